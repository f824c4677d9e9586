//! A bag into today's judge: does it still say what it said then?

use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::order::Evidence;
use rsrs_core::phase::Phase;
use serde::{Deserialize, Serialize};

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::table_text::columns;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::label::human_labels::JUDGE;
use rsrs_pipeline::label::{LabelOptions, Labelled, label_bag};

/// The label beside a bag, as a campaign leaves it.
const LABEL: &str = "label.json";

/// What came of it.
#[derive(Serialize)]
struct Report {
    bag: PathBuf,
    /// Where the recorded label is.
    recorded_in: PathBuf,
    recorded: Said,
    today: Said,
    /// Whether both are the same phase.
    is_same: bool,
}

/// What a judge has said: the part of a label that is compared.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Said {
    phase: Phase,
    /// The order parameters behind it.
    evidence: Option<Evidence>,
    /// Number of robots, if it is known.
    #[serde(default)]
    n_robots: Option<usize>,
    by: String,
}

/// A file with labels: that of one bag, or a list.
#[derive(Deserialize)]
#[serde(untagged)]
enum Labels {
    One(Said),
    Several(Vec<Said>),
}

/// Runs the command.
///
/// # Errors
///
/// If the bag cannot be judged, or there is no label of a judge to compare with.
pub fn run(bag: &Path, recorded: Option<&Path>, format: Format) -> anyhow::Result<Outcome> {
    let path = recorded.map_or_else(|| beside(bag), Path::to_owned);
    let recorded = read(&path, bag)?;
    let labelled = label_bag(bag, LabelOptions::default())?;
    let Labelled { phase, evidence, n_robots, by, .. } = labelled;
    let today = Said { phase, evidence, n_robots, by };
    if let Some((then, now)) = recorded.n_robots.zip(n_robots).filter(|(then, now)| then != now) {
        return Err(with_help(
            format!("{} is of {then} robots, and {} has {now}", path.display(), bag.display()),
            "name its own one with `--recorded FILE`",
        ));
    }
    let is_same = today.phase == recorded.phase;
    let result = Report { bag: bag.to_owned(), recorded_in: path, recorded, today, is_same };
    report(format, &result, &text(&result))?;
    Ok(if is_same { Outcome::Done } else { Outcome::NegativeAnswer })
}

fn beside(bag: &Path) -> PathBuf {
    // Of `.`, too, there is a folder above.
    let whole = std::fs::canonicalize(bag).unwrap_or_else(|_| bag.to_owned());
    whole.parent().unwrap_or(Path::new("")).join(LABEL)
}

fn read(path: &Path, bag: &Path) -> anyhow::Result<Said> {
    let file = path.display();
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(with_help(
                format!("there is no recorded label in {file}"),
                format!(
                    "name one with `--recorded FILE`; `rsrs label {} --format json > FILE` makes one",
                    bag.display()
                ),
            ));
        }
        Err(error) => return Err(error).context(format!("cannot read {file}")),
    };
    let labels: Labels = serde_json::from_str(&text)
        .with_context(|| format!("{file} is no label, as `rsrs label --format json` prints it"))?;
    let said = match labels {
        Labels::One(said) => said,
        Labels::Several(several) => match <[Said; 1]>::try_from(several) {
            Ok([said]) => said,
            Err(several) => bail!("{file} holds {} labels, expected 1", several.len()),
        },
    };
    if said.by != JUDGE {
        bail!("{file}: the label is by {}, expected one by the {JUDGE}", said.by);
    }
    Ok(said)
}

fn text(result: &Report) -> String {
    let verdict = if result.is_same { "the same label" } else { "another label" };
    let head = format!("{}: {verdict}", result.bag.display());
    let mut rows =
        vec![["", "phase", "rotation", "orbit", "circliness", "blocked"].map(str::to_owned)];
    for (who, said) in [("recorded", &result.recorded), ("today", &result.today)] {
        let number = |of: fn(&Evidence) -> f64| {
            said.evidence.as_ref().map_or_else(|| "-".to_owned(), |it| format!("{:.3}", of(it)))
        };
        rows.push([
            who.to_owned(),
            said.phase.to_string(),
            number(|it| it.rotation),
            number(|it| it.orbit),
            number(|it| it.circliness),
            number(|it| it.blocked),
        ]);
    }
    format!("{head}\n{}", columns(&rows))
}
