// The page Commission: shows the steps that ovws-web conducts, and sends the actions on them.
import { byId, element, setText } from "./format.js";
import { act, commission, picture } from "./link.js";
import { setLack, setRight, whyNot } from "./rights.js";
import { chooseTheme } from "./theme.js";

const BUSY_MS = 300; // between looks at what runs
const IDLE_MS = 1500;
const STATES = { open: "open", done: "done", skipped: "skipped", failed: "failed" };

let report = null;
let chosen = ""; // the step that is shown
let following = true; // shows the step that runs, or the first that is not done
let shownPicture = "";
let timer = 0;
let opened = false; // whether the large button was shown

const isPast = (step) => step.state === "done" || step.state === "skipped";
const stepOf = (name) => report.steps.find((step) => step.name === name);
const nextAfter = (step) => report.steps.slice(report.steps.indexOf(step) + 1).find((other) => !isPast(other)) ?? report.steps.find((other) => !isPast(other));

function choose(name) {
  chosen = name;
  following = false;
  setText(byId("error"), "");
  show();
}

/** What the large button does: {text, go}; null if there is nothing left. */
function primaryOf(step) {
  if (step.state === "failed" && step.offers.length > 0) {
    const [offer] = step.offers;
    return { text: offer.text, go: () => send("offer", step.name, offer.name) };
  }
  if (step.state === "failed") return { text: "Repeat", go: () => send("run", step.name) };
  if (!isPast(step)) return { text: "Run this step", go: () => send("run", step.name) };
  const next = nextAfter(step);
  return next ? { text: `Next: ${next.title}`, go: () => choose(next.name), looks: true } : null;
}

async function send(action, step = "", offer = "") {
  const reply = await act(action, step, offer);
  const reason = reply.error?.data.reason ?? "";
  setText(byId("error"), reason);
  if (reply.result) take({ ...reply.result, right: report.right });
  schedule(0);
}

function showSteps() {
  const list = byId("steps");
  if (list.children.length !== report.steps.length) {
    list.replaceChildren(...report.steps.map((step, i) => {
      const button = element("button");
      button.type = "button";
      button.append(element("span", "state"), element("span", "number", `${i + 1}`), element("span", "name", step.title), element("span", "hidden"));
      button.addEventListener("click", () => choose(step.name));
      const item = element("li");
      item.append(button);
      return item;
    }));
  }
  report.steps.forEach((step, i) => {
    const button = list.children[i].firstChild;
    const state = report.running?.step === step.name ? "running" : step.state;
    button.dataset.state = state;
    if (step.name === chosen) button.setAttribute("aria-current", "step");
    else button.removeAttribute("aria-current");
    setText(button.lastChild, `, ${STATES[state] ?? "running"}`);
  });
  setText(byId("done"), `${report.steps.filter(isPast).length} of ${report.steps.length} done`);
}

async function showPicture(step) {
  const wanted = step.picture === null ? "" : `${step.name} ${step.picture}`;
  if (wanted === shownPicture) return;
  shownPicture = wanted;
  byId("figure").hidden = true;
  if (!wanted) return;
  const image = byId("picture");
  image.alt = `Picture of the step ${step.title}`;
  const blob = await picture(`/commission/picture?step=${step.name}`);
  if (wanted !== shownPicture) return;
  if (!blob) {
    shownPicture = ""; // asked for again with the next report
    return;
  }
  byId("figure").hidden = false;
  URL.revokeObjectURL(image.src);
  image.src = URL.createObjectURL(blob);
}

function showVerdict(step) {
  const box = byId("verdict");
  box.hidden = step.verdict === null;
  if (step.verdict) {
    box.dataset.wellness = step.verdict.wellness;
    setText(box.querySelector("p"), step.verdict.text);
  }
  setText(byId("advice"), step.verdict?.advice ?? "");
}

/** Gives the large button the focus when it first appears, so that Enter is enough, unless the user has put it elsewhere. */
function focusPrimary() {
  const button = byId("primary");
  opened = !button.hidden;
  if (opened && document.activeElement === document.body) button.focus({ preventScroll: true });
}

/** Disables a button without taking the focus from it. */
function enable(button, can) {
  button.setAttribute("aria-disabled", String(!can));
}

function showOffers(step, can) {
  const others = step.state === "failed" ? step.offers.slice(1) : step.offers;
  const list = byId("offers");
  if (list.dataset.shown !== JSON.stringify([step.name, others])) {
    list.dataset.shown = JSON.stringify([step.name, others]);
    list.replaceChildren(...others.map((offer) => {
      const button = element("button", "", offer.text);
      button.type = "button";
      button.dataset.offer = offer.name;
      listen(button, () => send("offer", step.name, offer.name));
      const item = element("li");
      item.append(button);
      return item;
    }));
  }
  for (const button of list.querySelectorAll("button")) enable(button, can);
}

function showActions(step, busy) {
  const can = !busy && whyNot() === "";
  const primary = primaryOf(step);
  const button = byId("primary");
  button.hidden = primary === null && !busy;
  if (primary) setText(button, primary.text);
  enable(button, primary?.looks ? !busy : can);
  showOffers(step, can);
  byId("repeat").hidden = step.state !== "done" && !(step.state === "failed" && step.offers.length > 0);
  byId("skip").hidden = isPast(step);
  byId("undo").hidden = !step.can_undo;
  for (const id of ["repeat", "skip", "undo"]) enable(byId(id), can);
  byId("cancel").hidden = !busy;
  enable(byId("cancel"), whyNot() === "");
  setText(byId("why"), whyNot());
}

function showRunning(step) {
  const running = report.running?.step ? report.running : null;
  const bar = byId("progress");
  bar.hidden = running === null;
  bar.value = running?.progress ?? 0;
  const where = running && running.step !== step.name ? `${stepOf(running.step).title}: ` : "";
  setText(byId("doing"), running ? where + running.text : "");
}

function show() {
  if (!report) return;
  if (following) chosen = report.running?.step || (report.steps.find((step) => !isPast(step)) ?? report.steps.at(-1)).name;
  const step = stepOf(chosen);
  showSteps();
  setText(byId("title"), `${report.steps.indexOf(step) + 1}. ${step.title}`);
  setText(byId("purpose"), step.purpose);
  showRunning(step);
  showVerdict(step);
  showPicture(step);
  showActions(step, report.running !== null);
  if (!opened) focusPrimary();
  byId("end").hidden = !report.steps.every(isPast);
  setText(byId("role"), report.right === "control" ? "control enabled" : "view only");
}

function take(given) {
  const before = report?.running?.step;
  report = given;
  setRight(given.right);
  setLack("");
  if (report.running?.step && report.running.step !== before) {
    chosen = report.running.step; // also of another browser
    following = false;
  }
  show();
}

async function refresh() {
  const given = await commission();
  if (given?.steps) take(given);
  else {
    setLack(given?.reason ?? "No connection to ovws-web: reconnecting");
    if (report) show();
    else setText(byId("why"), whyNot());
  }
  schedule(report?.running ? BUSY_MS : IDLE_MS);
}

function schedule(after) {
  clearTimeout(timer);
  timer = setTimeout(refresh, after);
}

function listen(button, action) {
  button.addEventListener("click", () => {
    if (button.getAttribute("aria-disabled") !== "true") action();
  });
}

listen(byId("primary"), () => primaryOf(stepOf(chosen))?.go());
listen(byId("repeat"), () => send("run", chosen));
for (const action of ["skip", "undo", "cancel"]) listen(byId(action), () => send(action, chosen));
byId("live").href = `/${location.hash}`;
addEventListener("hashchange", () => location.reload());
chooseTheme(() => {});
refresh().then(() => report?.right === "control" && !report.running && send("look"));
