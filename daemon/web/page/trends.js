// Trend charts of the last minutes: one per quantity, all with the same time axis.
import { begin, font } from "./canvas.js";
import { themed } from "./colour.js";
import { bins, isGap, now, SPAN_S } from "./history.js";
import { brief, element, NONE, roundUp, setText, strehl, tick } from "./format.js";

const rate = (bin) => (bin.span_s > 0.2 ? bin.frames / bin.span_s : null);

// `most`: fixed end of the axis; else a round number above the data. `decades`: logarithmic axis that starts there.
const CHARTS = [
  { title: "RMS without tilts", unit: "wave", of: (bin) => bin.rms_waves, peak: (bin) => bin.rms_max_waves, least: 0.01 },
  { title: "Strehl ratio, estimated", unit: "", of: (bin) => strehl(bin.rms_waves), most: 1 },
  { title: "Latency", unit: "\u00b5s", of: (bin) => bin.latency_median_us, peak: (bin) => bin.latency_max_us, least: 1000, decades: 10 },
  { title: "Frame rate", unit: "frames/s", of: rate, least: 1 },
  { title: "Lost spots", unit: "spots", of: (bin) => bin.lost_max, least: 2, steps: true },
  { title: "Lost frames", unit: "frames", of: (bin) => bin.gap, least: 2, steps: true },
];

let views = [];

export function build(parent) {
  views = CHARTS.map((chart) => {
    const figure = element("figure");
    const head = element("figcaption");
    const title = element("span", "title", chart.unit && !chart.title.endsWith(chart.unit) ? `${chart.title}, ${chart.unit}` : chart.title);
    const value = element("span", "value");
    head.append(title, value);
    const canvas = element("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${chart.title} over the last three minutes`);
    figure.append(head, canvas);
    parent.append(figure);
    return { ...chart, canvas, value };
  });
}

function line(context, points, colour, width, steps) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.lineJoin = "round";
  context.beginPath();
  let last = null;
  for (const { x, y, first } of points) {
    if (first) last = null;
    if (y === null) {
      last = null;
      continue;
    }
    if (last === null) context.moveTo(x, y);
    else if (steps) {
      context.lineTo(x, last);
      context.lineTo(x, y);
    } else context.lineTo(x, y);
    last = y;
  }
  context.stroke();
}

/** The axis' tick values, and a function from value to height, 0 to 1. */
function axisOf(view, shown) {
  const most = Math.max(view.least ?? 0, ...shown);
  if (view.decades) {
    const limit = Math.max(1, Math.ceil(Math.log10(most / view.decades)));
    const marks = Array.from({ length: limit + 1 }, (_, i) => view.decades * 10 ** i);
    return { marks, part: (value) => Math.max(0, Math.log10(value / view.decades) / limit) };
  }
  const limit = view.most ?? roundUp(most);
  return { marks: [0, 0.5 * limit, limit], part: (value) => value / limit };
}

/** Draws the horizontal grid lines with labels, and the time axis. */
function drawAxes(context, box, axis, ink) {
  const text = font(0.72);
  context.font = text.css;
  context.lineWidth = 1;
  context.textBaseline = "middle";
  context.textAlign = "right";
  for (const mark of axis.marks) {
    const y = Math.round(box.bottom - axis.part(mark) * (box.bottom - box.top)) + 0.5;
    context.strokeStyle = ink.line;
    context.beginPath();
    context.moveTo(box.left, y);
    context.lineTo(box.right, y);
    context.stroke();
    context.fillStyle = ink.quiet;
    context.fillText(tick(mark), box.left - 5, y);
  }
  context.textBaseline = "top";
  for (let minute = 0; minute <= 3; ++minute) {
    const x = box.right - (minute / 3) * (box.right - box.left);
    context.textAlign = minute === 0 ? "right" : minute === 3 ? "left" : "center";
    context.fillText(minute === 0 ? "now" : `\u2212${minute} min`, x, box.bottom + 4);
  }
}

function drawChart(view, end, ink) {
  const { context, width, height } = begin(view.canvas);
  const text = font(0.72);
  const box = { left: 3.9 * text.px, right: width - 1, top: 0.6 * text.px, bottom: height - 1.7 * text.px };
  const shown = bins.flatMap((bin) => [view.of(bin), view.peak?.(bin)]).filter((v) => v !== null && v !== undefined);
  const axis = axisOf(view, shown);
  drawAxes(context, box, axis, ink);
  const xOf = (ns) => Math.max(box.left, box.right - ((end - ns) / 1e9 / SPAN_S) * (box.right - box.left));
  const points = (of) => bins.map((bin, i) => ({ x: xOf(bin.t_ns), y: of(bin) === null ? null : box.bottom - axis.part(of(bin)) * (box.bottom - box.top), first: isGap(bins[i - 1], bin) }));
  if (view.peak) line(context, points(view.peak), ink.faint, 0.11 * text.px, false);
  line(context, points(view.of), ink.accent, 0.16 * text.px, view.steps);
}

export function draw() {
  const ink = { line: themed("--line"), quiet: themed("--quiet"), accent: themed("--accent"), faint: themed("--peak") };
  for (const view of views) drawChart(view, now(), ink);
}

/** Updates values and labels for screen readers; called twice per second. */
export function describe() {
  const last = bins[bins.length - 1];
  for (const view of views) {
    const value = last ? view.of(last) : null;
    const peak = last && view.peak ? view.peak(last) : null;
    const unit = view.unit ? ` ${view.unit}` : "";
    const text = value === null ? NONE : `${brief(value)}${unit}`;
    setText(view.value, peak === null ? text : `${text}, peak ${brief(peak)}${unit}`);
    view.canvas.setAttribute("aria-label", `${view.title} over the last three minutes, now ${text}`);
  }
}
