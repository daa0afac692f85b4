// Events on the time axis: one button for each, whose text shows on hover or focus. Left and right arrows move between them.
import { element, setText, timeOfDay } from "./format.js";
import { minutesAgo, now, span } from "./history.js";

const MAX_EVENTS = 100;
let events = []; // {key, t_ns, text, severity, button}
let lane = null;
let readout = null;
let axis = [];
let showAt = () => {};

/** Returns the lane, with its own time axis. `onShow(t_ns or null)`: the event that is pointed at. */
export function build(onShow) {
  showAt = onShow;
  const box = element("div", "lanes");
  axis = Array.from({ length: 4 }, () => element("span"));
  const labels = element("p", "lane-axis");
  labels.append(...axis);
  lane = element("div", "lane");
  lane.setAttribute("role", "toolbar");
  lane.setAttribute("aria-label", "Events on the time axis");
  readout = element("p", "mark-text");
  box.append(lane, labels, readout);
  lane.addEventListener("keydown", (pressed) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[pressed.key];
    if (!step) return;
    const shown = inSpan();
    const at = shown.findIndex(({ button }) => button === document.activeElement);
    shown[Math.max(0, Math.min(shown.length - 1, at + step))]?.button.focus();
    pressed.preventDefault();
  });
  return box;
}

const inSpan = () => events.filter(({ t_ns: at }) => at > now() - span() * 1e9);

/** The events in the time span, oldest first. */
export const marks = () => inSpan();

export function takeEvent({ t_ns: at, seq, kind, text, severity, data }) {
  const key = `${at} ${seq}`;
  if (kind === "job" && data.state === "running") return;
  if (events.some((event) => event.key === key)) return;
  const button = element("button", "mark-button");
  button.type = "button";
  button.dataset.severity = severity;
  button.setAttribute("aria-label", `${timeOfDay(at)} ${kind}: ${text}`);
  const show = () => {
    setText(readout, button.getAttribute("aria-label"));
    showAt(at);
  };
  const hide = () => {
    setText(readout, "");
    showAt(null);
  };
  for (const name of ["pointerenter", "focus"]) button.addEventListener(name, show);
  for (const name of ["pointerleave", "blur"]) button.addEventListener(name, hide);
  lane.append(button);
  events.push({ key, t_ns: at, text: `${kind}: ${text}`, severity, button });
  events.sort((a, b) => a.t_ns - b.t_ns);
  if (events.length > MAX_EVENTS) events.shift().button.remove();
}

/** Places the buttons on the time axis. */
export function place() {
  const end = now();
  const shown = inSpan();
  const focused = shown.find(({ button }) => button === document.activeElement) ?? shown[shown.length - 1];
  for (const event of events) {
    const part = 1 - (end - event.t_ns) / 1e9 / span();
    event.button.hidden = !shown.includes(event);
    event.button.style.left = `${100 * Math.min(1, part)}%`;
    event.button.tabIndex = event === focused ? 0 : -1;
  }
  axis.forEach((label, third) => setText(label, minutesAgo(1 - third / 3)));
}
