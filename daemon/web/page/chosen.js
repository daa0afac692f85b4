// Choices of the user that the browser remembers, such as the unit of wavefronts, which holds for the whole page.
import { fixed, signed } from "./format.js";
import { NORMS, UNITS } from "./units.js";
import { INDICES } from "./zernike.js";

const listeners = [];

/** The remembered value; `fallback` if there is none or `isValid` rejects it. */
export function remembered(name, fallback, isValid = () => true) {
  try {
    const value = JSON.parse(localStorage.getItem(name));
    return value !== null && typeof value === typeof fallback && isValid(value) ? value : fallback;
  } catch {
    return fallback;
  }
}

export const remember = (name, value) => localStorage.setItem(name, JSON.stringify(value));

/** unit, norm, index: keys of UNITS, NORMS and INDICES. */
export const chosen = {
  unit: remembered("unit", "wave", (name) => name in UNITS),
  norm: remembered("norm", "rms", (name) => name in NORMS),
  index: remembered("index", "osa", (name) => name in INDICES),
};

/** Calls `listener` after each change of unit, normalisation or index. */
export const onChosen = (listener) => listeners.push(listener);

export function choose(name, value) {
  chosen[name] = value;
  remember(name, value);
  listeners.forEach((listener) => listener());
}

let wavelength = 632; // nm; that of the stream before anything in nm is shown

export function takeWavelength(nm) {
  if (nm === wavelength) return;
  wavelength = nm;
  listeners.forEach((listener) => listener());
}

export const wavelengthNm = () => wavelength;

/** Waves in the chosen unit; null stays null. */
export const inUnit = (waves) => (waves === null || waves === undefined ? null : waves * UNITS[chosen.unit].perWave(wavelength));
export const toWaves = (value) => value / UNITS[chosen.unit].perWave(wavelength);

/** Waves as text in the chosen unit; `more` decimals than usual. */
export const inUnitText = (waves, more = 0) => fixed(inUnit(waves), UNITS[chosen.unit].digits + more);
export const signedText = (waves) => signed(inUnit(waves), UNITS[chosen.unit].digits);
