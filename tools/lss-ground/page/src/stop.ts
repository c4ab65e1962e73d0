// Stops: the button that stops the shown vehicle, or lands it in flight; the all-stop beside it, with which it falls;
// and the stop of every vehicle. The gateway repeats each until it is completed; the answers of the vehicles are below
// the buttons.

import {$, el, show} from "./dom";
import {type Fleet, silence} from "./fleet";
import {type Json, Line} from "./link";

const kLate_ms = 3200;   // the gateway reports this after 3 s, if connected
const kOver_ms = 11_000;  // it gives up after 10 s
const kHold_ms = 500;
const kHint_ms = 4000;
const kShown_ms = 8000;  // good answers; others stay until the next press

type Tone = "busy" | "good" | "bad";
interface Press {
  id: number;
  vehicle: string;  // empty: all vehicles
  land: boolean;
  at: number;
  sent: boolean;
  acknowledged: boolean;
  over: boolean;
  over_ms: number;
  text: string;   // after the name
  brief: string;  // in the button
  tone: Tone;
  each: Map<string, {text: string; tone: Tone}>;  // the answer of each vehicle
}

export class Stops {
  private numbers = 0;
  private presses: Press[] = [];  // the newest last
  private hint = {text: "", at: -Infinity};  // the hint after a press that was too short
  readonly line = new Line("lss-stop", (m) => this.hear(m));

  constructor(private readonly fleet: Fleet, private readonly pressed: (stopped: string | null) => void) {
    const big = $("estop"), fall = $("fall"), all = $("stop-all");
    this.button(big, () => [], () => this.pilot());
    this.button(fall, () => this.fleet.meant ? [this.fleet.meant.id] : [], () => this.press(this.fleet.meant?.id ?? "", false));
    this.button(all, () => this.flying, () => this.press("", false));
    addEventListener("keydown", (e) => {
      const writes = e.target instanceof HTMLTextAreaElement || e.target instanceof HTMLInputElement && ["search", "password"].includes(e.target.type);
      if (e.key === "Enter" && e.target instanceof HTMLInputElement && e.target.type === "checkbox") e.target.click();
      if (e.code !== "Space" || writes) return;
      e.preventDefault();  // also where the space bar would press another button
      if (!e.repeat) this.pilot();
    }, true);
    addEventListener("keyup", (e) => { if (e.code === "Space" && e.target instanceof HTMLButtonElement) e.preventDefault(); }, true);
  }

  get waiting() { return this.presses.some((p) => !p.over); }
  private get flying() { return this.fleet.sorted.filter((v) => v.living && v.status?.airborne).map((v) => v.id); }

  // At once; when a vehicle would fall, only after a press of half a second.
  private button(button: HTMLElement, falls: () => string[], act: () => void) {
    let timer = 0;
    const begin = (e: Event) => {
      e.preventDefault();
      if (!falls().length) return act();
      button.dataset.held = "";
      clearTimeout(timer);
      timer = window.setTimeout(() => {
        delete button.dataset.held;
        act();
      }, kHold_ms);
    };
    const end = () => {
      clearTimeout(timer);
      if (!("held" in button.dataset)) return;
      delete button.dataset.held;
      this.hint = {text: `Hold ${button.querySelector("b")!.textContent} for half a second: ${falls().join(", ")} FALLS.`, at: performance.now()};
      this.draw();
    };
    button.addEventListener("pointerdown", begin);
    button.addEventListener("keydown", (e) => { if (e.key === "Enter") e.repeat ? e.preventDefault() : begin(e); });
    for (const let_go of ["pointerup", "pointerleave", "pointercancel", "keyup", "blur"]) button.addEventListener(let_go, end);
    button.addEventListener("contextmenu", (e) => e.preventDefault());  // of a long touch
  }

  private pilot() {
    const vehicle = this.fleet.meant;
    this.press(vehicle?.id ?? "", vehicle?.lands ?? false);
  }

  private press(vehicle: string, land: boolean) {
    this.presses = this.presses.filter((p) => !p.over && (p.vehicle !== vehicle || p.land !== land));
    const press: Press = {id: ++this.numbers, vehicle, land, at: performance.now(), sent: false, acknowledged: false, over: false, over_ms: 0,
      text: "sent …", brief: "sent …", tone: "busy", each: new Map()};
    this.presses.push(press);
    this.send(press);
    this.draw();
  }

  private send(press: Press) {
    const {id, vehicle, land} = press;
    const sent = this.line.send(land ? {type: "stop", id, vehicle, land} : {type: "stop", id, vehicle});
    if (sent) {
      if (!press.sent && press.tone === "bad") this.say(press, "sent …", "busy");
      press.sent = true;
    } else if (!press.sent) {
      this.say(press, press.land ? "NOT SENT: no connection. It goes when the connection is back." : "NOT SENT: no connection. Cut the power.", "bad", "NOT SENT");
    }
    this.pressed(sent && !this.line.lost ? vehicle : null);
  }

  private say(press: Press, text: string, tone: Tone, brief = text) {
    Object.assign(press, {text, tone, brief});
  }

  private end(press: Press) {
    press.over = true;
    press.over_ms = performance.now();
  }

  // It should have been completed by now.
  private late(press: Press, over: boolean) {
    if (!press.sent || press.vehicle === "" && press.each.size) return;
    const vehicle = this.fleet.vehicles.get(press.vehicle), on = over ? "" : " It is sent on.";
    if (press.land) {
      this.say(press, press.acknowledged ? "acknowledged, but nobody says that it landed" : `NOT ACKNOWLEDGED.${on} ALL-STOP makes it fall.`, "bad",
        press.acknowledged ? "not confirmed" : "NOT ACKNOWLEDGED");
    } else if (vehicle?.status?.state === "FatalError" && (vehicle.status_age_ms ?? Infinity) < performance.now() - press.at) {
      this.say(press, "not acknowledged, but it says that it is stopped (FatalError)", "good", "it says: stopped");
    } else if (press.acknowledged) {
      this.say(press, `acknowledged, but NOT CONFIRMED.${on} Cut the power.`, "bad", "NOT CONFIRMED");
    } else {
      this.say(press, `NOT ACKNOWLEDGED. Cut the power.${on}`, "bad", "NOT ACKNOWLEDGED");
    }
  }

  private hear(m: Json) {
    // Stops that the old connection may not have delivered.
    if (m.type === "welcome") this.presses.filter((p) => !p.over).forEach((p) => this.send(p));
    const press = m.type === "ack" ? this.presses.find((p) => p.id === m.request) : undefined;
    if (!press || press.over) return;
    const after_ms = performance.now() - press.at;
    const reason = m.reason?.text ?? m.text ?? "";
    const yes = ["accepted", "executing", "completed"].includes(m.phase);
    if (yes && !press.acknowledged) {
      press.acknowledged = true;
      if (press.vehicle) $("estop").dataset.ms = after_ms.toFixed(1);  // for measurements
    }
    if (!press.vehicle) {
      this.hearAll(press, m, Math.round(after_ms), reason);
    } else if (m.phase === "unanswered") {
      this.late(press, m.final);
    } else if (m.phase === "completed") {
      this.say(press, press.land ? "landing completed" : `stopped after ${Math.round(after_ms)} ms`, "good");
    } else if (yes) {
      if (m.phase === "accepted") this.say(press, `${press.land ? "landing: " : ""}acknowledged after ${Math.round(after_ms)} ms`, press.land ? "good" : "busy", `${press.land ? "landing" : "acknowledged"}, ${Math.round(after_ms)} ms`);
    } else if (m.final) {
      this.say(press, `${press.land && m.phase === "failed" ? "LANDING FAILED" : "REFUSED"}: ${reason}`, "bad", "REFUSED");
    } else if (!press.acknowledged) {
      this.say(press, `not obeyed yet: ${reason}. It is sent on.`, "busy", "sent again …");
    }
    if (m.final) this.end(press);
    this.draw();
  }

  private hearAll(press: Press, m: Json, after_ms: number, reason: string) {
    const before = press.each.get(m.vehicle);
    if (Array.isArray(m.silent)) {
      for (const id of m.silent) press.each.set(id, {text: "NO ANSWER", tone: "bad"});
      this.late(press, m.final);
    } else if (m.final) {
      return this.say(press, `REFUSED: ${reason}`, "bad", "REFUSED");
    } else if (m.phase === "completed") {
      if (before?.tone !== "good") press.each.set(m.vehicle, {text: `stopped after ${after_ms} ms`, tone: "good"});
    } else if (before?.tone !== "good") {
      press.each.set(m.vehicle, {text: m.phase === "accepted" || m.phase === "executing" ? "acknowledged" : `not yet: ${reason}`, tone: "busy"});
    }
    if (!press.each.size) return;
    const count = [...press.each.values()].filter((e) => e.tone === "good").length, bad = [...press.each.values()].some((e) => e.tone === "bad");
    this.say(press, `${count} of ${press.each.size} stopped`, bad ? "bad" : count === press.each.size ? "good" : "busy");
  }

  // No answer at all is also shown.
  private watch() {
    const now = performance.now();
    for (const press of this.presses) {
      if (press.over) continue;
      if (now - press.at > kLate_ms && !press.acknowledged && press.tone === "busy") this.late(press, false);
      if (now - press.at > kOver_ms && !(press.land && press.acknowledged)) {
        this.late(press, true);
        this.end(press);
      }
    }
    this.presses = this.presses.filter((p) => !p.over || p.tone === "bad" || now - p.over_ms < kShown_ms);
  }

  draw() {
    this.watch();
    const vehicle = this.fleet.meant, lands = vehicle?.lands ?? false, airborne = Boolean(vehicle?.status?.airborne);
    const big = $("estop"), fall = $("fall"), all = $("stop-all"), flying = this.flying;
    const why = this.line.lost ? "no connection" : this.line.welcome?.role === "look" ? "this key may not stop" : "";
    const newest = [...this.presses].reverse().find((p) => p.vehicle === (vehicle?.id ?? "") && p.land === lands);
    show(big, [lands, airborne, vehicle?.id, newest?.brief, newest?.over, why], () => [el("b", {}, lands ? "LAND" : "STOP"),
      el("span", {id: "estop-text"}, newest ? newest.brief : why || `${vehicle?.id ?? "every vehicle"} · space bar${airborne && !lands ? " · FALLS" : ""}`)]);
    big.dataset.tone = newest?.tone ?? (why ? "bad" : "");
    big.classList.toggle("lands", lands);
    if (fall.hidden === lands) fall.hidden = !lands;
    show(all, [flying], () => [el("b", {}, "STOP ALL"), el("span", {}, flying.length ? `every · ${flying.length} FALL${flying.length > 1 ? "" : "S"}` : "every vehicle")]);
    all.title = flying.length ? `Everything off, on every vehicle: ${flying.join(", ")} FALLS. Hold it for half a second.` : "Emergency stop of every vehicle on the domain";
    fall.title = `Everything off at once: ${vehicle?.id ?? "it"} FALLS. Hold it for half a second.`;

    const lines = this.presses.map((p) => ({tone: p.tone, name: p.vehicle ? `${p.land ? "LAND" : "STOP"} ${p.vehicle}` : "STOP ALL", text: p.text,
      each: [...p.each].sort(([a], [b]) => a.localeCompare(b)).map(([id, said]) => ({id, ...said, text: said.text === "NO ANSWER" ? this.noAnswer(id) : said.text}))}));
    const hint = performance.now() - this.hint.at < kHint_ms ? this.hint.text : "";
    show($("answers"), [lines, hint], () => [hint && el("div", {}, el("span", {}, hint)), ...lines.map((line) => el("div", {class: line.tone}, el("b", {}, line.name), el("span", {}, line.text),
      ...line.each.map((e) => el("span", {class: `one ${e.tone}`}, el("b", {}, e.id), ` ${e.text}`))))]);
  }

  private noAnswer(id: string) {
    const vehicle = this.fleet.vehicles.get(id);
    return !vehicle || vehicle.living ? "NO ANSWER" : `NO ANSWER (${silence(vehicle)})`;
  }
}
