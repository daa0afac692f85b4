// A button whose action is asked about before it is done.
import { element, setText } from "./format.js";
import { button } from "./widgets.js";

const PATIENCE_MS = 10_000;
let count = 0;

/**
 * Adds a button to `body`. After a click it asks `question` with a button `yes` and a button Keep; Escape or ten seconds mean
 * Keep. A function as `question` returns the question, or "" if there is nothing to ask. `act` does it. Returns the button.
 */
export function confirmButton(body, text, { question, yes = text, act }) {
  const asked = element("span", "confirm");
  const words = element("span", "question");
  words.id = `question-${++count}`;
  let timer = 0;
  const ask = (open) => {
    const asking = open && typeof question === "function" ? question() : question;
    if (!asking) return act();
    const hadFocus = asked.contains(document.activeElement);
    asked.hidden = !open;
    made.hidden = open;
    clearTimeout(timer);
    if (open) {
      setText(words, asking);
      keep.focus();
      timer = setTimeout(() => ask(false), PATIENCE_MS);
    } else if (hadFocus) made.focus();
  };
  const made = button(body, text, () => ask(true));
  asked.append(words);
  const sure = button(asked, yes, () => {
    ask(false);
    act();
  });
  const keep = button(asked, "Keep", () => ask(false));
  for (const choice of [sure, keep]) choice.setAttribute("aria-describedby", words.id);
  sure.classList.add("danger");
  asked.addEventListener("keydown", (event) => event.key === "Escape" && ask(false));
  asked.hidden = true;
  body.append(asked);
  return made;
}
