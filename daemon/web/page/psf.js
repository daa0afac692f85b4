// Point spread function and modulation transfer function of a wavefront over a circular, evenly lit pupil of diameter D.
import { fft2 } from "./fft.js";

export const PUPIL_PX = 64; // side of the wavefront map
export const SIZE_PX = 256;
/** Pixels of the PSF per lambda/D. */
export const PX_PER_LAMBDA_D = SIZE_PX / PUPIL_PX;

/** Moves the origin from the corner to the pixel (size / 2, size / 2). */
function centred(values, size) {
  const half = size / 2;
  const out = new Float32Array(values.length);
  for (let y = 0; y < size; ++y) {
    for (let x = 0; x < size; ++x) out[((y + half) % size) * size + ((x + half) % size)] = values[y * size + x];
  }
  return out;
}

/** Squared magnitude of the pupil's Fourier transform. `map`: PUPIL_PX x PUPIL_PX waves, NaN outside the pupil. */
function farField(map) {
  const re = new Float64Array(SIZE_PX * SIZE_PX);
  const im = new Float64Array(SIZE_PX * SIZE_PX);
  map.forEach((waves, i) => {
    if (Number.isNaN(waves)) return;
    const at = Math.floor(i / PUPIL_PX) * SIZE_PX + (i % PUPIL_PX);
    re[at] = Math.cos(2 * Math.PI * waves);
    im[at] = Math.sin(2 * Math.PI * waves);
  });
  fft2(re, im, SIZE_PX);
  return re.map((value, i) => value ** 2 + im[i] ** 2);
}

/**
 * The PSF relative to the peak without aberration, SIZE_PX x SIZE_PX by rows, with the optical axis at pixel (SIZE_PX / 2, SIZE_PX / 2) and
 * x to the right, y down; and `peak`, its maximum. A wavefront that rises to the right moves the spot to the right.
 */
export function psfOf(map) {
  const lit = map.reduce((count, waves) => count + (Number.isNaN(waves) ? 0 : 1), 0);
  const values = centred(farField(map), SIZE_PX).map((value) => value / lit ** 2);
  return { values, peak: values.reduce((most, value) => Math.max(most, value), 0) };
}

/** The MTF along x and y: [{frequency, x, y, limit}], frequencies from 0 to 1 in units of the cut-off D/lambda; `limit`: without aberration. */
export function mtfOf(psf) {
  const re = Float64Array.from(psf.values);
  const im = new Float64Array(re.length);
  fft2(re, im, SIZE_PX);
  const total = Math.hypot(re[0], im[0]);
  return Array.from({ length: PUPIL_PX + 1 }, (_, k) => {
    const along = (at) => Math.hypot(re[at], im[at]) / total;
    return { frequency: k / PUPIL_PX, x: along(k), y: along(k * SIZE_PX), limit: diffractionLimit(k / PUPIL_PX) };
  });
}

/** MTF of a circular pupil without aberration at a frequency in units of the cut-off. */
export function diffractionLimit(frequency) {
  const f = Math.min(1, Math.abs(frequency));
  return (2 / Math.PI) * (Math.acos(f) - f * Math.sqrt(1 - f * f));
}

/** The smallest of these half widths, lambda/D, around the axis that holds 9/10 of the light. */
export function fieldOf(psf, choices = [4, 8, 16, 32]) {
  const total = psf.values.reduce((sum, value) => sum + value, 0);
  for (const halfWidth of choices) {
    const reach = halfWidth * PX_PER_LAMBDA_D;
    let sum = 0;
    for (let y = Math.max(0, SIZE_PX / 2 - reach); y < SIZE_PX / 2 + reach; ++y) {
      for (let x = SIZE_PX / 2 - reach; x < SIZE_PX / 2 + reach; ++x) sum += psf.values[y * SIZE_PX + x];
    }
    if (sum >= 0.9 * total) return halfWidth;
  }
  return choices[choices.length - 1];
}
