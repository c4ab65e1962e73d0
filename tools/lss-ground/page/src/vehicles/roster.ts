// The vehicles that the page can draw. Any other is shown as its daemon describes it.

import {ardito} from "./ardito";
import type {Vehicle} from "../model";
import {generic} from "./generic";
import type {Kind} from "./kind";
import {talaris} from "./talaris";
import {zebro} from "./zebro";

const roster = new Map<string, Kind>([zebro, ardito, talaris].map((kind) => [kind.name, kind]));
const others = new WeakMap<Vehicle, Kind>();

export function kindOf(vehicle: Vehicle): Kind {
  const known = roster.get(vehicle.kind) ?? others.get(vehicle);
  if (known) return known;
  const made = generic(vehicle);
  others.set(vehicle, made);
  return made;
}
