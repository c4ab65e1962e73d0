// What the gateway was asked and has not answered for good. Every answer goes to who asked.

import {advice} from "./dom";
import type {Json, Line} from "./link";

export class Requests {
  private numbers = 0;
  private waiting = new Map<number, {heard: (ack: Json) => void; last: Json}>();

  constructor(private readonly line: Line) {}

  get welcome() { return this.line.welcome; }
  get lost() { return this.line.lost; }
  get mayCommand() { return !this.line.lost && this.line.welcome?.role === "command"; }

  // Another connection: what was asked over the last one is not answered any more.
  begin() {
    const left = [...this.waiting.values()];
    this.waiting.clear();
    for (const {heard, last} of left)
      heard({...last, phase: "unanswered", reason: {text: "the connection was lost meanwhile; the state says what is"}, final: true});
  }

  // False: it did not leave. What would leave some time later, when the connection is back, does not leave at all.
  send(message: Json, heard: (ack: Json) => void): boolean {
    const id = ++this.numbers;
    if (this.line.lost || !this.line.send({...message, id})) return false;
    this.waiting.set(id, {heard, last: {command: message.command ?? message.type}});
    return true;
  }

  heard(ack: Json) {
    const asked = this.waiting.get(ack.request);
    if (!asked) return;
    if (ack.final) this.waiting.delete(ack.request);
    asked.last = ack;
    asked.heard(ack);
  }
}

// What stands on the page anyway: where the vehicle is, who commands, the range of a parameter. No advice then.
const kPlain = ["not_in_state", "not_in_mode", "not_authorised", "parameter_range", "parameter_whole"];

// Why not, and what to do.
export function reasons(ack: Json): {why: string; advice: string} {
  const reason = ack.reason;
  const plain = kPlain.includes(reason?.name);
  return {why: plain ? reason.text.replace(/ \(measured.*/, "") : reason?.text ?? "", advice: plain ? "" : advice(reason?.advice ?? "")};
}

// What became of a command, in a line.
export function outcome(ack: Json): string {
  return ack.reason ? [ack.reason.text, advice(ack.reason.advice ?? "")].filter(Boolean).join("; ") : "";
}
