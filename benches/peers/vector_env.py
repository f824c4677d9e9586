"""Swarms of rsrs that are stepped from Python: its vector environment, with and without a reward.

The controller is NumPy's here and PyTorch's in `vmas_mill.py`, and is timed in both. Prints lines of name,
robots, agent-steps, CPU seconds.
"""

import sys
import time

import numpy as np

import rsrs

ROBOTS, WORLDS, STEPS = 9, 4096, 300


def main():
    conditions = rsrs.Conditions(sys.argv[1], harsher=True, robots=ROBOTS, speed_m_s=0.15, turn_rate_rad_s=0.75)
    for reward, name in [(None, "no reward"), ("margin", "a reward every 10 steps")]:
        environment = rsrs.vector_env(conditions, WORLDS, reward=reward)
        observations, _ = environment.reset(seed=1)
        actions = np.empty((WORLDS, ROBOTS, 2))
        actions[..., 0] = 0.15
        start = time.process_time()
        for _ in range(STEPS):
            np.multiply(observations, 1.5, out=actions[..., 1])
            actions[..., 1] -= 0.75
            observations, *_ = environment.step(actions)
        elapsed = time.process_time() - start
        print(f"vector environment (Python); {WORLDS} worlds at once; {name},{ROBOTS},{STEPS * WORLDS * ROBOTS},{elapsed:.4f}")


if __name__ == "__main__":
    main()
