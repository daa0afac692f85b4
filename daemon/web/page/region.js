// Region of interest of the camera: proposed by dragging a rectangle or by numbers, then applied.
import { stroke } from "./camera_marks.js";
import { byId, element, setText } from "./format.js";
import { call } from "./link.js";
import { whyNot } from "./rights.js";
import { allow, button, field, reasonOf, Sender } from "./widgets.js";

const KEYS = ["x", "y", "width", "height"];
const NOTHING = "Drag a rectangle in the image, or write numbers.";
let frame = null;
let inputs = null;
let buttons = null;
let camera = null; // of the newest bench message
let proposed = null; // region in sensor pixels, or null
let origin = null; // of the running drag, sensor pixels
let onChange = () => {};
let onEnd = () => {};

const current = () => camera?.settings.roi ?? { x: 0, y: 0, width: 0, height: 0 };

/** The nearest region that the camera has: within the sensor, at least the least size, in the camera's steps. */
export function snapped({ x, y, width, height }, limits) {
  const along = (at, size, range, sensor) => {
    const step = Math.max(1, range.increment);
    const steps = (value) => Math.round(value / step) * step;
    const length = Math.min(Math.floor(sensor / step) * step, Math.max(range.min, steps(size)));
    return [Math.max(0, Math.min(steps(at), Math.floor((sensor - length) / step) * step)), length];
  };
  const [left, w] = along(x, width, limits.roi_width, limits.sensor_width);
  const [top, h] = along(y, height, limits.roi_height, limits.sensor_height);
  return { x: left, y: top, width: w, height: h };
}

/** Proposes the nearest region and shows its numbers, but does not touch the one that the user is writing. */
function propose(region, written = "") {
  if (!camera?.limits) return;
  proposed = snapped(region, camera.limits);
  for (const key of KEYS) if (key !== written) inputs[key].value = String(proposed[key]);
  describe();
  takeRight();
  onChange();
}

function describe() {
  if (!camera?.limits) return frame.help("The camera is not connected.");
  const { limits } = camera;
  const [w, h] = [limits.roi_width, limits.roi_height];
  const now = current();
  const steps = w.increment > 1 || h.increment > 1 ? `, in steps of ${w.increment} \u00d7 ${h.increment} px` : "";
  const what = proposed ? `Sets ${proposed.width} \u00d7 ${proposed.height} px at (${proposed.x}, ${proposed.y}); now ` : "Now ";
  return frame.help(`${what}${now.width} \u00d7 ${now.height} px at (${now.x}, ${now.y}). The sensor has ${limits.sensor_width} \u00d7 ${limits.sensor_height} px${steps}.`);
}

/** Drags for CameraView, whose positions count from the corner of the present region. */
export const tool = {
  begin: (at) => {
    const { x, y } = current();
    origin = { x: x + at.x, y: y + at.y };
  },
  move: (at) => {
    if (!origin) return;
    const now = { x: current().x + at.x, y: current().y + at.y };
    propose({ x: Math.min(origin.x, now.x), y: Math.min(origin.y, now.y), width: Math.abs(now.x - origin.x), height: Math.abs(now.y - origin.y) });
  },
  end: () => (origin = null),
};

/** `handlers`: onChange() to draw again, onEnd() when the tool has done its work. */
export function build(parent, handlers) {
  ({ onChange, onEnd } = handlers);
  frame = field(parent, "Region of interest, sensor pixels");
  inputs = Object.fromEntries(
    KEYS.map((key) => {
      const input = element("input");
      input.type = "number";
      input.min = "0";
      input.setAttribute("aria-label", `Region: ${key}, sensor pixels`);
      input.setAttribute("aria-describedby", frame.describedBy);
      const numbers = () => Object.fromEntries(KEYS.map((each) => [each, Number(inputs[each].value)]));
      input.addEventListener("input", () => propose(numbers(), key));
      input.addEventListener("change", () => propose(numbers()));
      const label = element("span", "unit", key);
      frame.body.append(label, input);
      return [key, input];
    }),
  );
  inputs.x.id = frame.id;
  const sender = new Sender((params) => call("camera.set", params), (reply) => {
    frame.error(reasonOf(reply));
    if (reply.result) onEnd();
  });
  buttons = [
    button(frame.body, "Whole sensor", () => camera?.limits && propose({ x: 0, y: 0, width: camera.limits.sensor_width, height: camera.limits.sensor_height })),
    button(frame.body, "Apply", () => sender.send({ roi: proposed })),
  ];
  button(frame.body, "Cancel", () => onEnd());
  takeRight();
}

/** Begins or ends a proposal. */
export function show(shown) {
  proposed = null;
  frame.error("");
  byId("region").hidden = !shown;
  KEYS.forEach((key) => (inputs[key].value = String(current()[key])));
  describe();
  takeRight();
}

export function takeRight() {
  const reason = whyNot() || (camera?.limits ? "" : "The camera is not connected.");
  const [wholeSensor, apply] = buttons;
  const lack = reason || (proposed ? "" : NOTHING);
  allow([...Object.values(inputs), wholeSensor], reason, frame.why);
  allow([apply], lack, frame.why);
  setText(frame.why, lack);
}

export function takeCamera(message) {
  camera = message;
  if (!byId("region").hidden) describe();
  takeRight();
}

/** Draws the proposal. */
export function draw(context, place) {
  if (!proposed) return;
  const { x, y } = current();
  const from = place(proposed.x - x, proposed.y - y);
  const to = place(proposed.x - x + proposed.width, proposed.y - y + proposed.height);
  stroke(context, "#ffe45c", 1.6, () => context.rect(from.x, from.y, to.x - from.x, to.y - from.y));
}
