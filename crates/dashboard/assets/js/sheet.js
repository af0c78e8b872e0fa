// The data sheet of an encoder, as its manual has it.

import { sheet as asked } from "./api.js";
import { h } from "./dom.js";
import { more, said, t } from "./texts.js";

/** What stands in a cell: a sentence, a number, a text of every language, what is not stated, or nothing. */
function shown(cell) {
  if (cell === false) return h("span", { class: "soft" }, t("sheet.not_stated"));
  if (cell === null || cell === "") return null;
  if (typeof cell === "number") return cell.toLocaleString(document.documentElement.lang);
  if (typeof cell === "string") return h("span", { class: "mono" }, cell.replaceAll("..", "..\u200b"));
  return said(cell);
}

function table({ columns, rows }) {
  const head = columns.map((name) => h("th", { scope: "col" }, t(`sheet.column.${name}`)));
  // What stands at the left of several rows stands there once.
  const first = (at) => JSON.stringify(rows[at]?.[0]);
  const left = (content, at) => (at > 0 && first(at) === first(at - 1) ? null : shown(content));
  const cell = (content, name) => h("td", { "data-column": t(`sheet.column.${name}`) }, content);
  const body = rows.map(([leftmost, ...others], at) => h("tr", {}, cell(left(leftmost, at), columns[0]), others.map((other, place) => cell(shown(other), columns[place + 1]))));
  return h("div", { class: "scroll", tabindex: 0 }, h("table", { class: "small sheet" }, h("thead", {}, h("tr", {}, head)), h("tbody", {}, body)));
}

function section(part) {
  const title = t(`section.${part.section}`);
  if (part.chapters === null) return h("details", { "data-section": part.section }, h("summary", {}, title), h("p", { class: "small soft" }, t("sheet.silent")));
  return h("details", { "data-section": part.section }, h("summary", {}, title), h("p", { class: "small soft" }, t("sheet.chapters", { chapters: part.chapters })),
    table(part), part.notes.map((note) => h("p", { class: "small" }, said(note))));
}

/** Puts all sections of a model into `place`, once they and their texts are here. */
export async function sections(model, place) {
  const [sheet] = await Promise.all([asked(model), more("sheet")]);
  place.replaceChildren(h("p", { class: "small soft" }, t("sheet.manual", { document: sheet.document })), ...sheet.sections.map(section));
}
