// Shapes shared by several vehicles. Metres; y is up, x ahead.

import * as THREE from "three";
import type {Picture} from "./kind";

export const kColours = {body: 0x8d99ae, metal: 0x5c677d, leg: 0xe0a33e, swing: 0x4fb3d9, bad: 0xe5484d,
  off: 0x4a5160, gold: 0xc9a227, panel: 0x243b64, plume: 0xbfe6ff};

export function material(colour: number, rough = 0.7): THREE.MeshStandardMaterial {
  return new THREE.MeshStandardMaterial({color: colour, roughness: rough, metalness: 0.15});
}

export function box(x: number, y: number, z: number, colour: number): THREE.Mesh {
  return new THREE.Mesh(new THREE.BoxGeometry(x, y, z), material(colour));
}

export function cylinder(radius: number, length: number, colour: number, axis: "x" | "y" | "z" = "y"): THREE.Mesh {
  const geometry = new THREE.CylinderGeometry(radius, radius, length, 24);
  if (axis === "z") geometry.rotateX(Math.PI / 2);
  if (axis === "x") geometry.rotateZ(Math.PI / 2);
  return new THREE.Mesh(geometry, material(colour));
}

// A bar from one point to another.
export function beam(from: THREE.Vector3, to: THREE.Vector3, thick: number, colour: number): THREE.Mesh {
  const mesh = new THREE.Mesh(new THREE.BoxGeometry(thick, thick, from.distanceTo(to)), material(colour));
  mesh.position.copy(from).add(to).multiplyScalar(0.5);
  mesh.lookAt(to);
  return mesh;
}

export function place<T extends THREE.Object3D>(object: T, x: number, y: number, z: number): T {
  object.position.set(x, y, z);
  return object;
}

export function paint(object: THREE.Object3D, colour: number) {
  object.traverse((o) => {
    if (o instanceof THREE.Mesh) (o.material as THREE.MeshStandardMaterial).color.setHex(colour);
  });
}

// Of a vehicle whose shape and place the page does not know.
export const unknown: Picture = {
  metres: 1,
  model() {
    const root = new THREE.Group();
    root.add(place(box(0.6, 0.25, 0.4, kColours.body), 0, 0.125, 0));
    return {root, update() { /* stands */ }};
  },
};
