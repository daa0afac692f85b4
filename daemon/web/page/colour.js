// Colours of maps and charts. The diverging map runs from blue over near-white to brown. Its halves differ in hue for
// every kind of colour vision, and its lightness decreases evenly towards both ends.

const ANCHORS = [[8, 48, 107], [38, 102, 172], [110, 170, 212], [190, 216, 232], [246, 244, 238], [244, 208, 160], [222, 148, 74], [170, 88, 22], [104, 44, 4]];
const STEPS = 512;

function makeMap() {
  const map = new Uint32Array(STEPS);
  for (let i = 0; i < STEPS; ++i) {
    const at = (i / (STEPS - 1)) * (ANCHORS.length - 1);
    const low = Math.min(Math.floor(at), ANCHORS.length - 2);
    const mix = ANCHORS[low].map((from, k) => Math.round(from + (at - low) * (ANCHORS[low + 1][k] - from)));
    map[i] = (255 << 24) | (mix[2] << 16) | (mix[1] << 8) | mix[0];
  }
  return map;
}

const diverging = makeMap();

/** ABGR of a value between -scale and scale. */
export function colourOf(value, scale) {
  const at = Math.round(((value / scale + 1) / 2) * (STEPS - 1));
  return diverging[Math.max(0, Math.min(STEPS - 1, at))];
}

/** A colour variable of the style sheet, e.g. "--ink". */
export function themed(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Marks on the camera image, which is dark in both themes.
export const MARKS = { core: "#62c8ff", reference: "#ffb000", arrow: "#ffffff", region: "rgba(255,255,255,0.28)", lost: "#ff7a4d", halo: "rgba(0,0,0,0.65)" };
