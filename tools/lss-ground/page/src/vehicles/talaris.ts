// TALARIS: a hopper on four fans and eight cold-gas thrusters. Its x is up, its z ahead; here y is up and x ahead, so
// the axes are permuted: (z, x, y).

import * as THREE from "three";
import type {Json} from "../link";
import type {Model, Picture} from "./kind";
import {beam, box, cylinder, kColours, material, paint, place} from "./shapes";

const kHalf_m = 0.35;
const kLeg_m = 0.25;  // height of the position over the feet
const v = (x: number, y: number, z: number) => new THREE.Vector3(x, y, z);

function plume(length_m: number): THREE.Mesh {
  const mesh = new THREE.Mesh(new THREE.ConeGeometry(0.045, length_m, 16),
    new THREE.MeshBasicMaterial({color: kColours.plume, transparent: true, opacity: 0.75, depthWrite: false}));
  mesh.geometry.translate(0, -length_m / 2, 0);  // from its tip, downwards
  mesh.rotation.set(0, 0, 0);
  mesh.visible = false;
  return mesh;
}

// The places of a flight, a step apart; the oldest go.
class Trail {
  private static readonly kMost = 2000;
  private static readonly kStep_m = 0.1;
  readonly points: THREE.Points;
  private readonly places = new Float32Array(3 * Trail.kMost);
  private readonly last = v(Infinity, 0, 0);
  private count = 0;

  constructor(colour: number, size_m: number) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.places, 3));
    geometry.setDrawRange(0, 0);
    this.points = new THREE.Points(geometry, new THREE.PointsMaterial({color: colour, size: size_m}));
    this.points.frustumCulled = false;
  }
  add(at: THREE.Vector3) {
    if (at.distanceTo(this.last) < Trail.kStep_m) return;
    this.last.copy(at).toArray(this.places, 3 * (this.count++ % Trail.kMost));
    this.points.geometry.attributes.position.needsUpdate = true;
    this.points.geometry.setDrawRange(0, Math.min(this.count, Trail.kMost));
  }
  clear() {
    this.count = 0;
    this.last.x = Infinity;
    this.points.geometry.setDrawRange(0, 0);
  }
}

function model(): Model {
  // In the air: where it was, where guidance wants it to be, and where it may be (three sigma).
  const world = new THREE.Group(), flown = new Trail(kColours.gold, 0.05), planned = new Trail(kColours.plume, 0.035);
  const target = new THREE.Mesh(new THREE.OctahedronGeometry(0.1), new THREE.MeshBasicMaterial({color: kColours.plume, wireframe: true}));
  const sure = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16),
    new THREE.MeshBasicMaterial({color: kColours.gold, transparent: true, opacity: 0.18, depthWrite: false}));
  world.add(flown.points, planned.points, target, sure);
  let airborne = false;
  const root = new THREE.Group(), body = new THREE.Group();
  root.add(body);
  body.add(place(box(0.5, 0.05, 0.5, kColours.body), 0, 0.02, 0), place(cylinder(0.12, 0.3, kColours.gold), 0, 0.2, 0));
  body.add(place(box(0.2, 0.1, 0.2, kColours.panel), 0, 0.4, 0));
  const corners = [[1, -1], [1, 1], [-1, 1], [-1, -1]];
  const fans: THREE.Group[] = [];
  const plumes: THREE.Mesh[] = [];
  corners.forEach(([x, z], i) => {
    const foot = v(x * kHalf_m * 1.25, -0.24, z * kHalf_m * 1.25);
    body.add(beam(v(x * 0.24, 0, z * 0.24), foot, 0.03, kColours.metal), place(cylinder(0.06, 0.015, kColours.metal), foot.x, foot.y, foot.z));
    const ring = new THREE.Mesh(new THREE.TorusGeometry(0.11, 0.018, 10, 32), material(kColours.metal));
    ring.rotation.x = Math.PI / 2;
    const blades = new THREE.Group();
    blades.add(box(0.2, 0.006, 0.03, kColours.leg), box(0.03, 0.006, 0.2, kColours.leg));
    const fan = new THREE.Group();
    fan.add(ring, blades);
    const arm = i % 2 ? v(0, 0.04, z) : v(x, 0.04, 0);
    body.add(beam(arm.clone().multiply(v(0.2, 1, 0.2)), arm.clone().multiply(v(0.42, 1, 0.42)), 0.025, kColours.metal));
    body.add(place(fan, i % 2 ? 0 : x * 0.42, 0.06, i % 2 ? z * 0.42 : 0));
    fans.push(blades);
    const lift = place(plume(0.4), x * 0.22, 0, z * 0.22);  // valves 1, 3, 5, 7
    body.add(lift);
    plumes[i * 2] = lift;
  });
  // 2 and 8 push ahead: their gas goes back; 4 and 6 push back.
  for (const [valve, z] of [[2, -1], [8, 1], [4, 1], [6, -1]] as const) {
    const ahead = valve === 2 || valve === 8;
    const side = place(plume(0.3), ahead ? -0.26 : 0.26, 0.02, z * 0.18);
    side.rotation.z = ahead ? -Math.PI / 2 : Math.PI / 2;
    body.add(side);
    plumes[valve - 1] = side;
  }
  const turned = new THREE.Quaternion();
  return {
    root,
    world,
    update(t: Json, dt_s: number) {
      const ease = Math.min(1, dt_s * 8), p = t.position_m, q = t.attitude_wxyz;
      if (p.every(Number.isFinite)) root.position.lerp(v(p[2], Math.max(p[0], kLeg_m), p[1]), ease);
      if (q.every(Number.isFinite)) body.quaternion.slerp(turned.set(q[3], q[1], q[2], q[0]), ease);
      const aim = t.target_position_m, sigma = t.position_sigma_m;
      if (t.airborne && !airborne) [flown, planned].forEach((trail) => trail.clear());
      airborne = t.airborne;
      target.visible = airborne && Boolean(aim?.every(Number.isFinite));
      if (target.visible) planned.add(target.position.set(aim[2], aim[0], aim[1]));
      if (airborne && p.every(Number.isFinite)) flown.add(v(p[2], p[0], p[1]));
      sure.visible = airborne && p.every(Number.isFinite) && Boolean(sigma?.every(Number.isFinite));
      if (sure.visible) {
        sure.position.set(p[2], p[0], p[1]);
        sure.scale.set(3 * sigma[2], 3 * sigma[0], 3 * sigma[1]);
      }
      t.valves.forEach((valve: Json, i: number) => {
        const share = valve.on_s > 0 ? Math.min(1, valve.on_s / 0.2) : valve.open ? 1 : 0;
        plumes[i].visible = share > 0;
        plumes[i].scale.set(1, 0.3 + 0.7 * share, 1);
      });
      t.fans.forEach((f: Json, i: number) => {
        fans[i].rotation.y += Math.min(30, (f.rpm ?? 0) / 500) * dt_s * (i % 2 ? 1 : -1);
        paint(fans[i], f.rpm > 500 ? kColours.swing : kColours.leg);
      });
    },
  };
}

export const talaris: Picture = {
  metres: 1.4,
  model,
  bars: {
    names: ["1 up", "2 ahead", "3 up", "4 back", "5 up", "6 back", "7 up", "8 ahead"],
    legend: "thrusters: filled while open",
    get: (t) => t.valves.map((w: Json) => w.on_s > 0 || w.open ? 1 : 0),
  },
};
