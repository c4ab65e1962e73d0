// Signals over the last minute: signals of one unit share a chart.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import {el, $} from "./dom";
import {History, type Vehicle} from "./model";
import type {Signal} from "./vehicles/kind";
import {kindOf} from "./vehicles/roster";

const kHeight_px = 116;
const kColours = {
  dark: ["#4f9cf0", "#e0a33e", "#5fc08a", "#c77dd8", "#e5736b", "#7fc4d6", "#a5ad5c", "#9a8fe0"],
  light: ["#1c66bd", "#a86700", "#1d7f4a", "#93399f", "#c0392f", "#1b7d95", "#6b7415", "#5a4cc0"],
};

export class Plots {
  private charts: {plot: uPlot; signals: number[]; unit: string}[] = [];
  private shown: Vehicle | null = null;
  private chosen = new Map<string, Set<string>>();  // by type of vehicle

  private signals(vehicle: Vehicle): Signal[] { return kindOf(vehicle).signals; }

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
    $("choose").replaceChildren(el("details", {}, el("summary", {}, "choose"), list));
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
        cursor: {y: false, drag: {x: false, y: false}},
        legend: {live: false},
        scales: {x: {time: true}},
        axes: [{...axis, size: 22, space: 70}, {...axis, size: 44, label: unit, labelSize: 14, labelFont: "11px system-ui, sans-serif", space: 24}],
        series: [{}, ...members.map((i, k) => ({label: signals[i].name, stroke: colours[k % colours.length], width: 1.5, points: {show: false}}))],
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
    const end = Date.now() / 1000, seen = $("charts").parentElement!.getBoundingClientRect();
    for (const {plot, signals} of this.charts) {
      const {top, bottom} = plot.root.getBoundingClientRect();
      if (bottom < seen.top || top > seen.bottom) continue;  // scrolled away
      plot.batch(() => {
        plot.setData([history.times, ...signals.map((i) => history.values[i])] as uPlot.AlignedData, true);
        plot.setScale("x", {min: end - History.kSeconds, max: end});
      });
    }
  }
}
