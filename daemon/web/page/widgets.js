// Form controls that show the active value and the daemon's error.
import { call } from "./link.js";
import { brief, element, setText } from "./format.js";

const EDIT_MS = 1000; // from the last touch of a slider or a field on, the user is not changing it any more
const SETTLE_MS = 3000; // grace time for changes that the refused command itself causes, e.g. the end of a job, until a status tells them
const shownErrors = new Map(); // element with an error -> {bench, since}
let count = 0;

/** Shows an error beside a control until the next attempt or until the bench changes. */
export function showError(target, text) {
  setText(target, text);
  target.closest(".field")?.querySelector("input:not([type=range])")?.setAttribute("aria-invalid", String(text !== ""));
  if (text) shownErrors.set(target, { bench: null, since: performance.now() });
  else shownErrors.delete(target);
}

/** Removes errors when the bench has changed. `bench`: the state that refusals may depend on, as text. */
export function forgetErrors(bench) {
  for (const [target, error] of shownErrors) {
    if (error.bench === null || performance.now() - error.since < SETTLE_MS) error.bench = bench;
    else if (error.bench !== bench) showError(target, "");
  }
}

/** Enables controls (reason ""), or disables them and says why: as their title, and by the element that shows the reason. */
export function allow(controls, reason, shownBy) {
  for (const control of controls) {
    const because = reason ? shownBy.id : "";
    const { hint = control.title, why = "" } = control.dataset;
    control.disabled = reason !== "";
    if (control.dataset.hint === hint && why === because && control.title === (reason || hint)) continue;
    Object.assign(control.dataset, { hint, why: because });
    control.title = reason || hint;
    const others = (control.getAttribute("aria-describedby") ?? "").split(" ").filter((id) => id && id !== why);
    control.setAttribute("aria-describedby", [...others, because].join(" ").trim());
  }
}

/** The frame of a control: label, body, and lines of help, of the reason why it is disabled, and of its error. */
export function field(parent, title, unit = "") {
  const id = `field-${++count}`;
  const box = element("div", "field");
  const label = element("label", "", title);
  label.htmlFor = id;
  const body = element("div", "body");
  const [help, why, error] = ["help", "why", "error"].map((kind) => {
    const line = element("p", kind);
    line.id = `${id}-${kind}`;
    return line;
  });
  error.setAttribute("role", "alert");
  box.append(label, body, help, why, error);
  parent.append(box);
  const showHelp = (text) => {
    setText(help, text);
    help.title = text;
  };
  return { id, box, body, unit, why, help: showHelp, error: (text) => showError(error, text), describedBy: `${help.id} ${error.id}` };
}

/** Enables the controls of a field (reason ""), or disables them and shows the reason there. */
export function allowIn(frame, controls, reason) {
  allow(controls, reason, frame.why);
  setText(frame.why, reason);
}

/** The daemon's reason for an error; empty on success. */
export const reasonOf = (reply) => (reply.error ? reply.error.data.reason || reply.error.message : "");

/**
 * Sends what was set while the previous request was answered as one request. `post` sends it and resolves as `call`.
 * `onReply` gets the last reply, with the error of an earlier one unless what it refused was set again.
 */
export class Sender {
  #post;
  #onReply;
  #next = null;
  #sending = null; // a promise, until there is nothing to send

  constructor(post, onReply) {
    this.#post = post;
    this.#onReply = onReply;
  }

  get busy() {
    return this.#sending !== null;
  }

  /** Resolves to the last reply, when all is answered. */
  send(params) {
    this.#next = { ...this.#next, ...params }; // what waits for a reply is sent with it
    this.#sending ??= this.#sendAll();
    return this.#sending;
  }

  /** Sends the rest of a refused request again, if the field at fault is one of several; returns what stays refused. */
  #without(fault, request) {
    const { [fault.split(".").at(-1)]: value, ...rest } = request;
    if (value === undefined || Object.keys(rest).length === 0) return Object.keys(request);
    this.#next = { ...rest, ...this.#next };
    return Object.keys(request).filter((key) => !(key in rest));
  }

  async #sendAll() {
    let [refused, error, reply] = [[], null, null];
    try {
      while (this.#next) {
        const request = this.#next;
        this.#next = null;
        reply = await this.#post(request);
        if (reply.error) [refused, error] = [this.#without(reply.error.data.field, request), reply.error];
        else if (refused.every((key) => key in request)) error = null;
        if (error) reply = { ...reply, error };
        if (!this.#next) this.#onReply(reply);
      }
      return reply;
    } finally {
      this.#sending = null;
    }
  }
}

/** A slider and a number field for one value. `toSlider` and `toValue` map between them, e.g. logarithmically. */
export class NumberControl {
  #frame;
  #slider = element("input");
  #number = element("input");
  #map;
  #unit;
  #touched = -Infinity;
  #isTyped = false; // the number was typed, and is not sent yet
  #range = { min: -Infinity, max: Infinity };
  #shown = null; // the active value

  constructor(parent, title, unit, { onChange, map = { toSlider: (v) => v, toValue: (s) => s }, help = true }) {
    this.#frame = field(parent, title, unit);
    this.#map = map;
    this.#unit = unit;
    this.#slider.type = "range";
    this.#number.type = "number";
    this.#number.id = this.#frame.id;
    this.#slider.setAttribute("aria-label", `${title}${unit ? `, ${unit}` : ""}`);
    for (const input of [this.#slider, this.#number]) input.setAttribute("aria-describedby", this.#frame.describedBy);
    this.#frame.body.append(this.#slider, this.#number, element("span", "unit", unit));
    if (!help) this.#frame.box.classList.add("plain");
    this.#slider.addEventListener("input", () => {
      this.#touched = performance.now();
      const rounded = Number(this.#map.toValue(Number(this.#slider.value)).toPrecision(4));
      const value = Math.min(this.#range.max, Math.max(this.#range.min, rounded));
      this.#number.value = String(value);
      onChange(value);
    });
    this.#number.addEventListener("input", () => {
      this.#isTyped = true;
    });
    this.#number.addEventListener("change", () => {
      this.#touched = performance.now();
      this.#isTyped = false;
      if (this.#number.value !== "" && this.#isPossible(Number(this.#number.value))) onChange(Number(this.#number.value));
    });
    // Another page may have changed the value meanwhile.
    const showLater = () => setTimeout(() => this.show(this.#shown), 1.1 * EDIT_MS);
    this.#number.addEventListener("blur", () => {
      this.#isTyped = false;
      showLater();
    });
    this.#slider.addEventListener("change", showLater);
  }

  /** Checks the value against the displayed range; the daemon's own range may be wider than the device's. */
  #isPossible(value) {
    const { min, max } = this.#range;
    const possible = value >= min && value <= max;
    if (!possible) this.show(this.#shown, true);
    this.error(possible ? "" : `${value} ${this.#unit} is outside ${brief(min)} to ${brief(max)} ${this.#unit}`);
    return possible;
  }

  /** Changes the unit that is shown. */
  unit(unit) {
    if (unit === this.#unit) return;
    this.#unit = unit;
    setText(this.#frame.body.querySelector(".unit"), unit);
    this.#slider.setAttribute("aria-label", `${this.#frame.box.querySelector("label").textContent}, ${unit}`);
  }

  /** Sets the range of accepted numbers. */
  limits(min, max) {
    this.#range = { min, max };
  }

  /** Sets the slider's range and step. */
  reach(min, max, step) {
    [this.#slider.min, this.#slider.max] = [this.#map.toSlider(min), this.#map.toSlider(max)].map(String);
    this.#slider.step = step ? String(step) : "any";
    this.#number.step = "any";
  }

  /** Whether the user is changing the value. */
  get isEditing() {
    return document.activeElement === this.#number || performance.now() - this.#touched < EDIT_MS;
  }

  /** Shows the active value, unless the user is changing it. `force`: only what is being typed stays. */
  show(value, force = false) {
    this.#shown = value;
    if (value === null || this.#isTyped || (this.isEditing && !force)) return;
    this.#slider.value = String(this.#map.toSlider(value));
    this.#number.value = String(Number(value.toPrecision(5)));
  }

  help(text) {
    this.#frame.help(text);
  }

  error(text) {
    this.#frame.error(text);
  }

  /** The frame, for further controls of the same value. */
  get frame() {
    return this.#frame;
  }

  get inputs() {
    return [this.#slider, this.#number];
  }
}

/** A selection from a list of names. */
export class ChoiceControl {
  #frame;
  #select = element("select");

  constructor(parent, title, onChange) {
    this.#frame = field(parent, title);
    this.#select.id = this.#frame.id;
    this.#select.setAttribute("aria-describedby", this.#frame.describedBy);
    this.#select.addEventListener("change", () => onChange(this.#select.value));
    this.#frame.body.append(this.#select);
  }

  show(value, choices) {
    if (this.#select.options.length !== choices.length) {
      this.#select.replaceChildren(...choices.map((choice) => new Option(String(choice), String(choice))));
    }
    if (document.activeElement !== this.#select) this.#select.value = String(value);
  }

  /** Enables the selection (reason ""), or disables it and says why. */
  allow(reason) {
    allowIn(this.#frame, [this.#select], reason);
  }

  error(text) {
    this.#frame.error(text);
  }
}

export function button(parent, text, onClick) {
  const made = element("button", "", text);
  made.type = "button";
  made.addEventListener("click", onClick);
  parent.append(made);
  return made;
}
