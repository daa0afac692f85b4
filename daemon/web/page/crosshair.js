// The value of a pixel: of the one under the pointer, or else of the one that is marked by a crosshair.
import { info, valueAt } from "./camera_image.js";
import { stroke } from "./camera_marks.js";
import { byId, fixed, setText } from "./format.js";

const HINT = "Point at the image for the value of a pixel; click to keep it marked.";
const COLOUR = "#7dff9a";
let pointed = null; // camera pixel under the pointer
let pinned = null; // camera pixel with the crosshair

const pixelAt = (at) => at && { x: Math.floor(at.x), y: Math.floor(at.y) };

export const point = (at) => (pointed = pixelAt(at));

/** Marks the pixel, or removes the mark if it is there already. */
export function toggle(at) {
  const pixel = pixelAt(at);
  pinned = pinned && pinned.x === pixel.x && pinned.y === pixel.y ? null : pixel;
}

/** Keys of the canvas: marks the pixel at `centre`, moves or removes the mark. Returns whether it used the key. */
export function onKey(event, centre) {
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  if (event.key === "Enter") pinned = pixelAt(centre);
  else if (event.key === "Escape" && pinned) pinned = null;
  else if (event.shiftKey && steps[event.key] && pinned) pinned = { x: pinned.x + steps[event.key][0], y: pinned.y + steps[event.key][1] };
  else return false;
  pointed = null;
  return true;
}

/** Shows the value in coordinates of the sensor; `roi`: region of the camera. */
export function showValue(roi) {
  const pixel = pointed ?? pinned;
  const level = pixel && info() && valueAt(pixel.x, pixel.y);
  if (!level) return setText(byId("camera-readout"), HINT);
  const { x, y } = roi ?? { x: 0, y: 0 };
  const inRegion = x || y ? ` (${pixel.x}, ${pixel.y} in the region)` : "";
  const { full } = info();
  const mean = level.step > 1 ? `, mean of ${level.step} \u00d7 ${level.step} pixels` : "";
  const text = `x ${x + pixel.x}, y ${y + pixel.y}${inRegion}: ${level.value} DN, ${fixed((100 * level.value) / full, 1)} % of full scale${mean}${level.value >= full ? ", saturated" : ""}`;
  return setText(byId("camera-readout"), text);
}

/** Draws the crosshair, open at the pixel. */
export function draw(context, { place, zoom }, width, height) {
  if (!pinned) return;
  const at = place(pinned.x + 0.5, pinned.y + 0.5);
  const gap = Math.max(6, zoom);
  stroke(context, COLOUR, 1.1, () => {
    for (const [x1, y1, x2, y2] of [[0, at.y, at.x - gap, at.y], [at.x + gap, at.y, width, at.y], [at.x, 0, at.x, at.y - gap], [at.x, at.y + gap, at.x, height]]) {
      context.moveTo(x1, y1);
      context.lineTo(x2, y2);
    }
  });
}
