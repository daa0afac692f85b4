// Line profile of the camera image: a line that is dragged, and the grey levels along it.
import { begin, font } from "./canvas.js";
import { stroke } from "./camera_marks.js";
import { themed } from "./colour.js";
import { byId, fixed, setText, tick } from "./format.js";

let line = null; // {from, to} in camera pixels
let onChange = () => {};

export const setOnChange = (handler) => (onChange = handler);

/** Drags for CameraView. */
export const tool = {
  begin: (at) => (line = { from: at, to: at }),
  move: (at) => {
    line.to = at;
    onChange();
  },
  end: () => {},
};

/** Begins with a horizontal line through the middle of the part in view. */
export function start({ x, y, width, height }) {
  const middle = y + Math.floor(height / 2) + 0.5;
  line ??= { from: { x: x + 0.1 * width, y: middle }, to: { x: x + 0.9 * width, y: middle } };
}

export function drawLine(context, place) {
  if (!line) return;
  const [from, to] = [place(line.from.x, line.from.y), place(line.to.x, line.to.y)];
  stroke(context, "#ffe45c", 1.6, () => {
    context.moveTo(from.x, from.y);
    context.lineTo(to.x, to.y);
  });
}

/** One grey level per camera pixel of length; null outside of the image. */
function samples(valueAt) {
  const length = Math.hypot(line.to.x - line.from.x, line.to.y - line.from.y);
  const count = Math.max(2, Math.round(length) + 1);
  const values = Array.from({ length: count }, (_, i) => {
    const part = i / (count - 1);
    return valueAt(Math.floor(line.from.x + part * (line.to.x - line.from.x)), Math.floor(line.from.y + part * (line.to.y - line.from.y)))?.value ?? null;
  });
  return { length, values };
}

/** Draws the graph: grey level over the distance along the line. `valueAt`: as of camera_image.js. */
export function drawGraph(valueAt, full) {
  const { context, width, height } = begin(byId("profile-canvas"));
  if (!line || width === 0) return;
  const { length, values } = samples(valueAt);
  const known = values.filter((value) => value !== null);
  if (known.length === 0) return;
  const most = Math.max(...known);
  const text = font(0.72);
  const box = { left: 3.6 * text.px, right: width - 4, top: 0.7 * text.px, bottom: height - 1.6 * text.px };
  const top = Math.max(1, most) * 1.05;
  const yOf = (value) => box.bottom - (value / top) * (box.bottom - box.top);
  const xOf = (i) => box.left + (i / (values.length - 1)) * (box.right - box.left);
  context.font = text.css;
  context.textBaseline = "middle";
  for (const mark of [0, most / 2, most]) {
    context.fillStyle = themed("--line");
    context.fillRect(box.left, Math.round(yOf(mark)), box.right - box.left, 1);
    context.fillStyle = themed("--quiet");
    context.textAlign = "right";
    context.fillText(tick(mark), box.left - 5, yOf(mark));
  }
  context.textBaseline = "top";
  context.textAlign = "left";
  context.fillText("0 px", box.left, box.bottom + 4);
  context.textAlign = "right";
  context.fillText(`${fixed(length, 1)} px`, box.right, box.bottom + 4);
  context.strokeStyle = themed("--accent");
  context.lineWidth = 1.5;
  context.beginPath();
  let isDown = false;
  values.forEach((value, i) => {
    if (value === null) isDown = false;
    else {
      if (isDown) context.lineTo(xOf(i), yOf(value));
      else context.moveTo(xOf(i), yOf(value));
      isDown = true;
    }
  });
  context.stroke();
  const mean = known.reduce((sum, value) => sum + value, 0) / known.length;
  setText(byId("profile-text"), `DN along ${fixed(length, 1)} px: ${Math.min(...known)} to ${most} of ${full}, mean ${fixed(mean, 1)}. Drag in the image to move the line.`);
}
