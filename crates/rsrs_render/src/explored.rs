//! Controllers that were found, in words and as a gallery.

use std::path::{Path, PathBuf};

use rsrs_core::conditions::Walls;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::order::Parameter;
use rsrs_core::numerals::percent;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Controller;
use rsrs_core::world::ArenaShape;
use rsrs_files::quoted;
use rsrs_pipeline::explore::{Explored, FoundController};
use rsrs_pipeline::files::write_file;
use rsrs_view::page::Page;
use rsrs_view::theme::Theme;
use rsrs_view::trajectory::TrajectoryPicture;

use crate::wording::shell::free;
use crate::words::{Tone, Words};

const COLUMNS: usize = 4;
/// Width of `gallery.png`, in pixels.
const WIDTH_PX: u32 = 1600;
/// How much of a run is drawn strongly, in seconds.
const TAIL_S: f64 = 30.0;

/// What was found, and where it is.
pub fn text(explored: &Explored) -> Words {
    let Explored { robot, n_controllers, wanted, found, folder, .. } = explored;
    let mut words = Words::from(format!("{robot}: {n_controllers} controllers were tried"));
    for (number, found) in (1..).zip(found) {
        words = words.below(format!("\n{number:>3}. {}", line(found)));
        for line in [order_parameters(found), elsewhere(found)].iter().filter(|it| !it.is_empty()) {
            words = words.below(format!("     {line}"));
        }
        for line in commands(found) {
            words = words.below(format!("     {line}"));
        }
        let sweep = found.sweep.as_ref().map(|sweep| folder.join(sweep).display().to_string());
        words = words.below(format!("     {}", sweep.unwrap_or_else(no_sweep)));
    }
    if let Some(wanted) = wanted.filter(|_| !explored.is_found()) {
        let wanted = wanted.key().replace('_', " ");
        let none = format!("no controller surely leads to {wanted}");
        words = words.below("\n").then_toned(Tone::Bad, none).then(" in half of its runs");
    }
    words = words.below(format!("\npictures: {}", folder.join("gallery.html").display()));
    if wanted.is_some() && found.iter().all(|found| found.share <= 0.0) {
        let more = 5 * n_controllers;
        return words.below(format!(
            "next: the same command with `--controllers {more}`, which goes on from here"
        ));
    }
    if let Some(first) = found.iter().find_map(|found| found.sweep.as_ref()) {
        let sweep = folder.join(first);
        let results = free(results_of(&sweep));
        words = words.below(format!("next: {}", sweep_command(&sweep, &results)));
    }
    words
}

/// `milling (cyclic pursuit)`, and what it looks like where it has no name; what it comes nearest to, where none of its
/// runs shows that.
fn heading(found: &FoundController) -> String {
    let FoundController { name, brown_class, words, .. } = found;
    let name = name.replace('_', " ");
    if found.share <= 0.0 {
        return format!("nearest to {name}");
    }
    match brown_class.map(|class| class.replace('_', " ")) {
        _ if name == "other" => words.clone(),
        Some(class) if class != name => format!("{name} ({class})"),
        _ => name,
    }
}

/// `milling (cyclic pursuit): 98 % of 200 fresh runs (95 % interval 95 % to 99 %); circling, within ...`.
fn line(found: &FoundController) -> String {
    let FoundController { name, words, share, share_low, share_high, n_replicates, .. } = found;
    let line = format!(
        "{}: {} of {n_replicates} fresh runs (95 % interval {} to {})",
        heading(found),
        percent(*share),
        percent(*share_low),
        percent(*share_high)
    );
    if name == "other" { line } else { format!("{line}; {words}") }
}

/// Those that tell most about what it looks like, on average over the runs that show it:
/// `rotation 0.93, circliness 0.85, mean radius 0.71 m, clustered 0.22, blocked 0.01`.
fn order_parameters(found: &FoundController) -> String {
    let shown = ["rotation", "circliness", "mean_radius_m", "clustered", "blocked"];
    let value = |key: &str| {
        let value = Parameter::from_key(key)?.with_unit(*found.order_parameters.get(key)?);
        Some(format!("{} {value}", key.trim_end_matches("_m").replace('_', " ")))
    };
    shown.into_iter().filter_map(value).collect::<Vec<_>>().join(", ")
}

/// Its order parameters; in words, where no run shows it.
fn looks(found: &FoundController) -> String {
    let numbers = order_parameters(found);
    if numbers.is_empty() { found.words.clone() } else { numbers }
}

/// `as measured 96 %; with robots that push each other 12 %, surely fewer`.
fn elsewhere(found: &FoundController) -> String {
    let FoundController { share_as_measured, other_contact, share_with_other_contact, .. } = found;
    let touching = |contact| match contact {
        ContactModel::Stop => "stop each other",
        ContactModel::Push => "push each other",
        ContactModel::None => "pass through each other",
    };
    let needs = if found.needs_contact { ", surely fewer" } else { "" };
    format!(
        "as measured {}; with robots that {} {}{needs}",
        percent(*share_as_measured),
        touching(*other_contact),
        percent(*share_with_other_contact)
    )
}

/// The two commands, or the numbers of a table.
fn commands(found: &FoundController) -> Vec<String> {
    let parameters = match &found.controller {
        Controller::Parameters(parameters) => parameters,
        Controller::Machine(machine) => {
            return machine
                .numbers
                .iter()
                .map(|(name, value)| format!("{name}: {value}"))
                .collect();
        }
    };
    let [detected, undetected] = parameters.commands();
    vec![
        format!("something is detected: {detected}"),
        format!("nothing is detected:   {undetected}"),
    ]
}

/// Where the sweep around a controller goes: a folder of its own.
fn results_of(sweep: &Path) -> PathBuf {
    let name = sweep.file_stem().unwrap_or_default().display().to_string();
    PathBuf::from(format!("results_{name}"))
}

fn sweep_command(sweep: &Path, results: &Path) -> String {
    format!("rsrs sweep {} -o {}", quoted(sweep), quoted(results))
}

/// Why what was found has no sweep.
fn no_sweep() -> String {
    let behaviours = Behaviour::BUILT_IN.map(Behaviour::key).join(", ");
    format!("no sweep: runs are judged for {behaviours}, and this is not one of them")
}

/// Draws one run of each controller, as `gallery.svg`, `gallery.png` and `gallery.html` in the folder of the
/// search.
pub fn draw(explored: &Explored) -> anyhow::Result<()> {
    let Explored { folder, found, walls, arena_m, .. } = explored;
    let has_walls = *walls != Walls::None;
    let title = format!(
        "What {} robots of kind {} can do in {}, {} walls",
        explored.robots,
        explored.robot,
        explored.world.arena.as_ref().map_or_else(|| format!("{arena_m} m"), ArenaShape::in_words),
        if has_walls { "with" } else { "without" }
    );
    let n_robots = explored.runs.first().map_or(0, |run| run.trajectory.n_robots);
    let classes = explored.world.classes_of(n_robots);
    let pictures: Vec<TrajectoryPicture> = (1..)
        .zip(found.iter().zip(&explored.runs))
        .map(|(number, (found, run))| TrajectoryPicture {
            trajectory: &run.trajectory,
            radius_m: explored.radius_m,
            tail_s: TAIL_S,
            phase: run.phase,
            lost: &[],
            names: &[],
            walls_m: has_walls.then_some(arena_m / 2.0),
            world: Some(&explored.world),
            classes: &classes,
            title: format!("{number}: {}", heading(found)),
            subtitle: format!("{} of runs; {}", percent(found.share), looks(found)),
            theme: Theme::Screen,
        })
        .collect();
    let svg = rsrs_view::gallery::svg(&title, &pictures, COLUMNS)?;
    write_file(&folder.join("gallery.svg"), svg.as_bytes())?;
    let png = rsrs_view::raster::png(&svg, WIDTH_PX)?;
    write_file(&folder.join("gallery.png"), &png)?;
    let mut page = Page::new(&title);
    page.paragraph(
        "Each picture is one simulated run of a controller that was found: pale where robots were, \
         strong where they were in the last 30 s. The share is that of fresh runs that show the same.",
    );
    let mut figures = Vec::new();
    for (picture, found) in pictures.iter().zip(found) {
        let svg = rsrs_view::trajectory::svg(picture)?;
        figures.push((svg, caption(found, folder)));
    }
    page.figures(&figures);
    write_file(&folder.join("gallery.html"), page.finish().as_bytes())
}

/// Below a picture.
fn caption(found: &FoundController, folder: &Path) -> Vec<String> {
    let mut lines = vec![line(found), order_parameters(found), elsewhere(found)];
    lines.retain(|line| !line.is_empty());
    lines.extend(commands(found));
    lines.push(found.sweep.as_ref().map_or_else(no_sweep, |sweep| {
        let sweep = folder.join(sweep);
        sweep_command(&sweep, &results_of(&sweep))
    }));
    lines
}
