// History of the last minutes in bins of half a second. ovws-web keeps them, so that a newly opened page has them too.

export const SPAN_S = 180;
export const bins = [];
let lastAt = 0;

/** The current time by the daemon's clock, ns. */
export const now = () => (bins.length ? bins[bins.length - 1].t_ns + (performance.now() - lastAt) * 1e6 : 0);

/** Whether there is a gap between a bin and the previous one. */
export const isGap = (before, bin) => !before || bin.t_ns - bin.span_s * 1e9 - before.t_ns > 0.5e9;

/** Adds a bin. Bins arrive in order; after a reconnect known bins arrive again and are ignored. */
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
