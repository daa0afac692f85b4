// Zernike modes in the stream's convention: OSA/ANSI index j, RMS 1 over the pupil, x right, y down, angles from +x towards +y.

/** Radial order n and azimuthal frequency m (negative: sine) of the OSA/ANSI index j. */
export function orders(j) {
  const n = Math.ceil((Math.sqrt(9 + 8 * j) - 3) / 2);
  return { n, m: 2 * j - n * (n + 2) };
}

/** Noll's index, from 1: the cosine mode of a pair has the even number (R. J. Noll, J. Opt. Soc. Am. 66, 207, 1976). */
function noll(j) {
  const { n, m } = orders(j);
  const first = (n * (n + 1)) / 2 + Math.abs(m);
  if (m === 0) return first + 1;
  const isEven = m > 0;
  return first + ((first % 2 === 0) === isEven ? 0 : 1);
}

/** Fringe (University of Arizona) index, from 1: by n + |m|, then falling |m|, cosine first. */
function fringe(j) {
  const { n, m } = orders(j);
  return (1 + (n + Math.abs(m)) / 2) ** 2 - 2 * Math.abs(m) + (m < 0 ? 1 : 0);
}

/** The numberings of modes: title, and number of the OSA/ANSI index j. */
export const INDICES = {
  osa: { title: "OSA/ANSI", of: (j) => j },
  noll: { title: "Noll", of: noll },
  fringe: { title: "Fringe", of: fringe },
};

/** Unit-amplitude coefficient divided by RMS-normalised coefficient of the same wavefront: sqrt((2 - [m = 0]) (n + 1)). */
export function rmsFactor(j) {
  const { n, m } = orders(j);
  return Math.sqrt((m === 0 ? 1 : 2) * (n + 1));
}

function binomial(n, k) {
  let value = 1;
  for (let i = 1; i <= k; ++i) value = (value * (n - k + i)) / i;
  return value;
}

/** Value of the RMS-normalised mode at (x, y), in units of the pupil's radius. */
export function zernike(j, x, y) {
  const { n, m } = orders(j);
  const half = (n - Math.abs(m)) / 2;
  const square = x * x + y * y;
  let radial = 0;
  for (let k = 0; k <= half; ++k) radial = radial * square + (-1) ** k * Math.round(binomial(n - k, k) * binomial(n - 2 * k, half - k));
  let [re, im] = [1, 0];
  for (let k = 0; k < Math.abs(m); ++k) [re, im] = [re * x - im * y, re * y + im * x];
  return rmsFactor(j) * radial * (m < 0 ? im : re);
}

const MAX_CACHED = 4;
const cache = new Map(); // "size j,j,…" -> {inside, modes}

function basisOf(j, size) {
  const key = `${size} ${j.join()}`;
  if (!cache.has(key)) {
    const at = (i) => (2 * i + 1) / size - 1;
    const inside = [];
    for (let i = 0; i < size * size; ++i) if (Math.hypot(at(i % size), at(Math.floor(i / size))) <= 1) inside.push(i);
    const modes = j.map((mode) => Float32Array.from(inside, (i) => zernike(mode, at(i % size), at(Math.floor(i / size)))));
    if (cache.size === MAX_CACHED) cache.delete(cache.keys().next().value);
    cache.set(key, { inside, modes });
  }
  return cache.get(key);
}

/** The wavefront as size x size numbers by rows, in the coefficients' unit; NaN outside the pupil, whose circle touches the edges. */
export function wavefrontMap(j, coefficients, size) {
  const { inside, modes } = basisOf(j, size);
  const sums = new Float32Array(inside.length);
  modes.forEach((mode, k) => {
    const weight = coefficients[k];
    if (weight !== 0) for (let i = 0; i < sums.length; ++i) sums[i] += weight * mode[i];
  });
  const map = new Float32Array(size * size).fill(NaN);
  inside.forEach((at, i) => {
    map[at] = sums[i];
  });
  return map;
}
