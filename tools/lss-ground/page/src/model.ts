// The data about vehicles that the gateway has sent.

import type {Json} from "./link";

export interface Parameter {
  name: string; unit: string; min: number; max: number; required: boolean; whole: boolean; help: string;
  default: number | null; choices?: string[];
}
export interface Command {
  kind: number; name: string; summary: string; access: string; leased: boolean; parameters: Parameter[];
  allowed: {where: string; when: string[]}[];
}
// Of the telemetry, in the words of the dictionary.
export interface Field {
  name: string; type?: string; unit?: string; count?: number; fields?: Field[];
  label?: string; shown?: {unit: string; factor: number};  // for people: without its unit, in that of people
}
export interface Tunable {
  name: string; value: number; unit: string; min: number; max: number; whole: boolean; configured: number;
  saved: number | null; as_configured: boolean; as_saved: boolean; change: "always" | "at_rest"; help: string;
}
export interface Guard { allowed: boolean; why: string; advice: string; first: string; }
export interface Running { command: string; phase: string; step: string; left: number; steps: number; text: string; at: number; final: boolean; }

export interface Links { alive: boolean; daemon_age_ms: number | null; status_age_ms: number | null; telemetry_age_ms: number | null; }

// What is played of a recording.
export interface Recorded {
  now_s: number; playing: boolean; speed: number; readonly begin_s: number; readonly end_s: number;
  telemetryNow(): Json | null;
  statusNow(): Json | null;
}

export const kStale_ms = 3000;  // a heartbeat comes every second

// Samples of all signals since the page was opened: the last ten minutes as received, before these one a second.
export class History {
  static readonly kFine_s = 600;
  times: number[] = [];
  values: (number | null)[][];
  private fine = 0;       // index of the first sample that is not thinned out
  constructor(count: number, private readonly fine_s = History.kFine_s) { this.values = Array.from({length: count}, () => []); }
  add(time_s: number, row: (number | null)[]) {
    this.times.push(time_s);
    row.forEach((v, i) => this.values[i].push(v));
    if (time_s - this.times[this.fine] > 1.1 * this.fine_s) this.thin(time_s - this.fine_s);
  }
  // The index of the first sample from this time on.
  from(time_s: number): number {
    let low = 0, high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      this.times[middle] < time_s ? low = middle + 1 : high = middle;
    }
    return low;
  }
  private thin(before_s: number) {
    const end = this.from(before_s), kept: number[] = [];
    for (let i = this.fine; i < end; ++i) if (!kept.length || Math.floor(this.times[i]) !== Math.floor(this.times[kept[kept.length - 1]])) kept.push(i);
    const thinned = <T>(list: T[]) => { list.splice(this.fine, end - this.fine, ...kept.map((i) => list[i])); };
    this.values.forEach(thinned);
    thinned(this.times);
    this.fine += kept.length;
  }
}

export class Vehicle {
  readonly kind: string;
  readonly commands: Command[];
  readonly subjects: string[];
  readonly scripts: boolean;
  readonly fields: Field[];
  readonly presentation: Json;
  status: Json | null = null;
  telemetry: Json | null = null;
  telemetry_ms = 0;  // performance.now()
  timing: Json | null = null;
  parameters: Json | null = null;
  events = new Map<number, Json>();
  events_version = 0;
  guards = new Map<string, Guard>();
  running: Running | null = null;
  links: Links = {alive: false, daemon_age_ms: null, status_age_ms: null, telemetry_age_ms: null};
  links_ms = 0;  // performance.now() of them
  history: History | null = null;
  recorded: Recorded | null = null;  // it is a recording, no vehicle

  constructor(readonly id: string, message: Json) {
    this.kind = message.vehicle;
    this.commands = message.commands;
    this.subjects = message.subjects;
    this.scripts = message.scripts;
    this.fields = message.fields ?? [];
    this.presentation = message.presentation ?? {};
  }

  // Age of what came last of its daemon, and of its status, also when the gateway is silent; null: never received.
  get silent_ms() { return this.now_ms(this.links.daemon_age_ms); }
  get status_age_ms() { return this.now_ms(this.links.status_age_ms); }
  private now_ms(age_ms: number | null) { return age_ms === null ? null : age_ms + performance.now() - this.links_ms; }
  get living() { return this.links.alive && (this.silent_ms ?? Infinity) < kStale_ms; }
  // A press of STOP would land this vehicle: without a command for it, everything goes off.
  get lands() {
    return Boolean(this.status?.airborne) && this.status?.stop_in_flight === "lands" && this.commands.some((c) => c.name === "land");
  }

  addEvent(event: Json) {
    // A restarted daemon counts from 1.
    const newest = [...this.events.values()].pop();
    if (newest && event.index <= newest.index && event.utc_ns > newest.utc_ns) this.events.clear();
    // A later report of a series contains those before.
    for (const [index, e] of this.events)
      if (event.count > 1 && e.id === event.id && e.subject === event.subject && e.first_ns === event.first_ns) this.events.delete(index);
    this.events.set(event.index, event);
    if (this.events.size > 1024) this.events.delete(this.events.keys().next().value!);
    this.events_version++;
  }
}
