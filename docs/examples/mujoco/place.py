"""Puts the robots of `fleet.py` where a line of JSON on standard input has them, as a person would.

    rsrs run experiment.yaml … --place-command 'python place.py SOCKET'
"""

import socket
import sys

with socket.socket(socket.AF_UNIX) as floor:
    floor.connect(sys.argv[1])
    floor.sendall(sys.stdin.read().encode())
    floor.shutdown(socket.SHUT_WR)
    answer = floor.makefile().read().strip()
if answer != "placed":
    sys.exit(answer)
