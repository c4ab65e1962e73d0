// The vehicle's part of the page: one file for each vehicle beside this one, and a line in
// roster.ts.

import type * as THREE from "three";
import type {Json} from "../link";

export interface Signal {
  name: string;
  unit: string;
  get: (telemetry: Json) => number | null | undefined;
  shown?: boolean;  // at first
}

export interface Cell { text: string; tone?: "good" | "bad" | "dim"; }
export interface Table { heads: string[]; rows: (string | Cell)[][]; }

export interface Model {
  root: THREE.Object3D;             // moves over the ground
  update(telemetry: Json, dt_s: number): void;  // called for each drawing, with the newest telemetry
}

export interface Kind {
  name: string;
  metres: number;                   // its size, for the camera
  signals: Signal[];
  order: string[];                  // of the commands shown first
  hidden?: string[];                // commands that are useless alone on the page
  safe: string;                     // its reaction to a lost heartbeat
  model(): Model;
  overlay(telemetry: Json): string[];   // lines over the picture
  tables(telemetry: Json): Table[];
  // Bars over time: names of rows, and the rows filled now.
  bars?: {names: string[]; legend: string; get(telemetry: Json): number[]};  // 0 empty, 1 full, 2 alarm
}
