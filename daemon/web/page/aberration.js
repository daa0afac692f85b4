// Introduced aberration: one slider per mode. Modes that the sensor does not reconstruct keep their values.
import { brief, byId, element, setText, signed } from "./format.js";
import { call } from "./link.js";
import { NumberControl, reasonOf, Sender, showError } from "./widgets.js";
import { showFacts } from "./bench.js";

const RANGES = [0.1, 0.5, 1, 2, 5, 20];
let sliders = new Map(); // j -> NumberControl
let waves = new Map(); // j -> requested or active waves
let chosen = 0.5; // range of the sliders chosen by the user
let range = chosen; // current range: wider while a larger aberration is introduced
let shownModes = "";
let limits = { min: -1000, max: 1000 };

const show = (force) => sliders.forEach((slider, j) => slider.show(waves.get(j) ?? 0, force));

// While a DMD shows a sequence aberration.set is refused, and aberration.clear ends it.
const post = ({ modes }) => (modes.length ? call("aberration.set", { modes }) : call("aberration.clear"));
const sender = new Sender(post, (reply) => {
  showError(byId("aberration-error"), reasonOf(reply));
  const modes = reply.result?.modes ?? inForce;
  waves = new Map(modes.map((mode) => [mode.j, mode.waves]));
  if (reply.error) show(true);
});
let inForce = [];
let patterns = 0; // of a DMD's sequence

function request(j, value) {
  if (value === 0) waves.delete(j);
  else waves.set(j, value);
  sender.send({ modes: [...waves].map(([index, amount]) => ({ j: index, waves: amount })) });
}

function buildSliders(names) {
  const parent = document.querySelector("#aberration .sliders");
  parent.replaceChildren();
  sliders = new Map(
    names.map(({ j, name }) => {
      const slider = new NumberControl(parent, `Z${j} ${name}`, "wave", { onChange: (value) => request(j, value), help: false });
      slider.limits(limits.min, limits.max);
      slider.reach(-range, range, range / 100);
      return [j, slider];
    }),
  );
  show(true);
}

/** The user's range, or a wider one if the introduced aberration exceeds it. */
function neededRange() {
  const most = Math.max(0, ...inForce.map((mode) => Math.abs(mode.waves)));
  return most <= chosen ? chosen : (RANGES.find((wide) => wide >= most) ?? RANGES.at(-1));
}

function setRange(wide) {
  range = wide;
  byId("aberration-range").value = String(wide);
  sliders.forEach((slider) => slider.reach(-range, range, range / 100));
  show(true);
}

/** Builds the sliders; without control rights, a read-only list. */
export function build(mayControl) {
  const toolbar = document.querySelector("#aberration .toolbar");
  toolbar.replaceChildren();
  document.querySelector("#aberration .sliders").replaceChildren();
  sliders = new Map();
  shownModes = mayControl ? "" : null;
  if (!mayControl) {
    toolbar.append(Object.assign(element("dl", "facts"), { id: "aberration-facts" }));
    return;
  }
  const label = element("label", "", "Slider range \u00b1 ");
  const select = element("select");
  select.append(...RANGES.map((wide) => new Option(`${wide} wave`, String(wide), wide === range, wide === range)));
  select.id = "aberration-range";
  select.addEventListener("change", () => {
    chosen = Number(select.value);
    setRange(neededRange());
  });
  label.append(select);
  toolbar.append(label);
}

/** Whether an aberration is introduced. */
export const isIntroduced = () => patterns > 0 || inForce.some((mode) => mode.waves !== 0);

/** Removes the introduced aberration; resolves to the daemon's reply. */
export function clear() {
  waves.clear();
  show(true);
  return sender.send({ modes: [] });
}

export function takeBench({ aberration, sensor, limits: wire }) {
  inForce = aberration.modes;
  patterns = aberration.patterns.length;
  limits = wire.mode_waves;
  if (!sender.busy) waves = new Map(inForce.map((mode) => [mode.j, mode.waves]));
  const rms = Math.hypot(...inForce.filter((mode) => mode.j > 2).map((mode) => mode.waves));
  setText(byId("aberration-sub"), patterns ? `a sequence of ${patterns} patterns` : inForce.length ? `${brief(rms)} wave RMS without tilts` : "none");
  if (shownModes === null) {
    const facts = inForce.map((mode) => [`Z${mode.j} ${mode.name}`, `${signed(mode.waves, 4)} wave`]);
    return showFacts(byId("aberration-facts"), facts.length ? facts : [["Modes", "none"]]);
  }
  const key = sensor.modes_j.join();
  if (key !== shownModes) {
    shownModes = key;
    buildSliders(sensor.mode_names);
  }
  const hint = `Accepts ${limits.min} to ${limits.max} wave, as far as the SLM can show them.`;
  document.querySelector("#aberration .toolbar").title = hint;
  const needed = neededRange();
  const isEditing = [...sliders.values()].some((slider) => slider.isEditing);
  if (needed > range || (needed < range && !isEditing)) setRange(needed);
  return show(false);
}
