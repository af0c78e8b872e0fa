// The timing figure of a service, as the manuals show it: OUT bit 31, IN bit 31, and the five numbered steps.

import { s } from "./dom.js";
import { span, t } from "./texts.js";
import { bit31 } from "./words.js";

const WIDE = 84;
const LEFT = 84;
const TRACES = { out: { high: 46, low: 78, label: "OUT 31" }, in: { high: 116, low: 148, label: "IN 31" } };

function trace(changes, name) {
  const { high, low } = TRACES[name];
  const at = (bit) => (bit ? high : low);
  let path = `M ${LEFT} ${at(name === "out" ? before_out(changes[0]) : before_in(changes[0]))}`;
  changes.forEach((change, k) => {
    const x = LEFT + (k + 0.5) * WIDE;
    path += ` H ${x} V ${at(bit31(change[name]))}`;
  });
  return s("path", { class: name, d: `${path} H ${LEFT + changes.length * WIDE}` });
}

/** The service bits before a change. */
const before_out = (change) => (change.out_step === 2 ? 0 : change.out_step === 4 ? 1 : bit31(change.out));
const before_in = (change) => (change.in_step === 3 ? 0 : change.in_step === 5 ? 1 : bit31(change.in));

function step(number, x, y) {
  return [s("circle", { cx: x, cy: y, r: 9 }), s("text", { x, y: y + 4, "text-anchor": "middle" }, String(number))];
}

/** A figure of these changes, the oldest first; the distance between two is none of time. */
export function figure(changes) {
  const width = LEFT + Math.max(changes.length, 5) * WIDE + 12;
  const root = s("svg", { class: "figure", viewBox: `0 0 ${width} 190`, width, height: 190, role: "img", "aria-label": t("figure", { count: changes.length }), xmlns: "http://www.w3.org/2000/svg" });
  for (const { high, low, label } of Object.values(TRACES)) root.append(s("text", { x: 6, y: (high + low) / 2 + 4 }, label));
  if (changes.length === 0) {
    root.append(s("text", { class: "soft", x: LEFT, y: 100 }, t("figure.none")));
    return root;
  }
  changes.forEach((change, k) => {
    const x = LEFT + (k + 0.5) * WIDE;
    root.append(s("line", { class: "guide", x1: x, x2: x, y1: 30, y2: 160 }));
    if (change.out_step) root.append(...step(change.out_step, x, 20));
    if (change.in_step) root.append(...step(change.in_step, change.out_step ? x + 20 : x, 20));
    const since = k === 0 ? "" : `+${span(change.time_ns - changes[k - 1].time_ns)}`;
    root.append(s("text", { class: "soft", x, y: 178, "text-anchor": "middle" }, since));
  });
  root.append(trace(changes, "out"), trace(changes, "in"));
  return root;
}
