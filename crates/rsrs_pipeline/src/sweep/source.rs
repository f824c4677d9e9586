//! A sweep with its profile: read from a person's files, or back from a result folder.

use std::path::Path;

use rsrs_core::conditions::Conditions;
use rsrs_core::conditions::controller_table::{ControllerSource, ControllerTable};
use rsrs_core::conditions::start_file::{Headings, StartPlacement, Starts, read_starts};
use rsrs_core::diagram::folder::SweptSource;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::document::{self, DocumentError};
use rsrs_core::judge::behaviour::named::NamedBehaviour;
use rsrs_core::judge::behaviour::{Behaviour, unknown};
use rsrs_core::quantity::Cell;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::robot::profile::{ProfileError, RobotProfile};
use rsrs_core::world::{WorldFile, WorldSource};
use rsrs_fleet::fleet_file::FleetFile;
use serde::{Deserialize, Serialize};

use crate::error::{WithHelp, helped, with_help};
use crate::files::read_text;
use crate::measure::plan_folder::enabled_robots;
use crate::provenance::ResultProvenance;

/// A sweep that needs no other file: what `sweep.yaml` in a result folder holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedSweep {
    /// The sweep as written, defaults filled in.
    pub sweep: SweepFile,
    /// The measured robot.
    pub profile: RobotProfile,
    /// Where the results come from.
    pub provenance: ResultProvenance,
}

/// Which program made a result, beside what was swept.
#[derive(Serialize, Deserialize)]
struct Made {
    provenance: ResultProvenance,
}

impl ResolvedSweep {
    /// Reads a sweep file and the profile that it names.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        Self::parse(&name, &read_text(path)?, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads the text of a sweep file, called `name` in errors, and the profile that it names, relative to
    /// the folder `beside`.
    pub fn parse(name: &str, text: &str, beside: &Path) -> anyhow::Result<Self> {
        let sweep = SweepFile::parse(name, text).map_err(helped)?;
        let profile = read_profile(&beside.join(&sweep.profile)).map_err(named(name, "profile"))?;
        Self::of_robot(name, sweep, profile, beside)
    }

    /// A sweep of this robot, whatever profile it names; its table of starts, its controller, its
    /// world and its behaviour are relative to the folder `beside`. What cannot be read of these is
    /// named as a key of the file `name`.
    pub fn of_robot(
        name: &str,
        mut sweep: SweepFile,
        profile: RobotProfile,
        beside: &Path,
    ) -> anyhow::Result<Self> {
        if let Some(StartPlacement::File { path, headings }) = &sweep.placement {
            let starts = read_start_table(&beside.join(path), *headings)
                .map_err(named(name, "placement"))?;
            sweep.placement = Some(StartPlacement::Given { starts: starts.starts });
        }
        if let Some(ControllerSource::File(path)) = &sweep.controller {
            let table =
                read_controller(&beside.join(path), &profile).map_err(named(name, "controller"))?;
            sweep.controller = Some(ControllerSource::Read(table));
        }
        if let NamedBehaviour::File(path) = &sweep.behaviour {
            let behaviour = read_behaviour(&beside.join(path)).map_err(named(name, "behaviour"))?;
            sweep.behaviour = NamedBehaviour::Known(behaviour);
        }
        if let Some(WorldSource::File(path)) = &sweep.world {
            let world =
                read_world(&beside.join(path), &sweep.arenas_m(), &sweep.numbers_of_robots())
                    .map_err(named(name, "world"))?;
            sweep.world = Some(WorldSource::Read(world));
        }
        sweep.harsher = Harsher::from(sweep.factors(&profile));
        let provenance = ResultProvenance::new(&profile);
        Ok(Self { sweep, profile, provenance })
    }

    /// Reads the text of `sweep.yaml` in a result folder, called `file` in errors.
    pub fn parse_result(file: &str, text: &str) -> Result<Self, DocumentError> {
        let SweptSource { sweep, profile, .. } = SweptSource::parse(file, text)?;
        let Made { provenance } = document::parse(file, text)?;
        Ok(Self { sweep, profile, provenance })
    }

    /// The text of `sweep.yaml` in a result folder.
    pub fn to_yaml(&self) -> String {
        let Self { sweep, profile, provenance } = self;
        let made = Made { provenance: provenance.clone() };
        SweptSource::to_yaml(sweep, profile) + &document::to_yaml(&made)
    }

    /// Reads a sweep file and its profile, or what a sweep has left of both in its result folder.
    pub fn read_either(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = read_text(path)?;
        // No key of a sweep file is called so.
        if !text.lines().any(|line| line.starts_with("sweep:")) {
            return Self::read(path);
        }
        let SweptSource { sweep, profile, .. } = SweptSource::parse(&name, &text)?;
        sweep.check(&name).map_err(helped)?;
        let provenance = ResultProvenance::new(&profile);
        Ok(Self { sweep, profile, provenance })
    }

    /// The same sweep with the robots as measured; `None` if it is that already.
    pub fn as_measured(&self) -> Option<Self> {
        let none = Harsher::from(HarsherFactors::NONE);
        let sweep = SweepFile { harsher: none, ..self.sweep.clone() };
        (self.sweep.harsher != sweep.harsher).then(|| Self { sweep, ..self.clone() })
    }

    /// The same sweep with the robots of one class alone: they have that class's profile, and no class has another.
    pub fn of_class(&self, class: &str) -> anyhow::Result<Self> {
        let classes = self.sweep.world().map_or(&[][..], |world| &world.classes);
        let Some(found) = classes.iter().find(|it| it.name == class) else {
            let names: Vec<&str> = classes.iter().map(|class| class.name.as_str()).collect();
            return Err(if names.is_empty() {
                with_help(
                    format!("there are no classes of robots, and `{class}` is to be one"),
                    "leave the class out: all robots have the profile of the sweep",
                )
            } else {
                let help = format!("the classes are: {}", names.join(", "));
                with_help(format!("there is no class `{class}`"), help)
            });
        };
        let profile = found.profile_or(&self.profile).clone();
        let world = self.sweep.world().map(WorldFile::without_profiles);
        let given = self.sweep.harsher.decided(&self.profile);
        let sweep = SweepFile {
            harsher: Harsher::from(given.factors(&profile)),
            world: world.map(WorldSource::Read),
            ..self.sweep.clone()
        };
        let provenance = ResultProvenance::new(&profile);
        Ok(Self { sweep, profile, provenance })
    }

    /// Whether a class has a profile of its own.
    pub fn has_profiles_of_classes(&self) -> bool {
        self.sweep.world().is_some_and(|world| world.profiles().next().is_some())
    }

    /// Refuses, where a class has a profile of its own, what is done with one profile: `what`
    /// states that as a clause.
    pub fn refuse_profiles_of_classes(&self, what: &str) -> anyhow::Result<()> {
        let mut profiles = self.sweep.world().into_iter().flat_map(WorldFile::profiles);
        profiles.next().map_or(Ok(()), |(class, _)| {
            Err(with_help(
                format!("class {class} has a profile of its own, and {what}"),
                "leave `profile` out of the classes of the world, and ask it of each profile by itself",
            ))
        })
    }

    /// Names the results of this sweep: 16 hexadecimal digits.
    pub fn digest(&self) -> String {
        self.sweep.digest(&self.profile)
    }

    /// The cells with their conditions.
    pub fn cells(&self, file: &str) -> anyhow::Result<Vec<(Cell, Conditions)>> {
        self.sweep.resolve(file, &self.profile).map_err(helped)
    }

    /// The conditions of one cell, by its index in the order of [`ResolvedSweep::cells`].
    pub fn conditions_of(&self, index: usize) -> anyhow::Result<Conditions> {
        Ok(self.cells("sweep.yaml")?.swap_remove(index).1)
    }
}

/// States which key of which file names one that cannot be read; one that is read and is wrong has
/// a line of its own to be mended.
fn named<'a>(file: &'a str, key: &'a str) -> impl FnOnce(anyhow::Error) -> anyhow::Error + 'a {
    move |error| {
        if error.downcast_ref::<std::io::Error>().is_none() {
            return error;
        }
        helped(WithHelp {
            message: format!("{file}: the file that `{key}` names cannot be read"),
            help: format!("write its path as it is from the folder of {file}"),
            cause: Some(error.into()),
        })
    }
}

/// Reads a table of start poses; that names of robots are in it does not count where all are alike.
fn read_start_table(path: &Path, headings: Option<Headings>) -> anyhow::Result<Starts> {
    let name = path.display().to_string();
    let text = read_text(path)?;
    read_starts(&name, &text, headings).map_err(helped)
}

/// Reads a controller's table, for robots of this profile.
pub fn read_controller(path: &Path, profile: &RobotProfile) -> anyhow::Result<ControllerTable> {
    let name = path.display().to_string();
    ControllerTable::parse(&name, &read_text(path)?, profile).map_err(helped)
}

/// Reads what is in arenas of these sides, in metres, besides so many robots, and the profiles of classes.
pub fn read_world(path: &Path, arenas_m: &[f64], robots: &[usize]) -> anyhow::Result<WorldFile> {
    let name = path.display().to_string();
    let mut world = WorldFile::parse(&name, &read_text(path)?, arenas_m, robots).map_err(helped)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    world.read_profiles(|of_class| {
        read_profile(&beside.join(of_class)).map_err(named(&name, "profile"))
    })?;
    Ok(world)
}

/// What swarms are judged for, by its name or the path of its file, as people type it.
pub fn behaviour(text: &str) -> anyhow::Result<Behaviour> {
    if NamedBehaviour::is_path(text) {
        return read_behaviour(Path::new(text));
    }
    Behaviour::from_key(text).ok_or_else(|| anyhow::anyhow!(unknown(text)))
}

/// Reads what swarms are judged for.
pub fn read_behaviour(path: &Path) -> anyhow::Result<Behaviour> {
    Behaviour::parse(&path.display().to_string(), &read_text(path)?).map_err(helped)
}

/// Reads a profile.
pub fn read_profile(path: &Path) -> anyhow::Result<RobotProfile> {
    let name = path.display().to_string();
    let text = read_text(path)?;
    RobotProfile::parse(&name, &text).map_err(|error| match error {
        // They name the file and the line themselves.
        error @ (ProfileError::Document(_) | ProfileError::SensorAt { .. }) => helped(error),
        error => helped(error).context(format!("{name} does not describe a robot")),
    })
}

/// How many robots the fleet has whose file, `fleet.yaml`, lies beside a profile; `None` if there is none.
pub fn robots_beside(profile: &Path) -> anyhow::Result<Option<usize>> {
    let path = profile.with_file_name(FleetFile::NAME);
    if !path.exists() {
        return Ok(None);
    }
    Ok(Some(enabled_robots(&path)?.len()).filter(|n_robots| *n_robots > 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again_in_three_parts() {
        let sweep = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../launch_configs/sweeps/flockbot_speed_turn.yaml"
        );
        let source = ResolvedSweep::read(Path::new(sweep)).unwrap();

        let text = source.to_yaml();

        let is_part = |line: &&str| !line.starts_with([' ', '-', '#']);
        let parts: Vec<&str> = text.lines().filter(is_part).collect();
        assert_eq!(parts, ["sweep:", "profile:", "provenance:"]);
        assert_eq!(ResolvedSweep::parse_result("sweep.yaml", &text).unwrap(), source);
    }
}
