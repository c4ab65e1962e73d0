// The pilot's page of lss-ground. All data come from the daemon; all commands go to the daemon.

import "./style.css";
import {details, tabs} from "./details";
import {$, advice, age, el, show, sourceName} from "./dom";
import {Drive} from "./drive";
import {Fleet} from "./fleet";
import {beat, keyGiven, Line, setKey, type Json} from "./link";
import {Panel} from "./panel";
import {Parameters} from "./parameters";
import {Plots} from "./plots";
import {Player} from "./recording";
import {Requests} from "./requests";
import {Bars, Scene} from "./scene";
import {Sound} from "./sound";
import {Stops} from "./stop";
import type {Vehicle} from "./model";
import {kindOf} from "./vehicles/roster";

let trip_ms: number | null = null;

const data = new Line("lss-ground", hear);
const pulse = beat(data, (ms) => { trip_ms = ms; }, () => drive);

const scene = new Scene($("scene") as HTMLCanvasElement);
const bars = new Bars($("bars") as HTMLCanvasElement);
const plots = new Plots();
const requests = new Requests(data);
const panel = new Panel(requests);
const drive = new Drive(requests);
const sound = new Sound();
const parameters = new Parameters($("parameters"), requests);
const fleet = new Fleet((vehicle) => {
  scene.show(vehicle);
  plots.show(vehicle);
  panel.show(vehicle);
  drive.show(vehicle);
  player.show(vehicle);
  draw();
});
const player = new Player(fleet, (vehicle) => {
  vehicle.telemetry_ms = performance.now();
  bars.add(vehicle);
});
const stops = new Stops(fleet, (stopped) => drive.interrupt(stopped));
let crowded = false;

function hear(m: Json) {
  switch (m.type) {
    case "pulse": {
      pulse(m);
      crowded = m.crowded;
      return fleet.heard(m.crafts ?? {});
    }
    case "refused": return askKey();
    case "welcome":
      requests.begin();
      return panel.ask();
    case "vehicle": return fleet.add(m);
    case "gone": return fleet.gone(m.id);
    case "ack": return requests.heard(m);
  }
  const vehicle = fleet.vehicles.get(m.id), chosen = fleet.chosen;
  if (!vehicle) return;
  switch (m.type) {
    case "status": {
      const changed = vehicle.status?.state !== m.state || vehicle.status?.mode !== m.mode || vehicle.status?.authority !== m.authority;
      vehicle.status = m;
      vehicle.links.alive = m.alive;
      if (changed && vehicle === chosen) {
        panel.ask();
        parameters.ask();
      }
      break;
    }
    case "telemetry":
      vehicle.telemetry = m.telemetry;
      vehicle.telemetry_ms = performance.now();
      plots.record(vehicle);
      if (vehicle === chosen) bars.add(vehicle);
      break;
    case "events":
      vehicle.events.clear();
      m.events.forEach((e: Json) => vehicle.addEvent(e));
      break;
    case "event": vehicle.addEvent(m); break;
    case "timing": vehicle.timing = m; break;
    case "parameters": vehicle.parameters = m; break;
  }
}

// The key.

function askKey() {
  const dialog = $("login") as HTMLDialogElement;
  if (dialog.open) return;
  const input = $("key") as HTMLInputElement;
  $("login-why").textContent = keyGiven() ? "The gateway does not know this key." : "The gateway lets in who has a key.";
  input.value = "";
  dialog.onclose = () => {
    setKey(input.value.trim());
    data.again();
    stops.line.again();
  };
  dialog.showModal();
}

// Light and dark.

const theme = localStorage.getItem("theme");
if (theme) document.documentElement.dataset.theme = theme;
$("theme").onclick = () => {
  const dark = getComputedStyle(document.documentElement).colorScheme.includes("dark");
  localStorage.setItem("theme", document.documentElement.dataset.theme = dark ? "light" : "dark");
  scene.colours();
  plots.rebuild();
};

// Drawing.

// Age, in proportion to the time for which the vehicle continues without a heartbeat.
function tone(ms: number | null | undefined, limit_ms = lease_ms): string {
  return ms === null || ms === undefined || ms < 0 || ms >= limit_ms ? "bad" : ms >= limit_ms / 2 ? "warn" : "good";
}

function links() {
  const v = fleet.chosen, s = v?.status, stop = stops.line;
  const rows: [string, string, string][] = [
    ["page", data.lost ? "lost" : trip_ms === null ? "…" : age(trip_ms), data.lost ? "bad" : trip_ms === null ? "dim" : tone(trip_ms)],
    ["stop line", stop.lost ? "lost" : "ready", stop.lost ? "bad" : "good"],
  ];
  if (v && !v.recorded) {
    const silent_ms = v.silent_ms, ours = Math.min(lease_ms, 1500), obc_ms = s?.link?.obc_age_ms;
    rows.push(["daemon", v.links.alive ? age(silent_ms) : "gone", v.living && silent_ms! < Math.max(lease_ms, 1500) ? "good" : "bad"]);
    rows.push(["telemetry", age(v.links.telemetry_age_ms), v.living ? tone(v.links.telemetry_age_ms, ours) : "bad"]);
    rows.push(["OBC message", v.living ? age(obc_ms) : "?", v.living && s?.authority ? tone(obc_ms) : "dim"]);
    const volts = supply(v);
    if (volts !== null) rows.push(["supply", v.living ? volts : "?", v.living ? "" : "dim"]);
    rows.push(["record", !v.living ? "?" : s?.recording ? "● recording" : "NOT RECORDING", !v.living ? "dim" : s?.recording ? "rec" : "warn"]);
  }
  show($("links"), rows, () => rows.map(([name, value, tone]) => el("div", {class: tone}, el("dt", {}, name), el("dd", {}, value))));
}

function lost() {
  const banner = $("lost"), v = fleet.meant, gone = v?.status && !data.lost && !v.living;
  banner.hidden = !(data.lost || gone) || (!data.heard_ms && !data.refused && performance.now() < 1500);
  if (banner.hidden) return;
  const s = v?.status, mine = s && s.authority && s.authority === lastSource;
  const does = v ? kindOf(v).safe : "";
  const was = s ? `${v!.id} was ${s.state}${s.mode && s.state === "Operational" ? `, ${s.mode}` : ""}` : "";
  const now = gone ? `The daemon of ${v!.id} is ${v!.links.alive ? "silent" : "gone"}${v!.silent_ms === null ? "" : `, last message ${age(v!.silent_ms)} ago`}. ${was}. Motors stop by themselves without it.`
    : !s ? "No connection to the gateway."
    : `Connection lost${data.heard_ms ? ` ${(data.silent_ms / 1000).toFixed(1)} s ago` : ""}. ${was}. ` +
      (s.state !== "Operational" ? "It does not move." : mine ? `Without your heartbeat it ${does}, ${(lease_ms / 1000).toFixed(0)} s after the last one.`
        : s.authority ? `${sourceName(s.authority)} commands it.` : "Nobody commands it.");
  banner.textContent = `${now} ${data.refused ? "A key is needed." : data.lost ? "Connecting again …" : ""}`;
}
let lastSource = "", lease_ms = 2000;

// Two daemons of one name both execute commands.
function rivals() {
  const rows = fleet.sorted.filter((v) => v.living && v.status?.daemons?.length > 1).map((v) => ({id: v.id, daemons: v.status!.daemons as Json[]}));
  const banner = $("rivals");
  banner.hidden = !rows.length;
  show(banner, rows, () => rows.map(({id, daemons}) => el("div", {}, `${daemons.length === 2 ? "Two" : daemons.length} daemons have the name ${id}: `,
    ...daemons.flatMap((d, i) => [i ? " and " : "", el("b", {}, `host ${d.host || "?"}, pid ${d.pid}`), `, started ${new Date(d.started_utc_ns / 1e6).toISOString().slice(0, 19).replace("T", " ")} UTC`]),
    ". Both execute commands. Stop one of them, or give it another vehicle_id.")));
  $("crowded").hidden = !crowded || data.lost;
  $("crowded").textContent = "There are more vehicle names on this domain than the page can list. Some may be invented. STOP ALL reaches every one.";
}

function header() {
  const v = fleet.chosen, s = v?.status, living = v?.living;
  const tone = !s || !living ? "dim" : s.state === "FatalError" ? "bad" : s.state === "SolveErrors" ? "warn" : s.state === "Operational" ? "good" : "calm";
  const does = !s ? "" : v!.recorded ? `recorded${s.state === "Operational" ? `, ${s.mode}` : ""}` : !living ? `as last received${v!.silent_ms === null ? "" : `, ${age(v!.silent_ms)} ago`}` : s.state === "Operational" ? s.progress : s.state === "Idle" ? "motors off" : "";
  show($("state"), [s?.state, does, tone, fleet.vehicles.size], () => s ? [el("b", {class: tone}, s.state), el("span", {}, does)]
    : [el("span", {}, fleet.vehicles.size ? "no vehicle found" : "waiting for a vehicle …")]);
  document.title = s ? `${v!.id}: ${living ? `${s.state}${s.state === "Operational" ? `, ${s.mode}` : ""}` : "silent"}` : "lss-ground";
}

// Problems with one advice are one: the first is shown, the others are below it. The command that the advice names is a
// button beside it.
function problems() {
  const chosen = fleet.chosen, list = (chosen?.status?.problems ?? []) as Json[];
  show(document.querySelector("#problems div")!, [chosen?.id, Boolean(chosen?.status), chosen?.living, list, requests.mayCommand], () => {
    if (!list.length) return [el("p", {class: "dim"}, !chosen?.status ? "" : chosen.living || chosen.recorded ? "None." : "Unknown: it is silent.")];
    const groups = new Map<string, Json[]>();
    list.forEach((p, i) => {
      const key = p.advice ? `${p.error} ${p.advice}` : String(i);
      groups.set(key, [...(groups.get(key) ?? []), p]);
    });
    return [...groups.values()].map(([first, ...others]) => el("div", {class: `problem ${first.error ? "bad" : "warn"}`}, el("b", {}, first.text),
      others.length > 0 && el("details", {}, el("summary", {}, `and ${others.length} more with the same remedy`), ...others.map((p) => el("div", {}, p.text))),
      first.advice && el("span", {}, `→ ${advice(first.advice)}`), first.advice && action(first.advice)));
  });
}

function action(text: string): HTMLElement | null {
  const name = /lss-cli ([a-z][a-z-]*)(?! [A-Z0-9])/.exec(text)?.[1], vehicle = fleet.chosen;
  const command = vehicle?.commands.find((c) => c.name === name && c.parameters.every((p) => p.default !== null));
  if (!command || !requests.mayCommand) return null;
  const button = el("button", {type: "button", title: command.summary}, command.name.replace(/-/g, " "));
  button.onclick = () => panel.run(command.name);
  return button;
}

// The lowest supply voltage of the vehicle's modules.
function supply(v: Vehicle): string | null {
  const [field, member] = String(v.presentation.supply ?? "").split(".");
  if (!field || !v.telemetry) return null;
  const values = (member ? (v.telemetry[field] as Json[] ?? []).map((one) => one[member]) : [v.telemetry[field]])
    .filter((x) => typeof x === "number" && Number.isFinite(x) && x > 0) as number[];
  return values.length ? `${Math.min(...values).toFixed(1)} V` : "–";
}

function overlay() {
  const v = fleet.chosen;
  const lines = v?.telemetry ? kindOf(v).overlay(v.telemetry) : v ? ["no telemetry"] : [];
  show($("overlay"), lines, () => lines.map((line) => el("div", {}, line)));
}

function draw() {
  if (data.welcome) {
    lastSource = data.welcome.source;
    lease_ms = data.welcome.lease_ms;
  }
  const chosen = fleet.chosen;
  document.body.classList.toggle("stale", data.lost || Boolean(chosen && !chosen.living && !chosen.recorded));
  fleet.draw();
  stops.draw();
  rivals();
  header();
  links();
  lost();
  problems();
  overlay();
  panel.draw();
  if (!chosen) return;
  details(chosen);
  parameters.draw(chosen);
  sound.hear(fleet);
}

tabs(draw);
addEventListener("resize", () => plots.resize());
setInterval(draw, 100);
setInterval(() => plots.draw(), 200);
let bars_ms = 0;
requestAnimationFrame(function each(now) {
  scene.draw(now);
  if (now - bars_ms > 60) {
    bars_ms = now;
    bars.draw();
  }
  requestAnimationFrame(each);
});
