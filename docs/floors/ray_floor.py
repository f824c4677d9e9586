"""The floor of crates/rsrs/examples/floors: what that answers to a line of JSON."""

import json
import subprocess

import numpy as np

from floor import Recording


class Floor:
    """Solid bodies, motors with inertia, sensors that cast rays, and faults that last for a while."""

    name = "rays"
    radius_m = 0.075
    period_s = 0.13
    contact = "push"

    def __init__(self, program):
        self.program = subprocess.Popen(
            [program, "drive"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def drive(self, robots, starts, controller, duration_s, seed):
        """Lets robots, by number, drive from their starts. Each decides by a clock of its own."""
        task = {
            "robots": list(robots), "starts": starts, "unseen": controller.unseen, "seen": controller.seen,
            "n_periods": round(duration_s / self.period_s), "seed": seed,
        }
        print(json.dumps(task), file=self.program.stdin, flush=True)
        found = json.loads(self.program.stdout.readline())
        return Recording(**{key: np.array(value) for key, value in found.items()})
