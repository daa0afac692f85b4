// History of the last hour: bins of half a second for three minutes, of five seconds for an hour. ovws-web keeps them, so that a newly
// opened page has them too.

import { remember, remembered } from "./chosen.js";

export const SPANS = [[180, "3 min"], [900, "15 min"], [3600, "1 h"]]; // s, text
const FINE_S = 180;
const MAX_S = 3600;
const kept = { fine: [], coarse: [] };
let span_s = remembered("span", FINE_S, (seconds) => SPANS.some(([known]) => known === seconds));
let lastAt = 0;

/** The time span that charts show, s. */
export const span = () => span_s;
export const spanText = () => SPANS.find(([seconds]) => seconds === span_s)[1];
export const chooseSpan = (seconds) => {
  span_s = seconds;
  remember("span", seconds);
};

/** The bins of the time span, oldest first: the finest that reach back as far, and fine ones at the end. */
export function bins() {
  if (span_s <= FINE_S) return kept.fine;
  const { fine, coarse } = kept;
  const from = now() - span_s * 1e9;
  const begin = coarse.findIndex((bin) => bin.t_ns >= from);
  const old = begin < 0 ? [] : coarse.slice(begin);
  const until = old.length ? old[old.length - 1].t_ns : 0;
  return [...old, ...fine.filter((bin) => bin.t_ns > until)];
}

/** Label of a time axis at a part of the span before now. */
export const minutesAgo = (part) => (part === 0 ? "now" : `\u2212${Math.round((part * span_s) / 60)} min`);

/** The newest bin; undefined before the first. */
export const newest = () => kept.fine[kept.fine.length - 1];

/** The current time by the daemon's clock, ns. */
export const now = () => (newest() ? newest().t_ns + (performance.now() - lastAt) * 1e6 : 0);

/** Whether there is a gap between a bin and the previous one. */
export const isGap = (before, bin) => !before || bin.t_ns - bin.span_s * 1e9 - before.t_ns > 0.5e9;

/** Adds a bin. Bins arrive in order; after a reconnect known bins arrive again and are ignored. */
export function takeTrend(bin) {
  const isFine = bin.bin_s < 1;
  const list = isFine ? kept.fine : kept.coarse;
  const length = isFine ? FINE_S : MAX_S;
  const last = list[list.length - 1];
  if (last && bin.t_ns <= last.t_ns) {
    if (last.t_ns - bin.t_ns < 2 * length * 1e9) return;
    list.length = 0; // the daemon's clock was set back
  }
  list.push(bin);
  if (isFine) lastAt = performance.now();
  while (list.length && bin.t_ns - list[0].t_ns > length * 1e9) list.shift();
}
