// A button whose action is asked about before it is done.
import { element, setText } from "./format.js";
import { button } from "./widgets.js";

const PATIENCE_MS = 10_000;
let count = 0;

/**
 * Adds a button to `body`. After a click it asks `question` with a button `yes` and a button Keep; Escape or ten seconds mean
 * Keep. A function as `question` resolves to the question, or to "" if there is nothing to ask. `act` does it. Returns the button.
 */
export function confirmButton(body, text, { question, yes = text, act }) {
  const asked = element("span", "confirm");
  const words = element("span", "question");
  words.id = `question-${++count}`;
  let timer = 0;
  let deciding = false; // whether there is something to ask
  const show = (open) => {
    const hadFocus = asked.contains(document.activeElement);
    asked.hidden = !open;
    made.hidden = open;
    clearTimeout(timer);
    if (open) {
      keep.focus();
      timer = setTimeout(() => show(false), PATIENCE_MS);
    } else if (hadFocus) made.focus();
  };
  const begin = async () => {
    if (deciding) return;
    deciding = true;
    const asking = typeof question === "function" ? await question() : question;
    deciding = false;
    if (!asking) return act();
    setText(words, asking);
    show(true);
  };
  const made = button(body, text, begin);
  asked.append(words);
  const sure = button(asked, yes, () => {
    show(false);
    act();
  });
  const keep = button(asked, "Keep", () => show(false));
  for (const choice of [sure, keep]) choice.setAttribute("aria-describedby", words.id);
  sure.classList.add("danger");
  asked.addEventListener("keydown", (event) => event.key === "Escape" && show(false));
  asked.hidden = true;
  body.append(asked);
  return made;
}
