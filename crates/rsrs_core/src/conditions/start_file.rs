//! A table of start poses: where a file puts the robots.

use serde::{Deserialize, Serialize};

use crate::conditions::{Placement, Sides};
use crate::help::Help;
use crate::robot::unicycle::Pose;
use crate::trials::trial::table::{Row, Table};
use crate::trials::trial::{TrialError, TrialProblem};

/// Where robots start, as a person writes it in a sweep or an experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum StartPlacement {
    /// Uniform in a disc, facing away from its centre.
    DiscFacingOut {
        /// Radius of the disc, in metres.
        radius_m: f64,
    },
    /// Uniform in a box around the origin, facing away from its centre.
    BoxFacingOut(Sides),
    /// Uniform in a box around the origin, heading anywhere.
    BoxFacingAnyWay(Sides),
    /// Two robots of a detection trial.
    Pair {
        /// Distance of the two centres, in metres.
        distance_m: f64,
        /// Bearing of the other from the first, in radians; left is positive.
        bearing_rad: f64,
    },
    /// As given by a table.
    File {
        /// Path of the table, relative to the file that names it.
        path: String,
        /// Headings of robots for which the table gives positions only.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        headings: Option<Headings>,
    },
    /// As given by a table that has been read: one set of poses for all replicates, or several that
    /// the replicates take in turn.
    Given {
        /// Shape `[n_sets][n_robots]`.
        starts: Vec<Vec<Pose>>,
    },
}

/// Where robots head of which only the place is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Headings {
    /// Away from the origin.
    FacingOut,
}

impl StartPlacement {
    /// The placement of a world; `None` for a table that has not been read.
    pub fn placement(&self) -> Option<Placement> {
        Some(match *self {
            Self::DiscFacingOut { radius_m } => Placement::DiscFacingOut { radius_m },
            Self::BoxFacingOut(sides) => Placement::BoxFacingOut(sides),
            Self::BoxFacingAnyWay(sides) => Placement::BoxFacingAnyWay(sides),
            Self::Pair { distance_m, bearing_rad } => Placement::Pair { distance_m, bearing_rad },
            Self::File { .. } => return None,
            Self::Given { ref starts } => Placement::Given { starts: starts.clone() },
        })
    }
}

/// What a table of start poses holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Starts {
    /// Names of the robots, in the order of the table; empty if it names none.
    pub robots: Vec<String>,
    /// Shape `[n_sets][n_robots]`.
    pub starts: Vec<Vec<Pose>>,
}

/// Why a table of start poses was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StartFileError {
    /// The table is none, or a number in it cannot be meant.
    #[error(transparent)]
    Table(#[from] TrialError),
    /// Neither the table nor the file gives headings.
    #[error("{file}: no column `heading_rad`, so the robots' headings are unknown")]
    NoHeadings {
        /// The table.
        file: String,
    },
    /// Both give headings.
    #[error(
        "{file}: the column `heading_rad` and `headings: facing_out` both state where robots head"
    )]
    HeadingsTwice {
        /// The table.
        file: String,
    },
    /// The sets of poses are not numbered 0, 1, 2, ….
    #[error(
        "{file}:{line}: replicate is {found}, expected {expected}: sets are numbered from 0, in order"
    )]
    Replicate {
        /// The table.
        file: String,
        /// Line of the table, from 1.
        line: u64,
        /// The number found.
        found: u64,
        /// What it may be.
        expected: String,
    },
    /// A set has other robots than the first.
    #[error("{file}: replicate {replicate} has {found}, expected {expected} as replicate 0")]
    OtherRobots {
        /// The table.
        file: String,
        /// Number of the set.
        replicate: usize,
        /// Its robots.
        found: String,
        /// Those of the first set.
        expected: String,
    },
    /// A robot stands in a set twice.
    #[error("{file}:{line}: {robot} has a place already")]
    RobotTwice {
        /// The table.
        file: String,
        /// Line of the table, from 1.
        line: u64,
        /// The robot.
        robot: String,
    },
}

impl Help for StartFileError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Table(error) => match error.problem {
                TrialProblem::Unit { .. } => error.help(),
                _ => Some(
                    "the header is `robot,x_m,y_m,heading_rad`; `rsrs place EXPERIMENT \
                           --format json` shows poses of the simulator's"
                        .to_owned(),
                ),
            },
            Self::NoHeadings { .. } => {
                Some(
                    "add the column, or, where a file names the table under `placement`, `headings: facing_out` beside \
                     `path`"
                        .to_owned(),
                )
            }
            Self::HeadingsTwice { .. } => Some("keep one of them".to_owned()),
            Self::Replicate { .. } | Self::OtherRobots { .. } | Self::RobotTwice { .. } => None,
        }
    }
}

const X: usize = 0;
const Y: usize = 1;
const ROBOT: usize = 2;
const HEADING: usize = 3;
const REPLICATE: usize = 4;

/// A small robot does not start further from the origin; a larger coordinate is one in millimetres.
const MOST_M: f64 = 100.0;
/// A full turn and a rounding error; a larger heading is one in degrees.
const MOST_RAD: f64 = 6.3;

/// Reads a table of start poses, which errors call `file`.
///
/// Its columns are `x_m`, `y_m`, and where they are wanted `robot`, `heading_rad` (without it robots
/// head as `headings` says), and `replicate` for several sets of poses, numbered from 0. The origin is
/// the centre of the arena. Numbers are taken to the ninth decimal. Robots that overlap are found only
/// where their size is known.
///
/// # Example
///
/// ```
/// use rsrs_core::conditions::start_file::{Headings, read_starts};
///
/// let starts = read_starts("starts.csv", "x_m,y_m\n0.5,0\n0,-0.5\n", Some(Headings::FacingOut))?;
/// assert_eq!(starts.starts[0][1].heading_rad, -1.570796327);
/// # Ok::<(), rsrs_core::conditions::start_file::StartFileError>(())
/// ```
pub fn read_starts(
    file: &str,
    text: &str,
    headings: Option<Headings>,
) -> Result<Starts, StartFileError> {
    let mut table =
        Table::open(file, text, &["x_m", "y_m"], &["robot", "heading_rad", "replicate"])?;
    match (table.has(HEADING), headings) {
        (false, None) => return Err(StartFileError::NoHeadings { file: file.to_owned() }),
        (true, Some(_)) => return Err(StartFileError::HeadingsTwice { file: file.to_owned() }),
        _ => {}
    }
    let (is_named, has_sets) = (table.has(ROBOT), table.has(REPLICATE));
    let mut sets: Vec<(Vec<String>, Vec<Pose>)> = Vec::new();
    while let Some(row) = table.next_row()? {
        let replicate = if has_sets { row.count(REPLICATE)? } else { 0 };
        let n_sets = sets.len() as u64;
        if replicate == n_sets {
            sets.push(Default::default());
        } else if replicate + 1 != n_sets {
            let expected = match n_sets {
                0 => "0".to_owned(),
                _ => format!("{} or {n_sets}", n_sets - 1),
            };
            let (file, line) = (file.to_owned(), row.line);
            return Err(StartFileError::Replicate { file, line, found: replicate, expected });
        }
        let (robots, poses) = sets.last_mut().expect("the first row makes one");
        poses.push(pose(&row, headings)?);
        if is_named {
            let robot = row.name(ROBOT)?.to_owned();
            if robots.contains(&robot) {
                return Err(StartFileError::RobotTwice {
                    file: file.to_owned(),
                    line: row.line,
                    robot,
                });
            }
            robots.push(robot);
        }
    }
    if sets.is_empty() {
        return Err(table.refuse(TrialProblem::NoRows).into());
    }
    same_robots(file, &sets)?;
    let robots = sets[0].0.clone();
    Ok(Starts { robots, starts: sets.into_iter().map(|(_, poses)| poses).collect() })
}

fn pose(row: &Row<'_, '_>, headings: Option<Headings>) -> Result<Pose, TrialError> {
    let (x_m, y_m) = (row.number(X)?, row.number(Y)?);
    row.below(X, x_m, MOST_M, "millimetres")?;
    row.below(Y, y_m, MOST_M, "millimetres")?;
    let heading_rad = match headings {
        Some(Headings::FacingOut) => libm::atan2(y_m, x_m),
        None => row.number(HEADING)?,
    };
    row.below(HEADING, heading_rad, MOST_RAD, "degrees")?;
    Ok(Pose { x_m: tidy(x_m), y_m: tidy(y_m), heading_rad: tidy(heading_rad) })
}

/// A number to the ninth decimal: few enough digits for every parser to read back the same bits, and
/// no robot is set down to the nanometre.
fn tidy(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}

fn same_robots(file: &str, sets: &[(Vec<String>, Vec<Pose>)]) -> Result<(), StartFileError> {
    let (first, poses) = &sets[0];
    let named = |robots: &[String], poses: &[Pose]| match robots {
        [] => format!("{} robots", poses.len()),
        _ => format!("robots {}", robots.join(", ")),
    };
    for (replicate, (robots, others)) in sets.iter().enumerate() {
        if (robots, others.len()) != (first, poses.len()) {
            let (found, expected) = (named(robots, others), named(first, poses));
            let file = file.to_owned();
            return Err(StartFileError::OtherRobots { file, replicate, found, expected });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn refusal(text: &str, headings: Option<Headings>) -> String {
        read_starts("starts.csv", text, headings).unwrap_err().to_string()
    }

    #[test]
    fn a_table_gives_the_starts_of_one_replicate_or_of_each() {
        let one = "robot,x_m,y_m,heading_rad\nb,0.5,0,1.5\na,-0.5,0,3\n";
        let each = "replicate,x_m,y_m\n0,0.5,0\n0,-0.5,0\n1,0,0.5\n1,0,-0.5\n";

        let one = read_starts("starts.csv", one, None).unwrap();
        let each = read_starts("starts.csv", each, Some(Headings::FacingOut)).unwrap();

        assert_eq!(one.robots, ["b", "a"]);
        assert_eq!(
            one.starts,
            [[(0.5, 1.5), (-0.5, 3.0)].map(|(x_m, heading_rad)| Pose {
                x_m,
                y_m: 0.0,
                heading_rad
            })]
        );
        assert_eq!((each.robots.len(), each.starts.len()), (0, 2));
        let quarter_turns = each.starts[1].iter().map(|pose| pose.heading_rad / FRAC_PI_2);
        // Files have nine digits.
        let rounded: Vec<f64> = quarter_turns.map(|turns| (turns * 1e9).round() / 1e9).collect();
        assert_eq!(rounded, [1.0, -1.0]);
    }

    #[test]
    fn poses_have_the_same_bits_after_they_were_written_and_read() {
        let rows: String = (1..2000)
            .map(|row| {
                let (x_m, y_m) = (0.7 * libm::sin(f64::from(row)), 3.0 / f64::from(row));
                [x_m.to_string(), y_m.to_string()].join(",") + "\n"
            })
            .collect();
        let text = format!("x_m,y_m\n{rows}");
        let starts = read_starts("starts.csv", &text, Some(Headings::FacingOut)).unwrap().starts;

        let json = serde_json::to_string(&starts).unwrap();
        let yaml = serde_saphyr::to_string(&starts).unwrap();

        assert_eq!(serde_json::from_str::<Vec<Vec<Pose>>>(&json).unwrap(), starts);
        assert_eq!(serde_saphyr::from_str::<Vec<Vec<Pose>>>(&yaml).unwrap(), starts);
    }

    #[test]
    fn ambiguous_tables_are_refused_with_their_line() {
        let out = Some(Headings::FacingOut);
        for (text, headings, expected) in [
            ("x_m,y_m\n1,2\n", None, "starts.csv: no column `heading_rad`"),
            ("x_m,y_m,heading_rad\n1,2,3\n", out, "both state where robots head"),
            ("x_m,y_m\n", out, "starts.csv:1: the table has a header and no rows"),
            ("x_m,y_m\n500,20\n", out, "starts.csv:2: x_m is 500: this looks like millimetres"),
            ("x_m,y_m,heading_rad\n1,2,90\n", None, "heading_rad is 90: this looks like degrees"),
            ("x_m,y_m\n1,inf\n", out, "starts.csv:2: y_m is inf, expected a finite number"),
            ("robot,x_m,y_m\na,1,2\na,2,2\n", out, "starts.csv:3: a has a place already"),
            ("replicate,x_m,y_m\n1,1,2\n", out, "starts.csv:2: replicate is 1, expected 0"),
            ("replicate,x_m,y_m\n0,1,2\n2,1,2\n", out, "replicate is 2, expected 0 or 1"),
            (
                "replicate,x_m,y_m\n0,1,2\n1,1,2\n1,2,2\n",
                out,
                "replicate 1 has 2 robots, expected 1 robots as replicate 0",
            ),
        ] {
            let error = refusal(text, headings);

            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
