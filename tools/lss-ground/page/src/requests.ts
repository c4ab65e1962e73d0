// What the gateway was asked and has not answered for good. Every answer goes to who asked.

import {advice} from "./dom";
import type {Json, Line} from "./link";

export class Requests {
  private numbers = 0;
  private waiting = new Map<number, (ack: Json) => void>();

  constructor(private readonly line: Line) {}

  get welcome() { return this.line.welcome; }
  get open() { return this.line.open; }
  get mayCommand() { return this.line.open && this.line.welcome?.role === "command"; }

  // Another connection: what was asked over the last one is not answered any more.
  begin() { this.waiting.clear(); }

  // False: it did not leave.
  send(message: Json, heard: (ack: Json) => void): boolean {
    const id = ++this.numbers;
    if (!this.line.send({...message, id})) return false;
    this.waiting.set(id, heard);
    return true;
  }

  heard(ack: Json) {
    const heard = this.waiting.get(ack.request);
    if (ack.final) this.waiting.delete(ack.request);
    heard?.(ack);
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
