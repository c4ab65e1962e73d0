// Controls and values of a vehicle as its daemon describes them.

import type {Json} from "../link";
import {fixed} from "../dom";
import type {Field, Tunable, Vehicle} from "../model";
import type {Cell, Kind, Picture, Signal, Table} from "./kind";

const kMain = ["stop", "start", "solve", "reset"];  // of the commands of every vehicle
const kStatus = ["time_ns", "frame", "state", "mode"];  // said elsewhere
const kLines = 6;  // over the picture, of a vehicle without a headline

interface Headline { field: string; label: string; limit?: string; parts?: string; }  // as daemon/cycle/text.h

const unitOf = (f: Field) => f.shown?.unit ?? f.unit ?? "";
const labelOf = (f: Field) => f.label ?? f.name;

function decimals(value: number): number {
  const size = Math.abs(value);
  return size < 10 ? 3 : size < 100 ? 2 : 1;
}

function shown(value: unknown, f: Field): string {
  if (value === null || value === undefined) return "–";
  if (Array.isArray(value)) return value.map((part) => shown(part, f)).join("  ");
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value !== "number") return String(value);
  const size = value * (f.shown?.factor ?? 1);
  return f.type?.startsWith("f") || !Number.isInteger(size) ? fixed(size, decimals(size)) : String(size);
}

const with_unit = (text: string, f: Field) => unitOf(f) ? `${text} ${unitOf(f)}` : text;

export function described(vehicle: Vehicle): Omit<Kind, keyof Picture> {
  const {fields, presentation} = vehicle;
  const details = new Set<string>(presentation.details ?? []);
  const words = new Map<string, string[]>((presentation.words ?? []).map((w: Json) => [w.field, w.words]));
  const headline: Headline[] = presentation.headline ?? [];
  const label = new Map(headline.map((h) => [h.field, h.label]));
  const parts = new Map<string, number>((presentation.parts ?? []).map((p: Json) => [p.field, p.first]));
  const partName = (field: string, i: number) => parts.has(field) ? vehicle.subjects[parts.get(field)! + i] : undefined;
  const said = fields.filter((f) => !kStatus.includes(f.name));

  // Every number, under its name.
  function signals(list: Field[], path: string, name: string, read: (t: Json) => Json | undefined): Signal[] {
    return list.filter((f) => f.type !== "c1" && !(path && f.name === "id") && !details.has(path + f.name) && !words.has(path + f.name)).flatMap((f) => {
      const elements = f.count === undefined ? [null] : Array.from({length: f.count}, (_, i) => i);
      return elements.flatMap((i): Signal[] => {
        const own = (t: Json) => i === null ? read(t)?.[f.name] : read(t)?.[f.name]?.[i];
        const member = path + f.name, at = i === null || path ? member : `${member}[${i}]`;
        if (f.fields) return signals(f.fields, `${member}.`, `${i === null ? f.name : partName(f.name, i) ?? `${f.name} ${i + 1}`} `, own);
        const title = label.get(at) ?? label.get(member) ?? labelOf(f);
        const rank = headline.findIndex((h) => h.field === at);
        return [{rank: rank < 0 ? headline.length : rank, name: name + title + (i === null || label.has(at) ? "" : ` ${i + 1}`), unit: unitOf(f),
          shown: f.type !== undefined && f.type.startsWith("f") && (headline.length ? label.has(at) : !path && f.unit === "m/s"),
          get: (t) => { const x = own(t); return typeof x === "boolean" ? Number(x) : typeof x === "number" ? x * (f.shown?.factor ?? 1) : null; }}];
      });
    });
  }

  function line({field, label, limit, parts}: Headline, t: Json): string[] {
    const [, name, index] = /^(\w+)(?:\[(\d+)\])?$/.exec(field) ?? [];
    const f = fields.find((one) => one.name === name);
    if (!f || f.fields) return [];
    const value = index === undefined ? t[name] : t[name]?.[Number(index)];
    const text = parts && Array.isArray(value) ? value.map((part, i) => `${partName(parts, i) ?? i + 1} ${shown(part, f)}`).join("  ") : shown(value, f);
    const tunables: Tunable[] = vehicle.parameters?.parameters ?? [], allowed = tunables.find((one) => one.name === limit)?.value;
    return [`${label} ${with_unit(text, f)}${allowed === undefined ? "" : ` (limit ${shown(allowed, f)})`}`];
  }

  function cell(member: Field, path: string, element: Json): string | Cell {
    const value = element[member.name], text = words.get(path)?.[value as unknown as number] ?? shown(value, member);
    if (member.name === "online") return value === null ? {text: "not there", tone: "dim"} : {text: value ? "online" : "silent", tone: value ? "good" : "bad"};
    return member.name === "isolated" && value ? {text, tone: "bad"} : text;
  }

  // Of a part; with what an array beside it has for its elements.
  function table(f: Field, t: Json): Table {
    const members = f.fields!.filter((m) => m.name !== "id" && !details.has(`${f.name}.${m.name}`));
    const beside = headline.filter((h) => h.parts === f.name).flatMap((h) => fields.filter((one) => one.name === h.field).map((one) => ({...one, label: h.label})));
    const list: Json[] = t[f.name] ?? [];
    return {heads: [f.name, ...[...members, ...beside].map((m) => unitOf(m) ? `${labelOf(m)}, ${unitOf(m)}` : labelOf(m))],
      rows: list.map((element, i) => [element.name ?? partName(f.name, i) ?? String(i + 1), ...members.map((m) => cell(m, `${f.name}.${m.name}`, element)),
        ...beside.map((m) => shown(t[m.name]?.[i], m))])};
  }

  const first = (presentation.first ?? []) as number[], byKind = new Map(vehicle.commands.map((c) => [c.kind, c.name]));
  return {
    order: [...(first.length ? first.map((kind) => byKind.get(kind) ?? "") : vehicle.commands.filter((c) => c.kind >= 100).map((c) => c.name)), ...kMain],
    safe: presentation.without_client ?? "comes to a safe stop",
    signals: signals(said, "", "", (t) => t).sort((a, b) => a.rank - b.rank),
    overlay: (t) => headline.length ? headline.flatMap((h) => line(h, t))
      : said.filter((f) => f.unit && f.type && f.count === undefined).slice(0, kLines).map((f) => `${labelOf(f)} ${with_unit(shown(t[f.name], f), f)}`),
    tables: (t) => said.filter((f) => f.fields && f.count !== undefined).map((f) => table(f, t)),
  };
}
