// The camera image with the spots.
import { begin, font, paint } from "./canvas.js";
import { MARKS } from "./colour.js";
import { brief, byId, fixed, setText, element, NONE, roundUp } from "./format.js";

const COLUMNS = 6;
const store = {};
let image = null; // {width, height, step, canvas}
let spots = null; // {rows: [{x, y, refX, refY, peak, quality}], frameId}
let magnification = { value: 1, at: 0 };
let ringPx = null;
let pixels = null;
let painted = true; // whether the newest image has been painted

const shown = (id) => byId(`show-${id}`).checked;

/** Colour table for grey levels up to full scale; full scale is red. "dim light" scales to the brightest pixel and takes the square root. */
function greyTable(full, brightest) {
  const dim = shown("dim");
  const top = dim ? Math.max(1, brightest) : full;
  const table = new Uint32Array(full + 1);
  for (let value = 0; value <= full; ++value) {
    const light = Math.min(1, value / top);
    const grey = Math.round(255 * (dim ? Math.sqrt(light) : light));
    table[value] = value === full ? 0xff2e5fff : (255 << 24) | (grey << 16) | (grey << 8) | grey;
  }
  return table;
}

export function takeImage(json, binary) {
  const [height, width] = json.shape;
  const format = `${width * json.reduced_by} \u00d7 ${height * json.reduced_by} px, ${json.pixel_format}`;
  pixels = { format, frameId: json.frame_id, values: json.dtype === "<u2" ? new Uint16Array(binary) : new Uint8Array(binary), width, height, full: 2 ** json.significant_bits - 1, step: json.reduced_by };
  repaint();
}

/** Marks the image for painting. It is painted only when drawn, so that skipped images cost nothing. */
export function repaint() {
  painted = false;
}

function paintImage() {
  const { values, width, height, full, step } = pixels;
  let brightest = 0;
  if (shown("dim")) for (const value of values) if (value > brightest) brightest = value;
  const table = greyTable(full, brightest);
  const canvas = paint(store, width, height, (abgr) => {
    for (let i = 0; i < values.length; ++i) abgr[i] = table[Math.min(full, values[i])];
  });
  image = { canvas, width: width * step, height: height * step };
  painted = true;
}

const known = (value) => (Number.isNaN(value) ? null : value);

export function takeSpots(json, binary) {
  const values = new Float32Array(binary);
  const rows = [];
  for (let i = 0; i + COLUMNS <= values.length; i += COLUMNS) {
    const [x, y, refX, refY, peak, quality] = Array.from(values.subarray(i, i + COLUMNS), known);
    rows.push({ x, y, refX, refY, peak, quality, moved: x === null || refX === null ? null : Math.hypot(x - refX, y - refY) });
  }
  spots = { rows, pitch: pitchOf(rows) };
}

export function takeRing(px) {
  ringPx = px;
}

/** Smallest distance between two references (or, without references, two spots), px. */
function pitchOf(rows) {
  const at = rows.map((r) => (r.refX === null ? [r.x, r.y] : [r.refX, r.refY])).filter(([x]) => x !== null);
  let least = Infinity;
  at.forEach(([x, y], i) => at.slice(i + 1).forEach(([u, v]) => (least = Math.min(least, Math.hypot(x - u, y - v)))));
  return Number.isFinite(least) ? least : null;
}

/** Magnification of the arrows: the longest spans about half the distance to the neighbour. Changes rarely, so that arrows stay comparable. */
function arrowMagnification(now) {
  const longest = Math.max(...spots.rows.map((row) => row.moved ?? 0));
  const wanted = longest > 0 && spots.pitch ? Math.min(100, Math.max(1, roundUp(spots.pitch / 2 / longest / 2.5))) : 1;
  if (wanted < magnification.value || now - magnification.at > 3000) magnification = { value: wanted, at: now };
  return magnification.value;
}

/** Draws a line with a dark outline, visible on any image; its width scales with the text size. */
function stroke(context, colour, width, draw) {
  const thick = (width * font(1).px) / 15;
  for (const [style, line] of [[MARKS.halo, thick * 2.2], [colour, thick]]) {
    context.strokeStyle = style;
    context.lineWidth = line;
    context.beginPath();
    draw();
    context.stroke();
  }
}

function drawArrow(context, from, to, head) {
  const angle = Math.atan2(to.y - from.y, to.x - from.x);
  stroke(context, MARKS.arrow, 1.6, () => {
    context.moveTo(from.x, from.y);
    context.lineTo(to.x, to.y);
    for (const turn of [2.6, -2.6]) {
      context.moveTo(to.x, to.y);
      context.lineTo(to.x + head * Math.cos(angle + turn), to.y + head * Math.sin(angle + turn));
    }
  });
}

function drawLost(context, at, radius, number) {
  context.setLineDash([4, 3]);
  stroke(context, MARKS.lost, 1.8, () => context.arc(at.x, at.y, radius, 0, 2 * Math.PI));
  context.setLineDash([]);
  const text = font(0.75);
  context.font = text.css;
  context.fillStyle = MARKS.lost;
  context.fillText(String(number), at.x + radius * 0.75, at.y - radius * 0.75);
}

function drawSpot(context, row, number, place, zoom) {
  const reference = row.refX === null ? null : place(row.refX, row.refY);
  const core = row.x === null ? null : place(row.x, row.y);
  const radius = Math.max(4, (ringPx ?? 6) * zoom);
  if (reference && shown("regions") && spots.pitch) {
    context.strokeStyle = MARKS.region;
    context.lineWidth = 1;
    context.beginPath();
    context.arc(reference.x, reference.y, (spots.pitch / 2) * zoom, 0, 2 * Math.PI);
    context.stroke();
  }
  if (!shown("marks")) return;
  if (!core) return reference ? drawLost(context, reference, radius, number) : undefined;
  stroke(context, MARKS.core, 1.5, () => context.arc(core.x, core.y, radius, 0, 2 * Math.PI));
  if (!reference) return undefined;
  const half = Math.max(3, radius * 0.4);
  stroke(context, MARKS.reference, 1.5, () => {
    context.moveTo(reference.x - half, reference.y);
    context.lineTo(reference.x + half, reference.y);
    context.moveTo(reference.x, reference.y - half);
    context.lineTo(reference.x, reference.y + half);
  });
  const scale = magnification.value;
  const tip = { x: reference.x + scale * (core.x - reference.x), y: reference.y + scale * (core.y - reference.y) };
  if (Math.hypot(tip.x - reference.x, tip.y - reference.y) > 3) drawArrow(context, reference, tip, 5 + radius * 0.12);
  return undefined;
}

export function draw(now) {
  const canvas = byId("camera-canvas");
  if (!painted) paintImage();
  if (image) canvas.style.aspectRatio = `${image.width} / ${image.height}`;
  const { context, width } = begin(canvas);
  if (!image) return;
  const zoom = width / image.width;
  context.imageSmoothingEnabled = zoom < 1;
  context.drawImage(image.canvas, 0, 0, width, image.height * zoom);
  if (!spots) return;
  const scale = arrowMagnification(now);
  setText(byId("arrow-scale"), scale === 1 ? "displacement" : `displacement \u00d7 ${scale}`);
  const place = (x, y) => ({ x: (x + 0.5) * zoom, y: (y + 0.5) * zoom });
  spots.rows.forEach((row, i) => drawSpot(context, row, i, place, zoom));
}

/** Updates texts, table and the label for screen readers; called twice per second. */
export function describe() {
  if (pixels) setText(byId("camera-sub"), `${pixels.format}, frame ${pixels.frameId}`);
  if (!spots) return;
  const lost = spots.rows.filter((row) => row.x === null).length;
  const moved = spots.rows.map((row) => row.moved).filter((px) => px !== null);
  const most = moved.length ? `, the largest displacement ${brief(Math.max(...moved))} px` : "";
  byId("camera-canvas").setAttribute("aria-label", `Camera image: ${spots.rows.length - lost} of ${spots.rows.length} spots found${most}`);
  if (!document.querySelector("#camera details").open) return;
  const body = byId("spot-table").tBodies[0];
  while (body.rows.length > spots.rows.length) body.deleteRow(-1);
  while (body.rows.length < spots.rows.length) {
    const line = body.insertRow();
    for (let k = 0; k < COLUMNS; ++k) line.append(element("td"));
  }
  spots.rows.forEach((row, i) => {
    const texts = [String(i), fixed(row.x, 2), fixed(row.y, 2), fixed(row.moved, 2), fixed(row.peak, 0), row.x === null ? NONE : fixed(row.quality, 2)];
    texts.forEach((text, k) => setText(body.rows[i].cells[k], text));
  });
}
