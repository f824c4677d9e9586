"""Whether the test that started this script has requested its end."""

import select
import sys


def input_has_ended():
    readable, _, _ = select.select([sys.stdin], [], [], 0)
    return bool(readable)
