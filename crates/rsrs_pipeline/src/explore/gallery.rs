//! The gallery: what was found, confirmed on fresh seeds, and ready to be swept.

use std::path::PathBuf;

use rsrs_core::conditions::controller_table::ControllerSource;
use rsrs_core::diagram::sweep_file::{Axes, Fixed, SweepFile};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::behaviour::named::NamedBehaviour;
use rsrs_core::numerals::percent;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::harsher::Harsher;
use rsrs_core::world::WorldSource;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_sim::sweep::confirmation_seed;

use super::file_names::{CONTROLLER, PROFILE, STARTS, WORLD};
use super::folder::Folder;
use super::settings::in_folder;
use super::trial::{self, Elsewhere, Name, Shown, TestBed, Trial};
use super::{CONFIRM, ExploreOptions, Explored, FoundController, ShownRun};
use crate::files::{make_folder, write_file};

/// Controllers of a gallery at most.
const MOST: usize = 24;
const SWEEPS: &str = "sweeps";

/// Confirms what was found, and writes sweeps.
pub fn write(
    test_bed: &TestBed,
    open_folder: &Folder,
    trials: Vec<Trial>,
    options: &ExploreOptions,
) -> anyhow::Result<Explored> {
    let n_controllers = open_folder.journal.len().min(options.controllers);
    let seed = confirmation_seed(options.seed);
    let mut confirmed = Vec::new();
    for trial in trials {
        confirmed.push(confirm(test_bed, trial, seed, options)?);
    }
    // What fewer than half of the fresh runs show is nothing to go by, unless it was searched for.
    confirmed
        .retain(|it: &Confirmed| options.wanted.is_some() || it.shown.share.value() >= trial::MOST);
    // What has a name comes first, and of one name the surest.
    confirmed.sort_by(|one, other| {
        one.trial
            .name
            .cmp(&other.trial.name)
            .then(other.shown.share.hits.cmp(&one.shown.share.hits))
    });
    confirmed.truncate(MOST);
    let folder = open_folder.path.join(SWEEPS);
    make_folder(&folder)?;
    let (mut found, mut runs) = (Vec::new(), Vec::new());
    for (index, Confirmed { trial, shown }) in confirmed.into_iter().enumerate() {
        let elsewhere = test_bed.elsewhere(&trial, seed, options)?;
        let mut entry = describe(&trial, &shown, elsewhere);
        let mut phase = None;
        if let Name::Behaviour(behaviour) = trial.name {
            let name = format!("{:02}_{}.yaml", index + 1, trial.name.key());
            let sweep = PathBuf::from(SWEEPS).join(name);
            let text = sweep_text(test_bed, (&trial, behaviour), &entry, options);
            write_file(&open_folder.path.join(&sweep), text.as_bytes())?;
            entry.sweep = Some(sweep);
            phase = Some(behaviour.wanted());
        }
        let seed = Seed { seed, replicate: shown.first.unwrap_or(0) };
        let conditions = test_bed.judged_for(&trial)?;
        runs.push(ShownRun {
            trajectory: run_episode(&conditions, seed, options.duration_s)?,
            phase,
        });
        found.push(entry);
    }
    Ok(Explored {
        folder: open_folder.path.clone(),
        robot: test_bed.robot.clone(),
        wanted: options.wanted,
        n_controllers,
        found,
        runs,
        robots: options.robots,
        radius_m: test_bed.radius_m(),
        arena_m: test_bed.arena_m,
        walls: options.walls,
        world: options.world.cloned().unwrap_or_default(),
    })
}

/// A controller with what fresh runs show.
struct Confirmed {
    trial: Trial,
    shown: Shown,
}

/// Runs a controller on fresh seeds. One that does what it was called in less than half of them is
/// called by its niche, unless that is what was searched for.
fn confirm(
    test_bed: &TestBed,
    mut trial: Trial,
    seed: u64,
    options: &ExploreOptions,
) -> anyhow::Result<Confirmed> {
    let mut shown = test_bed.confirm(&trial, (seed, CONFIRM), options)?;
    if shown.share.value() < trial::MOST && trial.name != Name::Other && options.wanted.is_none() {
        trial.name = Name::Other;
        shown = test_bed.confirm(&trial, (seed, CONFIRM), options)?;
    }
    Ok(Confirmed { trial, shown })
}

fn describe(trial: &Trial, shown: &Shown, elsewhere: Elsewhere) -> FoundController {
    let Elsewhere { as_measured, contact, with_contact } = elsewhere;
    let share = shown.share;
    let interval = share.interval();
    FoundController {
        name: trial.name.key().to_owned(),
        brown_class: trial.name.brown_class(),
        words: trial.niche.in_words(),
        order_parameters: shown.means.iter().map(|(it, mean)| (it.key(), *mean)).collect(),
        niche: trial.niche,
        controller: trial.controller.clone(),
        number: trial.number,
        share: share.value(),
        share_low: interval.low,
        share_high: interval.high,
        n_replicates: share.n,
        share_as_measured: as_measured.value(),
        other_contact: contact,
        share_with_other_contact: with_contact.value(),
        needs_contact: interval.low > with_contact.interval().high,
        sweep: None,
    }
}

/// A sweep around a controller: two of its numbers, the others fixed.
fn sweep_text(
    test_bed: &TestBed,
    (trial, behaviour): (&Trial, Behaviour),
    found: &FoundController,
    options: &ExploreOptions,
) -> String {
    let (axes, mut values) = axes(test_bed, trial);
    values.push((Axis::Robots, options.robots as f64));
    if options.world.is_none_or(|world| world.arena.is_none()) {
        values.push((Axis::Arena, test_bed.arena_m));
    }
    if options.starts.is_none() {
        values.push((Axis::PlacementRadius, test_bed.placement_m));
    }
    let sweep = SweepFile {
        profile: format!("../{PROFILE}"),
        controller: test_bed
            .space
            .table()
            .map(|_| ControllerSource::File(format!("../{CONTROLLER}"))),
        harsher: Harsher::default(),
        behaviour: NamedBehaviour::Known(behaviour),
        axes,
        fixed: Fixed { values, walls: options.walls },
        placement: options.starts.map(|_| in_folder(format!("../{STARTS}"))),
        world: options.world.cloned().map(WorldSource::Read),
        cells: None,
        replicates: 100,
        duration_s: options.duration_s,
        seed: 1,
        adaptive: None,
    }
    .within_wheels(test_bed.robots());
    let world = options.world.map(|_| WorldSource::File(format!("../{WORLD}")));
    let sweep = SweepFile { world, ..sweep };
    let yaml = sweep.to_yaml();
    // The values of axes are fractions in files, and a person writes no fraction of a robot.
    let [fraction, whole] = [
        format!("{}: {:.1}\n", Axis::Robots, options.robots as f64),
        format!("{}: {}\n", Axis::Robots, options.robots),
    ];
    let yaml = yaml.replacen(&fraction, &whole, 1);
    let FoundController { words, share, n_replicates, .. } = found;
    format!(
        "# Around a controller that was found by `rsrs explore`: {words}, in {} of {n_replicates} runs.\n\
         {yaml}",
        percent(*share)
    )
}

/// The two numbers of a controller that are swept, around their values, and the others.
fn axes(test_bed: &TestBed, trial: &Trial) -> (Axes, Vec<(Axis, f64)>) {
    let mut values = test_bed.values(&trial.point);
    // Where nothing is detected is where robots are most of the time.
    values.sort_by_key(|(axis, _)| match axis {
        Axis::UndetectedSpeed => 0,
        Axis::UndetectedTurnRate => 1,
        Axis::Speed => 2,
        _ => 3,
    });
    let is_swept = |(axis, value): &(Axis, f64)| matches!(axis, Axis::Number(_)) || *value != 0.0;
    let (moving, standing): (Vec<_>, Vec<_>) = values.into_iter().partition(is_swept);
    let (swept, kept) = moving.split_at(moving.len().min(2));
    let around = |(axis, value): &(Axis, f64)| (*axis, test_bed.space.around(*axis, *value));
    let swept = Axes(swept.iter().map(around).collect());
    (swept, kept.iter().copied().chain(standing).collect())
}
