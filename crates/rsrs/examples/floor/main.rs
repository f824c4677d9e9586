//! The experiments of `docs/reproduce.py` on a stand-in for the laboratory's floor ([`faulty_fleet`]).
//!
//! ```text
//! cargo run --release --example floor FOLDER
//! ```
//!
//! `FOLDER` holds the sweep `plane`. Written beside it are drives of single robots (`alone.csv`), nine
//! experiments as bags, two pictures, and what was counted (`floor.json`).

mod faulty_fleet;
#[path = "../floors/mechanics.rs"]
mod mechanics;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::comparison::{CellRuns, Comparison, Tally};
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::{Phase, label};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::program;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::experiment::Time;
use rsrs_msgs::rsrs::LeaseState;
use rsrs_pipeline::episode::recorder::Recorder;
use rsrs_pipeline::episode::replicate::simulated_record;
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::label::{LabelOptions, label_bag};
use rsrs_pipeline::sweep::folder;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_render::picture::{DiagramOptions, of_sweep};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_view::diagram::ExperimentMark;
use rsrs_view::raster::{PNG_WIDTH_PX, png};
use rsrs_view::theme::Theme;
use rsrs_view::trajectory::TrajectoryPicture;
use serde_json::{Value, json};

use faulty_fleet::{FAULTS, FaultyFleet};

/// How long every experiment lasts, in seconds; that of the sweep.
const DURATION_S: f64 = 300.0;

/// Speeds and turning rates of the nine experiments, the paper's cell first: the others lie in and
/// around the milling region. The paper does not report where its nine lay.
#[rustfmt::skip]
const NINE: [(f64, f64); 9] = [
    (0.15, 0.75), (0.10, 0.25), (0.10, 0.75), (0.10, 1.75), (0.15, 0.25),
    (0.15, 1.75), (0.25, 0.25), (0.25, 0.75), (0.25, 1.75),
];

/// How often each of the nine is repeated.
const REPETITIONS: usize = 40;

/// Seed of repeated experiments; those in bags have 1 to 9.
const REPEATED: u64 = 1000;

/// Contacts per robot and second from which on robots collide continuously: once in 50 s.
const CONTINUOUSLY_PER_S: f64 = 0.02;

/// What one of the nine experiments came to.
struct Experiment {
    cell: Cell,
    /// The judge's label of its bag.
    phase: Phase,
    /// Whether that is settled.
    is_settled: bool,
    /// How simulated runs of its cell ended.
    simulated: PhaseCounts,
    /// How repetitions of it ended, on the same floor with other seeds.
    repeated: Vec<Phase>,
}

fn main() -> anyhow::Result<()> {
    program::set_commit("reproduce");
    let folder = std::env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.context("give the folder that holds the sweep `plane`")?;
    let plane = folder::read(&folder.join("plane"))?;
    let measured = &plane.source.profile;
    write_file(&folder.join("alone.csv"), drive_alone(measured)?.as_bytes())?;
    let experiments = (1..)
        .zip(NINE)
        .map(|(number, (speed_m_s, rate_rad_s))| {
            let conditions = conditions(measured, 9, speed_m_s, rate_rad_s)?;
            let cell = Cell::new([(Axis::Speed, speed_m_s), (Axis::TurnRate, rate_rad_s)])?;
            let bag = folder.join(format!("experiment_{number}"));
            record(&bag, measured, &conditions, number)?;
            let labelled = label_bag(&bag, LabelOptions::default())?;
            Ok(Experiment {
                phase: labelled.phase,
                is_settled: !labelled.is_borderline(),
                simulated: plane.diagram.cells[plane.diagram.locate(&cell)?].counts,
                repeated: repeat(&conditions)?,
                cell,
            })
        })
        .collect::<anyhow::Result<Vec<Experiment>>>()?;
    let papers = conditions(measured, 9, 0.15, 0.75)?;
    let first = watch(&papers, Seed { seed: 1, replicate: 0 })?;
    draw(&folder, &plane, &experiments, &first)?;
    let evidence = label(&first, &papers.bodies())?.evidence;
    let found = json!({
        "faults": FAULTS,
        "gains": SPEEDS_MM_S.map(|[desired, measured]| (measured / 1e3) / (desired / 1e3)),
        "radius_m": evidence.mean_radius_m,
        "circliness": evidence.circliness,
        "collisions": collisions(measured)?,
        "repeated": repeated(&experiments),
    });
    write_file(&folder.join("floor.json"), found.to_string().as_bytes())
}

/// Commanded and measured speeds of `tab:speed1`, in mm/s.
const SPEEDS_MM_S: [[f64; 2]; 6] =
    [[25.0, 22.15], [25.0, 21.48], [25.0, 22.32], [50.0, 48.47], [50.0, 48.66], [50.0, 48.54]];

/// The nine experiments and their repetitions beside the simulator.
fn repeated(experiments: &[Experiment]) -> Value {
    let compare = |real: &dyn Fn(&Experiment) -> PhaseCounts| {
        let runs = experiments.iter().map(|experiment| CellRuns {
            cell: experiment.cell.clone(),
            real: real(experiment),
            simulated: experiment.simulated,
            part: 1.0 / experiments.len() as f64,
        });
        Comparison::new(&runs.collect::<Vec<CellRuns>>())
    };
    let of_one = |number: usize| {
        compare(&|experiment: &Experiment| PhaseCounts::new([experiment.repeated[number]])).tally
    };
    let all = compare(&|experiment| PhaseCounts::new(experiment.repeated.iter().copied()));
    let cells = experiments.iter().zip(&all.cells).map(|(experiment, compared)| {
        let single = CellRuns {
            cell: experiment.cell.clone(),
            real: PhaseCounts::new([experiment.phase]),
            simulated: experiment.simulated,
            part: 1.0,
        };
        json!({
            "speed_m_s": experiment.cell.get(Axis::Speed),
            "turn_rate_rad_s": experiment.cell.get(Axis::TurnRate),
            "simulated": experiment.simulated.majority().map(Phase::key),
            "b_s": compared.simulated.value(),
            "phase": experiment.phase.key(),
            "beside": match Comparison::new(&[single]).tally {
                Tally { easier: 1, .. } => "easier",
                Tally { harder: 1, .. } => "harder",
                _ => "same",
            },
            "n_mills": compared.real.hits,
            "b_r": compared.real.value(),
            "verdict": compared.verdict,
        })
    });
    json!({
        "n": REPETITIONS,
        "cells": cells.collect::<Vec<Value>>(),
        "tallies": (0..REPETITIONS).map(of_one).collect::<Vec<Tally>>(),
        "verdict": all.verdict,
        "pooled": all.pooled,
    })
}

/// The robots as measured, set to a speed and a turning rate.
fn conditions(
    measured: &RobotProfile,
    robots: u32,
    speed_m_s: f64,
    turn_rate_rad_s: f64,
) -> anyhow::Result<Conditions> {
    let values = vec![
        (Axis::Speed, speed_m_s),
        (Axis::TurnRate, turn_rate_rad_s),
        (Axis::Robots, f64::from(robots)),
        (Axis::PlacementRadius, 0.825),
        (Axis::Arena, 15.0),
    ];
    Ok(Conditions::resolve(measured, &Settings { values, ..Settings::default() })?)
}

/// Runs one experiment and records it.
fn record(
    bag: &Path,
    measured: &RobotProfile,
    conditions: &Conditions,
    seed: u64,
) -> anyhow::Result<()> {
    let record = simulated_record(
        format!("reproduce_{seed}_0"),
        conditions.clone(),
        (Time::RealTime, DURATION_S, seed),
        &measured.digest(),
    );
    let (mut recorder, []) = Recorder::open(bag, &record, [])?;
    let mut fleet = FaultyFleet::new(conditions, Seed { seed, replicate: 0 })?;
    recorder.lease(0, LeaseState::Running)?;
    while fleet.time_s() < DURATION_S {
        for step in fleet.advance() {
            recorder.detection(&step)?;
            recorder.odometry(&step)?;
            recorder.command(&step)?;
        }
    }
    recorder.lease(fleet.time_ns(), LeaseState::Stopped)?;
    recorder.close()?;
    Ok(())
}

/// Runs one experiment without a bag, sampled once per control period.
fn watch(conditions: &Conditions, seed: Seed) -> anyhow::Result<Trajectory> {
    let mut fleet = FaultyFleet::new(conditions, seed)?;
    let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
    for sample in 1..=conditions.steps(DURATION_S) {
        while fleet.time_s() < sample as f64 * conditions.period_s {
            fleet.advance();
        }
        trajectory.poses.extend(fleet.poses());
        trajectory.commands.extend(fleet.commands());
    }
    Ok(trajectory)
}

/// Repeats an experiment on fresh seeds, each in a thread of its own; the phases in their order.
fn repeat(conditions: &Conditions) -> anyhow::Result<Vec<Phase>> {
    let run = |replicate: u64| -> anyhow::Result<Phase> {
        let trajectory = watch(conditions, Seed { seed: REPEATED, replicate })?;
        Ok(label(&trajectory, &conditions.bodies())?.phase)
    };
    std::thread::scope(|scope| {
        let replicates = 0..REPETITIONS as u64;
        let threads: Vec<_> = replicates.map(|it| scope.spawn(move || run(it))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no run panics")).collect()
    })
}

/// Lets five robots drive alone, four times 10 s each: trials for `rsrs validate`.
fn drive_alone(measured: &RobotProfile) -> anyhow::Result<String> {
    let mut table =
        String::from("robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s\n");
    let conditions = conditions(measured, 1, 0.15, 0.75)?;
    for (robot, trial) in (1..=5).flat_map(|robot| (1..=4).map(move |trial| (robot, trial))) {
        // The world of a robot is drawn with its number, so every trial has its own.
        let mut fleet =
            FaultyFleet::new(&conditions, Seed { seed: 100 * robot + trial, replicate: 0 })?;
        while fleet.time_s() < 10.0 {
            for step in fleet.advance() {
                let (time_s, Pose { x_m, y_m, heading_rad }) =
                    (step.time_ns as f64 / 1e9, step.pose);
                let Command { speed_m_s, turn_rate_rad_s } = step.command;
                write!(table, "{robot},{trial},{time_s:.3},{x_m:.5},{y_m:.5},{heading_rad:.5},")?;
                writeln!(table, "{speed_m_s},{turn_rate_rad_s}")?;
            }
        }
    }
    Ok(table)
}

/// How many semi-stable simulated runs there are at the paper's turning rate, and in how many of them
/// robots collide continuously.
fn collisions(measured: &RobotProfile) -> anyhow::Result<Value> {
    let harsher = HarsherFactors::for_robot(measured).apply(measured)?;
    let (mut n_colliding, mut n) = (0, 0);
    for speed_m_s in [0.10, 0.15, 0.20, 0.25, 0.30] {
        let conditions = conditions(&harsher, 9, speed_m_s, 0.75)?;
        for replicate in 0..40 {
            let episode = run_episode(&conditions, Seed { seed: 1, replicate }, DURATION_S)?;
            let verdict = label(&episode, &conditions.bodies())?;
            if verdict.phase == Phase::SEMI_STABLE_MILLING {
                n += 1;
                let onsets_per_s = verdict.evidence.contact_onsets_per_s.unwrap_or(0.0);
                n_colliding += u64::from(onsets_per_s >= CONTINUOUSLY_PER_S);
            }
        }
    }
    Ok(json!({ "n": n, "n_colliding": n_colliding, "per_s": CONTINUOUSLY_PER_S }))
}

/// Draws the phase diagram with the experiments on it, and the first of them from above.
fn draw(
    folder: &Path,
    plane: &SweepResult,
    experiments: &[Experiment],
    first: &Trajectory,
) -> anyhow::Result<()> {
    let mark = |it: &Experiment| ExperimentMark {
        cell: it.cell.clone(),
        phase: it.phase,
        is_settled: it.is_settled,
        is_simulated: false,
        n: 1,
        names: Vec::new(),
    };
    let diagram = of_sweep(
        plane,
        &DiagramOptions {
            chosen: folder::read_choice(&folder.join("plane"))?,
            experiments: experiments.iter().map(mark).collect(),
            validation: Some("the experiments ran on a stand-in for the real floor".to_owned()),
            ..DiagramOptions::default()
        },
    )?;
    let mill = rsrs_view::trajectory::svg(&TrajectoryPicture {
        trajectory: first,
        radius_m: plane.source.profile.body.radius_m,
        tail_s: 60.0,
        phase: Some(Phase::STABLE_MILLING),
        lost: &[],
        names: &[],
        walls_m: None,
        world: None,
        classes: &[],
        title: "0.15 m/s, 0.75 rad/s on the stand-in's floor".to_owned(),
        subtitle: "the last 60 s drawn strongly".to_owned(),
        theme: Theme::Screen,
    })?;
    for (name, svg) in [("diagram.png", diagram), ("mill.png", mill)] {
        write_file(&folder.join(name), &png(&svg, PNG_WIDTH_PX)?)?;
    }
    Ok(())
}
