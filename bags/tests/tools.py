"""Prints what `rosbags` and `mcap-ros2-support` find in a bag; see tools.rs."""

import json
import sys
from collections import Counter
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from ruamel.yaml import YAML


def with_rosbags(path):
    """Decodes all messages of a folder or a file."""
    decoded, types = Counter(), {}
    with AnyReader([path]) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
            decoded[connection.topic] += 1
            types[connection.topic] = connection.msgtype
        qos = {
            connection.topic: [
                (first := connection.ext.offered_qos_profiles[0]).history.name,
                first.depth,
                first.reliability.name,
                first.durability.name,
            ]
            for connection in reader.connections
        }
        times = {"start_ns": reader.start_time, "duration_ns": reader.duration}
    return {"decoded": decoded, "types": types}, qos, times


def with_mcap(path):
    """Decodes all messages of a file with the other package."""
    decoded, types = Counter(), {}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, _, _ in reader.iter_decoded_messages():
            decoded[channel.topic] += 1
            types[channel.topic] = schema.name
        channels = reader.get_summary().channels.values()
        return {"decoded": decoded, "types": types}, {
            "hashes": {channel.topic: channel.metadata["topic_type_hash"] for channel in channels},
            "attachments": {item.name: item.data.decode() for item in reader.iter_attachments()},
            "metadata": [item.name for item in reader.iter_metadata()],
        }


def main():
    """Inspects the bag, prints what was found."""
    folder = Path(sys.argv[1])
    contents = YAML(typ="safe").load(folder / "metadata.yaml")["rosbag2_bagfile_information"]
    file = folder / contents["relative_file_paths"][0]
    in_folder, qos, times = with_rosbags(folder)
    in_file, _, _ = with_rosbags(file)
    by_mcap, extras = with_mcap(file)
    report = {
        "rosbags_folder": in_folder,
        "rosbags_file": in_file,
        "mcap": by_mcap,
        "qos": qos,
        "message_count": contents["message_count"],
        "custom_data": contents["custom_data"],
        **times,
        **extras,
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main()
