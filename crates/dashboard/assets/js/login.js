// The token, entered in a form: the server keeps it as a cookie that no script reads.

import { login } from "./api.js";
import { h, put } from "./dom.js";
import { t } from "./texts.js";

/** Asks for the token until it is right. */
export function enter(place, status) {
  return new Promise((done) => {
    const draw = () => {
      const token = h("input", { id: "token", type: "password", autocomplete: "off", size: 32, required: true });
      const said = h("p", { role: "status", class: "bad" }, status === 429 ? t("login.many") : "");
      const form = h("form", { id: "login", class: "card" }, h("h2", {}, t("login")), h("p", {}, t("login.why")),
        h("div", { class: "row" }, h("label", {}, t("login.token"), token), h("button", { class: "first" }, t("login.enter"))), said);
      form.addEventListener("submit", async (event) => {
        event.preventDefault();
        try {
          await login(token.value);
          removeEventListener("spoken", draw);
          done();
        } catch (error) {
          put(said, t(error.status === 429 ? "login.many" : "login.wrong"));
          token.select();
        }
      });
      place.replaceChildren(form);
      token.focus();
    };
    addEventListener("spoken", draw);
    draw();
  });
}
