// browser.mjs: headless Chromium at the pilot's page, controlled by its input: each line of the standard input is a
// list in JSON, a verb and its arguments, and is answered by a line {"is": ...} or {"error": ...}. Needs CHROMIUM and
// PLAYWRIGHT (the folder of playwright-core) in the environment. Times are CLOCK_MONOTONIC in ns, as in Python and in
// the log of a tap.

import {createInterface} from "node:readline";
import {pathToFileURL} from "node:url";

const {chromium} = await import(pathToFileURL(`${process.env.PLAYWRIGHT}/index.mjs`).href);

const kPatience_ms = 60_000;
const browser = await chromium.launch({executablePath: process.env.CHROMIUM, args: ["--no-sandbox", "--disable-gpu-sandbox", "--disable-3d-apis"]});
const errors = [];
let context, page;

const now_ns = () => Number(process.hrtime.bigint());
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function until(code, limit_ms = kPatience_ms, poll_ms = 20) {
  for (const end_ms = performance.now() + limit_ms; performance.now() < end_ms; await pause(poll_ms))
    if (await page.evaluate(code).catch(() => false)) return now_ns();  // a page that loads has no answer
  throw new Error(`not within ${limit_ms} ms: ${code}`);
}

// What to add to the page's performance.now(), which is the same clock from another beginning, and by how much that is
// uncertain: half the way there and back, the shortest of several.
async function offset() {
  let best = {offset_ns: 0, error_ns: Infinity};
  for (let i = 0; i < 10; i++) {
    const before_ns = now_ns(), page_ms = await page.evaluate("performance.now()"), after_ns = now_ns();
    const error_ns = (after_ns - before_ns) / 2;
    if (error_ns < best.error_ns) best = {offset_ns: before_ns + error_ns - page_ms * 1e6, error_ns};
  }
  return best;
}

async function tab(address) {
  page = await context.newPage();
  page.setDefaultTimeout(kPatience_ms);
  page.on("pageerror", (e) => errors.push(e.message));
  await page.goto(address);
}

const verbs = {
  tab,  // another one of the same window
  async open(address, options = {}) {  // a new user
    await context?.close();
    context = await browser.newContext({viewport: {width: 1440, height: 900}, ...options});
    await tab(address);
  },
  go: async (address) => { await page.goto(address); },
  reload: async () => { await page.reload(); },
  ask: (code) => page.evaluate(code),
  until,
  errors: () => errors,
  click: (selector) => page.click(selector),
  fill: (selector, text) => page.fill(selector, text),
  key: (name) => page.keyboard.press(name),
  push: (name) => page.locator("#list").getByRole("button", {name, exact: true}).click(),  // waits until it is enabled

  // An emergency stop by "click" or "space": when the browser got the order, when it says that it was pressed, when the page
  // had its acknowledgement.
  async stop(by) {
    const box = await page.locator("#estop").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.evaluate((event) => {
      document.querySelector("#estop").dataset.ms = "";
      addEventListener(event, (e) => { window.pressed_ms = e.timeStamp; }, {capture: true, once: true});
    }, by === "click" ? "pointerdown" : "keydown");
    const {offset_ns, error_ns} = await offset();
    const told_ns = now_ns();
    if (by === "click") await page.mouse.down(); else await page.keyboard.down("Space");
    await until("document.querySelector('#estop').dataset.ms", kPatience_ms, 5);
    if (by === "click") await page.mouse.up(); else await page.keyboard.up("Space");
    const [pressed_ms, after_ms] = await page.evaluate("[pressed_ms, Number(document.querySelector('#estop').dataset.ms)]");
    return {told_ns, pressed_ns: pressed_ms * 1e6 + offset_ns, error_ns, acknowledged_ms: after_ms};
  },
};

console.log(JSON.stringify({is: "ready"}));
for await (const line of createInterface({input: process.stdin})) {
  const [verb, ...words] = JSON.parse(line);
  const answer = await Promise.resolve(verbs[verb](...words)).then((is) => ({is: is ?? null}), (e) => ({error: e.message}));
  console.log(JSON.stringify(answer));
}
await browser.close();
