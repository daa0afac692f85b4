// Colour theme: light, dark or the system's.
import { byId, setText } from "./format.js";

const NAMES = { auto: "system", light: "light", dark: "dark" };
const ORDER = Object.keys(NAMES);

/** Sets up the button that cycles through the themes; `onChange` redraws the canvases. */
export function chooseTheme(onChange) {
  const button = byId("theme");
  const set = (theme) => {
    document.documentElement.dataset.theme = theme;
    localStorage.setItem("theme", theme);
    setText(button, `Colours: ${NAMES[theme]}`);
    onChange();
  };
  const stored = localStorage.getItem("theme");
  set(ORDER.includes(stored) ? stored : "auto");
  button.addEventListener("click", () => set(ORDER[(ORDER.indexOf(document.documentElement.dataset.theme) + 1) % ORDER.length]));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", onChange);
}
