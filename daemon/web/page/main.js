// The page: dispatches messages to the views and redraws changed views in the next animation frame.
import * as aberration from "./aberration.js";
import * as bench from "./bench.js";
import * as camera from "./camera.js";
import * as events from "./events.js";
import * as figures from "./figures.js";
import { byId, element, setText } from "./format.js";
import * as history from "./history.js";
import { listen } from "./link.js";
import * as map from "./map.js";
import * as modes from "./modes.js";
import * as record from "./record.js";
import * as slm from "./slm.js";
import { chooseTheme } from "./theme.js";
import * as trends from "./trends.js";
import { forgetErrors } from "./widgets.js";

const dirty = new Set();
const STALE_MS = 1500;
const DESCRIBE_MS = 500;
let wavefront = null;
let status = null;
let lastFrame = { wavefront: 0, image: 0, phase: 0 };
let newestBench = null;
let modeNames = "";
let right = "look";
let clockOffset = null; // ms: upper limit of this computer's clock minus the server's
const CLOCKS_AGREE_MS = 100;

const takers = {
  "ovws.wavefront/1": (message) => {
    wavefront = message;
    lastFrame.wavefront = performance.now();
    dirty.add("wavefront");
  },
  "ovws.image/1": (message, binary) => {
    lastFrame.image = performance.now();
    camera.takeImage(message, binary);
    dirty.add("camera");
  },
  "ovws.spots/1": (message, binary) => {
    camera.takeSpots(message, binary);
    dirty.add("camera");
  },
  "ovws.phase/1": (message, binary) => {
    lastFrame.phase = performance.now();
    map.takePhase(message, binary);
    dirty.add("map");
  },
  "ovws.status/1": (message) => {
    status = message;
    slm.takeStatus(message);
    record.takeStatus(message);
    forgetErrors(whatRefusalsRestOn());
  },
  "ovws.event/1": events.takeEvent,
  "ovws.web.hello/1": takeHello,
  "ovws.web.trend/1": (bin) => {
    history.takeTrend(bin);
    figures.takeTrend(bin);
    dirty.add("trends");
  },
  "ovws.web.health/1": takeHealth,
  "ovws.web.bench/1": takeBench,
};

/** The state that refusals may depend on, as text. When it changes, displayed errors may be outdated. */
function whatRefusalsRestOn() {
  const { camera: device, sensor, aberration: introduced, reference, loop } = newestBench ?? {};
  const devices = [status?.state, status?.camera.connected, status?.slm.connected, status?.slm.pattern, status?.record.state];
  const chosen = [sensor?.charge, sensor?.tracker, sensor?.operator_in_force, sensor?.subapertures];
  return JSON.stringify([devices, chosen, device?.settings, introduced?.modes, reference, loop?.closed]);
}

function takeBench(message) {
  newestBench = message;
  const names = message.sensor.mode_names.map((mode) => mode.j).join();
  if (names !== modeNames) modes.takeNames(message.sensor.mode_names);
  modeNames = names;
  camera.takeRing(message.sensor.ring_px);
  bench.takeBench(message);
  aberration.takeBench(message);
  slm.takeBench(message, status?.slm.pattern);
  forgetErrors(whatRefusalsRestOn());
}

function showVerdict(wellness, text, others = []) {
  const verdict = byId("verdict");
  verdict.dataset.wellness = wellness;
  setText(verdict.querySelector("p"), text);
  document.title = wellness === "good" ? "ovws" : `ovws: ${text}`;
  const list = byId("findings");
  if (list.children.length !== others.length) list.replaceChildren(...others.map(() => element("li")));
  others.forEach((finding, i) => {
    list.children[i].dataset.wellness = finding.wellness;
    setText(list.children[i], finding.text);
  });
}

function takeHealth({ findings, t_ns: sent, browsers, refused }) {
  const offset = Date.now() - sent / 1e6;
  clockOffset = clockOffset === null ? offset : Math.min(clockOffset, offset);
  const [worst, ...others] = findings;
  if (worst) showVerdict(worst.wellness, worst.text, others);
  dirty.add("trends"); // the time axis moves, with frames or without
  const count = Object.values(refused).reduce((sum, n) => sum + n, 0);
  setText(byId("foot"), `${browsers} ${browsers === 1 ? "browser" : "browsers"} connected, ${count} ${count === 1 ? "request" : "requests"} refused`);
}

function takeState(reason) {
  if (reason) showVerdict("bad", reason);
  document.body.classList.toggle("cut", reason !== "");
}

/** Covers a view whose data are stale. */
function veil(section, since, now) {
  const age = now - since;
  const target = document.querySelector(`#${section} .veil`);
  const stale = since > 0 && age > STALE_MS;
  target.hidden = !stale && since > 0;
  if (stale) setText(target, `No new data for ${Math.round(age / 1000)} s`);
  else if (since === 0) setText(target, "Waiting for the first image");
  byId(section).classList.toggle("stale", stale);
}

function describe() {
  const now = performance.now();
  veil("camera", lastFrame.image, now);
  veil("map", lastFrame.phase, now);
  const stale = now - lastFrame.wavefront > STALE_MS;
  for (const id of ["figures", "modes"]) byId(id).classList.toggle("stale", stale);
  camera.describe();
  map.describe();
  trends.describe();
  const ahead = Math.abs(clockOffset) < CLOCKS_AGREE_MS ? 0 : clockOffset;
  if (wavefront && !stale) figures.takeAge(Date.now() - wavefront.t_arrival_ns / 1e6 - ahead);
  else figures.takeAge(null);
}

function drawAll(now) {
  if (dirty.has("wavefront")) {
    modes.takeWavefront(wavefront);
    figures.takeWavefront(wavefront);
  }
  if (dirty.has("camera")) camera.draw(now);
  if (dirty.has("map")) map.draw();
  if (dirty.has("trends")) {
    trends.draw();
    modes.draw();
  }
  dirty.clear();
  requestAnimationFrame(drawAll);
}

const redraw = () => ["camera", "map", "trends"].forEach((view) => dirty.add(view));

/** Handles the first message of each connection; rebuilds controls only if the rights changed. */
function takeHello({ right: given }) {
  if (given !== right) build(given === "control");
  right = given;
}

function build(mayControl) {
  setText(byId("role"), mayControl ? "control enabled" : "view only");
  for (const view of [bench, aberration, slm, record]) view.build(mayControl);
}

figures.build();
trends.build(document.querySelector("#trends .charts"));
build(false);
chooseTheme(redraw);
new ResizeObserver(redraw).observe(document.body);
for (const box of document.querySelectorAll("#camera .switches input")) {
  box.addEventListener("change", () => {
    camera.repaint();
    dirty.add("camera");
  });
}
addEventListener("hashchange", () => location.reload());
listen((json, binary) => takers[json.schema]?.(json, binary), takeState);
requestAnimationFrame(drawAll);
setInterval(describe, DESCRIBE_MS); // not in drawAll: stale data must show even when nothing is drawn
