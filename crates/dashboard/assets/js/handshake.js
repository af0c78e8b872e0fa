// The handshake of one encoder: the figure, both words field by field, the history, and a console to issue services.

import { history } from "./api.js";
import { attribute, h, put, save } from "./dom.js";
import { figure } from "./figure.js";
import { number, span, t } from "./texts.js";
import { FIELDS, bits, field, hex, request, value } from "./words.js";

const SHOWN = 15;
const ROWS = 200;
const KEPT = 8192;

/** A word, field by field. */
function word(title, id) {
  const fields = FIELDS.map((shape) => {
    const [name, high, low] = shape;
    const content = h("div", { class: "mono" });
    const box = h("div", {}, h("div", { class: "small soft" }, `${high === low ? high : `${high}..${low}`} ${t(`field.${name}`)}`), content);
    return { shape, box, content };
  });
  const whole = h("span", { class: "mono", id });
  const element = h("section", { class: "card" }, h("h3", {}, title, " ", whole), h("div", { class: "word" }, fields.map(({ box }) => box)));
  return {
    element,
    update(text) {
      put(whole, text);
      if (text == null) {
        put(whole, "-");
        fields.forEach(({ content }) => put(content, "-"));
        return;
      }
      const now = bits(text);
      const service_mode = now >>> 31 === 1;
      for (const { shape, box, content } of fields) {
        const found = field(now, shape);
        const [name] = shape;
        const named = name === "service" && service_mode ? ` ${t(`service.${found}`)}` : "";
        put(content, name === "data" ? `${hex(found, 6)}h = ${number(found)}` : name === "service" ? `${hex(found, 1)}h${named}` : String(found));
        box.classList.toggle("set", name !== "data" && name !== "service" && found === 1);
      }
    },
  };
}

/** The changes of an encoder's words, fetched when the state says that there are more. */
export function changes(position) {
  const kept = { list: [], missed: 0, next: 0 };
  let asking = false;
  kept.follow = async (count) => {
    if (asking || count <= kept.next) return false;
    asking = true;
    try {
      const more = await history(position, kept.next);
      kept.missed += more.missed;
      kept.next = more.next;
      kept.list.push(...more.changes);
      kept.list.splice(0, Math.max(0, kept.list.length - KEPT));
      return true;
    } catch {
      return false;
    } finally {
      asking = false;
    }
  };
  return kept;
}

function step_text(change) {
  const steps = [change.out_step, change.in_step].filter(Boolean).map((step) => `${step} ${t(`step.${step}`)}`).join("; ") || t("step.none");
  if (change.unseen.length === 0) return steps;
  return `${steps} (${t("history.unseen", { phases: change.unseen.join(", "), within: span(change.within_ns) })})`;
}

function past(context, kept) {
  const drawing = h("div", { class: "scroll", tabindex: 0, id: "figure", "aria-label": t("figure.scroll") });
  const slider = h("input", { type: "range", min: 0, max: 0, value: 0, "aria-label": t("history.scroll"), id: "scroll" });
  const body = h("tbody", { id: "history" });
  const note = h("p", { class: "small warn" });
  let newest = true;
  const draw = () => {
    const last = kept.list.length;
    slider.max = Math.max(0, last - SHOWN);
    if (newest) slider.value = slider.max;
    const from = Number(slider.value);
    drawing.replaceChildren(figure(kept.list.slice(from, from + SHOWN)));
    const rows = kept.list.slice(Math.max(0, last - ROWS)).reverse();
    body.replaceChildren(...rows.map((change) => h("tr", {}, h("td", { class: "num mono" }, String(change.number)), h("td", { class: "mono" }, span(change.time_ns)),
      h("td", {}, step_text(change)), h("td", { class: "mono" }, change.out), h("td", { class: "mono" }, change.in))));
    const { poll_ns } = context.about;
    const missed = kept.missed > 0 ? t("history.missed", { missed: number(kept.missed) }) : "";
    put(note, poll_ns == null ? missed : `${t("history.polled", { every: span(poll_ns) })} ${missed}`);
  };
  slider.addEventListener("input", () => { newest = slider.value === slider.max; draw(); });
  const csv = () => {
    const lines = kept.list.map((c) => [c.number, c.time_ns, c.out_step ?? "", c.in_step ?? "", c.out, c.in, c.within_ns, c.unseen.join(" ")].join(","));
    save(`history-${context.position}.csv`, new Blob([`number,time_ns,out_step,in_step,out,in,within_ns,unseen\n${lines.join("\n")}\n`], { type: "text/csv" }));
  };
  const svg = () => {
    const copy = drawing.querySelector("svg").cloneNode(true);
    const style = document.createElementNS("http://www.w3.org/2000/svg", "style");
    style.textContent = "path{fill:none;stroke-width:2.5}.out{stroke:#0b5c80}.in{stroke:#a3480b}text{font:12px sans-serif}.guide{stroke:#999;stroke-dasharray:3 3}circle{fill:#fff;stroke:#000}";
    copy.prepend(style);
    save(`handshake-${context.position}.svg`, new Blob([new XMLSerializer().serializeToString(copy)], { type: "image/svg+xml" }));
  };
  const head = ["number", "time", "step", "out", "in"].map((name) => h("th", { scope: "col", class: name === "number" ? "num" : null }, t(`column.${name}`)));
  const shown = h("section", { class: "card wide" }, h("h3", {}, t("figure.title")), drawing, slider,
    h("div", { class: "row" }, h("button", { onclick: svg }, t("save.svg")), h("button", { onclick: csv }, t("save.csv"))));
  const list = h("section", { class: "card wide" }, h("h3", {}, t("history")), note,
    h("div", { class: "scroll list", tabindex: 0 }, h("table", {}, h("thead", {}, h("tr", {}, head)), body)));
  draw();
  return { shown, list, draw };
}

/** Services, step by step or in one go. */
function console_of(context) {
  const { unit, position } = context;
  const services = h("select", { id: "service" }, unit.services.map(({ number: service }) => h("option", { value: service }, `${hex(service, 2)} ${t(`service.${service}`)}`)));
  const access = h("select", { id: "access" });
  const data = h("input", { id: "data", value: "9999", inputmode: "text", size: 12 });
  const answer = h("p", { id: "answer", role: "status" });
  const out = h("p", { class: "mono", id: "next-out" });
  const chosen = () => unit.services.find(({ number: service }) => service === Number(services.value));
  const writes = () => access.value === "write";
  const wanted = (bit) => {
    const number_of = writes() ? value(data.value) : 0;
    if (!(number_of >= 0 && number_of <= 0xffffff)) {
      context.say(t("console.value"));
      return null;
    }
    return hex(request(chosen().number, writes(), number_of, bit), 8);
  };
  const fit = () => {
    const { read, write } = chosen();
    const offered = [read ? "read" : null, write ? "write" : null].filter(Boolean);
    const before = access.value;
    access.replaceChildren(...offered.map((name) => h("option", { value: name }, t(`access.${name}`))));
    if (offered.includes(before)) access.value = before;
    told();
  };
  const told = () => {
    data.disabled = !writes();
    const word_of = hex(request(chosen().number, writes(), writes() ? value(data.value) || 0 : 0, true), 8);
    put(out, t("console.word", { word: word_of }));
  };
  services.addEventListener("change", fit);
  access.addEventListener("change", told);
  data.addEventListener("input", told);
  const send = async (word_of) => word_of && context.order({ verb: "out", position, word: word_of });
  const go = async () => {
    if (wanted(true) === null) return;
    const asked = { verb: "service", position, service: chosen().number };
    if (writes()) asked.value = value(data.value);
    const done = await context.order(asked);
    if (!done) return put(answer, "");
    const { data: got, error } = done.reply;
    put(answer, t(error ? "reply.error" : "reply.good", { hex: `${hex(got, 6)}h`, data: number(got) }));
    attribute(answer, "class", error ? "bad" : "good");
  };
  const steps = [
    h("button", { id: "step1", onclick: () => send(wanted(false)) }, "1 ", t("do.1")),
    h("button", { id: "step2", onclick: () => send(wanted(true)) }, "2 ", t("do.2")),
    h("button", { id: "step4", onclick: () => send(wanted(false)) }, "4 ", t("do.4")),
  ];
  const free = h("input", { id: "word", value: "00000000", size: 12, spellcheck: "false" });
  const rules = h("ol", { class: "rules small" }, [1, 2, 3, 4, 5].map((step) => h("li", {}, t(`rule.${step}`))));
  fit();
  if (chosen().write) { access.value = "write"; told(); }
  [...steps].forEach((button) => { button.disabled = !context.may_change; });
  const go_button = h("button", { class: "first", id: "go", onclick: go, disabled: !context.may_change }, t("do.all"));
  const write_button = h("button", { id: "write", onclick: () => send(free.value), disabled: !context.may_change }, t("console.write"));
  const element = h("section", { class: "card" }, h("h3", {}, t("console")), context.may_change ? null : h("p", { class: "soft", id: "only-shows" }, t("only_shows")),
    h("div", { class: "row" }, h("label", {}, t("console.service"), services), h("label", {}, t("console.access"), access), h("label", {}, t("console.data"), data)), out,
    h("div", { class: "row" }, steps, go_button), answer,
    h("div", { class: "row" }, h("label", {}, t("console.raw"), free), write_button), rules);
  return {
    element,
    update(device) {
      const [requested, replied] = [bits(device.out) >>> 31, bits(device.in) >>> 31];
      const at = requested ? (replied ? 2 : 1) : replied ? 3 : 0;
      [...rules.children].forEach((rule, k) => attribute(rule, "aria-current", k === at ? "step" : null));
    },
  };
}

/** The referee's findings of this encoder. */
function referee(context) {
  const list = h("ul", { class: "plain", id: "referee" });
  const element = h("section", { class: "card" }, h("h3", {}, t("referee")), list);
  let drawn = "";
  return {
    element,
    update({ ring: { referee: judged } }) {
      const found = judged?.findings.filter(({ position }) => position === context.position) ?? null;
      const is = JSON.stringify([found, found?.length === 0 ? judged.services : null]);
      if (is === drawn) return;
      drawn = is;
      const lines = found == null ? [h("li", { class: "soft" }, t("referee.off"))]
        : found.length === 0 ? [h("li", { class: "good" }, context.polled ? t("referee.polled") : t("referee.good", { services: number(judged.services) }))]
          : found.map(({ rule, verdict, severity, count, statement }) => h("li", {}, h("span", { class: severity === "error" ? "bad" : "warn" }, t(`broken.${rule}`)), " ",
            h("span", { class: "small soft" }, t("referee.count", { verdict: t(`verdict.${verdict}`), count: number(count), statement })),
            h("p", { class: "small", "data-advice": rule }, t(`advice.${rule}`))));
      list.replaceChildren(...lines);
    },
  };
}

export function create(context) {
  const kept = changes(context.position);
  const [out, input] = [word("OUT", "out"), word("IN", "in")];
  const console_part = console_of(context);
  const { shown, list, draw } = past(context, kept);
  const judged = referee(context);
  const said = h("p", { id: "phase" });
  const element = h("div", {}, h("h2", {}, t("view.handshake")), h("div", { class: "row" }, context.choice(), said),
    h("div", { class: "grid" }, shown, console_part.element, out.element, input.element, judged.element, list));
  return {
    element,
    update(state) {
      const { ring, changes: counts } = state;
      judged.update(state);
      const device = ring.devices[context.position];
      out.update(device.out);
      input.update(device.in);
      put(said, t(`handshake.${device.handshake}`));
      console_part.update(device);
      kept.follow(counts[context.position]).then((more) => more && draw());
    },
  };
}
