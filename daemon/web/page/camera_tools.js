// The toolbar of the camera image: zoom, what a drag does, freeze, full screen and saving.
import * as image from "./camera_image.js";
import { isFrozen, onFreeze } from "./frame.js";
import { byId } from "./format.js";
import { greyPng } from "./png.js";
import * as region from "./region.js";
import { save } from "./save.js";
import { freezeButton } from "./tools.js";
import { button } from "./widgets.js";

const MODES = [
  ["pan", "Move", "A drag moves the image"],
  ["profile", "Profile", "A drag draws a line; the grey levels along it are shown below"],
  ["region", "Region", "A drag proposes the camera's region of interest"],
];

function titled(made, title, label = "") {
  made.title = title;
  if (label) made.setAttribute("aria-label", label);
  return made;
}

/** The camera's panel and the bar alone, on the whole screen where the browser allows it. */
function addFullScreen(parent) {
  const toggle = titled(button(parent, "Full screen", () => set(!document.body.classList.contains("camera-full"))), "Only this panel and the bar; Escape ends it");
  const set = (full) => {
    document.body.classList.toggle("camera-full", full);
    toggle.setAttribute("aria-pressed", String(full));
    if (full) document.documentElement.requestFullscreen?.().catch(() => {});
    else if (document.fullscreenElement) document.exitFullscreen();
  };
  set(false);
  document.addEventListener("fullscreenchange", () => document.fullscreenElement || set(false));
  document.addEventListener("keydown", (event) => event.key === "Escape" && !event.defaultPrevented && document.body.classList.contains("camera-full") && set(false));
}

/** `onChange()` is called after a change of mode, and when the page is frozen or goes on. */
export function buildTools(view, onChange) {
  const parent = byId("camera-tools");
  const tools = { mode: "pan", choose };
  const modes = new Map();

  function choose(mode) {
    tools.mode = mode;
    modes.forEach((made, each) => made.setAttribute("aria-pressed", String(each === mode)));
    region.show(mode === "region");
    view.follow();
    onChange();
  }

  titled(button(parent, "\u2212", () => view.zoomBy(-1)), "Zoom out (key \u2212)", "Zoom out");
  titled(button(parent, "+", () => view.zoomBy(1)), "Zoom in (key +, or the wheel)", "Zoom in");
  titled(button(parent, "Fit", () => view.fit()), "Show the whole image (key 0, or a double click)");
  titled(button(parent, "1:1", () => view.zoomTo(1 / (window.devicePixelRatio || 1))), "One camera pixel for each pixel of the screen");
  for (const [mode, text, title] of MODES) modes.set(mode, titled(button(parent, text, () => choose(mode)), title));
  modes.forEach((made, mode) => made.setAttribute("aria-pressed", String(mode === "pan")));
  freezeButton(parent);
  onFreeze(() => {
    onChange();
    if (isFrozen()) image.fetchWhole(isFrozen).then(onChange);
  });
  addFullScreen(parent);
  titled(button(parent, "PNG", () => byId("camera-canvas").toBlob((blob) => save("camera", image.info().at, "png", blob))), "Save the view with its marks as PNG", "PNG of the view");
  const raw = async () => {
    const pixels = await image.raw();
    save("camera-raw", pixels.at, "png", await greyPng(pixels));
  };
  titled(button(parent, "Raw", raw), "Save the camera's pixels as a grey PNG, with their grey levels as they are", "PNG of the raw pixels");
  return tools;
}
