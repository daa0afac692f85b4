// Panels that fold, and the menu that leads to them. What is folded is remembered in this browser.
import { remember, remembered } from "./chosen.js";
import { byId, element } from "./format.js";

const FOLDED = "folded";
const OPEN = "open";
const sections = () => [...byId("views").querySelectorAll(":scope > section")];
const titleOf = (section) => section.querySelector("h2").textContent;

/** Remembers whether parts that fold within a panel, `details` with an id, are open. */
function rememberDetails() {
  const open = remembered(OPEN, {});
  for (const part of byId("views").querySelectorAll("details[id]")) {
    part.open = open[part.id] ?? part.open;
    part.addEventListener("toggle", () => {
      open[part.id] = part.open;
      remember(OPEN, open);
    });
  }
}

function fold(section, folded) {
  section.classList.toggle("folded", folded);
  section.querySelector(".fold").setAttribute("aria-expanded", String(!folded));
  const names = sections().filter((other) => other.classList.contains("folded")).map((other) => other.id);
  remember(FOLDED, names);
}

/** Leads to a panel: unfolds it, scrolls to it and moves the focus there. */
export function show(id) {
  const section = byId(id);
  if (section.classList.contains("folded")) fold(section, false);
  section.querySelector(".fold").focus({ preventScroll: true });
  section.scrollIntoView({ block: "start" });
}

function toggleMenu(open = byId("menu").hidden) {
  byId("menu").hidden = !open;
  byId("menu-button").setAttribute("aria-expanded", String(open));
}

function addMenuEntry(section) {
  const entry = element("button", "", titleOf(section));
  entry.type = "button";
  entry.addEventListener("click", () => {
    toggleMenu(false);
    show(section.id);
  });
  byId("menu").append(entry);
}

function addFold(section, folded) {
  const button = element("button", "fold");
  button.type = "button";
  button.setAttribute("aria-label", `Panel ${titleOf(section)}`);
  button.setAttribute("aria-controls", section.id);
  button.addEventListener("click", () => fold(section, !section.classList.contains("folded")));
  section.querySelector(".head").append(button);
  fold(section, folded);
}

/** Gives every section of the page its fold button and its entry in the menu. */
export function build() {
  const folded = new Set(remembered(FOLDED, []));
  rememberDetails();
  for (const section of sections()) {
    addMenuEntry(section);
    addFold(section, folded.has(section.id));
  }
  byId("menu-button").addEventListener("click", () => toggleMenu());
  document.addEventListener("keydown", (event) => event.key === "Escape" && toggleMenu(false));
  document.addEventListener("pointerdown", (event) => event.target.closest("#menu, #menu-button") || toggleMenu(false));
  byId("skip").addEventListener("click", () => byId("views").focus());
  const bar = byId("bar");
  new ResizeObserver(() => (document.documentElement.style.scrollPaddingTop = `${bar.offsetHeight + 8}px`)).observe(bar);
}
