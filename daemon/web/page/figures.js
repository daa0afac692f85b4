// The key figures at the top of the page.
import { chosen, inUnitText } from "./chosen.js";
import { brief, byId, element, fixed, NONE, setText, strehl } from "./format.js";

// Key, title, unit, and what it is.
const FIGURES = [
  ["rms", "RMS without tilts", "wave", "Root sum square of the newest frame\u2019s coefficients without tilts"],
  ["strehl", "Strehl, estimated", "", "Mar\u00e9chal: exp(\u2212(2\u03c0 RMS)\u00b2) of the newest frame, good for small aberrations; below the wavefront stands that of the map"],
  ["spots", "Spots found", "spots", "Spots found in the newest frame, of all subapertures"],
  ["rate", "Frame rate", "frames/s", "Frames measured in the last half second"],
  ["latency", "Latency", "\u00b5s", "From arrival in the daemon to publication, newest frame; the chart shows median and peak"],
  ["saturated", "Saturated spots", "%", "Spots with a saturated pixel in the newest frame"],
  ["screen", "Age on screen", "ms", "Time since the newest frame arrived in the daemon; on another computer corrected for its clock"],
];
const values = new Map();
let rmsUnit = null;

export function build() {
  for (const [key, title, unit, meaning] of FIGURES) {
    const box = element("div");
    box.title = meaning;
    const value = element("span", "value", NONE);
    const dd = element("dd");
    const unitText = element("span", "unit", unit);
    dd.append(value, unitText);
    box.append(element("dt", "", title), dd);
    byId("figures").append(box);
    values.set(key, value);
    if (key === "rms") rmsUnit = unitText;
  }
}

const put = (key, text) => setText(values.get(key), text);

export function takeWavefront(message) {
  put("rms", inUnitText(message.rms_waves));
  setText(document.querySelector("#bar-now .value"), `${inUnitText(message.rms_waves)} ${chosen.unit}`);
  setText(rmsUnit, chosen.unit);
  put("strehl", fixed(strehl(message.rms_waves), 3));
  put("spots", `${message.tracked}\u2009/\u2009${message.subapertures}`);
  put("latency", fixed(message.latency_us, 0));
  put("saturated", fixed(100 * message.saturated, 0));
}

export function takeTrend(bin) {
  if (bin.span_s > 0.2) put("rate", brief(bin.frames / bin.span_s));
}

/** Time since the frame arrived in the daemon, ms, corrected for the clock difference. */
export function takeAge(ms) {
  put("screen", ms === null ? NONE : fixed(ms, 0));
}
