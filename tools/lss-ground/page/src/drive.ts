// Hold to drive: the vehicle moves as long as a button, a key or a gamepad's stick is held, in the ways that its
// dictionary lists. Letting go is its command for standing still. Motions have a short lease of their own, so that the
// vehicle also stops when this page hangs or its network is gone. From the end of a hold until the vehicle confirms that
// it stands still, or the lease is over, the page sends no heartbeat.

import {$, el, show} from "./dom";
import type {Json} from "./link";
import type {Vehicle} from "./model";
import {outcome, type Requests} from "./requests";

const kLease_ms = 500;
const kPoll_ms = 50;
const kAlone = "no connection: it stops by itself";
const kStick = 0.4;            // of its way
const kShoulders = [4, 5];     // of the standard gamepad: one of them is held while the stick drives
const kKeys: Record<string, string> = {KeyW: "forward", ArrowUp: "forward", KeyS: "backward", ArrowDown: "backward",
  KeyA: "left", ArrowLeft: "left", KeyD: "right", ArrowRight: "right"};
const kPad = [["forward left", "↖"], ["forward", "↑"], ["forward right", "↗"], ["left", "←"], ["", ""], ["right", "→"],
  ["backward left", "↙"], ["backward", "↓"], ["backward right", "↘"]];

interface Way { way: string; command: number; parameters: (number | null)[]; }
interface Driven { id: string; rest: string; }  // name of its command for standing still

export class Drive {
  private shown: Vehicle | null = null;
  private way = "";                        // as sent; empty: the hold is over
  private turn = 0;                        // only the newest command's answers count
  private asked_ms: number | null = null;  // when the driven vehicle was sent its command for standing still, or a stop
  private held: string | null = null;      // button of the pad
  private readonly keys = new Set<string>();
  private stick: string[] = [];
  private blocked = false;                 // until everything is let go
  private text = "";
  private armed: HTMLInputElement | null = null;
  private pad = "";                        // name of the gamepad

  constructor(private readonly requests: Requests) {
    addEventListener("keydown", (e) => this.key(e));
    addEventListener("keyup", (e) => { if (this.keys.delete(kKeys[e.code])) this.update(); });
    for (const away of ["blur", "pagehide"]) addEventListener(away, () => this.release());
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.release(); });
    setInterval(() => this.poll(), kPoll_ms);
  }

  // While it drives the heartbeat is sent more often.
  get drives() { return this.way !== ""; }
  // No heartbeat now: it would keep a motion going whose hold is over.
  get ending() { return this.driven !== null && !this.way; }

  // The vehicle that may move by a hold. It is kept over a reload of the page: the new page has the same source name, so
  // that its heartbeat would keep the motion going.
  private get driven(): Driven | null { return JSON.parse(sessionStorage.getItem("driven") ?? "null"); }
  private set driven(driven: Driven | null) { sessionStorage.setItem("driven", JSON.stringify(driven)); }

  show(vehicle: Vehicle | null) {
    this.release();
    this.shown = vehicle;
    this.text = "";
    const where = $("drive"), ways = this.ways;
    where.hidden = !ways.length;
    if (!vehicle || !ways.length) return where.replaceChildren();
    this.armed = el("input", {type: "checkbox"}) as HTMLInputElement;
    this.armed.onchange = () => this.release();
    where.replaceChildren(el("div", {class: "pad", role: "group", "aria-label": "Hold to drive"}, ...kPad.map(([way, sign]) => this.button(way, sign))),
      el("div", {}, el("b", {}, "Hold to drive"), el("label", {}, this.armed, " keys W A S D, arrows"), el("span", {id: "gamepad"}), el("span", {id: "drives", role: "status"})));
    this.draw();
  }

  // A stop was pressed: nothing drives before all is let go. It was sent to this vehicle; empty: to every one; null: it
  // could not be sent.
  interrupt(stopped: string | null) {
    const driven = this.driven;
    this.blocked = true;
    this.end("", driven !== null && (stopped === "" || stopped === driven.id));
    this.draw();
  }

  private get ways(): Way[] { return this.shown?.presentation.hold ?? []; }
  private get ready() {
    return this.requests.mayCommand && Boolean(this.shown?.living) && this.shown!.status?.state === "Operational";
  }

  private button(way: string, sign: string): HTMLElement {
    if (!this.ways.some((w) => w.way === way)) return el("i");
    const button = el("button", {type: "button", "aria-label": way, title: `${way}, as long as it is held`, "data-way": way}, sign);
    const hold = (e: Event) => {
      e.preventDefault();
      this.held = way;
      this.update();
    };
    button.onpointerdown = (e) => {
      button.setPointerCapture(e.pointerId);
      hold(e);
    };
    button.onkeydown = (e) => { if (e.key === "Enter") e.repeat ? e.preventDefault() : hold(e); };
    const end = () => {
      if (this.held !== way) return;
      this.held = null;
      this.update();
    };
    for (const let_go of ["pointerup", "pointercancel", "lostpointercapture", "keyup", "blur"]) button.addEventListener(let_go, end);
    button.oncontextmenu = (e) => e.preventDefault();
    return button;
  }

  private key(e: KeyboardEvent) {
    const way = kKeys[e.code], target = e.target as HTMLElement;
    if (!way || !this.armed?.checked || e.ctrlKey || e.altKey || e.metaKey) return;
    if (target.matches("textarea, select, [role=tab]") || target instanceof HTMLInputElement && target.type !== "checkbox") return;
    e.preventDefault();
    if (e.repeat || this.keys.has(way)) return;
    this.keys.add(way);
    this.update();
  }

  private stickOfPad(): string[] {
    const pad = this.shown && navigator.getGamepads ? [...navigator.getGamepads()].find((g) => g?.connected && g.axes.length >= 2) ?? null : null;
    const [x, y] = pad?.axes ?? [0, 0], on = pad !== null && kShoulders.some((i) => pad.buttons[i]?.pressed);
    this.pad = pad?.id ?? "";
    return !on ? [] : [y < -kStick ? "forward" : y > kStick ? "backward" : "", x < -kStick ? "left" : x > kStick ? "right" : ""].filter(Boolean);
  }

  private poll() {
    this.stick = this.stickOfPad();
    if (this.way && (this.requests.lost || !this.shown?.living)) {
      this.blocked = true;
      this.end("no status from it: the order to stand still was sent");
    }
    this.settle();
    this.update();
  }

  // To drive on, all is let go and pressed again: a key that is still held only repeats, a stick is waited for.
  private release() {
    this.held = null;
    this.keys.clear();
    this.stick = [];
    this.update();
    this.stick = this.stickOfPad();
    this.blocked = this.stick.length > 0;
  }

  // The way that is held now, of those that the vehicle has.
  private wanted(): Way | null {
    const all = new Set([...(this.held ? this.held.split(" ") : []), ...this.keys, ...this.stick]);
    if (!all.size) this.blocked = false;
    const opposed = (a: string, b: string) => all.has(a) && all.has(b);
    if (this.blocked || !all.size || opposed("forward", "backward") || opposed("left", "right")) return null;
    const along = all.has("forward") ? "forward" : all.has("backward") ? "backward" : "", side = all.has("left") ? "left" : all.has("right") ? "right" : "";
    const find = (way: string) => this.ways.find((w) => w.way === way);
    return find([along, side].filter(Boolean).join(" ")) ?? find(along || side) ?? null;
  }

  private update() {
    const wanted = this.wanted();
    if (!wanted) {
      if (this.way) this.end("");
    } else if (!this.way && !this.ready) {
      this.text = !this.requests.mayCommand ? "this page may not command now" : "start it first";
      this.blocked = true;
    } else if (wanted.way !== this.way && (!this.driven || this.driven.id === this.shown!.id)) {
      this.send(wanted);
    }
    this.draw();
  }

  private send(wanted: Way) {
    const vehicle = this.shown!, command = vehicle.commands.find((c) => c.kind === wanted.command);
    if (!command) return this.way ? this.end("") : undefined;
    const parameters: Record<string, number> = {};
    command.parameters.forEach((p, i) => {
      const value = wanted.parameters[i] ?? p.default;
      if (value !== null) parameters[p.name] = value;
    });
    const turn = ++this.turn;
    if (this.requests.send({type: "command", vehicle: vehicle.id, command: command.name, parameters, lease_ms: kLease_ms}, (ack) => this.heard(turn, ack))) {
      this.driven = {id: vehicle.id, rest: vehicle.commands.find((c) => c.kind === vehicle.presentation.rest)?.name ?? "stop"};
      this.way = wanted.way;
      this.text = "";
    } else {
      this.blocked = true;
      this.end(kAlone);
    }
  }

  // The hold is over, for any reason. `stopped`: a stop was sent to the vehicle.
  private end(text: string, stopped = false) {
    this.way = "";
    this.text = text;
    this.turn++;
    this.asked_ms = stopped ? performance.now() : null;
    this.settle();
  }

  // The command for standing still leaves as soon as there is a connection.
  private settle() {
    const driven = this.driven;
    if (!driven || this.way) return;
    if (this.asked_ms !== null) {
      if (performance.now() - this.asked_ms > 2 * kLease_ms) this.driven = null;  // its lease is over
      return;
    }
    const turn = ++this.turn;
    if (this.requests.send({type: "command", vehicle: driven.id, command: driven.rest, parameters: {}, whole: false}, (ack) => this.heard(turn, ack)))
      this.asked_ms = performance.now();
    else this.text = kAlone;
  }

  private heard(turn: number, ack: Json) {
    if (turn !== this.turn) return;
    const no = ["rejected", "failed", "unanswered"].includes(ack.phase), why = `${ack.phase}: ${outcome(ack)}`;
    if (this.way) {
      if (!no) return;
      this.blocked = true;
      this.end(why);
    } else if (no) {
      this.text ||= why;
      if (ack.phase === "unanswered") this.asked_ms = null;  // the connection was lost
    } else {
      this.driven = null;
    }
  }

  private draw() {
    const where = $("drive");
    if (where.hidden) return;
    where.classList.toggle("off", !this.ready);
    for (const button of where.querySelectorAll<HTMLElement>("[data-way]")) button.classList.toggle("held", button.dataset.way === this.way);
    show($("gamepad"), this.pad, () => [this.pad ? `gamepad: hold a shoulder button and the left stick` : "no gamepad"]);
    show($("drives"), [this.way, this.text], () => [this.way ? el("b", {class: "good"}, `drives ${this.way}`) : this.text && el("b", {class: "bad"}, this.text)]);
  }
}
