//! Sweeps by the keys of their files.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_pipeline::error::{help_of, helped, with_help};
use rsrs_pipeline::sweep::source::ResolvedSweep;

use crate::json::keys_as_text;
use crate::profile::Profile;

/// The sweep of the keys of a file; its profile may be an object.
pub fn of_keys(name: &str, keys: &Bound<'_, PyDict>) -> PyResult<anyhow::Result<ResolvedSweep>> {
    let keys = keys.copy()?;
    let robot = match keys.get_item("profile")? {
        Some(profile) => profile.cast::<Profile>().ok().map(|profile| profile.get().0.clone()),
        None => None,
    };
    if let Some(robot) = &robot {
        keys.set_item("profile", &robot.name)?;
    }
    let text = keys_as_text(&keys)?;
    let here = Path::new("");
    let source = match robot {
        None => ResolvedSweep::parse(name, &text, here),
        Some(robot) => SweepFile::parse(name, &text)
            .map_err(helped)
            .and_then(|sweep| ResolvedSweep::of_robot(name, sweep, robot, here)),
    };
    Ok(source.map_err(|error| beside_key(error, &text)))
}

/// Names the key in place of its line, which the caller has not seen.
fn beside_key(error: anyhow::Error, text: &str) -> anyhow::Error {
    let message = error.to_string();
    let place = message.split(':').nth(1).and_then(|line| line.parse::<usize>().ok());
    match place.and_then(|line| text.lines().nth(line.checked_sub(1)?)) {
        Some(line) => {
            let problem = message.splitn(4, ':').nth(3).unwrap_or(&message).trim_start();
            let key = line.trim().trim_end_matches(',').replace('"', "");
            // What is missing is at no line, and brackets are nothing that a caller wrote.
            let is_nowhere = problem.starts_with("missing") || !key.contains(char::is_alphanumeric);
            let at = if is_nowhere { "" } else { &format!(", at `{key}`") };
            let name = message.split(':').next().unwrap_or_default();
            let message = format!("{name}{at}: {problem}");
            match help_of(&error) {
                Some(help) => with_help(message, help),
                None => anyhow::anyhow!(message),
            }
        }
        None => error,
    }
}
