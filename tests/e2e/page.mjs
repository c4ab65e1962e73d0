// page.mjs VEHICLE ADDRESS [SHOTS]: a person at the pilot's page, in headless Chromium. Needs CHROMIUM and
// PLAYWRIGHT (the folder of playwright-core) in the environment. Prints what it measured; ends with 1 when something
// was not as a person expects it.

import {strict as assert} from "node:assert";
import {pathToFileURL} from "node:url";

const [vehicle, address, shots] = process.argv.slice(2);
const {chromium} = await import(pathToFileURL(`${process.env.PLAYWRIGHT}/index.mjs`).href);

const kPatience_ms = 60_000;
const kFrames_s = shots ? 10 : 2;
const drawn = shots ? ["--disable-gpu-compositing", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] : ["--disable-3d-apis"];
const browser = await chromium.launch({executablePath: process.env.CHROMIUM, args: ["--no-sandbox", "--disable-gpu-sandbox", ...drawn]});
const page = await browser.newPage({viewport: {width: 1440, height: 900}, colorScheme: "dark"});
page.setDefaultTimeout(kPatience_ms);
const errors = [];
page.on("pageerror", (e) => errors.push(e.message));

const button = (name) => page.locator("#list").getByRole("button", {name, exact: true});
const says = (where, what, limit_ms = kPatience_ms) =>
  page.waitForFunction(([w, t]) => document.querySelector(w)?.textContent.includes(t), [where, what], {timeout: limit_ms, polling: 50});
let pressed = "";
const press = async (name) => {
  pressed = name;
  await button(name).click();  // waits until it is enabled
  console.log(`pressed ${name}`);
};
const row = (name) => page.locator(".command", {has: page.getByRole("button", {name, exact: true})});
// Of the command that was pressed last.
const ends = async (phase) => {
  const ended = await page.waitForFunction((name) => {
    const text = document.querySelector("#running").textContent;
    return text.replaceAll("-", " ").startsWith(name) && /completed|rejected|failed|unanswered|superseded/.test(text) ? text : "";
  }, pressed, {polling: 50});
  const text = await ended.jsonValue();
  assert.ok(text.includes(phase), text);
};
const done = async (name) => { await press(name); await ends("completed"); };
const number = async (pattern) => Number(pattern.exec(await page.innerText("#overlay"))?.[1] ?? NaN);
const shot = async (name, fullPage = false) => {
  if (!shots) return;
  await page.evaluate(() => { document.querySelector("#scene").dataset.fine = "please"; });
  await page.waitForFunction(() => document.querySelector("#scene").dataset.fine === "drawn");
  // That took CPU time: wait until the heartbeat is in time again.
  await page.waitForFunction(() => parseFloat(document.querySelector("#links dd").textContent) < 200 && document.querySelector("#links dd").textContent.endsWith(" ms"));
  await page.screenshot({path: `${shots}/${name}.png`, fullPage});
  await page.evaluate(() => { delete document.querySelector("#scene").dataset.fine; });
};
const more = () => page.locator("#list summary", {hasText: "more commands"}).click();

async function moving(picture, did, way) {
  await parametersMoving();
  await shot(picture);
  await frames(kFrames_s);
  await looks();
  console.log(`${did} ${await number(way)} m`);
}

async function zebro() {
  await more();
  await row("walk").getByLabel("speed").selectOption("high");
  await press("walk");
  await says("#state", "Walking");
  await says("#running", "executing");
  // A forbidden command shows the daemon's reason.
  await page.waitForFunction(() => [...document.querySelectorAll(".command")].some((c) => c.textContent.startsWith("panel") && c.querySelector("button").disabled && c.textContent.includes("not allowed")));
  await page.waitForFunction(() => Number(/walked ([\d.]+) m/.exec(document.querySelector("#overlay").innerText)?.[1]) > 0.03, null, {polling: 100});
  await says("#overlay", "by rowing no");
  await says("#overlay", "left side in soil");
  await says("#overlay", "(limit 0.160)");
  await moving("ground-zebro", "walked", /walked ([\d.]+) m/);
  await done("stop");
  await says("#state", "Idle");
}

async function ardito() {
  await row("drive").getByLabel("speed").fill("0.3");
  await row("drive").getByLabel("heading").fill("3");
  await page.keyboard.press("Tab");
  await press("drive");
  await says("#state", "Running");
  await page.waitForFunction(() => Number(/driven ([\d.]+) m/.exec(document.querySelector("#overlay").innerText)?.[1]) > 0.8, null, {polling: 100});
  await says("#overlay", "wheels sunk by LF ");
  await says("#overlay", "(limit 0.060)");
  await moving("ground-ardito", "drove", /driven ([\d.]+) m/);
  await done("halt");
  await done("stop");
  await says("#state", "Idle");
}

async function talaris() {
  const gnc = async (step) => {
    await row("gnc").getByLabel("step").selectOption(step);
    await press("gnc");
  };
  const plan = row("plan");
  await done("start");
  await more();
  await done("edf arm");
  await more();
  await gnc("standby");
  await ends("completed");
  await gnc("calibrate");
  await ends("completed");
  await plan.getByLabel("height").fill("1");
  await plan.getByLabel("distance").fill("3");
  await done("plan");
  await gnc("execute");
  await says("#overlay", "in the air yes");
  await parametersMoving();
  await says("#overlay", "traverse");
  await shot("ground-talaris");
  await frames(kFrames_s);
  await looks();
  await ends("completed");
  console.log(`height at the end ${await number(/height (-?[\d.]+) m/)} m, along ${await number(/along (-?[\d.]+) m/)} m`);
  await done("stop");
  await says("#state", "Idle");
}

// A parameter is changed, refused with its numbers, saved, and put back; in Idle.
async function parameters() {
  await page.getByRole("tab", {name: "Events"}).focus();
  for (let i = 0; i < 4; i++) await page.keyboard.press("ArrowRight");
  const name = "solve.budget_s", row = page.locator(".parameter", {has: page.getByText(name, {exact: true})}), input = row.getByLabel(name, {exact: true});
  const shows = (where, what) => where.filter({hasText: what}).waitFor();
  const answer = page.locator("#parameters .answer"), rows = page.locator(".parameter:visible");
  await shows(row, "to 600 · at any time");
  await input.fill("1000");
  await shows(row, /solve\.budget_s: 1000 s is out of range, allowed [23] to 600 s/);
  assert.ok(await row.getByRole("button", {name: "set", exact: true}).isDisabled());
  await input.press("Enter");  // the daemon judges
  await shows(answer, /1000 s: rejected: .*1000 s is out of range, allowed [23] to 600 s/);
  await input.fill("12");
  await row.getByRole("button", {name: "set", exact: true}).click();
  await shows(answer, "12 s: completed");
  await shows(row, "configured 10");
  await shows(row, "not saved");
  await page.getByRole("button", {name: "save", exact: true}).click();
  await shows(answer, "save: completed");
  await shows(page.locator("#parameters .hint"), /^1 not as configured$/);
  await shot(`ground-${vehicle}-parameters`);
  const differs = page.getByLabel("what differs"), all = await rows.count();
  await differs.press("Enter");  // the space bar stops
  await page.waitForFunction(() => [...document.querySelectorAll(".parameter")].filter((row) => !row.hidden).length === 1);
  await differs.press("Enter");
  await page.waitForFunction((n) => [...document.querySelectorAll(".parameter")].filter((row) => !row.hidden).length === n, all);
  await row.getByRole("button", {name: "reset", exact: true}).click();
  await shows(row, "saved 12");
  assert.equal(await input.inputValue(), "10");
}

// While it moves; the tab is open.
async function parametersMoving() {
  await page.locator("#parameters .hint").filter({hasText: "what changes at rest: not allowed in this state"}).waitFor();
  assert.ok(await page.getByLabel("solve.budget_s", {exact: true}).isEnabled());
  const resting = page.locator(".parameter", {hasText: "at rest"}).getByRole("spinbutton");
  assert.ok(await resting.count() > 0);
  for (const input of await resting.all()) assert.ok(await input.isDisabled());
}

// How often the browser draws, and the CPU time that the page's scripts take of its main thread for it. A figure, no bound.
async function frames(seconds) {
  const probe = await page.context().newCDPSession(page);
  await probe.send("Performance.enable", {timeDomain: "threadTicks"});
  const metrics = async () => new Map((await probe.send("Performance.getMetrics")).metrics.map(({name, value}) => [name, value]));
  const before = await metrics();
  const [count, passed_s, drew, cost_ms] = await page.evaluate((limit_ms) => new Promise((resolve) => {
    const drawn = () => Number(document.querySelector("#scene")?.dataset.drawn ?? 0);
    const begun = performance.now(), first = drawn();
    let n = 0;
    requestAnimationFrame(function each() {
      n++;
      const passed_ms = performance.now() - begun;
      if (passed_ms < limit_ms) requestAnimationFrame(each); else resolve([n, passed_ms / 1000, drawn() - first, document.querySelector("#scene")?.dataset.cost ?? "no"]);
    });
  }), seconds * 1000);
  const after = await metrics(), ms = (name) => ((after.get(name) - before.get(name)) * 1000 / count).toFixed(2);
  console.log(`${(count / passed_s).toFixed(1)} frames a second, ${(drew / passed_s).toFixed(1)} of them with a new picture, whose script takes ${cost_ms} ms; CPU a frame: ` +
    `scripts ${ms("ScriptDuration")} ms, layout and style ${(Number(ms("LayoutDuration")) + Number(ms("RecalcStyleDuration"))).toFixed(2)} ms, main thread in all ${ms("TaskDuration")} ms`);
  await probe.detach();
}

// In the head no part covers another one, and state and mode have room.
async function head() {
  assert.deepEqual(await page.evaluate(() => {
    const parts = [...document.querySelectorAll("#top > :not([hidden], #state), #state > *, #links dt")].filter((e) => e.checkVisibility() && e.id !== "links");
    const boxes = parts.map((e) => {
      const range = document.createRange();
      range.selectNodeContents(e);
      const {x, y, right, bottom} = e.matches("b, dt") ? range.getBoundingClientRect() : e.getBoundingClientRect();
      return {name: e.id || e.textContent, x, y, right, bottom};
    });
    const wrong = boxes.flatMap((a, i) => boxes.slice(i + 1).filter((b) =>
      a.x < b.right - 1 && b.x < a.right - 1 && a.y < b.bottom - 1 && b.y < a.bottom - 1).map((b) => `${a.name} covers ${b.name}`));
    const mode = document.querySelector("#state span").clientWidth, lines = document.querySelector("#top").clientHeight / 58;
    if (mode < 100) wrong.push(`the mode has ${mode} pixels`);
    if (innerWidth > 1000 && lines > 2.2) wrong.push(`it is ${lines} lines high`);
    return wrong;
  }), []);
}

// Nothing is wider than the window, and STOP is in it, on a small screen and on a telephone.
async function looks() {
  await head();
  for (const [width, height] of [[900, 900], [390, 844]]) {
    await page.setViewportSize({width, height});
    await page.waitForFunction((w) => innerWidth === w && document.documentElement.scrollWidth <= w, width);
    const stop = await page.locator("#estop").boundingBox();
    assert.ok(stop.x >= 0 && stop.x + stop.width <= width && stop.y >= 0 && stop.y + stop.height <= height, JSON.stringify(stop));
    await head();
    await shot(`ground-${vehicle}-${width}`, true);
  }
  await page.setViewportSize({width: 1024, height: 768});
  await head();
  await shot(`ground-${vehicle}-1024`);
  await page.setViewportSize({width: 1440, height: 900});
  await page.getByRole("button", {name: "Light or dark"}).click();
  await shot(`ground-${vehicle}-light`);
  await page.getByRole("button", {name: "Light or dark"}).click();
}

// The space bar, and the time from there to the daemon's acknowledgement, seen on the page.
async function stops(count) {
  await done("start");
  await says("#state", "Operational");
  const times = [];
  for (let i = 0; i < count; i++) {
    await page.evaluate(() => { document.querySelector("#estop").dataset.ms = ""; });
    if (i % 2) await page.click("#estop"); else await page.keyboard.press("Space");
    await page.waitForFunction(() => document.querySelector("#estop").dataset.ms, null, {polling: 5});
    times.push(Number(await page.getAttribute("#estop", "data-ms")));
  }
  await says("#state", "FatalError");
  await says("#problems", "emergency stop commanded");
  await shot(`ground-${vehicle}-stopped`);
  times.sort((a, b) => a - b);
  console.log(`${count} emergency stops, to the acknowledgement on the page: p50 ${times[Math.floor(count / 2)].toFixed(1)} ms, ` +
    `p99 ${times[Math.min(count - 1, Math.ceil(count * 0.99) - 1)].toFixed(1)} ms, most ${times[count - 1].toFixed(1)} ms`);
  await done("solve");
  await says("#state", "Idle");
}

try {
  await page.goto(address);
  await says("#state", "Idle");
  await parameters();
  await {zebro, ardito, talaris}[vehicle]();
  await stops(Number(process.env.LSS_STOPS ?? 20));
  assert.deepEqual(errors, []);
} catch (error) {
  console.log(error.message, errors);
  for (const part of ["#state", "#running", "#problems", "#overlay", "#list", "#parameters", "#lost"])
    console.log(part, await page.textContent(part).catch(() => "?"));
  if (shots) await page.screenshot({path: `${shots}/failed.png`});
  process.exitCode = 1;
} finally {
  await browser.close();
}
