// Drawings of the wavefront's panel: the map with contours, the point spread function and the modulation transfer function.
import { begin, font, paint } from "./canvas.js";
import { colourAt, colourOf, coloursOf, css, themed } from "./colour.js";
import { contour, levels } from "./contour.js";
import { tick } from "./format.js";
import { PX_PER_LAMBDA_D, SIZE_PX } from "./psf.js";

const wavefrontStore = {};
const psfStore = {};
const DECADES = 4; // of the logarithmic PSF

/** Draws the colour scale: `colour(part)` from 0 (bottom) to 1, `marks`: [[part, text]]. */
function drawScale(context, { left, top, height, width }, colour, marks, unit) {
  const bar = context.createLinearGradient(0, top + height, 0, top);
  for (let i = 0; i <= 64; ++i) bar.addColorStop(i / 64, css(colour(i / 64)));
  context.fillStyle = bar;
  context.fillRect(left, top, width, height);
  context.font = font(0.78).css;
  context.fillStyle = themed("--ink");
  context.textBaseline = "middle";
  for (const [part, text] of marks) context.fillText(text, left + width + 5, top + (1 - part) * height);
  context.fillText(unit, left, top - font(0.78).px);
}

/** Places a square picture with a scale to its right; null if there is no room yet. */
function layOut(context, width, height, labels) {
  const text = font(0.78);
  context.font = text.css;
  const bar = Math.max(10, height * 0.035);
  const right = Math.max(...labels.map((label) => context.measureText(label).width)) + bar + 12;
  const side = Math.min(height - 4, width - right - 10);
  if (side < 10) return null;
  const left = Math.max(0, (width - right - side) / 2);
  const top = (height - side) / 2;
  const inset = Math.max(text.px * 2, side * 0.08);
  return { left, top, side, scale: { left: left + side + 10, top: top + inset, height: side - 2 * inset, width: bar } };
}

function drawContours(context, { values, size, low, high }, { left, top, side }, step) {
  const at = (pixel) => ((pixel + 0.5) / size) * side;
  context.strokeStyle = themed("--ink");
  context.globalAlpha = 0.75;
  for (const level of levels(low, high, step)) {
    context.lineWidth = Math.abs(level) < step / 2 ? 1.8 : 0.8;
    context.beginPath();
    for (const [x1, y1, x2, y2] of contour(values, size, level)) {
      context.moveTo(left + at(x1), top + at(y1));
      context.lineTo(left + at(x2), top + at(y2));
    }
    context.stroke();
  }
}

/** Draws the map {values, size, low, high, limit}, all in the shown unit, with contours every `step` (0: none). */
export function drawWavefront(canvas, map, { palette, step, unit }) {
  const { context, width, height } = begin(canvas);
  const marks = [1, 0.5, 0, -0.5, -1].map((part) => [(part + 1) / 2, part === 0 ? "0" : `${part > 0 ? "+" : ""}${tick(part * map.limit)}`]);
  const place = layOut(context, width, height, marks.map(([, text]) => text).concat(unit));
  if (!place) return;
  const { left, top, side } = place;
  const colours = coloursOf(palette);
  const picture = paint(wavefrontStore, map.size, map.size, (abgr) => {
    map.values.forEach((value, i) => {
      abgr[i] = Number.isNaN(value) ? 0 : colourOf(value, map.limit, colours);
    });
  });
  context.imageSmoothingQuality = "high";
  context.save();
  context.beginPath();
  context.arc(left + side / 2, top + side / 2, (side / 2) * (1 - 2 / map.size), 0, 2 * Math.PI);
  context.clip();
  context.drawImage(picture, left, top, side, side);
  if (step > 0) drawContours(context, map, place, step);
  context.restore();
  drawScale(context, place.scale, (part) => colourAt(part, colours), marks, unit);
}

/** The PSF's part within `halfWidth` lambda/D of the axis: {values, side}, by rows. */
export function cropped(psf, halfWidth) {
  const reach = halfWidth * PX_PER_LAMBDA_D;
  const side = 2 * reach;
  const first = SIZE_PX / 2 - reach;
  return { side, values: Float32Array.from({ length: side * side }, (_, i) => psf.values[(first + Math.floor(i / side)) * SIZE_PX + first + (i % side)]) };
}

/** Draws the PSF; `text(lambdas)` says how long the bar in the picture is. */
export function drawPsf(canvas, psf, { halfWidth, log, palette, text }) {
  const { context, width, height } = begin(canvas);
  const most = Math.max(psf.peak, 1e-12);
  const part = (value) => (log ? 1 + Math.log10(Math.max(value, 1e-12) / most) / DECADES : value / most);
  const marks = log ? [0, 1, 2, 3, 4].map((k) => [1 - k / DECADES, (most / 10 ** k).toPrecision(2)]) : [0, 0.5, 1].map((k) => [k, tick(k * most)]);
  const place = layOut(context, width, height, marks.map(([, label]) => label));
  if (!place) return;
  const { left, top, side } = place;
  const colours = coloursOf(palette === "grey" ? "grey" : "heat");
  const view = cropped(psf, halfWidth);
  const picture = paint(psfStore, view.side, view.side, (abgr) => {
    view.values.forEach((value, i) => {
      abgr[i] = colourAt(part(value), colours);
    });
  });
  context.imageSmoothingQuality = "high";
  // The centre of the pixel on the axis is the picture's centre.
  const half = (0.5 / view.side) * side;
  context.save();
  context.beginPath();
  context.rect(left, top, side, side);
  context.clip();
  context.drawImage(picture, left - half, top - half, side, side);
  context.restore();
  drawScale(context, place.scale, (at) => colourAt(at, colours), marks, "");
  drawBar(context, place, halfWidth, text);
}

function drawBar(context, { left, top, side }, halfWidth, text) {
  const lambdas = halfWidth / 4;
  const length = (lambdas / (2 * halfWidth)) * side;
  const label = font(0.78);
  const [x, y] = [left + label.px, top + side - label.px];
  context.fillStyle = "#ffffff";
  context.fillRect(x, y, length, 2);
  context.font = label.css;
  context.textBaseline = "bottom";
  context.fillText(text(lambdas), x, y - 4);
}

/** Draws the MTF along x and y and its limit without aberration. `frequency`: text of the axis. */
export function drawMtf(canvas, mtf, { frequency }) {
  const { context, width, height } = begin(canvas);
  const text = font(0.75);
  const box = { left: 2.6 * text.px, right: width - text.px, top: 0.8 * text.px, bottom: height - 3.2 * text.px };
  const [xOf, yOf] = [(part) => box.left + part * (box.right - box.left), (part) => box.bottom - part * (box.bottom - box.top)];
  context.font = text.css;
  context.lineWidth = 1;
  for (const mark of [0, 0.25, 0.5, 0.75, 1]) {
    context.strokeStyle = themed("--line");
    context.strokeRect(box.left, yOf(mark), box.right - box.left, 0);
    context.strokeRect(xOf(mark), box.top, 0, box.bottom - box.top);
    context.fillStyle = themed("--quiet");
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(tick(mark), box.left - 5, yOf(mark));
    context.textAlign = "center";
    context.textBaseline = "top";
    context.fillText(tick(mark), xOf(mark), box.bottom + 4);
  }
  context.fillText(frequency, (box.left + box.right) / 2, box.bottom + 4 + 1.5 * text.px);
  const lines = [["limit", "--quiet", [5, 4], "no aberration"], ["x", "--accent", [], "along x"], ["y", "--peak", [], "along y"]];
  lines.forEach(([key, colour, dash, name], i) => {
    context.strokeStyle = context.fillStyle = themed(colour);
    context.setLineDash(dash);
    context.lineWidth = 2;
    context.beginPath();
    mtf.forEach((point) => context.lineTo(xOf(point.frequency), yOf(point[key])));
    context.stroke();
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(name, box.right - 6, box.top + (1 + i) * 1.5 * text.px);
  });
  context.setLineDash([]);
  context.textAlign = "left";
}
