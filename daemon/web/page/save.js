// Exports: files to download, and the clipboard.
import { font } from "./canvas.js";
import { themed } from "./colour.js";

/** 20261127-143059 of a time in ns, local time. */
function stamp(ns) {
  const at = new Date(ns / 1e6);
  const two = (value) => String(value).padStart(2, "0");
  return `${at.getFullYear()}${two(at.getMonth() + 1)}${two(at.getDate())}-${two(at.getHours())}${two(at.getMinutes())}${two(at.getSeconds())}`;
}

/** Saves a file as ovws-NAME-TIME.ENDING. */
export function save(name, ns, ending, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `ovws-${name}-${stamp(ns)}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** CSV text: lines `# key: value`, then the rows. Numbers have all digits; null and NaN are empty. */
export function csvText(facts, rows) {
  const cell = (value) => {
    if (value === null || value === undefined || Number.isNaN(value)) return "";
    const text = String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [...Object.entries(facts).map(([key, value]) => `# ${key}: ${value}`), ...rows.map((row) => Array.from(row, cell).join())].join("\n") + "\n";
}

export const saveCsv = (name, ns, facts, rows) => save(name, ns, "csv", new Blob([csvText(facts, rows)], { type: "text/csv" }));

/** A PNG of canvases below each other, each with a title, and lines of text at the end. `pictures`: [{title, canvas}] in device pixels. */
export async function pngOf(pictures, lines) {
  const ratio = window.devicePixelRatio || 1;
  const text = font(0.85);
  const row = Math.round(1.6 * text.px * ratio);
  const margin = row;
  const width = Math.max(...pictures.map(({ canvas }) => canvas.width), 480 * ratio) + 2 * margin;
  const out = new OffscreenCanvas(width, 2 * margin + pictures.reduce((sum, { title, canvas }) => sum + canvas.height + (title ? row : 0) + row / 2, 0) + row * lines.length);
  const context = out.getContext("2d");
  context.fillStyle = themed("--panel");
  context.fillRect(0, 0, out.width, out.height);
  context.fillStyle = themed("--ink");
  context.font = `${text.px * ratio}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  let y = margin;
  const write = (line) => {
    context.fillText(line, margin, y + row / 2, width - 2 * margin);
    y += row;
  };
  for (const { title, canvas } of pictures) {
    if (title) write(title);
    context.drawImage(canvas, margin, y);
    y += canvas.height + row / 2;
  }
  lines.forEach(write);
  return out.convertToBlob({ type: "image/png" });
}

/** Copies text, and a picture with it where the browser can. Without a secure connection, only text is copied. Returns whether it worked. */
export async function copy(text, picture = null) {
  try {
    const plain = new Blob([text], { type: "text/plain" });
    const item = picture ? { "text/plain": plain, "image/png": picture } : { "text/plain": plain };
    await navigator.clipboard.write([new ClipboardItem(item)]);
    return true;
  } catch {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    const copied = document.execCommand("copy");
    area.remove();
    return copied;
  }
}
