//! Contact sheets of the episodes in which stable milling is hardest to distinguish from anything
//! else, for people to label by eye, without the judge's answer.
//!
//! `cargo run -p rsrs_view --example borderline -- DIR` simulates the default plane in both worlds,
//! picks 100 episodes around the line between stable milling and the rest, and writes into `DIR`:
//! `pass_1/sheet_00.png` and on, the same in another order under `pass_2`, `key.csv` (which episode
//! is on which row of which sheet) and `episodes.csv` (the order parameters of the whole window, its
//! halves, thirds and sixths). A row of a sheet is one episode: its last 60 s in six pictures of
//! 10 s each, robots where they end, and all at one scale.
//!
//! Labels go into a table beside `docs/judge_by_eye.csv`; `-- agree DIR LABELS.csv` then prints how
//! many of them each rule meets.

#![expect(clippy::print_stdout, reason = "counts for people")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "pixels and indices are small"
)]

mod rules;
mod sheet;

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;

use rules::{Judged, Side};

const SEED: u64 = 1001;
const REPLICATES: u64 = 16;
const DURATION_S: f64 = 300.0;
/// Episodes on which two rules differ, and those on each side of the line on which they agree.
const PICKED: [(Side, usize); 3] = [(Side::Disputed, 50), (Side::Stable, 25), (Side::Other, 25)];

/// One episode: which world, cell and replicate.
#[derive(Clone, Copy, Debug)]
struct Episode {
    world: usize,
    cell: usize,
    replicate: u64,
}

const WORLDS: [&str; 2] = ["harsher", "as_measured"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["agree", folder, labels] => rules::agree(Path::new(folder), Path::new(labels)),
        [folder] => draw(Path::new(folder)),
        _ => Err("usage: borderline DIR, or borderline agree DIR LABELS.csv".into()),
    }
}

fn draw(folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let planes = planes()?;
    let judged = judge_all(&planes);
    let picked = pick(&judged);
    fs::create_dir_all(folder)?;
    fs::write(folder.join("episodes.csv"), rules::table(&picked))?;
    let mut key = "pass,sheet,row,episode\n".to_owned();
    for pass in 1..=2_u64 {
        let into = folder.join(format!("pass_{pass}"));
        fs::create_dir_all(&into)?;
        for (sheet, rows) in shuffled(picked.len(), pass).chunks(sheet::ROWS).enumerate() {
            let episodes: Vec<_> =
                rows.iter().map(|row| trajectory(&planes, picked[*row].episode)).collect();
            let svg = sheet::svg(&episodes, sheet);
            let png = rsrs_view::raster::png(&svg, sheet::WIDTH_PX as u32)?;
            fs::write(into.join(format!("sheet_{sheet:02}.png")), png)?;
            for (row, episode) in rows.iter().enumerate() {
                writeln!(key, "{pass},{sheet},{row},{episode}")?;
            }
        }
    }
    fs::write(folder.join("key.csv"), key)?;
    Ok(())
}

/// The default plane in both worlds.
fn planes() -> Result<[Vec<Conditions>; 2], Box<dyn std::error::Error>> {
    let sweep = SweepFile::parse(
        "flockbot_speed_turn.yaml",
        include_str!("../../../../launch_configs/sweeps/flockbot_speed_turn.yaml"),
    )?;
    let profile = RobotProfile::parse("flockbot.yaml", rsrs_testing::conditions::FLOCKBOT)?;
    let measured = SweepFile { harsher: Harsher::from(HarsherFactors::NONE), ..sweep.clone() };
    let plane = |sweep: &SweepFile| -> Result<Vec<Conditions>, Box<dyn std::error::Error>> {
        let cells = sweep.resolve("flockbot_speed_turn.yaml", &profile)?;
        Ok(cells.into_iter().map(|(_, conditions)| conditions).collect())
    };
    Ok([plane(&sweep)?, plane(&measured)?])
}

fn trajectory(planes: &[Vec<Conditions>; 2], episode: Episode) -> (Trajectory, Conditions) {
    let conditions = planes[episode.world][episode.cell].clone();
    let seed = Seed { seed: SEED, replicate: episode.replicate };
    let trajectory = run_episode(&conditions, seed, DURATION_S).expect("the robots fit");
    (trajectory, conditions)
}

fn judge_all(planes: &[Vec<Conditions>; 2]) -> Vec<Judged> {
    let mut episodes = Vec::new();
    for (world, plane) in planes.iter().enumerate() {
        for cell in 0..plane.len() {
            episodes.extend((0..REPLICATES).map(|replicate| Episode { world, cell, replicate }));
        }
    }
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(episode) = episodes.get(next.fetch_add(1, Ordering::Relaxed)) {
            let (trajectory, conditions) = trajectory(planes, *episode);
            let judged = Judged::new(*episode, &trajectory, &conditions.bodies());
            found.lock().expect("nobody panics with it").push(judged);
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        scope.spawn(work);
    });
    let mut found = found.into_inner().expect("nobody panics with it");
    found.sort_by_key(|judged| {
        (judged.episode.world, judged.episode.cell, judged.episode.replicate)
    });
    found
}

/// Of each group the episodes next to the line.
fn pick(judged: &[Judged]) -> Vec<Judged> {
    let mut picked = Vec::new();
    for (side, n) in PICKED {
        let mut group: Vec<Judged> =
            judged.iter().filter(|judged| judged.side() == Some(side)).cloned().collect();
        group.sort_by(|one, other| one.off_line().total_cmp(&other.off_line()));
        println!("{side:?}: {} of {} episodes", n.min(group.len()), group.len());
        picked.extend(group.into_iter().take(n));
    }
    picked
}

/// So many indices in an order that follows from the pass.
fn shuffled(n: usize, pass: u64) -> Vec<usize> {
    let mut state = pass.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut order: Vec<usize> = (0..n).collect();
    for last in (1..n).rev() {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(last, (state >> 33) as usize % (last + 1));
    }
    order
}
