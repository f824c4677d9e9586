"""Writes a bag again with `rosbags`, as other programs keep it: messages, and nothing attached.

    python rewritten.py BAG INTO
"""

import sys
from pathlib import Path

from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer

bag, into = Path(sys.argv[1]), Path(sys.argv[2])
with AnyReader([bag]) as reader, Writer(into, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
    connections = {
        connection.id: writer.add_connection(
            connection.topic,
            connection.msgtype,
            typestore=reader.typestore,
            offered_qos_profiles=connection.ext.offered_qos_profiles,
        )
        for connection in reader.connections
    }
    for connection, time_ns, data in reader.messages():
        writer.write(connections[connection.id], time_ns, data)
