// The connectors of an encoder with their pins, as its manual has them, and where the jumper is.

import { h } from "./dom.js";
import { t } from "./texts.js";

/** Which pins must be joined so that the next device is found. */
export const jumper_text = ({ jumper }) => (jumper == null ? "" : t("jumper.at", { connector: jumper.connector, from: jumper.pins[0], to: jumper.pins[1] }));

/** All of them, folded; the signals have the names of the manual. */
export function connectors(unit) {
  if (unit.connectors.length === 0) return null;
  const table = ({ name, pins }) => [h("p", { class: "small", lang: "en" }, name),
    h("table", { class: "small" }, h("tbody", {}, pins.map((signal, at) => h("tr", {}, h("th", { scope: "row" }, String(at + 1)), h("td", { lang: "en" }, signal)))))];
  return h("details", {}, h("summary", {}, t("connectors")), unit.connectors.map(table), h("p", { class: "small" }, jumper_text(unit)));
}
