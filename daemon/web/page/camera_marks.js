// Marks on the camera image. They stay outside of the dark cores, so that the cores remain visible.
import { font } from "./canvas.js";
import { MARKS } from "./colour.js";
import { roundUp } from "./format.js";

const GAP = 0.35; // half of each gap of the open ring, radians
const RING = 1.45; // radius of the open ring; unit: radius of the bright ring

let magnification = { value: 1, at: 0 };

/** Magnification of the arrows: the longest spans about half the distance to the neighbour. Changes rarely, so that arrows stay comparable. */
export function arrowMagnification({ rows, pitch }, now) {
  const longest = Math.max(...rows.map((row) => row.moved ?? 0));
  const wanted = longest > 0 && pitch ? Math.min(100, Math.max(1, roundUp(pitch / 2 / longest / 4))) : 1;
  if (wanted < magnification.value || now - magnification.at > 3000) magnification = { value: wanted, at: now };
  return magnification.value;
}

/** Draws a line with a dark outline, visible on any image; its width scales with the text size. */
export function stroke(context, colour, width, draw) {
  const thick = (width * font(1).px) / 15;
  for (const [style, line] of [[MARKS.halo, thick * 2.2], [colour, thick]]) {
    context.strokeStyle = style;
    context.lineWidth = line;
    context.beginPath();
    draw();
    context.stroke();
  }
}

/** Four arcs around the core, open where the ticks of the reference point. */
function drawCore(context, at, radius) {
  stroke(context, MARKS.core, 1.4, () => {
    for (let quarter = 0; quarter < 4; ++quarter) {
      const from = (quarter * Math.PI) / 2 + GAP;
      context.moveTo(at.x + radius * Math.cos(from), at.y + radius * Math.sin(from));
      context.arc(at.x, at.y, radius, from, from + Math.PI / 2 - 2 * GAP);
    }
  });
}

/** Four ticks that point to the reference from outside; none where it would hide the core. */
function drawReference(context, at, core, radius) {
  stroke(context, MARKS.reference, 1.4, () => {
    for (const [x, y] of [[1, 0], [0, 1], [-1, 0], [0, -1]]) {
      const ends = [0.8, 1.25].map((part) => ({ x: at.x + part * radius * x, y: at.y + part * radius * y }));
      if (ends.some((end) => Math.hypot(end.x - core.x, end.y - core.y) < 0.7 * radius)) continue;
      context.moveTo(ends[0].x, ends[0].y);
      context.lineTo(ends[1].x, ends[1].y);
    }
  });
}

/** An arrow that starts at the ring around the core, because at its centre it would hide the core. */
function drawArrow(context, at, shift, radius) {
  const length = Math.hypot(shift.x, shift.y);
  if (length < 3) return;
  const [ux, uy] = [shift.x / length, shift.y / length];
  const tip = { x: at.x + ux * (radius + length), y: at.y + uy * (radius + length) };
  const angle = Math.atan2(uy, ux);
  const head = Math.min(length, 4 + radius * 0.15);
  stroke(context, MARKS.arrow, 1.5, () => {
    context.moveTo(at.x + ux * radius, at.y + uy * radius);
    context.lineTo(tip.x, tip.y);
    for (const turn of [2.6, -2.6]) {
      context.moveTo(tip.x, tip.y);
      context.lineTo(tip.x + head * Math.cos(angle + turn), tip.y + head * Math.sin(angle + turn));
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

function drawRegion(context, at, radius) {
  context.strokeStyle = MARKS.region;
  context.lineWidth = 1;
  context.beginPath();
  context.arc(at.x, at.y, radius, 0, 2 * Math.PI);
  context.stroke();
}

/** `place(x, y)`: position on the canvas of a point of the image; `zoom`: CSS pixels per camera pixel. */
export function drawSpots(context, spots, { place, zoom, ringPx, marks, regions }) {
  const centre = (x, y) => (x === null ? null : place(x + 0.5, y + 0.5));
  const radius = Math.max(6, (ringPx ?? 6) * RING * zoom);
  spots.rows.forEach((row, number) => {
    const reference = centre(row.refX, row.refY);
    const core = centre(row.x, row.y);
    if (reference && regions && spots.pitch) drawRegion(context, reference, (spots.pitch / 2) * zoom);
    if (!marks) return;
    if (!core) return reference ? drawLost(context, reference, radius, number) : undefined;
    drawCore(context, core, radius);
    if (!reference) return undefined;
    drawReference(context, reference, core, radius);
    const scale = magnification.value;
    return drawArrow(context, core, { x: scale * (core.x - reference.x), y: scale * (core.y - reference.y) }, radius);
  });
}
