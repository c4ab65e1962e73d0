// A vehicle that the page was built without: controls and values as its daemon describes them, and a
// box for its picture.

import * as THREE from "three";
import type {Json} from "../link";
import {fixed} from "../dom";
import type {Field, Vehicle} from "../model";
import type {Kind, Model, Signal, Table} from "./kind";
import {box, kColours, place} from "./shapes";

const kCounters = ["time_ns", "frame", "state", "mode"];
const kCommon = [3, 6, 7, 8, 9, 10];  // commands of every vehicle that a pilot rarely needs
const kLines = 6;

const isText = (f: Field) => f.type === "c1";
const isTable = (f: Field) => f.fields !== undefined && f.count !== undefined;

function number(value: unknown): number | null {
  return typeof value === "boolean" ? Number(value) : typeof value === "number" ? value : null;
}

// Every number of the fields, under its path.
function signals(fields: Field[], before: string, read: (t: Json) => Json | undefined, top = true): Signal[] {
  return fields.filter((f) => !isText(f) && !(top && kCounters.includes(f.name))).flatMap((f): Signal[] => {
    const elements = f.count === undefined ? [""] : Array.from({length: f.count}, (_, i) => ` ${i + 1}`);
    return elements.flatMap((element, i): Signal[] => {
      const own = (t: Json) => f.count === undefined ? read(t)?.[f.name] : read(t)?.[f.name]?.[i];
      if (f.fields) return signals(f.fields, `${before}${f.name}${element} `, own, false);
      return [{name: `${before}${f.name}${element}`, unit: f.unit ?? "", shown: top && f.unit === "m/s", get: (t) => number(own(t))}];
    });
  });
}

function model(): Model {
  const root = new THREE.Group();
  root.add(place(box(0.6, 0.25, 0.4, kColours.body), 0, 0.125, 0));
  return {root, update() { /* its shape and its place are not known */ }};
}

function shown(value: unknown): string {
  if (value === null || value === undefined) return "–";
  return typeof value === "number" && !Number.isInteger(value) ? fixed(value, 3) : String(value);
}

function table(f: Field, list: Json[]): Table {
  return {heads: [f.name, ...f.fields!.map((part) => part.unit ? `${part.name}, ${part.unit}` : part.name)],
    rows: list.map((element, i) => [element.name ?? String(i + 1), ...f.fields!.map((part) => shown(element[part.name]))])};
}

export function generic(vehicle: Vehicle): Kind {
  const {fields} = vehicle;
  return {
    name: vehicle.kind,
    metres: 1,
    order: vehicle.commands.filter((c) => !kCommon.includes(c.kind)).map((c) => c.name),
    safe: "comes to a safe stop",
    signals: signals(fields, "", (t) => t),
    model,
    overlay: (t) => fields.filter((f) => f.unit && f.type && f.count === undefined && !kCounters.includes(f.name)).slice(0, kLines)
      .map((f) => `${f.name} ${shown(t[f.name])} ${f.unit}`),
    tables: (t) => fields.filter(isTable).map((f) => table(f, t[f.name] ?? [])),
  };
}
