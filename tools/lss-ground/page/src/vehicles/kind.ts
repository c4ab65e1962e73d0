// How the page shows a vehicle: its picture, of those that the page can draw (one file for each beside this one, and a line
// in roster.ts), and all else as its daemon describes it (described.ts).

import type * as THREE from "three";
import type {Json} from "../link";

export interface Signal {
  name: string;
  unit: string;
  get: (telemetry: Json) => number | null | undefined;
  shown: boolean;  // at first
  rank: number;    // the least first
}

export interface Cell { text: string; tone?: "good" | "bad" | "dim"; }
export interface Table { heads: string[]; rows: (string | Cell)[][]; }

export interface Model {
  root: THREE.Object3D;             // moves over the ground
  world?: THREE.Object3D;           // stays where it is
  update(telemetry: Json, dt_s: number): void;  // called for each drawing, with the newest telemetry
}

export interface Picture {
  metres: number;                   // its size, for the camera
  model(): Model;
  // Bars over time: names of rows, and the rows filled now.
  bars?: {names: string[]; legend: string; get(telemetry: Json): number[]};  // 0 empty, 1 full, 2 alarm
}

export interface Kind extends Picture {
  signals: Signal[];
  order: string[];                  // of the commands shown first
  safe: string;                     // its reaction to a lost heartbeat
  overlay(telemetry: Json): string[];   // lines over the picture
  tables(telemetry: Json): Table[];
}
