// A recording that is dropped on the page, and why the position jumped in it.

import { diagnose } from "./api.js";
import { attribute, h, put, save } from "./dom.js";
import { more, number, said, span, t, why } from "./texts.js";

const BYTES_MAX = 100_000_000;

/** What is being read, what was found last, and why the last one was not read: they stay while other views are looked at. */
let [running, last, failed] = [null, null, null];
/** What was said of tables of other programs. */
const said_of_table = { columns: "", decimal: false };
/** Draws what has changed, where the view is shown. */
let changed = () => {};

/** Why a recording was not read: the page's reason, the server's, nobody's connection, or that it was no longer wanted. */
async function why_not(error) {
  if (error.long) return t("diagnosis.long");
  if (error.status === 0) return t("diagnosis.lost");
  return error.status === null ? t("diagnosis.cancelled") : t("refused", { why: await why(error) });
}

/** Has a recording read. */
async function read(recording, about) {
  if (recording.size > BYTES_MAX) failed = { long: true };
  else {
    running = { ...diagnose(recording, about, (part) => { running.part = part; changed(); }), name: recording.name, part: 0 };
    failed = null;
    changed();
    try {
      last = { name: recording.name, answer: await running.done };
    } catch (error) {
      failed = error;
    }
    running = null;
  }
  changed();
}

function place(event) {
  const lines = event.line === event.to_line ? t("diagnosis.line", event) : t("diagnosis.lines", event);
  return `${lines}, ${span(event.time_us * 1000)}, ${t("diagnosis.at", event)}`;
}

/** An event in full, with its sentences. */
function found(event, number_of, { evidence, apart }) {
  const or = event.alternatives.map((cause) => t(`cause.${cause}`)).join("; ");
  return h("li", { class: "card", "data-cause": event.cause }, h("h3", {}, `${number_of + 1}. ${t(`cause.${event.cause}`)}`),
    h("p", { class: "small" }, `${t(`certainty.${event.certainty}`)}; ${place(event)}`),
    h("ul", { class: "small" }, evidence.map((sentence) => h("li", {}, said(sentence)))),
    or ? h("p", { class: "small" }, t("diagnosis.or", { or })) : null,
    apart.length > 0 ? h("p", { class: "small" }, t("diagnosis.apart"), " ", apart.map(said).join("; ")) : null);
}

function sentences(title, list) {
  return list.length === 0 ? null : h("section", { class: "card" }, h("h3", {}, title), h("ul", { class: "small" }, list.map((sentence) => h("li", {}, said(sentence)))));
}

/** What the manual has to say of step changes. */
function remedies_of(remedies) {
  if (remedies.length === 0) return null;
  const head = ["cause", "remedy"].map((name) => h("th", { scope: "col" }, t(`sheet.column.${name}`)));
  const rows = remedies.map(({ cause, remedy }) => h("tr", {}, h("td", { "data-column": t("sheet.column.cause") }, said(cause)), h("td", { "data-column": t("sheet.column.remedy") }, said(remedy))));
  return h("section", { class: "card", id: "remedies" }, h("p", { class: "small" }, t("diagnosis.manual")),
    h("div", { class: "scroll", tabindex: 0 }, h("table", { class: "small sheet" }, h("thead", {}, h("tr", {}, head)), h("tbody", {}, rows))));
}

/** The picture with its texts in the language of the page. */
function pictured({ picture, labels }) {
  const drawn = new DOMParser().parseFromString(picture, "image/svg+xml");
  const words = new Map(labels.map(({ text, said: sentence }) => [text, said(sentence)]));
  for (const node of drawn.querySelectorAll("text")) put(node, words.get(node.textContent) ?? node.textContent);
  return new Blob([new XMLSerializer().serializeToString(drawn)], { type: "image/svg+xml" });
}

/** The report and its picture. */
function report({ name, answer }) {
  const { report: { events }, said: { events: sentences_of, judged, limits, remedies }, rows, assumed } = answer;
  const image = pictured(answer);
  const [head, mood] = events.length > 0 ? [t("diagnosis.found", { count: number(events.length) }), "warn"] : answer.judged && judged.length > 0 ? [t("diagnosis.none"), "good"] : [t("diagnosis.unjudged"), "warn"];
  return [
    h("section", { class: "card" }, h("h3", {}, name), h("p", { id: "found-what", class: mood }, head),
      h("p", { class: "small soft" }, t("diagnosis.rows", { rows: number(rows) }), assumed ? h("span", { lang: "en" }, ` ${assumed}`) : null),
      answer.left_out == null ? null : h("p", { class: "small warn" }, t("diagnosis.left_out", { line: answer.left_out })),
      answer.may_be_decimal ? h("p", { class: "small warn" }, t("diagnosis.may_be_decimal")) : null,
      h("div", { class: "row" }, h("button", { onclick: () => save("diagnosis.svg", image) }, t("save.svg")),
        h("button", { onclick: () => save("diagnosis.json", new Blob([JSON.stringify(answer.report)], { type: "application/json" })) }, t("save.json")))),
    h("div", { class: "scroll card", tabindex: 0, "aria-label": t("diagnosis.picture") }, h("img", { class: "picture", src: URL.createObjectURL(image), alt: t("diagnosis.picture") })),
    h("ol", { class: "plain grid", id: "events-found" }, events.map((event, at) => found(event, at, sentences_of[at]))),
    remedies_of(remedies),
    h("div", { class: "grid" }, sentences(t("diagnosis.judged"), judged), sentences(t("diagnosis.limits"), limits)),
  ];
}

export function create(context) {
  const status = h("p", { id: "diagnosis-said", role: "status" });
  const shown = h("div", { class: "report" });
  const model = h("select", { id: "diagnosis-model" }, h("option", { value: "" }, t("diagnosis.model.named")),
    context.about.models.map((name) => h("option", { value: name }, name.toUpperCase())));
  const columns = h("input", { id: "diagnosis-columns", spellcheck: "false", size: 34, value: said_of_table.columns, oninput: () => { said_of_table.columns = columns.value; } });
  const decimal = h("input", { type: "checkbox", id: "diagnosis-decimal", checked: said_of_table.decimal, onchange: () => { said_of_table.decimal = decimal.checked; } });
  const table = h("details", { open: said_of_table.columns !== "" || said_of_table.decimal }, h("summary", {}, t("diagnosis.table")),
    h("div", { class: "row" }, h("label", {}, t("diagnosis.columns"), columns), h("label", {}, decimal, t("diagnosis.decimal"))), h("p", { class: "small soft" }, t("diagnosis.columns.how")));
  const file = h("input", { type: "file", id: "recording", accept: ".csv,.txt,text/csv", onchange: () => take(file.files[0]) });
  const zone = h("label", { class: "drop card", id: "drop" }, h("span", {}, t("diagnosis.drop")), file);
  const bar = h("progress", { max: 1, id: "diagnosis-progress", "aria-label": t("diagnosis.progress") });
  const going = h("div", { class: "row" }, bar, h("button", { id: "diagnosis-cancel", onclick: () => running?.cancel() }, t("diagnosis.cancel")));
  const take = async (recording) => {
    if (!recording) return;
    if (running) context.say(t("diagnosis.busy"));
    else await read(recording, { model: model.value, columns: columns.value, decimal: decimal.checked });
    file.value = "";
  };
  let drawn = null;
  const draw = async () => {
    going.hidden = !running;
    if (running) bar.value = running.part;
    const reason = failed ? await why_not(failed) : "";
    put(status, running ? t("diagnosis.reading", running) : failed ? reason : "");
    attribute(status, "class", running || failed?.status === null ? "soft" : "bad");
    if (drawn === last) return;
    drawn = last;
    await Promise.all([more("diagnosis"), more("sheet")]);
    shown.replaceChildren(...report(drawn).filter((part) => part !== null));
  };
  const over = (is) => (event) => {
    event.preventDefault();
    zone.classList.toggle("over", is);
  };
  zone.addEventListener("dragover", over(true));
  zone.addEventListener("dragleave", over(false));
  zone.addEventListener("drop", (event) => {
    over(false)(event);
    take(event.dataTransfer.files[0]);
  });
  changed = draw;
  draw();
  const element = h("div", {}, h("h2", {}, t("view.diagnosis")), h("p", { class: "soft" }, t("diagnosis.intro")),
    h("div", { class: "row" }, h("label", {}, t("diagnosis.model"), model)), table, zone, status, going, shown);
  return { element, update() {}, leave: () => { changed = () => {}; } };
}
