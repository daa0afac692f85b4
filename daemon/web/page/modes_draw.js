// A picture of the coefficients as bars, for export.
import { begin, detached, font } from "./canvas.js";
import { themed } from "./colour.js";
import { tick } from "./format.js";

const WIDTH_PX = 760;

/** `bars`: [{label, value, text, error}]; the axis runs from -limit to limit. Returns a canvas in device pixels. */
export function drawBars(bars, limit, unit) {
  const text = font(0.8);
  const row = 1.6 * text.px;
  const canvas = detached(WIDTH_PX, (bars.length + 1) * row);
  const { context } = begin(canvas);
  context.font = text.css;
  context.textBaseline = "middle";
  const [left, right] = [WIDTH_PX * 0.52, WIDTH_PX - 8];
  const middle = (left + right) / 2;
  const xOf = (value) => middle + (value / limit) * (right - middle);
  context.fillStyle = themed("--quiet");
  for (const [align, value] of [["left", -limit], ["center", 0], ["right", limit]]) {
    context.textAlign = align;
    context.fillText(value === 0 ? `0 ${unit}` : tick(value), xOf(value), row / 2);
  }
  bars.forEach(({ label, value, text: number, error }, i) => {
    const y = (i + 1.5) * row;
    context.fillStyle = themed("--ink");
    context.textAlign = "left";
    context.fillText(label, 0, y, WIDTH_PX * 0.38);
    context.textAlign = "right";
    context.fillText(number, left - 10, y);
    context.fillStyle = themed(value < 0 ? "--minus" : "--plus");
    context.fillRect(middle, y - 0.3 * row, xOf(value) - middle, 0.6 * row);
    if (error === null) return;
    context.fillStyle = themed("--ink");
    context.fillRect(xOf(value - error), y - 0.75, Math.max(1, xOf(error) - xOf(-error)), 1.5);
  });
  context.fillStyle = themed("--rule");
  context.fillRect(middle - 0.5, row, 1, bars.length * row);
  return canvas;
}
