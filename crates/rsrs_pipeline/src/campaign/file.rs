//! The campaign file: many experiments, in the order in which they are run.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::bail;
use rsrs_core::comparison::fixed::{FixedDesign, FixedRun};
use rsrs_core::diagram::sweep_file::SEED_LIMIT;
use rsrs_core::document;
use rsrs_core::quantity::Cell;
use serde::Deserialize;

use crate::error::{helped, with_help};
use crate::files::read_text;

/// A campaign as written by a person.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CampaignFile {
    /// The number of its experiments and the margin, written down before the first run: `rsrs compare`
    /// gives its verdict at that number then, and not before (`rsrs plan-experiments --fixed`).
    fixed: Option<FixedDesign>,
    /// What is run, in this order.
    experiments: Vec<Entry>,
}

/// An experiment file, and how often it is run with what.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// Path of the experiment file, relative to this file.
    experiment: PathBuf,
    /// What its folders are called; the experiment file's name without its ending if not given.
    name: Option<String>,
    /// Folder of a sweep, relative to this file, whose cells these are.
    from: Option<PathBuf>,
    /// The cells to run; the experiment's own if none are named.
    #[serde(default)]
    cells: Vec<Cell>,
    /// Seeds, each of which is run in every cell; the experiment's own if none are named.
    #[serde(default)]
    seeds: Vec<u64>,
    /// How often each cell is run with each seed: replicates 0, 1, … of it in the simulator.
    #[serde(default = "once")]
    repetitions: u64,
}

fn once() -> u64 {
    1
}

/// More than anybody runs in one campaign; larger numbers are slips.
const MAX_EXPERIMENTS: usize = 10_000;

/// One experiment of a campaign.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// What its folder is called: its place in the campaign, and its name.
    pub folder: String,
    /// Its name.
    pub name: String,
    /// The experiment file.
    pub file: PathBuf,
    /// Folder of the sweep that it belongs to.
    pub from: Option<PathBuf>,
    /// The cell, where the experiment file does not count.
    pub cell: Option<Cell>,
    /// The seed, where the experiment file's does not count.
    pub seed: Option<u64>,
    /// Which repetition it is, from 0.
    pub replicate: u64,
    /// Which run it is of those whose number was fixed.
    pub fixed: Option<FixedRun>,
}

/// Reads the text of a campaign file, and all of its experiments, in order: each cell with each
/// seed, as often as asked for.
pub fn read(path: &Path) -> anyhow::Result<(String, Vec<Experiment>)> {
    let file = path.display().to_string();
    let text = read_text(path)?;
    let campaign: CampaignFile = document::parse(&file, &text).map_err(helped)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let mut experiments = Vec::new();
    for entry in &campaign.experiments {
        entry.check(&file)?;
        entry.spell_out(beside, &mut experiments);
        if experiments.len() > MAX_EXPERIMENTS {
            bail!("{file}: more than {MAX_EXPERIMENTS} experiments");
        }
    }
    if experiments.is_empty() {
        bail!("{file}: no experiments");
    }
    if let Some(design) = campaign.fixed {
        fix(design, &mut experiments, &file)?;
    }
    Ok((text, experiments))
}

/// Numbers the experiments of a design.
fn fix(design: FixedDesign, experiments: &mut [Experiment], file: &str) -> anyhow::Result<()> {
    let FixedDesign { runs, margin } = design;
    let n = experiments.len() as u64;
    if runs != n {
        return Err(with_help(
            format!("{file}: fixed: runs is {runs}, and the experiments are {n}"),
            "the number that `rsrs plan-experiments --fixed` gives is that of all experiments together",
        ));
    }
    if !(0.0..=0.5).contains(&margin) {
        bail!("{file}: fixed: margin is {margin}, expected a share from 0 to 0.5");
    }
    for (number, experiment) in (1..).zip(experiments) {
        experiment.fixed = Some(FixedRun { number, runs, margin });
    }
    Ok(())
}

impl Entry {
    fn name(&self) -> String {
        self.name.clone().unwrap_or_else(|| {
            self.experiment.file_stem().map_or_else(String::new, |stem| stem.display().to_string())
        })
    }

    fn check(&self, file: &str) -> anyhow::Result<()> {
        let name = self.name();
        let is_plain = |letter: char| letter.is_alphanumeric() || "_-.".contains(letter);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
            return Err(with_help(
                format!("{file}: {name:?} cannot be the name of a folder"),
                "give a `name:` of letters, digits, `_`, `-` and `.`",
            ));
        }
        if self.repetitions == 0 || self.repetitions > MAX_EXPERIMENTS as u64 {
            bail!(
                "{file}: {name}: repetitions is {}, expected 1 to {MAX_EXPERIMENTS}",
                self.repetitions
            );
        }
        let mut seen = BTreeSet::new();
        for seed in &self.seeds {
            if *seed >= SEED_LIMIT {
                bail!("{file}: {name}: seed {seed}, expected a whole number below 2^63");
            }
            if !seen.insert(seed) {
                return Err(with_help(
                    format!("{file}: {name}: seed {seed} is named twice"),
                    "the same run again is `repetitions: 2`",
                ));
            }
        }
        Ok(())
    }

    fn spell_out(&self, beside: &Path, experiments: &mut Vec<Experiment>) {
        // Nothing named is one of the experiment file's own.
        let cells = some_of(&self.cells);
        let seeds = some_of(&self.seeds);
        let name = self.name();
        for cell in &cells {
            for replicate in 0..self.repetitions {
                for seed in &seeds {
                    experiments.push(Experiment {
                        folder: format!("{:03}_{name}", experiments.len() + 1),
                        name: name.clone(),
                        file: beside.join(&self.experiment),
                        from: self.from.as_ref().map(|from| beside.join(from)),
                        cell: cell.clone(),
                        seed: *seed,
                        replicate,
                        fixed: None,
                    });
                }
            }
        }
    }
}

fn some_of<T: Clone>(named: &[T]) -> Vec<Option<T>> {
    if named.is_empty() { vec![None] } else { named.iter().cloned().map(Some).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> anyhow::Result<Vec<Experiment>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("campaign.yaml");
        std::fs::write(&path, text).unwrap();
        read(&path).map(|(_, experiments)| experiments)
    }

    #[test]
    fn every_cell_is_run_with_every_seed_as_often_as_asked_for() {
        let text = "experiments:\n\
                    - experiment: a.yaml\n  seeds: [1, 2]\n  repetitions: 2\n\
                    - {experiment: b.yaml, name: fast, cells: [{speed_m_s: 0.3}, {speed_m_s: 0.4}]}\n";

        let experiments = read_text(text).unwrap();

        let given: Vec<(&str, Option<u64>, u64)> =
            experiments.iter().map(|it| (it.folder.as_str(), it.seed, it.replicate)).collect();
        assert_eq!(
            given,
            [
                ("001_a", Some(1), 0),
                ("002_a", Some(2), 0),
                ("003_a", Some(1), 1),
                ("004_a", Some(2), 1),
                ("005_fast", None, 0),
                ("006_fast", None, 0)
            ]
        );
    }

    #[test]
    fn what_is_no_campaign_is_refused() {
        for (text, expected) in [
            ("experiments: []", "no experiments"),
            ("experiments: [{experiment: a.yaml, seed: 3}]", "did you mean `seeds`?"),
            ("experiments: [{experiment: a.yaml, seeds: [3, 3]}]", "seed 3 is named twice"),
            ("experiments: [{experiment: a.yaml, name: ../b}]", "cannot be the name of a folder"),
            ("experiments: [{experiment: a.yaml, repetitions: 0}]", "repetitions is 0"),
        ] {
            let error = read_text(text).unwrap_err();

            assert!(error.to_string().contains(expected), "{error:#}");
        }
    }

    #[test]
    fn a_number_of_runs_that_is_fixed_is_that_of_all_experiments_and_each_has_its_own() {
        let experiments =
            "experiments: [{experiment: a.yaml, repetitions: 2}, {experiment: b.yaml}]\n";
        let with = |fixed: &str| read_text(&format!("fixed: {fixed}\n{experiments}"));

        let fixed = with("{runs: 3, margin: 0.25}").unwrap();

        let numbers = fixed.iter().map(|it| it.fixed.unwrap().number);
        assert_eq!(numbers.collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(fixed[0].fixed.unwrap().design(), FixedDesign { runs: 3, margin: 0.25 });
        let error = with("{runs: 4, margin: 0.25}").unwrap_err().to_string();
        assert!(error.contains("fixed: runs is 4, and the experiments are 3"), "{error}");
        let error = with("{runs: 3, margin: 0.7}").unwrap_err().to_string();
        assert!(error.contains("margin is 0.7, expected a share from 0 to 0.5"), "{error}");
    }
}
