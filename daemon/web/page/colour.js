// Colours of maps and charts.
import { palette, SIGNED } from "./palette.js";

/** The colours of a palette for the page's theme. */
export const coloursOf = (name = SIGNED[0]) => palette(name, getComputedStyle(document.documentElement).colorScheme === "dark");

/** ABGR of a part, from 0 (lowest) to 1 (highest), among a palette's colours. */
export function colourAt(part, colours) {
  const at = Math.round(part * (colours.length - 1));
  return colours[Math.max(0, Math.min(colours.length - 1, at))];
}

/** ABGR of a value between -scale and scale. */
export const colourOf = (value, scale, colours) => colourAt((value / scale + 1) / 2, colours);

/** An ABGR colour for canvas and CSS. */
export const css = (abgr) => `rgb(${abgr & 255} ${(abgr >> 8) & 255} ${(abgr >> 16) & 255})`;

/** A colour variable of the style sheet, e.g. "--ink". */
export function themed(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Marks on the camera image, which is dark in both themes.
export const MARKS = { core: "#62c8ff", reference: "#ffb000", arrow: "#ffffff", region: "rgba(255,255,255,0.28)", lost: "#ff7a4d", halo: "rgba(0,0,0,0.65)" };
