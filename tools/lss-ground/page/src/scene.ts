// The picture: ground with an endless grid, the vehicle, and a camera that follows it and is turned by dragging. Limits
// its frame rate to the speed of the machine.

import * as THREE from "three";
import type {Vehicle} from "./model";
import type {Model} from "./vehicles/kind";
import {kindOf} from "./vehicles/roster";

const kSlow_ms = 22;     // a frame that takes longer is drawn less often
const kSoftware_ms = 400, kSoftwarePixels = 0.6;  // between frames, and resolution, without a graphics processor

// Software rendering takes CPU time from everything else, including the heartbeat: then it draws few and simple frames.
function drawsInSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

// A repeated texture: not every browser draws lines with software rendering.
function grid(step_m: number, colour: string): THREE.Mesh {
  const kCells = 80, kPixels = 128;
  const cell = document.createElement("canvas");
  cell.width = cell.height = kPixels;
  const g = cell.getContext("2d")!;
  g.strokeStyle = colour;
  g.lineWidth = 4;  // half of it in the next cell
  g.strokeRect(0, 0, kPixels, kPixels);
  const map = new THREE.CanvasTexture(cell);
  map.wrapS = map.wrapT = THREE.RepeatWrapping;
  map.repeat.set(kCells, kCells);
  map.anisotropy = 8;
  map.colorSpace = THREE.SRGBColorSpace;
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(step_m * kCells, step_m * kCells), new THREE.MeshBasicMaterial({map, transparent: true, depthWrite: false}));
  mesh.rotation.x = -Math.PI / 2;
  return mesh;
}

export class Scene {
  private renderer: THREE.WebGLRenderer | null = null;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(38, 1, 0.01, 500);
  private readonly light = new THREE.DirectionalLight(0xffffff, 2.2);
  private ground: THREE.Mesh | null = null;
  private readonly target = new THREE.Vector3();
  private model: Model | null = null;
  private shown: Vehicle | null = null;
  private metres = 1;
  private turn = -0.75;
  private lift = 0.42;
  private zoom = 1;
  private drawn_ms = 0;
  private drawn = 0;
  private cost_ms = 8;
  private readonly software = drawsInSoftware();

  constructor(private readonly canvas: HTMLCanvasElement) {
    try {
      this.renderer = new THREE.WebGLRenderer({canvas, antialias: !this.software, alpha: true, powerPreference: "low-power"});
    } catch {
      canvas.replaceWith(Object.assign(document.createElement("p"), {className: "empty", textContent: "This browser draws nothing in three dimensions (WebGL)."}));
      return;
    }
    this.scene.add(new THREE.HemisphereLight(0xe8eeff, 0x8a857e, 1.7), this.light, this.light.target);
    let from: [number, number] | null = null;
    canvas.onpointerdown = (e) => { from = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); };
    canvas.onpointerup = () => { from = null; };
    canvas.onpointermove = (e) => {
      if (!from) return;
      this.turn += (e.clientX - from[0]) * 0.008;
      this.lift = Math.min(1.4, Math.max(0.05, this.lift + (e.clientY - from[1]) * 0.006));
      from = [e.clientX, e.clientY];
    };
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.zoom = Math.min(4, Math.max(0.4, this.zoom * Math.exp(e.deltaY * 0.001)));
    }, {passive: false});
  }

  show(vehicle: Vehicle | null) {
    if (vehicle === this.shown) return;
    this.shown = vehicle;
    if (this.model) this.scene.remove(this.model.root, ...this.model.world ? [this.model.world] : []);
    const kind = vehicle && kindOf(vehicle);
    this.model = kind ? kind.model() : null;
    if (!kind || !this.model) return;
    this.metres = kind.metres;
    this.zoom = 1;
    this.scene.add(this.model.root, ...this.model.world ? [this.model.world] : []);
    this.colours();
  }

  colours() {
    if (this.ground) this.scene.remove(this.ground);
    const style = getComputedStyle(document.documentElement);
    this.ground = grid(this.step, style.getPropertyValue("--grid").trim() || "#333");
    const far = this.metres * 9;  // where the ground meets the panel
    this.scene.fog = new THREE.Fog(style.getPropertyValue("--panel").trim() || "#161b22", far * 0.3, far);
    this.scene.add(this.ground);
  }

  private get step() { return this.metres > 1 ? 0.5 : 0.1; }

  draw(now_ms: number) {
    if (!this.renderer || !this.model || document.hidden) return;
    const gap_ms = now_ms - this.drawn_ms;
    if (this.cost_ms > kSlow_ms && gap_ms < this.cost_ms * 3) return;
    if (this.software && gap_ms < kSoftware_ms) return;
    const {fine} = this.canvas.dataset;  // for screenshots: set once, then kept
    if (fine === "drawn") return;
    this.drawn_ms = now_ms;
    const begun = performance.now();
    if (this.shown?.telemetry) this.model.update(this.shown.telemetry, Math.min(0.25, gap_ms / 1000));

    const at = this.model.root.position;
    this.target.lerp(at, Math.min(1, gap_ms / 250));
    if (this.target.distanceTo(at) > this.metres * 4) this.target.copy(at);
    const {step} = this;
    this.ground?.position.set(Math.round(at.x / step) * step, 0, Math.round(at.z / step) * step);
    const far = this.metres * 2.1 * this.zoom * Math.max(1, 1.6 / this.camera.aspect);  // room for words and bars
    this.camera.position.set(this.target.x + far * Math.cos(this.lift) * Math.sin(this.turn),
      this.target.y + far * Math.sin(this.lift), this.target.z + far * Math.cos(this.lift) * Math.cos(this.turn));
    this.camera.lookAt(this.target.x, this.target.y + this.metres * 0.06, this.target.z);
    this.light.position.set(at.x + 3, at.y + 6, at.z + 2);
    this.light.target.position.copy(at);

    const box = this.canvas.parentElement!.getBoundingClientRect();
    const ratio = fine ? 2 : this.software ? kSoftwarePixels : this.cost_ms > kSlow_ms ? 1 : Math.min(2, devicePixelRatio);
    const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
    }
    this.renderer.render(this.scene, this.camera);
    this.cost_ms += (performance.now() - begun - this.cost_ms) * 0.1;
    this.canvas.dataset.drawn = String(++this.drawn);  // for measurements
    if (fine) this.canvas.dataset.fine = "drawn";
    this.canvas.dataset.cost = this.cost_ms.toFixed(2);
  }
}

// Legs on the ground, or open valves, over the last seconds.
export class Bars {
  private static readonly kSeconds = 8;
  private samples: {at: number; values: number[]}[] = [];
  private shown: Vehicle | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {}

  add(vehicle: Vehicle) {
    const {bars} = kindOf(vehicle);
    if (vehicle !== this.shown) {
      this.shown = vehicle;
      this.samples = [];
      this.canvas.hidden = !bars;
      this.canvas.title = bars?.legend ?? "";
    }
    if (!bars || !vehicle.telemetry) return;
    const now = performance.now();
    this.samples.push({at: now, values: bars.get(vehicle.telemetry)});
    while (this.samples[0].at < now - Bars.kSeconds * 1000) this.samples.shift();
  }

  draw() {
    const bars = this.shown && kindOf(this.shown).bars;
    if (!bars || this.canvas.hidden) return;
    const box = this.canvas.getBoundingClientRect(), ratio = devicePixelRatio;
    this.canvas.width = box.width * ratio;
    this.canvas.height = box.height * ratio;
    const g = this.canvas.getContext("2d")!, style = getComputedStyle(document.documentElement);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const bad = colour("--bad"), full = colour("--accent");
    g.scale(ratio, ratio);
    const names_px = 52, row = box.height / bars.names.length, now = performance.now();
    g.font = "11px system-ui, sans-serif";
    g.textBaseline = "middle";
    bars.names.forEach((name, i) => {
      const y = i * row;
      g.fillStyle = colour("--dim");
      g.fillText(name, 2, y + row / 2);
      g.fillStyle = colour("--track");
      g.fillRect(names_px, y + 2, box.width - names_px, row - 4);
      const x = (at: number) => names_px + (box.width - names_px) * (1 - (now - at) / (Bars.kSeconds * 1000));
      const {samples} = this;
      for (let k = 0, next = 0; k < samples.length; k = next) {
        const value = samples[k].values[i];
        for (next = k + 1; next < samples.length && samples[next].values[i] === value;) next++;
        if (!value) continue;
        g.fillStyle = value === 2 ? bad : full;
        const left = Math.max(names_px, x(samples[k].at)), right = next < samples.length ? x(samples[next].at) : box.width;
        g.fillRect(left, y + 2, Math.max(1, right - left), row - 4);
      }
    });
  }
}
