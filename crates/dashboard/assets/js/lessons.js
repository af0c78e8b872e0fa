// Five lessons. Each sets the ring up, names its goals, and sees by itself when one is reached.

import { attribute, h, put } from "./dom.js";
import { changes } from "./handshake.js";
import { t } from "./texts.js";
import { bits } from "./words.js";

const KEY = "lessons";
const done_before = () => JSON.parse(localStorage.getItem(KEY) ?? "[]");

/** The first encoder that fits. */
const first = (units, fits) => units.find(fits)?.position ?? null;
const rotary = (unit) => unit.steps_per_turn != null;
const in_steps = (list, from, wanted) => {
  let at = 0;
  for (const change of list) {
    if (change.number < from) continue;
    for (const step of [change.out_step, change.in_step]) {
      if (step == null) continue;
      at = step === wanted[at] ? at + 1 : step === wanted[0] ? 1 : 0;
      if (at === wanted.length) return true;
    }
  }
  return false;
};
const programmed = (device, service) => device.parameters.find((parameter) => parameter.service === service);

/** A lesson: the encoder it uses, how it begins, and its goals, each a test of what is seen. */
const LESSONS = [
  {
    name: "service",
    position: (units) => first(units, rotary),
    view: "handshake",
    goals: [
      ["data", ({ list, from }) => list.some((c) => c.number >= from && c.out_step === 1)],
      ["bit", ({ list, from }) => in_steps(list, from, [1, 2])],
      ["reply", ({ list, from }) => in_steps(list, from, [1, 2, 3])],
      ["end", ({ list, from }) => in_steps(list, from, [1, 2, 3, 4, 5])],
    ],
  },
  {
    name: "torn",
    position: (units) => first(units, rotary),
    view: "handshake",
    goals: [
      ["together", ({ list, from }) => list.some((c) => c.number >= from && c.out_step === 2 && differs(list, c))],
      ["right", ({ list, from }) => in_steps(list, from, [1, 2, 3, 4, 5])],
    ],
  },
  {
    name: "check",
    position: (units) => first(units, (unit) => rotary(unit) && !unit.at_once),
    view: "handshake",
    goals: [
      ["program", ({ device }) => { const length = programmed(device, 2); return length != null && length.programmed !== length.active; }],
      ["look", ({ list, from, device, reached }) => reached.includes("program") && list.some((c) => c.number >= from && c.in_step === 3 && bits(c.in) >>> 24 === 0x82) && programmed(device, 2) != null],
      ["check", ({ list, from, device, reached }) => reached.includes("program") && list.some((c) => c.number >= from && c.in_step === 3 && (bits(c.in) >>> 24 & 0x8f) === 0x88) && same(device)],
    ],
  },
  {
    name: "preset",
    position: (units) => first(units, rotary),
    view: "handshake",
    goals: [
      ["adjust", ({ list, from }) => list.some((c) => c.number >= from && c.in_step === 3 && bits(c.in) >>> 24 === 0xc6)],
      ["offset", ({ device, begin }) => device.memory_writes.offset > begin.offset],
      ["lost", ({ list, from, reached }) => reached.includes("adjust") && list.some((c) => c.number >= from && c.out_step === 2 && bits(c.out) >>> 24 === 0x86)],
    ],
  },
  {
    name: "break",
    position: () => 0,
    view: "ring",
    goals: [
      ["broken", ({ ring }) => ring.trouble?.fault === "silent"],
      ["found", ({ ring, reached }) => reached.includes("broken") && ring.diagnosis.parameter !== "0000" && ring.diagnosis.parameter !== "0BDF"],
      ["lamps", ({ ring, reached }) => reached.includes("broken") && Object.values(ring.devices).some(({ lamps }) => !lamps.ba)],
      ["whole", ({ ring, reached }) => reached.includes("found") && ring.trouble == null && ring.line === "good" && ring.diagnosis.parameter === "0000"],
    ],
  },
];

/** Whether the data changed with the service bit: the encoder may have taken half of it. */
function differs(list, change) {
  const before = list.find((other) => other.number === change.number - 1);
  return before == null ? (bits(change.out) & 0x7fffffff) !== 0 : ((bits(before.out) ^ bits(change.out)) & 0x7fffffff) !== 0;
}

const same = (device) => device.parameters.every(({ programmed: is, active }) => is === active);

/** The lesson that is being done; it goes on while other views are looked at. */
let running = null;

function watch(state) {
  if (!running) return;
  const { lesson, kept, position } = running;
  const device = state.ring.devices[position];
  if (running.begin == null) {
    running.begin = device.memory_writes;
    running.from = state.changes[position];
    // The word before the first change is looked at too.
    kept.next = Math.max(0, running.from - 1);
  }
  kept.follow(state.changes[position]);
  const seen = { ring: state.ring, device, list: kept.list, from: running.from, begin: running.begin, reached: running.reached };
  for (const [goal, holds] of lesson.goals) {
    if (!running.reached.includes(goal) && holds(seen)) running.reached.push(goal);
  }
  if (running.reached.length === lesson.goals.length && !done_before().includes(lesson.name)) {
    localStorage.setItem(KEY, JSON.stringify([...done_before(), lesson.name]));
  }
}

export function create(context) {
  const cards = LESSONS.map((lesson, number_of) => {
    const position = lesson.position(context.units);
    const goals = lesson.goals.map(([goal]) => ({ goal, line: h("li", {}, t(`lesson.${lesson.name}.${goal}`)) }));
    const said = h("p", { role: "status" });
    const start = h("button", { class: "first", "data-lesson": lesson.name, disabled: position == null }, t("lesson.start"));
    start.addEventListener("click", () => {
      running = { lesson, position, kept: changes(position), reached: [], begin: null, from: 0 };
    });
    const place = lesson.view === "ring" ? "#ring" : `#${lesson.view}/${position}`;
    const element = h("section", { class: "card", "data-card": lesson.name }, h("h3", {}, `${number_of + 1}. ${t(`lesson.${lesson.name}`)}`), h("p", {}, t(`lesson.${lesson.name}.why`)),
      h("ol", { class: "goals" }, goals.map(({ line }) => line)),
      h("div", { class: "row" }, start, h("a", { href: place }, t("lesson.open", { view: t(`view.${lesson.view}`) }))), said);
    return {
      element,
      update() {
        const mine = running?.lesson === lesson ? running : null;
        goals.forEach(({ goal, line }) => attribute(line, "class", mine?.reached.includes(goal) ? "done" : null));
        const all = mine && mine.reached.length === lesson.goals.length;
        put(said, position == null ? t("lesson.none") : all ? t("lesson.passed") : mine ? t("lesson.running") : done_before().includes(lesson.name) ? t("lesson.before") : "");
        attribute(said, "class", all ? "good" : "soft");
      },
    };
  });
  const element = h("div", {}, h("h2", {}, t("view.lessons")), h("p", { class: "soft" }, t("lessons.intro")), h("div", { class: "grid" }, cards.map((card) => card.element)));
  return { element, update: () => cards.forEach((card) => card.update()) };
}

/** Sees how far the lesson is, whichever view is shown. */
export { watch };
