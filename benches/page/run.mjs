// What the page costs who looks: node benches/page/run.mjs PROGRAM, after .ci/browser has installed Chromium.
//
// The bytes of the first view; from navigation to the first changed position, the median of 20; the processor time of
// all of Chromium, and of the simulation, while a page stands idle, with 3 and with 128 encoders; a recording of
// 100,000,000 bytes that is chosen in the page, with the most memory of the server and the frames of a stream meanwhile.

import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { createInterface } from "node:readline";

const program = resolve(process.argv[2]);
const { chromium } = createRequire(`${resolve("target/browser")}/`)("playwright-core");
const SECONDS = 10;
const TICKS = 100;
const RECORDING_BYTES = 100_000_000;

async function running(scenario, part) {
  const sim = spawn(program, ["sim", ...scenario, "--modbus", "off", "--web", "127.0.0.1:0", "--format", "json"], { stdio: ["ignore", "pipe", "inherit"] });
  try {
    const line = await new Promise((done) => createInterface({ input: sim.stdout }).once("line", done));
    return await part(`http://${JSON.parse(line).web}`, sim.pid);
  } finally {
    sim.kill();
  }
}

/** Ticks of the processor that a process and all below it have had. */
function ticks(of) {
  const all = readdirSync("/proc").filter((name) => /^[0-9]+$/.test(name)).flatMap((pid) => {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
      return [{ pid: Number(pid), parent: Number(fields[1]), used: Number(fields[11]) + Number(fields[12]) }];
    } catch {
      return [];
    }
  });
  const family = new Set([of]);
  for (let grown = true; grown;) {
    grown = false;
    for (const { pid, parent } of all) if (family.has(parent) && !family.has(pid)) grown = Boolean(family.add(pid));
  }
  return all.filter(({ pid }) => family.has(pid)).reduce((sum, { used }) => sum + used, 0);
}

async function first_view(browser, base) {
  const page = await browser.newPage();
  let bytes = 0;
  page.on("requestfinished", async (request) => {
    const { responseBodySize, responseHeadersSize } = await request.sizes();
    bytes += responseBodySize + responseHeadersSize;
  });
  await page.goto(`${base}/#ring`);
  await page.waitForSelector("[data-device]");
  await page.waitForTimeout(500);
  await page.close();
  return bytes;
}

async function first_change(browser, base) {
  const page = await browser.newPage();
  await page.addInitScript(() => {
    let first = null;
    const look = () => {
      const text = document.querySelector('[data-value="1"]')?.textContent;
      if (text) first ??= text;
      if (text && text !== first) window.changed = performance.now();
      else requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
  await page.goto(`${base}/#ring`);
  const changed = await page.waitForFunction(() => window.changed);
  const took = await changed.jsonValue();
  await page.close();
  return took;
}

async function idle(server, browser, base, sim) {
  const page = await browser.newPage();
  await page.goto(`${base}/#ring`);
  await page.waitForSelector("[data-device]");
  await page.waitForTimeout(2000);
  const before = [ticks(server.process().pid), ticks(sim)];
  await page.waitForTimeout(SECONDS * 1000);
  const percent = [ticks(server.process().pid), ticks(sim)].map((now, k) => ((now - before[k]) / TICKS / SECONDS) * 100);
  await page.close();
  return percent;
}

function long_ring() {
  const file = join(mkdtempSync(join(tmpdir(), "page-")), "ring.toml");
  const device = (position) => `[[device]]\nposition = ${position}\nmodel = "ce-65-m"\nmotion = { kind = "speed", per_s = 1000.0 }\n`;
  writeFileSync(file, `version = 1\n${Array.from({ length: 128 }, (_, position) => device(position)).join("")}`);
  return file;
}

/** A log of an axis that moves slowly, with one wrong bit in 10,000 rows; as long as the page takes one. */
function long_recording() {
  const file = join(mkdtempSync(join(tmpdir(), "page-")), "axis.csv");
  const rows = ["time_us,out,in\n"];
  let size = rows[0].length;
  for (let k = 0; ; k += 1) {
    const word = (100_000 + 38 * k) % 2 ** 24 ^ (k % 10_000 === 5_000 ? 2 ** 20 : 0);
    const row = `${10_000 * k},00000000,${word.toString(16).toUpperCase().padStart(8, "0")}\n`;
    if (size + row.length > RECORDING_BYTES) break;
    rows.push(row);
    size += row.length;
  }
  writeFileSync(file, rows.join("").padEnd(RECORDING_BYTES, "\n"));
  return { file, rows: rows.length - 1 };
}

/** The most memory that a process has had, in MB. */
const most_memory = (pid) => Number(/VmHWM:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1000;

/** Times at which a stream of the page told something. */
async function follow(base, told) {
  const { body } = await fetch(`${base}/api/events`);
  for await (const piece of body) if (String.fromCharCode(...piece.subarray(0, 6)) === "event:") told.push(performance.now());
}

async function diagnosed(browser, base, sim) {
  const { file, rows } = long_recording();
  const page = await browser.newPage();
  await page.goto(`${base}/#diagnosis`);
  await page.waitForSelector("#recording");
  const told = [];
  follow(base, told).catch(() => {});
  const before = most_memory(sim);
  const began = performance.now();
  await page.setInputFiles("#recording", file);
  await page.waitForSelector("#found-what");
  const took = performance.now() - began;
  const during = [began, ...told.filter((at) => at > began && at < began + took), began + took];
  const gap = Math.max(...during.slice(1).map((at, k) => at - during[k]));
  console.log(`${RECORDING_BYTES} bytes, ${rows} rows, chosen in the page: the report after ${(took / 1000).toFixed(1)} s; most memory of sim ${before.toFixed(0)} MB before, ${most_memory(sim).toFixed(0)} MB then; no frame for at most ${gap.toFixed(0)} ms`);
  await page.close();
}

const server = await chromium.launchServer({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu", "--disable-background-networking"] });
const browser = await chromium.connect(server.wsEndpoint());
await running([], async (base) => {
  console.log(`bytes of the first view: ${await first_view(browser, base)}`);
  const took = [];
  for (let k = 0; k < 20; k += 1) took.push(await first_change(browser, base));
  took.sort((a, b) => a - b);
  console.log(`navigation to the first changed position, median of 20: ${((took[9] + took[10]) / 2).toFixed(0)} ms (${took[0].toFixed(0)} to ${took[19].toFixed(0)})`);
});
for (const [name, scenario] of [["3 encoders", []], ["128 encoders", [long_ring()]]]) {
  const [chromium_percent, sim_percent] = await running(scenario, (base, sim) => idle(server, browser, base, sim));
  console.log(`an idle page, ${name}: Chromium ${chromium_percent.toFixed(0)} %, sim ${sim_percent.toFixed(0)} % of a core`);
}
await running([], (base, sim) => diagnosed(browser, base, sim));
await browser.close();
await server.close();
