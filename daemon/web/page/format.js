// Formatting of numbers and times, and small DOM helpers.

const MINUS = "\u2212";
export const NONE = "\u2013";
const MOST_DECIMALS = 6;
const POWERS_FROM = 1e5;
const SUPERSCRIPTS = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";

/** A number with `digits` decimals; "–" if unknown. */
export function fixed(value, digits) {
  if (value === null || value === undefined || !Number.isFinite(value)) return NONE;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", MINUS);
}

/** Like fixed, with an explicit plus sign. */
export function signed(value, digits) {
  const text = fixed(value, digits);
  return text === NONE || text.startsWith(MINUS) || Number(text) === 0 ? text : `+${text}`;
}

/** A number with about three significant digits, and at least two of a small one. */
export function brief(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return NONE;
  const size = Math.abs(value);
  if (size === 0) return "0";
  const small = () => Math.min(MOST_DECIMALS, Math.max(3, 1 - Math.floor(Math.log10(size))));
  return fixed(value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : small());
}

/** A count with its noun. */
export const plural = (number, one, many) => `${grouped(number)} ${number === 1 ? one : many}`;

/** Shortest text of an axis label; from 100 000 on with a power of ten, because the space beside an axis is narrow. */
export function tick(value) {
  const size = Math.abs(Number(value.toPrecision(3)));
  const sign = value < 0 ? MINUS : "";
  if (size < POWERS_FROM) return `${sign}${size}`;
  const power = Math.floor(Math.log10(size));
  const factor = Number((size / 10 ** power).toPrecision(3));
  const ten = `10${[...String(power)].map((digit) => SUPERSCRIPTS[digit]).join("")}`;
  return factor === 1 ? `${sign}${ten}` : `${sign}${factor}\u00b7${ten}`;
}

/** 20000 as "20 000". */
export function grouped(value) {
  return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** Nanoseconds since 1970 as a local time of day. */
export function timeOfDay(ns) {
  return new Date(ns / 1e6).toLocaleTimeString([], { hour12: false });
}

/** Nanoseconds since 1970 as a local time of day, with the date unless it is today. */
export function dayAndTime(ns) {
  const at = new Date(ns / 1e6);
  const today = at.toDateString() === new Date().toDateString();
  return today ? timeOfDay(ns) : at.toLocaleString([], { dateStyle: "medium", timeStyle: "short", hour12: false });
}

/** A time to come, seconds: "20 s left", "3 min left". */
export function timeLeft(seconds) {
  if (seconds < 90) return `${Math.ceil(seconds)} s left`;
  const minutes = Math.round(seconds / 60);
  return minutes < 90 ? `${minutes} min left` : `${(minutes / 60).toFixed(1)} h left`;
}

/** Bytes as "12.3 MB", with decimal prefixes. */
export function sizeText(bytes) {
  const power = bytes < 1 ? 0 : Math.min(4, Math.floor(Math.log10(bytes) / 3));
  return `${brief(bytes / 1000 ** power)} ${["B", "kB", "MB", "GB", "TB"][power]}`;
}

/** The smallest of these steps times a power of ten that is at least `value`. */
export function roundUp(value, steps = [1, 2, 5, 10]) {
  const power = 10 ** Math.floor(Math.log10(value));
  return steps.map((step) => step * power).find((step) => step >= value * 0.9999);
}

/** Maréchal's estimate from the RMS without tilts, waves. */
export function strehl(rmsWaves) {
  return rmsWaves === null || rmsWaves === undefined ? null : Math.exp(-((2 * Math.PI * rmsWaves) ** 2));
}

/** An element with a class and text. */
export function element(name, className = "", text = "") {
  const made = document.createElement(name);
  if (className) made.className = className;
  if (text) made.textContent = text;
  return made;
}

export const byId = (id) => document.getElementById(id);

/** Sets a text only if it changes, to avoid needless layout. */
export function setText(target, text) {
  if (target.textContent !== text) target.textContent = text;
}
