// The list of events, newest first.
import { element, timeOfDay } from "./format.js";

const MAX_EVENTS = 100;
const seen = new Set();

export function takeEvent(event) {
  const key = `${event.t_ns} ${event.seq}`;
  if (seen.has(key)) return;
  seen.add(key);
  const list = document.querySelector("#events ol");
  const line = element("li");
  line.dataset.severity = event.severity;
  const time = element("time", "", timeOfDay(event.t_ns));
  time.dateTime = new Date(event.t_ns / 1e6).toISOString();
  const mark = element("span", "mark");
  mark.setAttribute("role", "img");
  mark.setAttribute("aria-label", event.severity);
  line.append(time, mark, element("span", "kind", event.kind), element("span", "text", event.text));
  // A job's progress replaces its previous entry.
  const job = event.kind === "job" ? `${event.data.job}` : "";
  const before = [...list.children].find((other) => job && other.dataset.job === job);
  if (before?.dataset.state === "running") before.remove();
  if (job) Object.assign(line.dataset, { job, state: event.data.state });
  list.prepend(line);
  while (list.children.length > MAX_EVENTS) list.lastChild.remove();
}
