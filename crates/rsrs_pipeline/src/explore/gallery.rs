//! The gallery: what was found, confirmed on fresh seeds, drawn, and ready to be swept.

use std::path::PathBuf;

use anyhow::Context;
use rsrs_core::conditions::Walls;
use rsrs_core::diagram::sweep_file::{Axes, Fixed, SweepFile};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::quantity::{Axis, AxisValues};
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::robot::harsher::Harsher;
use rsrs_core::statistics::share::Share;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_sim::sweep::confirmation_seed;
use rsrs_view::page::Page;
use rsrs_view::theme::Theme;
use rsrs_view::trajectory::TrajectoryPicture;

use super::folder::{Folder, PROFILE};
use super::trial::{self, Elsewhere, Laboratory, Name, Trial};
use super::{CONFIRM, Explored, FoundController, Options};
use crate::files::write_file;
use crate::wording::percent;

/// Pictures of a gallery at most.
const MOST: usize = 24;
const COLUMNS: usize = 4;
/// Width of `gallery.png`, in pixels.
const WIDTH_PX: u32 = 1600;
/// How much of a run is drawn strongly, in seconds.
const TAIL_S: f64 = 30.0;
/// Folder of the sweeps.
const SWEEPS: &str = "sweeps";

/// Confirms what was found, and writes pictures and sweeps.
///
/// # Errors
///
/// If a file cannot be written, or it is called off.
pub fn write(
    laboratory: &Laboratory,
    site: &Folder,
    trials: Vec<Trial>,
    options: &Options,
) -> anyhow::Result<Explored> {
    let n_controllers = site.journal.len().min(options.controllers);
    let seed = confirmation_seed(options.seed);
    let mut confirmed = Vec::new();
    for trial in trials {
        confirmed.push(confirm(laboratory, trial, seed, options)?);
    }
    // What has a name comes first, and of one name the surest.
    confirmed.sort_by(|one, other| {
        one.trial.name.cmp(&other.trial.name).then(other.share.hits.cmp(&one.share.hits))
    });
    confirmed.truncate(MOST);
    let folder = site.path.join(SWEEPS);
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make {}", folder.display()))?;
    let (mut trials, mut found, mut runs) = (Vec::new(), Vec::new(), Vec::new());
    for (index, Confirmed { trial, share, shown }) in confirmed.into_iter().enumerate() {
        let elsewhere = laboratory.elsewhere(&trial, seed, options)?;
        let mut entry = describe(&trial, share, elsewhere);
        if let Name::Behaviour(behaviour) = trial.name {
            let name = format!("{:02}_{}.yaml", index + 1, trial.name.key());
            let sweep = PathBuf::from(SWEEPS).join(name);
            let text = sweep_text(laboratory, (&trial, behaviour), &entry, options)?;
            write_file(&site.path.join(&sweep), text.as_bytes())?;
            entry.sweep = Some(sweep);
        }
        let seed = Seed { seed, replicate: shown.unwrap_or(0) };
        runs.push(run_episode(&laboratory.judged_for(&trial)?, seed, options.duration_s)?);
        found.push(entry);
        trials.push(trial);
    }
    let gallery = Gallery { trials: &trials, found: &found, runs: &runs };
    draw(laboratory, site, &gallery, options)?;
    Ok(Explored {
        folder: site.path.clone(),
        robot: laboratory.robot.clone(),
        wanted: options.wanted,
        n_controllers,
        found,
    })
}

/// A controller with what fresh runs show.
struct Confirmed {
    trial: Trial,
    share: Share,
    /// The first of the fresh runs that shows it.
    shown: Option<u64>,
}

/// Runs a controller on fresh seeds. One that does what it was called in less than half of them is
/// called by its niche, unless that is what was searched for.
fn confirm(
    laboratory: &Laboratory,
    mut trial: Trial,
    seed: u64,
    options: &Options,
) -> anyhow::Result<Confirmed> {
    let (mut share, mut shown) = laboratory.confirm(&trial, (seed, CONFIRM), options)?;
    if share.value() < trial::MOST && trial.name != Name::Other && options.wanted.is_none() {
        trial.name = Name::Other;
        (share, shown) = laboratory.confirm(&trial, (seed, CONFIRM), options)?;
    }
    Ok(Confirmed { trial, share, shown })
}

fn describe(trial: &Trial, share: Share, elsewhere: Elsewhere) -> FoundController {
    let Elsewhere { as_measured, contact, with_contact } = elsewhere;
    let interval = share.interval();
    FoundController {
        name: trial.name.key().to_owned(),
        words: trial.niche.in_words(),
        niche: trial.niche,
        controller: trial.controller,
        number: trial.number,
        share: share.value(),
        share_low: interval.low,
        share_high: interval.high,
        n_replicates: share.n,
        share_as_measured: as_measured.value(),
        other_contact: contact,
        share_with_other_contact: with_contact.value(),
        needs_contact: share.value() >= trial::MOST && with_contact.value() < trial::MOST,
        sweep: None,
    }
}

/// A sweep around a controller: two of its numbers, the others fixed.
fn sweep_text(
    laboratory: &Laboratory,
    (trial, behaviour): (&Trial, Behaviour),
    found: &FoundController,
    options: &Options,
) -> anyhow::Result<String> {
    let (axes, mut values) = axes(laboratory, trial.controller);
    values.push((Axis::Robots, options.robots as f64));
    values.push((Axis::Arena, laboratory.arena_m));
    values.extend(laboratory.placement_m.map(|radius_m| (Axis::PlacementRadius, radius_m)));
    let sweep = SweepFile {
        profile: format!("../{PROFILE}"),
        controller: None,
        harsher: Harsher::default(),
        behaviour,
        axes,
        fixed: Fixed { values, walls: options.walls },
        placement: None,
        cells: None,
        replicates: 100,
        duration_s: options.duration_s,
        seed: 1,
        adaptive: None,
    }
    .within_wheels(laboratory.robots());
    let yaml = serde_saphyr::to_string(&sweep).context("the sweep as YAML")?;
    let FoundController { words, share, n_replicates, .. } = found;
    Ok(format!(
        "# Around a controller that was found by `rsrs explore`: {words}, in {} of {n_replicates} runs.\n\
         {yaml}",
        percent(*share)
    ))
}

/// The two numbers of a controller that are swept, around their values, and the others.
fn axes(laboratory: &Laboratory, controller: ControllerParameters) -> (Axes, Vec<(Axis, f64)>) {
    let mut values = rsrs_core::conditions::operator::controller_values(&controller.into());
    // Where nothing is detected is where robots are most of the time.
    values.sort_by_key(|(axis, _)| match axis {
        Axis::UndetectedSpeed => 0,
        Axis::UndetectedTurnRate => 1,
        Axis::Speed => 2,
        _ => 3,
    });
    let (moving, standing): (Vec<_>, Vec<_>) =
        values.into_iter().partition(|(_, value)| *value != 0.0);
    let (swept, kept) = moving.split_at(moving.len().min(2));
    let around = |(axis, value): &(Axis, f64)| {
        let [least, most] = match axis {
            Axis::Speed | Axis::UndetectedSpeed => laboratory.space.speed_m_s,
            _ => laboratory.space.turn_rate_rad_s,
        };
        let amount = |factor: f64| ((value.abs() * factor).clamp(least, most) * 1e3).round() / 1e3;
        let mut near: Vec<f64> =
            [0.6, 0.8, 1.2, 1.4].map(|factor| amount(factor).copysign(*value)).to_vec();
        near.push(*value);
        near.sort_by(f64::total_cmp);
        near.dedup();
        (*axis, AxisValues(near))
    };
    let swept = Axes(swept.iter().map(around).collect());
    (swept, kept.iter().copied().chain(standing).collect())
}

/// What is shown: controllers, what fresh runs of them show, and one of these runs each.
struct Gallery<'a> {
    trials: &'a [Trial],
    found: &'a [FoundController],
    runs: &'a [Trajectory],
}

/// Draws one run of each, as `gallery.svg`, `gallery.png` and `gallery.html`.
fn draw(
    laboratory: &Laboratory,
    site: &Folder,
    gallery: &Gallery,
    options: &Options,
) -> anyhow::Result<()> {
    let Gallery { trials, found, runs } = *gallery;
    let walls = if options.walls == Walls::None { "without walls" } else { "with walls" };
    let title = format!(
        "What {} robots of kind {} can do in {} m, {walls}",
        options.robots, laboratory.robot, laboratory.arena_m
    );
    let pictures: Vec<TrajectoryPicture> = trials
        .iter()
        .zip(found)
        .zip(runs)
        .enumerate()
        .map(|(index, ((trial, found), trajectory))| TrajectoryPicture {
            trajectory,
            radius_m: laboratory.radius_m(),
            tail_s: TAIL_S,
            phase: match trial.name {
                Name::Behaviour(behaviour) => Some(behaviour.wanted()),
                Name::WallFollowing | Name::Other => None,
            },
            lost: &[],
            names: &[],
            walls_m: (options.walls != Walls::None).then_some(laboratory.arena_m / 2.0),
            title: format!("{}: {}", index + 1, found.name.replace('_', " ")),
            subtitle: format!("{} of runs; {}", percent(found.share), found.words),
            theme: Theme::Screen,
        })
        .collect();
    let svg = rsrs_view::gallery::svg(&title, &pictures, COLUMNS)?;
    write_file(&site.path.join("gallery.svg"), svg.as_bytes())?;
    let png = rsrs_view::raster::png(&svg, WIDTH_PX)?;
    write_file(&site.path.join("gallery.png"), &png)?;
    let mut page = Page::new(&title);
    page.paragraph(
        "Each picture is one simulated run of a controller that was found: pale where robots were, \
         strong where they were in the last 30 s. The share is that of fresh runs that show the same.",
    );
    let mut figures = Vec::new();
    for (picture, found) in pictures.iter().zip(found) {
        let svg = rsrs_view::trajectory::svg(picture)?;
        figures.push((svg, super::text::caption(found, &site.path)));
    }
    page.figures(&figures);
    write_file(&site.path.join("gallery.html"), page.finish().as_bytes())
}
