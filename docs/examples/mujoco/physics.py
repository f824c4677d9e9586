"""Nine robots with two wheels and a camera on a floor in MuJoCo: what a laboratory has, and nothing of ROS.

Lengths are in metres, times in seconds, angles in radians. What is random is drawn from the seed:
how wheels and motors of one robot differ from the drawing, and what each camera misses.
"""

import math
import random

import mujoco
import numpy as np

STEP_S = 0.002
BODY_RADIUS_M, BODY_HEIGHT_M, BODY_KG = 0.07, 0.06, 0.9
WHEEL_RADIUS_M, TRACK_M, WHEEL_KG = 0.03, 0.11, 0.04
# The base driver believes the drawing; wheels are made and worn as they are.
WHEEL_SIZE_SD, WHEEL_PAIR_SD, MOTOR_SD = 0.015, 0.004, 0.05
# A geared motor under speed control: it lags behind what is asked, and gives way under load.
MOTOR_NM_S, MOTOR_MOST_NM, MOTOR_LAG_S, GEARBOX_NM = 0.03, 0.03, 0.06, 0.0005
WHEELS_MOST_RAD_S = 14.0
WATCHDOG_S = 0.4
# The camera looks ahead from the front of the body; a body must fill two of its columns.
CAMERA_AHEAD_M, CAMERA_HALF_ANGLE_RAD, COLUMNS = 0.05, 0.35, 21
CAMERA_RANGE_M, CAMERA_RANGE_SD_M, CAMERA_FARTHEST_M = 0.9, 0.04, 2.0
MISSED, INVENTED = 0.04, 0.02
TRACKER_SD_M, TRACKER_SD_RAD = 0.001, 0.004

WORLD = """
<mujoco>
  <option timestep="{step}" integrator="implicitfast" cone="elliptic" impratio="10"/>
  <worldbody>
    <geom name="floor" type="plane" size="20 20 1" friction="0.8" contype="1" conaffinity="0"/>
    {walls}
    {robots}
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>
"""
# Bodies stop at walls, which no camera sees.
WALL = """
<geom type="box" pos="{x} {y} 0.05" size="{half_x} {half_y} 0.05" friction="0.3" contype="2" conaffinity="2"/>
"""
# Wheels and casters touch the floor, bodies touch bodies; rays see bodies, which are of group 1.
ROBOT = """
<body name="{name}" pos="{x} 0 {wheel}">
  <freejoint name="{name}"/>
  <geom name="{name}" type="cylinder" size="{radius} {half_height}" mass="{mass}" pos="0 0 0.01"
        friction="0.3" contype="2" conaffinity="2" group="1"/>
  {casters}
  {wheels}
</body>
"""
# The greater friction of two counts, unless one has priority.
CASTER = """
<geom type="sphere" size="0.01" pos="{x} 0 {z}" mass="0.01" friction="0.02" priority="1"
      contype="0" conaffinity="1"/>
"""
WHEEL = """
<body pos="0 {y} {lift}">
  <joint name="{name}_{side}" type="hinge" axis="0 1 0" armature="2e-5" frictionloss="{gearbox}"/>
  <geom type="cylinder" size="{radius} 0.006" euler="90 0 0" mass="{mass}" friction="0.8"
        contype="0" conaffinity="1"/>
</body>
"""
MOTOR = """
<general joint="{name}_{side}" dyntype="filterexact" dynprm="{lag}" gainprm="{gain}"
         biastype="affine" biasprm="0 0 -{gain}" forcerange="-{most} {most}"/>
"""


class Robot:
    """One robot: its wheels as they were made, and what it was commanded last."""

    def __init__(self, name, draws):
        size = WHEEL_RADIUS_M * draws.gauss(1.0, WHEEL_SIZE_SD)
        pair = draws.gauss(0.0, WHEEL_PAIR_SD)
        self.name = name
        self.wheels_m = (size * (1 - pair), size * (1 + pair))
        self.motor_nm_s = MOTOR_NM_S * draws.gauss(1.0, MOTOR_SD)
        self.commanded, self.commanded_s = (0.0, 0.0), -math.inf

    def xml(self, place):
        wheels = "".join(
            WHEEL.format(
                name=self.name, side=side, y=y, radius=radius, lift=radius - WHEEL_RADIUS_M,
                mass=WHEEL_KG, gearbox=GEARBOX_NM,
            )
            for side, y, radius in zip(("left", "right"), (TRACK_M / 2, -TRACK_M / 2), self.wheels_m)
        )
        return ROBOT.format(
            name=self.name, x=3.0 * place, wheel=WHEEL_RADIUS_M, radius=BODY_RADIUS_M,
            half_height=BODY_HEIGHT_M / 2, mass=BODY_KG, wheels=wheels,
            casters="".join(CASTER.format(x=x, z=0.01 - WHEEL_RADIUS_M) for x in (0.055, -0.055)),
        )

    def motors(self):
        return "".join(
            MOTOR.format(name=self.name, side=side, lag=MOTOR_LAG_S, gain=self.motor_nm_s, most=MOTOR_MOST_NM)
            for side in ("left", "right")
        )

    def wheel_rates(self, time_s):
        """What the base driver asks of both motors: zero once commands have stayed away."""
        speed, rate = self.commanded if time_s - self.commanded_s < WATCHDOG_S else (0.0, 0.0)
        left, right = ((speed - side * rate * TRACK_M / 2) / WHEEL_RADIUS_M for side in (1, -1))
        # Beyond the fastest wheel both are slowed alike, so that the curve stays the same.
        scale = min(1.0, WHEELS_MOST_RAD_S / max(abs(left), abs(right), 1e-9))
        return left * scale, right * scale


def walls(rectangle_m):
    """Four walls, 4 cm thick, around a rectangle whose middle is the origin."""
    x, y = (side_m / 2 + 0.02 for side_m in rectangle_m)
    along_x = [WALL.format(x=0, y=place, half_x=x + 0.02, half_y=0.02) for place in (-y, y)]
    along_y = [WALL.format(x=place, y=0, half_x=0.02, half_y=y - 0.02) for place in (-x, x)]
    return "".join(along_x + along_y)


class Physics:
    """The simulated robots, which `advance` moves on to a time."""

    def __init__(self, names, seed, rectangle_m=None):
        self.draws = random.Random(seed)
        self.robots = {name: Robot(name, self.draws) for name in names}
        robots = self.robots.values()
        world = WORLD.format(
            step=STEP_S,
            walls=walls(rectangle_m) if rectangle_m else "",
            robots="".join(robot.xml(place) for place, robot in enumerate(robots)),
            motors="".join(robot.motors() for robot in robots),
        )
        self.model = mujoco.MjModel.from_xml_string(world)
        self.data = mujoco.MjData(self.model)
        self.joints = {name: self.model.joint(name) for name in names}
        self.bodies = {name: self.model.body(name).id for name in names}
        angles = np.linspace(-CAMERA_HALF_ANGLE_RAD, CAMERA_HALF_ANGLE_RAD, COLUMNS)
        self.columns = angles
        mujoco.mj_forward(self.model, self.data)

    @property
    def time_s(self):
        return self.data.time

    def obey(self, name, speed_m_s, rate_rad_s):
        """A command reaches the base driver of a robot."""
        robot = self.robots[name]
        robot.commanded, robot.commanded_s = (speed_m_s, rate_rad_s), self.time_s

    def advance(self, until_s):
        """Moves all robots on, in steps that never pass the time."""
        while (steps := min(10, int((until_s - self.time_s) / STEP_S + 1e-6))) > 0:
            rates = [robot.wheel_rates(self.time_s) for robot in self.robots.values()]
            self.data.ctrl[:] = np.ravel(rates)
            mujoco.mj_step(self.model, self.data, steps)

    def place(self, poses):
        """Puts robots where they are wanted; all others go to the far end, apart from each other."""
        for aside, (name, joint) in enumerate(self.joints.items()):
            x, y, heading = poses.get(name, (3.0 * aside, 15.0, 0.0))
            qpos, qvel = joint.qposadr[0], joint.dofadr[0]
            half = (math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2))
            self.data.qpos[qpos : qpos + 7] = (x, y, WHEEL_RADIUS_M, *half)
            # The two wheels follow the body in the order of the joints.
            self.data.qvel[qvel : qvel + 8] = 0.0
            self.data.act[2 * aside : 2 * aside + 2] = 0.0
            self.robots[name].commanded_s = -math.inf
        mujoco.mj_forward(self.model, self.data)

    def pose(self, name):
        """Where a robot is: x, y and heading."""
        x, y, _ = self.data.xpos[self.bodies[name]]
        ahead_x, ahead_y = self.data.xmat[self.bodies[name]][[0, 3]]
        return x, y, math.atan2(ahead_y, ahead_x)

    def tracked(self, name):
        """Where a tracker has seen it."""
        x, y, heading = self.pose(name)
        noise = self.draws.gauss
        return (
            x + noise(0.0, TRACKER_SD_M),
            y + noise(0.0, TRACKER_SD_M),
            heading + noise(0.0, TRACKER_SD_RAD),
        )

    def detects(self, name):
        """What the camera of a robot reports of one image: whether there is another robot."""
        return self.nearest_m(name) < math.inf

    def nearest_m(self, name):
        """How far from the camera it reports the nearest robot; infinitely far where it reports none."""
        x, y, heading = self.pose(name)
        angles = heading + self.columns
        rays = np.stack((np.cos(angles), np.sin(angles), np.zeros(COLUMNS)), axis=1)
        eye = np.array(
            (
                x + CAMERA_AHEAD_M * math.cos(heading),
                y + CAMERA_AHEAD_M * math.sin(heading),
                WHEEL_RADIUS_M + 0.01,
            )
        )
        far_m = self.distances(eye, rays, self.bodies[name])
        range_m = self.draws.gauss(CAMERA_RANGE_M, CAMERA_RANGE_SD_M)
        filled_m = far_m[(far_m >= 0.0) & (far_m < range_m)]
        is_seen = len(filled_m) >= 2
        if self.draws.random() >= (1.0 - MISSED if is_seen else INVENTED):
            return math.inf
        return float(filled_m.min()) if is_seen else range_m / 2

    def distances(self, eye, rays, own):
        """How far bodies are along each ray, below zero where there is none."""
        bodies_only = np.array((0, 1, 0, 0, 0, 0), dtype=np.uint8)
        hit, far_m = np.empty(COLUMNS, dtype=np.int32), np.empty(COLUMNS)
        mujoco.mj_multiRay(
            self.model, self.data, eye, rays.ravel(), bodies_only, 1, own, hit, far_m, None, COLUMNS,
            CAMERA_FARTHEST_M,
        )
        return far_m
