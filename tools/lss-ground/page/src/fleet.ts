// The list of vehicles, and the one shown. Vehicles with a running daemon come first. The page opens on one of these
// and then stays. The next page opens on the vehicle that the user chose, if its daemon runs.

import {$, el, show} from "./dom";
import type {Json} from "./link";
import {type Links, Vehicle} from "./model";

export class Fleet {
  readonly vehicles = new Map<string, Vehicle>();
  chosen: Vehicle | null = null;

  constructor(private readonly changed: (vehicle: Vehicle) => void) {
    const list = $("vehicles") as HTMLSelectElement;
    list.onchange = () => {
      localStorage.setItem("vehicle", list.value);
      this.choose(this.vehicles.get(list.value));
    };
  }

  get sorted() {
    return [...this.vehicles.values()].sort((a, b) => Number(b.living) - Number(a.living) || a.id.localeCompare(b.id));
  }

  add(message: Json) {
    const before = this.vehicles.get(message.id);
    const same = (a: unknown, b: unknown) => JSON.stringify(a) === JSON.stringify(b);
    const vehicle = new Vehicle(message.id, message), parts = ["kind", "commands", "subjects", "scripts", "fields", "presentation"] as const;
    if (before && parts.every((part) => same(before[part], vehicle[part]))) return;
    this.vehicles.set(vehicle.id, vehicle);
    if (this.chosen?.id === vehicle.id) this.choose(vehicle);
  }

  // The gateway no longer has a place for it. The page keeps showing it, as silent.
  gone(id: string) {
    const vehicle = this.vehicles.get(id);
    if (!vehicle) return;
    vehicle.links = {...vehicle.links, alive: false};
    if (vehicle !== this.chosen) this.vehicles.delete(id);
  }

  // A recording, shown beside the vehicles.
  open(vehicle: Vehicle) {
    this.vehicles.set(vehicle.id, vehicle);
    this.choose(vehicle);
  }
  close(vehicle: Vehicle) {
    this.vehicles.delete(vehicle.id);
    this.chosen = null;
    this.choose(this.sorted.find((v) => v.living) ?? this.sorted[0]);
    if (!this.chosen) location.reload();
  }
  // What STOP is for; null: every vehicle.
  get meant() { return this.chosen?.recorded ? null : this.chosen; }

  // All vehicles that the gateway knows, with the age of the last message.
  heard(crafts: Record<string, Links>) {
    for (const [id, vehicle] of this.vehicles) if (!crafts[id] && !vehicle.recorded) this.gone(id);
    for (const [id, links] of Object.entries(crafts)) {
      const vehicle = this.vehicles.get(id);
      if (!vehicle) continue;
      vehicle.links = links;
      vehicle.links_ms = performance.now();
    }
    if (this.chosen) return;
    const living = this.sorted.filter((v) => v.living);
    this.choose(living.find((v) => v.id === localStorage.getItem("vehicle")) ?? living[0]);
  }

  private choose(vehicle: Vehicle | undefined) {
    if (!vehicle || vehicle === this.chosen) return;
    this.chosen = vehicle;
    this.changed(vehicle);
  }

  // Every vehicle, in a line: who it is, how it is, and what is wrong with it; the ones with errors come first. A press
  // shows it.
  private strip() {
    const where = $("strip"), all = [...this.vehicles.values()].sort((a, b) => a.id.localeCompare(b.id, undefined, {numeric: true}));
    where.hidden = all.length < 2;
    if (where.hidden) return;
    const rows = all.map((v) => {
      const s = v.status, wrong = (s?.problems ?? []) as Json[], errors = wrong.filter((p) => p.error).length;
      return {id: v.id, state: v.recorded ? "recording" : !v.living ? "silent" : s ? s.state === "Operational" ? s.mode : s.state : "…",
        tone: !v.living ? "dim" : s?.state === "FatalError" || errors ? "bad" : wrong.length ? "warn" : s?.state === "Operational" ? "good" : "calm",
        count: v.living ? wrong.length : 0, shown: v === this.chosen};
    }).sort((a, b) => Number(b.tone === "bad") - Number(a.tone === "bad"));
    show(where, rows, () => rows.map((row) => {
      const button = el("button", {type: "button", class: row.tone, "aria-pressed": String(row.shown), title: row.count ? `${row.count} problems` : row.state},
        el("b", {}, row.id), el("span", {}, row.state), row.count > 0 && el("i", {}, String(row.count)));
      button.onclick = () => {
        localStorage.setItem("vehicle", row.id);
        this.choose(this.vehicles.get(row.id));
      };
      return button;
    }));
  }

  draw() {
    const list = $("vehicles") as HTMLSelectElement;
    const rows = this.sorted.map((v) => ({id: v.id, living: v.living || Boolean(v.recorded), text: v.recorded ? v.id : !v.living ? `${v.id}, ${silence(v)}` : v.id === v.kind ? v.id : `${v.id} (${v.kind})`}));
    show(list, [rows, this.chosen?.id], () => {
      const option = (row: typeof rows[0]) => el("option", {value: row.id, selected: row.id === this.chosen?.id, class: row.living ? "" : "silent"}, row.text);
      const silent = rows.filter((row) => !row.living);
      return [!this.chosen && el("option", {value: "", selected: true, disabled: true}, rows.length ? "none runs: choose" : "no vehicle"),
        ...rows.filter((row) => row.living).map(option),
        silent.length > 0 && el("optgroup", {label: "silent"}, ...silent.map(option))];
    });
    list.classList.toggle("silent", Boolean(this.chosen) && !this.chosen!.living && !this.chosen!.recorded);
    this.strip();
  }
}

// In minutes: a list that changes every second is unreadable.
export function silence(vehicle: Vehicle): string {
  const ms = vehicle.silent_ms;
  return ms === null ? "no message" : ms < 60_000 ? "silent" : `silent for ${Math.floor(ms / 60_000)} min`;
}
