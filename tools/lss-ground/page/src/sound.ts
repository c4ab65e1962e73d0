// A tone when a problem is new: two short ones for an error, one for a warning. The person switches it on; a browser
// gives no sound before a page was clicked.

import {$} from "./dom";
import type {Fleet} from "./fleet";

export class Sound {
  private on = localStorage.getItem("sound") === "on";
  private audio: AudioContext | null = null;
  private known = new Map<string, Set<string>>();  // problems of each vehicle
  private readonly button = $("sound");

  constructor() {
    this.button.onclick = () => {
      this.on = !this.on;
      localStorage.setItem("sound", this.on ? "on" : "off");
      if (this.on) this.tone(0);
      this.draw();
    };
    this.draw();
  }

  private draw() {
    this.button.textContent = "♪";
    this.button.classList.toggle("off", !this.on);
    this.button.title = this.on ? "Alarms sound. Press for silence" : "Alarms are silent. Press for sound";
    this.button.setAttribute("aria-label", this.button.title);
    this.button.setAttribute("aria-pressed", String(this.on));
  }

  // Every vehicle, not only the one shown. What was there when the page opened is not new.
  hear(fleet: Fleet) {
    for (const vehicle of fleet.vehicles.values()) {
      if (!vehicle.status || !vehicle.living) continue;
      const problems = (vehicle.status.problems ?? []) as {text: string; error: boolean}[];
      const before = this.known.get(vehicle.id), fresh = before ? problems.filter((p) => !before.has(cause(p.text))) : [];
      this.known.set(vehicle.id, new Set(problems.map((p) => cause(p.text))));
      if (!fresh.length || !this.on) continue;
      this.tone(0);
      if (fresh.some((p) => p.error)) this.tone(0.25);
    }
  }

  private tone(after_s: number) {
    this.audio ??= new AudioContext();
    const at = this.audio.currentTime + after_s, source = this.audio.createOscillator(), volume = this.audio.createGain();
    source.frequency.value = 880;
    volume.gain.setValueAtTime(0.2, at);
    volume.gain.setTargetAtTime(0, at + 0.12, 0.02);
    source.connect(volume).connect(this.audio.destination);
    source.start(at);
    source.stop(at + 0.25);
  }
}

// Without its numbers, which change: "no reply for 3.2 s".
export const cause = (text: string) => text.replace(/\d+(\.\d+)?/g, "#");
