// Colour scales of the camera image: grey or false colours, with saturated pixels in a colour of their own.
import { colourAt } from "./colour.js";
import { palette } from "./palette.js";

const ABGR = (red, green, blue) => ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
const GREYS = Uint32Array.from({ length: 256 }, (_, grey) => ABGR(grey, grey, grey));

/** By name: title of the choice, its colours from dark to bright, and the colour of saturated pixels; all ABGR. */
export const SCALES = {
  grey: { title: "grey", colours: () => GREYS, saturated: ABGR(255, 60, 92) },
  heat: { title: "false colours", colours: () => palette("heat", true), saturated: ABGR(0, 240, 255) },
};

/**
 * ABGR of every grey level from 0 to `full`. With `dim`, the scale ends at `brightest` and is a square root, which shows
 * faint light.
 */
export function colourTable(name, full, { dim, brightest }) {
  const scale = SCALES[name];
  const colours = scale.colours();
  const top = dim ? Math.max(1, brightest) : full;
  const table = Uint32Array.from({ length: full + 1 }, (_, value) => {
    const part = Math.min(1, value / top);
    return colourAt(dim ? Math.sqrt(part) : part, colours);
  });
  table[full] = scale.saturated;
  return table;
}
