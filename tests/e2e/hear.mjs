// node --input-type=module - ADDRESS SUBPROTOCOL COUNT < hear.mjs, in the folder with the npm packages of the page: a
// client of Foxglove's own package subscribes to every channel. A JSON line for the server, each channel and each message,
// until there are COUNT messages of telemetry and one of each other topic.
import protocol from "@foxglove/ws-protocol";
import { WebSocket } from "ws";

const [address, subprotocol, count] = process.argv.slice(2);
const client = new protocol.FoxgloveClient({ ws: new WebSocket(address, [subprotocol]) });
const topics = new Map();  // by subscription
const heard = new Map();  // messages by topic
const say = (line) => console.log(JSON.stringify(line));
const end = (code) => process.stdout.write("", () => process.exit(code));

client.on("error", (error) => { console.error(error.message); end(1); });
client.on("close", () => { console.error("closed"); end(1); });
client.on("serverInfo", (info) => say({ server: info }));
client.on("status", (status) => say({ status }));
client.on("advertise", (channels) => {
  for (const channel of channels) {
    say({ channel });
    topics.set(client.subscribe(channel.id), channel.topic);
    heard.set(channel.topic, 0);
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const topic = topics.get(subscriptionId);
  heard.set(topic, heard.get(topic) + 1);
  const text = new TextDecoder().decode(data);  // as it came: 64-bit numbers stay whole
  console.log(`{"topic":${JSON.stringify(topic)},"log_ns":${timestamp},"data":${text}}`);
  if ([...heard].every(([name, n]) => n >= (name.includes("telemetry") ? Number(count) : 1))) end(0);
});
