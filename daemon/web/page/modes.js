// The coefficients of the shown frame: one signed bar per mode with its standard error, terms that follow from them, and their history.
import { begin, font } from "./canvas.js";
import { choose, chosen, inUnit, inUnitText, onChosen, signedText, wavelengthNm } from "./chosen.js";
import { colourOf, coloursOf, css, themed } from "./colour.js";
import * as derived from "./derived.js";
import { isFrozen, shown } from "./frame.js";
import { byId, element, setText, signed, tick, timeOfDay } from "./format.js";
import { bins, now, span, spanText } from "./history.js";
import { drawBars } from "./modes_draw.js";
import { copy, csvText, pngOf, save, saveCsv } from "./save.js";
import { AutoScale } from "./scale.js";
import { actionButton, freezeButton, select, toolbar } from "./tools.js";
import { NORMS, UNITS } from "./units.js";
import { INDICES, orders } from "./zernike.js";

let names = new Map(); // j -> name
let rows = []; // {j, at (in the message), value, bar, whisker}, in the chosen order
const scale = new AutoScale([1, 2, 5, 10]);
let built = ""; // what the rows were built for

/** Builds toolbar and tables; `onChange` is called when the panel must be drawn again. */
export function build(onChange) {
  const { keys, options } = toolbar(byId("modes"));
  freezeButton(keys);
  actionButton(keys, "Copy", "Copy the coefficients to the clipboard, as a table", async () => shown() !== null && copy(csvText({}, table()).replaceAll(",", "\t")));
  actionButton(keys, "CSV", "Save the coefficients", () => shown() !== null && saveCsv("coefficients", shown().t_arrival_ns, facts(), table()));
  actionButton(keys, "PNG", "Save a picture of the bars", async () => shown() !== null && save("coefficients", shown().t_arrival_ns, "png", await png()));
  const choice = (title, name, list) => select(options, title, chosen[name], list, (value) => choose(name, value));
  choice("Unit, whole page", "unit", Object.keys(UNITS).map((unit) => [unit, unit]));
  choice("Normalisation", "norm", Object.entries(NORMS).map(([name, { title }]) => [name, title]));
  choice("Index", "index", Object.entries(INDICES).map(([name, { title }]) => [name, title]));
  derived.build(byId("modes"));
  onChosen(onChange);
}

export function takeNames(list) {
  names = new Map(list.map((mode) => [mode.j, mode.name]));
  built = "";
}

const numberOf = (j) => INDICES[chosen.index].of(j);
const nameOf = (j) => names.get(j) ?? "";

/** A coefficient or standard error of mode j, RMS-normalised waves, as the page shows it; in waves. */
const normed = (j, waves) => (waves === null || waves === undefined ? null : waves * NORMS[chosen.norm].factor(j));

function buildRows(j) {
  const body = byId("mode-table").tBodies[0];
  body.replaceChildren();
  const order = j.map((mode, at) => ({ j: mode, at })).sort((a, b) => numberOf(a.j) - numberOf(b.j));
  rows = order.map(({ j: mode, at }) => {
    const line = body.insertRow();
    const name = element("th");
    name.scope = "row";
    name.append(element("span", "j", `Z${numberOf(mode)}`), element("span", "name", nameOf(mode)));
    name.title = `Z${numberOf(mode)} ${nameOf(mode)}`;
    const value = element("td", "number");
    const cell = element("td", "bar");
    const [bar, whisker] = [element("i"), element("b")];
    cell.append(bar, whisker);
    line.append(name, value, cell);
    return { j: mode, at, value, bar, whisker };
  });
}

/** What the message says about its errors: the standard error of all modes together, if it was measured from all pixels. */
function errorOf({ valid, sigma }) {
  if (!valid || !sigma) return "";
  if (sigma.includes(null)) return ", from positions";
  return `, standard error ${inUnitText(Math.hypot(...sigma))} ${chosen.unit} RMS`;
}

/** Places the whisker: one standard error to both sides of the bar's end, in parts of the axis. */
function showWhisker({ whisker }, waves, error, limit) {
  whisker.hidden = error === null || waves === null;
  if (whisker.hidden) return;
  // In steps, so that noise alone causes no new layout.
  const place = `${(50 * (1 + (waves - error) / limit)).toFixed(1)}% ${((100 * error) / limit).toFixed(1)}%`;
  if (whisker.dataset.place === place) return;
  whisker.dataset.place = place;
  [whisker.style.left, whisker.style.width] = place.split(" ");
}

export function showFrame() {
  const message = shown();
  if (!message) return;
  const key = `${chosen.index} ${message.j}`;
  if (built !== key) buildRows(message.j);
  built = key;
  const values = message.coefficients.map((waves, i) => normed(message.j[i], waves));
  const most = Math.max(...values.map((waves) => Math.abs(waves ?? 0)));
  const limit = message.valid ? scale.take(most) : scale.waves || scale.take(0);
  for (const row of rows) {
    const waves = values[row.at];
    const error = normed(row.j, message.sigma?.[row.at]);
    setText(row.value, signedText(waves));
    row.value.title = error === null ? "" : `standard error ${inUnitText(error, 1)} ${chosen.unit}`;
    row.bar.style.transform = `scaleX(${(waves ?? 0) / limit})`;
    row.bar.dataset.sign = (waves ?? 0) < 0 ? "minus" : "plus";
    showWhisker(row, waves, error, limit);
  }
  setText(byId("mode-table").tHead.rows[0].cells[1], chosen.unit);
  const held = isFrozen() ? `frozen at ${timeOfDay(message.t_arrival_ns)}, ` : "";
  setText(byId("modes-basis"), `${held}${INDICES[chosen.index].title}, ${NORMS[chosen.norm].title}-normalised`);
  setText(byId("modes-error"), errorOf(message));
  setText(byId("axis-low"), tick(-inUnit(limit)));
  setText(byId("axis-high"), `+${tick(inUnit(limit))}`);
  derived.show(message);
}

/** The coefficients as rows for export. */
function table() {
  const { coefficients, sigma } = shown();
  const head = [`index_${chosen.index}`, "n", "m", "name", `coefficient_${chosen.unit}`, `standard_error_${chosen.unit}`];
  return [head, ...rows.map(({ j, at }) => [numberOf(j), orders(j).n, orders(j).m, nameOf(j), inUnit(normed(j, coefficients[at])), inUnit(normed(j, sigma?.[at]))])];
}

const facts = () => ({ frame_id: shown().frame_id, time: new Date(shown().t_arrival_ns / 1e6).toISOString(), wavelength_nm: wavelengthNm(), normalisation: NORMS[chosen.norm].title, orientation: shown().orientation, ...derived.facts(shown()) });

function png() {
  const { coefficients, sigma, t_arrival_ns: at, frame_id: frame } = shown();
  const bars = rows.map((row) => {
    const value = inUnit(normed(row.j, coefficients[row.at])) ?? 0;
    return { label: `Z${numberOf(row.j)} ${nameOf(row.j)}`, value, text: signed(value, UNITS[chosen.unit].digits), error: inUnit(normed(row.j, sigma?.[row.at])) };
  });
  const canvas = drawBars(bars, inUnit(scale.waves), chosen.unit);
  return pngOf([{ title: `Coefficients, ${new Date(at / 1e6).toISOString()}, frame ${frame}`, canvas }], [byId("modes").querySelector(".sub").textContent]);
}

/** Draws the history: one row per mode, aligned with the bars; time runs to the right, now is at the edge. */
export function draw() {
  const canvas = byId("strip-canvas");
  canvas.style.height = `${byId("mode-table").tBodies[0].offsetHeight}px`;
  const { context, width, height } = begin(canvas);
  if (rows.length === 0 || width === 0) return;
  setText(byId("strip-title"), `last ${spanText()}`);
  canvas.setAttribute("aria-label", `Coefficients over the last ${spanText()}`);
  const beside = getComputedStyle(canvas).getPropertyValue("--beside").trim() === "1";
  const text = font(0.7);
  const left = beside ? 0 : 2.6 * text.px;
  const rowHeight = height / rows.length;
  const end = now();
  const colours = coloursOf();
  const xOf = (ns) => width - ((end - ns) / 1e9 / span()) * (width - left);
  for (const bin of bins()) {
    if (!bin.coefficients || bin.j.length !== rows.length) continue;
    const right = Math.ceil(xOf(bin.t_ns));
    const from = Math.floor(Math.max(left, right - (bin.span_s / span()) * (width - left)));
    rows.forEach(({ j, at }, i) => {
      context.fillStyle = css(colourOf(normed(j, bin.coefficients[at]), scale.waves, colours));
      context.fillRect(from, i * rowHeight + 1, right - from, rowHeight - 2);
    });
  }
  if (beside) return;
  context.font = text.css;
  context.fillStyle = themed("--quiet");
  context.textBaseline = "middle";
  rows.forEach((row, i) => context.fillText(`Z${numberOf(row.j)}`, 0, (i + 0.5) * rowHeight));
}
