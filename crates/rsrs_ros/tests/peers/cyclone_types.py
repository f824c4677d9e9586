"""Types of Cyclone DDS out of the definitions of ROS 2, as rmw_cyclonedds would make them."""

import re

from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final

NUMBERS = {
    "bool": bool,
    "byte": types.uint8,
    "char": types.uint8,
    "float32": types.float32,
    "float64": types.float64,
    **{f"{sign}int{bits}": getattr(types, f"{sign}int{bits}") for sign in ["", "u"] for bits in [8, 16, 32, 64]},
}
DELIMITER = "=" * 80 + "\n"
FIELD = re.compile(r"^(?P<base>[\w/]+)(<=\d+)?(\[(?P<length>(<=)?\d*)\])?\s+(?P<name>\w+)(\s+[^=\s].*)?$")


class Types:
    """Classes by the full names of their types; each is made when it is first asked for."""

    def __init__(self, schemas):
        """From schema texts as bags have them, by the name of the type that comes first."""
        self.texts, self.made = {}, {}
        for name, schema in schemas.items():
            first, *others = schema.split(DELIMITER)
            self.texts[name] = first
            for other in others:
                head, _, text = other.partition("\n")
                package, _, base = head.removeprefix("MSG: ").partition("/")
                self.texts[f"{package}/msg/{base}"] = text

    def get(self, name):
        if name not in self.made:
            fields = fields_of(self.texts[name])
            members = {field: self.type_of(name, base, length) for field, base, length in fields}
            self.made[name] = struct(name, members)
        return self.made[name]

    def type_of(self, inside, base, length):
        if base == "string":
            element = str
        elif base in NUMBERS:
            element = NUMBERS[base]
        else:
            package, _, short = base.rpartition("/")
            element = self.get(f"{package or inside.split('/')[0]}/msg/{short}")
        if length is None:
            return element
        return types.array[element, int(length)] if length.isdigit() else types.sequence[element]


def fields_of(text):
    """Name, type and length of each field, without constants and comments."""
    for line in text.splitlines():
        found = FIELD.match(line.partition("#")[0].strip())
        if found:
            yield found["name"], found["base"], found["length"]


def struct(name, members):
    """`std_msgs/msg/Bool` is `std_msgs::msg::dds_::Bool_` in DDS."""
    package, kind, short = name.split("/")
    return final(make_idl_struct(f"{short}_", f"{package}.{kind}.dds_.{short}_", members))


def messages(reader):
    """What has come; a publisher that leaves announces it in a sample without a message."""
    return [sample for sample in reader.take(N=100) if sample.sample_info.valid_data]
