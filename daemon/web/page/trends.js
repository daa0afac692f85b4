// Charts of the last minutes or the last hour: one per quantity, all with the same time axis, cursor and events.
import { alarm, allowNotifications, setAlarm } from "./alarm.js";
import { detached } from "./canvas.js";
import { chosen, inUnit, onChosen, toWaves, wavelengthNm } from "./chosen.js";
import { brief, byId, element, fixed, NONE, setText, strehl, timeOfDay } from "./format.js";
import { bins, chooseSpan, newest, now, span, SPANS, spanText } from "./history.js";
import * as marks from "./marks.js";
import { copy, csvText, pngOf, save, saveCsv } from "./save.js";
import { actionButton, checkbox, positive, select, toolbar } from "./tools.js";
import { boxOf, drawChart } from "./trends_draw.js";
import { UNITS } from "./units.js";

const rate = (bin) => (bin.span_s > 0.2 ? bin.frames / bin.span_s : null);
const rmsUnit = () => chosen.unit;

// `most`: fixed end of the axis; else a round number above the data. `decades`: logarithmic axis that starts there.
const CHARTS = [
  { title: "RMS without tilts", unit: rmsUnit, of: (bin) => inUnit(bin.rms_waves), low: (bin) => inUnit(bin.rms_min_waves), peak: (bin) => inUnit(bin.rms_max_waves), text: (value) => fixed(value, UNITS[chosen.unit].digits), least: () => inUnit(0.01), limit: () => inUnit(alarm.limit) },
  { title: "Strehl ratio, estimated", of: (bin) => strehl(bin.rms_waves), most: 1 },
  { title: "Latency", unit: () => "\u00b5s", of: (bin) => bin.latency_median_us, peak: (bin) => bin.latency_max_us, least: () => 1000, decades: 10 },
  { title: "Frame rate", unit: () => "frames/s", of: rate, least: () => 1 },
  { title: "Lost spots", unit: (count) => (count === 1 ? "spot" : "spots"), of: (bin) => bin.lost_max, least: () => 2, steps: true },
  { title: "Lost frames", unit: (count) => (count === 1 ? "frame" : "frames"), of: (bin) => bin.gap, least: () => 2, steps: true },
];

const EXPORT_PX = [960, 160];
let views = [];
let cursor = null; // ns: the time that is pointed at
let slider = null;
let redraw = () => {};

function pointAt(ns) {
  cursor = ns;
  describe();
  redraw();
}

/** The value of a chart's curve, and its peak, each after the colour of its curve if there are two. */
function buildValue(parent, { peak }) {
  const line = element("span", "value");
  const [value, highest] = [element("span"), element("span")];
  line.append(...(peak ? [element("i", "of"), value, element("i", "peak"), highest] : [value]));
  parent.append(line);
  return { value, highest };
}

export function build(section, onChange) {
  redraw = onChange;
  buildTools(section);
  const charts = section.querySelector(".charts");
  charts.before(marks.build(pointAt));
  views = CHARTS.map((chart) => {
    const figure = element("figure");
    const head = element("figcaption");
    const title = element("span", "title");
    head.append(title);
    const values = buildValue(head, chart);
    const canvas = element("canvas");
    canvas.setAttribute("role", "img");
    figure.append(head, canvas);
    charts.append(figure);
    canvas.addEventListener("pointermove", (moved) => {
      const box = boxOf(canvas);
      const part = (box.right - moved.offsetX) / (box.right - box.left);
      if (part >= 0 && part <= 1) pointAt(now() - part * span() * 1e9);
    });
    canvas.addEventListener("pointerleave", () => pointAt(null));
    return { ...chart, canvas, titleText: title, ...values };
  });
  onChosen(() => {
    describe();
    redraw();
  });
}

function buildTools(section) {
  const { keys, options } = toolbar(section);
  select(keys, "", String(span()), SPANS.map(([seconds, text]) => [String(seconds), text]), (seconds) => {
    chooseSpan(Number(seconds));
    slider.min = String(-seconds);
    slider.step = String(seconds / 360);
    pointAt(null);
  }).setAttribute("aria-label", "Time span");
  actionButton(keys, "Copy", "Copy the history to the clipboard, as a table", async () => newest() !== undefined && copy(csvText({}, table()).replaceAll(",", "\t")));
  actionButton(keys, "CSV", "Save the history of this time span", () => newest() !== undefined && saveCsv("history", now(), { wavelength_nm: wavelengthNm(), coefficients: "waves, RMS-normalised, OSA/ANSI" }, table()));
  actionButton(keys, "PNG", "Save a picture of the charts", async () => newest() !== undefined && save("history", now(), "png", await png()));
  const limit = positive(options, "", (value) => {
    setAlarm("limit", value === null ? 0 : toWaves(value));
    redraw();
  });
  const showLimit = () => {
    limit.previousSibling.textContent = `Alarm above RMS, ${chosen.unit}`;
    limit.value = alarm.limit ? String(Number(inUnit(alarm.limit).toPrecision(4))) : "";
  };
  showLimit();
  onChosen(showLimit);
  checkbox(options, "sound", alarm.sound, (on) => setAlarm("sound", on));
  const notify = checkbox(options, "notification", alarm.notify, async (on) => {
    const allowed = on && (await allowNotifications());
    setAlarm("notify", allowed);
    notify.checked = allowed;
    notify.parentElement.title = on && !allowed ? "The browser does not allow notifications of this page" : "";
  });
  buildCursor(keys);
}

/** The cursor for the keyboard: a slider over the time span. */
function buildCursor(parent) {
  slider = element("input");
  Object.assign(slider, { type: "range", min: String(-span()), max: "0", step: "0.5", value: "0", className: "cursor" });
  slider.setAttribute("aria-label", "Cursor: time before now, s");
  slider.title = "Cursor: shows the values at a time; also by pointing at a chart";
  slider.addEventListener("input", () => pointAt(Number(slider.value) === 0 ? null : now() + Number(slider.value) * 1e9));
  parent.append(slider);
}

export function draw() {
  const at = { cursor, events: marks.marks() };
  for (const view of views) drawChart(view, at);
  marks.place();
}

/** The bin at the cursor, or the newest. */
function pointedBin() {
  if (cursor === null) return newest();
  const bin = bins().find((one) => one.t_ns >= cursor);
  return bin && bin.t_ns - bin.span_s * 1e9 - cursor < 0.5e9 ? bin : undefined;
}

/** Updates values and labels for screen readers; called twice per second. */
export function describe() {
  const bin = pointedBin();
  const where = cursor === null ? "now" : timeOfDay(cursor);
  setText(byId("trends-sub"), cursor === null ? `last ${spanText()}` : `at ${where}`);
  slider.setAttribute("aria-valuetext", where);
  if (document.activeElement !== slider) slider.value = String(cursor === null ? 0 : (cursor - now()) / 1e9);
  for (const view of views) {
    const value = bin ? view.of(bin) : null;
    const peak = bin && view.peak ? view.peak(bin) : null;
    const unit = view.unit ? ` ${view.unit(value)}` : "";
    const shown = view.text ?? brief;
    const text = value === null ? NONE : `${shown(value)}${unit}`;
    setText(view.titleText, view.unit && !view.title.endsWith(view.unit()) ? `${view.title}, ${view.unit()}` : view.title);
    setText(view.value, `${cursor === null ? "" : `${where} `}${text}${peak === null ? "" : ", "}`);
    setText(view.highest, peak === null ? "" : `peak ${shown(peak)}${unit}`);
    view.canvas.setAttribute("aria-label", `${view.title} over the last ${spanText()}, ${where} ${text}`);
  }
}

/** The bins of the time span as rows for export. */
function table() {
  const list = bins();
  const j = list.findLast((bin) => bin.j.length)?.j ?? [];
  const unit = chosen.unit;
  const head = ["end", "span_s", "frames", "valid", "lost_frames", "lost_spots_max", `rms_mean_${unit}`, `rms_min_${unit}`, `rms_max_${unit}`, "latency_median_us", "latency_max_us", ...j.map((mode) => `z${mode}_wave`)];
  return [head, ...list.map((bin) => [
    new Date(bin.t_ns / 1e6).toISOString(), bin.span_s, bin.frames, bin.valid, bin.gap, bin.lost_max,
    inUnit(bin.rms_waves), inUnit(bin.rms_min_waves), inUnit(bin.rms_max_waves), bin.latency_median_us, bin.latency_max_us,
    ...j.map((mode) => bin.coefficients?.[bin.j.indexOf(mode)]),
  ])];
}

function png() {
  const at = { cursor, events: marks.marks() };
  const pictures = views.map((view) => {
    const canvas = detached(...EXPORT_PX);
    drawChart(view, at, canvas);
    return { title: view.titleText.textContent, canvas };
  });
  return pngOf(pictures, [`Until ${new Date(now() / 1e6).toISOString()}`, ...at.events.map((event) => `${timeOfDay(event.t_ns)} ${event.text}`)]);
}
