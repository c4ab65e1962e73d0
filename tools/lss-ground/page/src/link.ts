// The two connections to the gateway. Each sends hello, reconnects by itself, and notes the time of the last message.
// The gateway sends at least five messages a second.

export type Json = Record<string, any>;

const kLost_ms = 800;
const kSilent_ms = 2000, kConnect_ms = 5000;  // then another connection is tried
const kBeat_ms = 200, kFastBeat_ms = 100;
const kShortestWait_ms = 250, kLongestWait_ms = 2000;

function kept(name: string, make: () => string): string {
  let value = sessionStorage.getItem(name);
  if (!value) sessionStorage.setItem(name, value = make());
  return value;
}

// The secret of this tab: it keeps the source name after a lost connection.
const session = kept("session", () =>
  Array.from(crypto.getRandomValues(new Uint8Array(16)), (b) => b.toString(16).padStart(2, "0")).join(""));

// A key may be part of the address, after #, which browsers do not send.
const given = /[#&]key=([^&]+)/.exec(location.hash);
if (given) {
  let key = given[1];
  try { key = decodeURIComponent(key); } catch { /* a wrong key, then */ }
  sessionStorage.setItem("key", key);
  history.replaceState(null, "", location.pathname + location.search);
}
addEventListener("hashchange", () => location.reload());  // given to an open page

export const keyGiven = () => Boolean(sessionStorage.getItem("key"));
export function setKey(key: string) {
  sessionStorage.setItem("key", key);
}

export class Line {
  heard_ms = 0;        // performance.now() of the last message
  welcome: Json | null = null;
  refused = "";        // the gateway's reason for closing, if any
  private socket: WebSocket | null = null;
  private wait_ms = kShortestWait_ms;
  private begun_ms = 0;

  constructor(private readonly protocol: string, private readonly onMessage: (message: Json) => void) {
    this.connect();
    setInterval(() => this.watch(), kBeat_ms);
  }

  get open() { return this.welcome !== null && this.socket?.readyState === WebSocket.OPEN; }
  get lost() { return !this.open || performance.now() - this.heard_ms > kLost_ms; }
  get silent_ms() { return performance.now() - this.heard_ms; }

  // False: it was not sent.
  send(message: Json): boolean {
    if (!this.open) return false;
    this.socket!.send(JSON.stringify(message));
    return true;
  }

  again() {
    this.refused = "";
    this.wait_ms = kShortestWait_ms;
    this.connect();
  }

  private connect() {
    const address = new URL("./", location.href);
    address.protocol = address.protocol.replace("http", "ws");
    address.hash = "";
    const old = this.socket;
    if (old) {
      old.onopen = old.onmessage = old.onclose = null;
      old.close();
    }
    const socket = this.socket = new WebSocket(address, this.protocol);
    this.begun_ms = performance.now();
    socket.onopen = () => socket.send(JSON.stringify(
      {type: "hello", key: sessionStorage.getItem("key") ?? "", session}));
    socket.onmessage = (event) => {
      this.heard_ms = performance.now();
      const message = JSON.parse(event.data) as Json;
      if (message.type === "welcome") {
        this.welcome = message;
        this.wait_ms = kShortestWait_ms;
      }
      this.onMessage(message);
    };
    socket.onclose = (event) => {
      this.welcome = null;
      if (event.reason === "wrong key") this.refused = event.reason;
      if (this.refused) return this.onMessage({type: "refused", text: this.refused});
      setTimeout(() => this.connect(), this.wait_ms);
      this.wait_ms = Math.min(this.wait_ms * 1.6, kLongestWait_ms);
    };
  }

  // Without a network, a connection stays open for many minutes.
  private watch() {
    const now = performance.now();
    const silent = this.welcome ? now - this.heard_ms > kSilent_ms : now - this.begun_ms > kConnect_ms;
    if (!silent || this.socket!.readyState > WebSocket.OPEN) return;
    this.welcome = null;
    this.connect();
  }
}

// The heartbeat is sent by the drawing loop: a page that hangs cannot drive. `trip` receives the round-trip time.
export function beat(line: Line, trip: (ms: number) => void, drive: () => {drives: boolean; ending: boolean}): (pulse: Json) => void {
  let n = 0, turn = 0;
  const sent = new Map<number, number>();
  setInterval(() => {
    if (++turn % (kBeat_ms / kFastBeat_ms) !== 0 && !drive().drives) return;
    if (line.lost || drive().ending || !line.send({type: "beat", n: ++n})) return;
    sent.set(n, performance.now());
    sent.delete(n - 50);
  }, kFastBeat_ms);
  return (pulse) => {
    const then = sent.get(pulse.beat);
    if (then !== undefined) trip(performance.now() - then);
  };
}
