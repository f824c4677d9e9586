//! Labels by people: a file beside the recording, to which labels are only ever added.
//!
//! In a bag's folder it is `labels.yaml`; beside a single file `run.mcap` it is `run.labels.yaml`.
//! Who labels a bag again adds a label; the last one counts, and the earlier ones stay to be seen.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, bail};
use jiff::{Timestamp, Unit};
use rsrs_core::document;
use rsrs_core::help::Help;
use rsrs_core::judge::phase::Phase;
use serde::{Deserialize, Serialize};

use crate::error::with_help;
use crate::files::read_if_there;

/// Who labels when no person does.
pub const JUDGE: &str = "judge";

/// What stands in front of the first label.
const HEAD: &str = "\
# What people saw in this bag. `rsrs label BAG --as PHASE --by WHO` adds to it; of one person's labels
# the last one counts.
";

/// What one person saw in one run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HumanLabel {
    /// What the swarm settled into.
    pub phase: Phase,
    /// Who gave it.
    pub by: String,
    /// When it was given, in UTC.
    pub time: String,
    /// A note.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl HumanLabel {
    /// A label that is given now; `by` is neither empty nor the judge.
    pub fn now(phase: Phase, by: &str, note: Option<&str>) -> anyhow::Result<Self> {
        let label = Self {
            phase,
            by: by.trim().to_owned(),
            time: Timestamp::now()
                .round(Unit::Second)
                .context("reading the wall clock")?
                .to_string(),
            note: note.map(str::to_owned),
        };
        label.check()?;
        Ok(label)
    }

    fn check(&self) -> anyhow::Result<()> {
        if self.by.trim().is_empty() || self.by.chars().any(char::is_control) {
            bail!("a label by {:?}, expected a person's name", self.by);
        }
        if self.by == JUDGE {
            bail!("a label by `{JUDGE}`, which is the name of the program's own judge");
        }
        if self.time.parse::<Timestamp>().is_err() {
            bail!("a label of {:?}, expected a time such as 2026-11-21T08:00:00Z", self.time);
        }
        Ok(())
    }
}

/// Where the labels of a bag are.
pub fn path_of(bag: &Path) -> PathBuf {
    if bag.is_dir() {
        return bag.join("labels.yaml");
    }
    let name = bag.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split(".mcap").next().unwrap_or_default();
    bag.with_file_name(format!("{stem}.labels.yaml"))
}

/// All labels of a bag, in the order in which they were given; none without a file.
pub fn read(bag: &Path) -> anyhow::Result<Vec<HumanLabel>> {
    let path = path_of(bag);
    read_if_there(&path)?.map_or_else(|| Ok(Vec::new()), |text| parse(&path, &text))
}

/// The label of one person that counts: the last one.
pub fn by<'a>(labels: &'a [HumanLabel], who: &str) -> Option<&'a HumanLabel> {
    labels.iter().rev().find(|label| label.by == who)
}

/// Adds a label to those of a bag, and returns the path of their file; what was there stays as it
/// is, to the byte. A label that would not read back is refused.
pub fn add(bag: &Path, label: &HumanLabel) -> anyhow::Result<PathBuf> {
    let path = path_of(bag);
    let failed = |what: &str| format!("cannot {what} {}", path.display());
    if path.symlink_metadata().is_ok_and(|there| !there.is_file()) {
        bail!("{} is a link or not a regular file, and gets no labels", path.display());
    }
    let mut file = OpenOptions::new()
        .read(true)
        .append(true)
        .create(true)
        .open(&path)
        .with_context(|| failed("open"))?;
    // Until it is closed: two people may label at the same time.
    file.lock().with_context(|| failed("lock"))?;
    let mut before = String::new();
    file.read_to_string(&mut before).with_context(|| failed("read"))?;
    let added = entry(&path, &before, label)?;
    file.write_all(added.as_bytes()).and_then(|()| File::sync_all(&file)).with_context(|| {
        format!("{}; see whether a part of the label is at its end", failed("write to"))
    })?;
    Ok(path)
}

/// Copies the labels of a bag beside another one of the same run, which has none, and returns how
/// many there are.
pub fn carry(from: &Path, to: &Path) -> anyhow::Result<usize> {
    let labels = read(from)?;
    if !labels.is_empty() {
        let (from, to) = (path_of(from), path_of(to));
        // Anew: what somebody has put there stays.
        let copy = || std::io::copy(&mut File::open(&from)?, &mut File::create_new(&to)?);
        copy().with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))?;
    }
    Ok(labels.len())
}

/// What to write behind the labels that are there.
fn entry(path: &Path, before: &str, label: &HumanLabel) -> anyhow::Result<String> {
    let mut expected = parse(path, before)?;
    let yaml = serde_saphyr::to_string(&[label]).context("the label as YAML")?;
    let gap = match before {
        "" => HEAD,
        text if text.ends_with('\n') => "",
        _ => "\n",
    };
    let added = format!("{gap}{}\n", yaml.trim_end());
    expected.push(label.clone());
    let reads_back =
        parse(path, &format!("{before}{added}")).is_ok_and(|labels| labels == expected);
    if !reads_back {
        return Err(with_help(
            format!("{} is not a list to which a label can be added", path.display()),
            "write each label as `- phase: …` at the start of a line, its other keys below",
        ));
    }
    Ok(added)
}

fn parse(path: &Path, text: &str) -> anyhow::Result<Vec<HumanLabel>> {
    let is_comment = |line: &str| line.trim().is_empty() || line.trim_start().starts_with('#');
    if text.lines().all(is_comment) {
        return Ok(Vec::new());
    }
    let name = path.display().to_string();
    let labels: Vec<HumanLabel> = document::parse(&name, text).map_err(|error| {
        let keys: Vec<&str> = Phase::all().map(Phase::key).collect();
        let phases = format!("the phases are: {}", keys.join(", "));
        with_help(error.to_string(), error.help().unwrap_or(phases))
    })?;
    for label in &labels {
        label.check().with_context(|| name.clone())?;
    }
    Ok(labels)
}

/// Whose labels count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Labeller {
    /// Those of the one judge.
    Judge,
    /// Those of this person.
    Human(String),
}

impl FromStr for Labeller {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == JUDGE => Ok(Self::Judge),
            Some(("human", who)) if !who.trim().is_empty() => {
                Ok(Self::Human(who.trim().to_owned()))
            }
            _ => Err(format!("`{text}` is neither `{JUDGE}` nor `human:` and a name")),
        }
    }
}

impl fmt::Display for Labeller {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Judge => formatter.write_str(JUDGE),
            Self::Human(who) => write!(formatter, "human:{who}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(note: &str) -> HumanLabel {
        HumanLabel::now(Phase::SEMI_STABLE_MILLING, "Ana Lima", Some(note)).unwrap()
    }

    #[test]
    fn any_note_reads_back() {
        let path = Path::new("labels.yaml");
        let notes =
            ["plain", "- a: list", "two\nlines\n", "\"quoted\" #tag", "null", "", "12", "  äß 🐝"];
        let mut text = String::new();

        for note in notes {
            let added = entry(path, &text, &label(note)).unwrap();
            text.push_str(&added);
        }

        let read = parse(path, &text).unwrap();
        let read: Vec<&str> = read.iter().map(|label| label.note.as_deref().unwrap()).collect();
        assert_eq!(read, notes);
        assert!(text.starts_with(HEAD) && text.matches('#').count() >= 2);
    }

    #[test]
    fn a_file_without_its_last_line_end_is_added_to() {
        let path = Path::new("labels.yaml");
        let first = entry(path, "", &label("one")).unwrap();

        let second = entry(path, first.trim_end(), &label("two")).unwrap();

        let text = format!("{}{second}", first.trim_end());
        assert_eq!(parse(path, &text).unwrap().len(), 2);
    }

    #[test]
    fn a_list_in_brackets_is_left_alone() {
        let path = Path::new("labels.yaml");
        let text = "[{phase: dispersion, by: ana, time: 2026-11-21T08:00:00Z}]\n";

        let error = entry(path, text, &label("two")).unwrap_err();

        assert_eq!(parse(path, text).unwrap().len(), 1);
        assert!(error.to_string().contains("is not a list to which a label can be added"));
    }

    #[test]
    fn nobody_and_the_judge_cannot_label_by_hand() {
        for who in ["", " ", "judge", "two\nlines"] {
            assert!(HumanLabel::now(Phase::DISPERSION, who, None).is_err(), "{who:?}");
        }
    }
}
