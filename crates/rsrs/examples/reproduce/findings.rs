//! All that this document rests on, in the order of the paper's steps.

use std::path::Path;

use anyhow::Context;
use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_core::judge::order::Evidence;
use rsrs_core::judge::phase::{Phase, label};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::statistics::comparison::{CellRuns, Comparison, Tally};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use serde_json::Value;

use crate::experiments::{self, ARENA_M, DURATION_S, PLACEMENT_RADIUS_M, cell, conditions, nine};
use crate::program::Program;
use crate::swept::{self, Wanted, sweep};

/// What one of the nine experiments came to.
pub struct Experiment {
    /// Speed in m/s and turning rate in rad/s.
    pub setting: (f64, f64),
    /// What the judge said of its bag.
    pub phase: Phase,
    /// How simulated runs of its cell ended.
    pub simulated: PhaseCounts,
    /// How repetitions of it ended, on the same floor with other seeds.
    pub repeated: Vec<Phase>,
}

/// What a robot that cannot mill came to.
pub struct Hopeless {
    /// Its profile.
    pub name: &'static str,
    /// Made harsher, for each number of robots.
    pub harsher: Vec<Searched>,
    /// As the robot was made up.
    pub measured: Vec<Searched>,
}

/// Where a mill was looked for with one number of robots.
pub struct Searched {
    /// The number.
    pub robots: u32,
    /// What `rsrs choose` says if no cell is viable.
    pub reason: Option<String>,
    /// The plane of speed and turning rate.
    pub diagram: PhaseDiagram,
    /// What `rsrs choose` says of each factor in the best cell; `null` for robots as measured.
    pub factors: Value,
}

/// One setting varied at the paper's cell.
pub struct Varied {
    /// What is varied.
    pub axis: Axis,
    /// How often each value mills.
    pub diagram: PhaseDiagram,
}

/// All that was found.
pub struct Findings {
    /// The robots as measured.
    pub measured: RobotProfile,
    /// What `rsrs validate` reported of robots that drive alone.
    pub validation: Value,
    /// The plane of the paper's diagram.
    pub plane: PhaseDiagram,
    /// The same plane, of runs three times as long.
    pub long: PhaseDiagram,
    /// The same plane, with the sensor of the group's own configurations.
    pub group_sensor: PhaseDiagram,
    /// What `rsrs choose` reported.
    pub choice: Value,
    /// Speed and turning rate that `rsrs choose` recommends after sweeps with other seeds; `None` where
    /// no cell is viable.
    pub recommended: Vec<Option<(f64, f64)>>,
    /// The nine experiments, the paper's cell first.
    pub experiments: Vec<Experiment>,
    /// What `rsrs compare` reported of their bags.
    pub comparison: Value,
    /// Tallies of the repetitions, nine runs each.
    pub tallies: Vec<Tally>,
    /// All repetitions against the simulator.
    pub repeated: Comparison,
    /// How many semi-stable runs of the plane bump into each other continuously, of how many.
    pub bumping: (u64, u64),
    /// One run at the paper's cell, and what the judge saw in it.
    pub mill: (Trajectory, Evidence),
    /// Settings varied at the paper's cell.
    pub varied: Vec<Varied>,
    /// Robots that cannot mill.
    pub hopeless: Vec<Hopeless>,
}

/// How often each of the nine experiments is repeated.
pub const REPETITIONS: usize = 40;

const FIXED: &str = "{robots: 9, placement_radius_m: 0.825, arena_m: 15, walls: stop}";

/// Goes through the four steps.
///
/// # Arguments
///
/// * `work` — an empty folder.
/// * `root` — that of the project.
///
/// # Errors
///
/// The first step that fails.
pub fn find(work: &Path, root: &Path) -> anyhow::Result<Findings> {
    copy_launch_configs(work, root)?;
    let program = Program::build(work)?;
    let path = work.join("launch_configs/profiles/flockbot.yaml");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let measured = RobotProfile::parse("flockbot.yaml", &text)?;

    let axes = "{speed_m_s: {from: 0.05, to: 0.30, steps: 11}, \
                turn_rate_rad_s: {from: 0.25, to: 2.0, steps: 8}}";
    let of_plane = flockbots("plane", axes);
    let plane = sweep(&program, work, &of_plane)?;
    let long = Wanted { name: "long", duration_s: 900, ..of_plane };
    let group = Wanted { name: "group", profile: "flockbot_group_sensor", ..of_plane };
    let (long, group) = (sweep(&program, work, &long)?, sweep(&program, work, &group)?);
    experiments::drive_alone(&work.join("alone.csv"), &measured)?;
    let validation = program.run("validate plane --trajectories alone.csv --format json")?.json;
    let choice = program.run("choose plane -o plane/choice.json --format json")?.json;

    let experiments = nine()
        .into_iter()
        .zip(1..)
        .map(|(setting, number)| experiment(&program, (work, number), (&measured, setting), &plane))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let bags: Vec<String> =
        (1..=experiments.len()).map(|number| format!("experiment_{number}")).collect();
    let compare = format!("compare plane --format json --bags {}", bags.join(" "));
    let comparison = program.run(&compare)?.json;

    Ok(Findings {
        recommended: recommended(&program, work, &of_plane)?,
        long,
        group_sensor: group,
        tallies: tallies(&experiments),
        repeated: Comparison::of(&runs(&experiments, 0..REPETITIONS)),
        bumping: bumping(&measured)?,
        mill: mill(&measured)?,
        varied: varied(&program, work)?,
        hopeless: vec![hopeless(&program, work, &SMARS)?, hopeless(&program, work, &LTA)?],
        measured,
        validation,
        plane,
        choice,
        experiments,
        comparison,
    })
}

fn copy_launch_configs(work: &Path, root: &Path) -> anyhow::Result<()> {
    let (from, to) = (root.join("launch_configs/profiles"), work.join("launch_configs/profiles"));
    std::fs::create_dir_all(&to).with_context(|| to.display().to_string())?;
    for name in ["flockbot.yaml", "flockbot_group_sensor.yaml", "smars.yaml", "lta.yaml"] {
        std::fs::copy(from.join(name), to.join(name)).with_context(|| name.to_owned())?;
    }
    Ok(())
}

fn flockbots<'a>(name: &'a str, axes: &'a str) -> Wanted<'a> {
    let (duration_s, seed) = (300, 1);
    Wanted { name, profile: "flockbot", harsher: "{}", axes, fixed: FIXED, duration_s, seed }
}

/// Sweeps whose recommendation is asked for.
pub const SEEDS: u64 = 10;

fn recommended(
    program: &Program,
    work: &Path,
    plane: &Wanted,
) -> anyhow::Result<Vec<Option<(f64, f64)>>> {
    let choose = |seed: u64| {
        let name = format!("seed_{seed}");
        sweep(program, work, &Wanted { name: &name, seed, ..*plane })?;
        let cell = program.run(&format!("choose {name} --format json"))?.json["cell"].take();
        Ok(cell["speed_m_s"].as_f64().zip(cell["turn_rate_rad_s"].as_f64()))
    };
    (1..=SEEDS).map(choose).collect()
}

fn experiment(
    program: &Program,
    (work, number): (&Path, u64),
    (measured, setting): (&RobotProfile, (f64, f64)),
    plane: &PhaseDiagram,
) -> anyhow::Result<Experiment> {
    let conditions = conditions(measured, 9, setting)?;
    let name = format!("experiment_{number}");
    let seed = Seed { seed: number, replicate: 0 };
    experiments::record(&work.join(&name), (measured, &conditions), seed)?;
    let labels = program.run(&format!("label {name} --format json"))?.json;
    let key = labels[0]["phase"].as_str().context("a phase in what label reported")?;
    let values = [(Axis::Speed, setting.0), (Axis::TurnRate, setting.1)];
    Ok(Experiment {
        setting,
        phase: Phase::from_key(key).context("a phase in what label reported")?,
        simulated: swept::counts(plane, &values),
        repeated: experiments::repeat(&conditions, REPETITIONS as u64)?,
    })
}

/// The repetitions with these numbers, cell by cell.
fn runs(experiments: &[Experiment], chosen: std::ops::Range<usize>) -> Vec<CellRuns> {
    let of = |experiment: &Experiment| CellRuns {
        cell: cell(experiment.setting),
        real: experiments::counted(&experiment.repeated[chosen.clone()]),
        simulated: experiment.simulated,
    };
    experiments.iter().map(of).collect()
}

/// The tally of every nine experiments with the same number.
fn tallies(experiments: &[Experiment]) -> Vec<Tally> {
    let campaigns = 0..REPETITIONS;
    campaigns.map(|number| Comparison::of(&runs(experiments, number..number + 1)).tally).collect()
}

/// The first of the nine experiments again, to be drawn.
fn mill(measured: &RobotProfile) -> anyhow::Result<(Trajectory, Evidence)> {
    let conditions = conditions(measured, 9, nine()[0])?;
    let trajectory = experiments::watch(&conditions, Seed { seed: 1, replicate: 0 })?;
    let verdict = label(&trajectory, &conditions.bodies())?;
    Ok((trajectory, verdict.evidence))
}

/// Contacts per robot and second from which on robots bump into each other continuously: once in
/// 50 s.
pub const CONTINUOUSLY_PER_S: f64 = 0.02;

/// Looks for contacts in the semi-stable runs of simulated robots that turn as fast as the paper's, at
/// all speeds.
fn bumping(measured: &RobotProfile) -> anyhow::Result<(u64, u64)> {
    let harsher = HarsherFactors::for_robot(measured).apply(measured)?;
    let (mut n_bumping, mut n) = (0, 0);
    for speed_m_s in [0.10, 0.15, 0.20, 0.25, 0.30] {
        let conditions = conditions(&harsher, 9, (speed_m_s, 0.75))?;
        for replicate in 0..40 {
            let episode = run_episode(&conditions, Seed { seed: 1, replicate }, DURATION_S)?;
            let verdict = label(&episode, &conditions.bodies())?;
            if verdict.phase == Phase::SemiStableMilling {
                n += 1;
                let onsets = verdict.evidence.contact_onsets_per_s.unwrap_or(0.0);
                n_bumping += u64::from(onsets >= CONTINUOUSLY_PER_S);
            }
        }
    }
    Ok((n_bumping, n))
}

fn varied(program: &Program, work: &Path) -> anyhow::Result<Vec<Varied>> {
    let others = |without: &str| {
        let all = [
            ("speed_m_s", 0.15),
            ("turn_rate_rad_s", 0.75),
            ("robots", 9.0),
            ("placement_radius_m", PLACEMENT_RADIUS_M),
            ("arena_m", ARENA_M),
        ];
        let kept: Vec<String> = all
            .iter()
            .filter(|(name, _)| *name != without)
            .map(|(name, value)| format!("{name}: {value}"))
            .collect();
        format!("{{{}, walls: stop}}", kept.join(", "))
    };
    let wanted = [
        (Axis::Robots, "[3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14]"),
        (Axis::Range, "[0.30, 0.45, 0.60, 0.75, 0.90, 1.20]"),
        (Axis::TruePositive, "[0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]"),
        (Axis::FalsePositive, "[0, 0.04, 0.08, 0.12, 0.16, 0.20, 0.30]"),
        (Axis::Heterogeneity, "[0, 0.02, 0.05, 0.10, 0.15, 0.20]"),
        (Axis::PlacementRadius, "[0.40, 0.60, 0.825, 1.2, 1.6, 2.5]"),
    ];
    let run = |(axis, values): (Axis, &str)| {
        let axes = format!("{{{}: {values}}}", axis.key());
        let fixed = others(axis.key());
        let wanted = Wanted { fixed: &fixed, ..flockbots(axis.key(), &axes) };
        Ok(Varied { axis, diagram: sweep(program, work, &wanted)? })
    };
    wanted.into_iter().map(run).collect()
}

/// A robot of the paper that could not mill, and where it is looked for a mill.
struct Candidate {
    name: &'static str,
    axes: &'static str,
    arena_m: u32,
}

const SMARS: Candidate = Candidate {
    name: "smars",
    axes: "{speed_m_s: {from: 0.05, to: 0.15, steps: 5}, \
            turn_rate_rad_s: {from: 0.5, to: 1.0, steps: 3}}",
    arena_m: 15,
};

const LTA: Candidate = Candidate {
    name: "lta",
    axes: "{speed_m_s: {from: 0.2, to: 0.4, steps: 5}, \
            turn_rate_rad_s: {from: 0.3, to: 0.6, steps: 3}}",
    arena_m: 60,
};

fn hopeless(program: &Program, work: &Path, robot: &Candidate) -> anyhow::Result<Hopeless> {
    Ok(Hopeless {
        name: robot.name,
        harsher: search(program, work, (robot, "{}"))?,
        measured: search(program, work, (robot, "none"))?,
    })
}

/// Looks for a mill with several numbers of robots.
fn search(
    program: &Program,
    work: &Path,
    (robot, harsher): (&Candidate, &str),
) -> anyhow::Result<Vec<Searched>> {
    let search = |robots: u32| {
        let &Candidate { name: profile, axes, arena_m } = robot;
        let kind = if harsher == "none" { "measured" } else { "harsher" };
        let name = format!("{profile}_{kind}_{robots}");
        let fixed = format!("{{robots: {robots}, arena_m: {arena_m}, walls: stop}}");
        let wanted = Wanted { profile, harsher, fixed: &fixed, ..flockbots(&name, axes) };
        let diagram = sweep(program, work, &wanted)?;
        let chosen = program.run(&format!("choose {name} --format json"))?;
        let reason = chosen.json["reason"].as_str().map(str::to_owned);
        let factors = chosen.json["factors"].clone();
        Ok(Searched { robots, reason: reason.filter(|_| chosen.code != 0), diagram, factors })
    };
    [4, 6, 9, 12].into_iter().map(search).collect()
}

impl Hopeless {
    /// The search with the cell that mills most, made harsher; of equals that which mills most as
    /// measured.
    ///
    /// # Returns
    ///
    /// The search, the cell, and its shares made harsher and as measured.
    pub fn best(&self) -> (&Searched, &Cell, [f64; 2]) {
        let share = |entry: &DiagramCell| entry.counts.share(Phase::StableMilling);
        let all = self.harsher.iter().zip(&self.measured).flat_map(|(harsher, measured)| {
            let cells = harsher.diagram.cells.iter().zip(&measured.diagram.cells);
            cells.map(move |(harsh, mild)| (harsher, &harsh.cell, [harsh, mild].map(share)))
        });
        // The first of equals, as `rsrs choose` has it.
        all.rev()
            .max_by(|one, other| one.2.partial_cmp(&other.2).expect("shares are numbers"))
            .expect("a sweep has cells")
    }

    /// Whether any cell is viable, made harsher.
    pub fn is_viable(&self) -> bool {
        self.harsher.iter().any(|searched| searched.reason.is_none())
    }

    /// Cells that were searched, made harsher.
    pub fn n_cells(&self) -> usize {
        self.harsher.iter().map(|searched| searched.diagram.cells.len()).sum()
    }
}
