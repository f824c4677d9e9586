//! Pictures of results: what to write on them, and into which file.

mod boundaries;
mod curves;
pub mod page;
mod values;

use std::path::Path;

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::diagram::DiagramCell;
use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::diagram::choice::{Choice, VIABLE_B_S_LOW};
use rsrs_core::numerals::{count, percent, significant};
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::{RobotProfile, Sees};
use rsrs_core::world::WorldFile;
use rsrs_pipeline::error::{helped, with_help};
use rsrs_pipeline::files::write_draft;
use rsrs_pipeline::sweep::result::{SweepResult, World};
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_pipeline::validate::file::{StoredAnswer, stored};
use rsrs_view::diagram::{
    CellValues, DiagramPicture, DrawnDiagram, ExperimentMark, Numbers, Panel,
};
use rsrs_view::raster::{PNG_WIDTH_PX, png};

use crate::picture::boundaries::{Plane, boundaries};
use crate::picture_file::{Length, PageStyle};
use crate::wording::{capitalised, quantity, robot_names};

pub use curves::of_answers;
pub use values::{CellNumber, CellNumbers};

/// The note on a picture whose simulator was not validated against real robots.
const NOT_VALIDATED: &str = "simulated robots not validated against real trajectories";

/// What a person asked of the picture.
#[derive(Clone, Debug, Default)]
pub struct DiagramOptions {
    /// Horizontal axis; the first swept one if not given.
    pub x: Option<Axis>,
    /// Vertical axis; the second swept one if not given.
    pub y: Option<Axis>,
    /// Values on further axes; where one is missing, all of them are drawn side by side, or of more than
    /// [`MOST_PANELS`] that of the chosen cell, or else of the slice that has most cells.
    pub at: Vec<(Axis, f64)>,
    /// The chosen cell.
    pub chosen: Option<Choice>,
    /// The title; the robot's name in a sentence if not given.
    pub title: Option<String>,
    /// The line below it; what else it takes to repeat the sweep if not given.
    pub subtitle: Option<String>,
    /// Numbers that the cells show in the place of their phases.
    pub values: Option<CellNumbers>,
    /// Whether `B_s`, or what is shown in its place, is written into the cells.
    pub numbers: Numbers,
    /// Where experiments were run.
    pub experiments: Vec<ExperimentMark>,
    /// The worlds.
    pub worlds: Worlds,
    /// How it is printed.
    pub style: PageStyle,
    /// The result of `rsrs validate` in words, if there is one: [`validation`].
    pub validation: Option<String>,
}

/// Which worlds of a sweep a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Worlds {
    /// One of them.
    One(World),
    /// Both, side by side.
    Both,
}

impl Default for Worlds {
    fn default() -> Self {
        Self::One(World::default())
    }
}

impl Worlds {
    /// Each of them.
    pub fn all(self) -> &'static [World] {
        match self {
            Self::One(World::Harsher) => &[World::Harsher],
            Self::One(World::AsMeasured) => &[World::AsMeasured],
            Self::Both => &[World::Harsher, World::AsMeasured],
        }
    }

    fn first(self) -> World {
        self.all()[0]
    }
}

/// Panels of one picture at most.
pub const MOST_PANELS: usize = 12;

/// Draws the diagram of a sweep into its folder, as `diagram.svg` and `diagram.png`, with the answer of `rsrs validate` if it is there.
pub fn into_folder(folder: &Path, result: &SweepResult) -> anyhow::Result<()> {
    let validation = validation(folder, &result.source)?;
    let svg = of_sweep(result, &DiagramOptions { validation, ..DiagramOptions::default() })?;
    write_draft(&folder.join("diagram.svg"), svg.as_bytes())?;
    write_draft(&folder.join("diagram.png"), &png(&svg, PNG_WIDTH_PX)?)
}

/// Draws a sweep as SVG.
///
/// # Errors
///
/// If an axis or value was not swept, or the sweep does not hold the world.
pub fn of_sweep(result: &SweepResult, options: &DiagramOptions) -> anyhow::Result<String> {
    Ok(drawn(result, options)?.svg)
}

/// As [`of_sweep`], with where the cells lie.
pub fn drawn(result: &SweepResult, options: &DiagramOptions) -> anyhow::Result<DrawnDiagram> {
    let of = Drawn::new(result, options)?;
    let (x, y) = (of.x, of.y);
    if options.values.is_some() && y.is_none() {
        return Err(with_help(
            "a sweep of one axis has curves of its phases, and no map",
            "leave `--value` out, or sweep two axes",
        ));
    }
    let panels = of.panels()?;
    let shown = of.shown(&panels);
    let conditions = of.conditions()?;
    let robots = robot_names(&result.source);
    let swarm = result.source.sweep.behaviour.known().swarm();
    let title = options.title.clone().unwrap_or_else(|| match &options.values {
        Some(values) => format!("{} in {swarm}: {robots}", capitalised(&values.title)),
        None => format!("Phases of {swarm}: {robots}"),
    });
    let mut note = options.validation.clone().unwrap_or_else(|| NOT_VALIDATED.to_owned());
    note.extend(fitted_to_others(&result.source));
    let picture = DiagramPicture {
        panels,
        x,
        y,
        title,
        subtitle: match &options.subtitle {
            Some(subtitle) => subtitle.clone(),
            None => of.facts(&conditions)?.join(", "),
        },
        details: how(result, options.worlds, &conditions)?,
        chosen: options.chosen.as_ref().map(|choice| &choice.cell),
        chosen_note: options.chosen.as_ref().map(confirmed),
        values: options.values.as_ref().map(|values| cell_values(values, &shown)),
        numbers: options.numbers,
        experiments: &options.experiments,
        wanted: Some((VIABLE_B_S_LOW, format!("viable: {}", percent(VIABLE_B_S_LOW)))),
        note: Some(note),
        theme: options.style.theme,
        width_px: options.style.width.map(Length::px),
    };
    rsrs_view::diagram::drawn(&picture).map_err(helped)
}

/// Which profiles were fitted to trials that are not those of robots.
fn fitted_to_others(source: &ResolvedSweep) -> impl Iterator<Item = String> {
    let of = |which: String, profile: &RobotProfile| {
        let origin = profile.provenance.trials?;
        Some(format!("; {which} was fitted to trials of {}", origin.whose()))
    };
    let classes = source.sweep.world().into_iter().flat_map(WorldFile::profiles);
    let of_classes =
        classes.filter_map(move |(class, own)| of(format!("the profile of class {class}"), own));
    of("their profile".to_owned(), &source.profile).into_iter().chain(of_classes)
}

/// What the line below the title of a sweep states, fact by fact.
pub(crate) fn facts(result: &SweepResult, options: &DiagramOptions) -> anyhow::Result<Vec<String>> {
    let of = Drawn::new(result, options)?;
    of.facts(&of.conditions()?)
}

/// The result of `rsrs validate` that is kept in the folder of a sweep, in words; `None` if there is none.
pub fn validation(folder: &Path, source: &ResolvedSweep) -> anyhow::Result<Option<String>> {
    Ok(stored(folder, source)?.as_ref().map(validated))
}

fn validated(answer: &StoredAnswer) -> String {
    let StoredAnswer { n_inside, n_trials, .. } = answer;
    let counts = format!(
        "{n_inside} of {n_trials} trials inside the simulated {:.0} % reach",
        answer.share * 100.0
    );
    let at: Vec<String> =
        answer.judged.at.iter().map(|(axis, value)| format!("{axis}={value}")).collect();
    let at = (!at.is_empty()).then(|| format!("at {}", at.join(", ")));
    let class = answer.judged.class.as_ref().map(|class| format!("class {class}"));
    let which: Vec<String> = class.into_iter().chain(at).collect();
    let at = if which.is_empty() { String::new() } else { format!(" ({})", which.join(", ")) };
    if let Some(origin) = answer.trials_of {
        let whose = origin.whose();
        return format!("not validated: held against trials of {whose}, {counts}{at}");
    }
    match (answer.is_contained, answer.is_harsher) {
        (true, true) => format!("validated: {counts}{at}"),
        (true, false) => {
            format!("NOT validated: {counts}{at}, but the simulated robot is better in part")
        }
        (false, _) => format!("NOT contained: {counts}{at}"),
    }
}

/// The numbers of each panel, by the world that it shows.
fn cell_values(values: &CellNumbers, shown: &[World]) -> CellValues {
    CellValues {
        name: values.name.clone(),
        scale: values.scale,
        of_panels: shown.iter().map(|world| values.of(*world)).collect(),
        framed: values
            .framed
            .as_ref()
            .map(|(words, framed)| (words.clone(), shown.iter().map(|_| framed.clone()).collect())),
    }
}

/// What is drawn of a sweep, over which axes.
struct Drawn<'a> {
    result: &'a SweepResult,
    options: &'a DiagramOptions,
    x: Axis,
    y: Option<Axis>,
}

impl<'a> Drawn<'a> {
    fn new(result: &'a SweepResult, options: &'a DiagramOptions) -> anyhow::Result<Self> {
        let diagram = result.of_world(options.worlds.first())?;
        let is_open = |axis: &Axis| options.at.iter().all(|(at, _)| at != axis);
        let mut open = diagram.axes.iter().copied().filter(is_open);
        let x = options.x.or_else(|| open.next()).unwrap_or(Axis::Speed);
        let mut others = diagram.axes.iter().copied().filter(is_open);
        let y = options.y.or_else(|| others.find(|axis| *axis != x));
        Ok(Self { result, options, x, y })
    }

    /// A panel for each slice in each world.
    fn panels(&self) -> anyhow::Result<Vec<Panel<'a>>> {
        let Self { result, options, .. } = self;
        let slices = self.slices()?;
        let worlds = self.worlds();
        let mut panels = Vec::new();
        for at in &slices {
            for world in worlds {
                let mut heading = Vec::new();
                if slices.len() > 1 {
                    heading.extend(at.iter().map(|(axis, value)| quantity::named(*axis, *value)));
                }
                if worlds.len() > 1 {
                    heading.push(self.robots(*world).to_owned());
                }
                let diagram = result.of_world(*world)?;
                let (plane, conditions) = self.plane(diagram, *world, at)?;
                let mills = |entry: &&DiagramCell| {
                    entry.counts.wanted_share() >= 0.5 && is_at(&entry.cell, at)
                };
                let mills: Vec<&Cell> =
                    diagram.cells.iter().filter(mills).map(|entry| &entry.cell).collect();
                panels.push(Panel {
                    heading: heading.join(", "),
                    diagram,
                    at: at.clone(),
                    // They are about milling, not about what is shown in its place.
                    boundaries: if options.values.is_some() {
                        Vec::new()
                    } else {
                        boundaries(&conditions, plane, &mills)
                    },
                    is_b_s: *world == World::Harsher,
                    compared: self.compared(*world, worlds.len())?,
                });
            }
        }
        Ok(panels)
    }

    fn robots(&self, world: World) -> &'static str {
        robots(self.result, world)
    }

    /// The worlds of each slice: where no robot is made worse, both are one.
    fn worlds(&self) -> &'static [World] {
        let is_one = self.result.source.as_measured().is_none();
        if is_one { &[World::Harsher] } else { self.options.worlds.all() }
    }

    /// The world of each panel, in the order in which [`Self::panels`] makes them.
    fn shown(&self, panels: &[Panel]) -> Vec<World> {
        self.worlds().iter().copied().cycle().take(panels.len()).collect()
    }

    /// Robots as measured beside those made worse, where there is one axis and one panel.
    fn compared(
        &self,
        world: World,
        n_worlds: usize,
    ) -> anyhow::Result<Option<(String, &'a PhaseDiagram)>> {
        let is_second = self.y.is_none() && n_worlds == 1 && world == World::Harsher;
        if !is_second || self.result.source.as_measured().is_none() {
            return Ok(None);
        }
        let words = self.robots(World::AsMeasured).to_owned();
        Ok(Some((words, self.result.of_world(World::AsMeasured)?)))
    }

    /// All slices, if nothing selects one and there are few enough; else the selected one.
    fn slices(&self) -> anyhow::Result<Vec<Vec<(Axis, f64)>>> {
        let diagram = self.result.of_world(self.options.worlds.first())?;
        let shown = [Some(self.x), self.y];
        let at = &self.options.at;
        let all = slices_beyond(diagram, |axis| {
            !shown.contains(&Some(axis)) && at.iter().all(|(other, _)| *other != axis)
        });
        if (2..=MOST_PANELS / self.options.worlds.all().len()).contains(&all.len()) {
            let with = |slice: Vec<(Axis, f64)>| at.iter().copied().chain(slice).collect();
            return Ok(all.into_iter().map(with).collect());
        }
        Ok(vec![slice(diagram, self.x, self.y, self.options)])
    }

    /// The conditions of a cell of the picture.
    fn conditions(&self) -> anyhow::Result<Conditions> {
        let world = self.options.worlds.first();
        let diagram = self.result.of_world(world)?;
        Ok(self.plane(diagram, world, &self.slices()?[0])?.1)
    }

    /// What else it takes to repeat the sweep: robots, time, floor, and each value that it fixes.
    fn facts(&self, conditions: &Conditions) -> anyhow::Result<Vec<String>> {
        let Self { result, options, .. } = self;
        let diagram = result.of_world(options.worlds.first())?;
        let sweep = &result.source.sweep;
        let is_of_both = options.values.as_ref().is_some_and(|values| values.is_of_both_worlds);
        let world = match options.worlds {
            Worlds::One(world) if !is_of_both => robots(result, world),
            Worlds::One(_) | Worlds::Both => "robots made worse and robots as measured",
        };
        let is_swept = |axis: Axis| diagram.axes.contains(&axis);
        let mut facts = vec![world.to_owned()];
        if !is_swept(Axis::Robots) {
            facts.push(quantity::named(Axis::Robots, conditions.robots as f64));
        }
        facts.push(format!("{} s", sweep.duration_s));
        facts.push(replicates(diagram));
        match &conditions.placement {
            _ if is_swept(Axis::PlacementRadius) => {}
            Placement::DiscFacingOut { radius_m } => {
                facts.push(format!("start disc {} m", significant(*radius_m)));
            }
            Placement::BoxFacingOut(sides) | Placement::BoxFacingAnyWay(sides) => {
                let [width_m, height_m] = [sides.width_m, sides.height_m].map(significant);
                facts.push(format!("start box {width_m} × {height_m} m"));
            }
            Placement::Given { .. } => facts.push("starts from a table".to_owned()),
            Placement::Pair { .. } => {}
        }
        match conditions.arena.walls_m() {
            _ if is_swept(Axis::Arena) => {}
            Some(_) => facts.push(match &conditions.world.arena {
                None => format!("arena {} m", significant(conditions.arena.side_m)),
                Some(arena) => format!("arena {}", arena.in_words()),
            }),
            None => facts.push("no walls".to_owned()),
        }
        let stated = [Axis::Robots, Axis::PlacementRadius, Axis::Arena];
        let fixed = sweep.fixed.values.iter().filter(|(axis, _)| !stated.contains(axis));
        facts.extend(fixed.map(|(axis, value)| quantity::named(*axis, *value)));
        if !conditions.world.is_empty() {
            facts.push(conditions.world.in_words());
        }
        Ok(facts)
    }

    fn plane(
        &self,
        diagram: &PhaseDiagram,
        world: World,
        at: &[(Axis, f64)],
    ) -> anyhow::Result<(Plane, Conditions)> {
        let source = &self.result.source;
        let measured = (world == World::AsMeasured).then(|| source.as_measured()).flatten();
        let cells = measured.as_ref().unwrap_or(source).cells("sweep.yaml")?;
        Ok(plane(diagram, &cells, (self.x, self.y), at))
    }
}

/// The slices of a diagram: its values on the axes beyond the first two, in the order of its cells;
/// one slice without values for a diagram of at most two axes.
pub fn slices(diagram: &PhaseDiagram) -> Vec<Vec<(Axis, f64)>> {
    let further = diagram.axes.get(2..).unwrap_or_default();
    slices_beyond(diagram, |axis| further.contains(&axis))
}

/// The values of some axes that occur together, in the order of the cells.
fn slices_beyond(
    diagram: &PhaseDiagram,
    is_further: impl Fn(Axis) -> bool,
) -> Vec<Vec<(Axis, f64)>> {
    let further: Vec<Axis> =
        diagram.axes.iter().copied().filter(|axis| is_further(*axis)).collect();
    let values = |cell: &Cell| -> Vec<(Axis, f64)> {
        further.iter().filter_map(|axis| Some((*axis, cell.get(*axis)?))).collect()
    };
    let mut slices: Vec<Vec<(Axis, f64)>> = Vec::new();
    for entry in &diagram.cells {
        let slice = values(&entry.cell);
        if !slices.contains(&slice) {
            slices.push(slice);
        }
    }
    slices
}

/// Which values the axes beside `x` and `y` have in a picture: those that were requested, and one
/// for every other axis with several values.
fn slice(
    diagram: &PhaseDiagram,
    x: Axis,
    y: Option<Axis>,
    options: &DiagramOptions,
) -> Vec<(Axis, f64)> {
    let is_requested = |axis: Axis| options.at.iter().any(|(at, _)| *at == axis);
    let is_free = |axis: &Axis| *axis != x && Some(*axis) != y && !is_requested(*axis);
    let free: Vec<Axis> = diagram.axes.iter().copied().filter(is_free).collect();
    let values =
        |cell: &Cell| -> Option<Vec<f64>> { free.iter().map(|axis| cell.get(*axis)).collect() };
    let mut slices: Vec<(Vec<f64>, usize)> = Vec::new();
    for cell in
        diagram.cells.iter().map(|entry| &entry.cell).filter(|cell| is_at(cell, &options.at))
    {
        let Some(values) = values(cell) else { continue };
        match slices.iter_mut().find(|(slice, _)| *slice == values) {
            Some((_, n_cells)) => *n_cells += 1,
            None => slices.push((values, 1)),
        }
    }
    let most = slices.iter().map(|(_, n_cells)| *n_cells).max().unwrap_or(0);
    slices.retain(|(_, n_cells)| *n_cells == most);
    let chosen = options.chosen.as_ref().and_then(|choice| values(&choice.cell));
    let middle = slices.get(slices.len().saturating_sub(1) / 2).map(|(values, _)| values.clone());
    let rest = chosen.or(middle).unwrap_or_default();
    options.at.iter().copied().chain(free.into_iter().zip(rest)).collect()
}

fn replicates(diagram: &PhaseDiagram) -> String {
    let n = |entry: &DiagramCell| entry.counts.total();
    let least = diagram.cells.iter().map(n).min().unwrap_or(0);
    let most = diagram.cells.iter().map(n).max().unwrap_or(0);
    let n = if least == most { least.to_string() } else { format!("{least} to {most}") };
    format!("{n} replicates per cell")
}

/// The robots of a world.
pub fn robots(result: &SweepResult, world: World) -> &'static str {
    match world {
        World::Harsher if result.source.as_measured().is_some() => "robots made worse",
        World::Harsher | World::AsMeasured => "robots as measured",
    }
}

/// What fresh runs showed of the chosen cell.
fn confirmed(choice: &Choice) -> String {
    format!(
        "confirmed: {} of {} fresh runs {} ({} to {})",
        percent(choice.b_s),
        count(choice.n_replicates),
        choice.behaviour().verb().plain,
        percent(choice.b_s_low),
        percent(choice.b_s_high)
    )
}

/// What else it takes to repeat the sweep, for the picture's file: what was fixed, how robots were made worse, the seed.
fn how(result: &SweepResult, worlds: Worlds, conditions: &Conditions) -> anyhow::Result<String> {
    let sweep = &result.source.sweep;
    // The number of robots is stated before.
    let fixed = sweep.fixed.values.iter().filter(|(axis, _)| *axis != Axis::Robots);
    let mut parts: Vec<String> = fixed.map(|(axis, value)| format!("{axis}={value}")).collect();
    if worlds.first() == World::Harsher {
        let factors = serde_json::to_value(sweep.factors(&result.source.profile))?;
        let none = serde_json::to_value(HarsherFactors::NONE)?;
        let changed = factors.as_object().into_iter().flatten();
        let changed = changed.filter(|(key, factor)| none.get(key) != Some(factor));
        parts.extend(changed.map(|(key, factor)| format!("{key} {factor}")));
    }
    parts.push(match conditions.robot.sees {
        Sees::Body => "sees bodies".to_owned(),
        Sees::Centre => "sees centres".to_owned(),
    });
    parts.push(format!("seed {}", sweep.seed));
    parts.push(format!("sweep {}", result.source.digest()));
    Ok(parts.join(", "))
}

/// The plane of the picture, and the conditions of a cell in it.
fn plane(
    diagram: &PhaseDiagram,
    cells: &[(Cell, Conditions)],
    (x, y): (Axis, Option<Axis>),
    at: &[(Axis, f64)],
) -> (Plane, Conditions) {
    let span = |axis: Axis| {
        let values = diagram.values(axis);
        Some((axis, *values.first()?, *values.last()?))
    };
    let here = cells.iter().find(|(cell, _)| is_at(cell, at));
    let (_, conditions) = here.or(cells.first()).expect("a sweep has cells");
    let x = span(x).unwrap_or((x, 0.0, 0.0));
    (Plane { x, y: y.and_then(span) }, conditions.clone())
}

fn is_at(cell: &Cell, at: &[(Axis, f64)]) -> bool {
    at.iter().all(|(axis, value)| cell.get(*axis) == Some(*value))
}

#[cfg(test)]
pub(crate) mod tests {
    use rsrs_core::diagram::sweep_file::SweepFile;
    use rsrs_core::judge::counts::PhaseCounts;
    use rsrs_core::judge::phase::Phase;

    use super::*;

    /// Flockbots as measured, swept by a file of these lines, of which each cell milled so many times.
    pub(crate) fn swept(lines: &str, n: usize) -> SweepResult {
        let text = format!(
            "profile: flockbot.yaml\nharsher: none\nreplicates: {n}\nduration_s: 120\nseed: 1\n{lines}"
        );
        let sweep = SweepFile::parse("sweep.yaml", &text).expect("the tests write sweeps well");
        let robot = rsrs_testing::conditions::flockbot();
        let source = ResolvedSweep::of_robot("sweep.yaml", sweep, robot, Path::new(""))
            .expect("it needs no file");
        let cells: Vec<DiagramCell> = source
            .cells("sweep.yaml")
            .expect("Flockbots can be there")
            .into_iter()
            .map(|(cell, _)| DiagramCell {
                cell,
                counts: PhaseCounts::new(vec![Phase::STABLE_MILLING; n]),
            })
            .collect();
        let diagram = PhaseDiagram { axes: cells[0].cell.axes(), cells };
        SweepResult { source, diagram, as_measured: None }
    }

    /// The texts of a picture in one line, however they are wrapped.
    pub(crate) fn words(svg: &str) -> String {
        let texts = svg.split("<text").skip(1).filter_map(|text| {
            let (_, text) = text.split_once('>')?;
            Some(text.split_once("</text>")?.0)
        });
        texts.collect::<Vec<&str>>().join(" ")
    }

    fn line_below_the_title(result: &SweepResult) -> String {
        facts(result, &DiagramOptions::default()).expect("the sweep is whole").join(", ")
    }

    #[test]
    fn every_value_that_a_sweep_fixes_stands_below_the_title_once() {
        let result = swept(
            "axes: {speed_m_s: [0.1, 0.2], turn_rate_rad_s: [0.5, 1]}\n\
             fixed: {robots: 9, placement_radius_m: 0.825, arena_m: 15, half_angle_rad: 0.25, \
             range_m: 0.9, turn_bias_rad_s: 0.02}",
            6,
        );

        insta::assert_snapshot!(
            line_below_the_title(&result),
            @"robots as measured, 9 robots, 120 s, 6 replicates per cell, start disc 0.825 m, arena 15 m, half-angle of the sensor 0.25 rad (14.3°), range of the sensor 0.9 m, turn bias 0.02 rad/s"
        );
    }

    #[test]
    fn a_curve_names_the_axis_that_its_sweep_fixes() {
        let result = swept(
            "axes: {speed_m_s: [0.1, 0.2]}\nfixed: {robots: 9, turn_rate_rad_s: 0.75, arena_m: 15}",
            6,
        );
        let options = DiagramOptions::default();

        let svg = of_sweep(&result, &options).expect("it can be drawn");

        let line = line_below_the_title(&result);
        assert!(line.ends_with("arena 15 m, turning rate 0.75 rad/s"), "{line}");
        assert!(words(&svg).contains("turning rate 0.75 rad/s"), "{svg}");
    }
}
