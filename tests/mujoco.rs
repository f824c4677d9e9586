//! The robots in `MuJoCo` that the documentation takes from trials to a verdict: without ROS, whether
//! they are robots at all. `docs/examples/mujoco/run.sh` goes the whole way, in `.ci/long`.

use std::process::Command;

use rsrs_testing::python::{must_run, python_with_mujoco};
use serde_json::Value;

use crate::command::repository;

/// Drives one robot in all ways that a plan has, and holds another one in front of its camera.
const SCRIPT: &str = "\
import json, math, sys
sys.path.insert(0, sys.argv[1])
from physics import Physics
physics = Physics(['robot_1', 'robot_2'], seed=1)

def driven(speed_m_s, rate_rad_s, others={}):
    physics.place({'robot_1': (0.0, 0.0, 0.0), **others})
    for _ in range(20):
        physics.obey('robot_1', speed_m_s, rate_rad_s)
        physics.advance(physics.time_s + 0.1)
    return physics.pose('robot_1')

def share(others):
    physics.place({'robot_1': (0.0, 0.0, 0.0), **others})
    return sum(physics.detects('robot_1') for _ in range(400)) / 400

straight, turn, arc = driven(0.2, 0.0), driven(0.0, 1.0), driven(0.2, 1.0)
physics.advance(physics.time_s + 2.0)
stopped = physics.pose('robot_1')
physics.advance(physics.time_s + 1.0)
json.dump({
    'straight': straight, 'turn': turn, 'arc': arc,
    'crept_m': math.dist(stopped[:2], physics.pose('robot_1')[:2]),
    'blocked': driven(0.2, 0.0, {'robot_2': (0.2, 0.0, math.pi / 2)}),
    'pushed': physics.pose('robot_2'),
    'ahead': share({'robot_2': (0.5, 0.0, 0.0)}), 'beside': share({'robot_2': (0.0, 0.5, 0.0)}),
    'far': share({'robot_2': (1.3, 0.0, 0.0)}), 'alone': share({}),
}, sys.stdout)";

#[test]
fn robots_in_mujoco_drive_about_as_commanded_block_and_see_each_other() {
    let python = python_with_mujoco();
    let folder = repository().join("docs/examples/mujoco");

    let printed = must_run(Command::new(python).args(["-c", SCRIPT]).arg(folder));

    let found: Value = serde_json::from_str(&printed).expect("the script prints JSON");
    let number = |value: &Value| value.as_f64().expect("a number");
    // Of 0.4 m and 2 rad: their wheels lag, slip and are not as drawn, which trials find out.
    for (what, found, commanded) in [
        ("straight on", number(&found["straight"][0]), 0.4),
        ("in place", number(&found["turn"][2]), 2.0),
        ("in an arc", number(&found["arc"][2]), 2.0),
    ] {
        assert!((0.7..0.99).contains(&(found / commanded)), "{what}: {found} of {commanded}");
    }
    assert!(number(&found["crept_m"]) < 0.002, "without commands they stand: {found}");
    let apart_m = number(&found["pushed"][0]) - number(&found["blocked"][0]);
    assert!(apart_m > 0.135 && number(&found["blocked"][0]) < 0.35, "bodies are solid: {found}");
    for (where_it_is, expected) in
        [("ahead", 0.90..1.0), ("beside", 0.0..0.06), ("far", 0.0..0.06), ("alone", 0.0..0.06)]
    {
        let share = number(&found[where_it_is]);
        assert!(expected.contains(&share), "{where_it_is}: detected in {share}");
    }
}
