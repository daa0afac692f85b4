// The coefficients: one signed bar per mode, and their history over the last minutes.
import { begin, font } from "./canvas.js";
import { colourOf, themed } from "./colour.js";
import { byId, element, fixed, roundUp, setText, signed, tick } from "./format.js";
import { bins, now, SPAN_S } from "./history.js";

let names = new Map(); // j -> name
let rows = []; // {j, value, bar}
let scale = { value: 0.1, at: 0 };

export function takeNames(list) {
  names = new Map(list.map((mode) => [mode.j, mode.name]));
  rows = [];
}

function build(j) {
  const body = byId("mode-table").tBodies[0];
  body.replaceChildren();
  rows = j.map((index) => {
    const line = body.insertRow();
    const name = element("th");
    name.scope = "row";
    name.append(element("span", "j", `Z${index}`), element("span", "name", names.get(index) ?? ""));
    name.title = `Z${index} ${names.get(index) ?? ""}`;
    const value = element("td", "number");
    const cell = element("td", "bar");
    const bar = element("i");
    cell.append(bar);
    line.append(name, value, cell);
    return { j: index, value, bar };
  });
}

function scaleFor(most, now) {
  const wanted = roundUp(Math.max(most, 0.01));
  if (wanted > scale.value || (wanted < scale.value && now - scale.at > 4000)) scale = { value: wanted, at: now };
  if (wanted === scale.value) scale.at = now;
  return scale.value;
}

/** What the message says about its errors: the standard error of all modes together, if it was measured from all pixels. */
function errorOf({ valid, sigma }) {
  if (!valid || !sigma) return "";
  if (sigma.includes(null)) return ", from positions";
  return `, standard error ${fixed(Math.hypot(...sigma), 4)} wave RMS`;
}

export function takeWavefront(message) {
  if (rows.length !== message.j.length || rows.some((row, i) => row.j !== message.j[i])) build(message.j);
  const most = Math.max(...message.coefficients.map((c) => Math.abs(c ?? 0)));
  const limit = message.valid ? scaleFor(most, performance.now()) : scale.value;
  rows.forEach((row, i) => {
    const waves = message.coefficients[i];
    setText(row.value, signed(waves, 4));
    row.value.title = message.sigma?.[i] == null ? "" : `standard error ${fixed(message.sigma[i], 5)} wave`;
    row.bar.style.transform = `scaleX(${(waves ?? 0) / limit})`;
    row.bar.dataset.sign = (waves ?? 0) < 0 ? "minus" : "plus";
  });
  setText(byId("modes-error"), errorOf(message));
  setText(byId("axis-low"), tick(-limit));
  setText(byId("axis-high"), `+${tick(limit)}`);
}

/** Draws the history: one row per mode, aligned with the bars; time runs to the right, now is at the edge. */
export function draw() {
  const canvas = byId("strip-canvas");
  canvas.style.height = `${byId("mode-table").tBodies[0].offsetHeight}px`;
  const { context, width, height } = begin(canvas);
  if (rows.length === 0 || width === 0) return;
  const beside = getComputedStyle(canvas).getPropertyValue("--beside").trim() === "1";
  const text = font(0.7);
  const left = beside ? 0 : 2.6 * text.px;
  const rowHeight = height / rows.length;
  const end = now();
  const xOf = (ns) => width - ((end - ns) / 1e9 / SPAN_S) * (width - left);
  for (const bin of bins) {
    if (!bin.coefficients || bin.j.length !== rows.length) continue;
    const right = Math.ceil(xOf(bin.t_ns));
    const from = Math.floor(Math.max(left, right - (bin.span_s / SPAN_S) * (width - left)));
    bin.coefficients.forEach((waves, i) => {
      const abgr = colourOf(waves, scale.value);
      context.fillStyle = `rgb(${abgr & 255} ${(abgr >> 8) & 255} ${(abgr >> 16) & 255})`;
      context.fillRect(from, i * rowHeight + 1, right - from, rowHeight - 2);
    });
  }
  if (beside) return;
  context.font = text.css;
  context.fillStyle = themed("--quiet");
  context.textBaseline = "middle";
  rows.forEach((row, i) => context.fillText(`Z${row.j}`, 0, (i + 0.5) * rowHeight));
}
