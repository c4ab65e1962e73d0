// Signals over time, live or a part of the session: signals of one unit share a chart. The values at the pointer are
// below each chart; a drag zooms, a double click goes back to live.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import {el, $} from "./dom";
import {History, type Vehicle} from "./model";
import type {Signal} from "./vehicles/kind";
import {kindOf} from "./vehicles/roster";

const kHeight_px = 116;
const kSpans: [string, number][] = [["1 min", 60], ["10 min", 600], ["session", Infinity]];
const kColours = {
  dark: ["#4f9cf0", "#e0a33e", "#5fc08a", "#c77dd8", "#e5736b", "#7fc4d6", "#a5ad5c", "#9a8fe0"],
  light: ["#1c66bd", "#a86700", "#1d7f4a", "#93399f", "#c0392f", "#1b7d95", "#6b7415", "#5a4cc0"],
};

export const signalsOf = (vehicle: Vehicle): Signal[] => kindOf(vehicle).signals;

export class Plots {
  private charts: {plot: uPlot; signals: number[]; unit: string}[] = [];
  private shown: Vehicle | null = null;
  private span_s = kSpans[0][1];
  private zoom: {min: number; max: number} | null = null;  // stands still; null: the newest span
  private chosen = new Map<string, Set<string>>();  // by type of vehicle

  private readonly signals = signalsOf;

  record(vehicle: Vehicle) {
    const signals = this.signals(vehicle);
    vehicle.history ??= new History(signals.length);
    vehicle.history.add(Date.now() / 1000, signals.map((s) => {
      const value = s.get(vehicle.telemetry!);
      return typeof value === "number" && Number.isFinite(value) ? value : null;
    }));
  }

  show(vehicle: Vehicle | null) {
    this.shown = vehicle;
    if (!vehicle) return;
    const signals = this.signals(vehicle);
    if (!this.chosen.has(vehicle.kind)) {
      const kept = localStorage.getItem(`signals ${vehicle.kind}`);
      this.chosen.set(vehicle.kind, new Set(kept ? JSON.parse(kept) : signals.filter((s) => s.shown).map((s) => s.name)));
    }
    this.choices(vehicle);
    this.rebuild();
  }

  private choices(vehicle: Vehicle) {
    const chosen = this.chosen.get(vehicle.kind)!;
    const list = el("div", {class: "choices"});
    for (const signal of this.signals(vehicle)) {
      const box = el("input", {type: "checkbox", checked: chosen.has(signal.name)}) as HTMLInputElement;
      box.onchange = () => {
        box.checked ? chosen.add(signal.name) : chosen.delete(signal.name);
        localStorage.setItem(`signals ${vehicle.kind}`, JSON.stringify([...chosen]));
        this.rebuild();
      };
      list.append(el("label", {}, box, ` ${signal.name}`));
    }
    const spans = kSpans.map(([name, span_s]) => {
      const button = el("button", {type: "button", "aria-pressed": String(span_s === this.span_s && !this.zoom)}, name);
      button.onclick = () => {
        this.span_s = span_s;
        this.zoomTo(null);
      };
      return button;
    });
    $("choose").replaceChildren(...spans, el("details", {}, el("summary", {}, "choose"), list));
  }

  private zoomTo(zoom: {min: number; max: number} | null) {
    this.zoom = zoom;
    document.querySelectorAll("#choose > button").forEach((b, i) => b.setAttribute("aria-pressed", String(!zoom && kSpans[i][1] === this.span_s)));
    this.draw();
  }

  rebuild() {
    this.charts.forEach((c) => c.plot.destroy());
    this.charts = [];
    const where = $("charts"), vehicle = this.shown;
    where.replaceChildren();
    if (!vehicle) return;
    const signals = this.signals(vehicle), chosen = this.chosen.get(vehicle.kind)!;
    const units = new Map<string, number[]>();
    signals.forEach((s, i) => {
      if (chosen.has(s.name)) units.set(s.unit, [...(units.get(s.unit) ?? []), i]);
    });
    const style = getComputedStyle(document.documentElement);
    const colours = kColours[style.colorScheme.includes("dark") ? "dark" : "light"];
    const text = style.getPropertyValue("--dim").trim(), line = style.getPropertyValue("--line").trim();
    for (const [unit, members] of units) {
      const axis = {stroke: text, grid: {stroke: line, width: 1}, ticks: {show: false}, font: "11px system-ui, sans-serif"};
      const plot = new uPlot({
        width: where.clientWidth || 400,
        height: kHeight_px,
        cursor: {y: false, drag: {x: true, y: false, setScale: false}, sync: {key: "signals"}, bind: {dblclick: () => () => {
          this.zoomTo(null);
          return null;
        }}},
        hooks: {setSelect: [(u) => {
          const {left, width} = u.select;
          if (width > 3) this.zoomTo({min: u.posToVal(left, "x"), max: u.posToVal(left + width, "x")});
          u.setSelect({left: 0, top: 0, width: 0, height: 0}, false);
        }]},
        scales: {x: {time: true}},
        axes: [{...axis, size: 22, space: 70}, {...axis, size: 44, label: unit, labelSize: 14, labelFont: "11px system-ui, sans-serif", space: 24}],
        series: [{value: (_: uPlot, t: number | null) => t === null || t === undefined ? "–" : new Date(1000 * t).toLocaleTimeString()}, ...members.map((i, k) => ({label: signals[i].name, stroke: colours[k % colours.length], width: 1.5, points: {show: false},
          value: (_: uPlot, v: number | null) => v === null || v === undefined ? "–" : String(Number(v.toPrecision(4)))}))],
      }, [[]] as unknown as uPlot.AlignedData, where);
      this.charts.push({plot, signals: members, unit});
    }
    if (!units.size) where.append(el("p", {class: "empty"}, "No signal is chosen."));
    this.draw();
  }

  resize() {
    const width = $("charts").clientWidth;
    for (const {plot} of this.charts) if (plot.width !== width && width > 0) plot.setSize({width, height: kHeight_px});
  }

  draw() {
    const history = this.shown?.history;
    if (!history || document.hidden) return;
    const recorded = this.shown!.recorded, now = !recorded ? Date.now() / 1000 : this.span_s === Infinity ? recorded.end_s : recorded.now_s, begin = Math.max(now - this.span_s, history.times[0] ?? now - kSpans[0][1]);
    const {min, max} = this.zoom ?? {min: this.span_s === Infinity ? begin : now - this.span_s, max: now};
    const from = Math.max(0, history.from(min) - 1), to = history.from(max) + 1, seen = $("charts").parentElement!.getBoundingClientRect();
    for (const {plot, signals} of this.charts) {
      const {top, bottom} = plot.root.getBoundingClientRect();
      if (bottom < seen.top || top > seen.bottom) continue;  // scrolled away
      plot.batch(() => {
        plot.setData([history.times, ...signals.map((i) => history.values[i])].map((all) => all.slice(from, to)) as unknown as uPlot.AlignedData, true);
        plot.setScale("x", {min, max});
      });
    }
  }
}
