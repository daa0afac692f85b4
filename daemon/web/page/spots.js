// The spots of the camera image, and the table of their numbers.
import { brief, byId, element, fixed, NONE, setText } from "./format.js";

const COLUMNS = 6;

/** The newest spots: rows of {x, y, refX, refY, moved, peak, quality}, null where unknown; `pitch` is the distance of neighbours. */
export const spots = { rows: [], pitch: null };

const known = (value) => (Number.isNaN(value) ? null : value);

export function takeSpots(binary) {
  const values = new Float32Array(binary);
  const rows = [];
  for (let i = 0; i + COLUMNS <= values.length; i += COLUMNS) {
    const [x, y, refX, refY, peak, quality] = Array.from(values.subarray(i, i + COLUMNS), known);
    rows.push({ x, y, refX, refY, peak, quality, moved: x === null || refX === null ? null : Math.hypot(x - refX, y - refY) });
  }
  Object.assign(spots, { rows, pitch: pitchOf(rows) });
}

/** Smallest distance between two references (or, without references, two spots), px. */
function pitchOf(rows) {
  const at = rows.map((r) => (r.refX === null ? [r.x, r.y] : [r.refX, r.refY])).filter(([x]) => x !== null);
  let least = Infinity;
  at.forEach(([x, y], i) => at.slice(i + 1).forEach(([u, v]) => (least = Math.min(least, Math.hypot(x - u, y - v)))));
  return Number.isFinite(least) ? least : null;
}

/** Brightest pixel of each spot, DN. */
export const peaks = () => spots.rows.map((row) => row.peak).filter((peak) => peak > 0);

/** How many spots are found, and the largest displacement, as text. */
export function summary() {
  const lost = spots.rows.filter((row) => row.x === null).length;
  const moved = spots.rows.map((row) => row.moved).filter((px) => px !== null);
  const most = moved.length ? `, the largest displacement ${brief(Math.max(...moved))} px` : "";
  return `${spots.rows.length - lost} of ${spots.rows.length} spots found${most}`;
}

export function fillTable() {
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
