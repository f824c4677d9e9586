"""The keys of a file, given as Python's values."""

import json
import os
from collections.abc import Mapping
from typing import Any


def _plain(value: Any) -> Any:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"expected numbers, words, lists and dictionaries, found {value!r}")


def text(keys: Mapping[str, Any]) -> str:
    """The keys as JSON, which every reader of YAML reads; one on each line, by which errors name them."""
    return json.dumps(keys, default=_plain, ensure_ascii=False, allow_nan=False, indent=1)
