// A recording of DDS topics (MCAP, of `lss-cli record`), read in the browser and shown as a vehicle: a slider moves the
// picture and the values through its time. It is commanded by nothing, and STOP means every vehicle while it is shown.

import {parseIDL} from "@foxglove/omgidl-parser";
import {MessageReader} from "@foxglove/omgidl-serialization";
import {McapStreamReader} from "@mcap/core";
import {$, el, show} from "./dom";
import type {Fleet} from "./fleet";
import type {Json} from "./link";
import {type Field, History, type Recorded, Vehicle} from "./model";
import {signalsOf} from "./plots";

const kStates = ["Idle", "Operational", "FatalError", "SolveErrors"];
const kSeverities = ["info", "warning", "error", "fatal"];
const kTexts = ["vehicle_id", "vehicle", "version", "mode_name", "authority", "text", "host"];
const kSpeeds = [0.5, 1, 2, 5, 10, 50];
const kTick_ms = 50;

interface Sample { at_s: number; data: Json; }
// What the daemon said of its vehicle.
interface Dictionary {
  subjects: string[]; presentation?: Json; telemetry: {fields?: Field[]};
  faults: {number: number; name: string; advice: string}[];
}

// Numbers of 64 bits become ordinary ones; the largest stands for "never".
function plain(value: unknown, name = ""): any {
  if (typeof value === "bigint") return value === 0xffff_ffff_ffff_ffffn ? null : Number(value);
  if (ArrayBuffer.isView(value) || Array.isArray(value)) {
    const list = Array.from(value as ArrayLike<unknown>);
    if (!kTexts.includes(name)) return list.map((one) => plain(one));
    const end = list.findIndex((c) => Number(c) === 0);
    return new TextDecoder().decode(Uint8Array.from((end < 0 ? list : list.slice(0, end)).map(Number)));
  }
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([key, one]) => [key, plain(one, key)]));
}

function statusOf(data: Json, {faults: known, subjects}: Dictionary): Json {
  const faults = (data.faults as Json[]).filter((f) => f.id !== 0);
  return {...data, state: kStates[data.state] ?? "?", mode: data.mode_name, progress: data.mode_name, authority: data.authority || null, daemons: [],
    stop_in_flight: data.stop_in_flight === 0 ? "lands" : "falls", link: {obc_age_ms: data.obc_age_ms},
    frame: {index: data.frame_index, overruns: data.overruns}, counters: {commands_rejected: data.commands_rejected, safe_commands: data.safe_commands},
    realtime: {policy: data.realtime_enforced ? "enforce" : "degrade", granted: data.realtime_granted}, shared_memory: "off",
    problems: faults.map((f) => {
      const fault = known.find((k) => k.number === f.id), part = f.subject && (subjects[f.subject - 1] ?? `part ${f.subject}`);
      return {error: true, text: (fault?.name.replaceAll("_", " ") ?? `fault ${f.id}`) + (part ? `, ${part}` : ""), advice: fault?.advice ?? ""};
    })};
}

export class Recording implements Recorded {
  readonly telemetry: Sample[] = [];
  readonly status: Sample[] = [];
  readonly events: Sample[] = [];
  now_s = 0;
  playing = false;
  speed = 1;
  kind = "";
  id = "";
  dictionary: Dictionary | null = null;

  constructor(readonly name: string, bytes: Uint8Array) {
    const stream = new McapStreamReader({validateCrcs: true}), schemas = new Map<number, {name: string; text: string}>();
    const topics = new Map<number, {topic: string; reader: MessageReader} | null>(), all = new Map<number, Sample[]>();
    stream.append(bytes);
    for (let record = stream.nextRecord(); record; record = stream.nextRecord()) {
      if (record.type === "Metadata" && record.name === "lss") this.dictionary = JSON.parse(record.metadata.get("dictionary") ?? "null");
      if (record.type === "Schema") schemas.set(record.id, {name: record.name, text: new TextDecoder().decode(record.data)});
      if (record.type === "Channel" && !topics.has(record.id)) {
        const list = this.list(record.topic), schema = schemas.get(record.schemaId);
        if (!list || !schema || record.messageEncoding !== "cdr") {
          topics.set(record.id, null);
          continue;
        }
        topics.set(record.id, {topic: record.topic, reader: new MessageReader(schema.name, parseIDL(schema.text))});
        all.set(record.id, list);
        if (list !== this.telemetry) continue;
        this.kind = record.topic.split("/").pop()!;
        this.id = record.metadata.get("vehicle_id") ?? this.kind;
      }
      const topic = record.type === "Message" ? topics.get(record.channelId) : null;
      if (record.type === "Message" && topic)
        all.get(record.channelId)!.push({at_s: Number(record.logTime) / 1e9, data: plain(topic.reader.readMessage(record.data))});
    }
    if (!this.telemetry.length) throw new Error("it has no telemetry; is it a recording of lss-cli record?");
    if (!this.dictionary) throw new Error("it does not say what its vehicle is: it was recorded by an earlier lss-cli");
    this.now_s = this.begin_s;
  }

  private list(topic: string): Sample[] | null {
    return topic.startsWith("lss/telemetry/") ? this.telemetry : topic === "lss/status" ? this.status : topic === "lss/event" ? this.events : null;
  }
  get begin_s() { return this.telemetry[0].at_s; }
  get end_s() { return this.telemetry[this.telemetry.length - 1].at_s; }

  // Shown like a vehicle.
  vehicle(): Vehicle {
    const {subjects, telemetry, presentation} = this.dictionary!;
    const vehicle = new Vehicle(`${this.id}, ${this.name}`, {vehicle: this.kind, commands: [], subjects, scripts: false,
      fields: telemetry.fields, presentation: {...presentation, hold: []}});
    vehicle.recorded = this;
    const signals = signalsOf(vehicle);
    vehicle.history = new History(signals.length, Infinity);
    for (const {at_s, data} of this.telemetry) vehicle.history.add(at_s, signals.map((s) => {
      const value = s.get(data);
      return typeof value === "number" && Number.isFinite(value) ? value : null;
    }));
    this.events.forEach(({data}) => vehicle.addEvent({...data, severity: kSeverities[data.severity] ?? "info"}));
    return vehicle;
  }

  telemetryNow() { return this.newest(this.telemetry); }
  statusNow() {
    const status = this.newest(this.status);
    return status && statusOf(status, this.dictionary!);
  }

  // The newest sample at that time.
  private newest(list: Sample[]): Json | null {
    let low = 0, high = list.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      list[middle].at_s <= this.now_s ? low = middle + 1 : high = middle;
    }
    return low > 0 ? list[low - 1].data : null;
  }
}

export class Player {
  constructor(private readonly fleet: Fleet, private readonly moved: (vehicle: Vehicle) => void) {
    const input = $("open-file") as HTMLInputElement;
    $("open").onclick = () => input.click();
    input.onchange = () => {
      [...input.files ?? []].forEach((file) => void this.open(file));
      input.value = "";
    };
    addEventListener("dragover", (e) => e.preventDefault());
    addEventListener("drop", (e) => {
      e.preventDefault();
      [...e.dataTransfer?.files ?? []].forEach((file) => void this.open(file));
    });
    setInterval(() => this.play(), kTick_ms);
  }

  private async open(file: File) {
    const where = $("player");
    where.hidden = false;
    show(where, [file.name], () => [el("span", {}, `reading ${file.name} …`)]);
    try {
      const recording = new Recording(file.name, new Uint8Array(await file.arrayBuffer()));
      const vehicle = recording.vehicle();
      this.fleet.open(vehicle);
      this.seek(vehicle, recording.begin_s);
    } catch (error) {
      show(where, [file.name, String(error)], () => [el("b", {class: "bad"}, `${file.name} cannot be shown: ${(error as Error).message}`)]);
    }
  }

  private seek(vehicle: Vehicle, now_s: number) {
    const recording = vehicle.recorded!;
    recording.now_s = Math.min(recording.end_s, Math.max(recording.begin_s, now_s));
    vehicle.telemetry = recording.telemetryNow();
    vehicle.status = recording.statusNow();
    this.moved(vehicle);
    this.draw();
  }

  private play() {
    const vehicle = this.fleet.chosen, recording = vehicle?.recorded;
    if (!vehicle || !recording?.playing) return;
    const next_s = recording.now_s + recording.speed * kTick_ms / 1000;
    recording.playing = next_s < recording.end_s;
    this.seek(vehicle, next_s);
  }

  // The bar of the recording that is shown.
  show(vehicle: Vehicle | null) {
    const where = $("player"), recording = vehicle?.recorded;
    where.hidden = !recording;
    if (!vehicle || !recording) return;
    const play = el("button", {type: "button", id: "play"});
    play.onclick = () => {
      if (recording.now_s >= recording.end_s) this.seek(vehicle, recording.begin_s);
      recording.playing = !recording.playing;
      this.draw();
    };
    const slider = el("input", {type: "range", id: "seek", min: "0", max: String(recording.end_s - recording.begin_s), step: "0.01", "aria-label": "Time in the recording"}) as HTMLInputElement;
    slider.oninput = () => this.seek(vehicle, recording.begin_s + slider.valueAsNumber);
    const speed = el("select", {"aria-label": "Speed"}, ...kSpeeds.map((s) => el("option", {value: String(s), selected: s === recording.speed}, `${s} ×`))) as HTMLSelectElement;
    speed.onchange = () => { recording.speed = Number(speed.value); };
    const close = el("button", {type: "button", id: "close"}, "close");
    close.onclick = () => this.fleet.close(vehicle);
    show(where, [vehicle.id, recording.begin_s], () => [play, slider, el("span", {id: "played"}), speed, close]);
    this.draw();
  }

  private draw() {
    const recording = this.fleet.chosen?.recorded, played = document.getElementById("played");
    if (!recording || !played) return;
    $("play").textContent = recording.playing ? "pause" : "play";
    ($("seek") as HTMLInputElement).value = String(recording.now_s - recording.begin_s);
    played.textContent = `${(recording.now_s - recording.begin_s).toFixed(2)} of ${(recording.end_s - recording.begin_s).toFixed(2)} s · ${new Date(1000 * recording.now_s).toISOString().slice(0, 19).replace("T", " ")} UTC`;
  }
}
