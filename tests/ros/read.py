"""What the formats' own Python libraries read from an MCAP or bag file, as JSON.

    python tests/ros/read.py FILE

Prints {"topics": {TOPIC: {"type": NAME, "messages": [...]}}}: each message's fields by their names, ROS 2 by
mcap-ros2-support, with {"bytes": N, "sha256": HEX} in place of bytes. An MCAP file is read by rosbags too, by the schemas
that it brings along; where the two differ, or a bag cannot be read, the exit code is 1.
"""

import hashlib
import json
import sys
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore


def plain(value):
    """Numbers, texts, lists and fields by name, without the libraries' own types."""
    if isinstance(value, (bytes, bytearray, memoryview)) or getattr(value, "dtype", None) == np.uint8:
        content = bytes(value)
        return {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    if isinstance(value, (str, int, float, bool)):
        return value
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    names = getattr(value, "__slots__", None) or list(value.__dataclass_fields__)
    return {name: plain(getattr(value, name)) for name in names if not name.startswith("_")}


def by_mcap_ros2(path):
    topics = {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            topic = topics.setdefault(channel.topic, {"type": schema.name, "messages": []})
            topic["messages"].append({"log_time": message.log_time, **plain(decoded)})
    return topics


def by_rosbags(path):
    topics = {}
    with AnyReader([path], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        for connection, time, data in reader.messages():
            topic = topics.setdefault(connection.topic, {"type": connection.msgtype, "messages": []})
            topic["messages"].append({"log_time": time, **plain(reader.deserialize(data, connection.msgtype))})
    return topics


def main():
    path = Path(sys.argv[1])
    topics = by_rosbags(path)
    if path.suffix == ".mcap":
        other = by_mcap_ros2(path)
        if other != topics:
            sys.exit(f"mcap-ros2-support and rosbags read {path} differently")
    json.dump({"topics": topics}, sys.stdout)


if __name__ == "__main__":
    main()
