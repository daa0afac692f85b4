// The page: dispatches messages to the views and redraws changed views in the next animation frame.
import * as aberration from "./aberration.js";
import * as alarm from "./alarm.js";
import * as bar from "./bar.js";
import * as bench from "./bench.js";
import * as camera from "./camera.js";
import { onChosen } from "./chosen.js";
import * as derived from "./derived.js";
import * as events from "./events.js";
import * as figures from "./figures.js";
import { allowRemedies, showAgain, showFindings } from "./findings.js";
import { byId, setText } from "./format.js";
import * as frame from "./frame.js";
import * as history from "./history.js";
import { listen } from "./link.js";
import * as loop from "./loop.js";
import * as map from "./map.js";
import * as marks from "./marks.js";
import * as modes from "./modes.js";
import * as panels from "./panels.js";
import * as procedures from "./procedures.js";
import * as record from "./record.js";
import * as recordings from "./recordings.js";
import * as rights from "./rights.js";
import * as saved from "./saved.js";
import * as slm from "./slm.js";
import { chooseTheme } from "./theme.js";
import * as trends from "./trends.js";
import { forgetErrors } from "./widgets.js";

const dirty = new Set();
const STALE_MS = 1500;
const DESCRIBE_MS = 500;
const NUMBERS_MS = 100; // faster than anyone reads; each time the browser lays out the page
let numbersAt = -NUMBERS_MS;
let wavefront = null;
let status = null;
let lastFrame = { wavefront: 0, image: 0 };
let newestBench = null; // without it the limits of controls are unknown
let modeNames = "";
let right = "look";
const SILENT_MS = 3000; // the daemon sends its status once per second
let statusAt = 0;
let cut = "Connecting"; // why there is no connection; empty if there is one
let lack = null; // what was told last
const BACKLOG_MS = 1500; // after which the bins of the past have come
let connectedAt = 0;
let clockOffset = null; // ms: upper limit of this computer's clock minus the server's
const CLOCKS_AGREE_MS = 100;

const takers = {
  "ovws.wavefront/1": (message) => {
    wavefront = message;
    frame.take(message);
    lastFrame.wavefront = performance.now();
    dirty.add("wavefront");
    if (map.isDue()) dirty.add("map");
  },
  "ovws.image/1": (message, binary) => {
    lastFrame.image = performance.now();
    camera.takeImage(message, binary);
    dirty.add("camera");
  },
  "ovws.spots/1": (message, binary) => {
    camera.takeSpots(binary);
    dirty.add("camera");
  },
  "ovws.status/1": (message) => {
    status = message;
    statusAt = performance.now();
    takeLack();
    slm.takeStatus(message);
    for (const view of [record, recordings, bar, procedures, loop, saved]) view.takeStatus(message);
    forgetErrors(whatRefusalsRestOn());
  },
  "ovws.event/1": (event) => {
    events.takeEvent(event);
    marks.takeEvent(event);
    procedures.takeEvent(event);
  },
  "ovws.web.hello/1": takeHello,
  "ovws.web.trend/1": (bin) => {
    history.takeTrend(bin);
    figures.takeTrend(bin);
    alarm.takeTrend(bin, performance.now() - connectedAt > BACKLOG_MS);
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
  const isFirst = newestBench === null;
  newestBench = message;
  rights.takeBench(message);
  const names = message.sensor.mode_names.map((mode) => mode.j).join();
  if (names !== modeNames) modes.takeNames(message.sensor.mode_names);
  modeNames = names;
  camera.takeBench(message);
  aberration.takeBench(message);
  for (const view of [bench, bar, procedures, loop, saved, record]) view.takeBench(message);
  showAgain();
  map.takeBench(message);
  derived.takeBench(message);
  slm.takeBench(message);
  forgetErrors(whatRefusalsRestOn());
  if (isFirst) takeState("");
}

/** Whether something can be changed now: not without the bench, and not while the daemon is silent. */
function takeLack() {
  const isSilent = status !== null && performance.now() - statusAt > SILENT_MS;
  const now = cut ? "Not connected to ovws-web." : newestBench === null ? "Waiting for ovwsd." : isSilent ? "The daemon is silent." : "";
  if (now === lack) return;
  lack = now;
  rights.setLack(now);
  takeRight();
}

function takeHealth({ findings, t_ns: sent, browsers, refused }) {
  const offset = Date.now() - sent / 1e6;
  clockOffset = clockOffset === null ? offset : Math.min(clockOffset, offset);
  if (findings.length) showFindings(alarm.withAlarm(findings));
  dirty.add("trends"); // the time axis moves, with frames or without
  const count = Object.values(refused).reduce((sum, n) => sum + n, 0);
  setText(byId("foot"), `${browsers} ${browsers === 1 ? "browser" : "browsers"} connected, ${count} ${count === 1 ? "request" : "requests"} refused`);
}

function takeState(reason) {
  if (reason) showFindings([{ wellness: "bad", text: reason }]);
  cut = reason;
  takeLack();
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
  takeLack();
  veil("camera", lastFrame.image, now);
  veil("map", frame.isFrozen() ? now : lastFrame.wavefront, now);
  const stale = now - lastFrame.wavefront > STALE_MS;
  for (const id of ["figures", "bar-now"]) byId(id).classList.toggle("stale", stale);
  byId("modes").classList.toggle("stale", stale && !frame.isFrozen());
  camera.describe();
  map.describe();
  trends.describe();
  const ahead = Math.abs(clockOffset) < CLOCKS_AGREE_MS ? 0 : clockOffset;
  if (wavefront && !stale) figures.takeAge(Date.now() - wavefront.t_arrival_ns / 1e6 - ahead);
  else figures.takeAge(null);
}

function drawNumbers() {
  if (dirty.delete("wavefront") && wavefront) {
    modes.showFrame();
    figures.takeWavefront(wavefront);
  }
  if (dirty.delete("trends")) {
    trends.draw();
    modes.draw();
  }
}

function drawAll(now) {
  if (now - numbersAt >= NUMBERS_MS && (dirty.has("wavefront") || dirty.has("trends"))) {
    numbersAt = now;
    drawNumbers();
  }
  if (dirty.delete("camera")) camera.draw(now);
  if (dirty.delete("map")) map.draw();
  requestAnimationFrame(drawAll);
}

const redraw = () => ["wavefront", "camera", "map", "trends"].forEach((view) => dirty.add(view));

/** Enables or disables everything that changes the bench. */
function takeRight() {
  bar.takeRight();
  camera.takeRight();
  for (const view of [procedures, loop, saved]) view.takeRight();
  allowRemedies();
}

/** Handles the first message of each connection; rebuilds controls only if the rights changed. */
function takeHello({ right: given }) {
  if (given !== right) build(given === "control");
  right = given;
  connectedAt = performance.now();
  clockOffset = null; // a clock may have been set
  rights.setRight(given);
  takeRight();
}

function build(mayControl) {
  setText(byId("role"), mayControl ? "control enabled" : "view only");
  for (const view of [bench, aberration, slm, record, procedures, loop, saved]) view.build(mayControl);
}

figures.build();
map.build(redraw);
modes.build(redraw);
trends.build(byId("trends"), redraw);
frame.onFreeze(redraw);
onChosen(() => {
  if (newestBench) takeBench(newestBench); // its texts have units
  redraw();
});
bar.build();
camera.build(() => dirty.add("camera"));
build(false);
recordings.build();
panels.build();
chooseTheme(redraw);
new ResizeObserver(redraw).observe(document.body);
byId("commission").href += location.hash; // which holds the token
addEventListener("hashchange", () => location.reload());
listen((json, binary) => takers[json.schema]?.(json, binary), takeState);
requestAnimationFrame(drawAll);
setInterval(describe, DESCRIBE_MS); // not in drawAll: stale data must show even when nothing is drawn
