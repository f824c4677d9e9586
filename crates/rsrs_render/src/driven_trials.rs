//! What people read of driven trials: what is to be done for one, and what they came to.

use std::path::{Path, PathBuf};

use rsrs_core::numerals::counted;
use rsrs_core::trials::trial::{Neighbour, Trial};
use rsrs_files::quoted;
use serde::Serialize;

/// Where the sheet and the tables of a plan are, and what comes next: for the robots of a fleet file, and with the
/// radius of their bodies, in metres, where these were given.
pub fn planned(folder: &Path, fleet: Option<&Path>, radius_m: Option<f64>) -> String {
    let fleet = fleet.map_or_else(|| "FLEET".to_owned(), quoted);
    let radius = radius_m.map_or_else(String::new, |radius_m| format!(" --radius {radius_m}"));
    let shown = folder.display();
    let folder = quoted(folder);
    format!(
        "\nThe sheet and the tables to fill in are in {shown}.\n\
         next: rsrs measure drive {fleet} --plan {folder} --backend fleet --interface NAME   # or fill \
         them in by hand\n\
         then: rsrs measure fit --plan {folder} --name NAME{radius} -o PROFILE.yaml\n"
    )
}

/// What a person is to do before a trial of a robot.
pub fn instruction(robot: &str, trial: &Trial) -> String {
    let neighbour = match trial {
        Trial::Stand { neighbour: Some(neighbour), .. } => neighbour,
        Trial::Stand { neighbour: None, .. } => {
            return format!("{robot} alone: take away all that it could detect");
        }
        Trial::Drive { command, duration_s } => {
            return format!(
                "clear the floor around {robot}: it drives at {} m/s and {} rad/s for {duration_s} s",
                command.speed_m_s, command.turn_rate_rad_s
            );
        }
    };
    let Neighbour { distance_m, bearing_rad } = *neighbour;
    let side = if bearing_rad > 0.0 { "to the left" } else { "to the right" };
    let bearing = if bearing_rad == 0.0 {
        "straight ahead of it".to_owned()
    } else {
        let degrees = bearing_rad.abs().to_degrees();
        format!("{:.3} rad ({degrees:.1}°) {side}", bearing_rad.abs())
    };
    format!("put another robot {distance_m:.3} m from {robot}, {bearing}, centre to centre")
}

/// What a robot does in a trial.
pub(crate) fn description(robot: &str, trial: &Trial) -> String {
    match trial {
        Trial::Drive { command, duration_s } => format!(
            "{robot} drives at {} m/s and {} rad/s for {duration_s} s",
            command.speed_m_s, command.turn_rate_rad_s
        ),
        Trial::Stand { neighbour: None, samples } => {
            format!("{robot} stands alone for {samples} readings")
        }
        Trial::Stand { neighbour: Some(Neighbour { distance_m, bearing_rad }), samples } => {
            format!(
                "{robot} stands with another {distance_m:.3} m away at {bearing_rad:.3} rad, for \
                 {samples} readings"
            )
        }
    }
}

/// What filling in tables of trials came to.
#[derive(Clone, Debug, Serialize)]
pub struct Filled {
    /// The table, or the folder of the plan.
    pub table: PathBuf,
    /// Of one table that was filled in alone, what `rsrs measure fit` calls it.
    #[serde(skip)]
    pub only: Option<&'static str>,
    /// Rows that were filled in now.
    pub n_filled: usize,
    /// Rows that are still without a result.
    pub n_left: usize,
    /// How often a trial is made one after the other, while commands pause in it.
    #[serde(skip)]
    pub n_attempts: usize,
    /// Of the rows left, those that have a result in which commands paused.
    pub n_paused: usize,
    /// Messages that the middleware lost.
    pub n_lost: u64,
}

impl Filled {
    /// Whether no trial lost messages, and in none commands paused.
    pub fn is_whole(&self) -> bool {
        self.n_lost == 0 && self.n_paused == 0
    }
}

/// How far the tables are filled in, and what comes next.
pub fn filled(filled: &Filled) -> String {
    let Filled { only, n_filled, n_left, n_attempts, n_paused, n_lost, .. } = filled;
    let table = filled.table.display();
    let mut lines =
        vec![format!("{table}: {} filled in, {n_left} left", counted(*n_filled as u64, "row"))];
    if *n_paused > 0 {
        lines.push(format!(
            "in {n_paused} of those left commands paused in {n_attempts} trials one after the \
             other: `paused_s` states for how long; give this machine less to do, or the robots \
             a better network"
        ));
    }
    if *n_lost > 0 {
        lines.push(format!("{} lost on the way to the bags", counted(*n_lost, "message")));
    }
    lines.push(match (n_left, only) {
        (0, Some(option)) => format!("next: rsrs measure fit --{option} {table} … --name NAME"),
        (0, None) => format!("next: rsrs measure fit --plan {table} --name NAME -o PROFILE.yaml"),
        _ => "next: the same command again; it goes on with the rows that are left".to_owned(),
    });
    lines.join("\n")
}

/// The result of one trial: where it was recorded, its row as a `table`, and whether commands paused.
pub fn single(bag: &Path, table: &str, paused_s: Option<f64>) -> String {
    let paused = paused_s.map_or_else(String::new, |paused_s| format!("\n{}", pause(paused_s)));
    format!("{}:\n{table}{paused}", bag.display())
}

/// What a pause of the commands means for a trial.
pub fn pause(paused_s: f64) -> String {
    format!(
        "commands paused for {paused_s:.3} s, so the trial does not measure a gain; its row is \
         marked, and `rsrs measure fit` leaves it out"
    )
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::controller::ControllerParameters;

    use super::*;

    fn stand(distance_m: f64, bearing_rad: f64) -> Trial {
        Trial::Stand { neighbour: Some(Neighbour { distance_m, bearing_rad }), samples: 9 }
    }

    #[test]
    fn the_instruction_names_where_the_neighbour_stands() {
        for (trial, expected) in [
            (stand(0.3, 0.2), "0.300 m from a, 0.200 rad (11.5°) to the left, centre to centre"),
            (stand(0.3, -0.2), "0.300 m from a, 0.200 rad (11.5°) to the right, centre to centre"),
            (stand(0.5, 0.0), "0.500 m from a, straight ahead of it, centre to centre"),
            (Trial::Stand { neighbour: None, samples: 9 }, "a alone: take away all that it could"),
        ] {
            let given = instruction("a", &trial);
            assert!(given.contains(expected), "{given}");
        }
    }

    #[test]
    fn who_looks_on_reads_which_trial_it_is() {
        let command = ControllerParameters::mirrored(0.2, 0.5);
        let drive = Trial::Drive { command, duration_s: 4.5 };
        for (trial, expected) in [
            (drive, "a drives at 0.2 m/s and 0.5 rad/s for 4.5 s"),
            (stand(0.3, -0.2), "a stands with another 0.300 m away at -0.200 rad, for 9 readings"),
            (Trial::Stand { neighbour: None, samples: 9 }, "a stands alone for 9 readings"),
        ] {
            assert_eq!(description("a", &trial), expected);
        }
    }
}
