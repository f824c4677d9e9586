"""A microcontroller of docs/serial_protocol.md behind a terminal, to which its argument becomes a link."""

import grp
import os
import select
import sys
import time
import tty


def crc(body):
    remainder = 0xFFFF
    for byte in body:
        remainder ^= byte << 8
        for _ in range(8):
            carry = remainder & 0x8000
            remainder = (remainder << 1 ^ (0x1021 if carry else 0)) & 0xFFFF
    return remainder


def send(line, body):
    os.write(line, f"${body}*{crc(body.encode()):04X}\n".encode())


def serve(line):
    number, commanded_at, speed, turn, is_greeted, rest = "-", 0.0, "0", "0", False, b""
    while True:
        readable, _, _ = select.select([line], [], [], 0.05)
        try:
            rest += os.read(line, 4096) if readable else b""
        except OSError:
            time.sleep(0.05)  # nobody has the other end open
        *bodies, rest = rest.split(b"\n")
        for body in bodies:
            fields = body.strip(b"$\r").split(b"*")[0].decode().split(",")
            if fields[0] == "H":
                number, is_greeted = "-", True
                send(line, f"I,1,{fields[2]},rsrs_base,250,400,20,750")
            elif fields[0] == "V":
                number, commanded_at, (speed, turn) = fields[1], time.monotonic(), fields[3:5]
        is_fresh = time.monotonic() - commanded_at < 0.25
        speed, turn = (speed, turn) if is_fresh else ("0", "0")
        mode = "N" if not is_greeted else "R" if is_fresh else "T"
        clock = int(time.monotonic() * 1000) % 2**32
        send(line, f"S,{clock},{number},{speed},{turn},{mode},-,312,7400")


line, other_end = os.openpty()
tty.setraw(other_end)
name = os.ttyname(other_end)
os.chown(name, 0, grp.getgrnam("dialout").gr_gid)
os.chmod(name, 0o660)
os.symlink(name, sys.argv[1])
serve(line)
