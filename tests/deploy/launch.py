"""What a launch file would start, as JSON: executable, namespace, arguments and delay of each node.

Stands in for the few parts of `launch` and `launch_ros` that our launch files use, for those are
not on PyPI. Usage: launch.py FILE NAME:=VALUE...
"""

import json
import re
import runpy
import sys
import types
import xml.etree.ElementTree as ElementTree


class Record:
    """An action or substitution that only remembers how it was made."""

    def __init__(self, *values, **options):
        self.values, self.options = values, options


class LaunchConfiguration(Record):
    def perform(self, context):
        return context[self.values[0]]


def module(name, **members):
    made = types.ModuleType(name)
    vars(made).update(members)
    sys.modules[name] = made


def started_by_python(path, given):
    declared, node = type("Declared", (Record,), {}), type("Node", (Record,), {})
    later, timer = type("Later", (Record,), {}), type("Timer", (Record,), {})
    module("launch", LaunchDescription=list)
    module("launch.actions", DeclareLaunchArgument=declared, OpaqueFunction=later, Shutdown=Record, TimerAction=timer)
    module("launch.substitutions", LaunchConfiguration=LaunchConfiguration)
    module("launch_ros")
    module("launch_ros.actions", Node=node)
    actions = runpy.run_path(path)["generate_launch_description"]()
    context = {
        action.values[0]: given.get(action.values[0], action.options.get("default_value"))
        for action in actions
        if isinstance(action, declared)
    }
    assert set(given) <= set(context), f"{path} declares {sorted(context)}"
    assert None not in context.values(), f"not given: {context}"
    for action in actions:
        if isinstance(action, later):
            for started in action.options["function"](context):
                delay_s, nodes = 0.0, [started]
                if isinstance(started, timer):
                    delay_s, nodes = started.options["period"], started.options["actions"]
                for options in (node.options for node in nodes):
                    assert options["package"] == "rsrs", options
                    if "on_exit" in options:
                        check_exits(options["on_exit"])
                    namespace = options.get("namespace")
                    yield options["executable"], namespace, options["arguments"], delay_s


def check_exits(on_exit):
    """What ends everything fails if the node has failed: `ros2 launch` then exits with 1."""
    ended = on_exit(types.SimpleNamespace(returncode=0), None)
    assert isinstance(ended, Record), ended
    try:
        on_exit(types.SimpleNamespace(returncode=3), None)
    except RuntimeError as error:
        assert "exit code 3" in str(error), error
    else:
        raise AssertionError("a failed experiment ends like a good one")


def started_by_xml(path, given):
    root = ElementTree.parse(path).getroot()
    context = {
        argument.get("name"): given.get(argument.get("name"), argument.get("default"))
        for argument in root.iter("arg")
    }
    assert set(given) <= set(context), f"{path} declares {sorted(context)}"
    assert None not in context.values(), f"not given: {context}"

    def resolved(text):
        return text and re.sub(r"\$\(var (\w+)\)", lambda found: context[found[1]], text)

    for node in root.iter("node"):
        assert node.get("pkg") == "rsrs", node.attrib
        arguments = resolved(node.get("args")).split()
        yield node.get("exec"), resolved(node.get("namespace")), arguments, 0.0


def main():
    path, *pairs = sys.argv[1:]
    given = dict(pair.split(":=", 1) for pair in pairs)
    started = started_by_xml if path.endswith(".xml") else started_by_python
    names = ("executable", "namespace", "arguments", "delay_s")
    json.dump([dict(zip(names, node)) for node in started(path, given)], sys.stdout)


main()
