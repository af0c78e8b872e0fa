// One encoder: its shaft or rod to be moved by hand, what surrounds it, and what it makes of that.

import { newest } from "./api.js";
import { attribute, h, put, s, toggle } from "./dom.js";
import { create as create_polled } from "./polled.js";
import { sections } from "./sheet.js";
import { number, span, t } from "./texts.js";
import { binary, gray, hex, place } from "./words.js";

/** A shaft to be turned by hand or by the arrow keys. */
function dial(context, set) {
  const steps = context.unit.steps_per_turn;
  const hand = s("g", {}, s("line", { class: "hand", x1: 100, y1: 100, x2: 100, y2: 34 }), s("circle", { class: "knob", cx: 100, cy: 34, r: 11 }));
  const ticks = Array.from({ length: 24 }, (_, at) => s("line", { class: "tick", x1: 100, y1: 8, x2: 100, y2: at % 6 === 0 ? 20 : 14, transform: `rotate(${at * 15} 100 100)` }));
  const element = s("svg", { class: "dial", viewBox: "0 0 200 200", role: "slider", tabindex: 0, id: "dial", "aria-label": t("shaft"), "aria-valuemin": 0, "aria-valuemax": steps - 1 },
    s("circle", { class: "face", cx: 100, cy: 100, r: 95 }), ticks, hand);
  let raw = 0;
  let dragged = null;
  const move = (to) => { raw = Math.round(to); draw(); set({ raw }); };
  const draw = () => {
    attribute(hand, "transform", `rotate(${((raw % steps) * 360) / steps} 100 100)`);
    attribute(element, "aria-valuenow", ((raw % steps) + steps) % steps);
    attribute(element, "aria-valuetext", t("shaft.at", { raw: number(raw) }));
  };
  const angle = (event) => {
    const box = element.getBoundingClientRect();
    return Math.atan2(event.clientY - box.top - box.height / 2, event.clientX - box.left - box.width / 2);
  };
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    dragged = { last: angle(event), raw };
  });
  element.addEventListener("pointermove", (event) => {
    if (!dragged) return;
    const now = angle(event);
    let turned = now - dragged.last;
    if (turned > Math.PI) turned -= 2 * Math.PI;
    if (turned < -Math.PI) turned += 2 * Math.PI;
    dragged.last = now;
    dragged.raw += (turned / (2 * Math.PI)) * steps;
    move(dragged.raw);
  });
  const drop = () => { dragged = null; };
  element.addEventListener("pointerup", drop);
  element.addEventListener("pointercancel", drop);
  element.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: steps / 8, PageDown: -steps / 8 }[event.key];
    if (event.key === "Home") move(0);
    else if (by) move(raw + by * (event.shiftKey ? 64 : 1));
    else return;
    event.preventDefault();
  });
  return { element, update(device) { if (!dragged) { raw = device.raw; draw(); } } };
}

/** A rod with its magnet. */
function rod(context, set) {
  const end = context.unit.rod_um;
  const element = h("input", { type: "range", id: "rod", min: 0, max: end, step: 10, "aria-label": t("magnet.place") });
  let held = false;
  element.addEventListener("input", () => { held = true; set({ raw: Number(element.value) }); });
  element.addEventListener("change", () => { held = false; });
  return {
    element,
    update(device) {
      if (!held) element.value = device.raw;
      attribute(element, "aria-valuetext", `${number(device.raw / 1000, 2)} mm`);
    },
  };
}

function motion(context, set) {
  const rotary = context.unit.steps_per_turn != null;
  const speed = h("input", { type: "number", id: "speed", value: rotary ? 60 : 100, step: "any" });
  const go = () => set({ motion: rotary ? { kind: "speed", rpm: Number(speed.value) } : { kind: "speed", per_s: Number(speed.value) * 1000 } });
  return h("div", { class: "row" },
    h("label", {}, t(rotary ? "speed.rpm" : "speed.mm"), speed),
    h("button", { onclick: go, id: "go" }, t("go")), h("button", { onclick: () => set({ motion: { kind: "hold" } }), id: "stop" }, t("stop")));
}

function surroundings(context, set) {
  const { unit } = context;
  let seen = null;
  const volts = h("input", { type: "number", value: 24, step: "any", min: 0, id: "volts" });
  const supply = h("button", { onclick: () => set({ supply_v: seen?.on ? 0 : 24 }) }, t("supply"));
  const magnet = unit.rod_um == null ? null : h("button", { onclick: () => set({ magnet: !seen?.magnet }) }, t("magnet"));
  const inputs = Array.from({ length: unit.preset_inputs }, (_, at) =>
    h("button", { onclick: () => set({ [`preset${at + 1}_v`]: seen?.preset_mv[at] > 10_000 ? 0 : 24 }) }, t("preset_input", { number: at + 1 })));
  const said = h("p", { class: "small" });
  const element = h("section", { class: "card" }, h("h3", {}, t("around")),
    h("div", { class: "row" }, supply, magnet, inputs),
    h("div", { class: "row" }, h("label", {}, t("volts"), volts), h("button", { onclick: () => set({ supply_v: Number(volts.value) }) }, t("apply"))), said);
  return {
    element,
    update(device) {
      seen = device;
      toggle(supply, device.on);
      if (magnet) toggle(magnet, device.magnet);
      inputs.forEach((button, at) => toggle(button, device.preset_mv[at] > 10_000));
      const notes = [t("supply.is", { volts: number(device.supply_mv / 1000, 1) })];
      if (device.overvoltage) notes.push(t("overvoltage"));
      if (device.preset_overvoltage) notes.push(t("overvoltage.preset"));
      put(said, notes.join("; "));
    },
  };
}

function position(context) {
  const rows = ["steps", "place", "hex", "binary", "gray", "raw", "in", "error"].map((name) => [name, h("td", { class: "mono", "data-row": name })]);
  const cells = Object.fromEntries(rows);
  const big = h("p", { class: "big mono", id: "value" });
  const element = h("section", { class: "card" }, h("h3", {}, t("position")), big,
    h("table", {}, h("tbody", {}, rows.map(([name, cell]) => h("tr", {}, h("th", { scope: "row" }, t(`position.${name}`)), cell)))));
  return {
    element,
    update(device) {
      const off = device.value == null;
      const here = off ? null : place(device, context.unit);
      put(big, off ? t("off") : number(device.value));
      put(cells.steps, off ? "" : String(device.value));
      put(cells.place, off ? "" : here.mm == null ? t("turns", { turns: number(here.turns), degrees: number(here.degrees, 2) }) : `${number(here.mm, 3)} mm`);
      put(cells.hex, off ? "" : `${hex(device.value, 6)}h`);
      put(cells.binary, off ? "" : binary(device.value));
      put(cells.gray, off ? "" : binary(gray(device.value)));
      put(cells.raw, context.unit.rod_um == null ? t("raw.steps", { raw: number(device.raw) }) : `${number(device.raw / 1000, 2)} mm`);
      put(cells.in, device.in);
      put(cells.error, device.error ? t("error.pending") : t("error.none"));
      attribute(cells.error, "class", device.error ? "bad" : "good");
    },
  };
}

/** The status bits that have a remedy. */
const WITH_REMEDY = [0, 1, 2, 3, 5, 7, 8, 9, 13, 14];

/** The status bits of a word in words, each with what helps where the manuals say it. */
export function status_texts(status) {
  const word = Number.parseInt(status, 16);
  const set = Array.from({ length: 16 }, (_, bit) => bit).filter((bit) => (word >> bit) & 1);
  return set.map((bit) => `2^${bit}: ${t(`status.${bit}`)}${WITH_REMEDY.includes(bit) ? `; ${t(`remedy.${bit}`)}` : ""}`);
}

function parameters(context) {
  const body = h("tbody");
  const check = h("p");
  const status = h("p", { class: "small" });
  const head = ["service", "programmed", "accepted", "active"].map((name) => h("th", { scope: "col", class: name === "service" ? null : "num" }, t(`column.${name}`)));
  const element = h("section", { class: "card double" }, h("h3", {}, t("parameters")),
    h("div", { class: "scroll", tabindex: 0 }, h("table", {}, h("thead", {}, h("tr", {}, head)), body)), check, status,
    context.unit.at_once ? h("p", { class: "small soft" }, t("at_once")) : null);
  let drawn = "";
  return {
    element,
    update(device) {
      const is = JSON.stringify(device.parameters);
      if (is !== drawn) {
        drawn = is;
        body.replaceChildren(...device.parameters.map((parameter) => {
          const { service, programmed, accepted, active } = parameter;
          const differs = programmed !== active ? "num mono differs" : "num mono";
          return h("tr", {}, h("th", { scope: "row" }, `${hex(service, 2)} ${t(`service.${service}`)}`),
            h("td", { class: differs }, String(programmed)), h("td", { class: "num mono" }, accepted == null ? "-" : String(accepted)), h("td", { class: "num mono" }, String(active)));
        }));
      }
      const found = device.data_check == null ? [] : status_texts(device.data_check);
      put(check, device.data_check == null ? "" : found.length === 0 ? t(context.unit.at_once ? "check.valid" : "check.good") : t("check.bad", { status: `${device.data_check}h`, why: found.join("; ") }));
      attribute(check, "class", found.length === 0 ? "good" : "bad");
      const latched = status_texts(device.latched_status);
      put(status, latched.length === 0 ? t("latched.none") : t("latched", { why: latched.join("; ") }));
    },
  };
}

/** The records of its EEPROM: which cannot be read, and how often each was written. */
function memory({ unit }) {
  const has = { programmed: true, accepted: !unit.at_once, offset: true, turn_count: unit.kind === "rotary" };
  const rows = Object.keys(has).filter((name) => has[name]).map((name) => ({ name, writes: h("td", { class: "num mono" }), state: h("p", { class: "small bad", "data-record": name }) }));
  const shift = h("p", { id: "preset-shift" });
  const head = ["record", "count"].map((name) => h("th", { scope: "col", class: name === "count" ? "num" : null }, t(`eeprom.${name}`)));
  const element = h("section", { class: "card" }, h("h3", {}, t("eeprom")), shift,
    h("table", {}, h("thead", {}, h("tr", {}, head)), h("tbody", {}, rows.map(({ name, writes, state }) => h("tr", {}, h("th", { scope: "row" }, t(`writes.${name}`), state), writes)))),
    h("p", { class: "small soft" }, t("writes.why")));
  return {
    element,
    update(device) {
      for (const { name, writes, state } of rows) {
        put(state, device.memory_lost.includes(name) ? t("eeprom.lost") : "");
        state.hidden = state.textContent === "";
        put(writes, number(device.memory_writes[name]));
      }
      put(shift, device.preset_shift == null ? "" : device.preset_shift === 0 ? t("preset.none") : t("preset.shift", { steps: number(device.preset_shift) }));
    },
  };
}

function ssi(context, set) {
  const said = h("p", { class: "mono" });
  const field = h("p", { class: "mono small" });
  const fault = h("p");
  const element = h("section", { class: "card" }, h("h3", {}, t("ssi")),
    h("div", { class: "row" },
      h("button", { onclick: () => set({ ssi: { khz: 500, clocks: 25, every_ms: 10 } }) }, t("ssi.hang")),
      h("button", { onclick: () => set({ ssi: "off" }) }, t("ssi.take"))), said, field, fault);
  return {
    element,
    update({ ssi: reader }) {
      if (!reader) {
        [said, field, fault].forEach((line) => put(line, ""));
        put(said, t("ssi.none"));
        return;
      }
      put(said, t("ssi.reader", { khz: number(reader.clock_hz / 1000), clocks: reader.clocks, every: span(reader.every_ns), count: number(reader.count) }));
      put(field, reader.field ?? "");
      put(fault, reader.fault ? t("ssi.fault", { fault: reader.fault }) : reader.position == null ? "" : t("ssi.position", { position: number(reader.position) }));
      attribute(fault, "class", reader.fault ? "bad" : "good");
    },
  };
}

/** The data sheet of its model. */
export function sheet({ unit }) {
  const said = (value) => (value == null ? "?" : number(value));
  const kind = unit.kind === "rotary" ? t(unit.steps_per_turn == null ? "sheet.rotary.unknown" : "sheet.rotary", { steps: said(unit.steps_per_turn) }) : t(unit.rod_um == null ? "sheet.linear.unknown" : "sheet.linear", { mm: said(unit.rod_um == null ? null : unit.rod_um / 1000) });
  const place = h("div", { id: "sheet" });
  sections(unit.model, place).catch(() => put(place, t("not_connected")));
  return h("section", { class: "card wide" }, h("h3", {}, t("sheet", { title: unit.title })), h("p", {}, kind),
    unit.firmware == null ? null : h("p", { class: "small" }, t("sheet.firmware", { week: unit.firmware })), place);
}

/** A page that only shows moves nothing. */
function element_controls(...parts) {
  parts.forEach((part) => attribute(part, "inert", ""));
}

export function create(context) {
  if (context.polled) return create_polled(context);
  const send = newest((values) => context.order({ verb: "set", position: context.position, set: values }));
  const hand = context.unit.rod_um == null ? dial(context, send) : rod(context, send);
  const parts = [hand, position(context), surroundings(context, send), parameters(context), memory(context)];
  if (context.unit.ssi) parts.push(ssi(context, send));
  const [, shown, around, ...others] = parts.map((part) => part.element);
  const moved = h("section", { class: "card" }, h("h3", {}, t(context.unit.rod_um == null ? "shaft" : "rod")), hand.element,
    h("p", { class: "small soft" }, t(context.unit.rod_um == null ? "shaft.how" : "rod.how")), motion(context, send));
  if (!context.may_change) element_controls(hand.element, moved, around);
  const element = h("div", {}, h("h2", {}, t("view.encoder")), h("div", { class: "row" }, context.choice()),
    h("div", { class: "grid" }, moved, shown, around, others, sheet(context)));
  return {
    element,
    update: ({ ring }) => parts.forEach((part) => part.update(ring.devices[context.position])),
  };
}
