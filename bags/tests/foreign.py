"""Writes bags as other laboratories record them, with `rosbags`; see foreign.rs."""

import sys
from pathlib import Path

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

FOREVER = QosTime(9223372036, 854775807)
QOS = Qos(
    QosHistory.KEEP_LAST,
    7,
    QosReliability.BEST_EFFORT,
    QosDurability.TRANSIENT_LOCAL,
    FOREVER,
    FOREVER,
    QosLiveliness.AUTOMATIC,
    FOREVER,
    False,
)


def write(path, version, mode, plugin=StoragePlugin.MCAP):
    """Writes 100 strings, some of which compress well."""
    store = get_typestore(Stores.ROS2_JAZZY)
    string = store.types["std_msgs/msg/String"]
    writer = Writer(path, version=version, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    writer.set_custom_data("lab", "another")
    with writer:
        topic = writer.add_connection(
            "/chatter", "std_msgs/msg/String", typestore=store, offered_qos_profiles=[QOS]
        )
        for number in range(100):
            message = string(data=f"message {number} " * (number % 10 + 1))
            writer.write(topic, 1000 + number, store.serialize_cdr(message, "std_msgs/msg/String"))


def main():
    """Writes one bag of each kind."""
    folder = Path(sys.argv[1])
    for version in (8, 9):
        for mode in (
            CompressionMode.NONE,
            CompressionMode.FILE,
            CompressionMode.MESSAGE,
            CompressionMode.STORAGE,
        ):
            write(folder / f"{mode.name.lower()}_{version}", version, mode)
    write(folder / "sqlite", 8, CompressionMode.NONE, StoragePlugin.SQLITE3)


if __name__ == "__main__":
    main()
