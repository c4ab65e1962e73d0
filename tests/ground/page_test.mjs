// page_test.mjs PAGE [SHOTS]: the pilot's page that was built in the folder PAGE, in headless Chromium, with a gateway
// that sends just the messages of a test. Needs CHROMIUM and PLAYWRIGHT (the folder of playwright-core) in the
// environment. SHOTS: a folder for pictures of the tested page.

import {strict as assert} from "node:assert";
import {readFile} from "node:fs/promises";
import {createRequire} from "node:module";
import {join} from "node:path";
import {pathToFileURL} from "node:url";

const [folder, shots] = process.argv.slice(2);
const {chromium} = await import(pathToFileURL(`${process.env.PLAYWRIGHT}/index.mjs`).href);

const kTypes = {html: "text/html", js: "text/javascript", css: "text/css"};
const drawn = shots ? ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] : ["--disable-3d-apis"];
const browser = await chromium.launch({executablePath: process.env.CHROMIUM, args: ["--no-sandbox", "--disable-gpu-sandbox", ...drawn]});

// In the page, in place of the network.
function standIn(setup) {
  const gateway = window.gateway = {sent: [], order: [], crafts: {}, opening: [], lease_ms: 2000, late_ms: 0, open: true, closed: "", sockets: {}, ...setup};
  gateway.say = (protocol, message) => gateway.sockets[protocol]?.onmessage?.({data: JSON.stringify(message)});
  gateway.stops = () => gateway.sent.filter((m) => m.type === "stop");
  // The time of the page, which a test on a busy machine stops while it speaks for the gateway.
  const clock = performance.now.bind(performance);
  let stopped_ms = null;
  performance.now = () => stopped_ms ?? clock();
  gateway.time = (goes) => { stopped_ms = goes ? null : clock(); };
  const beats = [];
  gateway.pads = [];
  gateway.reads = 0;  // of the pads
  navigator.getGamepads = () => {
    gateway.reads++;
    return gateway.pads;
  };
  gateway.tones = 0;
  window.AudioContext = class {
    currentTime = 0;
    createOscillator() { return {frequency: {}, connect: (to) => to, start: () => { gateway.tones++; }, stop() {}}; }
    createGain() { return {gain: {setValueAtTime() {}, setTargetAtTime() {}}, connect: (to) => to}; }
  };
  window.WebSocket = class {
    static OPEN = 1;
    constructor(_, protocol) {
      this.protocol = protocol;
      this.readyState = 0;
      if (!gateway.open || gateway.closed === protocol) return;
      gateway.sockets[protocol] = this;
      setTimeout(() => { this.readyState = 1; this.onopen?.(); });
    }
    close() { this.readyState = 3; }
    send(text) {
      const message = JSON.parse(text);
      if (["beat", "stop", "command"].includes(message.type) && !message.dry_run)
        gateway.order.push([message.type === "beat" ? "beat" : `${message.vehicle} ${message.command ?? "STOP"}`, performance.now()]);
      if (message.type === "beat") return void beats.push([performance.now(), message.n]);
      gateway.sent.push(message);
      if (message.type !== "hello") return;
      gateway.say(this.protocol, {type: "welcome", role: "command", source: "ground:0123456789abcdef01234567", lease_ms: gateway.lease_ms});
      if (this.protocol === "lss-ground") gateway.opening.forEach((m) => gateway.say(this.protocol, m));
    }
  };
  setInterval(() => {
    const now = performance.now(), beat = beats.filter(([at]) => at <= now - gateway.late_ms).pop()?.[1];
    const crafts = {};
    for (const [id, c] of Object.entries(gateway.crafts))
      crafts[id] = {alive: c.age_ms === 0, daemon_age_ms: c.age_ms, status_age_ms: c.status_age_ms ?? c.age_ms, telemetry_age_ms: c.age_ms};
    if (gateway.open) for (const protocol of ["lss-ground", "lss-stop"]) gateway.say(protocol, {type: "pulse", beat, crafts, crowded: gateway.crowded ?? false, gateway: {}});
    gateway.told = "lss-ground" in gateway.sockets;
  }, 100);
}

const kCommands = ["start", "stop", "walk"].map((name, i) => ({kind: i + 1, name, summary: name, access: "holder", leased: true, parameters: [], allowed: []}));
const vehicle = (id, kind) => ({type: "vehicle", id, vehicle: kind, commands: kCommands, subjects: [], scripts: false});
const status = (id, more = {}) => ({type: "status", id, alive: true, state: "Operational", mode: "Walking", progress: "walks", problems: [], authority: null, recording: true,
  link: {obc_age_ms: 20}, frame: {index: 1, overruns: 0}, counters: {commands_rejected: 0, safe_commands: 0}, realtime: {policy: "enforce", granted: true},
  shared_memory: "off", version: "0", airborne: false, stop_in_flight: "lands", daemons: [], ...more});
const flight = (id) => ({type: "telemetry", id, telemetry: {program: "hop", phase: "traverse", airborne: true, remaining_s: 12, calibrated: true, calibrated_share: 1, position_m: [2, 0, 6.2], target_position_m: [2.1, 0, 6.8],
  velocity_m_s: [0.1, 0, 1.3], attitude_wxyz: [0.99, 0, 0.1, 0], rate_rad_s: [0, 0, 0], position_sigma_m: [0.1, 0.1, 0.1], range_m: 2, gas_left_thruster_s: 41, pressure_Pa: [2e7, 1e6], voltage_V: 24,
  gas_thruster_s: 9, script_id: 0, valves: [], fans: [], modules: []}});
// Lunar Zebro runs, Ardito is silent for ten minutes and comes first in the list.
const kTwo = {opening: [vehicle("ardito-1", "ardito"), status("ardito-1", {alive: false}), vehicle("zebro-1", "zebro"), status("zebro-1")],
  crafts: {"ardito-1": {age_ms: 610_000}, "zebro-1": {age_ms: 0}}};
const kFlying = {opening: [{...vehicle("talaris-1", "talaris"), commands: [...kCommands, {...kCommands[1], kind: 313, name: "land"}]}, status("talaris-1", {airborne: true, mode: "Guided", progress: "hop, traverse: 6.2 of 30.0 m", authority: "ground:0123456789abcdef01234567"}), flight("talaris-1"), vehicle("zebro-1", "zebro"), status("zebro-1")],
  crafts: {"talaris-1": {age_ms: 0}, "zebro-1": {age_ms: 0}}};

let page;
async function open(setup, options = {}) {
  await page?.context().close();
  const context = await browser.newContext({viewport: {width: 1440, height: 900}, colorScheme: "dark", ...options});
  page = await context.newPage();
  page.setDefaultTimeout(60_000);  // of a browser on a busy machine
  page.errors = [];
  page.on("pageerror", (e) => page.errors.push(e.message));
  await page.route("http://localhost/**", async (route) => {
    const path = new URL(route.request().url()).pathname.slice(1) || "index.html";
    await route.fulfill({body: await readFile(join(folder, path)), contentType: kTypes[path.split(".").pop()]});
  });
  await page.addInitScript(standIn, setup);
  await page.goto("http://localhost/");
  await page.waitForFunction(() => document.querySelector("#state").innerText && gateway.told);
}
const openTwoRovers = () => {
  const rover = (id) => ({...vehicle(id, "rover"), presentation: {rest: 2, hold: [{way: "forward", command: 3, parameters: []}]}});
  return open({opening: [rover("rover-1"), status("rover-1"), rover("rover-2"), status("rover-2")], crafts: {"rover-1": {age_ms: 0}, "rover-2": {age_ms: 0}}});
};
const text = (selector) => page.innerText(selector);
const says = (selector, what) => page.waitForFunction(([s, t]) => document.querySelector(s)?.checkVisibility() && document.querySelector(s).innerText.includes(t), [selector, what]);
// With two vehicles, when the stop button names this one; then its time stands still.
async function openStill(button) {
  await open(kTwo);
  await says("#estop-text", button);
  await time(false);
}
const is = (code) => page.waitForFunction(code);
const say = (message, protocol = "lss-ground") => page.evaluate(([p, m]) => gateway.say(p, m), [protocol, message]);
// Its parameters: one.
const limited = (id, name, value) => ({type: "parameters", id, parameters: [{name, value, unit: "", min: 0, max: 1, whole: false, configured: value, saved: null, as_configured: true, as_saved: true, change: "always", help: ""}]});
const stops = () => page.evaluate("gateway.stops()");
const answer = (request, more) => say({type: "ack", request, command: "estop", final: false, ...more}, "lss-stop");
// The last command of this name.
const answered = async (command, phase, text) => {
  const request = await page.evaluate((c) => gateway.sent.filter((m) => m.command === c && !m.dry_run).at(-1).id, command);
  await say({type: "ack", request, command, phase, final: phase !== "accepted", reason: text ? {name: "a_reason", text, advice: ""} : null});
};
const linkIs = (name, tone) => page.waitForFunction(([n, t]) => [...document.querySelectorAll("#links div")].find((d) => d.textContent.startsWith(n))?.className === t, [name, tone]);
const time = (goes) => page.evaluate((g) => gateway.time(g), goes);
const hold = async (selector, released) => {
  const box = await page.locator(selector).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await released();
  await page.mouse.up();
};
const fits = async () => {
  for (const id of ["estop", "fall", "stop-all"]) {
    const inside = await page.evaluate((i) => {
      const button = document.getElementById(i), box = button.getBoundingClientRect();
      if (!button.checkVisibility()) return true;
      const [name, said] = [...button.children].map((c) => c.getBoundingClientRect());
      return name.bottom <= said.top + 1 && [name, said].every((c) => c.left >= box.left && c.right <= box.right && c.top >= box.top && c.bottom <= box.bottom);
    }, id);
    assert.ok(inside, `${id}: ${await text(`#${id}`)}`);
  }
  assert.ok(await page.evaluate("document.documentElement.scrollWidth <= innerWidth"), "wider than the window");
};
const shot = async (name) => {
  if (!shots) return;
  await page.evaluate(() => { document.querySelector("#scene").dataset.fine = "please"; });
  await page.waitForFunction(() => document.querySelector("#scene").dataset.fine === "drawn");
  await page.screenshot({path: `${shots}/${name}.png`});
};

const tests = {
  async the_page_opens_on_a_vehicle_that_sends_and_shows_the_others_as_silent() {
    await open(kTwo);
    await says("#estop-text", "zebro-1");
    assert.equal(await page.inputValue("#vehicles"), "zebro-1");
    assert.deepEqual(await page.evaluate("[...document.querySelectorAll('#vehicles option')].map((o) => o.textContent)"), ["zebro-1 (zebro)", "ardito-1, silent for 10 min"]);
    assert.equal(await page.evaluate("document.querySelector('#vehicles optgroup').children[0].value"), "ardito-1");
    await linkIs("record", "rec");
    await shot("two-vehicles");
  },

  async a_silent_vehicle_is_shown_as_silent_and_stays_when_a_person_chose_it() {
    await open(kTwo);
    await page.selectOption("#vehicles", "ardito-1");
    await says("#lost", "The daemon of ardito-1 is gone, last message 10 min ago");
    await linkIs("record", "dim");
    assert.doesNotMatch(await text("#links"), /recording/i);
    await linkIs("telemetry", "bad");
    await says("#problems", "Unknown: it is silent");
    await linkIs("daemon", "bad");
    await is("document.body.classList.contains('stale')");
    await is("document.querySelector('#state b').className === 'dim' && document.querySelector('#state').innerText.includes('as last received, 10 min ago')");
    await is("document.title === 'ardito-1: silent'");
    await shot("silent");
    await page.keyboard.press("Space");
    assert.deepEqual((await stops()).map((m) => m.vehicle), ["ardito-1"]);
    await is("gateway.crafts['zebro-1'].age_ms === 0 && document.querySelector('#vehicles').value === 'ardito-1'");

    await page.reload();  // it is dead, so another one is shown; the choice is kept
    await says("#estop-text", "zebro-1");
    await page.addInitScript(() => { gateway.crafts["ardito-1"].age_ms = 0; });
    await page.reload();
    await says("#estop-text", "ardito-1");
  },

  async with_none_that_sends_none_is_chosen_and_stop_is_for_all() {
    await open({...kTwo, crafts: {"ardito-1": {age_ms: 610_000}, "zebro-1": {age_ms: 5000}}});
    await says("#state", "no vehicle found");
    assert.equal(await page.inputValue("#vehicles"), "");
    await says("#estop-text", "every vehicle");
    await page.keyboard.press("Space");
    assert.deepEqual(await stops(), [{type: "stop", id: 1, vehicle: ""}]);
    await page.evaluate("gateway.crafts['zebro-1'].age_ms = 0");
    await says("#state", "Operational");
  },

  async a_name_that_is_gone_leaves_the_list_and_too_many_are_reported() {
    await open({...kTwo, crowded: true});
    await says("#crowded", "STOP ALL reaches every one");
    await page.evaluate("delete gateway.crafts['ardito-1']");
    await say({type: "gone", id: "ardito-1"});
    await is("document.querySelectorAll('#vehicles option').length === 1");
    await page.evaluate("gateway.crowded = false");
    await is("document.querySelector('#crowded').hidden");
  },

  async a_round_trip_is_coloured_by_the_lease() {
    await open({...kTwo, lease_ms: 600});
    await linkIs("page", "good");
    await page.evaluate("gateway.late_ms = 700");
    await linkIs("page", "bad");
    await page.evaluate("gateway.late_ms = 0");
    await linkIs("page", "good");
    await say(status("zebro-1", {authority: "somebody", link: {obc_age_ms: 400}}));
    await linkIs("OBC message", "warn");
    await say(status("zebro-1", {authority: "somebody", link: {obc_age_ms: 9800}}));
    await linkIs("OBC message", "bad");
  },

  async a_stop_is_not_over_before_it_is_completed() {
    await openStill("zebro-1 · space bar");
    await page.click("#estop");
    assert.deepEqual(await stops(), [{type: "stop", id: 1, vehicle: "zebro-1"}]);
    const busy = {vehicle: "zebro-1", phase: "rejected", reason: {text: "request queue is full", name: "busy"}};
    await answer(1, busy);
    await says("#answers", "not obeyed yet: request queue is full");
    await fits();
    await answer(1, {...busy, phase: "failed"});
    await answer(1, {vehicle: "zebro-1", phase: "unanswered"});
    await says("#answers", "NOT ACKNOWLEDGED. Cut the power. It is sent on.");
    await fits();
    await answer(1, {vehicle: "zebro-1", phase: "accepted"});
    await says("#answers", "acknowledged after");
    await fits();
    await answer(1, busy);  // of a repetition
    await answer(1, {vehicle: "zebro-1", phase: "completed", final: true});
    await says("#answers", "stopped after");
    assert.doesNotMatch(await text("body"), /refused|failed/i);
    await fits();
    await time(true);
    await is("document.querySelector('#answers').childElementCount === 0");  // after a while
    await time(false);

    await page.keyboard.press("Space");
    await answer(2, {phase: "rejected", final: true, reason: {text: "this key may not stop"}});
    await says("#answers", "REFUSED: this key may not stop");
    await page.keyboard.press("Space");
    await answer(3, {vehicle: "zebro-1", phase: "unanswered", final: true});
    await says("#answers", "NOT ACKNOWLEDGED. Cut the power.");
    await time(true);
    await shot("not-acknowledged");
  },

  async a_stop_that_nobody_acknowledges_says_whether_the_vehicle_stopped() {
    await open(kTwo);
    await says("#estop-text", "zebro-1 · space bar");  // before, STOP is for every vehicle
    await page.keyboard.press("Space");
    await says("#answers", "NOT ACKNOWLEDGED. Cut the power. It is sent on.");  // the gateway says nothing
    await time(false);
    await say(status("zebro-1", {state: "FatalError"}));
    await answer(1, {vehicle: "zebro-1", phase: "unanswered", final: true});
    await says("#answers", "it says that it is stopped (FatalError)");
  },

  async a_stop_without_a_connection_leaves_when_there_is_one() {
    await openStill("zebro-1 · space bar");
    await page.evaluate(() => {
      gateway.open = false;
      for (const socket of Object.values(gateway.sockets)) { socket.readyState = 3; socket.onclose?.({reason: ""}); }
    });
    await page.keyboard.press("Space");
    await says("#answers", "NOT SENT: no connection. Cut the power.");
    assert.deepEqual(await stops(), []);
    await page.evaluate("gateway.open = true");
    await time(true);  // an attempt of before ends by it
    await is("gateway.stops().length === 1 && gateway.stops()[0].vehicle === 'zebro-1'");
    await time(false);
    await answer(1, {vehicle: "zebro-1", phase: "completed", final: true});
    await says("#answers", "stopped after");
  },

  async stop_all_is_one_stop_and_lists_what_each_said() {
    await openStill("zebro-1");
    await page.click("#stop-all");
    assert.deepEqual(await stops(), [{type: "stop", id: 1, vehicle: ""}]);
    await answer(1, {vehicle: "zebro-1", phase: "accepted"});
    await answer(1, {vehicle: "zebro-1", phase: "completed"});
    await answer(1, {vehicle: "unknown-7", phase: "completed"});
    await says("#answers", "2 of 2 stopped");
    await answer(1, {vehicle: "*", phase: "unanswered", final: true, silent: ["ardito-1"]});
    await says("#answers", "2 of 3 stopped");
    await says("#answers", "unknown-7 stopped after");
    await says("#answers", "zebro-1 stopped after");
    await says("#answers", "ardito-1 NO ANSWER (silent for 10 min)");
    await fits();
    await time(true);
    await shot("stop-all");
    await time(false);
    await page.click("#stop-all");
    await answer(2, {vehicle: "*", phase: "unanswered", final: true, silent: []});
    await says("#answers", "NOT ACKNOWLEDGED. Cut the power.");
  },

  async an_unknown_vehicle_has_the_controls_and_values_of_its_dictionary() {
    const speed = {name: "speed", unit: "m/s", min: -1, max: 1, required: true, default: null, whole: false, help: "ahead"};
    const crane = {...vehicle("crane-1", "crane"), commands: [{...kCommands[0], kind: 401, name: "hoist", parameters: [speed]}],
      fields: [{name: "time_ns", type: "i8", unit: "ns"}, {name: "rope_m", type: "f8", unit: "m"}, {name: "speed_m_s", type: "f8", unit: "m/s"},
        {name: "drums", count: 2, fields: [{name: "current_A", type: "f8", unit: "A"}, {name: "online", type: "b1"}]}]};
    await open({opening: [crane, status("crane-1"), {type: "telemetry", id: "crane-1", telemetry: {time_ns: 5, rope_m: 12.25, speed_m_s: 0.5,
      drums: [{current_A: 1.5, online: true}, {current_A: 2.5, online: false}]}}], crafts: {"crane-1": {age_ms: 0}}});
    await says("#list", "Hoist");
    await says("#list", "m/s");
    await says("#overlay", "rope_m 12.25 m");
    await page.fill("#list input", "0.25");
    await is("gateway.sent.some((m) => m.command === 'hoist' && m.dry_run && m.parameters.speed === 0.25)");
    await page.click("#tab-parts");
    await says("#parts", "current_A, A");
    await says("#parts", "2.500");
    await page.click("#choose summary");
    await says("#choose", "drums 2 current_A");
    assert.deepEqual(page.errors, []);
    await shot("unknown");
  },

  async a_vehicle_is_shown_as_its_dictionary_says() {
    const degrees = {unit: "deg", factor: 180 / Math.PI};
    const own = [[401, "hoist"], [402, "swing"], [403, "step"]].map(([kind, name]) => ({...kCommands[0], kind, name}));
    const crane = {...vehicle("crane-1", "crane"), commands: [...kCommands.slice(0, 2), ...own], subjects: ["boom", "left drum", "right drum"],
      fields: [{name: "boom_rad", label: "boom", type: "f8", unit: "rad", shown: degrees}, {name: "place_m", label: "place", type: "f8", unit: "m", count: 2},
        {name: "braked", type: "b1"}, {name: "load", type: "u1"}, {name: "serial", type: "u4"},
        {name: "drums", count: 2, fields: [{name: "id", type: "u1"}, {name: "turned_rad", label: "turned", type: "f8", unit: "rad", shown: degrees},
          {name: "rope", type: "u1"}, {name: "online", type: "b1"}, {name: "runs", type: "u4"}]}],
      presentation: {details: ["serial", "drums.runs"], words: [{field: "drums.rope", words: ["slack", "tight"], shown_only: true}, {field: "load", words: ["none", "full"]}],
        parts: [{field: "drums", first: 1}], first: [402], without_client: "lowers its load",
        headline: [{field: "boom_rad", label: "lifted"}, {field: "place_m[1]", label: "left"}, {field: "braked", label: "braked"}, {field: "load", label: "load"},
          {field: "drums.turned_rad", label: "turned"}]}};
    const drum = (id, turned_rad, rope, online) => ({id, turned_rad, rope, online, runs: 77});
    await open({opening: [crane, status("crane-1", {state: "Operational", authority: "me"}), {type: "telemetry", id: "crane-1",
      telemetry: {boom_rad: Math.PI / 6, place_m: [3, 4.5], braked: true, load: "full", serial: 991, drums: [drum(1, Math.PI, 1, true), drum(2, 0.01, 0, null)]}}],
    crafts: {"crane-1": {age_ms: 0}}});
    await says("#overlay", "lifted 30.00 deg\nleft 4.500 m\nbraked yes\nload full");
    const texts = (where) => page.$$eval(where, (all) => all.map((one) => one.textContent));
    assert.deepEqual(await texts("#list > .command button"), ["swing", "stop", "start"]);
    assert.deepEqual(await texts("#list .more button"), ["hoist", "step"]);
    await page.click("#tab-parts");
    assert.deepEqual(await texts("#parts th"), ["drums", "turned, deg", "rope", "online"]);
    assert.deepEqual(await texts("#parts td"), ["left drum", "180.0", "tight", "online", "right drum", "0.573", "slack", "not there"]);
    await page.click("#choose summary");
    assert.deepEqual(await texts("#choose label"), [" lifted", " left", " braked", " left drum turned", " right drum turned", " place 1", " left drum online", " right drum online"]);
    assert.deepEqual(await page.$$eval("#choose input", (all) => all.map((one) => one.checked)), [true, true, false, true, true, false, false, false]);
    // Its next version has the same commands and other measurements.
    await say({...crane, fields: [...crane.fields, {name: "wind_m_s", label: "wind", type: "f8", unit: "m/s"}]});
    await is("[...document.querySelectorAll('#choose label')].some((one) => one.textContent === ' wind')");
    assert.deepEqual(page.errors, []);
  },

  async a_rover_that_slip_slows_down_shows_the_slip_and_why_it_is_slower() {
    const speed = (name) => ({name, type: "f8", unit: "m/s"}), share = (name) => ({name, type: "f8"});
    const rover = {...vehicle("ardito-1", "ardito"), fields: [speed("measured_m_s"), speed("speed_m_s"), share("slip_share"), share("speed_share")],
      presentation: {headline: [{field: "measured_m_s", label: "speed"}, {field: "speed_m_s", label: "commanded"}, {field: "slip_share", label: "lost by slip"}, {field: "speed_share", label: "share driven"}]}};
    const goes = (measured_m_s, slip_share, speed_share) => ({type: "telemetry", id: "ardito-1", telemetry: {measured_m_s, speed_m_s: 0.5, slip_share, speed_share, wheels: [], steering: [], nodes: [], rho_rad: [0, 0]}});
    await open({opening: [rover, status("ardito-1", {progress: "0.50 m/s, heading 0.0 deg"}), goes(0.5, 0.03, 1)], crafts: {"ardito-1": {age_ms: 0}}});
    await says("#overlay", "speed 0.500 m/s\ncommanded 0.500 m/s\nlost by slip 0.030\nshare driven 1.000");
    await say(goes(0.25, 0.482, 0.5));
    await say(status("ardito-1", {progress: "0.50 m/s, slowed to 50 % by slip, heading 0.0 deg"}));
    await says("#overlay", "speed 0.250 m/s\ncommanded 0.500 m/s\nlost by slip 0.482\nshare driven 0.500");
    await says("#state", "slowed to 50 % by slip");
    await say({type: "event", id: "ardito-1", index: 9, utc_ns: 1764000000e9, severity: "warning", subject_name: "", text: "drives slower than commanded: 0.44 of the wheels' speed is lost, 0.4 is allowed"});
    await says("#events", "0.44 of the wheels' speed is lost, 0.4 is allowed");
    assert.deepEqual(page.errors, []);
    await fits();
    await shot("slip");
  },

  async a_wheel_that_digs_itself_in_shows_how_deep_and_which_one() {
    const rover = {...vehicle("ardito-1", "ardito"), subjects: ["LF", "RF", "LM", "RM", "LR", "RR"],
      fields: [{name: "sunk_m", type: "f8", unit: "m", count: 6}, {name: "wheels", count: 6, fields: [{name: "id", type: "u1"}, {name: "hot", type: "b1"}]}],
      presentation: {parts: [{field: "wheels", first: 0}], headline: [{field: "sunk_m", label: "wheels sunk by", limit: "mobility.sink_limit_m", parts: "wheels"}]}};
    const wheels = [1, 2, 3, 4, 5, 6].map((id) => ({id, hot: false}));
    const stands = (sunk_m) => ({type: "telemetry", id: "ardito-1", telemetry: {sunk_m, wheels, steering: [], nodes: [], rho_rad: [0, 0]}});
    await open({opening: [rover, status("ardito-1"), stands([null, null, null, null, null, null])], crafts: {"ardito-1": {age_ms: 0}}});
    await says("#overlay", "wheels sunk by LF – RF – LM – RM – LR – RR – m");
    assert.doesNotMatch(await text("#overlay"), /limit/);
    await say(limited("ardito-1", "mobility.sink_limit_m", 0.06));
    await says("#overlay", "RR – m (limit 0.060)");
    await say(stands([-0.02, -0.01, 0, 0.0724, 0.03, -0.07]));
    await say(status("ardito-1", {problems: [{text: "the wheel dug itself in, the others hold: the rover stopped, wheel 4", error: true, advice: "drive back the way it came"}]}));
    await says("#overlay", "wheels sunk by LF -0.020 RF -0.010 LM 0.000 RM 0.072 LR 0.030 RR -0.070 m (limit 0.060)");
    await says("#problems", "the wheel dug itself in");
    await page.click("#tab-parts");
    assert.deepEqual(await page.$$eval("#parts th", (all) => all.map((one) => one.textContent)), ["wheels", "hot", "wheels sunk by, m"]);
    assert.deepEqual(await page.$$eval("#parts tbody tr:nth-child(4) td", (all) => all.map((one) => one.textContent)), ["RM", "no", "0.072"]);
    assert.deepEqual(page.errors, []);
    await fits();
    await shot("sunk");
  },

  async a_side_in_soft_soil_shows_which_one_and_that_the_robot_rows() {
    const limit = "ground.soil_share";
    const robot = {...vehicle("zebro-1", "zebro"), fields: [{name: "rows", type: "b1"}, {name: "soil_share", type: "f8", count: 2}],
      presentation: {headline: [{field: "rows", label: "by rowing"}, {field: "soil_share[0]", label: "left side in soil", limit}, {field: "soil_share[1]", label: "right side in soil", limit}]}};
    const walks = (rows, soil_share) => ({type: "telemetry", id: "zebro-1", telemetry: {rows, soil_share, modules: [], yaw_rad: 0, distance_m: 0}});
    await open({opening: [robot, status("zebro-1"), limited("zebro-1", limit, 0.16), walks(false, [null, null])], crafts: {"zebro-1": {age_ms: 0}}});
    await says("#overlay", "by rowing no\nleft side in soil – (limit 0.160)\nright side in soil – (limit 0.160)");
    await say(walks(true, [0.5234, 0.01]));
    await says("#overlay", "by rowing yes\nleft side in soil 0.523 (limit 0.160)\nright side in soil 0.010 (limit 0.160)");
    await say(limited("zebro-1", limit, 0.3));
    await says("#overlay", "right side in soil 0.010 (limit 0.300)");
    assert.deepEqual(page.errors, []);
    await fits();
    await shot("soil");
  },

  async two_daemons_of_one_name_are_named() {
    await open(kTwo);
    await is("document.querySelector('#rivals').hidden");
    const daemons = [{host: "obc", pid: 411, started_utc_ns: 1764000000e9}, {host: "base", pid: 77, started_utc_ns: 1764000060e9}];
    await say(status("zebro-1", {daemons}));
    await says("#rivals", "Two daemons have the name zebro-1: host obc, pid 411, started 2025-11-24 16:00:00 UTC and host base, pid 77, started 2025-11-24 16:01:00 UTC");
    await fits();
    await shot("two-daemons");
    await say(status("zebro-1"));
    await is("document.querySelector('#rivals').hidden");
  },

  async a_vehicle_drives_as_long_as_a_key_a_button_or_a_stick_is_held() {
    const speed = {name: "speed", unit: "m/s", min: -1, max: 1, required: true, default: null, whole: false, help: "ahead"};
    const turn = {...speed, name: "turn", default: 0};
    const rover = {...vehicle("rover-1", "rover"), commands: [...kCommands, {...kCommands[0], kind: 401, name: "drive", parameters: [speed, turn]}, {...kCommands[0], kind: 402, name: "halt"}],
      presentation: {rest: 402, hold: [{way: "forward", command: 401, parameters: [0.2, null]}, {way: "forward left", command: 401, parameters: [0.2, 0.1]}, {way: "left", command: 401, parameters: [0, 0.3]}]}};
    await open({opening: [rover, status("rover-1"), vehicle("zebro-1", "zebro"), status("zebro-1")], crafts: {"rover-1": {age_ms: 0}, "zebro-1": {age_ms: 0}}});
    const moves = () => page.evaluate("gateway.sent.filter((m) => m.type === 'command' && !m.dry_run).map((m) => [m.vehicle, m.command, m.parameters, m.lease_ms ?? 0])");
    const expected = [];
    const next = async (...more) => {
      expected.push(...more);
      await page.waitForFunction((n) => gateway.sent.filter((m) => m.type === "command" && !m.dry_run).length >= n, expected.length);
      assert.deepEqual(await moves(), expected);
    };
    const forward = ["rover-1", "drive", {speed: 0.2, turn: 0}, 500], arc = ["rover-1", "drive", {speed: 0.2, turn: 0.1}, 500], halt = ["rover-1", "halt", {}, 0];
    await says("#drive", "Hold to drive");
    assert.deepEqual(await page.$$eval("#drive [data-way]", (all) => all.map((one) => one.dataset.way)), ["forward left", "forward", "left"]);
    await hold("#drive [data-way='forward']", () => next(forward));
    await next(halt);

    await page.keyboard.press("KeyW");  // keys are off at first
    await page.click("#drive label");
    await page.keyboard.down("KeyW");
    await next(forward);
    await says("#drives", "drives forward");
    await shot("drive");
    await page.keyboard.down("KeyA");
    await next(arc);
    await page.keyboard.up("KeyA");
    await next(forward);
    await page.evaluate("dispatchEvent(new Event('blur'))");  // another window
    await next(halt);
    await page.keyboard.up("KeyW");

    const stick = (y, shoulder) => page.evaluate(([y, s]) => { gateway.pads = [{id: "pad", connected: true, axes: [0, y], buttons: Array.from({length: 16}, (_, i) => ({pressed: i === 4 && s}))}]; }, [y, shoulder]);
    await stick(-1, false);
    await says("#gamepad", "hold a shoulder button");
    await stick(-1, true);
    await next(forward);
    await page.evaluate("gateway.pads = []");  // unplugged
    await next(halt);

    await page.keyboard.down("KeyW");
    await next(forward);
    await page.keyboard.press("Space");  // a stop: nothing more by a key that is still held
    await is("gateway.stops().length === 1 && document.querySelector('#drives').innerText === ''");
    await page.keyboard.down("KeyA");
    await page.keyboard.up("KeyA");
    await page.keyboard.up("KeyW");
    await next();
    await page.keyboard.down("KeyW");
    await next(forward);
    await answered("drive", "rejected", "the brakes are on");
    await says("#drives", "rejected: the brakes are on");
    await next(halt);
    await page.keyboard.up("KeyW");
    await next();

    await say(status("rover-1", {state: "Idle"}));
    await page.keyboard.down("KeyW");
    await says("#drives", "start it first");
    await page.keyboard.up("KeyW");
    await next();
    await page.selectOption("#vehicles", "zebro-1");  // its dictionary lists no ways
    await is("document.querySelector('#drive').hidden");
    assert.deepEqual(page.errors, []);
  },

  async a_vehicle_that_is_left_or_lost_while_it_drives_is_not_driven_on() {
    await openTwoRovers();
    const moves = () => page.evaluate("gateway.sent.filter((m) => m.type === 'command' && !m.dry_run).map((m) => m.vehicle + ' ' + m.command)");
    await page.click("#drive label");
    await page.keyboard.down("ArrowUp");
    await is("gateway.sent.some((m) => m.command === 'walk' && !m.dry_run)");
    await page.click("#strip button:nth-child(2)");
    await is("gateway.sent.some((m) => m.command === 'stop' && !m.dry_run)");
    assert.deepEqual(await moves(), ["rover-1 walk", "rover-1 stop"]);
    await page.keyboard.up("ArrowUp");

    await page.click("#drive label");
    await page.keyboard.down("ArrowUp");
    await is("gateway.sent.filter((m) => m.command === 'walk' && !m.dry_run).length === 2");
    await page.evaluate("gateway.open = false");  // nothing is heard any more
    await says("#drives", "no connection: it stops by itself");
    await page.evaluate("gateway.order = []; gateway.open = true");
    await is("gateway.order.length > 0");
    assert.equal(await page.evaluate("gateway.order[0][0]"), "rover-2 stop", "before any heartbeat");
    await page.keyboard.up("ArrowUp");
    assert.deepEqual(await moves(), ["rover-1 walk", "rover-1 stop", "rover-2 walk", "rover-2 stop"]);
  },

  async a_stick_that_is_held_over_a_change_of_vehicle_or_window_drives_nothing() {
    await openTwoRovers();
    const moves = () => page.evaluate("gateway.order.map(([o]) => o).filter((o) => o !== 'beat')");
    const stick = async (y) => {
      await page.evaluate((y_) => {
        gateway.pads = [{id: "pad", connected: true, axes: [0, y_], buttons: Array.from({length: 16}, (_, i) => ({pressed: i === 4}))}];
        gateway.reads = 0;
      }, y);
      await is("gateway.reads > 4");
    };
    const confirmed = async () => {  // that it stands still, and the stick was read some times more
      await is("gateway.order.findLastIndex(([o]) => o.endsWith('stop')) > gateway.order.findLastIndex(([o]) => o.endsWith('walk'))");
      await answered("stop", "completed");
      await page.evaluate("gateway.reads = 0");
      await is("gateway.reads > 4");
    };
    const expected = ["rover-1 walk"];
    await stick(-1);
    assert.deepEqual(await moves(), expected);
    const changes = {"rover-1": () => page.click("#strip button:nth-child(2)"), "rover-2": () => page.evaluate("dispatchEvent(new Event('blur'))")};
    for (const [driven, change] of Object.entries(changes)) {
      await change();
      await confirmed();
      expected.push(`${driven} stop`);
      assert.deepEqual(await moves(), expected);
      await stick(0);
      await stick(-1);
      expected.push("rover-2 walk");
      assert.deepEqual(await moves(), expected, "pushed again");
    }
  },

  async every_end_of_a_hold_stops_the_vehicle_and_no_heartbeat_drives_it_on() {
    const rover = {...vehicle("rover-1", "rover"), presentation: {rest: 2, hold: [{way: "forward", command: 3, parameters: []}, {way: "forward left", command: 3, parameters: []}]}};
    await open({opening: [rover, status("rover-1")], crafts: {"rover-1": {age_ms: 0}}});
    const last = (what) => `gateway.order.findLastIndex(([o]) => ${JSON.stringify(what)}.includes(o))`;
    const walks = () => is(`${last(["rover-1 walk"])} > ${last(["rover-1 stop", "rover-1 STOP"])}`);
    const rests = () => is(`${last(["rover-1 stop"])} > ${last(["rover-1 walk"])}`);
    // After this the next message is a heartbeat, when the lease is over.
    const lets = async (what) => {
      await is(`${last(["beat"])} > ${last([what])}`);
      const [[, from_ms], [next, to_ms]] = await page.evaluate(`gateway.order.slice(${last([what])})`);
      assert.equal(next, "beat");
      assert.ok(to_ms - from_ms >= 1000, `a heartbeat ${to_ms - from_ms} ms after ${what}`);
    };

    await page.click("#drive label");
    await page.keyboard.down("KeyW");
    await walks();
    await answered("walk", "accepted");
    await page.keyboard.down("KeyA");
    await is("gateway.order.filter(([o]) => o === 'rover-1 walk').length === 2");
    await answered("walk", "rejected", "too far to the side");
    await rests();
    await answered("stop", "rejected", "request queue is full");
    await says("#drives", "rejected: too far to the side");
    await lets("rover-1 stop");
    await page.keyboard.up("KeyA");
    await page.keyboard.up("KeyW");

    await page.keyboard.down("KeyW");
    await walks();
    await page.keyboard.up("KeyW");
    await rests();
    await answered("stop", "accepted");
    assert.equal(await page.evaluate("sessionStorage.getItem('driven')"), "null");

    await page.keyboard.down("KeyW");
    await walks();
    await page.keyboard.press("Space");
    await lets("rover-1 STOP");
    await page.keyboard.up("KeyW");

    await page.keyboard.down("KeyW");
    await walks();
    await page.evaluate("gateway.crafts['rover-1'].age_ms = 5000");  // it is silent
    await rests();
    await says("#drives", "no status from it: the order to stand still was sent");
    await is("document.body.classList.contains('stale')");
    await page.evaluate("gateway.crafts['rover-1'].age_ms = 0");
    await is("!document.body.classList.contains('stale')");
    await page.keyboard.up("KeyW");

    await page.keyboard.down("KeyW");
    await walks();
    await page.evaluate(() => {  // it comes back at once
      const socket = gateway.sockets["lss-ground"];
      gateway.order = [];
      socket.readyState = 3;
      socket.onclose({reason: ""});
    });
    await is("gateway.order.length > 0");
    assert.equal(await page.evaluate("gateway.order[0][0]"), "rover-1 stop", "before any heartbeat");
    await page.keyboard.up("KeyW");

    await page.keyboard.down("KeyW");
    await walks();
    await page.reload();
    await is("gateway.order.length > 0");
    assert.equal(await page.evaluate("gateway.order[0][0]"), "rover-1 stop", "before any heartbeat of the new page");
    await page.keyboard.up("KeyW");

    await page.click("#drive label");
    await page.keyboard.down("KeyW");
    await walks();
    await page.evaluate(() => {
      const socket = gateway.sockets["lss-stop"];
      gateway.closed = "lss-stop";
      socket.readyState = 3;
      socket.onclose({reason: ""});
    });
    await page.keyboard.press("Space");
    await says("#answers", "NOT SENT");
    await rests();
    assert.deepEqual(await stops(), []);
    await page.keyboard.up("KeyW");
  },

  async a_new_problem_sounds_and_those_with_one_remedy_are_one() {
    const leg = (name) => ({text: `leg ${name} does not answer, last reply 1.2 s ago`, error: true, advice: "check the bus, then: lss-cli start"});
    await open(kTwo);
    await page.click("#sound");
    await is("gateway.tones === 1");
    await say(status("zebro-1", {problems: [leg("LF"), leg("LM"), {text: "a lamp is dark", error: false, advice: "replace it"}]}));
    await is("gateway.tones === 3");
    await says("#problems", "leg LF does not answer");
    await says("#problems", "and 1 more with the same remedy");
    assert.equal(await page.$$eval("#problems .problem", (all) => all.length), 2);
    await say(status("zebro-1", {problems: [{...leg("LF"), text: leg("LF").text.replace("1.2", "3.4")}]}));
    await is("!document.querySelector('#problems').innerText.includes('lamp')");
    assert.equal(await page.evaluate("gateway.tones"), 3, "the same problem, later");
    await page.click("#problems .problem button");
    await is("gateway.sent.some((m) => m.command === 'start' && !m.dry_run && m.whole)");
    await shot("problems");
  },

  async a_hundred_vehicles_are_in_the_strip_and_one_press_shows_one() {
    const ids = Array.from({length: 100}, (_, i) => `zebro-${i + 1}`);
    await open({opening: ids.flatMap((id, i) => [vehicle(id, "zebro"), status(id, i === 41 ? {state: "FatalError", problems: [{text: "x", error: true, advice: ""}]} : {})]),
      crafts: Object.fromEntries(ids.map((id, i) => [id, {age_ms: i === 6 ? 99_000 : 0}]))});
    await is("document.querySelectorAll('#strip button').length === 100");
    const chip = (n) => page.$eval(`#strip button:nth-child(${n})`, (b) => `${b.className}: ${b.innerText.replace(/\s+/g, " ")}`);
    assert.equal(await chip(1), "bad: zebro-42 FatalError 1", "what is wrong comes first");
    await is("document.querySelector('#strip button:nth-child(8)').className === 'dim'");
    assert.equal(await chip(2), "good: zebro-1 Walking");
    await page.click("#strip button:nth-child(1)");
    await says("#estop-text", "zebro-42");
    await fits();
    await shot("hundred");
  },

  async signals_have_values_at_the_pointer_zoom_and_the_whole_session() {
    const mast = {...vehicle("mast-1", "mast"), fields: [{name: "height_m", label: "height", type: "f8", unit: "m"}, {name: "cells", count: 2, fields: [{name: "pack_V", label: "pack", type: "f8", unit: "V"}]}],
      presentation: {headline: [{field: "height_m", label: "height"}], supply: "cells.pack_V"}};
    await open({opening: [mast, status("mast-1")], crafts: {"mast-1": {age_ms: 0}}});
    // Twenty minutes, at two a second, and the clock of the page with them.
    await page.evaluate(() => {
      const begin = 1000 * Math.floor(Date.now() / 1000);  // so that the even ones are the first of their second
      for (let i = 0; i < 2400; ++i) {
        Date.now = () => begin + 500 * i;
        gateway.say("lss-ground", {type: "telemetry", id: "mast-1", telemetry: {height_m: i, cells: [{pack_V: 24.5}, {pack_V: 23.75}]}});
      }
      const end = begin + 500 * 2400, opened = performance.now();
      Date.now = () => end + performance.now() - opened;
    });
    await says("#links", "23.8 V");
    const span = () => page.evaluate("[...document.querySelectorAll('#choose > button')].map((b) => b.getAttribute('aria-pressed')).join()");
    assert.equal(await span(), "true,false,false");
    const at = async (share) => {
      const box = await page.locator("#charts .u-over").first().boundingBox();
      return [box.x + share * box.width, box.y + box.height / 2];
    };
    const read = () => page.$eval("#charts .u-legend .u-series:nth-child(2) .u-value", (v) => Number(v.textContent));
    await page.mouse.move(...await at(0.5));
    await is("Number(document.querySelector('#charts .u-legend .u-series:nth-child(2) .u-value').textContent) > 2300");
    await page.click("#choose > button:nth-child(3)");
    await page.mouse.move(...await at(0.25));
    await is("(() => { const v = Number(document.querySelector('#charts .u-legend .u-series:nth-child(2) .u-value').textContent); return v > 500 && v < 700; })()");
    assert.ok(await read() % 2 === 0, "old samples are thinned out to one a second");
    await page.mouse.move(...await at(0.5));
    await page.mouse.down();
    await page.mouse.move(...await at(0.75));
    await page.mouse.up();
    assert.equal(await span(), "false,false,false");
    await page.mouse.move(...await at(0.02));
    await is("(() => { const v = Number(document.querySelector('#charts .u-legend .u-series:nth-child(2) .u-value').textContent); return v > 1150 && v < 1300; })()");
    await shot("zoom");
    await page.mouse.dblclick(...await at(0.5));
    await is("document.querySelector('#choose > button:nth-child(3)').getAttribute('aria-pressed') === 'true'");
    assert.deepEqual(page.errors, []);
  },

  async a_recording_is_scrubbed_and_played_and_stop_is_then_for_every_vehicle() {
    const modules = join(process.env.PLAYWRIGHT, "..");
    const [{McapWriter, TempBuffer}, {parseIDL}, {MessageWriter}] = await Promise.all(
      ["@mcap/core", "@foxglove/omgidl-parser", "@foxglove/omgidl-serialization"].map((name) => createRequire(`${modules}/x.js`)(name)));
    const idl = `module lss {
      struct MastCell { double pack_V; };
      struct MastTelemetry { char vehicle_id[16]; long long time_ns; unsigned long long age_ms; double height_m; MastCell cells[2]; };
      struct Fault { unsigned short id; unsigned short subject; };
      struct Status { char vehicle_id[16]; octet state; char mode_name[16]; char authority[32]; boolean recording; Fault faults[2]; octet stop_in_flight; };
    };`;
    const types = parseIDL(idl), bytes = new TempBuffer(), file = new McapWriter({writable: bytes});
    const chars = (text, size) => Uint8Array.from({length: size}, (_, i) => text.charCodeAt(i) || 0);
    const double = (name, unit) => ({name, type: "f8", unit, label: name.slice(0, -1 - unit.length)});
    const dictionary = {subjects: ["mast"], faults: [{number: 42, name: "mast_jammed", advice: "free it"}],
      telemetry: {fields: [{name: "time_ns", type: "i8"}, double("height_m", "m"), {name: "cells", count: 2, fields: [double("pack_V", "V")]}]}};
    await file.start({profile: "", library: "a test"});
    await file.addMetadata({name: "lss", metadata: new Map([["dictionary", JSON.stringify(dictionary)]])});
    const channels = {};
    for (const [topic, type] of [["lss/telemetry/mast", "lss::MastTelemetry"], ["lss/status", "lss::Status"], ["lss/unknown", "lss::Fault"]]) {
      const schemaId = await file.registerSchema({name: type, encoding: "omgidl", data: new TextEncoder().encode(idl)});
      channels[topic] = {id: await file.registerChannel({topic, schemaId, messageEncoding: "cdr", metadata: new Map([["vehicle_id", "mast-7"]])}), writer: new MessageWriter(type, types)};
    }
    const begin = 1_764_000_000_000_000_000n;
    const put = async (topic, at_s, data) => {
      const time = begin + BigInt(Math.round(1e9 * at_s)), {id, writer} = channels[topic];
      await file.addMessage({channelId: id, sequence: 0, logTime: time, publishTime: time, data: writer.writeMessage(data)});
    };
    const state = (n, fault) => ({vehicle_id: chars("mast-7", 16), state: n, mode_name: chars("Rising", 16), authority: chars("", 32), recording: true, faults: [{id: fault, subject: 1}, {id: 0, subject: 0}], stop_in_flight: 0});
    await put("lss/status", 0, state(0, 0));
    for (let i = 0; i <= 200; ++i) {
      if (i === 100) await put("lss/status", 5, state(1, 0));
      if (i === 180) await put("lss/status", 9, state(2, 42));
      await put("lss/telemetry/mast", i / 20, {vehicle_id: chars("mast-7", 16), time_ns: BigInt(i), age_ms: 0xffff_ffff_ffff_ffffn, height_m: i / 10, cells: [{pack_V: 24}, {pack_V: 23}]});
    }
    await file.end();

    await open(kTwo);
    await page.setInputFiles("#open-file", {name: "run.mcap", mimeType: "application/octet-stream", buffer: Buffer.from(bytes.get())});
    await says("#played", "0.00 of 10.00 s");
    await says("#state", "Idle");
    await says("#overlay", "height 0.000 m");
    assert.equal(await page.inputValue("#vehicles"), "mast-7, run.mcap");
    await is("document.querySelector('#lost').hidden && !document.body.classList.contains('stale')");
    const seek = (at_s) => page.$eval("#seek", (s, at) => { s.value = String(at); s.dispatchEvent(new Event("input")); }, at_s);
    await seek(5.03);
    await says("#overlay", "height 10.00 m");
    await says("#state", "recorded, Rising");
    await seek(9.5);
    await says("#state", "FatalError");
    await says("#problems", "mast jammed, mast");
    await seek(2);
    await says("#state", "Idle");
    await page.click("#tab-parts");
    await says("#parts", "23.00");
    await page.click("#choose > button:nth-child(3)");
    await page.click("#choose summary");
    await page.click("#choose label:has-text('height')");
    await page.click("#choose summary");
    const box = await page.locator("#charts .u-over").first().boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await is("Math.abs(Number(document.querySelector('#charts .u-legend .u-series:nth-child(2) .u-value').textContent) - 10) < 0.3");
    await shot("recording");
    await page.selectOption("#player select", "10");
    await page.click("#play");
    await says("#played", "10.00 of 10.00 s");
    await says("#play", "play");
    await page.focus("#vehicles");
    await page.keyboard.press("Space");
    assert.deepEqual(await stops(), [{type: "stop", id: 1, vehicle: ""}], "a recording cannot be stopped");
    await page.click("#close");
    await says("#estop-text", "zebro-1");
    await page.setInputFiles("#open-file", {name: "bad.mcap", mimeType: "application/octet-stream", buffer: Buffer.from("no recording")});
    await says("#player", "bad.mcap cannot be shown");
    assert.deepEqual(page.errors, []);
  },

  async in_flight_land_comes_first_and_the_all_stop_falls_and_is_held() {
    await open(kFlying);
    await says("#estop", "LAND");
    await says("#estop-text", "talaris-1 · space bar");
    await says("#fall", "ALL-STOP\nIT FALLS · hold");
    await says("#stop-all", "every · 1 FALLS");
    await fits();
    await shot("flight");
    await time(false);
    await page.keyboard.press("Space");
    await page.click("#estop");
    assert.deepEqual(await stops(), [1, 2].map((id) => ({type: "stop", id, vehicle: "talaris-1", land: true})));
    await answer(2, {vehicle: "talaris-1", command: "land", phase: "accepted"});
    await says("#answers", "landing: acknowledged after");
    await answer(2, {vehicle: "talaris-1", command: "land", phase: "completed", final: true});
    await says("#answers", "landing completed");

    await page.keyboard.press("Space");
    await answer(3, {vehicle: "talaris-1", command: "land", phase: "rejected", final: true, reason: {text: "it is not in the air", name: "not_in_flight"}});
    await says("#answers", "REFUSED: it is not in the air");
    await time(true);
    await page.keyboard.press("Space");
    await says("#answers", "NOT ACKNOWLEDGED. It is sent on. ALL-STOP makes it fall.");
    await fits();
    await time(false);

    const before = (await stops()).length;
    await page.click("#fall");  // too short
    await says("#answers", "Hold ALL-STOP for half a second: talaris-1 FALLS.");
    await page.click("#stop-all");
    await says("#answers", "Hold STOP ALL for half a second: talaris-1 FALLS.");
    await fits();
    assert.equal((await stops()).length, before);
    await hold("#fall", () => is(`gateway.stops().length === ${before + 1}`));
    assert.deepEqual((await stops()).at(-1), {type: "stop", id: before + 1, vehicle: "talaris-1"});
    await page.focus("#stop-all");
    await page.keyboard.down("Enter");
    await is(`gateway.stops().length === ${before + 2}`);
    await page.keyboard.up("Enter");
    assert.deepEqual((await stops()).at(-1), {type: "stop", id: before + 2, vehicle: ""});

    await say(status("talaris-1", {airborne: false}));
    await says("#estop", "STOP");
    await is("document.querySelector('#fall').hidden && document.querySelector('#stop-all').innerText.includes('every vehicle')");
  },

  async where_a_stop_in_flight_falls_the_button_is_a_stop_that_says_so() {
    await open(kFlying);
    await say(status("talaris-1", {airborne: true, stop_in_flight: "falls"}));
    await says("#estop", "STOP");
    await says("#estop-text", "talaris-1 · space bar · FALLS");
    await is("document.querySelector('#fall').hidden");
    await fits();
    await page.keyboard.press("Space");
    assert.deepEqual(await stops(), [{type: "stop", id: 1, vehicle: "talaris-1"}]);
  },

  async a_flyer_without_a_command_to_land_is_stopped() {
    await open({...kFlying, opening: [vehicle("talaris-1", "talaris"), ...kFlying.opening.slice(1)]});
    await says("#estop-text", "talaris-1 · space bar · FALLS");
    await is("document.querySelector('#fall').hidden");
    await page.keyboard.press("Space");
    assert.deepEqual(await stops(), [{type: "stop", id: 1, vehicle: "talaris-1"}]);
  },

  async everything_fits_on_small_windows_and_in_the_light() {
    for (const [width, height] of [[1440, 900], [1024, 768], [900, 900], [390, 844]]) {
      await open(kFlying, {viewport: {width, height}, colorScheme: "light"});
      await says("#estop", "LAND");
      await time(false);
      await page.keyboard.press("Space");
      await answer(1, {vehicle: "talaris-1", command: "land", phase: "accepted"});
      await says("#answers", "landing");
      await fits();
      await time(true);
      await shot(`light-${width}`);
    }
  },
};

let failures = 0;
for (const [name, run] of Object.entries(tests).filter(([name]) => name.includes(process.env.ONLY ?? ""))) {
  try {
    await run();
    assert.deepEqual(page.errors, []);
    console.log(`ok ${name}`);
  } catch (error) {
    failures++;
    console.log(`FAILED ${name}: ${error.message}\n${error.stack.split("\n").filter((l) => l.includes("page_test")).join("\n")}`);
    for (const part of ["#vehicles", "#state", "#links", "#overlay", "#player", "#stops", "#answers", "#lost"]) console.log(part, JSON.stringify(await page.textContent(part, {timeout: 500}).catch(() => "?")));
  }
}
await browser.close();
console.log(`${failures} of ${Object.keys(tests).length} failed`);
process.exitCode = failures ? 1 : 0;
