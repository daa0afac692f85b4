// Pixels of the camera image: the newest image of the stream, which may be reduced, and the part in view at full resolution.
import { paint } from "./canvas.js";
import { imagePart } from "./link.js";
import { colourTable } from "./camera_scale.js";

const MAX_DETAIL_PX = 1.6e6; // of a part that is fetched for every image
const DETAIL_LIVES_MS = 1500;

/** Pixels with their place in the camera's image, in camera pixels; each is the mean of step x step camera pixels. */
class Pixels {
  constructor({ json, binary }) {
    const [height, width] = json.shape;
    Object.assign(this, { x: json.x ?? 0, y: json.y ?? 0, width, height, step: json.reduced_by ?? 1, frameId: json.frame_id, at: performance.now() });
    this.full = 2 ** json.significant_bits - 1;
    this.values = json.dtype === "<u2" ? new Uint16Array(binary) : new Uint8Array(binary);
  }

  /** The grey level at a camera pixel, or undefined outside. */
  levelAt(x, y) {
    const column = Math.floor((x - this.x) / this.step);
    const row = Math.floor((y - this.y) / this.step);
    return column >= 0 && row >= 0 && column < this.width && row < this.height ? this.values[row * this.width + column] : undefined;
  }
}

/** Draws pixels at their place; `store` keeps their painted image until they or the table change. */
function drawPixels(context, store, pixels, table, place) {
  if (store.pixels !== pixels || store.table !== table) {
    const { values, full } = pixels;
    paint(store, pixels.width, pixels.height, (abgr) => {
      for (let i = 0; i < values.length; ++i) abgr[i] = table[Math.min(full, values[i])];
    });
    Object.assign(store, { pixels, table });
  }
  const from = place(pixels.x, pixels.y);
  const to = place(pixels.x + pixels.width * pixels.step, pixels.y + pixels.height * pixels.step);
  context.imageSmoothingEnabled = to.x - from.x < pixels.width;
  context.drawImage(store.canvas, from.x, from.y, to.x - from.x, to.y - from.y);
}

const stores = { newest: {}, detail: {} };
let newest = null;
let detail = null;
let isFetching = false;
let fetched = ""; // the image and part that was fetched last
let header = null;
let table = { key: "" };

/** Facts of the shown image: size in camera pixels, format, levels; null before the first one. */
export const info = () => header;

export function take(json, binary) {
  newest = new Pixels({ json, binary });
  const { step, full, frameId, width, height } = newest;
  const [rows, columns] = json.whole_shape ?? [height * step, width * step];
  header = {
    width: columns, height: rows, step, full, frameId, format: json.pixel_format,
    histogram: json.histogram, saturated: json.saturated_pixels, brightest: json.brightest_dn, at: json.t_arrival_ns,
  };
}

const whole = () => ({ x: 0, y: 0, width: header.width, height: header.height });

/** Fetches the part in view at full resolution, once for each image and part. `onReady` is called if it came. */
export async function refine(part, onReady) {
  const wanted = JSON.stringify([newest.frameId, part]);
  if (newest.step === 1 || part.width * part.height > MAX_DETAIL_PX || isFetching || wanted === fetched) return;
  isFetching = true;
  fetched = wanted;
  const reply = await imagePart(part);
  isFetching = false;
  if (!reply) return;
  detail = new Pixels(reply);
  onReady();
}

/** All pixels at full resolution as {values, width, height, at}; of a newer image if the shown one is reduced. `at`: its time, ns. */
export async function raw() {
  const reply = header.step === 1 ? null : await imagePart(whole());
  const { values, width, height } = reply ? new Pixels(reply) : newest;
  return { values, width, height, at: reply?.json.t_arrival_ns ?? header.at };
}

/** Replaces a reduced image by a newer one at full resolution, to look at it for long, if it is still wanted then. */
export async function fetchWhole(isWanted) {
  const reply = header?.step > 1 ? await imagePart(whole()) : null;
  if (!reply || !isWanted()) return;
  newest = new Pixels(reply);
  detail = null;
  header = { ...header, step: 1, frameId: newest.frameId, at: reply.json.t_arrival_ns };
}

const currentDetail = () => (detail && newest.step > 1 && performance.now() - detail.at < DETAIL_LIVES_MS ? detail : null);

/** Grey level at a camera pixel as {value, step}, `step` as in Pixels; null outside of the image. */
export function valueAt(x, y) {
  for (const pixels of [currentDetail(), newest]) {
    const value = pixels?.levelAt(x, y);
    if (value !== undefined) return { value, step: pixels.step };
  }
  return null;
}

/** Whether the part in view is shown at full resolution. */
export const isWhole = () => header.step === 1 || currentDetail() !== null;

export function draw(context, scale, dim, place) {
  const key = `${scale} ${header.full} ${dim ? header.brightest : ""}`;
  if (table.key !== key) table = { key, colours: colourTable(scale, header.full, { dim, brightest: header.brightest }) };
  drawPixels(context, stores.newest, newest, table.colours, place);
  if (currentDetail()) drawPixels(context, stores.detail, detail, table.colours, place);
}
