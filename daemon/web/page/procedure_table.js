// The procedures that the page offers: their params, and their reports in words.
import { brief, fixed, plural, signed } from "./format.js";

const MRAD = 1000;

function registrationText({ registered, scale_px_per_cycle: scale, rotation_deg: rotation, mirrored, residual_px: residual, sights, base_px: base }) {
  if (!registered) return "None: the geometry of the configuration applies.";
  const mirror = mirrored ? ", mirrored" : "";
  return `The camera sees the SLM rotated by ${fixed(rotation, 2)}\u00b0${mirror}, ${brief(scale)} px for a cycle per SLM pixel; base spot at (${base.map((x) => fixed(x, 1)).join(", ")}) px. Residual ${brief(residual)} px over ${plural(sights, "grating", "gratings")}.`;
}

/** Whether a registration has only been confirmed: its map is the previous one. */
function confirmedText(before, { base_px: base, px_per_cycle: map }) {
  const same = before?.registered && [...before.base_px, ...before.px_per_cycle].every((value, k) => value === [...base, ...map][k]);
  return same ? "Confirmed: the same map was found again. Reference and calibration stay in use." : "";
}

function lutText({ source, path, depth_rad: depth, falls, levels, noise_rad: noise, residual_rad: residual, reason }) {
  if (source !== "measured") return source === "file" ? `None: the table of ${path} applies.` : "None: a linear table applies.";
  const lacking = reason ? ` ${reason}.` : " Every phase can be shown.";
  return `${fixed(depth / Math.PI, 2)} \u03c0 deep${falls ? ", falling" : ""}; ${levels} grey levels, noise ${brief(noise * MRAD)} mrad, residual ${brief(residual * MRAD)} mrad.${lacking}`;
}

function settleText({ p50_ms: median, max_ms: longest, repetitions, outliers, configured_settle_ms: configured, reason }) {
  const left = outliers ? `, ${plural(outliers, "outlier", "outliers")} left out` : "";
  const verdict = reason ? `${reason}.` : `slm.settle_ms is ${brief(configured)} ms, which is long enough.`;
  return `Settled after ${brief(median)} ms at the median, ${brief(longest)} ms at most (${repetitions} changes${left}). ${verdict}`;
}

function flatnessText({ measured, path, modes, rms_waves: rms, residual_rms_waves: residual, iterations }) {
  if (!measured) return path ? `None: ${path} applies.` : "None: the SLM counts as flat.";
  const largest = [...modes].sort((a, b) => Math.abs(b.waves) - Math.abs(a.waves)).slice(0, 3);
  const names = largest.map(({ j, waves, standard_error_waves: error }) => `Z${j} ${signed(waves, 3)} \u00b1 ${fixed(error, 3)}`).join(", ");
  return `${plural(modes.length, "mode", "modes")}, ${fixed(rms, 3)} wave RMS; largest ${names} wave. The last of ${plural(iterations, "scan", "scans")} changed it by ${fixed(residual, 4)} wave.`;
}

function calibrationText({ calibrated, in_force: active, modes, condition_number: condition, drift_px: drift, drift_noise_px: noise, dropped, disagreement_reason: differs }) {
  if (!calibrated) return "None for this sensor: modes are reconstructed with the model.";
  const left = dropped.length ? ` Left out: ${dropped.map(({ j, reason }) => `Z${j} (${reason})`).join(", ")}.` : "";
  const used = active ? "" : " It is not active with this tracker or operator.";
  return `${plural(modes.length, "mode", "modes")}, condition number ${brief(condition)}, drift ${brief(drift)} px (${brief(noise)} px expected from noise). ${differs ? `${differs}.` : "It agrees with the model."}${left}${used}`;
}

const FRAMES = ["frames", "Frames per image"];

/**
 * name: of the methods NAME.run and NAME.clear, unless `method` names another; params: [key, title, unit];
 * isKnown, text: whether a report has a result, and the result in words; endangers: what Run asks about if there is a reference
 * or a calibration; doneText(before, after): what to say of a new result.
 */
export const PROCEDURES = [
  { name: "registration", title: "Registration", params: [FRAMES], isKnown: (report) => report.registered, text: registrationText, lost: "the geometry of the configuration applies then",
    endangers: "If the camera sees the SLM otherwise than before, reference and calibration are not used any more: measure them again then.", doneText: confirmedText },
  { name: "lut", title: "Look-up table", params: [["levels", "Grey levels"], FRAMES], isKnown: (report) => report.measured, text: lutText, lost: "the configured table applies then" },
  { name: "settle", title: "Settle time", method: "slm.settle", params: [["repetitions", "Image changes"], ["watch_ms", "Watch each for", "ms"]], isKnown: (report) => report.repetitions > 0, text: settleText },
  { name: "flatness", title: "Flatness", params: [["frames", "Frames per position"]], isKnown: (report) => report.measured, text: flatnessText, lost: "the configured map applies then" },
  { name: "calibration", title: "Calibration", params: [["amplitude_waves", "Poke amplitude", "wave"], ["frames", "Frames per poke"]], isKnown: (report) => report.calibrated, text: calibrationText, lost: "modes are then reconstructed with the model" },
];
