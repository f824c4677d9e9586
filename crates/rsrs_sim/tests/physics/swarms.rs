//! The judge on swarms that are not ours: what swarmsim's robots do under controllers whose behaviour
//! others have named. It calls a ring that rotates stable milling, and never anything else.

use std::f64::consts::TAU;

use rsrs_core::judge::phase::{Phase, label};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_testing::environment::or_if_long;
use rsrs_testing::python::python_with_swarmsim;
use serde_json::{Value, json};

use crate::swarmsim::ask;

const N_ROBOTS: usize = 8;
const DURATION_S: f64 = 81.0;
/// The window of the judge, and a little more, is left.
const SKIPPED_S: f64 = 20.0;

/// What a behaviour is, by those who have named it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ring {
    /// A ring that rotates.
    Always,
    /// A ring when all goes well.
    Sometimes,
    /// Something else.
    Never,
}

/// A swarm of swarmsim.
#[derive(Clone, Copy)]
struct Swarm {
    behaviour: &'static str,
    /// Half of the angle in which a robot sees; the sensor's usual one by default.
    half_angle_rad: Option<f64>,
    period_s: f64,
    ring: Ring,
}

const fn usual(behaviour: &'static str, ring: Ring) -> Swarm {
    Swarm { behaviour, half_angle_rad: None, period_s: 0.13, ring }
}

const SWARMS: [Swarm; 5] = [
    usual("milling", Ring::Always),
    // In one period a pursuer turns by 0.26 rad, and looks past whom it pursues through a line.
    usual("cyclic_pursuit", Ring::Sometimes),
    // One that looks more often, and through a cone, does not: the ring of its name.
    Swarm {
        behaviour: "cyclic_pursuit",
        half_angle_rad: Some(0.2),
        period_s: 0.05,
        ring: Ring::Always,
    },
    usual("dispersal", Ring::Never),
    usual("aggregation", Ring::Never),
];

#[test]
fn only_a_rotating_ring_of_another_simulator_is_stable_milling() {
    let python = python_with_swarmsim();
    let swarms: Vec<(Swarm, u64)> =
        SWARMS.iter().flat_map(|it| (1..=or_if_long(1, 2)).map(|seed| (*it, seed))).collect();
    let wanted = swarms.iter().map(|(swarm, seed)| {
        json!({
            "behaviour": swarm.behaviour,
            "seed": seed,
            "half_angle_rad": swarm.half_angle_rad,
            "period_s": swarm.period_s,
        })
    });
    let task = json!({
        "swarms": wanted.collect::<Vec<_>>(),
        "robots": N_ROBOTS,
        "duration_s": DURATION_S,
        "skipped_s": SKIPPED_S,
    });

    let answer = ask(&python, "swarms_in_swarmsim.py", &task);

    let answered = answer.as_array().expect("one list for each swarm");
    assert_eq!(answered.len(), swarms.len());
    for ((Swarm { behaviour, period_s, ring, .. }, seed), rows) in swarms.into_iter().zip(answered)
    {
        let trajectory = trajectory(rows, period_s);
        let bodies = Bodies { radius_m: Some(0.05), reach_m: Some(20.0), ..Bodies::UNKNOWN };
        let verdict = label(&trajectory, &bodies).expect("it is long enough");
        let is_mill = verdict.phase == Phase::STABLE_MILLING;
        let rotates = rotates_as_a_ring(&trajectory);
        let what = format!("{behaviour} every {period_s} s, seed {seed}: {verdict:?}");
        assert!(!is_mill || rotates, "{what}");
        match ring {
            Ring::Always => assert!(rotates && is_mill, "{what}"),
            Ring::Sometimes => {}
            Ring::Never => assert!(!is_mill, "{what}"),
        }
    }
}

fn trajectory(rows: &Value, period_s: f64) -> Trajectory {
    let mut trajectory = Trajectory::new(period_s, N_ROBOTS);
    for row in rows.as_array().expect("a list of rows") {
        let number = |column: usize| row[column].as_f64().expect("a number");
        let heading_rad = libm::remainder(number(2), TAU);
        trajectory.poses.push(Pose { x_m: number(0), y_m: number(1), heading_rad });
        trajectory.commands.push(Command { speed_m_s: number(3), turn_rate_rad_s: number(4) });
    }
    trajectory
}

/// Whether all robots go around their centroid the same way, once at least, and none is ever half as
/// far from it as another. This asks nothing of the judge.
fn rotates_as_a_ring(trajectory: &Trajectory) -> bool {
    let mut gone_rad = [0.0; N_ROBOTS];
    let mut before_rad = [None; N_ROBOTS];
    for sample in 0..trajectory.n_samples() {
        let poses = trajectory.poses_at(sample);
        let mean = |of: fn(&Pose) -> f64| poses.iter().map(of).sum::<f64>() / N_ROBOTS as f64;
        let (x_m, y_m) = (mean(|pose| pose.x_m), mean(|pose| pose.y_m));
        let radii = poses.iter().map(|pose| libm::hypot(pose.x_m - x_m, pose.y_m - y_m));
        let (least_m, most_m) =
            radii.fold((f64::INFINITY, 0.0_f64), |(least, most), it| (least.min(it), most.max(it)));
        if least_m < 0.5 * most_m {
            return false;
        }
        for (robot, pose) in poses.iter().enumerate() {
            let bearing_rad = libm::atan2(pose.y_m - y_m, pose.x_m - x_m);
            if let Some(before_rad) = before_rad[robot].replace(bearing_rad) {
                gone_rad[robot] += libm::remainder(bearing_rad - before_rad, TAU);
            }
        }
    }
    gone_rad.iter().all(|gone| *gone > TAU) || gone_rad.iter().all(|gone| *gone < -TAU)
}
