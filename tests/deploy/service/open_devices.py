"""Prints of each path of a device whether it opens, or the name of the error."""

import errno
import os
import sys

for path in sys.argv[1:]:
    try:
        os.close(os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))
        outcome = "opens"
    except OSError as error:
        outcome = errno.errorcode[error.errno]
    print(path, outcome, flush=True)
