// What a vehicle brings to the page: one file each beside this one, and a line in roster.ts.

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
  update(telemetry: Json, dt_s: number): void;  // called when drawn, with the newest
}

export interface Kind {
  name: string;
  metres: number;                   // how large it is, for the camera
  signals: Signal[];
  order: string[];                  // of the commands that come first
  hidden?: string[];                // commands that make no sense by themselves here
  safe: string;                     // what it does when its heartbeat is lost
  model(): Model;
  overlay(telemetry: Json): string[];   // lines over the picture
  tables(telemetry: Json): Table[];
  // Bars over time: rows of names, and which are filled now.
  bars?: {names: string[]; legend: string; get(telemetry: Json): number[]};  // 0 empty, 1 full, 2 alarm
}
