//! `rsrs diagram`: the phase diagram as a picture.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use rsrs_core::quantity::{Axis, Cell};
use rsrs_view::diagram::{ExperimentMark, Numbers};

use crate::commands::{Format, report_written};
use crate::failure::{Outcome, bad_arguments};
use crate::page_arguments::PageArguments;
use crate::profile_arguments::ProfileArguments;
use rsrs_pipeline::compare;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::label::Labeller;
use rsrs_pipeline::sweep::folder;
use rsrs_pipeline::sweep::result::{SweepResult, World};
use rsrs_render::comparison::Report;
use rsrs_render::latex;
use rsrs_render::picture::page::page;
use rsrs_render::picture::{CellNumber, CellNumbers, DiagramOptions, Worlds, of_sweep, validation};
use rsrs_render::picture_file::PictureFile;

/// Draw the phase diagram of a sweep.
///
/// A sweep holds two worlds, and the picture names the one that it shows: robots made worse or, with
/// `--world as-measured`, robots as measured. Hue is the most frequent phase of a cell, lightness its
/// share. Dashed lines are conditions for an ideal ring, by geometry alone, where no simulated mills
/// contradict them. With `choice.json` beside the sweep's files, the chosen cell is marked; with
/// `validation.json`, its answer is noted. With `--bags`, recorded runs are drawn where they were run,
/// by their label.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs diagram results/flockbot -o flockbot.svg
  rsrs diagram results/flockbot --world side-by-side -o flockbot.html
  rsrs diagram results/flockbot --bags results/campaign/*/bag -o flockbot.pdf")]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Picture to write; its extension selects the format: svg, png, pdf, or html, which also has
    /// the numbers; or tex, a table of the cells for a paper.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Horizontal axis (default: the first swept one).
    #[arg(long, value_name = "AXIS")]
    x: Option<Axis>,
    /// Vertical axis (default: the second swept one).
    #[arg(long, value_name = "AXIS")]
    y: Option<Axis>,
    /// Values on further axes, as AXIS=VALUE,…; without them, up to 12 slices are drawn side by side.
    #[arg(long, value_name = "AXIS=V")]
    at: Option<Cell>,
    /// Bags of runs to be laid over the diagram: rosbag2 folders or single `.mcap` files.
    #[arg(long, value_name = "BAG", num_args = 1..)]
    bags: Vec<PathBuf>,
    /// Whose labels of the bags are drawn: the judge's, or those of one person, as `human:WHO` (default:
    /// judge).
    #[arg(
        long,
        value_name = "judge|human:WHO",
        default_value = "judge",
        hide_default_value = true,
        requires = "bags"
    )]
    labels: Labeller,
    #[command(flatten)]
    other: ProfileArguments,
    /// Title (default: one with the name of the robot).
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// What the cells show instead of their phases: the mean of an order parameter over the runs of
    /// a cell (`mean_radius_m`: over those that end as wanted); `settling_time_s`, when half of
    /// those that end as wanted had settled, for which they are simulated again; or `difference`,
    /// between robots as measured and those made worse (default: phases).
    #[arg(long, value_name = "NAME", value_parser = cell_numbers())]
    value: Option<CellNumber>,
    /// Leave the numbers out of the cells.
    #[arg(long)]
    no_numbers: bool,
    #[command(flatten)]
    page: PageArguments,
    /// The robots: made worse by the sweep's factors, as measured, or both side by side (default:
    /// harsher).
    #[arg(long, value_enum)]
    world: Option<Robots>,
}

/// Which robots a diagram shows.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Robots {
    /// The robots are made worse than measured, by the sweep's `harsher`.
    Harsher,
    /// The robots are as measured.
    AsMeasured,
    /// Both, in two panels.
    SideBySide,
}

impl From<Robots> for Worlds {
    fn from(robots: Robots) -> Self {
        match robots {
            Robots::Harsher => Self::One(World::Harsher),
            Robots::AsMeasured => Self::One(World::AsMeasured),
            Robots::SideBySide => Self::Both,
        }
    }
}

/// A number that a cell may show, by its name.
fn cell_numbers() -> impl TypedValueParser<Value = CellNumber> {
    PossibleValuesParser::new(CellNumber::keys())
        .map(|key| CellNumber::from_key(&key).expect("the parser takes no other words"))
}

impl Arguments {
    /// The worlds that are shown.
    fn worlds(&self) -> Worlds {
        self.world.unwrap_or(Robots::Harsher).into()
    }

    /// What the cells show in the place of their phases.
    fn values(&self, result: &SweepResult) -> anyhow::Result<Option<CellNumbers>> {
        let worlds = self.worlds().all();
        self.value.map(|value| value.of_sweep(&self.folder, result, worlds)).transpose()
    }

    /// The bags as marks on the diagram.
    fn experiments(&self) -> anyhow::Result<Vec<ExperimentMark>> {
        if self.bags.is_empty() {
            return Ok(Vec::new());
        }
        let options = compare::CompareOptions {
            bags: self.bags.clone(),
            labels: self.labels.clone(),
            with_lost_robots: false,
            with_implausible: false,
            margin: None,
            poses: None,
            other_profile: self.other.profile(),
        };
        Ok(Report::new(compare::compare(&self.folder, &options)?).marks())
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if latex::is_tex(&arguments.output) {
        if arguments.value.is_some() {
            return Err(bad_arguments(with_help(
                "a table has the phases of the cells, and no `--value`",
                "all numbers of all runs are in `replicates.parquet`",
            )));
        }
        arguments.page.check(None, "a table has the style of its document: leave it out")?;
        let result = folder::read(&arguments.folder)?;
        let tables = arguments.worlds().all().iter();
        let tables: Vec<String> =
            tables.map(|world| latex::cells(&result, *world)).collect::<Result<_, _>>()?;
        write_file(&arguments.output, tables.concat().as_bytes())?;
        report_written(Format::Text, &arguments.output)?;
        return Ok(Outcome::Done);
    }
    let is_page = arguments.output.extension().is_some_and(|ending| ending == "html");
    // The tables of a page are of one world, whatever its picture shows.
    if arguments.value == Some(CellNumber::Difference) && arguments.world.is_some() && !is_page {
        return Err(bad_arguments(with_help(
            "a difference is between both worlds, and `--world` chooses what is shown of them",
            "leave out `--world`",
        )));
    }
    let picture = (!is_page).then(|| picture_file(arguments)).transpose()?;
    let result = folder::read(&arguments.folder)?;
    let options = DiagramOptions {
        x: arguments.x,
        y: arguments.y,
        at: arguments.at.iter().flat_map(Cell::iter).collect(),
        chosen: folder::read_choice(&arguments.folder)?,
        experiments: arguments.experiments()?,
        title: arguments.title.clone(),
        subtitle: None,
        values: arguments.values(&result)?,
        numbers: if arguments.no_numbers { Numbers::Hidden } else { Numbers::Shown },
        worlds: arguments.worlds(),
        style: arguments.page.style(),
        validation: validation(&arguments.folder, &result.source)?,
    };
    let svg = of_sweep(&result, &options)?;
    if let Some(picture) = picture {
        picture.write(&svg)?;
    } else {
        write_file(&arguments.output, page(&result, arguments.worlds(), &svg)?.as_bytes())?;
    }
    report_written(Format::Text, &arguments.output)?;
    Ok(Outcome::Done)
}

fn picture_file(arguments: &Arguments) -> anyhow::Result<PictureFile<'_>> {
    let file = PictureFile::new(&arguments.output).map_err(|error| {
        bad_arguments(with_help(
            format!("{error}, nor in .html or .tex"),
            "name the picture `-o diagram.svg`, `-o diagram.png`, `-o diagram.pdf` or `-o diagram.html`, or a table `-o cells.tex`",
        ))
    })?;
    Ok(file.styled(arguments.page.style()))
}
