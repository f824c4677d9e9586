//! A bag into today's judge: is its label still the recorded one?

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::Phase;
use rsrs_files::quoted;
use serde::{Deserialize, Serialize};

use crate::error::with_help;
use crate::files::read_if_there;
use crate::label::human_labels::JUDGE;
use crate::label::{LABEL, LabelOptions, Labelled, label_bag};

/// A recorded label beside that of today's judge.
#[derive(Clone, Debug, Serialize)]
pub struct JudgeReplay {
    /// The bag.
    pub bag: PathBuf,
    /// Where the recorded label is.
    pub recorded_in: PathBuf,
    /// The recorded label.
    pub recorded: JudgedPhase,
    /// That of this program.
    pub today: JudgedPhase,
    /// Whether both are the same phase.
    pub is_same: bool,
}

/// The part of a label that is compared.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct JudgedPhase {
    /// The phase.
    pub phase: Phase,
    /// The order parameters behind it.
    pub evidence: Option<OrderParameters>,
    /// Number of robots, if it is known.
    #[serde(default)]
    pub n_robots: Option<usize>,
    /// Who labelled it.
    pub by: String,
}

/// A file with labels: that of one bag, or a list.
#[derive(Deserialize)]
#[serde(untagged)]
enum Labels {
    One(Box<JudgedPhase>),
    Several(Vec<JudgedPhase>),
}

/// Labels a bag, and compares the label with one that a judge gave before: that of a file, or of
/// `label.json` beside the bag.
pub fn replay_into_judge(bag: &Path, recorded: Option<&Path>) -> anyhow::Result<JudgeReplay> {
    let path = recorded.map_or_else(|| beside(bag), Path::to_owned);
    // The phases of the label may be those of a behaviour that the bag has.
    let labelled = label_bag(bag, LabelOptions::default())?;
    let recorded = read(&path, bag)?;
    let Labelled { phase, evidence, n_robots, by, .. } = labelled;
    let today = JudgedPhase { phase, evidence, n_robots, by };
    if let Some((then, now)) = recorded.n_robots.zip(n_robots).filter(|(then, now)| then != now) {
        return Err(with_help(
            format!("{} is of {then} robots, and {} has {now}", path.display(), bag.display()),
            "name its own one with `--recorded FILE`",
        ));
    }
    let is_same = today.phase == recorded.phase;
    Ok(JudgeReplay { bag: bag.to_owned(), recorded_in: path, recorded, today, is_same })
}

fn beside(bag: &Path) -> PathBuf {
    // Of `.`, too, there is a folder above.
    let whole = std::fs::canonicalize(bag).unwrap_or_else(|_| bag.to_owned());
    whole.parent().unwrap_or(Path::new("")).join(LABEL)
}

fn read(path: &Path, bag: &Path) -> anyhow::Result<JudgedPhase> {
    let file = path.display();
    let Some(text) = read_if_there(path)? else {
        return Err(with_help(
            format!("there is no recorded label in {file}"),
            format!(
                "name one with `--recorded FILE`; `rsrs label {} --format json > FILE` makes one",
                quoted(bag)
            ),
        ));
    };
    let labels: Labels = serde_json::from_str(&text)
        .with_context(|| format!("{file} is no label, as `rsrs label --format json` prints it"))?;
    let label = match labels {
        Labels::One(label) => *label,
        Labels::Several(several) => match <[JudgedPhase; 1]>::try_from(several) {
            Ok([label]) => label,
            Err(several) => bail!("{file} holds {} labels, expected 1", several.len()),
        },
    };
    if label.by != JUDGE {
        bail!("{file}: the label is by {}, expected one by the {JUDGE}", label.by);
    }
    Ok(label)
}
