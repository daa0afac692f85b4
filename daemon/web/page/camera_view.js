// The part of the camera image in view: zoom and pan by wheel, pinch, drag and keys.

const MAX_ZOOM = 64; // CSS pixels per camera pixel
const STEP = 1.4;
const PAN_PX = 60;
const CLICK_PX = 4;

export class CameraView {
  #canvas;
  #handlers;
  #size = { width: 1, height: 1 }; // of the image, camera pixels
  #zoom = 0; // CSS pixels per camera pixel; 0: fits the whole image
  #centre = { x: 0, y: 0 };
  #pointers = new Map();
  #dragged = 0;

  /**
   * `handlers`: onChange(); onPoint(at or null) while the pointer moves; onClick(at); tool() returns {begin, move, end} for
   * drags that do not pan, or null; onKey(key, event) returns whether it used the key. Positions are in camera pixels.
   */
  constructor(canvas, handlers) {
    this.#canvas = canvas;
    this.#handlers = handlers;
    canvas.addEventListener("wheel", (event) => this.#onWheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.#onDown(event));
    canvas.addEventListener("pointermove", (event) => this.#onMove(event));
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => this.#onUp(event));
    canvas.addEventListener("pointerleave", () => this.#pointers.size || handlers.onPoint(null));
    canvas.addEventListener("keydown", (event) => this.#onKey(event));
    canvas.addEventListener("dblclick", () => handlers.tool() || this.fit());
  }

  /** Sets the image's size; the whole image is shown if it changes. */
  setSize(width, height) {
    if (this.#size.width === width && this.#size.height === height) return;
    this.#size = { width, height };
    this.fit();
  }

  get #fitting() {
    return Math.min(this.#canvas.clientWidth / this.#size.width, this.#canvas.clientHeight / this.#size.height);
  }

  /** CSS pixels per camera pixel. */
  get zoom() {
    return this.#zoom || this.#fitting;
  }

  get isFitted() {
    return this.#zoom === 0;
  }

  get centre() {
    return this.isFitted ? { x: this.#size.width / 2, y: this.#size.height / 2 } : this.#centre;
  }

  /** Position on the canvas, CSS pixels, of a point of the image, whose pixel (i, k) reaches from (i, k) to (i + 1, k + 1). */
  place = (x, y) => {
    const { zoom, centre } = this;
    return { x: this.#canvas.clientWidth / 2 + (x - centre.x) * zoom, y: this.#canvas.clientHeight / 2 + (y - centre.y) * zoom };
  };

  #imageAt(event) {
    const box = this.#canvas.getBoundingClientRect();
    const { zoom, centre } = this;
    return { x: centre.x + (event.clientX - box.left - box.width / 2) / zoom, y: centre.y + (event.clientY - box.top - box.height / 2) / zoom };
  }

  /** The part of the image in view, whole camera pixels. */
  get part() {
    const { zoom, centre } = this;
    const [halfWidth, halfHeight] = [this.#canvas.clientWidth / 2 / zoom, this.#canvas.clientHeight / 2 / zoom];
    const x = Math.max(0, Math.floor(centre.x - halfWidth));
    const y = Math.max(0, Math.floor(centre.y - halfHeight));
    return { x, y, width: Math.min(this.#size.width, Math.ceil(centre.x + halfWidth)) - x, height: Math.min(this.#size.height, Math.ceil(centre.y + halfHeight)) - y };
  }

  fit() {
    this.#zoom = 0;
    this.#changed();
  }

  /** Sets the zoom and keeps the point `at` of the image where it is. */
  zoomTo(zoom, at = this.centre) {
    const { zoom: before, centre } = this;
    const now = Math.min(MAX_ZOOM, zoom);
    if (now <= this.#fitting * 1.001) return this.fit();
    this.#centre = { x: at.x + ((centre.x - at.x) * before) / now, y: at.y + ((centre.y - at.y) * before) / now };
    this.#zoom = now;
    return this.#changed();
  }

  zoomBy(steps, at) {
    this.zoomTo(this.zoom * STEP ** steps, at);
  }

  /** Moves the image by CSS pixels. */
  pan(dx, dy) {
    if (this.isFitted) return;
    const { zoom } = this;
    this.#centre = { x: this.#centre.x - dx / zoom, y: this.#centre.y - dy / zoom };
    this.#changed();
  }

  #changed() {
    const { width, height } = this.#size;
    this.#centre = { x: Math.min(width, Math.max(0, this.#centre.x)), y: Math.min(height, Math.max(0, this.#centre.y)) };
    this.follow();
    this.#handlers.onChange();
  }

  /** A finger scrolls the page while the whole image is in view and no tool is chosen; else it moves the image. */
  follow() {
    this.#canvas.style.touchAction = this.isFitted && !this.#handlers.tool() ? "pan-y" : "none";
    this.#canvas.dataset.cursor = this.#handlers.tool() ? "tool" : this.isFitted ? "point" : "pan";
  }

  #onWheel(event) {
    if (event.deltaY >= 0 && this.isFitted) return; // the page scrolls
    event.preventDefault();
    this.zoomBy(-Math.sign(event.deltaY) * Math.min(1, Math.abs(event.deltaY) / 60), this.#imageAt(event));
  }

  #onDown(event) {
    if (event.button !== 0) return;
    this.#canvas.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, event);
    this.#dragged = this.#pointers.size > 1 ? Infinity : 0;
    if (this.#pointers.size === 1) this.#handlers.tool()?.begin(this.#imageAt(event));
  }

  #onMove(event) {
    this.#handlers.onPoint(this.#imageAt(event));
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    this.#pointers.set(event.pointerId, event);
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    this.#dragged += Math.hypot(dx, dy);
    const other = [...this.#pointers.values()].find((pointer) => pointer.pointerId !== event.pointerId);
    if (other) this.#pinch(before, event, other);
    else if (this.#handlers.tool()) this.#handlers.tool().move(this.#imageAt(event));
    else this.pan(dx, dy);
  }

  #pinch(before, now, other) {
    const distance = (pointer) => Math.hypot(pointer.clientX - other.clientX, pointer.clientY - other.clientY);
    const middle = { clientX: (now.clientX + other.clientX) / 2, clientY: (now.clientY + other.clientY) / 2 };
    this.zoomTo((this.zoom * distance(now)) / Math.max(1, distance(before)), this.#imageAt(middle));
    this.pan((now.clientX - before.clientX) / 2, (now.clientY - before.clientY) / 2);
  }

  #onUp(event) {
    if (!this.#pointers.delete(event.pointerId) || this.#pointers.size > 0) return;
    const tool = this.#handlers.tool();
    if (tool) tool.end(this.#imageAt(event));
    else if (this.#dragged < CLICK_PX && event.type === "pointerup") this.#handlers.onClick(this.#imageAt(event));
  }

  #onKey(event) {
    const pans = { ArrowLeft: [PAN_PX, 0], ArrowRight: [-PAN_PX, 0], ArrowUp: [0, PAN_PX], ArrowDown: [0, -PAN_PX] };
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (this.#handlers.onKey(event)) event.preventDefault();
    else if (event.key === "+" || event.key === "=") this.zoomBy(1);
    else if (event.key === "-") this.zoomBy(-1);
    else if (event.key === "0") this.fit();
    else if (pans[event.key] && !this.isFitted) {
      event.preventDefault();
      this.pan(...pans[event.key]);
    }
  }
}
