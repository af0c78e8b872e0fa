// The texts of the page: the server sends codes, the words are here, in each language.

export const LANGUAGES = ["en", "de"];

let texts = {};
/** The sentences of the server that were read so far: no key of one is one of the other. */
let sentences = {};
let language = "en";
/** The further texts that were read in this language. */
let read = new Set();

/** Reads the texts of a language. */
export async function speak(wanted) {
  language = LANGUAGES.includes(wanted) ? wanted : "en";
  const answer = await fetch(`/texts/${language}.json`);
  texts = await answer.json();
  sentences = {};
  read = new Set();
  document.documentElement.lang = language;
}

/** Reads the sentences of something that not every view needs. */
export async function more(name) {
  if (read.has(name)) return;
  const wanted = language;
  const answer = await fetch(`/texts/${wanted}/${name}.json`);
  const further = await answer.json();
  if (wanted !== language) return;
  Object.assign(sentences, further);
  read.add(name);
}

/** The language that was chosen here, else that of the browser. */
export function usual() {
  const chosen = localStorage.getItem("language");
  return chosen ?? (navigator.language.startsWith("de") ? "de" : "en");
}

/** A text with its values; a key without one shows itself. */
export function t(key, values = {}) {
  return filled(texts[key] ?? key, values);
}

function filled(text, values) {
  return text.replace(/\{(\w+)\}/g, (_, name) => values[name] ?? "");
}

/** A sentence of the server: its code and its values. What a manual states is its own code, in English. */
export function said({ code, values = {}, text }) {
  return filled(sentences[code] ?? text ?? code, Object.fromEntries(Object.entries(values).map(([name, value]) => [name, worded(name, value)])));
}

/** Why something was refused. */
export async function why(error) {
  if (!error.said) return error.message;
  try {
    await more("refusals");
  } catch {
    return error.message;
  }
  return said(error.said);
}

function worded(name, value) {
  if (value?.code) return said(value);
  // Causes and how sure they are come by their names.
  if (name === "cause") return t(`cause.${value}`);
  if (name === "certainty") return t(`certainty.${value}`);
  if (typeof value !== "number") return value;
  if (name.endsWith("_ns")) return span(value);
  return Number.isInteger(value) ? String(value) : value.toLocaleString(language);
}

/** A number as people of this language write it. */
export function number(value, digits) {
  const shape = digits == null ? {} : { minimumFractionDigits: digits, maximumFractionDigits: digits };
  return value.toLocaleString(language, shape);
}

/** A time of nanoseconds. */
export function span(ns) {
  if (ns < 1e6) return `${number(ns / 1e3, 0)} µs`;
  if (ns < 1e9) return `${number(ns / 1e6, 2)} ms`;
  return `${number(ns / 1e9, 3)} s`;
}
