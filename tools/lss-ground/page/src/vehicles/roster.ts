// The vehicles that the page can draw. Any other is a box.

import type {Vehicle} from "../model";
import {ardito} from "./ardito";
import {described} from "./described";
import type {Kind, Picture} from "./kind";
import {unknown} from "./shapes";
import {talaris} from "./talaris";
import {zebro} from "./zebro";

const pictures = new Map<string, Picture>(Object.entries({zebro, ardito, talaris}));
const kinds = new WeakMap<Vehicle, Kind>();

export function kindOf(vehicle: Vehicle): Kind {
  let kind = kinds.get(vehicle);
  if (!kind) kinds.set(vehicle, kind = {...pictures.get(vehicle.kind) ?? unknown, ...described(vehicle)});
  return kind;
}
