// Colour palettes of even lightness steps, from OKLab (B. Ottosson, 2020): equal steps of the value look equally large.

const STEPS = 512;

/** Linear sRGB, 0 to 1, of OKLab lightness, chroma and hue in degrees; outside 0 to 1 if no screen shows this colour. */
function linearRgb(lightness, chroma, hue) {
  const [a, b] = [chroma * Math.cos((hue * Math.PI) / 180), chroma * Math.sin((hue * Math.PI) / 180)];
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s, -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s, -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s];
}

const isShowable = (rgb) => rgb.every((part) => part >= -1e-4 && part <= 1.0001);

/** The colour as [r, g, b] from 0 to 255, with less chroma where no screen shows as much. */
function rgbOf(lightness, chroma, hue) {
  let [low, high] = [0, chroma];
  for (let i = 0; i < 12 && !isShowable(linearRgb(lightness, high, hue)); ++i) {
    const middle = (low + high) / 2;
    if (isShowable(linearRgb(lightness, middle, hue))) low = middle;
    else high = middle;
    if (i === 11) high = low;
  }
  return linearRgb(lightness, high, hue).map((part) => {
    const bounded = Math.min(1, Math.max(0, part));
    return Math.round(255 * (bounded <= 0.0031308 ? 12.92 * bounded : 1.055 * bounded ** (1 / 2.4) - 0.055));
  });
}

/** From one hue over near-white (on a dark page, near-black) to another; lightness changes evenly towards both ends. */
const diverging = (minus, plus) => (part, isDark) => {
  const away = Math.abs(2 * part - 1);
  return [isDark ? 0.26 + 0.6 * away : 0.97 - 0.62 * away, 0.16 * away ** 0.75, part < 0.5 ? minus : plus];
};

/** [lightness, chroma, hue] of each part from 0 to 1, on a light or dark page. */
const KINDS = {
  "blue\u2013brown": diverging(252, 58),
  "purple\u2013green": diverging(312, 145),
  grey: (part) => [0.15 + 0.82 * part, 0, 0],
  heat: (part) => [0.12 + 0.85 * part, 0.15 * Math.sin(Math.PI * part) ** 0.7, 300 + 155 * part],
};

/** Palettes of signed values, for the user's choice. */
export const SIGNED = ["blue\u2013brown", "purple\u2013green", "grey"];
const made = new Map();

/** The palette's colours as Uint32Array of ABGR, from the lowest value to the highest. */
export function palette(name, isDark) {
  const key = `${name} ${isDark}`;
  if (!made.has(key)) {
    const kind = KINDS[name] ?? KINDS[SIGNED[0]];
    made.set(key, Uint32Array.from({ length: STEPS }, (_, i) => {
      const [r, g, b] = rgbOf(...kind(i / (STEPS - 1), isDark));
      return (255 << 24) | (b << 16) | (g << 8) | r;
    }));
  }
  return made.get(key);
}
