// The ring: master, segments, encoders with their lamps, and what the master says of it.

import { happened } from "./api.js";
import { connectors, jumper_text } from "./connectors.js";
import { attribute, h, put, toggle } from "./dom.js";
import { clock, is_known } from "./clock.js";
import { likely_text, reasons } from "./polled.js";
import { number, span, t } from "./texts.js";

const REGISTER = ["SS_INFO", "QUALITY", "WARN", "DC_RESULT", "SY_RESULT", "RESULT", "BASP", "BSA", "READY", "ACTIVE", "RUN", "DETECT", "CTRL", "BUS", "PF", "USER"];

/** The bits of the status register that are set. */
function register_names(status) {
  const word = Number.parseInt(status, 16);
  return REGISTER.filter((_, at) => (word >> (15 - at)) & 1);
}

/** What the parameter register says. */
export function parameter_text(text) {
  const word = Number.parseInt(text, 16);
  const known = { 0: "nothing", 0x0bb1: "peripheral", 0x0bdf: "searching", 0x0be1: "not_found" }[word];
  if (known) return t(`parameter.${known}`);
  const [device, below] = [word >> 8, word & 0xff];
  if (below & 0x80) return device === 0 ? t("parameter.master") : t("parameter.interface", { device });
  return t("parameter.device", { device, below });
}

/** What happened, in words. */
export function event_text(event) {
  const values = { ...event, verdict: event.event === "doubted" ? t(`worth.${event.verdict}`) : "", says: event.parameter == null ? "" : parameter_text(event.parameter) };
  const place = event.event === "search_found" ? `event.search_found.${event.fault}` : `event.${event.event}`;
  if (event.event === "jump_cause") return t("event.jump_cause", { position: event.position, found: likely_text(event) });
  const rule = event.event === "finding" ? t(`broken.${event.rule}`) : "";
  return t(place, { ...values, rule, parameter: event.parameter_hex ?? "", cycles: event.cycles == null ? "" : number(event.cycles) });
}

function master(context) {
  const status = h("p", { class: "mono" });
  const names = h("p", { class: "small" });
  const parameter = h("p", { id: "found" });
  const element = h("section", { class: "card" }, h("h3", {}, t("master")), h("p", { class: "small soft" }, t("master.says")), parameter, status, names);
  return {
    element,
    update({ ring }) {
      if (ring.diagnosis.status == null) {
        put(parameter, ring.link?.up === false ? "-" : t("master.untold"));
        [status, names].forEach((line) => put(line, ""));
        attribute(parameter, "class", null);
        return;
      }
      put(status, t("registers", { ...ring.diagnosis, parameter: ring.diagnosis.parameter ?? "----" }));
      put(names, register_names(ring.diagnosis.status).map((name) => `${name}: ${t(`register.${name}`)}`).join("; "));
      put(parameter, ring.diagnosis.parameter == null ? "" : parameter_text(ring.diagnosis.parameter));
      attribute(parameter, "class", ring.diagnosis.parameter === "0000" ? "good" : "bad");
    },
  };
}

/** The segment on which the ring ends, by what is known of the simulation or found by the master. */
function ends_at({ trouble, diagnosis }) {
  if (trouble?.fault === "silent") return trouble.segment;
  const word = Number.parseInt(diagnosis.parameter, 16);
  return (word & 0xff) === 0x80 ? word >> 8 : null;
}

function segment(context, at) {
  const trouble = (fault) => () => context.order(fault ? { verb: "line", segment: at, fault } : { verb: "line", fault: "none" });
  const cable = h("div", { class: "cable" });
  const said = h("span", { class: "small" });
  const cut = h("button", { onclick: trouble("silent"), "data-do": "break" }, t("break"));
  const noise = h("button", { onclick: trouble("flips=2000"), "data-do": "noise" }, t("noise"));
  const mend = h("button", { onclick: trouble(null), "data-do": "mend" }, t("mend"));
  const element = h("div", { class: "segment", role: "group", "aria-label": t("segment", { at }), "data-segment": at },
    h("span", { class: "small soft" }, t("segment", { at })), cable, said, h("div", { class: "row" }, cut, noise, mend));
  return {
    element,
    update({ ring }) {
      const here = ring.trouble?.segment === at ? ring.trouble.fault : null;
      const end = ends_at(ring);
      const dark = end != null && at > end;
      attribute(cable, "class", here === "silent" ? "cable broken" : here ? "cable bad" : dark ? "cable dark" : "cable");
      const faults = ring.diagnosis.segment_faults[at] ?? 0;
      const words = here === "silent" ? t("segment.broken") : here ? t("segment.troubled", { fault: here }) : dark ? t("segment.dark") : t("segment.whole");
      put(said, `${words}; ${t("faults", { faults: number(faults) })}`);
      toggle(cut, here === "silent");
      toggle(noise, here != null && here !== "silent");
      mend.disabled = here == null || !context.may_change;
      cut.disabled = noise.disabled = !context.may_change;
    },
  };
}

const LAMPS = ["u", "ba", "rc", "rd"];

function device(context, unit) {
  const { position } = unit;
  const set = (values) => context.order({ verb: "set", position, set: values });
  const lamps = LAMPS.map((name) => h("span", { class: `lamp ${name === "rd" ? "red" : ""}`, role: "img", "data-lamp": name }, h("i"), name.toUpperCase()));
  const value = h("p", { class: "big mono", "data-value": position });
  const said = h("p", { class: "small" });
  const supply = h("button", {}, t("supply"));
  const jumper = h("button", { title: jumper_text(unit) }, t("jumper"));
  const chip = h("button", {}, t("chip"));
  [supply, jumper, chip].forEach((button) => { button.disabled = !context.may_change; });
  const element = h("section", { class: "card", "data-device": position, "aria-label": t("encoder.at", { position, title: unit.title }) },
    h("h3", {}, h("a", { href: `#encoder/${position}` }, t("encoder.at", { position, title: unit.title }))),
    h("div", { class: "lamps" }, lamps), value, said, h("div", { class: "row" }, supply, jumper, chip), connectors(unit),
    h("p", { class: "small" }, h("a", { href: `#handshake/${position}` }, t("view.handshake"))));
  let seen = null;
  supply.addEventListener("click", () => set({ supply_v: seen?.on ? 0 : 24 }));
  jumper.addEventListener("click", () => set({ jumper: !seen?.jumper }));
  chip.addEventListener("click", () => set({ chip_held: !seen?.chip_held }));
  return {
    element,
    update({ ring }) {
      seen = ring.devices[position];
      LAMPS.forEach((name, at) => {
        const lit = seen.lamps[name];
        lamps[at].classList.toggle("lit", lit);
        attribute(lamps[at], "aria-label", t(lit ? "lamp.on" : "lamp.off", { name: name.toUpperCase(), meaning: t(`lamp.${name}`) }));
        attribute(lamps[at], "title", t(`lamp.${name}`));
      });
      put(value, seen.value == null ? t("off") : number(seen.value));
      const notes = [t("number", { number: seen.device_number })];
      if (seen.error) notes.push(t("error_bit"));
      if (seen.overvoltage) notes.push(t("overvoltage"));
      put(said, notes.join("; "));
      attribute(said, "class", seen.error ? "small bad" : "small");
      toggle(supply, seen.on);
      toggle(jumper, seen.jumper);
      toggle(chip, seen.chip_held);
    },
  };
}

/** An encoder behind a bus: its words and what they are worth. */
function seen_device(unit) {
  const { position } = unit;
  const value = h("p", { class: "big mono", "data-value": position });
  const verdict = h("p", { "data-verdict": position });
  const why = h("p", { class: "small" });
  const [out, input] = [h("p", { class: "small mono" }), h("p", { class: "small mono" })];
  const element = h("section", { class: "card", "data-device": position, "aria-label": t("encoder.at", { position, title: unit.title }) },
    h("h3", {}, h("a", { href: `#encoder/${position}` }, t("encoder.at", { position, title: unit.title }))), value, verdict, why, out, input,
    h("p", { class: "small" }, h("a", { href: `#handshake/${position}` }, t("view.handshake"))));
  return {
    element,
    update({ ring }) {
      const seen = ring.devices[position];
      put(value, seen.value == null ? "-" : number(seen.value));
      put(verdict, t(`worth.${seen.verdict}`));
      attribute(verdict, "class", worth(seen.verdict));
      put(why, reasons(seen, ring)[0]);
      put(out, `OUT ${seen.out ?? "-"}`);
      put(input, `IN  ${seen.in ?? "-"}`);
    },
  };
}

/** Whether a verdict is good news. */
export const worth = (verdict) => (verdict === "valid" ? "good" : ["unchecked", "in_service", "unseen"].includes(verdict) ? "warn" : "bad");

/** What has happened, the newest first; of a real ring with the time of the day. */
function events(context) {
  const list = h("ul", { class: "plain list", id: "events", tabindex: 0, "aria-label": t("happened") });
  const element = h("section", { class: "card wide" }, h("h3", {}, t("happened")), list);
  let next = 0;
  let asking = false;
  const none = h("li", { class: "soft" }, t("happened.none"));
  list.append(none);
  const ask = async () => {
    if (asking || (context.polled && !is_known())) return;
    asking = true;
    try {
      for (const event of await happened(next)) {
        none.remove();
        next = event.number + 1;
        list.prepend(h("li", {}, h("span", { class: "mono small soft" }, `${context.polled ? clock(event.time_ns) : span(event.time_ns)}  `), event_text(event)));
        while (list.children.length > 200) list.lastChild.remove();
      }
    } catch { /* the strip says that there is no connection */ }
    asking = false;
  };
  const timer = setInterval(ask, 500);
  ask();
  return { element, update() {}, leave: () => clearInterval(timer) };
}

/** A ring behind a bus: nobody can see its cables, and nobody can break them from here. */
function polled_view(context, parts, item, ring, rows) {
  context.units.forEach((unit) => item(seen_device(unit)));
  const told = events(context);
  ring.append(h("li", {}, parts[0].element), ...rows);
  const link = h("p", { id: "link" });
  const element = h("div", {}, h("h2", {}, t("view.ring")), h("p", { class: "soft" }, t("ring.polled", { bus: context.about.bus })), link,
    h("div", { class: "card loose" }, ring), h("div", { class: "grid" }, told.element));
  return {
    element,
    update: (state) => {
      const { up, cause, text } = state.ring.link;
      put(link, up === false ? `${t("bus.down", { cause: t(`worth.${cause}`) })} (${text})` : "");
      attribute(link, "class", "bad");
      parts.forEach((part) => part.update(state));
    },
    leave: () => told.leave(),
  };
}

export function create(context) {
  const parts = [master(context)];
  const rows = [];
  const ring = h("ol", { class: "ring" });
  const item = (...made) => { parts.push(...made); rows.push(h("li", {}, made.map((part) => part.element))); };
  if (context.polled) return polled_view(context, parts, item, ring, rows);
  context.units.forEach((unit, at) => item(segment(context, at), device(context, unit)));
  item(segment(context, context.units.length));
  const told = events(context);
  ring.append(h("li", {}, parts[0].element), ...rows);
  const element = h("div", {}, h("h2", {}, t("view.ring")), h("p", { class: "soft" }, t("ring.intro")),
    h("div", { class: "card" }, ring, h("p", { class: "small soft" }, t("ring.home"))), h("div", { class: "grid" }, told.element));
  return {
    element,
    update: (state) => parts.forEach((part) => part.update(state)),
    leave: () => told.leave(),
  };
}
