// Parameters that change while the daemon runs. The daemon decides whether a change is allowed, by dry runs: of the
// typed value, and of one unchanged parameter for each value of `when`. Nothing is decided here.

import {el, show} from "./dom";
import type {Json} from "./link";
import type {Tunable, Vehicle} from "./model";
import {reasons, type Requests} from "./requests";

const kAgain_ms = 1000;
const kWhen = {always: "at any time", at_rest: "at rest"};

interface Row {
  item: Tunable; element: HTMLElement; input: HTMLInputElement; set: HTMLButtonElement; reset: HTMLButtonElement;
  about: HTMLElement; why: HTMLElement;
  written: string;                               // written into the input by this code; anything else was typed
  judged: {value: number; why: string} | null;   // by the daemon; no reason: it would be accepted
}

const text = (value: number) => String(Number(value.toPrecision(10)));
const whyNot = (ack: Json) => { const {why, advice} = reasons(ack); return [why, advice].filter(Boolean).join(" → "); };
const said = (ack: Json) => [ack.phase, whyNot(ack)].filter(Boolean).join(": ");

function button(title: string, help: string, press: () => void): HTMLButtonElement {
  const made = el("button", {type: "button", title: help, disabled: true}, title) as HTMLButtonElement;
  made.onclick = press;
  return made;
}

export class Parameters {
  private vehicle: Vehicle | null = null;
  private rows: Row[] = [];
  private made = "";                        // the data of the rows
  private not = new Map<string, string>();  // the reason against it, by `when`, and of "save"; empty: allowed
  private readonly words = el("input", {type: "search", placeholder: "words", "aria-label": "Words to find parameters by"}) as HTMLInputElement;
  private readonly differs = el("input", {type: "checkbox"}) as HTMLInputElement;
  private readonly save = button("save", "keep all values for the next start", () => this.keep());
  private readonly resetAll = button("reset all", "all as the configuration says", () => this.asConfigured(this.rows));
  private readonly state = el("p", {class: "hint"});
  private readonly answer = el("p", {class: "answer", role: "status"});
  private readonly head = el("div", {class: "head"});
  private readonly list = el("div", {});

  constructor(private readonly where: HTMLElement, private readonly requests: Requests) {
    this.head.append(el("div", {class: "filter"}, this.words, el("label", {}, this.differs, " what differs"), this.save, this.resetAll), this.state);
    where.append(this.head, this.list);
    this.words.oninput = this.differs.onchange = () => this.redraw();
    setInterval(() => this.ask(), kAgain_ms);
  }

  draw(vehicle: Vehicle) {
    if (this.where.hidden) return;
    if (vehicle !== this.vehicle) this.answer.textContent = "";
    this.vehicle = vehicle;
    const items: Tunable[] = vehicle.parameters?.parameters ?? [];
    const made = JSON.stringify([vehicle.id, items.map((i) => [i.name, i.unit, i.min, i.max, i.whole, i.change])]);
    if (made !== this.made) {
      this.made = made;
      this.not.clear();
      this.rows = items.map((item) => this.row(item));
      this.list.replaceChildren(...this.rows.map((row) => row.element));
      this.ask();
    }
    this.rows.forEach((row, i) => this.update(row, items[i]));
    this.heading(items);
  }

  private redraw() { if (this.vehicle) this.draw(this.vehicle); }

  private row(item: Tunable): Row {
    const input = el("input", {type: "number", step: item.whole ? "1" : "any", "aria-label": item.name, title: item.help}) as HTMLInputElement;
    const set = button("set", `set ${item.name}`, () => this.typed(row));
    const reset = button("reset", "", () => this.asConfigured([row]));
    const about = el("small", {}), why = el("div", {class: "why"});
    const name = item.name.split(/(?<=[._])/).flatMap((part) => [part, el("wbr")]);  // possible line breaks
    const element = el("div", {class: "parameter"}, el("div", {class: "name"}, el("b", {title: item.help}, ...name), about),
      el("span", {class: "fields"}, input, el("i", {}, item.unit), set, reset), why);
    const row: Row = {item, element, input, set, reset, about, why, written: "", judged: null};
    input.oninput = () => {
      if (this.answer.parentElement === element) this.answer.remove();
      this.askTyped(row);
      this.redraw();
    };
    input.onkeydown = (e) => {
      if (e.key === "Enter") this.typed(row);  // the daemon judges
      if (e.key === "Escape") input.value = row.written;
      if (e.key === "Enter" || e.key === "Escape") this.redraw();
    };
    return row;
  }

  // The typed value that is not yet active; null: none, or not a number.
  private wanted(row: Row): number | null {
    const value = row.input.valueAsNumber;
    return Number.isFinite(value) && row.input.value !== row.written && value !== row.item.value ? value : null;
  }

  private update(row: Row, item: Tunable) {
    const {input} = row, untouched = input.value === row.written;
    row.item = item;
    row.written = text(item.value);
    const stale = untouched || (this.wanted(row) === null && document.activeElement !== input);
    if (stale && input.value !== row.written) input.value = row.written;
    const wanted = this.wanted(row), not = this.why(item.change), judged = row.judged?.value === wanted ? row.judged : null;
    input.disabled = not !== "";
    row.set.disabled = not !== "" || judged?.why !== "";
    row.reset.disabled = not !== "" || item.as_configured;
    row.reset.title = `to ${text(item.configured)} ${item.unit}, as configured`;
    const about = `${wanted !== null ? `is ${row.written} · ` : ""}${text(item.min)} to ${text(item.max)}${item.whole ? ", whole" : ""} · ${kWhen[item.change]}`;
    show(row.about, [about, item], () => [about,
      !item.as_configured && el("em", {}, `configured ${text(item.configured)}`),
      !item.as_saved && el("em", {class: "warn"}, item.saved === null ? "not saved" : `saved ${text(item.saved)}`)]);
    const answered = this.answer.parentElement === row.element;
    const why = wanted === null || not || answered ? "" : judged?.why ?? "";
    if (row.why.textContent !== why) row.why.textContent = why;
    const found = !this.words.value || `${item.name} ${item.help}`.toLowerCase().includes(this.words.value.toLowerCase());
    row.element.hidden = !found || (this.differs.checked && item.as_configured && item.as_saved && wanted === null);
  }

  // Empty: allowed now.
  private why(of: string): string {
    const {welcome} = this.requests;
    if (this.requests.lost || !this.vehicle?.links.alive) return "no connection";
    if (welcome?.role !== "command") return "this key may not command";
    return this.not.get(of) ?? "…";
  }

  private heading(items: Tunable[]) {
    const configured = items.filter((i) => !i.as_configured).length, unsaved = items.filter((i) => !i.as_saved).length;
    const why = items.length ? [...new Set(items.map((i) => i.change))].map((c) => [kWhen[c], this.why(c)]).filter(([, w]) => w && w !== "…") : [];
    const reason = why.length > 1 && why.every(([, w]) => w === why[0][1]) ? why[0][1] : why.map(([c, w]) => `what changes ${c}: ${w}`).join("; ");
    const differs = [configured && `${configured} not as configured`, unsaved && `${unsaved} not saved`].filter(Boolean).join(", ");
    const line = items.length ? [differs || "all as configured and saved", reason].filter(Boolean).join(" · ") : "No parameters were received yet.";
    if (this.state.textContent !== line) this.state.textContent = line;
    this.save.disabled = !items.length || this.why("save") !== "";
    this.resetAll.disabled = !this.rows.some((row) => !row.reset.disabled);
  }

  // Would it be accepted?
  ask() {
    if (!this.vehicle || this.where.hidden || document.hidden || !this.requests.mayCommand) return;
    for (const when of Object.keys(kWhen)) {
      const one = this.rows.find((row) => row.item.change === when)?.item;
      if (one) this.dry("set-parameter", {value: one.value}, (why) => this.not.set(when, why), one.name);
    }
    this.dry("save-parameters", {}, (why) => this.not.set("save", why));
    for (const row of this.rows) this.askTyped(row);
  }

  private askTyped(row: Row) {
    const value = this.wanted(row);
    if (value !== null) this.dry("set-parameter", {value}, (why) => { row.judged = {value, why}; }, row.item.name);
  }

  private dry(command: string, parameters: Json, judge: (why: string) => void, name?: string) {
    const vehicle = this.vehicle!;
    this.requests.send({type: "command", vehicle: vehicle.id, command, parameters, name, dry_run: true}, (ack) => {
      if (vehicle !== this.vehicle || !["accepted", "rejected", "failed"].includes(ack.phase)) return;
      judge(ack.phase === "accepted" ? "" : whyNot(ack) || ack.phase);
      this.redraw();
    });
  }

  // True: done. A line shows the result.
  private command(vehicle: Vehicle, words: string, command: string, parameters: Json, where: Element, name?: string): Promise<boolean> {
    const tell = (what: string, tone: string) => {
      if (vehicle !== this.vehicle) return;
      if (this.answer.parentElement !== where) where.append(this.answer);
      this.answer.textContent = `${words}: ${what}`;
      this.answer.className = `answer ${tone}`;
    };
    tell("sent …", "");
    return new Promise((resolve) => {
      const heard = (ack: Json) => {
        tell(said(ack), ack.phase === "completed" ? "good" : ack.final ? "bad" : "");
        if (!ack.final) return;
        this.ask();
        resolve(ack.phase === "completed");
      };
      if (this.requests.send({type: "command", vehicle: vehicle.id, command, parameters, name}, heard)) return;
      tell("not sent: there is no connection", "bad");
      resolve(false);
    });
  }

  private change(vehicle: Vehicle, {item, element}: Row, value: number): Promise<boolean> {
    return this.command(vehicle, `${text(value)} ${item.unit}`.trim(), "set-parameter", {value}, element, item.name);
  }

  private typed(row: Row) {
    const value = this.wanted(row);
    if (value !== null) void this.change(this.vehicle!, row, value);
  }

  // One after the other, as long as each is accepted.
  private async asConfigured(rows: Row[]) {
    const vehicle = this.vehicle!;
    for (const row of rows.filter((r) => !r.item.as_configured)) {
      if (!await this.change(vehicle, row, row.item.configured)) return;
    }
  }

  private keep() { void this.command(this.vehicle!, "save", "save-parameters", {}, this.head); }
}
