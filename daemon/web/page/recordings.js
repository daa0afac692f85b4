// The recordings in the daemon's folder, each with a download.
import { byId, dayAndTime, element, setText, sizeText } from "./format.js";
import { fetchJson } from "./link.js";
import { button, reasonOf, showError } from "./widgets.js";

let shown = "";
let state = null; // of the recorder: a change of it changes the list

/** Downloads a file: the browser fetches it by itself and writes it to disk as it comes. */
async function download(name) {
  const reply = await fetchJson("/ticket", { name });
  showError(byId("recordings-error"), reasonOf(reply));
  if (!reply.result) return;
  const link = element("a");
  link.href = reply.result.path;
  link.download = "";
  document.body.append(link);
  link.click();
  link.remove();
}

function row({ name, file, bytes, t_modified_ns: at }, unreadable) {
  const line = element("tr");
  const head = element("th", "", name);
  head.scope = "row";
  head.title = file;
  const keys = element("td", "keys");
  const get = button(keys, "Download", () => download(name));
  get.setAttribute("aria-label", `Download ${name}`);
  get.disabled = unreadable !== null;
  if (unreadable) {
    get.title = unreadable;
    get.setAttribute("aria-describedby", "recordings-why");
  }
  line.append(head, element("td", "number", sizeText(bytes)), element("td", "time", dayAndTime(at)), keys);
  return line;
}

/** Reads the list again. */
export async function load() {
  const reply = await fetchJson("/recordings");
  showError(byId("recordings-error"), reasonOf(reply));
  if (!reply.result || JSON.stringify(reply.result) === shown) return;
  shown = JSON.stringify(reply.result);
  const { folder, recordings, left_off: more, unreadable } = reply.result;
  const none = folder === null ? "No folder for recordings is configured: set record.directory." : `No recordings in ${folder}.`;
  setText(byId("recordings-sub"), recordings.length ? `${recordings.length + more} in ${folder}${more ? `, the newest ${recordings.length} listed` : ""}` : none);
  setText(byId("recordings-why"), recordings.length && unreadable ? unreadable : "");
  byId("recordings-table").hidden = recordings.length === 0;
  byId("recordings-table").querySelector("tbody").replaceChildren(...recordings.map((one) => row(one, unreadable)));
}

export function build() {
  const fold = byId("recordings");
  fold.addEventListener("toggle", () => fold.open && load());
  button(document.querySelector("#recordings .keys"), "Refresh", load);
}

export function takeStatus({ record }) {
  const now = `${record.state} ${record.file}`;
  if (now === state) return;
  state = now;
  if (byId("recordings").open) load();
}
