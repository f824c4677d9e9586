"""A client of the Foxglove WebSocket protocol, of other people's parts: prints one message per topic.

    python client.py URL SUBPROTOCOL TOPIC [TOPIC ...]

Messages are decoded by the definitions that the server gives, and by nothing else.
"""

import asyncio
import json
import math
import struct
import sys

import websockets
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def plain(message):
    """Gives a decoded message as what JSON can hold."""
    if hasattr(message, "__dataclass_fields__"):
        names = (name for name in message.__dataclass_fields__ if not name.startswith("__"))
        return {name: plain(getattr(message, name)) for name in names}
    if hasattr(message, "tolist"):
        return message.tolist()
    if isinstance(message, float) and not math.isfinite(message):
        return None
    return message


async def main(url, subprotocol, wanted):
    """Subscribes topics as they are advertised, until each has given a message."""
    decoders = {}
    seen = {}
    async with websockets.connect(url, subprotocols=[subprotocol]) as socket:
        assert socket.subprotocol == subprotocol, socket.subprotocol
        info = json.loads(await socket.recv())
        assert info["op"] == "serverInfo", info
        async for message in socket:
            if isinstance(message, str):
                message = json.loads(message)
                assert message["op"] == "advertise", message
                channels = [it for it in message["channels"] if it["topic"] in wanted]
                for channel in channels:
                    assert channel["encoding"] == "cdr", channel
                    assert channel["schemaEncoding"] == "ros2msg", channel
                    types = get_typestore(Stores.EMPTY)
                    types.register(get_types_from_msg(channel["schema"], channel["schemaName"]))
                    # Numbers of its own, which are not those of the server.
                    decoders[1000 + channel["id"]] = (channel, types)
                subscriptions = [{"id": 1000 + it["id"], "channelId": it["id"]} for it in channels]
                if subscriptions:
                    request = {"op": "subscribe", "subscriptions": subscriptions}
                    await socket.send(json.dumps(request))
                continue
            if message[0] != 1:
                continue
            number, time_ns = struct.unpack_from("<IQ", message, 1)
            channel, types = decoders[number]
            decoded = types.deserialize_cdr(message[13:], channel["schemaName"])
            seen.setdefault(channel["topic"], {"time_ns": time_ns, "message": plain(decoded)})
            if len(seen) == len(wanted):
                break
    print(json.dumps(seen))


asyncio.run(asyncio.wait_for(main(sys.argv[1], sys.argv[2], sys.argv[3:]), 60))
