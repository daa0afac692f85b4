// The banner: the worst finding about the bench, the further ones, and a button for the remedy of each.
import { byId, element, setText } from "./format.js";
import { followJob } from "./jobs.js";
import { call } from "./link.js";
import * as panels from "./panels.js";
import { clearFirst, takeText } from "./reference.js";
import { whyLoop, whyNot } from "./rights.js";
import { allow, reasonOf, showError } from "./widgets.js";

let shown = []; // the findings

/** Whether the action takes a reference and does nothing else. */
const takesReference = ({ calls }) => calls?.length === 1 && calls[0].method === "reference.take";

/** Makes one call, and waits if it is a job; resolves to the reason for an error, empty on success. */
async function make({ method, params }) {
  const reply = await call(method, params);
  return reply.result?.job === undefined ? reasonOf(reply) : (await followJob(reply.result.job)).error;
}

/** Makes the calls in order, waiting for those that are jobs; stops at the first error and shows it. */
async function remedy(action, control) {
  control.dataset.busy = "yes";
  control.disabled = true;
  showError(byId("verdict-error"), "");
  let error = takesReference(action) ? await clearFirst() : "";
  for (const each of action.calls) error ||= await make(each);
  showError(byId("verdict-error"), error ? `${action.label}: ${error}` : "");
  delete control.dataset.busy;
  allowRemedies();
}

function label(control, action) {
  if (action) setText(control, takesReference(action) ? takeText(action.label) : action.label);
}

/** Gives `parent` the button of the action, unless it has it already. */
function showAction(parent, action) {
  const key = JSON.stringify(action ?? null);
  if (parent.dataset.action === key) return label(parent.querySelector("button"), action);
  parent.dataset.action = key;
  parent.querySelector("button")?.remove();
  if (!action) return;
  const made = element("button", action.calls ? "call" : "");
  label(made, action);
  made.type = "button";
  made.addEventListener("click", () => (action.calls ? remedy(action, made) : panels.show(action.section)));
  parent.append(made);
}

/** Disables the remedies that change something, with the reason, while this page may not or the closed loop excludes them. */
export function allowRemedies() {
  const common = whyNot();
  const loop = common ? "" : whyLoop();
  const remedies = document.querySelectorAll("header button.call:not([data-busy])");
  for (const control of remedies) allow([control], common || loop, byId(common ? "bar-why" : "verdict-why"));
  setText(byId("verdict-why"), remedies.length ? loop : "");
}

/** `findings`: the worst first. */
export function showFindings(findings) {
  shown = findings;
  const [worst, ...others] = findings;
  const verdict = byId("verdict");
  verdict.dataset.wellness = byId("bar-now").dataset.wellness = worst.wellness;
  byId("bar-now").title = `${worst.text}. RMS without tilts`;
  setText(verdict.querySelector("p"), worst.text);
  showAction(verdict, worst.action);
  document.title = worst.wellness === "good" ? "ovws" : `ovws: ${worst.text}`;
  const list = byId("findings");
  if (list.children.length !== others.length) {
    list.replaceChildren(
      ...others.map(() => {
        const line = element("li");
        line.append(element("span"));
        return line;
      }),
    );
  }
  others.forEach((finding, i) => {
    list.children[i].dataset.wellness = finding.wellness;
    setText(list.children[i].firstChild, finding.text);
    showAction(list.children[i], finding.action);
  });
  allowRemedies();
}

/** Shows the same findings, with what their buttons do now. */
export const showAgain = () => shown.length && showFindings(shown);
