// What survives: references kept by name, and the settings in use that config.save keeps for the next start.
import { byId, dayAndTime, element, setText } from "./format.js";
import { confirmButton } from "./confirm.js";
import { call } from "./link.js";
import { whyLoop, whyNot } from "./rights.js";
import { allow, button, field, reasonOf } from "./widgets.js";

let parts = null; // for users with control rights
let bench = null;
let status = null;
let previewed = ""; // settings of the bench for which config.save was asked what it would save
let lastSave = ""; // what the last config.save of this page has done

function buildConfig(parent) {
  const frame = field(parent, "Settings in use");
  const save = button(frame.body, "Save settings", async () => {
    save.disabled = true;
    const reply = await call("config.save");
    save.disabled = false;
    frame.error(reasonOf(reply));
    if (!reply.result) return;
    const { saved, path } = reply.result;
    lastSave = saved.length ? `Saved ${dayAndTime(Date.now() * 1e6)} in ${path}.` : "Nothing differs from the configuration file any more.";
    preview();
  });
  save.id = frame.id;
  save.setAttribute("aria-describedby", frame.describedBy);
  return { config: frame, save };
}

function buildReference(parent) {
  const frame = field(parent, "Save the reference as");
  const name = element("input");
  name.type = "text";
  name.id = frame.id;
  name.autocomplete = "off";
  name.placeholder = "name";
  name.setAttribute("aria-describedby", frame.describedBy);
  const keep = () => act(frame, "reference.save", name.value.trim());
  name.addEventListener("keydown", (event) => event.key === "Enter" && keep());
  frame.body.append(name);
  const save = button(frame.body, "Save", keep);
  save.setAttribute("aria-label", "Save the reference under this name");
  return { reference: frame, name, saveReference: save };
}

async function act(frame, method, name) {
  const reply = await call(method, { name });
  frame.error(reasonOf(reply));
  if (reply.result && method !== "reference.load") takeReferences(reply.result.references);
  if (reply.result && method === "reference.save") parts.name.value = "";
}

export function build(mayControl) {
  const parent = document.querySelector("#saved .params");
  parent.replaceChildren();
  parts = mayControl ? { ...buildConfig(parent), ...buildReference(parent) } : null;
  shown = previewed = "";
  if (bench) takeBench(bench);
}

/** Shows what config.save would save, or why it would not. */
async function preview() {
  const { config } = parts;
  const { result, error } = await call("config.save", { preview: true });
  if (config !== parts?.config) return;
  if (error) return config.help(status?.state === "job_running" ? "" : reasonOf({ error }));
  const keys = result.saved;
  const text = keys.length ? `Keeps for the next start what differs from the configuration file: ${keys.join(", ")}.` : "Nothing differs from the configuration file.";
  return config.help(`${text} ${lastSave}`.trim());
}

let shown = "";

function takeReferences(references) {
  const key = JSON.stringify([references, parts !== null]);
  if (key === shown) return;
  shown = key;
  byId("references").hidden = references.length === 0;
  byId("references").querySelector("tbody").replaceChildren(...references.map(referenceRow));
  update();
}

function referenceRow({ name, t_taken_ns: at, usable, reason }) {
  const row = element("tr");
  const head = element("th", "", name);
  head.scope = "row";
  const state = element("td", usable ? "" : "unusable", usable ? "fits" : reason);
  const keys = element("td", "keys");
  row.append(head, element("td", "time", dayAndTime(at)), state, keys);
  if (!parts) return row;
  const load = button(keys, "Load", () => act(parts.reference, "reference.load", name));
  load.setAttribute("aria-label", `Load the reference ${name}`);
  load.dataset.reason = usable ? "" : reason;
  load.classList.add("load");
  const forget = confirmButton(keys, "Delete", { question: `Deletes ${name} on disk.`, act: () => act(parts.reference, "reference.delete", name) });
  forget.setAttribute("aria-label", `Delete the reference ${name}`);
  return row;
}

function update() {
  if (!parts) return;
  const common = whyNot();
  const running = status?.state === "job_running" ? "A job is running." : "";
  allow([parts.save], common || running, parts.config.why);
  setText(parts.config.why, common || running);
  const lack = common || (status && !status.sensor.referenced ? "Take a reference first." : "");
  allow([parts.saveReference], lack, parts.reference.why);
  setText(parts.reference.why, lack);
  for (const load of document.querySelectorAll("#references .load")) load.disabled = common !== "" || whyLoop() !== "" || load.dataset.reason !== "";
}

export const takeRight = update;

export function takeStatus(message) {
  if (status?.state === "job_running" && message.state !== status.state) previewed = ""; // the preview is refused during a job
  status = message;
  update();
}

export function takeBench(message) {
  bench = message;
  takeReferences(message.references ?? []);
  const { hologram_id: _, ...sensor } = message.sensor; // a closed loop changes it at every step
  const key = JSON.stringify([message.camera.settings, message.camera.info, sensor, message.settle_ms, status?.slm.info]);
  if (parts && key !== previewed) {
    previewed = key;
    preview();
  }
  update();
}
