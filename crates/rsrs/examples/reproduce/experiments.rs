//! Experiments on the stand-in's floor: recorded into bags, or only judged.

use std::fmt::Write;
use std::path::Path;

use anyhow::Context;
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::diagram::PhaseCounts;
use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::judge::phase::{Phase, label};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::experiment::{RobotLost, Time};
use rsrs_fleet::record::{Backend, ExperimentRecord, Provenance};
use rsrs_msgs::rsrs::RunLease;
use rsrs_sim::draw::Seed;

use crate::reality::Floor;
use rsrs_pipeline::episode::recorder::Recorder;

/// How long every experiment lasts, in seconds; that of the sweeps.
pub const DURATION_S: f64 = 300.0;

/// The nine experiments: the paper's cell in the middle, and two further speeds and turning rates in
/// and around the milling region. The paper does not say where its nine lay.
pub const SPEEDS_M_S: [f64; 3] = [0.10, 0.15, 0.25];
/// See [`SPEEDS_M_S`].
pub const TURN_RATES_RAD_S: [f64; 3] = [0.25, 0.75, 1.75];

/// Settings that every experiment shares with the sweep.
pub const PLACEMENT_RADIUS_M: f64 = 0.825;
/// Side of the arena, in metres.
pub const ARENA_M: f64 = 15.0;

/// Speed and turning rate of all nine, the paper's first.
pub fn nine() -> Vec<(f64, f64)> {
    let all = SPEEDS_M_S.into_iter().flat_map(|v| TURN_RATES_RAD_S.map(|w| (v, w)));
    let (first, others): (Vec<_>, Vec<_>) = all.partition(|cell| *cell == (0.15, 0.75));
    [first, others].concat()
}

/// The cell of a speed and a turning rate.
pub fn cell((speed_m_s, turn_rate_rad_s): (f64, f64)) -> Cell {
    Cell::new([(Axis::Speed, speed_m_s), (Axis::TurnRate, turn_rate_rad_s)])
        .expect("two axes, both finite")
}

/// The robots as measured, set to a speed and a turning rate.
///
/// # Errors
///
/// If the profile does not allow it.
pub fn conditions(
    measured: &RobotProfile,
    robots: u32,
    (speed_m_s, turn_rate_rad_s): (f64, f64),
) -> anyhow::Result<Conditions> {
    let values = vec![
        (Axis::Speed, speed_m_s),
        (Axis::TurnRate, turn_rate_rad_s),
        (Axis::Robots, f64::from(robots)),
        (Axis::PlacementRadius, PLACEMENT_RADIUS_M),
        (Axis::Arena, ARENA_M),
    ];
    Ok(Conditions::resolve(measured, &Settings { values, ..Settings::default() })?)
}

/// Runs one experiment and records it.
///
/// # Arguments
///
/// * `bag` — folder of the bag; it must not exist.
///
/// # Errors
///
/// If the robots do not fit or the bag cannot be written.
pub fn record(
    bag: &Path,
    (measured, conditions): (&RobotProfile, &Conditions),
    seed: Seed,
) -> anyhow::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    let record = ExperimentRecord {
        run_id: format!("reproduce_{}_{}", seed.seed, seed.replicate),
        robots: (1..=conditions.robots).map(|robot| format!("robot_{robot}")).collect(),
        conditions: conditions.clone(),
        duration_s: DURATION_S,
        seed: seed.seed,
        replicate: seed.replicate,
        robot_lost: RobotLost::Abort,
        backend: Backend::Simulator,
        controller_only: Vec::new(),
        time: Time::RealTime,
        provenance: Provenance::new(version, "reproduce", &measured.digest(), conditions),
    };
    let (mut recorder, []) = Recorder::open(bag, &record, [])?;
    let mut floor = Floor::new(conditions, seed)?;
    recorder.lease(0, RunLease::RUNNING)?;
    while floor.time_s() < DURATION_S {
        for step in floor.advance() {
            recorder.detection(&step)?;
            recorder.odometry(&step)?;
            recorder.command(&step)?;
        }
    }
    recorder.lease(floor.time_ns(), RunLease::STOPPED)?;
    recorder.close()?;
    Ok(())
}

/// Runs one experiment without a bag, sampled once per control period.
///
/// # Errors
///
/// If the robots do not fit.
pub fn watch(conditions: &Conditions, seed: Seed) -> anyhow::Result<Trajectory> {
    let mut floor = Floor::new(conditions, seed)?;
    let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
    for sample in 1..=conditions.steps(DURATION_S) {
        while floor.time_s() < sample as f64 * conditions.period_s {
            floor.advance();
        }
        trajectory.poses.extend(floor.poses());
        trajectory.commands.extend(floor.commands());
    }
    Ok(trajectory)
}

/// Repeats an experiment on fresh seeds, on all processors.
///
/// # Returns
///
/// The phase of each run, in the order of their seeds; shape `[n_runs]`.
///
/// # Errors
///
/// If the robots do not fit.
pub fn repeat(conditions: &Conditions, n_runs: u64) -> anyhow::Result<Vec<Phase>> {
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    let run = |replicate: u64| -> anyhow::Result<Phase> {
        let trajectory = watch(conditions, Seed { seed: REPEATED, replicate })?;
        Ok(label(&trajectory, &conditions.bodies())?.phase)
    };
    let share = |thread: u64| -> anyhow::Result<Vec<(u64, Phase)>> {
        let mine = (0..n_runs).filter(|replicate| replicate % n_threads == thread);
        mine.map(|replicate| Ok((replicate, run(replicate)?))).collect()
    };
    let mut phases = std::thread::scope(|scope| {
        let handles: Vec<_> =
            (0..n_threads).map(|thread| scope.spawn(move || share(thread))).collect();
        let shares = handles.into_iter().map(|handle| handle.join().expect("no run panics"));
        shares.collect::<anyhow::Result<Vec<_>>>()
    })?
    .concat();
    phases.sort_unstable_by_key(|(replicate, _)| *replicate);
    Ok(phases.into_iter().map(|(_, phase)| phase).collect())
}

/// Seed of repeated experiments; those in bags have 1 to 9.
const REPEATED: u64 = 1000;

/// How runs ended.
pub fn counted(phases: &[Phase]) -> PhaseCounts {
    PhaseCounts::of(phases.iter().copied())
}

/// Lets robots drive alone, one after the other, and writes where they went: trials for
/// `rsrs validate`.
///
/// # Errors
///
/// If the file cannot be written.
pub fn drive_alone(path: &Path, measured: &RobotProfile) -> anyhow::Result<()> {
    let mut table =
        String::from("robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s\n");
    let conditions = conditions(measured, 1, (0.15, 0.75))?;
    for robot in 1..=N_DRIVERS {
        for trial in 1..=TRIALS_PER_DRIVER {
            // The world of a robot is drawn with its number, so every trial has its own.
            let seed = Seed { seed: 100 * robot + trial, replicate: 0 };
            let mut floor = Floor::new(&conditions, seed)?;
            while floor.time_s() < TRIAL_S {
                for step in floor.advance() {
                    let (pose, command) = (step.pose, step.command);
                    writeln!(
                        table,
                        "{robot},{trial},{:.3},{:.5},{:.5},{:.5},{},{}",
                        step.time_ns as f64 / 1e9,
                        pose.x_m,
                        pose.y_m,
                        pose.heading_rad,
                        command.speed_m_s,
                        command.turn_rate_rad_s
                    )
                    .expect("a string takes any text");
                }
            }
        }
    }
    std::fs::write(path, table).with_context(|| path.display().to_string())
}

/// Robots that drive alone.
pub const N_DRIVERS: u64 = 5;
/// Trials of each.
pub const TRIALS_PER_DRIVER: u64 = 4;
/// How long each lasts, in seconds.
pub const TRIAL_S: f64 = 10.0;
