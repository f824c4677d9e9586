//! A plan on paper, and as tables to fill in.

use std::fmt::Write as _;

use super::Plan;
use crate::trials::trial::TrialKind;

/// Time that placing robots by hand and writing down a result take for one trial, in seconds.
const BY_HAND_S: f64 = 60.0;

impl Plan {
    /// The sheet to print.
    pub fn text(&self) -> String {
        let n_robots = self.robots.len();
        let n_straight = n_robots * self.speeds_m_s.len() * self.repetitions;
        let n_turns = n_robots * self.turn_rates_rad_s.len() * self.repetitions;
        let n_places = self.distances_m.len() * self.bearings_rad.len();
        let request = &self.request;
        let mut text = String::new();
        let mut line = |words: String| {
            writeln!(text, "{words}").expect("a string takes all");
        };
        line(format!("Trials of {n_robots} robots: {}", self.robots.join(", ")));
        line(String::new());
        line(format!("1  Straight runs: {n_straight}, over a track of {} m", request.track_m));
        line(format!("   speeds: {}", listed(&self.speeds_m_s, ("m/s", 100.0, " cm/s"))));
        line(format!(
            "   {} times each; write down the time, and where the robot ended:",
            self.repetitions
        ));
        line("   lateral_m beside the line (left is positive), heading_change_rad (left is positive)".to_owned());
        line(format!("2  Turns in place: {n_turns}, a full circle (6.2832 rad, 360°) each"));
        line(format!("   rates: {}", listed(&self.turn_rates_rad_s, ("rad/s", DEGREES, "°/s"))));
        line(format!("   {} times each; write down the time", self.repetitions));
        line(format!(
            "3  Arcs: {n_turns}, the same turns while driving at {} m/s ({} cm/s); write down the time",
            self.arc_speed_m_s,
            tenths(100.0 * self.arc_speed_m_s)
        ));
        line(format!(
            "4  Detections: one robot, another at {n_places} places, {} readings each",
            self.samples
        ));
        let distances = listed(&self.distances_m, ("m", 100.0, " cm"));
        line(format!("   distances, centre to centre: {distances}"));
        let bearings = listed(&self.bearings_rad, ("rad", DEGREES, "°"));
        line(format!("   bearings, left is positive: {bearings}"));
        line(format!(
            "5  False positives: {} readings of each robot alone, {:.0} s in all",
            self.samples_alone, self.false_positive_s
        ));
        line("6  Period: 20 control periods of each robot, from its log or a bag".to_owned());
        line(String::new());
        line(self.time_in_words(n_straight + 2 * n_turns + n_places + n_robots));
        line(format!(
            "Expected precision: each gain (measured over commanded) to ±{} (if trials of a robot differ by \
             {}), each rate of detections to ±{}, at 95 %.",
            request.gain_precision, request.trial_sd, request.rate_precision
        ));
        text
    }

    /// What all of it takes: most of it is not driving.
    fn time_in_words(&self, n_trials: usize) -> String {
        let time = |time_s: f64| match (time_s / 60.0).ceil() {
            minutes if minutes < 60.0 => format!("{minutes} min"),
            minutes => format!("{:.1} h", minutes / 60.0),
        };
        let by_hand_s = n_trials as f64 * BY_HAND_S;
        format!(
            "About {} in all: {} of driving and reading, and {} by hand, if placing and writing down take \
             {:.0} min for each of the {n_trials} trials.",
            time(self.duration_s + by_hand_s),
            time(self.duration_s),
            time(by_hand_s),
            BY_HAND_S / 60.0
        )
    }

    /// The table of straight runs, to fill in.
    pub fn speed_csv(&self) -> String {
        let rows = self.repeated(&self.speeds_m_s);
        let rows =
            rows.map(|(robot, speed)| format!("{robot},{speed},{},,,,,\n", self.request.track_m));
        table(TrialKind::Speed, rows)
    }

    /// The table of turns in place, to fill in.
    pub fn turn_csv(&self) -> String {
        let rows = self.repeated(&self.turn_rates_rad_s);
        let rows = rows.map(|(robot, rate)| format!("{robot},{rate},6.283185,,,\n"));
        table(TrialKind::Turn, rows)
    }

    /// The table of turns while driving, to fill in.
    pub fn arc_csv(&self) -> String {
        let speed = self.arc_speed_m_s;
        let rows = self.repeated(&self.turn_rates_rad_s);
        let rows = rows.map(|(robot, rate)| format!("{robot},{speed},{rate},6.283185,,,\n"));
        table(TrialKind::Arc, rows)
    }

    /// The table of detections, to fill in; the last rows are without a neighbour.
    pub fn detection_csv(&self) -> String {
        let (first, samples) = (&self.robots[0], self.samples);
        let places = self.bearings_rad.iter().flat_map(|bearing_rad| {
            self.distances_m
                .iter()
                .map(move |distance_m| format!("{first},{distance_m},{bearing_rad},{samples},,\n"))
        });
        let n_alone = self.samples_alone;
        let alone = self.robots.iter().map(|robot| format!("{robot},,,{n_alone},,\n"));
        table(TrialKind::Detection, places.chain(alone))
    }

    /// The table of control periods, to fill in.
    pub fn period_csv(&self) -> String {
        let rows = self.robots.iter().map(|robot| format!("{robot},,\n").repeat(20));
        table(TrialKind::Period, rows)
    }

    /// Every robot with every command, as often as planned, in the order in which they are driven:
    /// all commands once, then again, so that a battery running down spreads over all of them.
    fn repeated<'a>(&'a self, commands: &'a [f64]) -> impl Iterator<Item = (&'a str, f64)> {
        self.robots.iter().flat_map(move |robot| {
            (0..self.repetitions)
                .flat_map(move |_| commands.iter().map(move |command| (robot.as_str(), *command)))
        })
    }
}

/// A table with these rows.
fn table(kind: TrialKind, rows: impl Iterator<Item = String>) -> String {
    let header = kind.header();
    std::iter::once(format!("{header}\n")).chain(rows).collect()
}

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Numbers in the unit of the tables and in that of a tape or protractor, of which the former has
/// `factor`: `0.15, 0.3 m (15, 30 cm)`.
fn listed(numbers: &[f64], (unit, factor, other): (&str, f64, &str)) -> String {
    let list = |texts: Vec<String>| texts.join(", ");
    let usual = list(numbers.iter().map(ToString::to_string).collect());
    let others = list(numbers.iter().map(|number| tenths(number * factor)).collect());
    format!("{usual} {unit} ({others}{other})")
}

/// A number to one decimal, without a zero there.
fn tenths(number: f64) -> String {
    ((number * 10.0).round() / 10.0).to_string()
}
