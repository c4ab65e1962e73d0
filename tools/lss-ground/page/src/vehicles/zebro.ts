// Lunar Zebro: six C-shaped legs, each turning about its hip; a solar panel on top.

import * as THREE from "three";
import type {Json} from "../link";
import type {Model, Picture} from "./kind";
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

export const zebro: Picture = {
  metres: 0.3,
  model,
  bars: {
    names: kLegs,
    legend: "filled: on the ground · empty: in the air",
    get: (t) => t.modules.slice(0, 6).map((m: Json) => !m.online ? 2 : m.swing ? 0 : 1),
  },
};
