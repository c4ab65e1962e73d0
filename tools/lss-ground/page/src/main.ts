// The pilot's page of lss-ground. What it shows comes from the daemon; what it does goes to the daemon.

import "./style.css";
import {details, tabs} from "./details";
import {$, advice, age, el, show} from "./dom";
import {beat, keyGiven, Line, setKey, type Json} from "./link";
import {Vehicle} from "./model";
import {Panel} from "./panel";
import {Parameters} from "./parameters";
import {Plots} from "./plots";
import {Requests} from "./requests";
import {Bars, Scene} from "./scene";
import {roster} from "./vehicles/roster";

const kStopsAfter_ms = 3200;  // the gateway gives up after 3 s

const vehicles = new Map<string, Vehicle>();
let chosen: Vehicle | null = null;
let trip_ms: number | null = null;

const data = new Line("lss-ground", hear);
const stop = new Line("lss-stop", hearStop);
const pulse = beat(data, (ms) => { trip_ms = ms; });

const scene = new Scene($("scene") as HTMLCanvasElement);
const bars = new Bars($("bars") as HTMLCanvasElement);
const plots = new Plots();
const requests = new Requests(data);
const panel = new Panel(requests);
const parameters = new Parameters($("parameters"), requests);

function hear(m: Json) {
  switch (m.type) {
    case "pulse": {
      pulse(m);
      for (const [id, links] of Object.entries(m.crafts ?? {})) {
        const vehicle = vehicles.get(id);
        if (vehicle) vehicle.links = links as Vehicle["links"];
      }
      return;
    }
    case "refused": return askKey();
    case "welcome":
      requests.begin();
      return panel.ask();
    case "vehicle": {
      const before = vehicles.get(m.id);
      if (before && before.kind === m.vehicle) return;
      vehicles.set(m.id, new Vehicle(m.id, m));
      return choose(chosen ? chosen.id : localStorage.getItem("vehicle") ?? m.id);
    }
    case "ack": return requests.heard(m);
  }
  const vehicle = vehicles.get(m.id);
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
      vehicle.telemetry = m;
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

function choose(id: string) {
  const list = $("vehicles") as HTMLSelectElement;
  list.replaceChildren(...[...vehicles.values()].map((v) => el("option", {value: v.id}, v.id === v.kind ? v.id : `${v.id} (${v.kind})`)));
  const vehicle = vehicles.get(id) ?? [...vehicles.values()][0];
  list.value = vehicle.id;
  if (vehicle === chosen) return;
  chosen = vehicle;
  localStorage.setItem("vehicle", vehicle.id);
  scene.show(vehicle);
  plots.show(vehicle);
  panel.show(vehicle);
  draw();
}

// Emergency stop: one click or the space bar, at any time.

let stops = 0;
const stopping = new Map<number, {vehicle: Vehicle | null; at: number}>();

function emergency() {
  const id = ++stops, at = performance.now();
  if (!stop.send({type: "stop", id, vehicle: chosen?.id ?? ""})) return stopText("NOT SENT: no connection. Use the switch.", "bad");
  stopping.set(id, {vehicle: chosen, at});
  stopText("sent …", "busy");
  setTimeout(() => {
    if (stopping.delete(id)) stopText("NOT ACKNOWLEDGED. Cut the power.", "bad");
  }, kStopsAfter_ms);
}

let stopShown_ms = -Infinity;
function stopText(text: string, tone: string) {
  $("estop-text").textContent = text;
  $("estop").dataset.tone = tone;
  stopShown_ms = performance.now();
}

function hearStop(m: Json) {
  // What the old connection may not have delivered.
  if (m.type === "welcome") stopping.forEach((sent, id) => stop.send({type: "stop", id, vehicle: sent.vehicle?.id ?? ""}));
  const sent = m.type === "ack" ? stopping.get(m.request) : undefined;
  if (!sent) return;
  if (m.phase === "rejected" || m.phase === "failed" || m.phase === "unanswered") {
    stopText(m.phase === "unanswered" ? "NOT ACKNOWLEDGED. Cut the power." : `REFUSED: ${m.reason?.text ?? m.text}`, "bad");
  } else {
    const after_ms = performance.now() - sent.at;
    $("estop").dataset.ms = after_ms.toFixed(1);  // for those who measure
    stopText(`acknowledged after ${Math.round(after_ms)} ms`, "good");
  }
  stopping.delete(m.request);
}

$("estop").addEventListener("pointerdown", (e) => { e.preventDefault(); emergency(); });
addEventListener("keydown", (e) => {
  const writes = e.target instanceof HTMLTextAreaElement || e.target instanceof HTMLInputElement && ["search", "password"].includes(e.target.type);
  const onStop = e.target === $("estop") && e.key === "Enter";
  if (e.key === "Enter" && e.target instanceof HTMLInputElement && e.target.type === "checkbox") e.target.click();
  if ((e.code !== "Space" || writes) && !onStop) return;
  e.preventDefault();  // also where the space bar would press another button
  if (!e.repeat) emergency();
}, true);
addEventListener("keyup", (e) => { if (e.code === "Space" && e.target instanceof HTMLButtonElement) e.preventDefault(); }, true);

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
    stop.again();
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

function links() {
  const v = chosen, s = v?.status;
  const rows: [string, string, string][] = [
    ["page", data.lost ? "lost" : trip_ms === null ? "…" : age(trip_ms), data.lost ? "bad" : "good"],
    ["stop line", stop.lost ? "lost" : "ready", stop.lost ? "bad" : "good"],
  ];
  if (v) {
    rows.push(["daemon", v.links.alive ? `${age(v.links.status_age_ms)}` : "gone", !v.links.alive || (v.links.status_age_ms ?? 9e9) > 2500 ? "bad" : "good"]);
    rows.push(["telemetry", age(v.links.telemetry_age_ms), (v.links.telemetry_age_ms ?? 9e9) > 1500 ? "bad" : "good"]);
    rows.push(["OBC heard", age(s?.link?.obc_age_ms), "dim"]);
    rows.push(["record", s?.recording ? "● recording" : "NOT RECORDING", s?.recording ? "rec" : "warn"]);
  }
  show($("links"), rows, () => rows.map(([name, value, tone]) => el("div", {class: tone}, el("dt", {}, name), el("dd", {}, value))));
}

function lost() {
  const banner = $("lost"), v = chosen, gone = v?.status && !data.lost && (!v.links.alive || (v.links.status_age_ms ?? 0) > 3000);
  banner.hidden = !(data.lost || gone) || (!data.heard_ms && !data.refused && performance.now() < 1500);
  if (banner.hidden) return;
  const s = v?.status, mine = s && s.authority && s.authority === lastSource;
  const does = v ? roster[v.kind]?.safe ?? "comes to a safe stop" : "";
  const was = s ? `${v!.id} was ${s.state}${s.mode && s.state === "Operational" ? `, ${s.mode}` : ""}` : "";
  const now = gone ? `The daemon of ${v!.id} is gone. ${was}. Motors stop by themselves without it.`
    : !s ? "No connection to the gateway."
    : `Connection lost${data.heard_ms ? ` ${(data.silent_ms / 1000).toFixed(1)} s ago` : ""}. ${was}. ` +
      (s.state !== "Operational" ? "It does not move." : mine ? `Without your heartbeat it ${does}, ${(lease_ms / 1000).toFixed(0)} s after it was heard last.`
        : s.authority ? `${s.authority} commands it.` : "Nobody commands it.");
  banner.textContent = `${now} ${data.refused ? "A key is needed." : data.lost ? "Connecting again …" : ""}`;
}
let lastSource = "", lease_ms = 2000;

function header() {
  const v = chosen, s = v?.status;
  const tone = !s ? "dim" : s.state === "FatalError" ? "bad" : s.state === "SolveErrors" ? "warn" : s.state === "Operational" ? "good" : "calm";
  show($("state"), [s?.state, s?.mode, s?.progress, tone], () => s ? [el("b", {class: tone}, s.state),
    el("span", {}, s.state === "Operational" ? s.progress : s.state === "Idle" ? "motors off" : "")] : [el("span", {}, "waiting for a vehicle …")]);
  if (performance.now() - stopShown_ms > 6000 && !stopping.size) {
    const why = stop.lost ? "no connection" : stop.welcome?.role === "look" ? "this key may not stop" : "";
    $("estop-text").textContent = why || `${chosen?.id ?? "all"} · space bar`;
    $("estop").dataset.tone = why ? "bad" : "";
  }
  document.title = s ? `${v!.id}: ${s.state}${s.state === "Operational" ? `, ${s.mode}` : ""}` : "lss-ground";
}

function problems() {
  const list = chosen?.status?.problems ?? [];
  show(document.querySelector("#problems div")!, [chosen?.id, Boolean(chosen?.status), list], () => list.length
    ? list.map((p: Json) => el("p", {class: p.error ? "bad" : "warn"}, el("b", {}, p.text), p.advice && el("span", {}, `→ ${advice(p.advice)}`)))
    : [el("p", {class: "dim"}, chosen?.status ? "None." : "")]);
}

function overlay() {
  const v = chosen, kind = v && roster[v.kind];
  const lines = kind && v.telemetry ? kind.overlay(v.telemetry) : v ? ["no telemetry"] : [];
  show($("overlay"), lines, () => lines.map((line) => el("div", {}, line)));
}

function draw() {
  if (data.welcome) {
    lastSource = data.welcome.source;
    lease_ms = data.welcome.lease_ms;
  }
  document.body.classList.toggle("stale", data.lost);
  header();
  links();
  lost();
  problems();
  overlay();
  panel.draw();
  if (!chosen) return;
  details(chosen);
  parameters.draw(chosen);
}

tabs(draw);
$("vehicles").onchange = () => choose(($("vehicles") as HTMLSelectElement).value);
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
