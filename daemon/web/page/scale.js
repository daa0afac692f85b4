// A scale whose limit follows the values.
import { inUnit, onChosen, toWaves } from "./chosen.js";
import { roundUp } from "./format.js";

const MIN_WAVES = 0.01;
const HOLD_MS = 4000;

/** A limit that is round in the chosen unit. It widens at once and narrows only after 4 s, so that pictures stay comparable. */
export class AutoScale {
  #steps;
  #at = 0;
  waves = MIN_WAVES;

  constructor(steps) {
    this.#steps = steps;
    onChosen(() => {
      this.waves = 0;
    });
  }

  /** Takes the largest value in waves; returns the limit in waves. */
  take(most) {
    const now = performance.now();
    const wanted = toWaves(roundUp(inUnit(Math.max(most, MIN_WAVES)), this.#steps));
    if (wanted >= this.waves || now - this.#at > HOLD_MS) [this.waves, this.#at] = [wanted, now];
    return this.waves;
  }
}
