// Registration, look-up table, settle time, flatness and calibration: what is active, how to measure it again, and its result.
import { brief, byId, dayAndTime, element, grouped, setText } from "./format.js";
import { confirmButton } from "./confirm.js";
import { JobButton } from "./jobs.js";
import { call } from "./link.js";
import { paramFields, paramsOf } from "./params.js";
import { PROCEDURES } from "./procedure_table.js";
import { whyLoop, whyNot } from "./rights.js";
import { button, field, reasonOf } from "./widgets.js";

let made = null; // the procedures of the page
let status = null;
const asked = new Set(); // jobs that were asked for

/** Asks the daemon: the status may be older than what a click depends on. Without an answer: yes. */
async function hasReferenceOrCalibration() {
  const [reference, calibration] = await Promise.all([call("reference.get"), call("calibration.get")]);
  return (reference.result?.taken ?? true) || (calibration.result?.calibrated ?? true);
}

class Procedure {
  #row;
  #method;
  #state = element("span", "state");
  #text = element("p", "result");
  #controls = element("div", "params");
  #frame = null;
  #job = null;
  #clear = null;
  #inputs = [];
  #report = null;

  constructor(parent, row) {
    this.#row = row;
    this.#method = row.method ?? `${row.name}.run`;
    const details = element("details", "procedure");
    details.id = `procedure-${row.name}`;
    const summary = element("summary");
    summary.append(element("span", "title", row.title), this.#state);
    this.#text.setAttribute("role", "status");
    details.append(summary, this.#text, this.#controls);
    parent.append(details);
  }

  get isKnown() {
    return this.#report !== null && this.#row.isKnown(this.#report);
  }

  get method() {
    return this.#method;
  }

  build(mayControl) {
    this.#controls.replaceChildren();
    this.#frame = this.#job = this.#clear = null;
    if (!mayControl) return;
    const { given, inputs } = paramFields(this.#controls, this.#method, this.#row.params);
    this.#inputs = inputs;
    this.#frame = field(this.#controls, "Measurement");
    this.#job = new JobButton(this.#frame, "Run", this.#method, {
      params: given,
      question: this.#row.endangers && (async () => ((await hasReferenceOrCalibration()) ? this.#row.endangers : "")),
      onDone: (result) => {
        const before = this.#report;
        this.show(result);
        return this.#row.doneText?.(before, result);
      },
    });
    this.#job.button.id = this.#frame.id;
    this.#job.button.setAttribute("aria-label", `Run: ${this.#row.title}`);
    this.#job.button.setAttribute("aria-describedby", this.#frame.describedBy);
    if (this.#row.lost) this.#buildClear();
    else this.#buildSettle();
  }

  #buildClear() {
    const { name, lost } = this.#row;
    this.#clear = confirmButton(this.#frame.body, "Clear", {
      question: `Deletes it, also on disk; ${lost}.`,
      yes: "Delete",
      act: async () => {
        const reply = await call(`${name}.clear`);
        this.#frame.error(reasonOf(reply));
        if (reply.result) this.show(reply.result);
      },
    });
    this.#clear.setAttribute("aria-label", `Clear: ${this.#row.title}`);
  }

  /** The button that takes the proposed settle time over, where the daemon can change it while it runs. */
  async #buildSettle() {
    const frame = this.#frame;
    const use = button(frame.body, "Use", async () => {
      const reply = await call("slm.set", { settle_ms: Math.ceil(this.#report.proposed_settle_ms) });
      frame.error(reasonOf(reply));
      if (reply.result) frame.help(`slm.settle_ms is now ${brief(reply.result.settle_ms)} ms.`);
    });
    use.hidden = true;
    if ((await paramsOf("slm.set")).settle_ms && frame === this.#frame) this.#clear = use;
    this.allow();
  }

  /** Shows a report, as of NAME.get. */
  show(report) {
    this.#report = report;
    const { isKnown, text } = this.#row;
    setText(this.#text, text(report));
    const known = isKnown(report);
    const at = report.t_taken_ns ? ` ${dayAndTime(report.t_taken_ns)}` : "";
    setText(this.#state, known ? `measured${at}` : "none");
    this.allow();
  }

  /** What there is before a first report. */
  showNothing(text) {
    if (this.#report) return;
    setText(this.#text, text);
    setText(this.#state, "not measured");
  }

  follow(job) {
    if (this.#job && !this.#job.isRunning) this.#job.follow(job);
  }

  /** Enables the controls, or disables them and says why. */
  allow() {
    if (!this.#job) return;
    const running = this.#job.isRunning;
    const device = status && !status.camera.connected ? "The camera is not connected." : status && !status.slm.connected ? "The SLM is not connected." : "";
    const why = whyNot() || device || (status?.state === "job_running" && !running ? "A job is running." : "") || whyLoop();
    this.#job.disable(why);
    for (const input of this.#inputs) input.disabled = running;
    if (!this.#clear) return;
    const known = this.isKnown;
    this.#clear.classList.toggle("absent", running || !known);
    this.#clear.disabled = why !== "";
    if (!this.#row.lost) {
      this.#clear.hidden = !known;
      if (known) setText(this.#clear, `Use ${grouped(Math.ceil(this.#report.proposed_settle_ms))} ms`);
    }
  }
}

export function build(mayControl) {
  made ??= new Map(PROCEDURES.map((row) => [row.name, new Procedure(document.querySelector("#procedures .list"), row)]));
  for (const procedure of made.values()) procedure.build(mayControl);
}

export function takeBench({ measured, settle_ms: settle }) {
  for (const [name, report] of Object.entries(measured)) if (report) made.get(name).show(report);
  made.get("settle").showNothing(`slm.settle_ms is ${brief(settle)} ms; not measured since this page was opened.`);
  const active = PROCEDURES.filter(({ name, isKnown }) => measured[name] && isKnown(measured[name])).map(({ title }) => title.toLowerCase());
  takeRight();
  setText(byId("procedures-sub"), active.length ? `measured: ${active.join(", ")}` : "nothing measured");
}

export function takeStatus(message) {
  status = message;
  takeRight();
}

export function takeRight() {
  made?.forEach((procedure) => procedure.allow());
}

/** Follows a job that this page did not start, or started before it was loaded again. */
export async function takeEvent({ kind, data }) {
  if (kind !== "job" || data.state !== "running" || whyNot() || asked.has(data.job)) return;
  asked.add(data.job);
  const { result } = await call("job.get", { job: data.job });
  if (result?.state !== "running") return;
  made.forEach((procedure) => procedure.method === result.kind && procedure.follow(data.job));
}
