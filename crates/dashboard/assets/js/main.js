// The frame around the views: which one is shown, in which language and theme, and what the ring tells.

import * as api from "./api.js";
import { attribute, h, put } from "./dom.js";
import { LANGUAGES, number, span, speak, t, usual, why } from "./texts.js";
import { hex, searches } from "./words.js";
import { ask } from "./ask.js";
import * as clock from "./clock.js";
import * as diagnosis from "./diagnosis.js";
import * as encoder from "./encoder.js";
import * as handshake from "./handshake.js";
import * as lessons from "./lessons.js";
import { enter } from "./login.js";
import * as ring from "./ring.js";
import * as trend from "./trend.js";

const VIEWS = { ring, encoder, handshake, trend, diagnosis, lessons };
/** The lessons set a ring up, which only a simulation lets them do. */
const OF_SIMULATION = ["lessons"];
const OF_ENCODER = ["encoder", "handshake", "trend"];
const page = { state: null, units: [], about: null, view: null, connected: false };

/** So long without a poll is said. */
const POLL_LATE_MS = 1000;

/** A ring that is looked at by polls. */
const polled = () => page.about.poll_ns != null;
const views = () => Object.keys(VIEWS).filter((name) => !polled() || !OF_SIMULATION.includes(name));

/** Says something for a while; screen readers read it too. */
function say(text) {
  const toast = document.getElementById("toast");
  put(toast, text);
  clearTimeout(say.timer);
  say.timer = setTimeout(() => put(toast, ""), 6000);
}

/** What a verb would do to a real encoder, to be agreed to. */
function asked(verb) {
  const { bus } = page.about;
  if (verb.verb === "out") return t("ask.out", { word: verb.word, position: verb.position, bus });
  const what = { service: hex(verb.service, 2), name: t(`service.${verb.service}`), value: verb.value ?? "", position: verb.position, bus };
  return t(verb.value == null ? "ask.read" : "ask.write", what);
}

/** Whoever writes to a real ring is asked first. */
const agreed = async (question) => !polled() || page.about.simulated || ask(question);

/** Has a verb carried out, and tells why not. On a real ring whoever writes is asked first. */
async function order(verb) {
  const writes = ["out", "service"].includes(verb.verb);
  return writes && !(await agreed(asked(verb))) ? null : carry_out(verb);
}

/** Has a verb carried out that was agreed to, and tells why not. */
async function carry_out(verb) {
  try {
    return await api.command(verb);
  } catch (error) {
    say(t("refused", { why: await why(error) }));
    return null;
  }
}

/** The view and the encoder that the address names. */
function wanted() {
  const [name, position] = location.hash.slice(1).split("/");
  const unit = page.units.find((unit) => unit.position === Number.parseInt(position ?? "0", 10)) ?? page.units[0];
  return { name: views().includes(name) ? name : "ring", position: unit.position, unit };
}

function navigation(current) {
  const links = views().map((name) => {
    const place = OF_ENCODER.includes(name) ? `#${name}/${current.position}` : `#${name}`;
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
  const { may_change } = page.about;
  const context = { ...current, units: page.units, about: page.about, polled: polled(), may_change, order, agreed, carry_out, say, choice: () => choice(current) };
  page.view = VIEWS[current.name].create(context);
  document.getElementById("main").replaceChildren(page.view.element);
  document.title = `${t(`view.${current.name}`)} - Encoring`;
  update();
}

function cycles_of(seen) {
  const { cycles, faulty_cycles, dropped_cycles } = seen.counters;
  const facts = [t("time", { time: span(seen.time_ns) }), t("cycle", { time: span(seen.cycle_ns) }),
    t("cycles", { cycles: number(cycles), faulty: number(faulty_cycles) })];
  if (dropped_cycles > 0) facts.push(t("dropped", { cycles: number(dropped_cycles) }));
  return facts;
}

/** A ring behind a bus: which, how often it is looked at, and whether anybody answers. */
function polls({ polls: made, poll_ns, link }) {
  const facts = [page.about.bus, page.about.simulated ? t("bus.simulated") : t("bus.real"),
    t(page.about.may_change ? "bus.asks" : "bus.reads"), t("bus.polls", { polls: number(made), every: span(poll_ns) })];
  // A poll that waits for an answer makes the last one old.
  const ago = clock.since_last();
  if (ago > POLL_LATE_MS) facts.push(t("bus.late", { ago: span(ago * 1e6) }));
  if (link.up != null) facts.push(link.up ? t("bus.up") : t("bus.down", { cause: t(`worth.${link.cause}`) }));
  return facts;
}

/** What the last data cycle says, or that the master looks for a fault: then no data come. */
function line_text(seen) {
  if (searches(seen)) return t("line.searching");
  if (seen.line === "silent" && seen.segment == null) return t("line.stands");
  return t(`line.${seen.line}`, { segment: seen.segment ?? "" });
}

function strip() {
  const facts = [page.connected ? t("connected") : t("not_connected")];
  if (page.state) {
    const { ring: seen } = page.state;
    facts.push(...(polled() ? polls(seen) : cycles_of(seen)), line_text(seen));
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
    if (page.about) show();
    else dispatchEvent(new Event("spoken"));
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
await begin();

/** Which ring it is; whoever must name a token is asked for it until it is right. */
async function begin() {
  settings();
  try {
    page.about = await api.about();
  } catch (error) {
    if (![401, 429].includes(error.status)) throw error;
    await enter(document.getElementById("main"), error.status);
    return begin();
  }
  page.units = await api.units();
  trend.collect(page);
  show();
  addEventListener("hashchange", show);
  api.follow(
    (state) => { page.state = state; clock.now(state.ring.time_ns); trend.seen(state); lessons.watch(state); soon(); },
    (connected) => { page.connected = connected; soon(); },
  );
}
