//! The answer of `rsrs validate` in words.

use std::fmt;

use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::validation::{Exit, LEVEL, TrialPlace, Validation};

use super::file::{Turning, ValidationReport};
use crate::wording::columns;

impl fmt::Display for ValidationReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&text(self))
    }
}

fn text(answer: &ValidationReport) -> String {
    let validation = &answer.validation;
    let mut blocks = vec![headline(validation), robots(validation)];
    if let Some(origin) = answer.trials_of {
        let whose = origin.whose();
        let note = format!("note: the trials are those of {whose}: nothing is validated by them");
        blocks.insert(1, note);
    }
    let (constant, changing): (Vec<usize>, Vec<usize>) =
        (0..validation.tubes.len()).partition(|index| validation.tubes[*index].command.is_some());
    blocks.extend(constant.into_iter().map(|index| tube(validation, index)));
    if !changing.is_empty() {
        let lines: Vec<String> =
            changing.into_iter().map(|index| changing_tube(validation, index)).collect();
        blocks.push(lines.join("\n"));
    }
    let outside: Vec<String> = validation.outside().map(outside).collect();
    if !outside.is_empty() {
        blocks.push(format!("outside:\n{}", outside.join("\n")));
    }
    if !validation.is_contained {
        blocks.push(remedy(answer));
    }
    blocks.push(capabilities(answer));
    blocks.extend(answer.lost_capabilities.iter().map(|lost| format!("warning: {lost}")));
    blocks.push(sensor(answer));
    blocks.join("\n\n")
}

fn headline(validation: &Validation) -> String {
    let verdict = if validation.is_contained { "contained" } else { "NOT contained" };
    let counts = format!(
        "{} of {} trials inside the simulated {:.0} % reach at every time ({})",
        validation.n_inside,
        validation.n_trials,
        validation.share * 100.0,
        share(validation.coverage)
    );
    let p_value = validation.p_value;
    let chance = if p_value < 0.0001 { "below 0.0001".to_owned() } else { format!("{p_value:.4}") };
    format!(
        "{verdict}: {counts}\n\
         simulated robots leave as often or more with probability {chance}; expected {LEVEL} or more"
    )
}

/// An exact interval of a share.
fn share(interval: Interval) -> String {
    format!("{:.2} to {:.2}, exact 95 %", interval.low, interval.high)
}

fn robots(validation: &Validation) -> String {
    let mut rows = vec![["robot", "inside", "share, exact 95 %"].map(str::to_owned)];
    for robot in &validation.robots {
        rows.push([
            robot.robot.clone(),
            format!("{} of {}", robot.n_inside, robot.n_trials),
            format!("{:.2} to {:.2}", robot.coverage.low, robot.coverage.high),
        ]);
    }
    columns(&rows)
}

/// What a tube's commands were; where they changed, by whose trials.
pub fn commands(validation: &Validation, tube: usize) -> String {
    if let Some(command) = validation.tubes[tube].command {
        return format!("{} m/s, {} rad/s", command.speed_m_s, command.turn_rate_rad_s);
    }
    let trials = validation.trials.iter().filter(|place| place.tube == tube);
    let names: Vec<String> =
        trials.map(|place| format!("trial `{}` of {}", place.trial, place.robot)).collect();
    format!("changing commands of {}", names.join(", "))
}

fn tube(validation: &Validation, index: usize) -> String {
    let tube = &validation.tubes[index];
    let mut rows =
        vec![["after", "area", "heading", "inside", "share, exact 95 %"].map(str::to_owned)];
    for horizon in &tube.horizons {
        let [least_rad, most_rad] = horizon.heading_rad;
        rows.push([
            format!("{:.1} s", horizon.time_s),
            format!("{:.4} m²", horizon.area_m2),
            format!("{least_rad:.2} to {most_rad:.2} rad"),
            format!("{} of {}", horizon.n_inside, horizon.n_trials),
            format!("{:.2} to {:.2}", horizon.coverage.low, horizon.coverage.high),
        ]);
    }
    format!("{}:\n{}", commands(validation, index), columns(&rows))
}

/// One line for drives whose command changed: each is of its own kind, and there are many.
fn changing_tube(validation: &Validation, index: usize) -> String {
    let horizons = &validation.tubes[index].horizons;
    let last = &horizons[horizons.len() - 1];
    let n_inside = validation
        .trials
        .iter()
        .filter(|place| place.tube == index && place.exits.is_empty())
        .count();
    let n_trials = validation.trials.iter().filter(|place| place.tube == index).count();
    format!(
        "{}: {n_inside} of {n_trials} inside, area {:.4} m² after {:.1} s",
        commands(validation, index),
        last.area_m2,
        last.time_s
    )
}

fn outside(place: &TrialPlace) -> String {
    let exits = &place.exits;
    let worst = exits
        .iter()
        .max_by(|left, right| distance_m(left).total_cmp(&distance_m(right)))
        .expect("a trial outside has an exit");
    let by =
        match (exits.iter().any(|exit| exit.by_position), exits.iter().any(|exit| exit.by_heading))
        {
            (true, true) => "position and heading",
            (true, false) => "position",
            (false, _) => "heading",
        };
    format!(
        "  {}, trial `{}`: by {by}, first after {:.1} s; after {:.1} s {}, {} and {} of the mean",
        place.robot,
        place.trial,
        exits[0].time_s,
        worst.time_s,
        side(worst.ahead_m, "m ahead", "m behind"),
        side(worst.left_m, "m to the left", "m to the right"),
        side(worst.turned_rad, "rad counterclockwise", "rad clockwise"),
    )
}

fn distance_m(exit: &Exit) -> f64 {
    exit.ahead_m * exit.ahead_m + exit.left_m * exit.left_m
}

fn side(amount: f64, positive: &str, negative: &str) -> String {
    format!("{:.3} {}", amount.abs(), if amount >= 0.0 { positive } else { negative })
}

/// What would contain the trials.
fn remedy(answer: &ValidationReport) -> String {
    if let Some(turning) = &answer.turning {
        return turned(turning);
    }
    match &answer.smallest_factors {
        Some(factors) => format!(
            "the smallest factors that contain them: {}\n\
             set them under `harsher:` in the sweep file, and sweep again",
            changed(&answer.judged.harsher, factors)
        ),
        None => {
            "no factor contains them up to 64: the robots do what the profile has too little of \
                 to widen; a profile without turn bias, heading noise or gusts leaves a straight \
                 line\nmeasure these: `lateral_m` and `heading_change_rad` in the straight runs of \
                 `rsrs measure fit`, or `--trajectories`"
                .to_owned()
        }
    }
}

/// How robots turn that leave because of that.
fn turned(turning: &Turning) -> String {
    let interval = |estimate: Estimate| match (estimate.low, estimate.high) {
        (Some(low), Some(high)) => format!("{:.3} ({low:.3} to {high:.3})", estimate.value),
        _ => format!("{:.3} (no interval)", estimate.value),
    };
    let lag = turning.yaw_lag_s.map(|lag_s| {
        format!(
            "their turning rate lags: `yaw_lag_s` is {}, not what the profile has",
            interval(lag_s)
        )
    });
    let gain = turning.driving_gain.map(|gain| {
        format!("they turn otherwise while they drive: by a gain of {}", interval(gain))
    });
    let causes: Vec<String> = lag.into_iter().chain(gain).collect();
    format!(
        "{}\nwith that in the profile they are contained, and no factor has to be larger\n\
         measure it: `rsrs measure fit` with `--trajectories` or `--bags` for the lag, and with \
         `--arcs` for the gain while driving; then sweep again",
        causes.join("\n")
    )
}

/// The factors that differ.
fn changed(from: &HarsherFactors, to: &HarsherFactors) -> String {
    let [from, to] = [*from, *to].map(Harsher::from);
    let texts: Vec<String> = from
        .given()
        .zip(to.given())
        .filter(|((_, from), (_, to))| from.to_bits() != to.to_bits())
        .map(|((key, from), (_, to))| format!("{key} {to:.2} (now {from})"))
        .collect();
    texts.join(", ")
}

fn capabilities(answer: &ValidationReport) -> String {
    if answer.capability_violations.is_empty() {
        return "capabilities: the simulated robot is nowhere better than the measured one"
            .to_owned();
    }
    let lines: Vec<String> =
        answer.capability_violations.iter().map(|violation| format!("  {violation}")).collect();
    format!("capabilities in which the simulated robot is better:\n{}", lines.join("\n"))
}

fn sensor(answer: &ValidationReport) -> String {
    match &answer.sensor_violations {
        None => "sensor: not checked; give `--detection`".to_owned(),
        Some(violations) if violations.is_empty() => {
            "sensor: the detections do not contradict the simulated one".to_owned()
        }
        Some(violations) => {
            let lines: Vec<String> =
                violations.iter().map(|violation| format!("  {violation}")).collect();
            format!("detections that contradict the simulated sensor:\n{}", lines.join("\n"))
        }
    }
}
