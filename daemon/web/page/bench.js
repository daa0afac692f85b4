// Exposure, gain, charge, tracker, reference and loop: current values, and controls for users with control rights.
import { brief, byId, element, grouped, NONE, setText, timeOfDay } from "./format.js";
import { call } from "./link.js";
import { button, ChoiceControl, field, NumberControl, reasonOf, Sender } from "./widgets.js";

let controls = null;
let view = null; // the newest bench message
const REFERENCE_FRAMES = 100;
const LOG = { toSlider: (value) => Math.log10(value), toValue: (slider) => 10 ** slider };

/** The gain in the camera's unit: dB or raw steps. */
function gainOf(settings) {
  return settings?.gain_db === null
    ? { key: "gain_raw", value: settings.gain_raw, unit: "(raw)", step: 1 }
    : { key: "gain_db", value: settings?.gain_db, unit: "dB", step: 0.1 };
}

function buildCamera(parent) {
  const errors = (reply) => {
    const atGain = /gain_(db|raw)$/.test(reply.error?.data?.field ?? "");
    exposure.error(atGain ? "" : reasonOf(reply));
    gain.error(atGain ? reasonOf(reply) : "");
    const applied = reply.result?.applied ?? view.camera.settings;
    exposure.show(applied.exposure_us, true);
    gain.show(gainOf(applied).value, true);
  };
  const sender = new Sender("camera.set", errors);
  const exposure = new NumberControl(parent, "Exposure", "\u00b5s", { map: LOG, onChange: (value) => sender.send({ exposure_us: value }) });
  const gain = new NumberControl(parent, "Gain", gainOf(view?.camera.settings).unit, { onChange: (value) => sender.send({ [gainOf(view.camera.settings).key]: value }) });
  return { exposure, gain };
}

function buildSensor(parent) {
  const charge = new ChoiceControl(parent, "Charge", (value) => set("charge", Number(value), charge));
  const tracker = new ChoiceControl(parent, "Tracker", (value) => set("tracker", value, tracker));
  async function set(key, value, control) {
    control.error(reasonOf(await call("sensor.set", { [key]: value })));
  }
  return { charge, tracker };
}

async function follow(job, bar) {
  for (;;) {
    const { result } = await call("job.get", { job });
    if (!result || result.state !== "running") return result;
    bar.value = result.progress;
    await new Promise((done) => setTimeout(done, 100));
  }
}

function buildReference(parent) {
  const frame = field(parent, "Reference");
  const bar = element("progress");
  bar.id = frame.id;
  bar.max = 1;
  bar.hidden = true;
  async function takeReference() {
    take.disabled = retake.disabled = true;
    bar.hidden = false;
    bar.value = 0;
    const reply = await call("reference.take", { frames: REFERENCE_FRAMES });
    frame.error(reasonOf(reply));
    const ended = reply.result ? await follow(reply.result.job, bar) : null;
    if (ended && ended.state !== "done") frame.error(ended.error?.data?.reason || ended.error?.message || ended.state);
    bar.hidden = true;
    take.disabled = retake.disabled = false;
  }
  const take = button(frame.body, `Take ${REFERENCE_FRAMES} frames`, takeReference);
  const retake = button(frame.body, "Clear aberration and take", async () => {
    const reply = await call("aberration.clear");
    frame.error(reasonOf(reply));
    if (reply.result) await takeReference();
  });
  retake.hidden = true;
  button(frame.body, "Clear", async () => frame.error(reasonOf(await call("reference.clear"))));
  frame.body.append(bar);
  return { reference: frame, retake };
}

function buildLoop(parent) {
  const frame = field(parent, "Loop gain");
  const gain = element("input");
  gain.type = "number";
  gain.id = frame.id;
  gain.value = "0.3";
  gain.step = "0.05";
  gain.setAttribute("aria-describedby", frame.describedBy);
  frame.body.append(gain);
  button(frame.body, "Close", async () => frame.error(reasonOf(await call("loop.close", { gain: Number(gain.value) }))));
  button(frame.body, "Open", async () => frame.error(reasonOf(await call("loop.open"))));
  button(frame.body, "Clear correction", async () => frame.error(reasonOf(await call("correction.clear"))));
  return { loop: frame };
}

export function build(mayControl) {
  const parent = document.querySelector("#bench .controls");
  parent.replaceChildren();
  controls = null;
  if (!mayControl) {
    parent.append(Object.assign(element("dl", "facts"), { id: "bench-facts" }));
    return;
  }
  controls = { ...buildCamera(parent), ...buildSensor(parent), ...buildReference(parent), ...buildLoop(parent) };
}

function referenceText(reference) {
  if (!reference.taken) return reference.source === "model" ? "from the model" : "none";
  const stale = reference.stale?.length ? `; changed since: ${reference.stale.map((s) => s.field).join(", ")}` : "";
  const introduced = reference.introduced_rms_waves ? `, contains an introduced aberration of ${brief(reference.introduced_rms_waves)} wave RMS` : "";
  return `${reference.frames} frames, ${timeOfDay(reference.t_taken_ns)}${introduced}${stale}`;
}

function loopText(loop) {
  const residual = loop.residual_rms_waves === null ? "" : `, residual ${brief(loop.residual_rms_waves)} wave RMS`;
  if (loop.closed) return `${loop.paused ? "paused" : "closed"}, ${grouped(loop.steps)} steps${residual}`;
  return loop.opened_because ? `open since ${timeOfDay(loop.t_opened_ns)}: ${loop.opened_because}` : `open, correction ${brief(loop.correction_rms_waves)} wave RMS`;
}

function showControls({ camera, sensor, limits, reference, aberration, loop }) {
  const { settings } = camera;
  if (camera.limits) {
    const { exposure_us: e } = camera.limits;
    const { key, unit, step } = gainOf(settings);
    const g = camera.limits[key] ?? camera.limits.gain_db ?? camera.limits.gain_raw;
    // The exposure cannot exceed the frame period.
    const longest = Math.min(e.max, 1e6 / settings.frame_rate_hz);
    controls.exposure.limits(e.min, longest);
    controls.exposure.reach(e.min, longest);
    controls.gain.limits(g.min, g.max);
    controls.gain.reach(g.min, g.max, step);
    const why = longest < e.max ? `, at ${brief(settings.frame_rate_hz)} frames/s` : "";
    controls.exposure.help(`${brief(e.min)} to ${grouped(longest)} \u00b5s${why}`);
    controls.gain.help(`${brief(g.min)} to ${brief(g.max)} ${unit}`);
  }
  controls.exposure.show(settings.exposure_us);
  controls.gain.show(gainOf(settings).value);
  const { min, max } = limits.charge;
  controls.charge.show(sensor.charge, Array.from({ length: max - min + 1 }, (_, i) => min + i));
  controls.tracker.show(sensor.tracker, limits.trackers);
  controls.reference.help(`Active: ${referenceText(reference)}`);
  controls.retake.hidden = !reference.introduced_rms_waves && !aberration.modes.some((mode) => mode.waves !== 0);
  controls.loop.help(`${loopText(loop)}; gain ${limits.loop_gain.min} to ${limits.loop_gain.max}`);
}

/** Shows pairs of title and text; rebuilds the list only if its length changes. */
export function showFacts(list, facts) {
  if (list.children.length !== 2 * facts.length) {
    list.replaceChildren(...facts.flatMap(() => [element("dt"), element("dd")]));
  }
  facts.forEach(([title, text], i) => {
    setText(list.children[2 * i], title);
    setText(list.children[2 * i + 1], text);
  });
}

export function takeBench(message) {
  view = message;
  const { camera, sensor, reference, loop } = message;
  const info = camera.info ? `${camera.info.vendor} ${camera.info.model}` : "no camera";
  setText(byId("bench-sub"), `${info}, ${sensor.subapertures} subapertures`);
  if (controls) return showControls(message);
  const { settings } = camera;
  return showFacts(byId("bench-facts"), [
    ["Exposure", `${grouped(settings.exposure_us)} \u00b5s`],
    ["Gain", `${brief(gainOf(settings).value)} ${gainOf(settings).unit}`],
    ["Requested frame rate", `${brief(settings.frame_rate_hz)} frames/s`],
    ["Charge", String(sensor.charge)],
    ["Tracker", sensor.tracker],
    ["Active operator", sensor.operator_in_force ?? NONE],
    ["Reference", referenceText(reference)],
    ["Loop", loopText(loop)],
  ]);
}
