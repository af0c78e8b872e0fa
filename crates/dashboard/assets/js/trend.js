// Position and speed over time, as the page has seen them.

import { h, put, save } from "./dom.js";
import { chosen_on, closer, farther, part_of } from "./part.js";
import { number, t } from "./texts.js";
import { active } from "./words.js";

/** So many samples are kept of each encoder: five minutes of the fastest frames. */
const KEPT = 6000;
const SPANS = [1, 3, 10, 60, 300];
const USUAL = 10;
/** So far apart the times below the curves are at least, in pixels. */
const TIMES_APART = 90;
const samples = [];
const marks = [];

/** Begins to keep samples. */
export function collect(page) {
  page.units.forEach(({ position }) => { samples[position] = []; });
}

/** Keeps what a state shows. */
export function seen({ ring }) {
  samples.forEach((list, position) => {
    const device = ring.devices[position];
    const last = list.at(-1);
    if (last && ring.time_ns <= last.time) return;
    list.push({ time: ring.time_ns, value: device.value, out: device.out, input: device.in, error: device.error });
    if (list.length > KEPT) list.shift();
    if (device.on != null && last && (last.value == null) !== (device.value == null)) mark(ring.time_ns, position, device.value == null ? "off" : "on");
    // A reply in between is no news.
    if (last && device.verdict != null && device.verdict !== "in_service") {
      const doubted = !["valid", "unchecked"].includes(device.verdict);
      if (list.doubted != null && list.doubted !== doubted) mark(ring.time_ns, position, doubted ? "doubted" : "believed");
      list.doubted = doubted;
    }
    if (last && last.error !== device.error) mark(ring.time_ns, position, device.error ? "error" : "error_over");
  });
  const before = seen.line ?? ring.line;
  if (before !== ring.line) mark(ring.time_ns, null, ring.line === "good" ? "line_good" : "line_bad");
  seen.line = ring.line;
}

function mark(time, position, what) {
  marks.push({ time, position, what });
  if (marks.length > 500) marks.shift();
}

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function extent(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return low === high ? [low - 1, high + 1] : [low, high];
}

/** Speeds between neighbours, in steps a second; none across a gap or the jump where the range begins again. */
function speeds(list, length) {
  return list.slice(1).map((sample, k) => {
    const before = list[k];
    if (sample.value == null || before.value == null) return null;
    let moved = sample.value - before.value;
    if (length && Math.abs(moved) > length / 2) moved -= Math.sign(moved) * (length + 1);
    return { time: sample.time, value: (moved * 1e9) / (sample.time - before.time) };
  });
}

function curve(pen, points, [x, y], stroke) {
  pen.strokeStyle = stroke;
  pen.lineWidth = 1.8;
  pen.beginPath();
  let down = false;
  for (const point of points) {
    if (point == null || point.value == null) { down = false; continue; }
    if (down) pen.lineTo(x(point.time), y(point.value));
    else pen.moveTo(x(point.time), y(point.value));
    down = true;
  }
  pen.stroke();
}

/** Times between two, round ones. */
function round_times(begin, end, most) {
  const rough = (end - begin) / Math.max(most, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((times) => times * power).find((each) => each >= rough);
  const times = [];
  for (let time = Math.ceil(begin / step) * step; time <= end; time += step) times.push(time || 0);
  return { times, digits: Math.max(0, -Math.floor(Math.log10(step / 1e9) + 1e-9)) };
}

const seconds = (ns, digits = 3) => `${number(ns / 1e9, digits)} s`;

/** What stands at a time of one encoder. */
const marks_of = (position, begin, end) => marks.filter((mark) => mark.time >= begin && mark.time <= end && (mark.position == null || mark.position === position));

/** One curve with its extent; `place` is top, bottom and width. */
function panel(pen, points, label, stroke, x, { top, bottom, wide }) {
  const values = points.filter((point) => point?.value != null).map((point) => point.value);
  pen.fillStyle = color("--soft");
  pen.fillText(label, 8, top + 12);
  pen.strokeStyle = color("--edge");
  pen.lineWidth = 1;
  pen.strokeRect(0.5, top + 0.5, wide - 1, bottom - top);
  if (values.length === 0) return;
  const [low, high] = extent(values);
  const y = (value) => bottom - 4 - ((value - low) / (high - low)) * (bottom - top - 24);
  curve(pen, points, [x, y], stroke);
  pen.fillStyle = color("--soft");
  pen.fillText(number(high, 0), 8, top + 28);
  pen.fillText(number(low, 0), 8, bottom - 4);
}

/** The times below, and what happened. */
function axis(pen, position, { begin, end }, x, { height, wide }) {
  const { times, digits } = round_times(begin, end, wide / TIMES_APART);
  // Before 0 there was nothing.
  for (const time of times.filter((time) => time >= 0)) {
    pen.strokeStyle = color("--edge");
    pen.beginPath();
    pen.moveTo(x(time), height - 20);
    pen.lineTo(x(time), height - 14);
    pen.stroke();
    const text = seconds(time, digits);
    pen.fillStyle = color("--soft");
    pen.fillText(text, Math.min(Math.max(x(time) - pen.measureText(text).width / 2, 2), wide - pen.measureText(text).width - 2), height - 3);
  }
  let room = [];
  for (const { time, what } of marks_of(position, begin, end)) {
    pen.strokeStyle = pen.fillStyle = color("--bad");
    pen.beginPath();
    pen.moveTo(x(time), 0);
    pen.lineTo(x(time), height - 20);
    pen.stroke();
    // Each text on the first line where it covers no other.
    const text = t(`mark.${what}`);
    const width = pen.measureText(text).width;
    const at = Math.min(x(time) + 3, wide - width - 4);
    const line = [0, 1, 2, 3].find((line) => !room.some((other) => other.line === line && at < other.end && at + width + 6 > other.at)) ?? 0;
    room.push({ line, at, end: at + width + 6 });
    pen.fillText(text, at, 44 + 15 * line);
  }
}

/** A range that is being dragged, and where the pointer is. */
function pointer(pen, dragged, at, { height, wide }) {
  if (dragged) {
    pen.fillStyle = color("--main");
    pen.globalAlpha = 0.2;
    pen.fillRect(dragged[0] * wide, 0, (dragged[1] - dragged[0]) * wide, height - 20);
    pen.globalAlpha = 1;
  }
  if (at == null) return;
  pen.strokeStyle = color("--soft");
  pen.setLineDash([3, 3]);
  pen.beginPath();
  pen.moveTo(at * wide, 0);
  pen.lineTo(at * wide, height - 20);
  pen.stroke();
  pen.setLineDash([]);
}

/** What is shown, as a table: each sample, with what happened since the one before. */
function table(list, position, { begin, end }) {
  const shown = list.filter(({ time }) => time >= begin && time <= end);
  const rows = shown.map((sample, k) => {
    const since = k === 0 ? begin : shown[k - 1].time + 1;
    const what = marks_of(position, since, sample.time).map((mark) => mark.what).join(" ");
    return [Math.round(sample.time / 1000), sample.out ?? "", sample.input ?? "", sample.value ?? "", what].join(",");
  });
  return `time_us,out,in,value,event\n${rows.map((row) => `${row}\n`).join("")}`;
}

/** The buttons, and which part is shown. */
function controls(part, draw, saves) {
  const spans = h("select", { id: "span", onchange: (event) => {
    if (event.target.value === "") return;
    part.span = Number(event.target.value) * 1e9;
    draw();
  } }, h("option", { value: "" }, t("trend.other")), SPANS.map((span) => h("option", { value: span }, t("trend.span", { seconds: span }))));
  const button = (id, text, does) => h("button", { id, onclick: () => { does(part); draw(); } }, text);
  const hold = h("button", { id: "hold", onclick: () => { if (part.end == null) part.hold(); else part.follow(); draw(); } });
  const element = h("div", {}, h("div", { class: "row" }, h("label", {}, t("trend.zoom"), spans), hold, saves),
    h("div", { class: "row" }, button("closer", t("trend.closer"), closer), button("farther", t("trend.farther"), farther),
      button("earlier", t("trend.earlier"), () => part.move(-0.5)), button("later", t("trend.later"), () => part.move(0.5)), button("reset", t("trend.reset"), () => part.reset())));
  return {
    element,
    update() {
      const preset = SPANS.find((span) => Math.abs(span * 1e9 - part.span) < 1);
      if (document.activeElement !== spans) spans.value = preset ?? "";
      put(hold, t(part.end == null ? "trend.hold" : "trend.go"));
    },
  };
}

export function create(context) {
  const { position, unit } = context;
  const list = samples[position] ?? [];
  const canvas = h("canvas", { role: "application", tabindex: 0, "aria-label": t("trend.canvas"), "aria-describedby": "trend-how", id: "trend" });
  const said = h("p", { class: "small mono", id: "trend-said" });
  const part = part_of(() => ({ first: list[0]?.time ?? 0, last: list.at(-1)?.time ?? 0 }), USUAL * 1e9);
  let [length, dragged, at] = [null, null, null];
  const csv = h("button", { id: "csv", onclick: () => save(`trend-${position}.csv`, new Blob([table(list, position, part.range())], { type: "text/csv" })) }, t("save.csv"));
  const png = h("button", { id: "png", onclick: () => { at = null; draw(); canvas.toBlob((blob) => save(`trend-${position}.png`, blob)); } }, t("save.png"));
  const draw = () => {
    const { width: wide, height } = canvas.getBoundingClientRect();
    const scale = devicePixelRatio || 1;
    if (wide === 0) return;
    canvas.width = Math.round(wide * scale);
    canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.fillStyle = color("--card");
    pen.fillRect(0, 0, wide, height);
    pen.font = "12px system-ui, sans-serif";
    const range = part.range();
    const { begin, end } = range;
    const x = (time) => ((time - begin) / (end - begin)) * wide;
    const inside = list.filter(({ time }) => time >= begin && time <= end);
    const middle = height * 0.58;
    panel(pen, inside, `${t("encoder.at", { position, title: unit.title })}: ${t("trend.position")}`, color("--out"), x, { top: 2, bottom: middle - 8, wide });
    panel(pen, speeds(inside, length), t("trend.speed"), color("--in"), x, { top: middle, bottom: height - 22, wide });
    axis(pen, position, range, x, { height, wide });
    pointer(pen, dragged, at, { height, wide });
    const before = at == null ? inside.at(-1) : inside.findLast(({ time }) => time <= begin + at * (end - begin));
    const value = before?.value == null ? "-" : number(before.value);
    put(said, inside.length === 0 ? t("trend.empty") : t(at == null ? "trend.now" : "trend.at", { value, at: seconds(before?.time ?? begin), samples: number(inside.length), from: seconds(Math.max(begin, 0)), to: seconds(end) }));
    buttons.update();
  };
  const buttons = controls(part, draw, [csv, png]);
  chosen_on(canvas, part, (range, pointed = null) => { [dragged, at] = [range, pointed]; draw(); });
  const element = h("div", {}, h("h2", {}, t("view.trend")), h("p", { class: "soft" }, t("trend.intro")),
    h("div", { class: "row" }, context.choice()), buttons.element, canvas, said, h("p", { class: "small soft", id: "trend-how" }, t("trend.how")));
  return {
    element,
    update({ ring }) {
      const device = ring.devices[position];
      // A rod has ends, and begins nowhere again.
      length = unit.kind === "rotary" ? active(device, 2) ?? device.measuring_length : null;
      if (dragged == null) draw();
    },
    theme: draw,
  };
}
