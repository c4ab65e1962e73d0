// node --input-type=module - FILE.mcap < decode.mjs, in the folder with the npm packages of the page: every message as a
// JSON line, read by code that is not ours: by the summary and the indexes of the file, which is refused when a checksum
// does not fit. A last line has the file's metadata.
import { open } from "node:fs/promises";

import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";
import { parse as parseRos } from "@foxglove/rosmsg";
import { MessageReader as RosReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";

// 64-bit numbers stay whole, which JSON.stringify cannot.
function text(value) {
  if (typeof value === "bigint") return value.toString();
  if (typeof value === "number") return Number.isFinite(value) ? String(value) : "null";
  if (Array.isArray(value)) return `[${value.map(text).join(",")}]`;
  if (ArrayBuffer.isView(value)) return `[${Array.from(value, text).join(",")}]`;
  if (value !== null && typeof value === "object")
    return `{${Object.entries(value).map(([key, v]) => `${JSON.stringify(key)}:${text(v)}`).join(",")}}`;
  return JSON.stringify(value);
}

const file = await open(process.argv[2], "r");
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const buffer = new Uint8Array(Number(size));
    await file.read(buffer, 0, buffer.length, Number(offset));
    return buffer;
  },
};

const readers = new Map();
function readerOf(channel, schemas) {
  if (!readers.has(channel.id)) {
    const schema = schemas.get(channel.schemaId);
    if (!["omgidl", "ros2msg"].includes(schema.encoding) || channel.messageEncoding !== "cdr")
      throw new Error(`encoded as ${schema.encoding}`);
    const definition = new TextDecoder().decode(schema.data);
    readers.set(channel.id, schema.encoding === "omgidl" ? new MessageReader(schema.name, parseIDL(definition))
                                                         : new RosReader(parseRos(definition, { ros2: true })));
  }
  return readers.get(channel.id);
}

const indexed = await McapIndexedReader.Initialize({ readable });
const lines = [];
let counted = 0n;
for await (const message of indexed.readMessages()) {
  const channel = indexed.channelsById.get(message.channelId);
  const data = readerOf(channel, indexed.schemasById).readMessage(message.data);
  lines.push(text({ topic: channel.topic, sequence: message.sequence, log_ns: message.logTime,
                    publish_ns: message.publishTime, data }));
  ++counted;
}

// The same from the begin on, with every checksum, that of the data section included.
const stream = new McapStreamReader({ validateCrcs: true });
stream.append(await file.readFile());
let streamed = 0n;
for (let record; (record = stream.nextRecord()); ) if (record.type === "Message") ++streamed;
const metadata = [];
for await (const record of indexed.readMetadata()) metadata.push({ name: record.name, values: Object.fromEntries(record.metadata) });
lines.push(text({ end: { counted, streamed, done: stream.done(), statistics: indexed.statistics.messageCount,
                         library: indexed.header.library, profile: indexed.header.profile, metadata,
                         channels: [...indexed.channelsById.values()].map((c) => ({
                           topic: c.topic, type: indexed.schemasById.get(c.schemaId).name,
                           metadata: Object.fromEntries(c.metadata) })) } }));
process.stdout.write(lines.join("\n") + "\n");
await file.close();
