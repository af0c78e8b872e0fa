// Position and speed over time, as the page has seen them.

import { h, put, save } from "./dom.js";
import { number, t } from "./texts.js";

/** So many samples are kept of each encoder: five minutes of the fastest frames. */
const KEPT = 6000;
const SPANS = [1, 3, 10, 60, 300];
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

export function create(context) {
  const list = samples[context.position] ?? [];
  const canvas = h("canvas", { role: "img", "aria-label": t("trend.canvas"), id: "trend" });
  let seconds = 10;
  let held = null;
  const spans = h("select", { id: "span", onchange: (event) => { seconds = Number(event.target.value); draw(); } }, SPANS.map((span) => h("option", { value: span, selected: span === seconds }, t("trend.span", { seconds: span }))));
  const hold = h("button", { onclick: () => { held = held == null ? list.at(-1)?.time ?? null : null; put(hold, t(held == null ? "trend.hold" : "trend.go")); draw(); } }, t("trend.hold"));
  const said = h("p", { class: "small mono" });
  let length = null;
  const part = (pen, points, top, bottom, label, stroke, x, wide) => {
    const values = points.filter((point) => point?.value != null).map((point) => point.value);
    pen.fillStyle = color("--soft");
    pen.fillText(label, 8, top + 12);
    if (values.length === 0) return;
    const [low, high] = extent(values);
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - top - 22);
    pen.fillText(number(high, 0), 8, top + 28);
    pen.fillText(number(low, 0), 8, bottom - 2);
    pen.strokeStyle = color("--edge");
    pen.strokeRect(0.5, top + 0.5, wide - 1, bottom - top);
    curve(pen, points, [x, y], stroke);
  };
  const draw = () => {
    const box = canvas.getBoundingClientRect();
    const scale = devicePixelRatio || 1;
    if (box.width === 0) return;
    canvas.width = Math.round(box.width * scale);
    canvas.height = Math.round(box.height * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.fillStyle = color("--card");
    pen.fillRect(0, 0, box.width, box.height);
    pen.font = "12px system-ui, sans-serif";
    const end = held ?? list.at(-1)?.time ?? 0;
    const begin = end - seconds * 1e9;
    const x = (time) => ((time - begin) / (end - begin)) * box.width;
    const inside = list.filter(({ time }) => time >= begin && time <= end);
    const middle = box.height * 0.6;
    part(pen, inside, 4, middle - 8, t("trend.position"), color("--out"), x, box.width);
    part(pen, speeds(inside, length), middle, box.height - 6, t("trend.speed"), color("--in"), x, box.width);
    for (const { time, position, what } of marks) {
      if (time < begin || time > end || (position != null && position !== context.position)) continue;
      pen.strokeStyle = pen.fillStyle = color("--bad");
      pen.beginPath();
      pen.moveTo(x(time), 0);
      pen.lineTo(x(time), box.height);
      pen.stroke();
      pen.fillText(t(`mark.${what}`), Math.min(x(time) + 3, box.width - 90), 12);
    }
    const last = inside.at(-1);
    put(said, last ? t("trend.now", { value: last.value == null ? t("off") : number(last.value), samples: number(inside.length) }) : "");
  };
  const csv = () => {
    const lines = list.map((sample) => [Math.round(sample.time / 1000), sample.out, sample.input, sample.value ?? ""].join(","));
    save(`trend-${context.position}.csv`, new Blob([`time_us,out,in,value\n${lines.join("\n")}\n`], { type: "text/csv" }));
  };
  const png = () => canvas.toBlob((blob) => save(`trend-${context.position}.png`, blob));
  const element = h("div", {}, h("h2", {}, t("view.trend")), h("p", { class: "soft" }, t("trend.intro")),
    h("div", { class: "row" }, context.choice(), h("label", {}, t("trend.zoom"), spans), hold, h("button", { onclick: csv }, t("save.csv")), h("button", { onclick: png }, t("save.png"))),
    canvas, said);
  return {
    element,
    update({ ring }) {
      length = ring.devices[context.position].parameters?.find(({ service }) => service === 2)?.active ?? null;
      draw();
    },
    theme: draw,
  };
}
