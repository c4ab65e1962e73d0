// Commands: a button that the daemon would reject now is disabled and shows the reason. The daemon
// decides, by a dry run of exactly the command of the button; nothing is decided here.

import {$, el, kDegree, show, sourceName} from "./dom";
import type {Json} from "./link";
import type {Command, Parameter, Vehicle} from "./model";
import {outcome, reasons, type Requests} from "./requests";
import {kindOf} from "./vehicles/roster";

const kAgain_ms = 1000;
// The gateway requests data itself; parameters have their own tab.
const kOwn = 100;  // kinds of its own commands begin there
const kHidden = ["data", "set-parameter", "save-parameters"];

interface Row { command: Command; element: HTMLElement; button: HTMLButtonElement; why: HTMLElement; inputs: Map<string, () => number | null>; }

function shownUnit(p: Parameter): string {
  return p.unit === "rad" ? "deg" : p.unit === "choice" || p.unit === "set" ? "" : p.unit;
}

export class Panel {
  private rows: Row[] = [];
  private shown: Vehicle | null = null;
  private runs: HTMLButtonElement | null = null;  // a script

  constructor(private readonly requests: Requests) {
    setInterval(() => this.ask(), kAgain_ms);
  }

  show(vehicle: Vehicle | null) {
    this.shown = vehicle;
    this.rows = [];
    this.runs = null;
    const list = $("list");
    list.replaceChildren();
    if (!vehicle) return;
    const {order} = kindOf(vehicle);
    const rank = (c: Command) => (order.indexOf(c.name) + 1) || order.length + (c.kind >= kOwn ? c.kind : 1000 * c.kind);
    const commands = vehicle.commands.filter((c) => !kHidden.includes(c.name)).sort((a, b) => rank(a) - rank(b));
    for (const command of commands) this.rows.push(this.row(command));
    const main = this.rows.filter((r) => order.includes(r.command.name)), more = this.rows.filter((r) => !main.includes(r));
    list.append(...main.map((r) => r.element));
    if (more.length) list.append(el("details", {class: "more"}, el("summary", {}, "more commands"), ...more.map((r) => r.element)));
    if (vehicle.scripts) list.append(this.scripts());
    this.ask();
  }

  private row(command: Command): Row {
    const button = el("button", {type: "button", disabled: true, title: command.summary}, command.name.replace(/-/g, " ")) as HTMLButtonElement;
    const fields = el("span", {class: "fields"}), why = el("div", {class: "why"});
    const inputs = new Map<string, () => number | null>();
    for (const p of command.parameters) fields.append(this.field(p, inputs));
    const row = {command, button, why, inputs, element: el("div", {class: "command"}, button, fields, why)};
    button.onclick = () => this.send(row);
    return row;
  }

  private field(p: Parameter, inputs: Map<string, () => number | null>): HTMLElement {
    const hint = `${p.name}: ${p.help}`;
    const changed = () => this.ask();
    if (p.choices) {
      const select = el("select", {title: hint, "aria-label": p.name},
        ...p.choices.map((choice, i) => el("option", {value: String(p.min + i), selected: p.default === p.min + i}, choice))) as HTMLSelectElement;
      select.onchange = changed;
      inputs.set(p.name, () => Number(select.value));
      return el("label", {title: hint}, el("i", {}, p.name), select);
    }
    if (p.unit === "set") {
      const count = Math.round(Math.log2(p.max + 1));
      const boxes = Array.from({length: count}, (_, i) => el("input", {type: "checkbox", "aria-label": `${p.name} ${i + 1}`, checked: ((p.default ?? 0) >> i & 1) === 1}) as HTMLInputElement);
      boxes.forEach((b) => { b.onchange = changed; });
      inputs.set(p.name, () => boxes.reduce((set, b, i) => set + (b.checked ? 2 ** i : 0), 0));
      return el("label", {title: hint, class: "set"}, el("i", {}, p.name), ...boxes.map((b, i) => el("span", {}, String(i + 1), b)));
    }
    const scale = p.unit === "rad" ? kDegree : 1, unit = shownUnit(p);
    const shown = (value: number) => String(Number((value / scale).toPrecision(6)));
    const input = el("input", {type: "number", title: `${hint} (${shown(p.min)} to ${shown(p.max)} ${unit})`, "aria-label": p.name,
      min: shown(p.min), max: shown(p.max), step: p.whole ? "1" : "any", value: p.default === null ? "" : shown(p.default), placeholder: "?"}) as HTMLInputElement;
    input.onchange = changed;
    inputs.set(p.name, () => input.value === "" || !Number.isFinite(input.valueAsNumber) ? null : input.valueAsNumber * scale);
    return el("label", {title: hint}, el("i", {}, p.name), input, unit && ` ${unit}`);
  }

  private parameters(row: Row): Record<string, number> | null {
    const all: Record<string, number> = {};
    for (const [name, read] of row.inputs) {
      const value = read();
      if (value === null) return null;
      all[name] = value;
    }
    return all;
  }

  // Would it be accepted?
  ask() {
    const vehicle = this.shown;
    if (!vehicle || document.hidden || !this.requests.mayCommand) return this.draw();
    for (const row of this.rows) {
      const more = row.element.closest("details");
      if (more && !(more as HTMLDetailsElement).open) continue;
      const parameters = this.parameters(row);
      if (!parameters) {
        vehicle.guards.set(row.command.name, {allowed: false, why: "fill in what has a ?", advice: "", first: ""});
        continue;
      }
      this.requests.send({type: "command", vehicle: vehicle.id, command: row.command.name, parameters, dry_run: true, whole: true},
        (ack) => this.answered(vehicle, row.command.name, ack));
    }
    this.draw();
  }

  private answered(vehicle: Vehicle, command: string, ack: Json) {
    if (ack.phase !== "accepted" && ack.phase !== "rejected" && ack.phase !== "failed") return;
    const first = ack.steps > 1 ? String(ack.step).split(" ")[0] : "";
    vehicle.guards.set(command, {allowed: ack.phase === "accepted", first, ...reasons(ack)});
    this.draw();
  }

  private send(row: Row) {
    const parameters = this.parameters(row);
    if (parameters) this.run(row.command.name, parameters);
  }

  // A command, with the steps before it.
  run(command: string, parameters: Record<string, number> = {}) {
    this.begin(command, {type: "command", command, parameters, whole: true});
  }

  private begin(command: string, message: Json) {
    const vehicle = this.shown;
    if (!vehicle) return;
    vehicle.running = {command, phase: "sent", step: "", left: 0, steps: 1, text: "", at: performance.now(), final: false};
    if (!this.requests.send({...message, vehicle: vehicle.id}, (ack) => this.heard(vehicle, ack)))
      vehicle.running = {...vehicle.running, phase: "not sent", text: "there is no connection", final: true};
    this.draw();
  }

  private heard(vehicle: Vehicle, ack: Json) {
    vehicle.running = {command: ack.command, phase: ack.phase, step: ack.step ?? "", left: ack.left ?? 0, steps: ack.steps ?? 1,
      text: outcome(ack), at: performance.now(), final: ack.final};
    if (ack.final) this.ask();
    this.draw();
  }

  private scripts(): HTMLElement {
    const text = el("textarea", {rows: "5", spellcheck: "false", "aria-label": "Script",
      placeholder: "0s      valves 1,3  for 100ms\n500ms   valves 5,7  for 100ms\n2s      fans all    throttle 0.3"}) as HTMLTextAreaElement;
    const run = el("button", {type: "button"}, "run script") as HTMLButtonElement;
    run.onclick = () => {
      if (text.value.trim()) this.begin("script", {type: "script", text: text.value});
    };
    this.runs = run;
    return el("details", {class: "more"}, el("summary", {}, "script of timed actuations"), text, run,
      el("p", {class: "hint"}, "The first actuation comes 5 s after it was taken."));
  }

  draw() {
    const vehicle = this.shown, role = this.requests.welcome?.role;
    if (!vehicle) return;
    const holder = vehicle.status?.authority, mine = holder && holder === this.requests.welcome?.source;
    $("holder").textContent = role !== "command" && role ? "this key may only look" + (role === "stop" ? " and stop" : "")
      : mine ? "you command" : holder ? `${sourceName(holder)} commands` : "nobody commands";
    const open = this.requests.mayCommand && vehicle.living;
    if (this.runs) this.runs.disabled = !open;
    for (const row of this.rows) {
      const guard = vehicle.guards.get(row.command.name);
      const allowed = open && guard?.allowed === true;
      if (row.button.disabled === allowed) row.button.disabled = !allowed;
      const why = !this.requests.mayCommand || !guard ? "" :
        guard.allowed ? guard.first && guard.first !== row.command.name ? `begins with: ${guard.first}` : "" : [guard.why, guard.advice].filter(Boolean).join(" → ");
      if (row.why.textContent !== why) row.why.textContent = why;
      row.why.classList.toggle("no", !allowed);
    }
    const running = vehicle.running;
    show($("running"), [vehicle.id, running], () => {
      if (!running) return [];
      const tone = running.phase === "completed" ? "good" : ["rejected", "failed", "unanswered", "not sent"].includes(running.phase) ? "bad" : running.final ? "dim" : "busy";
      const done = running.steps - running.left;
      return [el("div", {class: `progress ${tone}`}, el("b", {}, running.command), ` ${running.phase}`,
        running.steps > 1 && ` · step ${done} of ${running.steps}: ${running.step}`, running.text && ` · ${running.text}`,
        !running.final && el("progress", running.steps > 1 ? {max: String(running.steps), value: String(done - 0.5)} : {}))];
    });
  }
}
