// Lunar Zebro: six C-shaped legs, each turning about its hip; a solar panel on top.

import * as THREE from "three";
import type {Json} from "../link";
import {fixed, kDegree} from "../dom";
import type {Kind, Model} from "./kind";
import {box, cylinder, kColours, material, paint, place} from "./shapes";

const kLength_m = 0.2, kWidth_m = 0.14, kHeight_m = 0.035, kLeg_m = 0.06;
const kLegs = ["LF", "RF", "LM", "RM", "LH", "RH"];

// Half a circle that hangs from the hip: straight down at angle 0.
function leg(): THREE.Group {
  const turning = new THREE.Group();
  const arc = new THREE.Mesh(new THREE.TorusGeometry(kLeg_m / 2, 0.004, 8, 24, Math.PI), material(kColours.leg));
  arc.rotation.z = -Math.PI / 2;
  arc.position.y = -kLeg_m / 2;
  turning.add(arc, cylinder(0.007, 0.012, kColours.metal, "z"));
  return turning;
}

function model(): Model {
  const root = new THREE.Group(), body = new THREE.Group();
  root.add(body);
  body.add(box(kLength_m, kHeight_m, kWidth_m, kColours.body));
  body.add(place(box(kLength_m * 0.9, 0.004, kWidth_m * 0.95, kColours.panel), 0, kHeight_m / 2 + 0.008, 0));
  body.add(place(box(0.012, 0.016, 0.05, kColours.metal), kLength_m / 2 + 0.006, 0.004, 0));
  const legs = kLegs.map((_, i) => {
    const turning = leg();
    const side = i % 2 === 0 ? -1 : 1, row = Math.floor(i / 2);
    body.add(place(turning, (1 - row) * kLength_m * 0.4, 0, side * (kWidth_m / 2 + 0.012)));
    return turning;
  });
  let before_m: number | null = null;
  const shown: number[] = kLegs.map(() => 0);
  return {
    root,
    update(t: Json, dt_s: number) {
      const modules = t.modules;
      const yaw = -t.yaw_rad;
      const moved_m = before_m === null ? 0 : t.distance_m - before_m;
      before_m = t.distance_m;
      root.rotation.y = yaw;
      if (Math.abs(moved_m) < 1) {
        root.position.x += moved_m * Math.cos(yaw);
        root.position.z -= moved_m * Math.sin(yaw);
      }
      let lowest_m = kHeight_m / 2;
      legs.forEach((turning, i) => {
        const m = modules[i];
        if (!m) return;
        // Between two samples it turns the shorter way.
        const gap = Math.atan2(Math.sin(m.position_rad - shown[i]), Math.cos(m.position_rad - shown[i]));
        shown[i] += gap * Math.min(1, dt_s * 25);
        turning.rotation.z = -shown[i];
        lowest_m = Math.max(lowest_m, kLeg_m / 2 * (1 + Math.cos(shown[i])));
        paint(turning, !m.online ? kColours.bad : m.isolated ? kColours.off : m.swing ? kColours.swing : kColours.leg);
      });
      body.position.y += (lowest_m + 0.002 - body.position.y) * Math.min(1, dt_s * 12);
    },
  };
}

const perLeg = (name: string, unit: string, get: (m: Json) => number) =>
  kLegs.map((leg, i) => ({name: `${leg} ${name}`, unit, get: (t: Json) => t.modules[i] && get(t.modules[i])}));

export const zebro: Kind = {
  name: "zebro",
  metres: 0.3,
  order: ["walk", "stand", "lay-down", "stop", "start", "solve", "reset"],
  safe: "finishes its step, lies down and switches its motors off",
  signals: [
    {name: "speed", unit: "mm/s", shown: true, get: (t) => t.speed_m_s * 1000},
    {name: "distance", unit: "m", shown: true, get: (t) => t.distance_m},
    {name: "yaw", unit: "deg", get: (t) => t.yaw_rad / kDegree},
    {name: "bus cycle", unit: "ms", get: (t) => t.bus_cycle_ns * 1e-6},
    ...perLeg("current", "A", (m) => m.current_A).map((s) => ({...s, shown: true})),
    ...perLeg("position", "deg", (m) => m.position_rad / kDegree),
    ...perLeg("temperature", "degC", (m) => m.temperature_degC),
  ],
  model,
  overlay(t) {
    return [`${fixed(t.distance_m, 3)} m walked`, `${fixed(t.speed_m_s * 1000, 1)} mm/s ${t.direction < 0 ? "backward" : "forward"}`,
      `turned ${fixed(t.yaw_rad / kDegree, 1)}°`, `${t.steps} gait cycles`];
  },
  bars: {
    names: kLegs,
    legend: "filled: on the ground · empty: in the air",
    get: (t) => t.modules.slice(0, 6).map((m: Json) => !m.online ? 2 : m.swing ? 0 : 1),
  },
  tables(t) {
    return [{
      heads: ["module", "link", "does", "angle °", "target °", "°/s", "A", "°C", "V", "age"],
      rows: t.modules.map((m: Json) => [
        m.name, {text: m.online ? "online" : "silent", tone: m.online ? "good" : "bad"},
        m.isolated ? {text: "isolated", tone: "bad"} : !m.motion_control ? {text: "off", tone: "dim"} : m.swing ? "swing" : m.moving ? "moving" : "holding",
        fixed(m.position_rad / kDegree, 1), fixed(m.set_point_rad / kDegree, 1), fixed(m.velocity_rad_s / kDegree, 1),
        fixed(m.current_A, 3), fixed(m.temperature_degC, 1), fixed(m.supply_V, 1), m.age_ms === null ? "never" : `${m.age_ms} ms`]),
    }];
  },
};
