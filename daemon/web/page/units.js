// Units of wavefronts, and quantities that follow from coefficients. Coefficients are RMS-normalised waves by OSA/ANSI index.
import { rmsFactor } from "./zernike.js";

/** The units: how many make one wave at a wavelength in nm, and decimals that show 0.0001 wave. */
export const UNITS = {
  wave: { perWave: () => 1, digits: 4 },
  nm: { perWave: (wavelengthNm) => wavelengthNm, digits: 2 },
  rad: { perWave: () => 2 * Math.PI, digits: 4 },
};

/** The normalisations: factor from the RMS-normalised coefficient of mode j. */
export const NORMS = {
  rms: { title: "RMS", factor: () => 1 },
  unit: { title: "unit amplitude", factor: rmsFactor },
};

const X_TILT = 2, Y_TILT = 1, DEFOCUS = 4, ASTIGMATISM_45 = 3, ASTIGMATISM_0 = 5, COMA_X = 8, COMA_Y = 7, SPHERICAL = 12;
export const TILTS = [Y_TILT, X_TILT];
export { DEFOCUS };

/** Strehl ratio of a wavefront map in waves, without tilts: |mean of exp(2 pi i W)|^2 over the pupil. */
export function strehlOf(map) {
  let [re, im, count] = [0, 0, 0];
  for (const waves of map) {
    if (Number.isNaN(waves)) continue;
    re += Math.cos(2 * Math.PI * waves);
    im += Math.sin(2 * Math.PI * waves);
    count += 1;
  }
  return count ? (re * re + im * im) / count ** 2 : null;
}

/**
 * Radius of curvature of the wavefront at the pupil, m, from its defocus; positive if positive waves rise towards the pupil's edge.
 * The defocus c sqrt(3) (2 rho^2 - 1) bends like 2 sqrt(3) c rho^2, a sphere's sag like (a rho)^2 / 2R: R = a^2 / (4 sqrt(3) c), with
 * the pupil's radius a (1/R is the vergence M of L. N. Thibos et al., J. Vision 4(4):9, 2004, with opposite sign).
 */
export function radiusOfCurvatureM(defocusWaves, wavelengthNm, pupilMm) {
  const radius = pupilMm * 0.5e-3;
  return radius ** 2 / (4 * Math.sqrt(3) * defocusWaves * wavelengthNm * 1e-9);
}

const degrees = (rad) => (rad * 180) / Math.PI;
/** An angle in [0, period) degrees; rounding may not give `period` itself. */
const wrapped = (angle, period) => {
  const inside = ((angle % period) + period) % period;
  return inside > period - 1e-9 ? 0 : inside;
};

/**
 * Sphere and cylinder (dioptres, minus cylinder) and axis (degrees from +x towards +y) of the lens that corrects the wavefront:
 * M = -4 sqrt(3) c4 / a^2, J0 = -2 sqrt(6) c5 / a^2, J45 = -2 sqrt(6) c3 / a^2, coefficients in um, pupil radius a in mm
 * (L. N. Thibos et al., "Accuracy and precision of objective refraction from wavefront aberrations", J. Vision 4(4):9, 2004).
 * `of`: coefficient of mode j in waves, undefined if it is not measured. Null if a mode is missing.
 */
export function refraction(of, wavelengthNm, pupilMm) {
  const [defocus, straight, oblique] = [DEFOCUS, ASTIGMATISM_0, ASTIGMATISM_45].map((j) => (of(j) * wavelengthNm * 1e-3) / (pupilMm / 2) ** 2);
  const mean = -4 * Math.sqrt(3) * defocus;
  const cross = [-2 * Math.sqrt(6) * straight, -2 * Math.sqrt(6) * oblique];
  const size = Math.hypot(...cross);
  if (Number.isNaN(mean + size)) return null;
  return { sphereD: mean + size, cylinderD: -2 * size, axisDeg: wrapped(degrees(Math.atan2(cross[1], cross[0])) / 2, 180) };
}

/**
 * Seidel terms of the third-order modes: [{name, waves, angleDeg}], angle null where there is none, waves null if a mode is missing.
 * W = tilt rho cos(theta - a) + focus rho^2 + astigmatism rho^2 cos^2(theta - a) + coma rho^3 cos(theta - a) + spherical rho^4.
 * Of the two signs of the astigmatism, the one with the smaller focus is taken
 * (J. C. Wyant, K. Creath, "Basic wavefront aberration theory for optical metrology", Appl. Optics and Optical Eng. XI, 1992).
 */
export function seidel(of) {
  const unit = (j) => of(j) * rmsFactor(j);
  const vector = (x, y) => ({ size: Math.hypot(x, y), angle: degrees(Math.atan2(y, x)) });
  const tilt = vector(unit(X_TILT) - 2 * unit(COMA_X), unit(Y_TILT) - 2 * unit(COMA_Y));
  const astigmatism = vector(unit(ASTIGMATISM_0), unit(ASTIGMATISM_45));
  const coma = vector(unit(COMA_X), unit(COMA_Y));
  const focus = 2 * unit(DEFOCUS) - 6 * unit(SPHERICAL);
  const sign = focus > 0 ? -1 : 1; // of the astigmatism's part in the focus
  const terms = [
    ["tilt", tilt.size, wrapped(tilt.angle, 360)],
    ["focus", focus + sign * astigmatism.size, null],
    ["astigmatism", -sign * 2 * astigmatism.size, wrapped(astigmatism.angle / 2 + (sign < 0 ? 0 : 90), 180)],
    ["coma", 3 * coma.size, wrapped(coma.angle, 360)],
    ["spherical", 6 * unit(SPHERICAL), null],
  ];
  return terms.map(([name, waves, angleDeg]) => (Number.isNaN(waves) ? { name, waves: null, angleDeg: null } : { name, waves, angleDeg }));
}
