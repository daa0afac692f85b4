// The wavefront map over the pupil, with its colour scale.
import { begin, font, paint } from "./canvas.js";
import { colourOf, themed } from "./colour.js";
import { brief, byId, fixed, roundUp, setText, tick } from "./format.js";

const store = {};
let map = null; // {canvas, low, high, valid}
let scale = { value: 0.1, at: 0 };

/** The colour scale's limit: widens at once and narrows only after 4 s, so that colours stay comparable. */
function scaleFor(most, now) {
  const wanted = roundUp(Math.max(most, 0.01), [1, 1.5, 2, 3, 4, 5, 7.5, 10]);
  if (wanted > scale.value || (wanted < scale.value && now - scale.at > 4000)) scale = { value: wanted, at: now };
  if (wanted === scale.value) scale.at = now;
  return scale.value;
}

let newest = null; // [json, binary] not yet painted

export function takePhase(json, binary) {
  newest = [json, binary];
}

function paintMap(json, binary) {
  const values = new Float32Array(binary);
  const [height, width] = json.shape;
  let [low, high, count, sum, squares] = [Infinity, -Infinity, 0, 0, 0];
  for (const value of values) {
    if (Number.isNaN(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
    count += 1;
    sum += value;
    squares += value * value;
  }
  if (!json.valid || count === 0) {
    map = { valid: false };
    return;
  }
  const limit = scaleFor(Math.max(-low, high), performance.now());
  const canvas = paint(store, width, height, (abgr) => {
    for (let i = 0; i < values.length; ++i) abgr[i] = Number.isNaN(values[i]) ? 0 : colourOf(values[i], limit);
  });
  const rms = Math.sqrt(Math.max(0, squares / count - (sum / count) ** 2));
  map = { canvas, low, high, rms, limit, valid: true, frameId: json.frame_id };
}

function drawScale(context, left, top, height, limit) {
  const width = Math.max(10, height * 0.035);
  const bar = context.createLinearGradient(0, top, 0, top + height);
  for (let i = 0; i <= 64; ++i) {
    const abgr = colourOf(limit * (1 - i / 32), limit);
    bar.addColorStop(i / 64, `rgb(${abgr & 255} ${(abgr >> 8) & 255} ${(abgr >> 16) & 255})`);
  }
  context.fillStyle = bar;
  context.fillRect(left, top, width, height);
  const text = font(0.78);
  context.font = text.css;
  context.fillStyle = themed("--ink");
  context.textBaseline = "middle";
  for (const part of [1, 0.5, 0, -0.5, -1]) {
    const y = top + ((1 - part) / 2) * height;
    context.fillText(part === 0 ? "0" : `${part > 0 ? "+" : ""}${tick(part * limit)}`, left + width + 5, y);
  }
  context.fillText("wave", left, top - text.px);
}

export function draw() {
  if (newest) paintMap(...newest);
  newest = null;
  const canvas = byId("map-canvas");
  const { context, width, height } = begin(canvas);
  if (!map || !map.valid) return;
  const text = font(0.78);
  context.font = text.css;
  const labels = [0.5, 1].map((part) => context.measureText(`+${tick(part * map.limit)}`).width);
  const right = Math.max(...labels) + Math.max(10, height * 0.035) + 12;
  const side = Math.min(height - 4, width - right - 10);
  if (side < 10) return; // not laid out yet
  const left = Math.max(0, (width - right - side) / 2);
  const top = (height - side) / 2;
  context.imageSmoothingQuality = "high";
  context.save();
  context.beginPath();
  context.arc(left + side / 2, top + side / 2, (side / 2) * (1 - 2 / map.canvas.width), 0, 2 * Math.PI);
  context.clip();
  context.drawImage(map.canvas, left, top, side, side);
  context.restore();
  const inset = Math.max(text.px * 2, side * 0.08);
  drawScale(context, left + side + 10, top + inset, side - 2 * inset, map.limit);
}

/** Updates texts and the label for screen readers; called twice per second. */
export function describe() {
  if (!map || !map.valid) {
    setText(byId("map-sub"), "");
    setText(byId("map-caption"), "No wavefront is being measured.");
    return;
  }
  const peak = map.high - map.low;
  setText(byId("map-sub"), `frame ${map.frameId}`);
  setText(byId("map-caption"), `Peak to valley ${brief(peak)} wave, RMS with tilts ${fixed(map.rms, 4)} wave. x points right, y down.`);
  byId("map-canvas").setAttribute("aria-label", `Wavefront over the pupil: peak to valley ${brief(peak)} wave`);
}
