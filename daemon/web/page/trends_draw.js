// Drawing of one chart over time.
import { begin, font, sizeOf } from "./canvas.js";
import { themed } from "./colour.js";
import { roundUp, tick } from "./format.js";
import { bins, isGap, minutesAgo, now, span } from "./history.js";

/** The plotting area of a chart's canvas, CSS pixels. */
export function boxOf(canvas) {
  const text = font(0.72);
  const [width, height] = sizeOf(canvas);
  return { left: 3.9 * text.px, right: width - 1, top: 0.6 * text.px, bottom: height - 1.7 * text.px };
}

/** Runs of points without gaps: [{x, y}], y null where there is no value. */
function runsOf(points) {
  const runs = [];
  let run = null;
  for (const { x, y, first } of points) {
    if (first || y === null) run = null;
    if (y === null) continue;
    if (!run) runs.push((run = []));
    run.push({ x, y });
  }
  return runs;
}

function line(context, points, colour, width, steps) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.lineJoin = "round";
  context.beginPath();
  for (const run of runsOf(points)) {
    run.forEach(({ x, y }, i) => {
      if (i === 0) context.moveTo(x, y);
      else {
        if (steps) context.lineTo(x, run[i - 1].y);
        context.lineTo(x, y);
      }
    });
  }
  context.stroke();
}

/** Fills the band between two curves. */
function band(context, lower, upper, colour) {
  context.fillStyle = colour;
  const uppers = runsOf(upper);
  runsOf(lower).forEach((run, i) => {
    const back = uppers[i] ?? [];
    context.beginPath();
    [...run, ...[...back].reverse()].forEach(({ x, y }) => context.lineTo(x, y));
    context.fill();
  });
}

/** The axis' tick values, and a function from value to height, 0 to 1. */
function axisOf(view, shown) {
  let most = view.least?.() ?? 0;
  for (const value of shown) most = Math.max(most, value);
  if (view.decades) {
    const limit = Math.max(1, Math.ceil(Math.log10(most / view.decades)));
    const ticks = Array.from({ length: limit + 1 }, (_, i) => view.decades * 10 ** i);
    return { ticks, part: (value) => Math.max(0, Math.log10(value / view.decades) / limit) };
  }
  const limit = view.most ?? roundUp(most);
  return { ticks: [0, 0.5 * limit, limit], part: (value) => value / limit };
}

/** Draws the horizontal grid lines with labels, and the time axis. */
function drawAxes(context, box, axis) {
  const text = font(0.72);
  context.font = text.css;
  context.lineWidth = 1;
  context.textBaseline = "middle";
  context.textAlign = "right";
  for (const mark of axis.ticks) {
    const y = Math.round(box.bottom - axis.part(mark) * (box.bottom - box.top)) + 0.5;
    context.strokeStyle = themed("--line");
    context.beginPath();
    context.moveTo(box.left, y);
    context.lineTo(box.right, y);
    context.stroke();
    context.fillStyle = themed("--quiet");
    context.fillText(tick(mark), box.left - 5, y);
  }
  context.textBaseline = "top";
  for (let third = 0; third <= 3; ++third) {
    const x = box.right - (third / 3) * (box.right - box.left);
    context.textAlign = third === 0 ? "right" : third === 3 ? "left" : "center";
    context.fillText(minutesAgo(third / 3), x, box.bottom + 4);
  }
}

function drawMarks(context, box, xOf, { cursor, events }) {
  const vertical = (ns, colour, width) => {
    const x = xOf(ns);
    if (x <= box.left) return;
    context.fillStyle = themed(colour);
    context.fillRect(x - width / 2, box.top, width, box.bottom - box.top);
  };
  context.globalAlpha = 0.55;
  for (const { t_ns: at, severity } of events) vertical(at, severity === "info" ? "--rule" : severity === "warning" ? "--warning" : "--bad", 1);
  context.globalAlpha = 1;
  if (cursor !== null) vertical(cursor, "--ink", 1.5);
}

function drawLimit(context, box, y) {
  context.strokeStyle = themed("--bad");
  context.lineWidth = 1.5;
  context.setLineDash([6, 4]);
  context.beginPath();
  context.moveTo(box.left, y);
  context.lineTo(box.right, y);
  context.stroke();
  context.setLineDash([]);
}

/** Draws a chart. `view`: as in trends.js; `at`: {cursor: ns or null, events}. */
export function drawChart(view, at, canvas = view.canvas) {
  const { context } = begin(canvas);
  const box = boxOf(canvas);
  const text = font(0.72);
  const limit = view.limit?.() || null;
  const list = bins();
  const shown = [...list.flatMap((bin) => [view.of(bin), view.peak?.(bin)]), limit].filter((value) => value !== null && value !== undefined);
  const axis = axisOf(view, shown);
  drawAxes(context, box, axis);
  const end = now();
  const xOf = (ns) => Math.max(box.left, box.right - ((end - ns) / 1e9 / span()) * (box.right - box.left));
  drawMarks(context, box, xOf, at);
  const yOf = (value) => (value === null ? null : box.bottom - axis.part(value) * (box.bottom - box.top));
  const points = (of) => list.map((bin, i) => ({ x: xOf(bin.t_ns), y: yOf(of(bin)), first: isGap(list[i - 1], bin) }));
  if (view.low) band(context, points(view.low), points(view.peak), themed("--band"));
  if (view.peak) line(context, points(view.peak), themed("--peak"), 0.11 * text.px, false);
  line(context, points(view.of), themed("--accent"), 0.16 * text.px, view.steps);
  if (limit) drawLimit(context, box, yOf(limit));
}
