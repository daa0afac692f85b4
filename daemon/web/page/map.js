// The wavefront's panel: map over the pupil, point spread function or modulation transfer function of the shown frame, and their figures.
import { detached } from "./canvas.js";
import { chosen, inUnit, inUnitText, onChosen, remember, remembered, toWaves, wavelengthNm } from "./chosen.js";
import { coefficientOf, isFrozen, shown } from "./frame.js";
import { brief, byId, fixed, roundUp, setText, timeOfDay } from "./format.js";
import { drawMtf, drawPsf, drawWavefront, cropped } from "./map_draw.js";
import { SIGNED } from "./palette.js";
import { fieldOf, mtfOf, psfOf, PUPIL_PX, PX_PER_LAMBDA_D } from "./psf.js";
import { copy, pngOf, save, saveCsv } from "./save.js";
import { AutoScale } from "./scale.js";
import { actionButton, checkbox, freezeButton, positive, select, toolbar } from "./tools.js";
import { DEFOCUS, radiusOfCurvatureM, strehlOf, TILTS } from "./units.js";
import { wavefrontMap } from "./zernike.js";

const LEAST_DEFOCUS = 1e-4; // wave: its standard error where the frame tells none
const MAP_PX = 128;
const MIN_INTERVAL_MS = { wavefront: 60, psf: 250, mtf: 250 };
const NAMES = { wavefront: "Wavefront over the pupil", psf: "Point spread function", mtf: "Modulation transfer function" };
const EXPORT_PX = [900, 780];
const KEPT = "map";
const options = { view: "wavefront", palette: SIGNED[0], contours: false, tilt: false, defocus: false, log: false, limit: 0, ...remembered(KEPT, {}) };
const controls = {};
let bench = null; // {pupilMm, lambdaPx, pitchUm}: pupil on the SLM, lambda/D on the camera
let computed = null; // what is drawn
let computedAt = -Infinity;
const scale = new AutoScale([1, 1.5, 2, 3, 4, 5, 7.5, 10]);
let redraw = () => {};

function set(name, value) {
  options[name] = value;
  remember(KEPT, options);
  computedAt = -Infinity;
  showControls();
  redraw();
}

function showControls() {
  const isMap = options.view === "wavefront";
  for (const name of ["palette", "contours", "lock", "limit"]) controls[name].parentElement.hidden = !isMap;
  controls.palette.parentElement.hidden = options.view === "mtf";
  controls.log.parentElement.hidden = options.view !== "psf";
  controls.lock.checked = options.limit > 0;
  controls.limit.previousSibling.textContent = `\u00b1 ${chosen.unit}`;
  if (document.activeElement !== controls.limit) controls.limit.value = String(Number(inUnit(limitNow()).toPrecision(4)));
}

/** Builds the toolbar; `onChange` is called when the panel must be drawn again. */
export function build(onChange) {
  redraw = onChange;
  const { keys, options: box } = toolbar(byId("map"));
  select(keys, "", options.view, [["wavefront", "Wavefront"], ["psf", "PSF"], ["mtf", "MTF"]], (view) => set("view", view)).setAttribute("aria-label", "What the panel shows");
  freezeButton(keys);
  actionButton(keys, "Copy", "Copy picture and figures to the clipboard", async () => computed && copy(lines().join("\n"), await png()));
  actionButton(keys, "CSV", "Save the shown values", () => computed !== null && saveValues());
  actionButton(keys, "PNG", "Save the picture", async () => computed !== null && save(options.view, computed.frame.t_arrival_ns, "png", await png()));
  checkbox(box, "without tilts", options.tilt, (on) => set("tilt", on));
  checkbox(box, "without defocus", options.defocus, (on) => set("defocus", on));
  controls.contours = checkbox(box, "contours", options.contours, (on) => set("contours", on));
  controls.palette = select(box, "Colours", options.palette, SIGNED.map((name) => [name, name]), (name) => set("palette", name));
  controls.lock = checkbox(box, "lock scale", options.limit > 0, (on) => set("limit", on ? scale.waves : 0));
  controls.limit = positive(box, "\u00b1", (value) => set("limit", value === null ? 0 : toWaves(value)));
  controls.log = checkbox(box, "logarithmic", options.log, (on) => set("log", on));
  onChosen(() => {
    showControls();
    redraw();
  });
  showControls();
}

export function takeBench({ sensor, optics }) {
  bench = { pupilMm: sensor.pupil_mm, lambdaPx: sensor.lambda_pupil_px, pitchUm: optics.camera_pitch_um };
}

/** Limit of the colour scale in waves, and interval of the contours in the shown unit. */
const limitNow = () => options.limit || scale.waves;
const contourStep = () => roundUp(inUnit(limitNow()) / 5);

function extremes(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return { low, high };
}

/** Coefficients without the modes of which `isRemoved`. */
const without = ({ j, coefficients }, isRemoved) => coefficients.map((waves, i) => (isRemoved(j[i]) ? 0 : waves));

function compute(frame) {
  const isRemoved = (j) => (options.tilt && TILTS.includes(j)) || (options.defocus && j === DEFOCUS);
  const coefficients = without(frame, isRemoved);
  const waves = wavefrontMap(frame.j, coefficients, MAP_PX);
  const untilted = without({ j: frame.j, coefficients }, (j) => TILTS.includes(j));
  const found = { frame, waves, ...extremes(waves), rms: Math.hypot(...coefficients), strehl: strehlOf(wavefrontMap(frame.j, untilted, MAP_PX)) };
  if (options.view === "wavefront") return found;
  found.psf = psfOf(wavefrontMap(frame.j, coefficients, PUPIL_PX));
  found.halfWidth = fieldOf(found.psf);
  if (options.view === "mtf") found.mtf = mtfOf(found.psf);
  return found;
}

/** Length on the camera of a number of lambda/D: " = 12 um = 3.5 px"; empty if unknown. */
function onCamera(lambdas) {
  if (!bench?.lambdaPx) return "";
  const px = lambdas * bench.lambdaPx;
  const mm = (px * bench.pitchUm) / 1000;
  return ` = ${brief(px)} px = ${mm < 0.1 ? `${brief(1000 * mm)} \u00b5m` : `${brief(mm)} mm`}`;
}

/** Frequency of the MTF's cut-off D/lambda on the camera, cycles per mm; null if unknown. */
const cutOff = () => (bench?.lambdaPx ? 1000 / (bench.lambdaPx * bench.pitchUm) : null);

/** Whether a new frame should be drawn: PSF and MTF are computed only a few times a second. */
export const isDue = () => performance.now() - computedAt >= MIN_INTERVAL_MS[options.view];

export function draw() {
  const frame = shown();
  if (!frame?.valid) computed = null;
  else if (computed === null || (frame !== computed.frame && (isFrozen() || isDue())) || computedAt < 0) {
    computed = compute(frame);
    computedAt = performance.now();
  }
  const canvas = byId("map-canvas");
  if (computed === null) canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
  else drawTo(canvas);
}

function drawTo(canvas) {
  if (computed.psf && options.view === "psf") {
    return drawPsf(canvas, computed.psf, { halfWidth: computed.halfWidth, log: options.log, palette: options.palette, text: (lambdas) => `${lambdas} \u03bb/D${onCamera(lambdas)}` });
  }
  if (computed.mtf) {
    const cycles = cutOff();
    return drawMtf(canvas, computed.mtf, { frequency: `frequency, D/\u03bb${cycles ? ` = ${brief(cycles)} cycles/mm on the camera` : ""}` });
  }
  const { waves, low, high } = computed;
  scale.take(Math.max(-low, high));
  const map = { values: waves.map(inUnit), size: MAP_PX, low: inUnit(low), high: inUnit(high), limit: inUnit(limitNow()) };
  return drawWavefront(canvas, map, { palette: options.palette, step: options.contours ? contourStep() : 0, unit: chosen.unit });
}

/** The figures of what is shown, as sentences. */
function lines() {
  const { frame, low, high, rms, strehl } = computed;
  const left = [options.tilt && "tilts", options.defocus && "defocus"].filter(Boolean).join(" and ");
  const defocus = options.defocus ? undefined : coefficientOf(frame)(DEFOCUS);
  const radius = defocus && bench?.pupilMm ? radiusOfCurvatureM(defocus, wavelengthNm(), bench.pupilMm) : null;
  const error = frame.sigma?.[frame.j.indexOf(DEFOCUS)] ?? LEAST_DEFOCUS;
  const curved = radius !== null && Math.abs(defocus) > 3 * error ? `, radius of curvature ${brief(radius)} m` : "";
  const text = [`Peak to valley ${brief(inUnit(high - low))} ${chosen.unit}, RMS ${inUnitText(rms)} ${chosen.unit}, Strehl ratio ${fixed(strehl, 3)}${curved}.`];
  if (left) text.push(`${left[0].toUpperCase()}${left.slice(1)} left out, by their coefficients.`);
  if (options.view === "psf") text.push(`Intensity relative to the peak without aberration. 1 \u03bb/D${onCamera(1)}.`);
  if (options.view === "mtf") text.push(`Contrast of a far field of the whole pupil.`);
  if (options.view === "wavefront" && options.contours) text.push(`Contours every ${brief(contourStep())} ${chosen.unit}.`);
  text.push("x points right, y down.");
  return text;
}

/** Updates texts and the label for screen readers; called twice per second. */
export function describe() {
  showControls();
  if (computed === null) {
    setText(byId("map-sub"), "");
    setText(byId("map-caption"), "No wavefront is being measured.");
    return;
  }
  const { frame } = computed;
  setText(byId("map-sub"), `${isFrozen() ? `frozen at ${timeOfDay(frame.t_arrival_ns)}, ` : ""}frame ${frame.frame_id}`);
  setText(byId("map-caption"), lines().join(" "));
  byId("map-canvas").setAttribute("aria-label", `${NAMES[options.view]}: ${lines()[0]}`);
}

function png() {
  const canvas = detached(...EXPORT_PX);
  drawTo(canvas);
  const { t_arrival_ns: at, frame_id: frame } = computed.frame;
  return pngOf([{ title: `${NAMES[options.view]}, ${new Date(at / 1e6).toISOString()}, frame ${frame}`, canvas }], lines());
}

const rowsOf = (values, side) => Array.from({ length: side }, (_, row) => values.subarray(row * side, (row + 1) * side));

function saveValues() {
  const { frame } = computed;
  const facts = { frame_id: frame.frame_id, time: new Date(frame.t_arrival_ns / 1e6).toISOString(), wavelength_nm: frame.wavelength_nm, orientation: "x right by columns, y down by rows" };
  if (options.tilt) facts.left_out_tilts = "yes";
  if (options.defocus) facts.left_out_defocus = "yes";
  if (computed.psf && options.view === "psf") {
    const { values, side } = cropped(computed.psf, computed.halfWidth);
    return saveCsv("psf", frame.t_arrival_ns, { ...facts, unit: "peak without aberration", pixels_per_lambda_D: PX_PER_LAMBDA_D, axis_pixel: side / 2 }, rowsOf(values, side));
  }
  if (computed.mtf) {
    const cycles = cutOff();
    const rows = computed.mtf.map(({ frequency, x, y, limit }) => [frequency, cycles && frequency * cycles, x, y, limit]);
    return saveCsv("mtf", frame.t_arrival_ns, facts, [["frequency_D_per_lambda", "frequency_cycles_per_mm", "mtf_x", "mtf_y", "mtf_without_aberration"], ...rows]);
  }
  return saveCsv("wavefront", frame.t_arrival_ns, { ...facts, unit: chosen.unit, pupil: `its circle touches the edges of ${MAP_PX} x ${MAP_PX} pixels` }, rowsOf(computed.waves.map(inUnit), MAP_PX));
}
