// The banner: the worst finding about the bench, the further ones, and a button for the remedy of each.
import { byId, element, setText } from "./format.js";
import { followJob } from "./jobs.js";
import { call } from "./link.js";
import * as panels from "./panels.js";
import { whyNot } from "./rights.js";
import { allow, reasonOf, showError } from "./widgets.js";

/** Makes the calls in order, waiting for those that are jobs; stops at the first error and shows it. */
async function remedy(calls, control) {
  control.dataset.busy = "yes";
  control.disabled = true;
  showError(byId("verdict-error"), "");
  for (const { method, params } of calls) {
    const reply = await call(method, params);
    const error = reply.result?.job === undefined ? reasonOf(reply) : (await followJob(reply.result.job)).error;
    if (error) {
      showError(byId("verdict-error"), `${method}: ${error}`);
      break;
    }
  }
  delete control.dataset.busy;
  allowRemedies();
}

/** Gives `parent` the button of the action, unless it has it already. */
function showAction(parent, action) {
  const key = JSON.stringify(action ?? null);
  if (parent.dataset.action === key) return;
  parent.dataset.action = key;
  parent.querySelector("button")?.remove();
  if (!action) return;
  const made = element("button", action.calls ? "call" : "", action.label);
  made.type = "button";
  made.addEventListener("click", () => (action.calls ? remedy(action.calls, made) : panels.show(action.section)));
  parent.append(made);
}

/** Disables the remedies that change something, with the reason, while this page may not. */
export function allowRemedies() {
  allow(document.querySelectorAll("header button.call:not([data-busy])"), whyNot(), byId("bar-why"));
}

/** `findings`: the worst first. */
export function showFindings([worst, ...others]) {
  const verdict = byId("verdict");
  verdict.dataset.wellness = worst.wellness;
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
