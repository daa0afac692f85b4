// The last minutes, half a second a bin, as ovws-web kept them: a page that was just opened has them, too.

export const SPAN_S = 180;
export const bins = [];
let lastAt = 0;

/** By the daemon's clock, ns: what was not measured since the last bin is a gap. */
export const now = () => (bins.length ? bins[bins.length - 1].t_ns + (performance.now() - lastAt) * 1e6 : 0);

/** Whether something is missing between a bin and the one before it. */
export const isGap = (before, bin) => !before || bin.t_ns - bin.span_s * 1e9 - before.t_ns > 0.5e9;

/** Bins come in order; after a connection anew those that are known come again. */
export function takeTrend(bin) {
  const last = bins[bins.length - 1];
  if (last && bin.t_ns <= last.t_ns) {
    if (last.t_ns - bin.t_ns < 2 * SPAN_S * 1e9) return;
    bins.length = 0; // the daemon's clock was set back
  }
  bins.push(bin);
  lastAt = performance.now();
  while (bins.length && bin.t_ns - bins[0].t_ns > SPAN_S * 1e9) bins.shift();
}
