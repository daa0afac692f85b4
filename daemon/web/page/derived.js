// Terms that follow from the coefficients: Seidel terms, and the sphere, cylinder and axis of the lens that corrects them.
import { chosen, inUnit, signedText, wavelengthNm } from "./chosen.js";
import { coefficientOf } from "./frame.js";
import { element, fixed, NONE, setText, signed } from "./format.js";
import { refraction, seidel } from "./units.js";

let pupilMm = null;
const cells = new Map(); // name -> {value, angle}
let box = null;

const SEIDEL = ["tilt", "focus", "astigmatism", "coma", "spherical"];
const LENS = ["sphere", "cylinder"];

/** Adds the table, folded, at the end of a section. */
export function build(section) {
  box = element("details", "derived");
  box.append(element("summary", "", "Seidel terms, sphere and cylinder"));
  const table = element("table");
  const head = table.createTHead().insertRow();
  for (const title of ["term", "magnitude", "angle"]) {
    const cell = element("th", title === "term" ? "" : "number", title);
    cell.scope = "col";
    head.append(cell);
  }
  const body = table.createTBody();
  for (const name of [...SEIDEL, ...LENS]) {
    const row = body.insertRow();
    row.dataset.term = name;
    const title = element("th", "", SEIDEL.includes(name) ? `Seidel ${name}` : name);
    title.scope = "row";
    const [value, angle] = [element("td", "number"), element("td", "number")];
    row.append(title, value, angle);
    cells.set(name, { value, angle });
  }
  box.append(table, element("p", "help"));
  section.append(box);
}

export function takeBench({ sensor }) {
  pupilMm = sensor.pupil_mm ?? null;
}

function termsOf(message) {
  const of = coefficientOf(message);
  return { terms: message.valid ? seidel(of) : [], lens: message.valid && pupilMm ? refraction(of, wavelengthNm(), pupilMm) : null };
}

/** An angle in [0, period) degrees; 359.97 rounds to 0. */
const angleText = (degrees, period) => (degrees === null ? "" : `${fixed(Number(degrees.toFixed(1)) % period, 1)}\u00b0`);

export function show(message) {
  if (!box.open) return;
  const { terms, lens } = termsOf(message);
  for (const name of SEIDEL) {
    const term = terms.find((one) => one.name === name);
    setText(cells.get(name).value, term?.waves == null ? NONE : `${signedText(term.waves)} ${chosen.unit}`);
    setText(cells.get(name).angle, angleText(term?.angleDeg ?? null, name === "astigmatism" ? 180 : 360));
  }
  setText(cells.get("sphere").value, lens ? `${signed(lens.sphereD, 4)} D` : NONE);
  setText(cells.get("cylinder").value, lens ? `${signed(lens.cylinderD, 4)} D` : NONE);
  setText(cells.get("cylinder").angle, angleText(lens?.axisDeg ?? null, 180));
  const pupil = pupilMm ? `of the lens that corrects, for the pupil of ${fixed(pupilMm, 2)} mm on the SLM` : "for an unknown pupil";
  setText(box.querySelector(".help"), `Sphere and cylinder ${pupil}. Angles from +x towards +y, which points down.`);
}

/** The terms for the head of an exported file. */
export function facts(message) {
  const { terms, lens } = termsOf(message);
  const found = {};
  for (const { name, waves, angleDeg } of terms) {
    if (waves !== null) found[`seidel_${name}_${chosen.unit}`] = `${inUnit(waves)}${angleDeg === null ? "" : ` at ${angleDeg} deg`}`;
  }
  if (lens) Object.assign(found, { sphere_D: lens.sphereD, cylinder_D: lens.cylinderD, axis_deg: lens.axisDeg, pupil_mm: pupilMm });
  return found;
}
