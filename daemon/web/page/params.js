// Number fields for the params of a method, with defaults, ranges and meanings from the schemas that the daemon publishes.
import { element } from "./format.js";
import { call } from "./link.js";
import { field } from "./widgets.js";

let described = null;

/** The schemas of a method's params by key; none if the daemon does not answer, which is asked again next time. */
export async function paramsOf(method) {
  described ??= call("system.describe");
  const { result } = await described;
  if (!result) described = null;
  return result?.methods[method]?.params.properties ?? {};
}

/** One number; empty: the daemon's default. */
export class NumberField {
  #input = element("input");
  #frame;

  constructor(parent, title, unit = "") {
    this.#frame = field(parent, title, unit);
    this.#input.type = "number";
    this.#input.step = "any";
    this.#input.id = this.#frame.id;
    this.#input.placeholder = "default";
    this.#input.setAttribute("aria-describedby", this.#frame.describedBy);
    this.#frame.body.append(this.#input, element("span", "unit", unit));
  }

  /** Takes default, range and meaning from a schema. */
  describe({ default: usual, minimum, maximum, description, type } = {}) {
    Object.assign(this.#input, { min: minimum ?? "", max: maximum ?? "", title: description ?? "", step: type === "integer" ? "1" : "any" });
    if (usual === null) this.#input.placeholder = "automatic";
    else if (usual !== undefined && this.#input.value === "") this.#input.value = String(usual);
  }

  /** The number, or undefined. */
  get value() {
    return this.#input.value === "" ? undefined : Number(this.#input.value);
  }

  set value(number) {
    if (document.activeElement !== this.#input) this.#input.value = String(number);
  }

  get input() {
    return this.#input;
  }

  get frame() {
    return this.#frame;
  }
}

/** Fields for some params of a method: `rows` of [key, title, unit]. Returns a function that returns the params that are given. */
export function paramFields(parent, method, rows) {
  const fields = rows.map(([key, title, unit]) => [key, new NumberField(parent, title, unit)]);
  paramsOf(method).then((schemas) => fields.forEach(([key, made]) => made.describe(schemas[key])));
  const given = () => Object.fromEntries(fields.map(([key, made]) => [key, made.value]).filter(([, value]) => value !== undefined));
  return { given, inputs: fields.map(([, made]) => made.input) };
}
