"""Tables of others as the text of a CSV file, numbers to the bit."""

import csv
import io
from typing import Any


def text(frame: Any) -> str:
    """The text of a frame of polars or pandas, a table of Arrow, or a dictionary of columns."""
    if hasattr(frame, "write_csv"):
        return str(frame.write_csv())
    if hasattr(frame, "to_csv"):
        return str(frame.to_csv(index=False))
    if hasattr(frame, "to_pydict"):
        frame = frame.to_pydict()
    if not hasattr(frame, "keys"):
        raise TypeError(f"expected a path, a data frame or a dictionary of columns, found {frame!r}")
    columns = [list(frame[name]) for name in frame.keys()]
    if len({len(column) for column in columns}) > 1:
        raise ValueError("the columns have different lengths")
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(frame.keys())
    for row in zip(*columns):
        writer.writerow(["" if it is None or it != it else it for it in row])
    return out.getvalue()
