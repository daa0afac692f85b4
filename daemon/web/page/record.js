// The running or last recording, with start and stop buttons for users with control rights.
import { byId, element, grouped, NONE, setText } from "./format.js";
import { call } from "./link.js";
import { button, field, reasonOf } from "./widgets.js";
import { showFacts } from "./bench.js";

const MIB = 2 ** 20;
let start = null;
let stop = null;

/** Proposes a new file name: "run-" and this computer's time. */
function proposedName() {
  const now = new Date();
  const two = (number) => String(number).padStart(2, "0");
  const [date, time] = [[now.getFullYear(), now.getMonth() + 1, now.getDate()], [now.getHours(), now.getMinutes(), now.getSeconds()]];
  return `run-${date.map(two).join("")}-${time.map(two).join("")}`;
}

export function build(mayControl) {
  const parent = document.querySelector("#record .controls");
  parent.replaceChildren();
  start = stop = null;
  if (!mayControl) return;
  const frame = field(parent, "File name");
  const name = element("input");
  name.type = "text";
  name.id = frame.id;
  name.value = proposedName();
  name.autocomplete = "off";
  name.setAttribute("aria-describedby", frame.describedBy);
  frame.body.append(name);
  frame.help("Records every frame with its image, its measurement and the active settings.");
  const ask = async (method, params) => {
    const reply = await call(method, params);
    frame.error(reasonOf(reply));
    if (reply.result) takeStatus({ record: reply.result });
    if (reply.result && method === "record.stop") name.value = proposedName();
  };
  start = button(frame.body, "Record", () => ask("record.start", { name: name.value }));
  stop = button(frame.body, "Stop", () => ask("record.stop", {}));
}

export function takeStatus({ record }) {
  const on = record.state === "recording";
  if (start) [start.disabled, stop.disabled] = [on, !on];
  byId("record").classList.toggle("recording", on);
  setText(byId("record-sub"), on ? "recording" : record.state === "ended" ? `ended: ${record.reason}` : "");
  const lacking = (dropped) => (dropped > 0 ? `, ${grouped(dropped)} dropped: the disk is too slow` : "");
  showFacts(byId("record-facts"), [
    ["File", record.file ?? NONE],
    ["Duration", `${grouped(record.duration_s)} s`],
    ["Frames", `${grouped(record.frames)}${lacking(record.frames_dropped)}`],
    ["Images", `${grouped(record.pictures)}${lacking(record.pictures_dropped)}`],
    ["Size", `${grouped(record.bytes / MIB)} MiB`],
  ]);
}
