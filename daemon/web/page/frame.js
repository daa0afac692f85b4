// The measured frame that the page shows: the newest, or the one at which the user froze the page.
import { takeWavelength } from "./chosen.js";

let newest = null;
let frozen = null;
const listeners = [];

export function take(message) {
  newest = message;
  takeWavelength(message.wavelength_nm);
}

/** The `wavefront` message to show; null before the first. */
export const shown = () => frozen ?? newest;
export const isFrozen = () => frozen !== null;

/** Calls `listener` after each change between frozen and live. */
export const onFreeze = (listener) => listeners.push(listener);

/** Freezes at the newest frame, or shows live frames again. */
export function toggleFreeze() {
  frozen = frozen ? null : newest;
  listeners.forEach((listener) => listener());
}

/** Coefficient of mode j of a message in waves; undefined if it is not measured. */
export const coefficientOf = (message) => (j) => message.coefficients[message.j.indexOf(j)] ?? undefined;
