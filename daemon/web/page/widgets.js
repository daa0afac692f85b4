// Controls that say what is in force, what the daemon made of a wish, and why it refused one.
import { call } from "./link.js";
import { element, say } from "./format.js";

let count = 0;

/** One control's frame: a label, what goes into it, a line of help and one for the daemon's refusal. */
export function field(parent, title, unit = "") {
  const id = `field-${++count}`;
  const box = element("div", "field");
  const label = element("label", "", title);
  label.htmlFor = id;
  const body = element("div", "body");
  const help = element("p", "help");
  const error = element("p", "error");
  help.id = `${id}-help`;
  error.id = `${id}-error`;
  error.setAttribute("role", "alert");
  box.append(label, body, help, error);
  parent.append(box);
  return { id, box, body, unit, help: (text) => say(help, text), error: (text) => say(error, text), describedBy: `${help.id} ${error.id}` };
}

/** Why, as the daemon says it; empty if all went well. */
export const reasonOf = (reply) => (reply.error ? reply.error.data.reason || reply.error.message : "");

/** Sends the newest wish as soon as the one before is answered: what was wished between is not sent. */
export class Sender {
  #method;
  #onReply;
  #next = null;
  #busy = false;

  constructor(method, onReply) {
    this.#method = method;
    this.#onReply = onReply;
  }

  get busy() {
    return this.#busy;
  }

  async send(params) {
    this.#next = params;
    if (this.#busy) return;
    this.#busy = true;
    while (this.#next) {
      const wish = this.#next;
      this.#next = null;
      const reply = await call(this.#method, wish);
      if (!this.#next) this.#onReply(reply);
    }
    this.#busy = false;
  }
}

/** A slider and a number that say the same. `toSlider` and `toValue` map between them, for a logarithmic one. */
export class NumberControl {
  #frame;
  #slider = element("input");
  #number = element("input");
  #map;
  #touched = -Infinity;

  constructor(parent, title, unit, { onChange, map = { toSlider: (v) => v, toValue: (s) => s }, help = true }) {
    this.#frame = field(parent, title, unit);
    this.#map = map;
    this.#slider.type = "range";
    this.#number.type = "number";
    this.#number.id = this.#frame.id;
    this.#slider.setAttribute("aria-label", `${title}${unit ? `, ${unit}` : ""}`);
    for (const input of [this.#slider, this.#number]) input.setAttribute("aria-describedby", this.#frame.describedBy);
    this.#frame.body.append(this.#slider, this.#number, element("span", "unit", unit));
    if (!help) this.#frame.box.classList.add("plain");
    this.#slider.addEventListener("input", () => {
      this.#touched = performance.now();
      const value = Number(this.#map.toValue(Number(this.#slider.value)).toPrecision(4));
      this.#number.value = String(value);
      onChange(value);
    });
    this.#number.addEventListener("change", () => {
      this.#touched = performance.now();
      if (this.#number.value !== "") onChange(Number(this.#number.value));
    });
  }

  /** The device's own limits. */
  limits(min, max, step) {
    [this.#slider.min, this.#slider.max] = [this.#map.toSlider(min), this.#map.toSlider(max)].map(String);
    this.#slider.step = step ? String(step) : "any";
    this.#number.step = "any";
  }

  /** What is in force, unless somebody's hand is on it. */
  show(value, force = false) {
    const inHand = document.activeElement === this.#number || performance.now() - this.#touched < 1000;
    if (value === null || (inHand && !force)) return;
    this.#slider.value = String(this.#map.toSlider(value));
    this.#number.value = String(Number(value.toPrecision(5)));
  }

  help(text) {
    this.#frame.help(text);
  }

  error(text) {
    this.#frame.error(text);
    this.#number.setAttribute("aria-invalid", String(text !== ""));
  }
}

/** One of some names. */
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
