// D.I.A.N.A. Ardito: six wheels on rockers and bogies, the corner ones steered.

import * as THREE from "three";
import type {Json} from "../link";
import type {Model, Picture} from "./kind";
import {beam, box, cylinder, kColours, paint, place} from "./shapes";

const kWheel_m = 0.15, kTread_m = 0.12, kTrack_m = 0.391, kBase_m = 0.6;  // from the middle to a wheel beside, ahead and behind
const kSteering: Record<number, number> = {0: 0, 1: 1, 4: 2, 5: 3};  // wheel to steering drive
const v = (x: number, y: number, z: number) => new THREE.Vector3(x, y, z);

function wheel(): THREE.Group {
  const spinning = new THREE.Group();
  spinning.add(cylinder(kWheel_m, kTread_m, kColours.metal, "z"));
  for (let i = 0; i < 8; i++) {
    const cleat = box(0.016, 0.04, kTread_m * 1.02, kColours.metal);
    cleat.rotation.z = i * Math.PI / 4;
    cleat.position.set(-Math.sin(i * Math.PI / 4) * kWheel_m, Math.cos(i * Math.PI / 4) * kWheel_m, 0);
    spinning.add(cleat);
  }
  return spinning;
}

function model(): Model {
  const root = new THREE.Group(), body = new THREE.Group();
  root.add(body);
  body.position.y = kWheel_m + 0.2;
  body.add(place(box(0.8, 0.2, 0.5, kColours.body), 0, 0.14, 0));
  body.add(place(box(0.72, 0.014, 0.46, kColours.panel), 0, 0.25, 0));
  body.add(place(cylinder(0.02, 0.5, kColours.metal), 0.28, 0.5, 0.11));
  body.add(place(box(0.07, 0.07, 0.17, kColours.metal), 0.28, 0.78, 0.11));
  body.add(place(cylinder(0.02, 2 * kTrack_m, kColours.metal, "z"), 0, 0.08, 0));  // axis of the rockers
  const beacon = place(cylinder(0.035, 0.07, kColours.off), -0.28, 0.29, 0.14);
  body.add(beacon);
  const wheels: {spin: THREE.Group; steer: THREE.Group; angle: number}[] = [];
  const rockers: THREE.Group[] = [], bogies: THREE.Group[] = [];
  for (const side of [-1, 1]) {
    const z = side * kTrack_m, rocker = place(new THREE.Group(), 0, 0.08, z), bogie = place(new THREE.Group(), -kBase_m / 2, -0.1, 0);
    body.add(rocker);
    rocker.add(bogie, beam(v(0, 0, 0), v(kBase_m, 0, 0), 0.04, kColours.gold), beam(v(0, 0, 0), v(-kBase_m / 2, -0.1, 0), 0.04, kColours.gold),
      beam(v(kBase_m, 0, 0), v(kBase_m, -0.28, 0), 0.035, kColours.gold));
    bogie.add(beam(v(kBase_m / 2, 0, 0), v(-kBase_m / 2, 0, 0), 0.035, kColours.gold));
    for (const x of [kBase_m / 2, -kBase_m / 2]) bogie.add(beam(v(x, 0, 0), v(x, -0.18, 0), 0.035, kColours.gold));
    rockers.push(rocker);
    bogies.push(bogie);
    [0, 1, 2].forEach((row) => {
      const spin = wheel(), steer = new THREE.Group();
      steer.add(spin);
      if (row === 0) rocker.add(place(steer, kBase_m, -0.28, 0));
      else bogie.add(place(steer, row === 1 ? kBase_m / 2 : -kBase_m / 2, -0.18, 0));
      wheels[row * 2 + (side < 0 ? 0 : 1)] = {spin, steer, angle: 0};
    });
  }
  return {
    root,
    update(t: Json, dt_s: number) {
      const ease = Math.min(1, dt_s * 10);
      root.position.x += ((t.x_m ?? 0) - root.position.x) * ease;
      root.position.z += (-(t.y_m ?? 0) - root.position.z) * ease;
      const yaw = -(t.yaw_rad ?? 0);
      root.rotation.y += Math.atan2(Math.sin(yaw - root.rotation.y), Math.cos(yaw - root.rotation.y)) * ease;
      const beta = t.beta_rad ?? 0;
      rockers[0].rotation.z = beta;
      rockers[1].rotation.z = -beta;
      bogies.forEach((b, i) => { b.rotation.z = t.rho_rad[i] ?? 0; });
      t.wheels.forEach((w: Json, i: number) => {
        wheels[i].angle -= (w.hall_rad_s ?? w.motor_rad_s ?? 0) * dt_s;
        wheels[i].spin.rotation.z = wheels[i].angle;
        const steering = t.steering[kSteering[i]];
        if (i in kSteering) wheels[i].steer.rotation.y = steering?.reduction_rad ?? steering?.motor_rad ?? 0;
        const node = t.nodes[i];
        paint(wheels[i].spin, node && !node.online || w.state >= 3 ? kColours.bad : w.state > 0 ? kColours.leg : node?.isolated ? kColours.off : kColours.metal);
      });
      paint(beacon, t.beacon ? 0xffb020 : kColours.off);
    },
  };
}

export const ardito: Picture = {
  metres: 1.8,
  model,
};
