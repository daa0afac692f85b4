// The loop's settings: law, gain, leak, limits and the modes to correct; and the identification of the disturbance.
import { brief, byId, dayAndTime, element, grouped, setText } from "./format.js";
import { jobField } from "./jobs.js";
import { call } from "./link.js";
import { NumberField, paramsOf } from "./params.js";
import { whyNot } from "./rights.js";
import { allow, button, ChoiceControl, field, reasonOf } from "./widgets.js";

const NUMBERS = [
  ["gain", "Gain"],
  ["leak", "Leak"],
  ["limit_waves", "Limit of each mode", "wave"],
  ["patience_s", "Open by itself after", "s"],
];
const LAWS = ["integrator", "optimised", "predictor"];

let parts = null; // for users with control rights
let bench = null;
let status = null;
let touched = false; // whether the user has changed a setting

function buildNumbers(parent) {
  const numbers = Object.fromEntries(NUMBERS.map(([key, title, unit]) => [key, new NumberField(parent, title, unit)]));
  for (const made of Object.values(numbers)) made.input.addEventListener("input", touch);
  return numbers;
}

function buildModes(parent) {
  const box = element("fieldset", "modes");
  const all = element("input");
  const label = element("label");
  const list = element("div", "list");
  all.type = "checkbox";
  all.checked = true;
  label.append(all, "all measured modes");
  all.addEventListener("change", () => {
    touch();
    showModes();
  });
  box.append(element("legend", "", "Modes to correct"), label, list);
  parent.append(box);
  return { all, list, shown: "" };
}

function touch() {
  touched = true;
  update();
}

export function build(mayControl) {
  const parent = document.querySelector("#loop .params");
  parent.replaceChildren();
  parts = null;
  if (!mayControl) return;
  const law = new ChoiceControl(parent, "Law", touch);
  const numbers = buildNumbers(parent);
  const modes = buildModes(parent);
  const identify = jobField(parent, "Disturbance, seconds", "Identify", "loop.identify", { params: () => ({ seconds: Number(seconds.value) || undefined }) });
  const seconds = element("input");
  seconds.type = "number";
  seconds.value = "30";
  seconds.setAttribute("aria-label", "Seconds to watch the disturbance");
  identify.button.before(seconds);
  const frame = field(parent, "Closed loop");
  const use = button(frame.body, "Use these settings", async () => frame.error(await reclose()));
  use.id = frame.id;
  use.title = "Opens the loop, which keeps its correction, and closes it with these settings";
  const made = { law, numbers, modes, identify, seconds, frame, use };
  parts = made;
  touched = false;
  law.show(LAWS[0], LAWS);
  paramsOf("loop.close").then((schemas) => {
    for (const [key] of NUMBERS) made.numbers[key].describe(schemas[key]);
  });
  paramsOf("loop.identify").then(({ seconds: range }) => range && Object.assign(seconds, { min: range.minimum, max: range.maximum, title: range.description }));
  if (bench) takeBench(bench);
}

/** Shows a checkbox for each mode, unless all are corrected. */
function showModes() {
  const { all, list } = parts.modes;
  list.hidden = all.checked;
  const names = bench.sensor.mode_names;
  const key = names.map(({ j }) => j).join();
  const chosen = bench.loop.modes;
  const isChosen = (j) => chosen === null || chosen.includes(j);
  if (!touched) for (const box of list.querySelectorAll("input")) box.checked = isChosen(Number(box.value));
  if (parts.modes.shown === key) return;
  parts.modes.shown = key;
  list.replaceChildren(
    ...names.map(({ j, name }) => {
      const label = element("label");
      const box = element("input");
      box.type = "checkbox";
      box.value = String(j);
      box.checked = isChosen(j);
      box.addEventListener("change", touch);
      label.append(box, `Z${j} ${name}`);
      return label;
    }),
  );
}

/** The settings with which the loop closes; nothing for what the daemon decides. */
export function loopSettings() {
  if (!parts || !bench) return {};
  const numbers = Object.entries(parts.numbers).map(([key, made]) => [key, made.value]);
  const settings = Object.fromEntries(numbers.filter(([, value]) => value !== undefined));
  settings.law = document.querySelector("#loop select").value;
  const boxes = [...parts.modes.list.querySelectorAll("input")];
  if (!parts.modes.all.checked) settings.modes = boxes.filter((box) => box.checked).map((box) => Number(box.value));
  return settings;
}

async function reclose() {
  const { law, gain, leak, limit_waves, patience_s, modes } = bench.loop;
  const opened = await call("loop.open", { keep: true });
  if (opened.error) return reasonOf(opened);
  const closed = await call("loop.close", loopSettings());
  if (!closed.error) return settle();
  const before = { law, gain, leak, limit_waves, patience_s, ...(modes && { modes }) };
  const back = await call("loop.close", before);
  return `${reasonOf(closed)} ${back.error ? "The loop is open." : "The loop goes on with its former settings."}`;
}

/** From now on the settings follow those of the daemon's loop again. */
function settle() {
  touched = false;
  return "";
}

function settingsText({ law, gain, leak, limit_waves: limit, modes }) {
  const which = modes === null ? "all modes" : `${modes.length} ${modes.length === 1 ? "mode" : "modes"} (${modes.map((j) => `Z${j}`).join(", ")})`;
  const strength = law === "integrator" ? `, gain ${brief(gain)}, leak ${brief(leak)}` : "";
  return `${law}${strength}, limit ${brief(limit)} wave, ${which}`;
}

function modelText(model) {
  if (!model) return "The laws optimised and predictor need an identification.";
  const rms = (law) => brief(Math.hypot(...model.modes.map((mode) => mode[law].residual_waves)));
  return `Identified ${dayAndTime(model.t_taken_ns)} over ${grouped(model.seconds)} s; expected residual: integrator ${rms("integrator")}, optimised ${rms("optimised")}, predictor ${rms("predictor")} wave RMS.`;
}

function update() {
  if (!parts || !bench) return;
  const { closed } = bench.loop;
  parts.frame.box.hidden = !closed;
  parts.frame.help("The loop keeps its correction meanwhile.");
  const common = whyNot();
  const running = status?.state === "job_running" && !parts.identify.isRunning ? "A job is running." : "";
  allow([parts.use], common, parts.frame.why);
  setText(parts.frame.why, common);
  parts.identify.disable(common || running);
}

export const takeRight = update;

export function takeStatus(message) {
  status = message;
  update();
}

export function takeBench(message) {
  bench = message;
  const { loop, identified } = message;
  setText(byId("loop-state"), `${loop.closed ? "closed with" : "last closed with"} ${settingsText(loop)}`);
  setText(byId("loop-model"), modelText(identified));
  if (!parts) return;
  if (!touched) {
    document.querySelector("#loop select").value = loop.law;
    for (const [key, made] of Object.entries(parts.numbers)) made.value = loop[key];
    parts.modes.all.checked = loop.modes === null;
  }
  showModes();
  update();
}
