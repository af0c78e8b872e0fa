// The page as people use it, in Chromium: node browser.mjs PROGRAM TOOLS PICTURES.
//
// The worked example by mouse and by keyboard alone, a broken segment, a shaft that is dragged, the five lessons, a
// recording that is dropped, a trend that is zoomed, a ring behind a gateway, a page behind a token, and every view in
// two languages, two themes and two widths. Nothing may be said on the console, asked of another place, or be wider than
// the screen, and what the page shows is what the API says.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { createInterface } from "node:readline";

const [program, tools, pictures] = process.argv.slice(2).map((path) => resolve(path));
const require = createRequire(`${tools}/`);
const { chromium } = require("playwright-core");
const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

/** The manuals' example: 1000 steps a turn over ten turns; number of the service and its value. */
const EXAMPLE = [[2, 9999], [3, 10], [9, 1]];

/** What a backup of the CE-65-M of the built-in ring says. */
const BACKUP = `version = 1
model = "ce-65-m"
[unit]
native = 4096
[parameters]
counting_direction = 0
measuring_length = 16777215
numerator = 4096
denominator = 1
ssi_values = 24
`;

const problems = [];

/** A program that runs while a part of the test does; it gets what its first line says, and the program. */
async function running(command, part) {
  const started = spawn(program, [...command, "--format", "json"], { stdio: ["ignore", "pipe", "inherit"] });
  try {
    const line = await new Promise((done, failed) => {
      createInterface({ input: started.stdout }).once("line", done);
      started.once("exit", () => failed(new Error(`${command[0]} has ended`)));
    });
    await part(JSON.parse(line), started);
  } finally {
    started.kill();
  }
}

/** A ring of its own for a part of the test. */
const ring = (part) => running(["sim", "--modbus", "off", "--web", "127.0.0.1:0"], ({ web }) => part(`http://${web}`));

/** A page that is looked at for everything that it must not do. */
async function open(browser, base, { width = 1440, language = "en", theme = "light", expected = [] } = {}) {
  const context = await browser.newContext({ viewport: { width, height: 900 } });
  await context.addInitScript(([language, theme]) => {
    localStorage.setItem("language", language);
    localStorage.setItem("theme", theme);
  }, [language, theme]);
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  const note = (what) => problems.push(`${language} ${theme} ${width} ${page.url()}: ${what}`);
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && !expected.some((text) => message.text().includes(text)) && note(message.text()));
  page.on("pageerror", (error) => note(error.stack));
  page.on("request", (request) => !request.url().startsWith(base) && !request.url().startsWith("blob:") && note(`asks ${request.url()}`));
  return page;
}

const state = async (base) => (await (await fetch(`${base}/api/state`)).json()).ring;
const text = (page, selector) => page.locator(selector).textContent();
const until = (page, selector, wanted) => page.waitForFunction(([selector, wanted]) => document.querySelector(selector)?.textContent.includes(wanted), [selector, wanted]);

/** What the example must have come to. */
async function example_holds(base) {
  // A frame may be older than the answer that the page has just shown.
  const active = async () => {
    const { parameters, data_check: check } = (await state(base)).devices[2];
    return [...EXAMPLE.map(([service]) => parameters.find((parameter) => parameter.service === service).active), check];
  };
  const wanted = [...EXAMPLE.map(([, value]) => value), "0000"];
  for (let k = 0; k < 1000 && String(await active()) !== String(wanted); k += 1);
  assert.deepEqual(await active(), wanted);
  const { changes } = await (await fetch(`${base}/api/history?position=2`)).json();
  const steps = changes.flatMap((change) => [change.out_step, change.in_step]).filter(Boolean);
  assert.deepEqual(steps.slice(0, 5), [1, 2, 3, 4, 5]);
}

async function by_mouse(browser, base) {
  const page = await open(browser, base);
  await page.goto(`${base}/#handshake/2`);
  for (const [service, value] of EXAMPLE) {
    await page.selectOption("#service", String(service));
    await page.fill("#data", String(value));
    await page.click("#step1");
    await until(page, "#out", (0x40000000 + service * 0x1000000 + value).toString(16).toUpperCase());
    await page.click("#step2");
    await page.waitForFunction(() => Number.parseInt(document.querySelector("#in").textContent, 16) >= 0x80000000);
    if (service === 2) await page.screenshot({ path: `${pictures}/acknowledged.png`, fullPage: true });
    await page.click("#step4");
    await page.waitForFunction(() => Number.parseInt(document.querySelector("#in").textContent, 16) < 0x80000000);
  }
  await page.selectOption("#service", "8");
  await page.click("#go");
  await until(page, "#answer", "Acknowledged: 0");
  await page.waitForFunction(() => document.querySelectorAll("#history tr").length >= 20);
  await page.screenshot({ path: `${pictures}/handshake.png`, fullPage: true });
  await example_holds(base);
  await page.context().close();
}

/** Goes on with Tab until this has the focus. */
async function tab_to(page, selector) {
  for (let k = 0; k < 60; k += 1) {
    if (await page.evaluate((selector) => document.activeElement?.matches(selector), selector)) return;
    await page.keyboard.press("Tab");
  }
  assert.fail(`Tab does not lead to ${selector}`);
}

async function by_keyboard(browser, base) {
  const page = await open(browser, base);
  await page.goto(`${base}/#ring`);
  await page.waitForSelector("main h2");
  await tab_to(page, 'nav a[href^="#handshake"]');
  await page.keyboard.press("Enter");
  await page.waitForSelector("#service");
  await tab_to(page, "#position");
  // The view of the encoder before stands until it is drawn anew.
  await page.evaluate(() => { document.querySelector("#service").dataset.before = "yes"; });
  await page.keyboard.type("2");
  await page.waitForURL("**/#handshake/2");
  await page.waitForSelector("#service:not([data-before])");
  const choose = async (selector, letters) => {
    await page.evaluate(() => document.activeElement.blur());
    await tab_to(page, selector);
    await page.keyboard.type(letters);
  };
  for (const [service, value] of EXAMPLE) {
    await choose("#service", `0${service}`);
    await tab_to(page, "#access");
    await page.keyboard.type("w");
    await tab_to(page, "#data");
    await page.keyboard.press("Control+A");
    await page.keyboard.type(String(value));
    await tab_to(page, "#go");
    await page.keyboard.press("Enter");
    await until(page, "#answer", `= ${value.toString(16).toUpperCase().padStart(6, "0")}h`);
  }
  await choose("#service", "08");
  await tab_to(page, "#go");
  await page.keyboard.press("Space");
  await until(page, "#answer", "Acknowledged: 0");
  await example_holds(base);
  await page.goto(`${base}/#encoder/1`);
  await tab_to(page, "#stop");
  await page.keyboard.press("Enter");
  await tab_to(page, "#dial").catch(async () => { await page.keyboard.press("Shift+Tab"); });
  await page.context().close();
}

async function broken_segment_and_lesson(browser, base) {
  const page = await open(browser, base);
  await page.goto(`${base}/#lessons`);
  await page.click('[data-lesson="break"]');
  await page.click('nav a[href="#ring"]');
  await page.click('[data-segment="2"] [data-do="break"]');
  await until(page, "#found", "device 2.0");
  await page.waitForSelector('[data-device="2"] .lamp[data-lamp="ba"]:not(.lit)');
  assert.equal((await state(base)).diagnosis.parameter, "0280");
  await until(page, "#events", "the ring ends before segment 2");
  await page.screenshot({ path: `${pictures}/broken.png`, fullPage: true });
  await page.click('[data-segment="2"] [data-do="mend"]');
  await until(page, "#found", "no fault");
  await page.waitForSelector('[data-device="2"] .lamp[data-lamp="ba"].lit');
  await page.click('nav a[href="#lessons"]');
  await until(page, '[data-card="break"]', "Passed.");
  await page.context().close();
}

async function dragged(browser, base) {
  const page = await open(browser, base);
  await page.goto(`${base}/#encoder/2`);
  await page.click("#stop");
  await page.focus("#dial");
  await page.keyboard.press("Home");
  await until(page, '[data-row="steps"]', "0");
  const box = await page.locator("#dial").boundingBox();
  const at = (turn) => [box.x + box.width / 2 + Math.sin(turn * 2 * Math.PI) * box.width * 0.3, box.y + box.height / 2 - Math.cos(turn * 2 * Math.PI) * box.height * 0.3];
  await page.mouse.move(...at(0));
  await page.mouse.down();
  for (let k = 1; k <= 10; k += 1) await page.mouse.move(...at(k / 40));
  await page.mouse.up();
  // A quarter of a turn of 4096 steps, as exactly as a pointer can be.
  await page.waitForFunction(() => Math.abs(Number(document.querySelector('[data-row="steps"]').textContent) - 1024) < 60);
  await page.keyboard.press("ArrowRight");
  const { value } = (await state(base)).devices[2];
  assert.ok(Math.abs(value - 1024) < 61, String(value));
  await page.waitForFunction(async () => {
    const { ring } = await (await fetch("/api/state")).json();
    return document.querySelector('[data-row="steps"]').textContent === String(ring.devices[2].value);
  });
  await page.screenshot({ path: `${pictures}/encoder.png`, fullPage: true });
  await page.context().close();
}

/** Presses something: by mouse, or with the keyboard alone. */
const BY = {
  mouse: { press: (page, selector) => page.click(selector), choose: (page, selector, value) => page.selectOption(selector, value), write: (page, selector, text) => page.fill(selector, text) },
  keyboard: {
    async press(page, selector) {
      await page.evaluate(() => document.activeElement.blur());
      await tab_to(page, selector);
      await page.keyboard.press("Enter");
    },
    async choose(page, selector, value) {
      await page.evaluate(() => document.activeElement.blur());
      await tab_to(page, selector);
      for (let k = 0; k < 40 && (await page.inputValue(selector)) !== value; k += 1) await page.keyboard.press(k < 20 ? "ArrowUp" : "ArrowDown");
      assert.equal(await page.inputValue(selector), value);
    },
    async write(page, selector, text) {
      await page.evaluate(() => document.activeElement.blur());
      await tab_to(page, selector);
      await page.keyboard.press("Control+A");
      await page.keyboard.type(text);
    },
  },
};

const requested = (page) => page.waitForFunction(() => Number.parseInt(document.querySelector("#in").textContent, 16) >= 0x80000000);
const ended = (page) => page.waitForFunction(() => Number.parseInt(document.querySelector("#in").textContent, 16) < 0x80000000);

/** What a trainee does in each lesson, once its view is open. */
const DONE = {
  async service(page, { press, choose, write }) {
    await choose(page, "#service", "2");
    await write(page, "#data", "9999");
    await press(page, "#step1");
    await until(page, "#out", "4200270F");
    await press(page, "#step2");
    await requested(page);
    await press(page, "#step4");
    await ended(page);
  },
  async torn(page, by) {
    await by.choose(page, "#service", "2");
    await by.write(page, "#data", "5000");
    await by.press(page, "#step2");
    await requested(page);
    await by.press(page, "#step4");
    await ended(page);
    await DONE.service(page, by);
  },
  async check(page, { press, choose, write }) {
    for (const [service, value] of EXAMPLE) {
      await choose(page, "#service", String(service));
      await choose(page, "#access", "write");
      await write(page, "#data", String(value));
      await press(page, "#go");
      await until(page, "#answer", `= ${value.toString(16).toUpperCase().padStart(6, "0")}h`);
    }
    await choose(page, "#service", "2");
    await choose(page, "#access", "read");
    await press(page, "#go");
    await until(page, "#answer", "00270Fh");
    await choose(page, "#service", "8");
    await press(page, "#go");
    await until(page, "#answer", "000000h");
  },
  async preset(page, { press, choose, write }) {
    await choose(page, "#service", "6");
    await write(page, "#data", "1000");
    await press(page, "#go");
    await until(page, "#answer", "0003E8h");
    await write(page, "#word", "86000000");
    await press(page, "#write");
    await requested(page);
    await write(page, "#word", "00000000");
    await press(page, "#write");
    await ended(page);
  },
};

/** The lessons on one page, in their order: a later one finds what the earlier ones have left. */
async function lessons(browser, base, by) {
  const page = await open(browser, base);
  for (const [name, do_it] of Object.entries(DONE)) {
    await page.goto(`${base}/#lessons`);
    await page.waitForSelector(`[data-card="${name}"]`);
    await by.press(page, `[data-lesson="${name}"]`);
    await until(page, `[data-card="${name}"]`, "Running.");
    await by.press(page, `[data-card="${name}"] a`);
    await page.waitForSelector("#service");
    // Where the encoder stands still, a preset is what it says.
    await do_it(page, by);
    await page.goto(`${base}/#lessons`);
    await until(page, `[data-card="${name}"]`, "Passed.");
    const open_goals = await page.locator(`[data-card="${name}"] li:not(.done)`).count();
    assert.equal(open_goals, 0, name);
  }
  await page.screenshot({ path: `${pictures}/lessons-passed.png`, fullPage: true });
  await page.context().close();
}

const lessons_by_mouse = (browser, base) => lessons(browser, base, BY.mouse);
const lessons_by_keyboard = (browser, base) => lessons(browser, base, BY.keyboard);

/** A log in which one bit is wrong in one row. */
const log = () => "time_us,in\n" + Array.from({ length: 400 }, (_, k) => `${k * 1000},${(k === 200 ? (1000 + 10 * k) ^ (1 << 20) : 1000 + 10 * k).toString(16).toUpperCase().padStart(8, "0")}\n`).join("");

async function dropped(browser, base) {
  const page = await open(browser, base, { expected: ["status of 400"] });
  await page.goto(`${base}/#diagnosis`);
  await page.setInputFiles("#recording", { name: "axis.csv", mimeType: "text/csv", buffer: Buffer.from(log()) });
  await page.waitForSelector('[data-cause="single_bit"]');
  await until(page, '[data-cause="single_bit"]', "line 202");
  await page.waitForSelector("#diagnosis-cancel", { state: "hidden" });
  const wide = await page.waitForFunction(() => document.querySelector(".picture")?.naturalWidth);
  assert.ok((await wide.jsonValue()) > 100);
  await page.screenshot({ path: `${pictures}/diagnosis.png`, fullPage: true });
  // Dropped, as a mouse does it.
  const wrong = await page.evaluateHandle(() => {
    const data = new DataTransfer();
    data.items.add(new File(["time_us,in\n0,XYZ\n"], "wrong.csv", { type: "text/csv" }));
    return data;
  });
  await page.dispatchEvent("#drop", "drop", { dataTransfer: wrong });
  await until(page, "#diagnosis-said", "wrong.csv line 2");
  // A table whose header does not say which column is which.
  await page.click("main details summary");
  await page.fill("#diagnosis-columns", "time_ms=Zeit,in=Istwert");
  await page.check("#diagnosis-decimal");
  await page.setInputFiles("#recording", { name: "plc.csv", mimeType: "text/csv", buffer: Buffer.from("Zeit;Istwert\n0;1000\n1;1010\n2;1020\n3;1030\n") });
  await until(page, ".report h3", "plc.csv");
  await page.fill("#diagnosis-columns", "");
  await page.uncheck("#diagnosis-decimal");
  // What is being read goes on while another view is looked at, in another language too.
  let go_on;
  const held = new Promise((done) => { go_on = done; });
  await page.route("**/api/diagnose**", async (route) => { await held; await route.continue(); });
  await page.setInputFiles("#recording", { name: "later.csv", mimeType: "text/csv", buffer: Buffer.from(log()) });
  await until(page, "#diagnosis-said", "Reading later.csv");
  await page.click('nav a[href="#ring"]');
  await page.selectOption("#language", "de");
  await page.click('nav a[href="#diagnosis"]');
  await until(page, "#diagnosis-said", "later.csv wird gelesen");
  await page.waitForSelector("#diagnosis-cancel", { state: "visible" });
  await page.click('nav a[href="#ring"]');
  go_on();
  await page.waitForResponse("**/api/diagnose**");
  await page.click('nav a[href="#diagnosis"]');
  await until(page, ".report h3", "later.csv");
  await page.waitForSelector("#diagnosis-cancel", { state: "hidden" });
  // The picture speaks the language of the page too.
  const [saved] = await Promise.all([page.waitForEvent("download"), page.locator("button", { hasText: "SVG" }).click()]);
  const drawn = readFileSync(await saved.path(), "utf8");
  for (const said of ["Position, Schritte", "ein falsches Bit"]) assert.ok(drawn.includes(said), said);
  for (const english of ["steps", "line", "bit was"]) assert.ok(!drawn.includes(`>${english}`) && !drawn.includes(` ${english} `), english);
  await page.context().close();
}

/** The part of the time that the trend shows, in seconds. */
const shown = async (page) => {
  const [, from, to] = /from ([\d.]+) s to ([\d.]+) s/.exec(await text(page, "#trend-said"));
  return [Number(from), Number(to)];
};

/** The trend, zoomed and moved by mouse and by keyboard, and saved. */
async function trend(browser, base) {
  const page = await open(browser, base);
  await page.goto(`${base}/#trend/1`);
  await page.waitForFunction(() => Number(/([\d,]+) samples/.exec(document.querySelector("#trend-said")?.textContent)?.[1]) > 60);
  const box = await page.locator("#trend").boundingBox();
  const at = (share) => [box.x + box.width * share, box.y + box.height / 3];
  await page.mouse.move(...at(0.85));
  await page.mouse.down();
  await page.mouse.move(...at(0.95), { steps: 4 });
  await page.mouse.up();
  await until(page, "#hold", "Go on");
  const [from, to] = await shown(page);
  assert.ok(Math.abs(to - from - 1) < 0.05, `a tenth of ten seconds: ${from} to ${to}`);
  await page.focus("#trend");
  for (const [key, wanted] of [["-", (begin, end) => end - begin > 1.2], ["+", (begin, end) => end - begin < 1.1], ["ArrowLeft", (begin) => begin < from]]) {
    await page.keyboard.press(key);
    const [begin, end] = await shown(page);
    assert.ok(wanted(begin, end), `${key}: ${begin} to ${end}, before it ${from} to ${to}`);
  }
  const before = await shown(page);
  await page.mouse.move(...at(0.5));
  await page.mouse.wheel(0, -100);
  await page.waitForFunction(([wide]) => {
    const [, from, to] = /from ([\d.]+) s to ([\d.]+) s/.exec(document.querySelector("#trend-said").textContent);
    return to - from < wide;
  }, [before[1] - before[0] - 0.1]);
  await page.mouse.move(box.x + 5, box.y - 20);
  const [saved] = await Promise.all([page.waitForEvent("download"), page.click("#csv")]);
  const [head, ...rows] = readFileSync(await saved.path(), "utf8").trim().split("\n");
  assert.equal(head, "time_us,out,in,value,event");
  const [first, last] = await shown(page);
  assert.ok(rows.length > 1 && rows.every((row) => Number(row.split(",")[0]) / 1e6 >= first - 0.001 && Number(row.split(",")[0]) / 1e6 <= last + 0.001), `${rows.length} rows`);
  const [drawn] = await Promise.all([page.waitForEvent("download"), page.click("#png")]);
  assert.equal(readFileSync(await drawn.path()).subarray(1, 4).toString(), "PNG");
  await page.screenshot({ path: `${pictures}/trend.png`, fullPage: true });
  await page.focus("#trend");
  await page.keyboard.press("0");
  await until(page, "#hold", "Hold");
  await page.context().close();
}

/** A ring behind a gateway: read only, then with every write asked for, then without a gateway. */
async function behind_a_gateway(browser) {
  await running(["sim", "--web", "off", "--modbus", "127.0.0.1:0"], async ({ modbus }, sim) => {
    const serve = ["serve", "--web", "127.0.0.1:0", "--bus", `modbus-tcp://${modbus}?status=holding:900&parameter=holding:901`, "--at", "0-2", "--model", "la-66,ce-100-m,ce-65-m"];
    const backup = `${pictures}/axis.toml`;
    writeFileSync(backup, BACKUP);
    await running([...serve, "--parameters", `2=${backup}`], async ({ web }) => {
      const base = `http://${web}`;
      const page = await open(browser, base);
      await page.goto(`${base}/#encoder/2`);
      await until(page, '[data-row="place"]', "turns");
      await until(page, '[data-service="2"]', "16777215by axis.toml");
      await until(page, '[data-service="3"] td', "not known");
      assert.ok(await page.isDisabled("#read-all"));
      await page.goto(`${base}/#handshake/1`);
      await page.waitForSelector("#only-shows");
      assert.ok(await page.isDisabled("#go"));
      await page.context().close();
      for (const language of ["en", "de"]) {
        for (const width of [360, 1440]) {
          const page = await open(browser, base, { language, width, theme: language === "en" ? "light" : "dark" });
          for (const view of ["ring", "encoder/2", "handshake/1", "trend/1", "diagnosis"]) await sound(page, base, view, `serve-${view.replace("/", "-")} ${language} ${width}`);
          await page.context().close();
        }
      }
    });
    await running([...serve, "--allow-control"], async ({ web }) => {
      const base = `http://${web}`;
      const page = await open(browser, base);
      await page.goto(`${base}/#ring`);
      await until(page, "#strip", "a real ring");
      assert.equal(await page.locator('nav a[href="#lessons"]').count(), 0);
      await page.goto(`${base}/#encoder/2`);
      await until(page, "#data-check", "were not read");
      await page.click("#read-all");
      await page.click('[data-do="agree"]');
      await until(page, "#read-said", "5 of 5");
      await until(page, '[data-service="2"] td', "16777215read");
      await until(page, "#data-check", "would accept");
      await page.screenshot({ path: `${pictures}/serve-read.png`, fullPage: true });
      await page.goto(`${base}/#handshake/1`);
      await page.selectOption("#service", "2");
      await page.fill("#data", "9999");
      await page.click("#go");
      await page.waitForSelector("dialog[open]");
      await until(page, "#question", modbus);
      await page.screenshot({ path: `${pictures}/asked.png` });
      await page.keyboard.press("Escape");
      await page.waitForSelector("dialog", { state: "detached" });
      const before = await (await fetch(`${base}/api/history?position=1`)).json();
      assert.deepEqual(before.changes, [], "what was not agreed to was not done");
      await page.click("#go");
      await page.click('[data-do="agree"]');
      await until(page, "#answer", "00270Fh");
      await page.waitForFunction(() => document.querySelectorAll("#history tr").length >= 2);
      await page.screenshot({ path: `${pictures}/serve-handshake.png`, fullPage: true });
      sim.kill();
      await until(page, "#strip", "the gateway: no connection");
      await page.goto(`${base}/#ring`);
      await until(page, "#link", "connection refused");
      await page.screenshot({ path: `${pictures}/serve-down.png`, fullPage: true });
      await page.context().close();
    });
  });
}

async function behind_a_token(browser) {
  const token = "a-token-of-the-browser-1";
  const file = `${pictures}/token`;
  writeFileSync(file, `${token}\n`);
  await running(["sim", "--modbus", "off", "--web", "127.0.0.1:0", "--web-token-file", file], async ({ web }) => {
    const base = `http://${web}`;
    const page = await open(browser, base, { expected: ["status of 401"] });
    await page.goto(base);
    await page.waitForSelector("#login");
    await page.screenshot({ path: `${pictures}/login.png` });
    await page.keyboard.type("a-wrong-token-1234");
    await page.keyboard.press("Enter");
    await until(page, "#login", "wrong");
    await page.keyboard.press("Control+A");
    await page.keyboard.type(token);
    await page.keyboard.press("Enter");
    await page.waitForSelector("[data-device]");
    await page.waitForFunction(() => document.querySelectorAll("#strip span").length > 3);
    const [cookie] = await page.context().cookies();
    assert.deepEqual([cookie.httpOnly, cookie.sameSite, cookie.value], [true, "Strict", token]);
    assert.ok(!page.url().includes(token));
    assert.equal(await page.evaluate(() => document.cookie), "");
    await page.reload();
    await page.waitForSelector("[data-device]");
    await page.context().close();
  });
}

/** A view without anything that must not be: checked and pictured. */
async function sound(page, base, view, name) {
  await page.goto(`${base}/#${view}`);
  await page.waitForSelector("main h2");
  await page.waitForFunction(() => document.querySelectorAll("#strip span").length > 3);
  const wider = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  if (wider > 0) problems.push(`${name}: ${wider} pixels wider than the screen`);
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  for (const { id, impact, nodes } of found.violations) {
    if (["serious", "critical"].includes(impact)) problems.push(`${name}: ${id}: ${nodes.map((node) => node.html.slice(0, 120)).join(" | ")}`);
  }
  await page.screenshot({ path: `${pictures}/${name.replaceAll(" ", "-")}.png`, fullPage: true });
}

async function every_view(browser, base) {
  for (const language of ["en", "de"]) {
    for (const theme of ["light", "dark"]) {
      for (const width of [360, 1440]) {
        const page = await open(browser, base, { width, language, theme });
        for (const view of ["ring", "encoder/0", "encoder/2", "handshake/1", "trend/1", "diagnosis", "lessons"]) {
          await sound(page, base, view, `${view.replace("/", "-")} ${language} ${theme} ${width}`);
        }
        await page.context().close();
      }
    }
  }
}

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run"],
});
try {
  const on_a_ring = [by_mouse, by_keyboard, broken_segment_and_lesson, dragged, trend, dropped, lessons_by_mouse, lessons_by_keyboard, every_view];
  const alone = [behind_a_gateway, behind_a_token];
  for (const part of [...on_a_ring, ...alone]) {
    const began = performance.now();
    await (alone.includes(part) ? part(browser) : ring((base) => part(browser, base)));
    console.log(`${part.name}: ${((performance.now() - began) / 1000).toFixed(1)} s`);
  }
} finally {
  await browser.close();
}
assert.deepEqual([...new Set(problems)], []);
console.log("the page in a browser: all is well");
