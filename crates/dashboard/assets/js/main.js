// The frame around the views: which one is shown, in which language and theme, and what the ring tells.

import * as api from "./api.js";
import { attribute, h, put } from "./dom.js";
import { LANGUAGES, number, span, speak, t, usual } from "./texts.js";
import * as encoder from "./encoder.js";
import * as handshake from "./handshake.js";
import * as lessons from "./lessons.js";
import * as ring from "./ring.js";
import * as trend from "./trend.js";

const VIEWS = { ring, encoder, handshake, trend, lessons };
const page = { state: null, units: [], view: null, connected: false };

/** Says something for a while; screen readers read it too. */
function say(text) {
  const toast = document.getElementById("toast");
  put(toast, text);
  clearTimeout(say.timer);
  say.timer = setTimeout(() => put(toast, ""), 6000);
}

/** Has a verb carried out, and tells why not. */
async function order(verb) {
  try {
    return await api.command(verb);
  } catch (error) {
    say(t("refused", { why: error.message }));
    return null;
  }
}

/** The view and the encoder that the address names. */
function wanted() {
  const [name, position] = location.hash.slice(1).split("/");
  const last = Math.max(page.units.length - 1, 0);
  return { name: VIEWS[name] ? name : "ring", position: Math.min(Number.parseInt(position ?? "0", 10) || 0, last) };
}

function navigation(current) {
  const links = Object.keys(VIEWS).map((name) => {
    const place = ["encoder", "handshake", "trend"].includes(name) ? `#${name}/${current.position}` : `#${name}`;
    return h("a", { href: place, "aria-current": name === current.name ? "page" : null }, t(`view.${name}`));
  });
  const nav = document.getElementById("nav");
  attribute(nav, "aria-label", t("nav"));
  nav.replaceChildren(...links);
}

/** The encoder that a view is about, to be chosen. */
function choice(current) {
  const options = page.units.map((unit) =>
    h("option", { value: unit.position, selected: unit.position === current.position },
      t("encoder.at", { position: unit.position, title: unit.title })));
  const change = (event) => { location.hash = `#${current.name}/${event.target.value}`; };
  return h("label", {}, t("encoder"), h("select", { id: "position", onchange: change }, options));
}

function show() {
  const current = wanted();
  page.view?.leave?.();
  navigation(current);
  const context = { ...current, unit: page.units[current.position], units: page.units, order, say, choice: () => choice(current) };
  page.view = VIEWS[current.name].create(context);
  document.getElementById("main").replaceChildren(page.view.element);
  document.title = `${t(`view.${current.name}`)} - Encoring`;
  update();
}

function strip() {
  const facts = [page.connected ? t("connected") : t("not_connected")];
  if (page.state) {
    const { ring: seen } = page.state;
    const { cycles, faulty_cycles, dropped_cycles } = seen.counters;
    facts.push(t("time", { time: span(seen.time_ns) }), t("cycle", { time: span(seen.cycle_ns) }),
      t("cycles", { cycles: number(cycles), faulty: number(faulty_cycles) }));
    if (dropped_cycles > 0) facts.push(t("dropped", { cycles: number(dropped_cycles) }));
    facts.push(t(`line.${seen.line}`, { segment: seen.segment ?? "" }));
  }
  const place = document.getElementById("strip");
  if (place.children.length !== facts.length) place.replaceChildren(...facts.map(() => h("span")));
  facts.forEach((fact, at) => put(place.children[at], fact));
}

function update() {
  strip();
  if (page.state && page.view) page.view.update(page.state);
}

function settings() {
  const choose = async (event) => {
    localStorage.setItem("language", event.target.value);
    await speak(event.target.value);
    settings();
    show();
  };
  const names = { en: "English", de: "Deutsch" };
  const languages = h("select", { id: "language", "aria-label": t("language"), onchange: choose },
    LANGUAGES.map((name) => h("option", { value: name, selected: name === document.documentElement.lang }, names[name])));
  const theme = h("button", { id: "theme", onclick: turn_theme }, t("theme"));
  document.getElementById("settings").replaceChildren(languages, theme);
  put(document.getElementById("skip"), t("skip"));
}

function turn_theme() {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
  localStorage.setItem("theme", root.dataset.theme);
  page.view?.theme?.();
}

let frame = 0;
function soon() {
  if (frame) return;
  frame = requestAnimationFrame(() => { frame = 0; update(); });
}

const theme = localStorage.getItem("theme");
if (theme) document.documentElement.dataset.theme = theme;
await speak(usual());
page.units = await api.units();
settings();
show();
addEventListener("hashchange", show);
trend.collect(page);
api.follow(
  (state) => { page.state = state; trend.seen(state); lessons.watch(state); soon(); },
  (connected) => { page.connected = connected; soon(); },
);
