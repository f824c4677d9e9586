//! The table of start poses that an experiment names.

use std::path::Path;

use anyhow::bail;
use rsrs_core::conditions::start_file::{StartPlacement, read_starts};
use rsrs_core::help::Helpful;
use rsrs_fleet::fleet_file::FleetRobot;

use super::read as read_file;

/// A table of start poses, as read.
pub struct StartTable {
    /// Where it is.
    pub name: String,
    /// The table, which goes into the bag.
    pub text: String,
    robots: Vec<String>,
}

/// Reads the table that a placement names, if it names one, and puts what it holds in its place.
pub fn read(placement: &mut StartPlacement, beside: &Path) -> anyhow::Result<Option<StartTable>> {
    let StartPlacement::File { path, headings } = placement else { return Ok(None) };
    let (name, text) = read_file(&beside.join(path))?;
    let starts = read_starts(&name, &text, *headings).map_err(Helpful::from)?;
    *placement = StartPlacement::Given { starts: starts.starts };
    Ok(Some(StartTable { name, text, robots: starts.robots }))
}

impl StartTable {
    /// Refuses a table whose names are not those of the run's robots, in the fleet's order: another
    /// robot would be put where one of them is meant.
    pub fn check(&self, robots: &[FleetRobot]) -> anyhow::Result<()> {
        let pairs = self.robots.iter().zip(robots);
        for (row, (found, expected)) in pairs.enumerate() {
            if *found != expected.name {
                bail!(
                    "{}: start pose {} is that of {found}, expected {} as in the fleet file",
                    self.name,
                    row + 1,
                    expected.name
                );
            }
        }
        Ok(())
    }
}
