// Histogram of the camera image, and what its saturated or dim pixels mean.
import { begin, font } from "./canvas.js";
import { SCALES } from "./camera_scale.js";
import { css, themed } from "./colour.js";
import { byId, fixed, grouped, setText } from "./format.js";

const DIM_PART = 0.2; // of full scale: below, the image is called dim

function shareText(part) {
  const percent = 100 * part;
  return percent >= 0.1 ? `${fixed(percent, 1)} %` : percent >= 0.001 ? `${fixed(percent, 3)} %` : "less than 0.001 %";
}

/**
 * What the levels mean, and what to do. `peaks`: brightest pixel of each spot, DN; where no spot is known, the brightest
 * pixel of the image counts, which may be stray light.
 */
export function verdict({ saturated, brightest, full, width, height }, peaks) {
  const inSpots = peaks.filter((peak) => peak >= full).length;
  if (saturated > 0 || inSpots > 0) {
    const share = `${grouped(saturated)} ${saturated === 1 ? "pixel is" : "pixels are"} saturated (${shareText(saturated / (width * height))}): the light exceeds the ${full} DN of full scale.`;
    if (inSpots === 0 && peaks.length > 0) return { wellness: "", text: `${share} None is in a spot, so the measurement is not affected. ${reach(Math.max(...peaks), full, "spot")}.` };
    const wrong = inSpots === 0 ? "" : ` ${inSpots} ${inSpots === 1 ? "spot is" : "spots are"} measured wrong.`;
    return { wellness: "warning", text: `${share}${wrong} Lower the exposure or the gain, or press Auto.` };
  }
  const top = peaks.length > 0 ? Math.max(...peaks) : brightest;
  const text = `No pixel is saturated. ${reach(top, full, peaks.length > 0 ? "spot" : "pixel")}`;
  if (top / full < DIM_PART) return { wellness: "note", text: `${text}: the noise counts more than it needs to. Raise the exposure, or press Auto.` };
  return { wellness: "", text: `${text}.` };
}

const reach = (level, full, what) => `The brightest ${what} reaches ${fixed((100 * level) / full, 0)} % of full scale`;

/** Draws the counts of all levels, in logarithmic height; the last bin, which holds saturated pixels, has their colour. */
export function draw({ histogram, full, saturated }, scale) {
  const { context, width, height } = begin(byId("histogram-canvas"));
  if (width === 0 || !histogram) return;
  const text = font(0.72);
  const bottom = height - 1.6 * text.px;
  const most = Math.log10(1 + Math.max(...histogram));
  const barWidth = width / histogram.length;
  histogram.forEach((count, i) => {
    const tall = (Math.log10(1 + count) / most) * bottom;
    const isLast = i === histogram.length - 1 && saturated > 0;
    context.fillStyle = isLast ? css(SCALES[scale].saturated) : themed("--accent");
    context.fillRect(isLast ? width - Math.max(4, barWidth) : i * barWidth, bottom - tall, isLast ? Math.max(4, barWidth) : Math.max(1, barWidth - 0.5), tall);
  });
  context.fillStyle = themed("--rule");
  context.fillRect(0, bottom, width, 1);
  context.font = text.css;
  context.fillStyle = themed("--quiet");
  context.textBaseline = "top";
  for (const [part, align] of [[0, "left"], [0.5, "center"], [1, "right"]]) {
    context.textAlign = align;
    context.fillText(`${Math.round(part * full)}${part === 1 ? " DN" : ""}`, part * width, bottom + 4);
  }
}

export function describe(info, peaks) {
  const { wellness, text } = verdict(info, peaks);
  const line = byId("saturation");
  setText(line, text);
  line.dataset.wellness = wellness;
  byId("histogram-canvas").setAttribute("aria-label", `Histogram of grey levels, logarithmic. ${text}`);
}
