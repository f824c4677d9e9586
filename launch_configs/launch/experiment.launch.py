"""One experiment, on the fleet that stands on the floor or on a simulated one.

    ros2 launch rsrs experiment.launch.py experiment:=milling.yaml interface:=wlan0
    ros2 launch rsrs experiment.launch.py experiment:=milling.yaml backend:=sim

Everything ends when the experiment does, with exit code 1 if it was not completed. `rsrs run` does the same without ROS 2 installed.
"""

import os
from pathlib import Path

import yaml
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown, TimerAction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def enabled_robots(experiment):
    """Names of the robots of an experiment's fleet file, in its order."""
    fleet = experiment.parent / yaml.safe_load(experiment.read_text())["fleet"]
    robots = yaml.safe_load(fleet.read_text())["robots"]
    return [name for name, robot in robots.items() if robot.get("enabled", True)]


def finish(event, context):
    """Ends everything when the runner has ended; `ros2 launch` fails with what fails in here."""
    if event.returncode:
        raise RuntimeError(f"the experiment ended with exit code {event.returncode}")
    return Shutdown(reason="the experiment is over")


def nodes(context):
    def value(name):
        return LaunchConfiguration(name).perform(context)

    is_simulated = value("backend") == "sim"
    # Without an interface the runner of a real fleet refuses, and lists those that there are.
    interface = value("interface") or ("127.0.0.1" if is_simulated else "")

    def node(executable, *arguments, **options):
        everyone = ["--interface", interface, *arguments] if interface else list(arguments)
        return Node(
            package="rsrs", executable=executable, arguments=everyone, output="screen", **options
        )

    experiment = Path(value("experiment")).absolute()
    output = ["--output", value("output")] if value("output") else []
    options = ["--experiment", str(experiment), "--backend", value("backend"), *output]
    runner = node("experiment_runner", *options, on_exit=finish)
    if not is_simulated:
        return [runner]
    robots = ["--robots", ",".join(enabled_robots(experiment))]
    return apart([node("sim_node", *robots), node("controller_node", *robots), runner])


def apart(started):
    """Secured programs that join at once lose handshakes: each starts two seconds after the last."""
    if os.environ.get("ROS_SECURITY_ENABLE") != "true":
        return started
    return [TimerAction(period=2.0 * index, actions=[node]) for index, node in enumerate(started)]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("experiment", description="The experiment file."),
        DeclareLaunchArgument(
            "backend", default_value="fleet", choices=["fleet", "sim"],
            description="Who moves: the fleet that stands there, or a simulated one.",
        ),
        DeclareLaunchArgument(
            "interface", default_value="",
            description="The network interface, by name or IP address, to speak on; for a "
            "simulated fleet loopback if empty, for a real one what RSRS_INTERFACE names.",
        ),
        DeclareLaunchArgument(
            "output", default_value="", description="The bag to record; named by date if empty."
        ),
        OpaqueFunction(function=nodes),
    ])
