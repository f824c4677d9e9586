"""Prints what `rosbags` and `mcap-ros2-support` read in the bag of a run; see interop.rs."""

import hashlib
import json
import sys
from pathlib import Path

import numpy
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from ruamel.yaml import YAML


def plain(value):
    """A decoded message as dictionaries, lists, numbers and texts, whoever decoded it."""
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple, bytes)):
        return [plain(item) for item in value]
    if isinstance(value, (bool, int, float, str)):
        return value
    # Names of fields are in lower case; `rosbags` keeps constants and the type beside them.
    names = getattr(value, "__slots__", None) or [name for name in vars(value) if name[0].islower()]
    return {name: plain(getattr(value, name)) for name in names}


def stamp_ns(message):
    """The stamp of a message, in nanoseconds; none for types without one."""
    if "clock" in message:
        stamp = message["clock"]
    elif "header" in message:
        stamp = message["header"]["stamp"]
    else:
        return None
    return stamp["sec"] * 1_000_000_000 + stamp["nanosec"]


def by_topic(messages):
    """Gathers (topic, type, log time, message): all times, and a fingerprint of all values."""
    topics, digests = {}, {}
    for name, type_name, log_time_ns, message in messages:
        message = plain(message)
        empty = {"type_name": type_name, "log_times_ns": [], "stamps_ns": []}
        topic = topics.setdefault(name, empty)
        topic["log_times_ns"].append(log_time_ns)
        topic["stamps_ns"].append(stamp_ns(message))
        digest = digests.setdefault(name, hashlib.sha256())
        digest.update(json.dumps(message, sort_keys=True).encode())
    for name, topic in topics.items():
        topic["values"] = digests[name].hexdigest()
    return topics


def with_rosbags(folder):
    """Every message, as most people would read them."""
    with AnyReader([folder]) as reader:
        for connection, time_ns, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            yield connection.topic, connection.msgtype, time_ns, message


def with_schemas_alone(folder):
    """Every message, by a reader that has no type but those whose text is in the bag."""
    types = get_typestore(Stores.EMPTY)
    with Reader(folder) as reader:
        for connection in reader.connections:
            found = get_types_from_msg(connection.msgdef.data, connection.msgtype)
            new = {name: found[name] for name in found if name not in types.fielddefs}
            types.register(new)
        for connection, time_ns, data in reader.messages():
            message = types.deserialize_cdr(data, connection.msgtype)
            yield connection.topic, connection.msgtype, time_ns, message


def with_mcap(file):
    """Every message, by the readers of the MCAP project."""
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            yield channel.topic, schema.name, message.log_time, decoded


def attachments(file):
    """The texts that are attached to a bag, by name."""
    with file.open("rb") as stream:
        return {item.name: item.data.decode() for item in make_reader(stream).iter_attachments()}


def main():
    """Reads the bag in three ways, prints what was found."""
    folder = Path(sys.argv[1])
    contents = YAML(typ="safe").load(folder / "metadata.yaml")["rosbag2_bagfile_information"]
    file = folder / contents["relative_file_paths"][0]
    listed = {
        topic["topic_metadata"]["name"]: topic["message_count"]
        for topic in contents["topics_with_message_count"]
    }
    report = {
        "rosbags": by_topic(with_rosbags(folder)),
        "schemas_alone": by_topic(with_schemas_alone(folder)),
        "mcap": by_topic(with_mcap(file)),
        "listed": listed,
        "attachments": attachments(file),
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main()
