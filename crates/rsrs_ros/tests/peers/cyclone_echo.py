"""Sends back every sample over Cyclone DDS, decoded and encoded again by it; see main.rs.

The first line of the input is the list of topics; the end of the input is the end.
"""

import json
import sys
import time

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from cyclone_types import Types, messages
from until_end import input_has_ended

FOREVER = duration(seconds=10)


def qos_of(topic):
    reliable, keeps = topic["reliable"], topic["transient_local"]
    return Qos(
        Policy.Reliability.Reliable(FOREVER) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if keeps else Policy.Durability.Volatile,
        Policy.History.KeepLast(topic["depth"]),
    )


def seen(publications, ours, topic):
    """Type and quality of service of what others publish on a topic."""
    return [
        [
            "/".join(publication.type_name.removesuffix("_").replace("dds_::", "").split("::")),
            isinstance(publication.qos[Policy.Reliability], Policy.Reliability.Reliable),
            publication.qos[Policy.Durability] == Policy.Durability.TransientLocal,
        ]
        for publication in publications
        if publication.topic_name == "rt" + topic["name"] and publication.participant_key != ours
    ]


def main():
    topics = json.loads(sys.stdin.readline())
    types = Types({topic["type_name"]: topic["schema"] for topic in topics})
    participant = DomainParticipant(42)
    pairs = []
    for topic in topics:
        kind, qos = types.get(topic["type_name"]), qos_of(topic)
        reader = DataReader(participant, Topic(participant, "rt" + topic["name"], kind), qos)
        echo = Topic(participant, "rt/echo" + topic["name"], kind)
        pairs.append((reader, DataWriter(participant, echo, qos)))
    print(json.dumps("ready"), flush=True)
    while not input_has_ended():
        for reader, writer in pairs:
            for sample in messages(reader):
                writer.write(sample)
        time.sleep(0.002)
    found = BuiltinDataReader(participant, BuiltinTopicDcpsPublication).take(N=1000)
    print(json.dumps({t["name"]: seen(found, participant.guid, t) for t in topics}), flush=True)


main()
