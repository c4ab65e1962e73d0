// Below the picture: events, timing of the frames, every module, and all fields of the telemetry.

import {$, age, el, fixed, show} from "./dom";
import type {Json} from "./link";
import type {Vehicle} from "./model";
import {kindOf} from "./vehicles/roster";
import type {Cell, Table} from "./vehicles/kind";

const kTabs = [["events", "Events"], ["timing", "Timing"], ["parts", "Modules"], ["measured", "Telemetry"], ["parameters", "Parameters"]] as const;
const kSeverities = ["info", "warning", "error", "fatal"];
let chosen = "events", least = 0, words = "";

export function tabs(changed: () => void) {
  const list = document.querySelector("#tabs [role=tablist]")! as HTMLElement;
  const choose = (id: string) => {
    chosen = id;
    for (const [name] of kTabs) {
      const tab = $(`tab-${name}`);
      tab.setAttribute("aria-selected", String(name === id));
      tab.tabIndex = name === id ? 0 : -1;
      $(name).hidden = name !== id;
    }
    changed();
  };
  for (const [id, title] of kTabs) {
    const tab = el("button", {type: "button", role: "tab", id: `tab-${id}`, "aria-controls": id}, title);
    tab.onclick = () => choose(id);
    list.append(tab);
    $(id).setAttribute("aria-labelledby", tab.id);
  }
  list.onkeydown = (e) => {
    const step = {ArrowRight: 1, ArrowLeft: -1}[e.key];
    if (!step) return;
    const at = kTabs.findIndex(([id]) => id === chosen), [id] = kTabs[(at + step + kTabs.length) % kTabs.length];
    choose(id);
    $(`tab-${id}`).focus();
  };
  choose(chosen);
  const severity = el("select", {"aria-label": "Least severity"}, ...kSeverities.map((s, i) => el("option", {value: String(i)}, i ? `${s} and worse` : "all"))) as HTMLSelectElement;
  const filter = el("input", {type: "search", placeholder: "words", "aria-label": "Words to filter by"}) as HTMLInputElement;
  severity.onchange = () => { least = Number(severity.value); changed(); };
  filter.oninput = () => { words = filter.value.toLowerCase(); changed(); };
  $("events").append(el("div", {class: "filter"}, severity, filter), el("ol", {}));
}

export function details(vehicle: Vehicle) {
  if (chosen === "events") events(vehicle);
  if (chosen === "timing") timing(vehicle);
  if (chosen === "parts") parts(vehicle);
  if (chosen === "measured") measured(vehicle);
}

function events(vehicle: Vehicle) {
  const list = $("events").querySelector("ol")!;
  show(list, [vehicle.id, vehicle.events_version, least, words], () => [...vehicle.events.values()]
    .filter((e) => kSeverities.indexOf(e.severity) >= least && (!words || `${e.text} ${e.subject_name}`.toLowerCase().includes(words)))
    .sort((a, b) => b.index - a.index).slice(0, 200)
    .map((e) => el("li", {class: e.severity}, el("time", {}, new Date(e.utc_ns / 1e6).toISOString().slice(11, 23)), el("b", {}, e.severity), el("span", {}, e.text))));
}

function timing(vehicle: Vehicle) {
  const t = vehicle.timing;
  show($("timing"), [vehicle.id, t?.until_ns], () => {
    if (!t) return [el("p", {class: "empty"}, "No timing was received yet.")];
    const us = (value: unknown) => fixed(value, 1);
    const rows = Object.entries(t.points as Json).map(([name, p]) => [name, us(p.mean_us), us(p.sigma_us), us(p.p50_us), us(p.p99_us), us(p.p999_us), us(p.max_us)]);
    return [el("p", {}, `${t.frames} frames of ${fixed(t.period_ns * 1e-6, 0)} ms · ${t.missed.overruns} commands late · ${t.missed.repeated} repeated · ${t.missed.skipped} frames skipped · least margin ${us(t.margin?.min_us)} µs`),
      table({heads: ["µs", "mean", "sigma", "p50", "p99", "p99.9", "max"], rows}), histogram(t.points.command, "boundary to command ready")];
  });
}

function histogram(series: Json | undefined, title: string): HTMLElement | null {
  if (!series?.histogram?.length) return null;
  const most = Math.max(...series.histogram.map((b: Json) => Math.log2(1 + b.count)));
  const ns = "http://www.w3.org/2000/svg", svg = document.createElementNS(ns, "svg");
  svg.setAttribute("viewBox", "0 0 600 90");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", title);
  const width = 600 / series.histogram.length;
  series.histogram.forEach((b: Json, i: number) => {
    const height = Math.log2(1 + b.count) / most * 70, bar = document.createElementNS(ns, "rect");
    for (const [k, value] of Object.entries({x: i * width + 0.5, y: 74 - height, width: Math.max(1, width - 1), height})) bar.setAttribute(k, String(value));
    const tip = document.createElementNS(ns, "title");
    tip.textContent = `${b.from_us.toFixed(1)} to ${b.to_us.toFixed(1)} µs: ${b.count}`;
    bar.append(tip);
    svg.append(bar);
  });
  for (const [x, anchor, bucket] of [[0, "start", series.histogram[0]], [600, "end", series.histogram.at(-1)]] as const) {
    const label = document.createElementNS(ns, "text");
    label.setAttribute("x", String(x));
    label.setAttribute("y", "87");
    label.setAttribute("text-anchor", anchor);
    label.textContent = `${(anchor === "start" ? bucket.from_us : bucket.to_us).toFixed(0)} µs`;
    svg.append(label);
  }
  return el("figure", {}, svg as unknown as Node, el("figcaption", {}, `${title}, counts by their logarithm`));
}

function cell(c: string | Cell): HTMLElement {
  return typeof c === "string" ? el("td", {}, c) : el("td", {class: c.tone ?? ""}, c.text);
}

function table(t: Table): HTMLElement {
  return el("table", {}, el("thead", {}, el("tr", {}, ...t.heads.map((h) => el("th", {}, h)))),
    el("tbody", {}, ...t.rows.map((row) => el("tr", {}, ...row.map(cell)))));
}

function parts(vehicle: Vehicle) {
  const s = vehicle.status;
  const tables = vehicle.telemetry ? kindOf(vehicle).tables(vehicle.telemetry) : [];
  show($("parts"), [vehicle.id, tables, s?.frame?.index], () => [...tables.map(table), s && el("p", {class: "hint"},
    `frame ${s.frame.index}, ${s.frame.overruns} overruns · ${s.counters.commands_rejected} commands rejected · ${s.counters.safe_commands} safe commands · ` +
    `last OBC message ${age(s.link.obc_age_ms)} ago · real time ${s.realtime.policy}, ${s.realtime.granted ? "granted" : "not granted"} · shared memory ${s.shared_memory} · lssd ${s.version}`)]);
}

// All fields of the telemetry by their names in the IDL: a table for each array of structs, and one for the others.
function measured(vehicle: Vehicle) {
  const all = Object.entries(vehicle.telemetry ?? {});
  const text = (x: unknown): string => x === null ? "–" : Array.isArray(x) ? x.map(text).join("  ") : String(x);
  const structs = ([, x]: [string, any]) => Array.isArray(x) && typeof x[0] === "object" && x[0] !== null;
  show($("measured"), [vehicle.id, all], () => [
    table({heads: ["field", "value"], rows: all.filter((f) => !structs(f)).map(([name, x]) => [name, text(x)])}),
    ...all.filter(structs).map(([name, list]) => table({heads: [name, ...list.map((_: Json, i: number) => String(i))],
      rows: Object.keys(list[0]).map((key) => [key, ...list.map((part: Json) => text(part[key]))])}))]);
}
