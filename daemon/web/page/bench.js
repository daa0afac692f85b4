// Sensor and loop: charge, tracker, frame rate, reference and correction, for users with control rights; else their values.
import { chosen, inUnitText } from "./chosen.js";
import { brief, byId, element, grouped, NONE, plural, setText, timeOfDay } from "./format.js";
import { call } from "./link.js";
import { whyLoop } from "./rights.js";
import { allowIn, button, ChoiceControl, field, NumberControl, reasonOf, Sender } from "./widgets.js";

let controls = null;
const LOG = { toSlider: (value) => Math.log10(value), toValue: (slider) => 10 ** slider };

/** The gain in the camera's unit: dB or raw steps. */
export function gainOf(settings) {
  return settings?.gain_db === null
    ? { key: "gain_raw", value: settings.gain_raw, unit: "(raw)", step: 1 }
    : { key: "gain_db", value: settings?.gain_db, unit: "dB", step: 0.1 };
}

function buildRate(parent) {
  const sender = new Sender((params) => call("camera.set", params), (reply) => {
    rate.error(reasonOf(reply));
    if (reply.result) rate.show(reply.result.applied.frame_rate_hz, true);
  });
  const rate = new NumberControl(parent, "Frame rate", "Hz", { map: LOG, onChange: (value) => sender.send({ frame_rate_hz: value }) });
  return { rate };
}

function buildSensor(parent) {
  const charge = new ChoiceControl(parent, "Charge", (value) => set("charge", Number(value), charge));
  const tracker = new ChoiceControl(parent, "Tracker", (value) => set("tracker", value, tracker));
  async function set(key, value, control) {
    control.error(reasonOf(await call("sensor.set", { [key]: value })));
  }
  return { charge, tracker };
}

function buildReference(parent) {
  const frame = field(parent, "Reference");
  const clear = button(frame.body, "Clear reference", async () => frame.error(reasonOf(await call("reference.clear"))));
  clear.id = frame.id;
  return { reference: frame, clearReference: clear };
}

function buildLoop(parent) {
  const frame = field(parent, "Correction");
  const clear = button(frame.body, "Clear correction", async () => frame.error(reasonOf(await call("correction.clear"))));
  clear.id = frame.id;
  return { loop: frame, clearCorrection: clear };
}

export function build(mayControl) {
  const parent = document.querySelector("#bench .controls");
  parent.replaceChildren();
  parent.hidden = true; // until their limits are known
  controls = null;
  if (!mayControl) {
    parent.append(Object.assign(element("dl", "facts"), { id: "bench-facts" }));
    return;
  }
  controls = { ...buildSensor(parent), ...buildRate(parent), ...buildReference(parent), ...buildLoop(parent) };
}

function referenceText(reference) {
  if (!reference.taken) return reference.source === "model" ? "from the model" : "none";
  const stale = reference.stale?.length ? `; changed since: ${reference.stale.map((s) => s.field).join(", ")}` : "";
  const introduced = reference.introduced_rms_waves ? `, contains an introduced aberration of ${inUnitText(reference.introduced_rms_waves)} ${chosen.unit} RMS` : "";
  return `${plural(reference.frames, "frame", "frames")}, ${timeOfDay(reference.t_taken_ns)}${introduced}${stale}`;
}

function loopText(loop) {
  const residual = loop.residual_rms_waves === null ? "" : `, residual ${inUnitText(loop.residual_rms_waves)} ${chosen.unit} RMS`;
  if (loop.closed) return `${loop.paused ? "paused" : "closed"}, ${grouped(loop.steps)} steps${residual}`;
  const correction = `correction ${inUnitText(loop.correction_rms_waves)} ${chosen.unit} RMS`;
  return loop.opened_because ? `open since ${timeOfDay(loop.t_opened_ns)}: ${loop.opened_because}; ${correction}` : `open, ${correction}`;
}

function showControls({ camera, sensor, limits, reference, loop }) {
  const range = camera.limits?.frame_rate_hz;
  if (range) {
    controls.rate.limits(range.min, range.max);
    controls.rate.reach(range.min, range.max);
    controls.rate.help(`${brief(range.min)} to ${brief(range.max)} frames/s`);
  }
  controls.rate.show(camera.settings.frame_rate_hz);
  const { min, max } = limits.charge;
  controls.charge.show(sensor.charge, Array.from({ length: max - min + 1 }, (_, i) => min + i));
  controls.tracker.show(sensor.tracker, limits.trackers);
  controls.reference.help(`Active: ${referenceText(reference)}`);
  controls.loop.help(`Loop ${loopText(loop)}`);
  for (const choice of [controls.charge, controls.tracker]) choice.allow(whyLoop());
  allowIn(controls.reference, [controls.clearReference], whyLoop());
  allowIn(controls.loop, [controls.clearCorrection], whyLoop());
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
  const { camera, sensor, reference, loop } = message;
  const info = camera.info ? `${camera.info.vendor} ${camera.info.model}` : "no camera";
  setText(byId("bench-sub"), `${info}, ${sensor.subapertures} subapertures`);
  document.querySelector("#bench .controls").hidden = false;
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
