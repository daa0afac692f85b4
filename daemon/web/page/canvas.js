// Canvases at the screen's pixel resolution.

const ratioNow = () => window.devicePixelRatio || 1;

/** A canvas that is not on the page, for exports; width and height in CSS pixels. */
export const detached = (width, height) => new OffscreenCanvas(width * ratioNow(), height * ratioNow());

/** Width and height in CSS pixels. */
export const sizeOf = (canvas) => (canvas instanceof OffscreenCanvas ? [canvas.width / ratioNow(), canvas.height / ratioNow()] : [canvas.clientWidth, canvas.clientHeight]);

/** Resizes the canvas to device pixels and clears it; returns its context and size in CSS pixels. */
export function begin(canvas) {
  const ratio = ratioNow();
  const [width, height] = sizeOf(canvas);
  const pixels = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) [canvas.width, canvas.height] = pixels;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

/** An off-screen image of `width` x `height` pixels painted by `fill(abgr)`; reused through `store`. */
export function paint(store, width, height, fill) {
  if (!store.canvas || store.canvas.width !== width || store.canvas.height !== height) {
    store.canvas = new OffscreenCanvas(width, height);
    store.context = store.canvas.getContext("2d");
    store.data = store.context.createImageData(width, height);
    store.abgr = new Uint32Array(store.data.data.buffer);
  }
  fill(store.abgr);
  store.context.putImageData(store.data, 0, 0);
  return store.canvas;
}

/** The page's font at `size` times the text size. */
export function font(size = 0.8) {
  const base = parseFloat(getComputedStyle(document.documentElement).fontSize);
  return { css: `${size * base}px system-ui, sans-serif`, px: size * base };
}
