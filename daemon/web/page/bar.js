// The bar that stays in view: exposure, gain, reference, loop, recording and aberration, each with its state.
import * as aberration from "./aberration.js";
import { gainOf } from "./bench.js";
import { chosen, inUnitText } from "./chosen.js";
import { brief, byId, element, grouped, setText, timeOfDay } from "./format.js";
import { JobButton } from "./jobs.js";
import { call } from "./link.js";
import { loopSettings } from "./loop.js";
import * as record from "./record.js";
import { clearFirst, takeText } from "./reference.js";
import { whyLoop, whyNot } from "./rights.js";
import { allow, button, field, NumberControl, reasonOf, Sender } from "./widgets.js";

const LOG = { toSlider: (value) => Math.log10(value), toValue: (slider) => 10 ** slider };
const REFERENCE_FRAMES = 100;
const TAKE = `Take ${REFERENCE_FRAMES} frames`;
const AUTO_TARGET = 0.7;
// Of opened_because in WIRE.md: a client opened the loop.
const OPENED_ON_REQUEST = "loop.open was called";
const LEAST_WAVES = 0.0005; // of a correction that is shown

let parts = null;
let bench = null; // the newest bench message
let status = null;

function buildCamera(parent) {
  const onReply = (reply) => {
    const atGain = /gain_(db|raw)$/.test(reply.error?.data?.field ?? "");
    exposure.error(atGain ? "" : reasonOf(reply));
    gain.error(atGain ? reasonOf(reply) : "");
    const applied = reply.result?.applied ?? bench.camera.settings;
    exposure.show(applied.exposure_us, true);
    gain.show(gainOf(applied).value, true);
  };
  const sender = new Sender((params) => call("camera.set", params), onReply);
  const exposure = new NumberControl(parent, "Exposure", "\u00b5s", { map: LOG, onChange: (value) => sender.send({ exposure_us: value }) });
  exposure.frame.box.classList.add("wide");
  const auto = new JobButton({ body: exposure.frame.body, error: (text) => exposure.error(text) }, "Auto", "camera.auto_exposure", {
    params: () => ({ target: AUTO_TARGET }),
    onDone: (result) => exposure.show(result.exposure_us, true),
  });
  auto.button.title = `Sets the exposure so that most spots reach up to ${100 * AUTO_TARGET} % of full scale`;
  const gain = new NumberControl(parent, "Gain", "dB", { onChange: (value) => sender.send({ [gainOf(bench.camera.settings).key]: value }) });
  return { exposure, auto, gain };
}

function buildReference(parent) {
  const frame = field(parent, "Reference");
  const take = new JobButton({ body: frame.body, error: frame.error }, TAKE, "reference.take", { params: () => ({ frames: REFERENCE_FRAMES }), before: clearFirst });
  take.button.id = frame.id;
  return { reference: frame, take };
}

/** A field whose one button does one of two things, by the state. */
function buildToggle(parent, title, onClick) {
  const frame = field(parent, title);
  const toggle = button(frame.body, "", async () => {
    toggle.disabled = true;
    frame.error(await onClick());
    toggle.disabled = false;
    update();
  });
  toggle.id = frame.id;
  toggle.setAttribute("aria-describedby", frame.describedBy);
  return { ...frame, toggle };
}

/** The RMS of the correction that an open loop leaves, waves; 0 if none is worth showing. */
const leftCorrection = ({ closed, correction_rms_waves: rms }) => (!closed && rms >= LEAST_WAVES ? rms : 0);

/** Clears what the field shows; resolves to the reason for an error, empty on success. */
async function clearShown() {
  const corrected = leftCorrection(bench.loop) > 0;
  const error = aberration.isIntroduced() || !corrected ? reasonOf(await aberration.clear()) : "";
  return error || (corrected ? reasonOf(await call("correction.clear")) : "");
}

/** Shows the aberration, and the correction of the open loop, which looks like one. */
function showAberration({ aberration: { modes }, loop }) {
  const introduced = Math.hypot(...modes.map((mode) => mode.waves));
  const correction = leftCorrection(loop);
  parts.clear.help(introduced ? `${inUnitText(introduced)} ${chosen.unit}` : "none");
  setText(parts.correction, correction ? `correction ${inUnitText(correction)} ${chosen.unit}` : "");
  const both = introduced ? "the aberration and the correction" : "the correction";
  parts.clear.toggle.dataset.hint = `Clears ${correction ? both : "the aberration"}`;
}

export function build() {
  const parent = document.querySelector("#bar .fields");
  const loop = async () => reasonOf(await (bench.loop.closed ? call("loop.open") : call("loop.close", loopSettings())));
  parts = {
    ...buildCamera(parent),
    ...buildReference(parent),
    loop: buildToggle(parent, "Loop", loop),
    record: buildToggle(parent, "Recording", record.toggle),
    clear: buildToggle(parent, "Aberration", clearShown),
  };
  setText(parts.clear.toggle, "Clear");
  parts.correction = element("span", "sub");
  parts.clear.body.append(parts.correction);
  byId("more").addEventListener("click", () => {
    const open = byId("bar").classList.toggle("open");
    byId("more").setAttribute("aria-expanded", String(open));
    setText(byId("more"), open ? "Less" : "More");
  });
  update();
}

function showCamera({ settings, limits }) {
  const { key, unit, step } = gainOf(settings);
  parts.gain.unit(unit);
  if (limits) {
    const { exposure_us: e } = limits;
    const g = limits[key] ?? limits.gain_db ?? limits.gain_raw;
    // The exposure cannot exceed the frame period.
    const longest = Math.min(e.max, 1e6 / settings.frame_rate_hz);
    parts.exposure.limits(e.min, longest);
    parts.exposure.reach(e.min, longest);
    parts.gain.limits(g.min, g.max);
    parts.gain.reach(g.min, g.max, step);
    const why = longest < e.max ? `, at ${brief(settings.frame_rate_hz)} frames/s` : "";
    parts.exposure.help(`${brief(e.min)} to ${grouped(longest)} \u00b5s${why}`);
    parts.gain.help(`${brief(g.min)} to ${brief(g.max)} ${unit}`);
  }
  parts.exposure.show(settings.exposure_us);
  parts.gain.show(gainOf(settings).value);
}

function referenceText({ taken, source, t_taken_ns: at, stale }) {
  if (!taken) return source === "model" ? "from the model" : "none";
  return `${stale?.length ? "stale, " : ""}${timeOfDay(at)}`;
}

function loopText(loop) {
  const residual = loop.residual_rms_waves === null ? "" : `, ${inUnitText(loop.residual_rms_waves)} ${chosen.unit}`;
  if (loop.closed) return `${loop.paused ? "paused" : "closed"}${residual}`;
  return loop.opened_because && loop.opened_because !== OPENED_ON_REQUEST ? `open: ${loop.opened_because}` : "open";
}

/** Why a control is disabled though the page may control: what the bench lacks for it. */
function lacks() {
  const connected = bench?.camera.limits && (!status || status.camera.connected); // its limits are null until it was connected once
  const camera = connected ? "" : "No camera.";
  const job = status?.state === "job_running" ? "A job is running." : "";
  const reference = !status || status.sensor.referenced ? "" : "Needs a reference.";
  const closed = whyLoop();
  const auto = closed && "Auto needs an open loop."; // the field's other controls work
  return { camera: camera || job, auto: camera || job || auto, open: camera || job || closed, job, loop: closed ? "" : camera || job || reference, none: "" };
}

/** Enables every control, or disables it and says why. */
function update() {
  if (!parts) return;
  const common = whyNot();
  setText(byId("bar-why"), common);
  const lack = lacks();
  const rows = [
    [parts.exposure.inputs, parts.exposure.frame, lack.camera],
    [[parts.auto.button], parts.exposure.frame, lack.auto],
    [parts.gain.inputs, parts.gain.frame, lack.camera],
    [[parts.take.button], parts.reference, lack.open],
    [[parts.loop.toggle], parts.loop, lack.loop],
    [[parts.record.toggle], parts.record, lack.none],
    [[parts.clear.toggle], parts.clear, lack.job],
  ];
  for (const [controls, frame, reason] of rows) {
    allow(controls, common || reason, common ? byId("bar-why") : frame.why);
    setText(frame.why, common ? "" : reason);
  }
}

export const takeRight = update;

export function takeBench(message) {
  bench = message;
  const { camera, reference, loop } = message;
  showCamera(camera);
  parts.reference.help(referenceText(reference));
  setText(parts.take.button, takeText(TAKE));
  showAberration(message);
  parts.loop.help(loopText(loop));
  parts.loop.box.classList.toggle("closed", loop.closed);
  setText(parts.loop.toggle, loop.closed ? "Open" : "Close");
  update();
}

export function takeStatus(message) {
  status = message;
  const { record: now } = message;
  const on = now.state === "recording";
  parts.record.help(on ? `${grouped(now.duration_s)} s` : "off");
  parts.record.box.classList.toggle("recording", on);
  setText(parts.record.toggle, on ? "Stop" : "Record");
  update();
}
