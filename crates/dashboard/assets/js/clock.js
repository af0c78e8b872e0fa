// Which time of the day a time on the bus's clock is.

import { span } from "./texts.js";

let origin = null;
let last = -1;
let changed = 0;

/** A state of this time is there now. Of many the earliest counts: the others were on their way for longer. */
export function now(time_ns) {
  const began = Date.now() - time_ns / 1e6;
  origin = time_ns < last || origin == null ? began : Math.min(origin, began);
  if (time_ns !== last) changed = performance.now();
  last = time_ns;
}

/** Whether a state was there yet. */
export const is_known = () => origin != null;

/** A time of the bus as a time of the day. */
export function clock(time_ns) {
  return origin == null ? span(time_ns) : new Date(origin + time_ns / 1e6).toLocaleTimeString(document.documentElement.lang);
}

/** How long ago the bus's clock went on last, in ms. */
export const since_last = () => performance.now() - changed;
