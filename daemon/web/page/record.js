// The running or last recording, with the name of the next one for users with control rights.
import { brief, byId, element, grouped, NONE, setText, sizeText } from "./format.js";
import { call } from "./link.js";
import { NumberField, paramsOf } from "./params.js";
import { field, reasonOf } from "./widgets.js";
import { showFacts } from "./bench.js";

const MIB = 2 ** 20;
let name = null; // the field of the file name, for users with control rights
let every = null; // the field of pictures_every, for users with control rights
let estimated = ""; // camera settings of the estimate
let isRecording = false;

/** Params of the next recording. */
const asked = () => ({ name: name.value.trim() || null, pictures_every: every.value });

/** Shows how large the next recording would become. */
async function estimate() {
  const target = every;
  const { result } = await call("record.estimate", { pictures_every: every.value });
  if (!result || target !== every) return;
  const { bytes_per_hour: size, hours_free: hours } = result;
  const room = hours === null ? "" : hours < 1 ? `; space for ${grouped(60 * hours)} min` : `; space for ${brief(hours)} h`;
  every.frame.help(`At most ${sizeText(size)} an hour${room}.`);
}

/** Estimates again when the camera has changed. */
export function takeBench({ camera: { settings } }) {
  const key = JSON.stringify([settings.frame_rate_hz, settings.roi, settings.pixel_format]);
  if (!every || key === estimated) return;
  estimated = key;
  estimate();
}

export function build(mayControl) {
  const parent = document.querySelector("#record .controls");
  parent.replaceChildren();
  name = every = null;
  estimated = "";
  if (!mayControl) return;
  const frame = field(parent, "Name of the next recording");
  name = element("input");
  name.type = "text";
  name.id = frame.id;
  name.placeholder = "run- and the time";
  name.autocomplete = "off";
  name.setAttribute("aria-describedby", frame.describedBy);
  frame.body.append(name);
  frame.help("Every frame with its measurement and the active settings. Record and Stop are in the bar.");
  every = new NumberField(parent, "Images of every n-th frame, 0: none");
  paramsOf("record.estimate").then(({ pictures_every: schema }) => schema && every?.describe(schema));
  every.input.addEventListener("input", estimate);
}

/** Starts a recording under the name of the field, or stops the one that runs; resolves to the error, empty if none. */
export async function toggle() {
  const stops = isRecording; // the status may change it meanwhile
  const reply = stops ? await call("record.stop") : await call("record.start", asked());
  if (stops && reply.result) name.value = "";
  if (reply.result) takeStatus({ record: reply.result });
  return reasonOf(reply);
}

export function takeStatus({ record }) {
  const on = record.state === "recording";
  isRecording = on;
  byId("record").classList.toggle("recording", on);
  setText(byId("record-sub"), on ? "recording" : record.state === "ended" ? `ended: ${record.reason}` : "");
  const lost = (dropped) => `${grouped(dropped)} dropped: the disk is too slow`;
  const lacking = (dropped) => (dropped > 0 ? `, ${lost(dropped)}` : "");
  showFacts(byId("record-facts"), [
    ["File", record.file ?? NONE],
    ["Duration", `${grouped(record.duration_s)} s`],
    ["Frames", `${grouped(record.frames)}${lacking(record.frames_dropped)}`],
    ["Images", `${grouped(record.pictures)}${lacking(record.pictures_dropped)}`],
    ...(record.documents_dropped > 0 ? [["Documents", lost(record.documents_dropped)]] : []),
    ["Size", `${grouped(record.bytes / MIB)} MiB`],
  ]);
}
