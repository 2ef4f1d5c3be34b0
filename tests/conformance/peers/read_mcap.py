#!/usr/bin/env python3
"""Reads our recordings with the MCAP project's own reader, every message by nothing but its schema.

    read_mcap.py FILE...

Each file is read twice: with its index, and from start to end as a stream without one. Checksums are verified. Prints
one line of JSON on stdout, an object with what was found in each file, and ends with 0 if every reader got to the end
of every file and every message was decoded. Needs mcap 1.6.0 and mcap-protobuf-support 0.6.0.
"""
import json
import os
import sys

from google.protobuf.unknown_fields import UnknownFieldSet
from mcap.reader import NonSeekingReader, make_reader
from mcap_protobuf.decoder import DecoderFactory


def shape(name, message):
    """What says of a message that a viewer can show it."""
    if name == "foxglove.FrameTransforms":
        return sorted({(t.parent_frame_id, t.child_frame_id) for t in message.transforms})
    if name == "foxglove.LaserScan":
        return [message.frame_id, len(message.ranges), message.end_angle - message.start_angle]
    if name == "foxglove.SceneUpdate":
        return sorted({entity.frame_id for entity in message.entities})
    if name == "foxglove.Grid":
        rows = len(message.data) / message.row_stride
        return [message.frame_id, message.column_count, rows, message.cell_stride, len(message.fields)]
    if name == "foxglove.Log":
        return [message.level, message.message]
    return None


class Decoders:
    def __init__(self):
        self.protobuf = DecoderFactory()

    def decode(self, schema, channel, data):
        if channel.message_encoding == "json":
            if json.loads(schema.data)["title"] != schema.name:
                raise ValueError(f"{channel.topic}: another schema's title")
            return json.loads(data)
        message = self.protobuf.decoder_for(channel.message_encoding, schema)(data)
        if len(UnknownFieldSet(message)):
            raise ValueError(f"{channel.topic}: fields that the schema does not know")
        return message


def read_with_index(path, found):
    decoders = Decoders()
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        found["library"] = reader.get_header().library
        summary = reader.get_summary()
        found["summary"] = summary is not None
        if summary is not None:
            found["chunks"] = len(summary.chunk_indexes)
            found["stated"] = summary.statistics.message_count
        for schema, channel, message in reader.iter_messages():
            entry = found["topics"].setdefault(channel.topic, {
                "schema": schema.name, "encoding": channel.message_encoding, "messages": 0,
                "metadata": channel.metadata, "first_s": message.log_time * 1e-9, "last_s": message.log_time * 1e-9})
            decoded = decoders.decode(schema, channel, message.data)
            entry.setdefault("shape", shape(schema.name, decoded))
            entry["messages"] += 1
            log_time_s = message.log_time * 1e-9
            entry["first_s"] = min(entry["first_s"], log_time_s)
            entry["last_s"] = max(entry["last_s"], log_time_s)
            found["messages"] += 1


def read_as_stream(path):
    with open(path, "rb") as stream:
        reader = NonSeekingReader(stream, validate_crcs=True)
        return sum(1 for _ in reader.iter_messages(log_time_order=False))


def read(path):
    found = {"messages": 0, "topics": {}}
    read_with_index(path, found)
    found["streamed"] = read_as_stream(path)
    times = [entry[name] for entry in found["topics"].values() for name in ("first_s", "last_s")]
    found["first_s"], found["last_s"] = min(times), max(times)
    found["bytes"] = os.path.getsize(path)
    return found


def main():
    found = {path: read(path) for path in sys.argv[1:]}
    print(json.dumps(found))
    return 0 if all(entry["messages"] for entry in found.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
