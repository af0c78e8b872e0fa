// One encoder of a ring that is looked at by polls: what its word is worth and why, and what is known of its parameters.

import { clock } from "./clock.js";
import { attribute, h, put } from "./dom.js";
import { parameter_text, worth } from "./ring.js";
import { sheet, status_texts } from "./encoder.js";
import { more, number, said, span, t } from "./texts.js";
import { binary, bits, field, FIELDS, gray, hex, place } from "./words.js";

/** A position in degrees or mm; a dash where the scaling is not known. */
function place_text(device, unit) {
  const here = place(device, unit);
  if (here == null) return "-";
  return here.mm == null ? t("turns", { turns: number(here.turns), degrees: number(here.degrees, 2) }) : `${number(here.mm, 3)} mm`;
}

function reply_text(input) {
  const [write, service, data] = ["read_write", "service", "data"].map((name) => field(bits(input), FIELDS.find(([other]) => other === name)));
  return t("why.in_service", { access: t(write ? "access.write" : "access.read"), service: hex(service, 2), name: t(`service.${service}`), data: number(data) });
}

/** The verdict in sentences; none if all is well. */
export function reasons(device, ring) {
  const { verdict, why, status } = device;
  if (verdict === "stale") return [t("why.stale", { age: span(device.age_ns ?? 0) })];
  if (verdict === "ring_stopped") return ring.diagnosis.parameter == null ? [] : [t("why.ring_stopped", { says: parameter_text(ring.diagnosis.parameter) })];
  if (verdict === "in_service") return [reply_text(device.in)];
  if (verdict === "implausible_bits") return [t("why.implausible_bits", { word: device.in })];
  if (why != null) return [t(`why.${verdict}`, { from: why.from, to: why.to, within: why.within_ns == null ? "" : span(why.within_ns), measuring_length: why.measuring_length })];
  if (verdict === "faulty") return [t("why.faulty"), ...(status == null ? [t("why.faulty.unknown")] : status_texts(status))];
  return device.text == null ? [] : [device.text];
}

/** What was found of a jump. */
export function likely_text({ cause, certainty, alternatives }) {
  const or = alternatives.map((other) => t(`cause.${other}`)).join("; ");
  return `${t("likely", { cause: t(`cause.${cause}`), certainty: t(`certainty.${certainty}`) })} ${or ? t("diagnosis.or", { or }) : ""}`;
}

/** The lamps, where they can be seen. */
const lamps_text = (lamps) => (lamps == null ? t("lamps.unseen") : ["u", "ba", "rc", "rd"].map((name) => t(lamps[name] ? "lamp.on" : "lamp.off", { name: name.toUpperCase(), meaning: t(`lamp.${name}`) })).join("; "));

/** Puts items into a list, if they are others. */
function list_of(properties) {
  const list = h("ul", properties);
  let drawn = "";
  return {
    list,
    show(items) {
      const is = JSON.stringify(items);
      if (is === drawn) return;
      drawn = is;
      list.replaceChildren(...items.map((text) => h("li", {}, text)));
    },
  };
}

function position(context) {
  // They are there when a jump is to be explained.
  ["diagnosis", "sheet"].forEach((name) => { more(name).catch(() => {}); });
  const rows = ["steps", "place", "hex", "binary", "gray", "in", "out", "age", "step", "lamps"].map((name) => [name, h("td", { class: ["step", "lamps"].includes(name) ? null : "mono", "data-row": name })]);
  const cells = Object.fromEntries(rows);
  const big = h("p", { class: "big mono", id: "value" });
  const of = h("p", { class: "small", id: "of" });
  const travel = h("meter", { min: 0, "aria-label": t("position") });
  const verdict = h("p", { id: "verdict" });
  const why = list_of({ id: "why" });
  const likely = list_of({ class: "small", id: "likely" });
  const causes = list_of({ class: "small", id: "step-changes" });
  const named = h("span");
  const turned = h("p", { class: "warn", id: "misread" });
  const blind = list_of({ class: "small", id: "blind" });
  const explained = h("button", { id: "acknowledge", onclick: () => context.order({ verb: "acknowledge", position: context.position }) }, t("acknowledge"));
  const jumped = h("div", {}, h("p", { class: "row" }, explained, h("span", { class: "small" }, t("acknowledge.when"))), likely.list, h("p", { class: "small" }, named), causes.list);
  const element = h("section", { class: "card double" }, h("h3", {}, t("position")), big, of, travel, verdict, why.list, turned, jumped, blind.list,
    h("table", {}, h("tbody", {}, rows.map(([name, cell]) => h("tr", {}, h("th", { scope: "row" }, t(`position.${name}`)), cell)))));
  return {
    element,
    update({ ring }) {
      const device = ring.devices[context.position];
      const { value, measuring_length: length } = device;
      const there = value != null;
      put(big, there ? number(value) : "-");
      put(of, !there ? "" : length == null ? t("of.unknown") : t("of", { length: number(length) }));
      travel.hidden = !there || length == null;
      if (!travel.hidden) [travel.max, travel.value] = [length, value];
      put(verdict, t(`worth.${device.verdict}`));
      attribute(verdict, "class", worth(device.verdict));
      why.show(reasons(device, ring));
      put(turned, device.misread == null ? "" : t(`misread.${device.misread}`));
      // Only a step of the position waits for somebody who explains it.
      jumped.hidden = device.why?.from == null;
      const { likely: found } = device;
      likely.show(found == null ? [] : [likely_text(found), ...found.evidence.map(said), ...found.apart.map((way) => `${t("diagnosis.apart")} ${said(way)}`)]);
      put(named, context.unit.step_changes.length > 0 ? t("step_changes") : "");
      causes.show((jumped.hidden ? [] : context.unit.step_changes).map(({ cause, remedy }) => `${said({ code: cause })}: ${said({ code: remedy })}`));
      blind.show(device.blind.map((name) => t(`blind.${name}`)));
      put(cells.steps, there ? String(value) : "-");
      put(cells.place, there ? place_text(device, context.unit) : "-");
      put(cells.hex, there ? `${hex(value, 6)}h` : "-");
      put(cells.binary, there ? binary(value) : "-");
      put(cells.gray, there ? binary(gray(value)) : "-");
      put(cells.in, device.in ?? "-");
      put(cells.out, device.out ?? "-");
      put(cells.age, device.age_ns == null ? "-" : span(device.age_ns));
      put(cells.step, t(`handshake.${device.handshake}`));
      put(cells.lamps, lamps_text(device.lamps));
    },
  };
}

/** A value with how it is known. */
function known_cell(known, unit) {
  if (known == null) return h("td", { class: "soft" }, t("known.not"));
  const from = known.from === "file" ? unit.file?.name ?? "" : known.time_ns == null ? "" : clock(known.time_ns);
  return h("td", {}, h("span", { class: "mono" }, String(known.value)), h("br"), h("span", { class: "small soft" }, t(`known.${known.from}`, { from })));
}

/** The accepted value; a model that takes values over at once has none. */
const accepted_cell = (known, unit) => (unit.at_once ? h("td", {}, "-") : known_cell(known, unit));

/** What a data check would say, or what is missing to tell. */
function check_text(device, unit) {
  if (device.data_check != null) {
    const found = status_texts(device.data_check);
    if (found.length > 0) return [t("check.bad", { status: `${device.data_check}h`, why: found.join("; ") }), "bad"];
    return unit.at_once ? [t("check.at_once"), null] : [`${t("check.good")} ${t("check.beside")}`, "good"];
  }
  const missing = device.parameters.filter(({ programmed }) => programmed == null).map(({ service }) => hex(service, 2));
  return [missing.length > 0 ? t("check.missing", { services: missing.join(", ") }) : t("check.plate"), "soft"];
}

/** Reads every value that can be read, one service after the other, once it is agreed to. */
async function read_all(context, status) {
  const { unit, position } = context;
  const wanted = unit.services.filter(({ number: service, read }) => read && service !== 8);
  if (!(await context.agreed(t("ask.read_all", { count: wanted.length, position, bus: context.about.bus })))) return;
  let done = 0;
  let doubtful = 0;
  for (const { number: service } of wanted) {
    put(status, t("read.now", { service: hex(service, 2), name: t(`service.${service}`) }));
    const answer = await context.carry_out({ verb: "service", position, service });
    if (answer == null) break;
    done += 1;
    if (answer.reply.error && answer.reply.data === 0) doubtful += 1;
  }
  put(status, `${t("read.done", { done, count: wanted.length })} ${doubtful > 0 ? t("read.doubtful", { doubtful }) : ""}`);
}

function parameters(context) {
  const { unit } = context;
  const body = h("tbody", { id: "known" });
  const check = h("p", { id: "data-check" });
  const status = h("p", { class: "small", id: "read-said", role: "status" });
  const read = h("button", { id: "read-all", disabled: !context.may_change, onclick: async () => {
    read.disabled = true;
    await read_all(context, status);
    read.disabled = false;
  } }, t("read.all"));
  const head = ["service", "programmed", "accepted", "active"].map((name) => h("th", { scope: "col" }, t(`column.${name}`)));
  const { file } = unit;
  const about = file == null ? t("file.none") : [t("file", { name: file.name }), file.taken == null ? "" : t("file.taken", { at: new Date(file.taken).toLocaleString(document.documentElement.lang) }),
    file.serial == null ? "" : t("file.serial", { serial: file.serial }), file.label ?? ""].filter(Boolean).join("; ");
  const element = h("section", { class: "card double" }, h("h3", {}, t("parameters")), context.about.simulated ? null : h("p", { class: "small", id: "file" }, about),
    h("div", { class: "scroll", tabindex: 0 }, h("table", { class: "known" }, h("thead", {}, h("tr", {}, head)), body)), check,
    h("div", { class: "row" }, read, context.may_change ? null : h("span", { class: "small soft" }, t("only_shows"))), status,
    h("p", { class: "small soft" }, t("known.how")), unit.at_once ? h("p", { class: "small soft" }, t("at_once")) : null);
  let drawn = "";
  return {
    element,
    update({ ring }) {
      const device = ring.devices[context.position];
      const is = JSON.stringify(device.parameters);
      if (is !== drawn) {
        drawn = is;
        body.replaceChildren(...device.parameters.map(({ service, programmed, accepted, active }) =>
          h("tr", { class: programmed != null && active != null && programmed.value !== active.value ? "differs" : null, "data-service": service }, h("th", { scope: "row" }, `${hex(service, 2)} ${t(`service.${service}`)}`),
            known_cell(programmed, unit), accepted_cell(accepted, unit), known_cell(active, unit))));
      }
      const [text, mood] = device.parameters.length === 0 ? ["", null] : check_text(device, unit);
      put(check, text);
      attribute(check, "class", mood);
    },
  };
}

export function create(context) {
  const parts = [position(context), parameters(context)];
  const element = h("div", {}, h("h2", {}, t("view.encoder")), h("div", { class: "row" }, context.choice()),
    h("div", { class: "grid" }, parts.map((part) => part.element), sheet(context)));
  return { element, update: (state) => parts.forEach((part) => part.update(state)) };
}
