// A question before something is written to a real encoder.

import { h } from "./dom.js";
import { t } from "./texts.js";

/** Whether it is agreed to; to be closed otherwise is no. */
export function ask(question) {
  return new Promise((done) => {
    const no = h("button", { value: "no", autofocus: true }, t("ask.no"));
    const yes = h("button", { value: "yes", class: "first", "data-do": "agree" }, t("ask.yes"));
    const dialog = h("dialog", { "aria-labelledby": "question" }, h("form", { method: "dialog" },
      h("p", { id: "question" }, question), h("p", { class: "small soft" }, t("ask.why")), h("div", { class: "row" }, no, yes)));
    dialog.addEventListener("close", () => { dialog.remove(); done(dialog.returnValue === "yes"); });
    document.body.append(dialog);
    dialog.showModal();
  });
}
