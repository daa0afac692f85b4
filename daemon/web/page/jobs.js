// Jobs of the daemon: start one, follow its progress, cancel it, and show its result or error.
import { element, setText, timeLeft } from "./format.js";
import { confirmButton } from "./confirm.js";
import { call } from "./link.js";
import { allow, button, field, reasonOf } from "./widgets.js";

const POLL_MS = 150;
const FORECAST_S = 1.5; // a forecast needs some time of the job, and is for jobs that take long
const SHORT_S = 3;
const MOST_UNANSWERED = 20;
const RETRY_MS = 1000;
const pause = (ms = POLL_MS) => new Promise((done) => setTimeout(done, ms));

/**
 * Follows a job to its end. Resolves to {state, result, error}: `state` is "done", "failed" or "cancelled", `error` a text
 * that says what to do, empty unless the job failed. Never rejects. `onProgress` receives fractions from 0 to 1.
 */
export async function followJob(job, onProgress = () => {}) {
  for (let unanswered = 0; ; ) {
    const reply = await call("job.get", { job });
    if (reply.error && reply.error.code === undefined && ++unanswered < MOST_UNANSWERED) {
      await pause(RETRY_MS); // the daemon or ovws-web did not answer; the job goes on
      continue;
    }
    if (reply.error) return { state: "failed", result: null, error: reasonOf(reply) };
    unanswered = 0;
    const { state, progress, result, error } = reply.result;
    onProgress(progress);
    if (state !== "running") return { state, result, error: error ? error.data?.reason || error.message : "" };
    await pause();
  }
}

/**
 * Starts a job by its method and follows it to its end, as followJob; a refusal to start is a failure too.
 * `onStart` receives the job's number.
 */
export async function runJob(method, params = {}, { onStart = () => {}, onProgress = () => {} } = {}) {
  const reply = await call(method, params);
  if (reply.error) return { state: "failed", result: null, error: reasonOf(reply) };
  onStart(reply.result.job);
  return followJob(reply.result.job, onProgress);
}

/**
 * A button that runs a job, with progress and Cancel while it runs, and the error or the result's text afterwards.
 * `body`: element for the button; `error`, `help`: functions that show a text.
 */
export class JobButton {
  #job = null;
  #bar = element("progress");
  #left = element("span", "left");
  #cancel;
  #onDone;
  #since = 0;
  #first = null; // the progress that was seen first: a job may be followed from its middle

  /**
   * `params()`: params at the moment of the click. `before()`: what a click does first; resolves to a reason not to start the
   * job, or "". `question()`: resolves to what a click asks first, or to "". `onDone(result)`: returns the text to show, or nothing.
   */
  constructor({ body, error, help = () => {}, why = null }, text, method, { params = () => ({}), before = async () => "", question = null, onDone = () => {} } = {}) {
    this.error = error;
    this.help = help;
    this.why = why;
    this.#onDone = onDone;
    const act = () => this.run(method, params(), before);
    this.button = question ? confirmButton(body, text, { question, act }) : button(body, text, act);
    this.#bar.max = 1;
    this.#bar.setAttribute("aria-label", `Progress: ${text}`);
    body.append(this.#bar, this.#left);
    this.#cancel = button(body, "Cancel", () => call("job.cancel", { job: this.#job }));
    this.#cancel.setAttribute("aria-label", `Cancel: ${text}`);
    this.#show(false);
  }

  /** Disables the button and says why (field of jobField only), or enables it with reason "". */
  disable(reason) {
    allow([this.button], reason, this.why);
    setText(this.why, reason);
  }

  get isRunning() {
    return !this.#cancel.hidden;
  }

  #show(running) {
    this.#bar.hidden = this.#cancel.hidden = !running;
    this.button.hidden = running;
    this.#bar.value = 0;
    this.#left.hidden = true;
    this.#since = performance.now();
    this.#first = null;
    this.#cancel.disabled = true; // until the job has a number
  }

  #progress(part) {
    this.#bar.value = part;
    this.#first ??= part;
    const spent = (performance.now() - this.#since) / 1000;
    const left = (spent * (1 - part)) / (part - this.#first);
    this.#left.hidden = !(part > this.#first && spent > FORECAST_S && spent + left > SHORT_S);
    if (!this.#left.hidden) setText(this.#left, timeLeft(left));
  }

  /** Runs the job; resolves to what runJob resolves to. */
  run(method, params, before) {
    return this.#watch(async (watching) => {
      const error = await before();
      return error ? { state: "failed", result: null, error } : runJob(method, params, watching);
    });
  }

  /** Follows a job that another page or client has started. */
  follow(job) {
    return this.#watch(({ onStart, onProgress }) => {
      onStart(job);
      return followJob(job, onProgress);
    });
  }

  async #watch(start) {
    const hadFocus = document.activeElement === this.button;
    this.error("");
    this.#show(true);
    const onStart = (job) => {
      this.#job = job;
      this.#cancel.disabled = false;
      if (hadFocus) this.#cancel.focus();
    };
    const ended = await start({ onStart, onProgress: (part) => this.#progress(part) });
    const heldFocus = document.activeElement === this.#cancel;
    this.#show(false);
    if (heldFocus) this.button.focus();
    this.error(ended.error);
    this.help(ended.state === "done" ? (this.#onDone(ended.result) ?? "") : ended.state === "cancelled" ? "Cancelled." : "");
    return ended;
  }
}

/** A JobButton in a field of its own, with the title as its label. */
export function jobField(parent, title, text, method, options) {
  const frame = field(parent, title);
  const made = new JobButton(frame, text, method, options);
  made.button.id = frame.id;
  made.button.setAttribute("aria-describedby", frame.describedBy);
  return made;
}
