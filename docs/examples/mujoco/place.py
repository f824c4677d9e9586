"""Puts the robots of `fleet.py` where a line of JSON on standard input has them, as a person would.

    rsrs run experiment.yaml … --place-command 'python place.py SOCKET'
"""

import socket
import sys

with socket.socket(socket.AF_UNIX) as fleet:
    fleet.connect(sys.argv[1])
    fleet.sendall(sys.stdin.read().encode())
    fleet.shutdown(socket.SHUT_WR)
    answer = fleet.makefile().read().strip()
if answer != "placed":
    sys.exit(answer)
