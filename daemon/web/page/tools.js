// The toolbar of a panel: buttons that are always visible, and options that fold away.
import { isFrozen, onFreeze, toggleFreeze } from "./frame.js";
import { element, setText } from "./format.js";
import { button } from "./widgets.js";

/** Adds a toolbar below the head of a section; returns its buttons' and options' boxes. */
export function toolbar(section) {
  const bar = element("div", "tools");
  const keys = element("div", "keys");
  const fold = element("details");
  const options = element("div", "options");
  fold.append(element("summary", "", "Options"), options);
  bar.append(keys, fold);
  section.querySelector(".head").after(bar);
  const name = section.querySelector("h2").textContent;
  for (const box of [keys, options]) {
    box.setAttribute("role", "group");
    box.setAttribute("aria-label", `${name}: ${box === keys ? "actions" : "options"}`);
  }
  return { keys, options };
}

/** A button that shows for a moment whether its action succeeded. `action` returns false if it failed. */
export function actionButton(parent, text, hint, action) {
  const made = button(parent, text, async () => {
    const worked = await action();
    setText(made, worked === false ? "Failed" : "Done");
    setTimeout(() => setText(made, text), 1200);
  });
  made.title = hint;
  return made;
}

/** The button that freezes the shown frame, in every panel that shows it. */
export function freezeButton(parent) {
  const made = button(parent, "Freeze", toggleFreeze);
  made.title = "Keep the present frame on camera image, wavefront and coefficients";
  const show = () => made.setAttribute("aria-pressed", String(isFrozen()));
  onFreeze(show);
  show();
}

let count = 0;

function labelled(parent, title, input) {
  const label = element("label", "option");
  input.id = `option-${++count}`;
  label.htmlFor = input.id;
  if (input.type === "checkbox") label.append(input, title);
  else label.append(element("span", "", title), input);
  parent.append(label);
  return input;
}

/** A checkbox; `onChange(checked)`. */
export function checkbox(parent, title, checked, onChange) {
  const input = element("input");
  input.type = "checkbox";
  input.checked = checked;
  input.addEventListener("change", () => onChange(input.checked));
  return labelled(parent, title, input);
}

/** A selection; `choices`: [[value, title]]; `onChange(value)`. */
export function select(parent, title, value, choices, onChange) {
  const input = element("select");
  input.replaceChildren(...choices.map(([key, text]) => new Option(text, key)));
  input.value = value;
  input.addEventListener("change", () => onChange(input.value));
  return labelled(parent, title, input);
}

/** A positive number, or nothing; `onChange(number or null)`. */
export function positive(parent, title, onChange) {
  const input = element("input");
  input.type = "number";
  input.min = "0";
  input.step = "any";
  input.addEventListener("change", () => {
    const value = Number(input.value);
    const isGiven = input.value !== "" && value > 0;
    if (!isGiven) input.value = "";
    onChange(isGiven ? value : null);
  });
  return labelled(parent, title, input);
}
