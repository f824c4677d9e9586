//! What was found, in words.

use std::fmt;
use std::path::{Path, PathBuf};

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;

use super::{Explored, FoundController};
use crate::wording::percent;
use crate::wording::shell::{free_beside, quoted};

impl fmt::Display for Explored {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { robot, n_controllers, wanted, found, folder, .. } = self;
        writeln!(formatter, "{robot}: {n_controllers} controllers were tried")?;
        for (index, found) in found.iter().enumerate() {
            writeln!(formatter, "\n{:>3}. {}", index + 1, line(found))?;
            writeln!(formatter, "     {}", elsewhere(found))?;
            for line in commands(found) {
                writeln!(formatter, "     {line}")?;
            }
            let sweep = found.sweep.as_ref().map(|sweep| folder.join(sweep).display().to_string());
            writeln!(formatter, "     {}", sweep.unwrap_or_else(no_sweep))?;
        }
        if let Some(wanted) = wanted.filter(|_| !self.is_found()) {
            writeln!(formatter, "\nno controller surely leads to {wanted} in half of its runs")?;
        }
        write!(formatter, "\npictures: {}", folder.join("gallery.html").display())?;
        if let Some(first) = found.iter().find_map(|found| found.sweep.as_ref()) {
            let sweep = folder.join(first);
            let results = results_of(&sweep);
            let results = if results.exists() { free_beside(&results) } else { results };
            write!(formatter, "\nnext: {}", sweep_command(&sweep, &results))?;
        }
        Ok(())
    }
}

/// `milling: 98 % of 200 runs (95 to 99 %); circling, within reach of each other`.
fn line(found: &FoundController) -> String {
    let FoundController { name, words, share, share_low, share_high, n_replicates, .. } = found;
    format!(
        "{}: {} of {n_replicates} fresh runs (95 % interval {} to {}); {words}",
        name.replace('_', " "),
        percent(*share),
        percent(*share_low),
        percent(*share_high)
    )
}

/// `as measured 96 %; with robots that push each other 12 %, so not with any contact`.
fn elsewhere(found: &FoundController) -> String {
    let FoundController { share_as_measured, other_contact, share_with_other_contact, .. } = found;
    let touching = |contact| match contact {
        ContactModel::Stop => "stop each other",
        ContactModel::Push => "push each other",
        ContactModel::None => "pass through each other",
    };
    let needs = if found.needs_contact { ", so not with any contact" } else { "" };
    format!(
        "as measured {}; with robots that {} {}{needs}",
        percent(*share_as_measured),
        touching(*other_contact),
        percent(*share_with_other_contact)
    )
}

fn commands(found: &FoundController) -> [String; 2] {
    let [detected, undetected] = found.controller.commands();
    let command = |Command { speed_m_s, turn_rate_rad_s }| {
        format!("{speed_m_s} m/s, {turn_rate_rad_s} rad/s")
    };
    [
        format!("something is detected: {}", command(detected)),
        format!("nothing is detected:   {}", command(undetected)),
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
    let behaviours = Behaviour::ALL.map(Behaviour::key).join(", ");
    format!("no sweep: runs are judged for {behaviours}, and this is none of them")
}

/// Below a picture.
pub fn caption(found: &FoundController, folder: &Path) -> Vec<String> {
    let mut lines = vec![line(found), elsewhere(found)];
    lines.extend(commands(found));
    lines.push(found.sweep.as_ref().map_or_else(no_sweep, |sweep| {
        let sweep = folder.join(sweep);
        sweep_command(&sweep, &results_of(&sweep))
    }));
    lines
}
