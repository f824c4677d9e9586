"""Prints what `rosbags` makes of the values, names and texts in a JSON file; see oracle.rs."""

import json
import sys
from pathlib import Path

import numpy
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

NUMPY_TYPES = {"bool": numpy.bool_, "byte": numpy.uint8, "char": numpy.uint8}
NUMPY_TYPES |= {
    name: getattr(numpy, name)
    for name in "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split()
}


def register_services(store):
    """Adds the requests and responses of the services that the ROS package defines."""
    folder = Path(sys.prefix) / "share/rcl_interfaces/srv"
    for file in sorted(folder.glob("*Parameter*.srv")):
        for part, text in zip(("Request", "Response"), file.read_text().split("\n---\n")):
            name = f"{file.stem}_{part}"
            # The parser accepts only names with msg in the middle.
            parsed = get_types_from_msg(text, f"rcl_interfaces/msg/{name}")
            store.register({f"rcl_interfaces/srv/{name}": parsed[f"rcl_interfaces/msg/{name}"]})


def register_package(store, folder):
    """Adds the messages and services of a package that `rosbags` does not have."""
    files = sorted(Path(folder).glob("msg/*.msg"))
    for file in files:
        store.register(get_types_from_msg(file.read_text(), f"{Path(folder).name}/msg/{file.stem}"))
    for file in sorted(Path(folder).glob("srv/*.srv")):
        request, response = f"\n{file.read_text()}".split("\n---\n")
        for part, text in (("Request", request), ("Response", response)):
            name = f"{Path(folder).name}/msg/{file.stem}_{part}"
            # ROS 2 gives a message without fields this one.
            text = text if text.strip() else "uint8 structure_needs_at_least_one_member"
            parsed = get_types_from_msg(text, name)
            store.register({name.replace("/msg/", "/srv/"): parsed[name]})


def build(store, type_name, values):
    """Makes a message object of plain values, all of which must be fields."""
    _, fields = store.fielddefs[type_name]
    assert [name for name, _ in fields] == list(values), (type_name, fields, list(values))
    return store.types[type_name](
        **{name: build_field(store, kind, values[name]) for name, kind in fields}
    )


def build_field(store, kind, value):
    """Makes one field."""
    node, detail = kind
    if node == Nodetype.NAME:
        return build(store, detail, value)
    if node == Nodetype.BASE:
        # rosbags packs a lone byte as a signed one: the same bits, another number.
        return value - 256 if detail[0] == "byte" and value > 127 else value
    element, _ = detail
    if element[0] == Nodetype.BASE and element[1][0] in NUMPY_TYPES:
        # A covariance is written row by row.
        return numpy.array(value, dtype=NUMPY_TYPES[element[1][0]]).ravel()
    return [build_field(store, element, item) for item in value]


def definition(fielddefs, type_name):
    """Constants and fields as JSON compares them; enum members become their names."""
    return json.loads(json.dumps(fielddefs[type_name], default=lambda node: node.name))


def all_definitions(fielddefs):
    """The same for every type in a parsed text."""
    return {name: definition(fielddefs, name) for name in fielddefs}


def main():
    """Reads the question, prints the answer."""
    question = json.loads(Path(sys.argv[1]).read_text())
    store = get_typestore(Stores.ROS2_JAZZY)
    register_services(store)
    register_package(store, question["package"])
    for name, text in question["own_definitions"].items():
        store.register(get_types_from_msg(text, name))

    parsed, expected = {}, {}
    for name, text in question["schemas"].items():
        parsed[name] = all_definitions(get_types_from_msg(text, name))
        generated, _ = store.generate_msgdef(name, ros_version=2)
        expected[name] = {
            found: definition(store.fielddefs, found)
            for found in get_types_from_msg(generated, name)
        }
    answer = {
        "cdr_hex": [
            bytes(
                store.serialize_cdr(
                    build(store, case["type_name"], json.loads(case["values"])), case["type_name"]
                )
            ).hex()
            for case in question["cases"]
        ],
        "hashes": {name: store.hash_rihs01(name) for name in question["schemas"]},
        "parsed": parsed,
        "expected": expected,
    }
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
