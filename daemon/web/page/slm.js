// The SLM: the hologram on it, and a comparison of its output with that hologram.
import { byId, element, NONE, setText } from "./format.js";
import { call, picture } from "./link.js";
import { whyLoop } from "./rights.js";
import { button, ChoiceControl, field, reasonOf } from "./widgets.js";
import { showFacts } from "./bench.js";

let drawn = null; // hologram id and checksum of the displayed image
let checksum = null;
let pattern = null;
let patterns = null; // those that can be shown; known by the bench, as the one in use is by the status: either may come first
let inUse = null;
let url = null;
let compared = null; // the last comparison: its field and result
const veil = () => document.querySelector("#slm .veil");

/** Shows the result of the comparison. Called again when the image changes, which may be later. */
function showComparison() {
  if (!compared) return;
  const { frame, result } = compared;
  const same = result.crc32 === checksum ? ", identical to the image above" : "";
  frame.help(`The output showed hologram ${result.hologram_id}${same} (CRC-32 ${result.crc32.toString(16)}).`);
}

async function compare(frame) {
  const { result, error } = await call("slm.verify");
  frame.error(error ? reasonOf({ error }) : result.equal ? "" : `${result.differing_pixels} pixels of the output differ from hologram ${result.hologram_id}`);
  frame.help("");
  compared = error || !result.equal ? null : { frame, result };
  showComparison();
}

export function build(mayControl) {
  const parent = document.querySelector("#slm .controls");
  parent.replaceChildren();
  pattern = compared = null;
  if (!mayControl) return;
  const choice = new ChoiceControl(parent, "Pattern", async (value) => choice.error(reasonOf(await call("slm.show", { pattern: value }))));
  pattern = choice;
  const frame = field(parent, "Output");
  button(frame.body, "Compare with the output", () => compare(frame)).id = frame.id;
}

async function load() {
  const blob = await picture("/hologram.png");
  if (!blob) return;
  if (url) URL.revokeObjectURL(url);
  url = URL.createObjectURL(blob);
  byId("hologram").src = url;
}

function showPattern() {
  if (patterns && inUse) pattern?.show(inUse, patterns);
  pattern?.allow(inUse ? whyLoop() : "Waiting for ovwsd.");
}

export function takeBench({ hologram, limits }) {
  const none = hologram.hologram_id === null;
  byId("hologram").hidden = none;
  veil().hidden = !none;
  if (none) setText(veil(), hologram.reason ? `No image: ${hologram.reason}` : "No image yet");
  const key = `${hologram.hologram_id} ${hologram.crc32}`;
  if (!none && key !== drawn) {
    drawn = key;
    checksum = hologram.crc32;
    byId("hologram").alt = `Hologram ${hologram.hologram_id} on the SLM`;
    setText(byId("slm-sub"), `hologram ${hologram.hologram_id}`);
    load();
    showComparison();
  }
  patterns = limits.patterns;
  showPattern();
}

export function takeStatus({ slm }) {
  const { info } = slm;
  inUse = slm.pattern;
  showPattern();
  showFacts(byId("slm-facts"), [
    ["Output", info ? `${info.output}, ${info.driver}` : NONE],
    ["Mode", info ? `${info.width} \u00d7 ${info.height} px at ${Math.round(info.refresh_hz)} Hz` : NONE],
    ["Pattern", slm.pattern],
    ["Hologram", `${slm.hologram_id}, ${slm.settled ? "settled" : "changing"}`],
    ["State", slm.fault ?? (slm.connected ? "connected" : "not connected")],
  ]);
}
