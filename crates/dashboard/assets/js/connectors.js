// The connectors of an encoder with their pins, as its manual has them, and where the jumper is.

import { h } from "./dom.js";
import { more, said, t } from "./texts.js";

/** Which pins must be joined so that the next device is found. */
export const jumper_text = ({ jumper }) => (jumper == null ? "" : t("jumper.at", { connector: jumper.connector, from: jumper.pins[0], to: jumper.pins[1] }));

/** All of them, folded; their texts come when they are unfolded. */
export function connectors(unit) {
  if (unit.connectors.length === 0) return null;
  const pin = (signal, at) => h("tr", {}, h("th", { scope: "row" }, String(at + 1)), h("td", {}, said({ code: signal === "" ? "free" : signal })));
  const table = ({ name, pins }) => [h("p", { class: "small" }, said({ code: name })), h("table", { class: "small" }, h("tbody", {}, pins.map(pin)))];
  const place = h("div");
  const draw = async () => {
    await more("sheet");
    place.replaceChildren(...unit.connectors.flatMap(table), h("p", { class: "small" }, jumper_text(unit)));
  };
  const element = h("details", { ontoggle: () => element.open && place.children.length === 0 && draw() }, h("summary", {}, t("connectors")), place);
  return element;
}
