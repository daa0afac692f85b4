// The camera panel: the image with the spots, and the tools to look at it.
import * as image from "./camera_image.js";
import { arrowMagnification, drawSpots } from "./camera_marks.js";
import { SCALES } from "./camera_scale.js";
import { buildTools } from "./camera_tools.js";
import { CameraView } from "./camera_view.js";
import { begin } from "./canvas.js";
import { remember, remembered } from "./chosen.js";
import { css } from "./colour.js";
import * as crosshair from "./crosshair.js";
import { brief, byId, setText, timeOfDay } from "./format.js";
import { isFrozen } from "./frame.js";
import * as histogram from "./histogram.js";
import * as profile from "./profile.js";
import * as region from "./region.js";
import { fillTable, peaks, spots, summary, takeSpots as take } from "./spots.js";

let ringPx = null;
let settings = null; // of the camera
let view = null;
let tools = null; // {mode, choose}
let redraw = () => {};

const shown = (id) => byId(`show-${id}`).checked;

export function takeImage(json, binary) {
  if (!isFrozen()) image.take(json, binary);
}

export function takeSpots(binary) {
  if (!isFrozen()) take(binary);
}

export function takeBench({ camera, sensor }) {
  ringPx = sensor.ring_px;
  settings = camera.settings;
  region.takeCamera(camera);
}

export const takeRight = () => region.takeRight();

function onKey(event) {
  if (event.key === "Escape" && tools.mode !== "pan") tools.choose("pan");
  else if (!crosshair.onKey(event, view.centre)) return false;
  redraw();
  return true;
}

/** Gives the canvas the height that the banner, the bar and the figures leave: the panel stays in one view with the bar. */
function fitHeight() {
  const main = byId("views");
  const observer = new ResizeObserver(() => {
    main.style.setProperty("--above", `${main.offsetTop}px`);
    redraw();
  });
  for (const above of document.querySelectorAll("header, #bar, #figures")) observer.observe(above);
}

/** `requestDraw`: asks for a call of draw. */
export function build(requestDraw) {
  redraw = requestDraw;
  fitHeight();
  byId("camera-scale").append(...Object.entries(SCALES).map(([name, { title }]) => new Option(title, name)));
  byId("camera-scale").value = remembered("camera-scale", "grey", (name) => name in SCALES);
  view = new CameraView(byId("camera-canvas"), {
    onChange: redraw,
    onPoint: (at) => {
      crosshair.point(at);
      crosshair.showValue(settings?.roi);
    },
    onClick: (at) => {
      crosshair.toggle(at);
      redraw();
    },
    onKey,
    tool: () => ({ profile: profile.tool, region: region.tool })[tools?.mode] ?? null,
  });
  tools = buildTools(view, () => {
    if (tools.mode === "profile") profile.start(view.part);
    byId("profile").hidden = tools.mode !== "profile";
    redraw();
  });
  profile.setOnChange(redraw);
  region.build(byId("region"), { onChange: redraw, onEnd: () => tools.choose("pan") });
  for (const box of document.querySelectorAll("#camera .switches :is(input, select)")) box.addEventListener("change", redraw);
  byId("camera-scale").addEventListener("change", () => remember("camera-scale", byId("camera-scale").value));
  byId("histogram").addEventListener("toggle", redraw);
}

/** Fetches the part in view at full resolution if one reduced pixel covers more than one pixel of the screen. */
function refine() {
  const screenPixels = view.zoom * image.info().step * (window.devicePixelRatio || 1);
  if (!isFrozen() && screenPixels > 1.01) image.refine(view.part, redraw);
}

export function draw(now) {
  const canvas = byId("camera-canvas");
  const info = image.info();
  if (info) {
    canvas.style.aspectRatio = `${info.width} / ${info.height}`;
    view.setSize(info.width, info.height);
  }
  const { context, width, height } = begin(canvas);
  if (!info || width === 0) return;
  const scale = byId("camera-scale").value;
  refine();
  image.draw(context, scale, shown("dim"), view.place);
  document.querySelector(".key.saturated").style.background = css(SCALES[scale].saturated);
  const magnification = arrowMagnification(spots, now);
  setText(byId("arrow-scale"), magnification === 1 ? "displacement" : `displacement \u00d7 ${magnification}`);
  drawSpots(context, spots, { place: view.place, zoom: view.zoom, ringPx, marks: shown("marks"), regions: shown("regions") });
  crosshair.draw(context, view, width, height);
  if (tools.mode === "profile") {
    profile.drawLine(context, view.place);
    profile.drawGraph(image.valueAt, info.full);
  }
  if (tools.mode === "region") region.draw(context, view.place);
  if (byId("histogram").open) histogram.draw(info, scale);
  crosshair.showValue(settings?.roi);
}

/** What the badge on the picture says: that it is frozen, or coarser than the camera's. */
function badgeText(info) {
  const frozen = isFrozen() ? `Frozen: frame ${info.frameId}, ${timeOfDay(info.at)}` : "";
  const reduced = image.isWhole() ? "" : `reduced by ${info.step}${isFrozen() ? "" : "; zoom in for all pixels"}`;
  return [frozen, reduced].filter(Boolean).join(", ");
}

/** Updates texts, table and the label for screen readers; called twice per second. */
export function describe() {
  const info = image.info();
  if (info) {
    const zoom = view.isFitted ? "" : `, ${brief(view.zoom)} \u00d7`;
    setText(byId("camera-sub"), `${info.width} \u00d7 ${info.height} px, ${info.format}, frame ${info.frameId}${zoom}`);
    histogram.describe(info, peaks());
    const badge = badgeText(info);
    byId("camera-badge").hidden = badge === "";
    setText(byId("camera-badge"), badge);
  }
  byId("camera-canvas").setAttribute("aria-label", `Camera image: ${summary()}`);
  if (byId("spots").open) fillTable();
}
