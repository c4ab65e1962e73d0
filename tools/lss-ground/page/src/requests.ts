// Requests to the gateway without a final answer. Every answer goes to the sender of the request.

import {advice} from "./dom";
import type {Json, Line} from "./link";

export class Requests {
  private numbers = 0;
  private waiting = new Map<number, {heard: (ack: Json) => void; last: Json}>();

  constructor(private readonly line: Line) {}

  get welcome() { return this.line.welcome; }
  get lost() { return this.line.lost; }
  get mayCommand() { return !this.line.lost && this.line.welcome?.role === "command"; }

  // A new connection: requests of the last one get no more answers.
  begin() {
    const left = [...this.waiting.values()];
    this.waiting.clear();
    for (const {heard, last} of left)
      heard({...last, phase: "unanswered", reason: {text: "the connection was lost meanwhile; the state says what is"}, final: true});
  }

  // False: it was not sent. A request is never sent later, after a reconnection.
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

// Facts that the page already shows: state of the vehicle, holder of authority, range of a parameter. No advice for
// these.
const kPlain = ["not_in_state", "not_in_mode", "not_authorised", "parameter_range", "parameter_whole"];

// The reason and the advice.
export function reasons(ack: Json): {why: string; advice: string} {
  const reason = ack.reason;
  const plain = kPlain.includes(reason?.name);
  return {why: plain ? reason.text.replace(/ \(measured.*/, "") : reason?.text ?? "", advice: plain ? "" : advice(reason?.advice ?? "")};
}

// The result of a command, in a line.
export function outcome(ack: Json): string {
  return ack.reason ? [ack.reason.text, advice(ack.reason.advice ?? "")].filter(Boolean).join("; ") : "";
}
