//! What is on the screen.

use std::time::Duration;

use rsrs_core::printable::one_line;
use rsrs_fleet::observation::{Observation, SwarmOrder};

use super::look::{BannerKind, Look};

/// What is on the screen.
pub struct View<'a> {
    /// What is seen.
    pub observation: &'a Observation,
    /// The time of it.
    pub now: Duration,
    /// Order parameters and phase; `None` while nothing has moved.
    pub order: Option<SwarmOrder>,
    /// Where it comes from: an interface, or a bag.
    pub place: &'a str,
    /// How far a recording is; `None` for a fleet that runs.
    pub timeline: Option<Timeline>,
    /// A line that nobody should overlook.
    pub banner: Option<Banner>,
    /// The first row of the table, if it does not fit.
    pub first_row: usize,
    /// Whether the keys, and what the words mean, lie over all.
    pub shows_help: bool,
    pub look: Look,
}

/// How far a recording is.
#[derive(Clone, Copy, Debug)]
pub struct Timeline {
    /// From its beginning.
    pub at: Duration,
    /// All of it.
    pub duration: Duration,
    /// Seconds of it in one second.
    pub pace: f64,
    /// Whether it goes on.
    pub state: PlayState,
}

/// Whether a recording goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayState {
    Plays,
    Paused,
    /// It is at its end.
    Over,
}

/// A line that nobody should overlook.
#[derive(Clone, Debug)]
pub struct Banner {
    pub text: String,
    /// What it is about.
    pub kind: BannerKind,
}

impl Banner {
    /// What robots say is wrong with them; `None` if none does.
    pub fn of_faults(observation: &Observation, now: Duration) -> Option<Self> {
        let mut faults = observation.faults(now);
        let (robot, part, message) = faults.next()?;
        let whose = if part.contains(robot) { String::new() } else { format!("{robot}: ") };
        let more = match faults.count() {
            0 => String::new(),
            n => format!(", and {n} more"),
        };
        let text = format!("{whose}{part}: {message}{more}");
        Some(Self { text: one_line(&text).into_owned(), kind: BannerKind::Alarm })
    }
}
