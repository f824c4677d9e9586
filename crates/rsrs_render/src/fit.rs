//! A fit in words, every number with its 95 % interval, and in pictures.

use std::path::Path;

use rsrs_core::capability::LostCapability;
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::fit::{Details, Fit, Population};
use rsrs_pipeline::files::make_folder;
use rsrs_pipeline::measure::fit::FittedFiles;
use rsrs_view::distribution::{self, DistributionPicture, DrivenSpeed};
use rsrs_view::sensor::{self, SensorPicture};

use crate::columns::columns;
use crate::picture_file::{PageStyle, write_svg_and_png};

/// All of a fit of the kind of robot `name`, and the capabilities that the default factors of a
/// sweep would all but lose.
pub fn text(name: &str, files: &FittedFiles, lost: &[LostCapability]) -> String {
    let fitted = &files.fit;
    let details = &fitted.details;
    let moved_by = details.moved_by;
    let whose = moved_by.origin().map(|origin| {
        format!(
            "\ntrials of {}: {} of {} are simulated, so this is no measured robot",
            origin.whose(),
            moved_by.simulator,
            moved_by.simulator + moved_by.fleet + moved_by.unknown
        )
    });
    let whose = whose.unwrap_or_default();
    let mut blocks = vec![
        format!(
            "{name}: {} straight runs and {} turns of {} robots; intervals are 95 %{whose}",
            details.speed.n_trials,
            details.turn.n_trials,
            details.speed.n_robots.max(details.turn.n_robots)
        ),
        speeds(fitted),
        turns(fitted),
        arcs(details),
        spreads(details),
    ];
    if let Some(strays) = strays(details) {
        blocks.push(strays);
    }
    blocks.push(sensor(fitted));
    blocks.push(period(details));
    let mut notes: Vec<String> =
        details.cautions.iter().map(|caution| format!("note: {caution}")).collect();
    notes.extend(files.notes.iter().map(|note| format!("note: {note}")));
    if !notes.is_empty() {
        blocks.push(notes.join("\n"));
    }
    let factor = "with the default factors of a sweep";
    blocks.extend(lost.iter().map(|lost| format!("warning: {factor}, {lost}")));
    blocks.join("\n\n")
}

/// Draws the speeds of each robot, and the sensor, as SVG and PNG, for the kind of robot `name`,
/// whose body has a radius of `radius_m` metres.
pub fn draw(
    folder: &Path,
    files: &FittedFiles,
    name: &str,
    radius_m: f64,
    style: PageStyle,
) -> anyhow::Result<()> {
    let fitted = &files.fit;
    make_folder(folder)?;
    let map = &fitted.details.sensor;
    let origin = fitted.details.moved_by.origin();
    let whose = origin.map(|origin| format!("; trials of {}", origin.whose())).unwrap_or_default();
    let trials: Vec<DrivenSpeed> = (files.speed.rows.iter())
        .map(|trial| DrivenSpeed {
            robot: files.speed.robots[trial.robot].clone(),
            commanded_m_s: trial.commanded_m_s,
            measured_m_s: trial.distance_m / trial.duration_s,
        })
        .collect();
    let speeds = distribution::svg(&DistributionPicture {
        speeds: &fitted.speed,
        trials: &trials,
        title: format!("Speeds of {name}"),
        subtitle: format!(
            "{} trials of {} robots{whose}",
            fitted.details.speed.n_trials, fitted.details.speed.n_robots
        ),
        theme: style.theme,
    })?;
    let seen = sensor::svg(&SensorPicture {
        map,
        simulated_m: &map.polygon_m,
        radius_m,
        title: format!("Sensor of {name}"),
        subtitle: format!(
            "{} places; detects {:.2} in the polygon, {:.3} without a neighbour{whose}",
            map.nodes.len(),
            map.true_positive.value,
            map.false_positive.value
        ),
        theme: style.theme,
    })?;
    write_svg_and_png(folder, "speeds", &speeds, style)?;
    write_svg_and_png(folder, "sensor", &seen, style)
}

fn speeds(fitted: &Fit) -> String {
    let mut rows =
        vec![["speed", "commanded", "mean", "sd", "gain", "interval", "trials"].map(str::to_owned)];
    for fit in &fitted.speed {
        rows.push([
            fit.robot.clone(),
            format!("{} m/s", fit.commanded_m_s),
            format!("{:.4}", fit.mean_m_s),
            fit.sd_m_s.map_or_else(|| "-".to_owned(), |sd_m_s| format!("{sd_m_s:.5}")),
            format!("{:.3}", fit.gain),
            bounds(fit.gain_low, fit.gain_high),
            fit.n_trials.to_string(),
        ]);
    }
    rows.extend(of_all(&fitted.details.speed, "m/s"));
    columns(&rows)
}

fn turns(fitted: &Fit) -> String {
    let mut rows =
        vec![["turn", "commanded", "mean", "sd", "gain", "interval", "trials"].map(str::to_owned)];
    for fit in &fitted.turn {
        rows.push([
            fit.robot.clone(),
            format!("{} rad/s", fit.commanded_rad_s),
            format!("{:.4}", fit.mean_rad_s),
            fit.sd_rad_s.map_or_else(|| "-".to_owned(), |sd_rad_s| format!("{sd_rad_s:.5}")),
            format!("{:.3}", fit.gain),
            bounds(fit.gain_low, fit.gain_high),
            fit.n_trials.to_string(),
        ]);
    }
    rows.extend(of_all(&fitted.details.turn, "rad/s"));
    columns(&rows)
}

/// Turns while driving, and how fast the turning rate follows.
fn arcs(details: &Details) -> String {
    let mut lines = vec![match &details.arc {
        None => "turns while driving: not measured, assumed to be as in place".to_owned(),
        Some(arc) => {
            let mut rows = vec![
                ["while driving", "commanded", "gain", "interval", "trials"].map(str::to_owned),
            ];
            rows.extend(arc.by_command.iter().map(|at| {
                [
                    format!("{} robots", at.n_robots),
                    format!("{} rad/s", at.command),
                    format!("{:.3}", at.gain.value),
                    bounds(at.gain.low, at.gain.high),
                    arc.n_trials.to_string(),
                ]
            }));
            columns(&rows)
        }
    }];
    lines.extend(details.yaw_lag.map(|lag| {
        let none = if lag.is_certain() {
            String::new()
        } else {
            format!(
                ": taken for none, as it is not certainly more than the control period, {:.4} s",
                lag.period_s
            )
        };
        format!(
            "lag of the turning rate: {:.4} s ({}), {} trajectories{none}",
            lag.lag_s.value,
            bounds(lag.lag_s.low, lag.lag_s.high),
            lag.n_trials
        )
    }));
    lines.join("\n")
}

/// The mean over robots at each command: what the profile takes.
fn of_all(population: &Population, unit: &str) -> Vec<[String; 7]> {
    let row = |at: &rsrs_core::trials::fit::CommandGain| {
        let robots = if at.n_robots == 1 { "robot" } else { "robots" };
        [
            format!("{} {robots}", at.n_robots),
            format!("{} {unit}", at.command),
            String::new(),
            String::new(),
            format!("{:.3}", at.gain.value),
            bounds(at.gain.low, at.gain.high),
            String::new(),
        ]
    };
    population.by_command.iter().map(row).collect()
}

fn spreads(details: &Details) -> String {
    let mut rows = Vec::new();
    for (what, population) in [("speed", &details.speed), ("turn", &details.turn)] {
        for (between, sd) in [("robots", population.robot_sd), ("trials", population.trial_sd)] {
            rows.push([
                format!("sd of the {what} gain between {between}"),
                sd.map_or_else(|| "unknown".to_owned(), |sd| number(sd.value)),
                sd.map_or_else(String::new, |sd| bounds(sd.low, sd.high)),
            ]);
        }
        if let Some(likelihood) = population.likelihood.filter(|_| population.by_command.len() > 1)
        {
            rows.push([
                "  of it, alike at all commands".to_owned(),
                number(likelihood.alike_sd),
                "by restricted maximum likelihood".to_owned(),
            ]);
        }
    }
    columns(&rows)
}

/// Motion that was not commanded.
fn strays(details: &Details) -> Option<String> {
    let mut rows = Vec::new();
    let mut row = |what: &str, sd: Option<Estimate>| {
        if let Some(sd) = sd {
            rows.push([what.to_owned(), number(sd.value), bounds(sd.low, sd.high)]);
        }
    };
    if let Some(drift) = details.drift {
        row("sd of the turn bias between robots (rad/s)", Some(drift.bias_sd_rad_s));
        row("heading noise in a period, by straight runs (rad)", drift.heading_noise_sd_rad);
        row("gusts on each axis (m/s)", drift.gust_sd_m_s);
    }
    if let Some(steps) = details.steps {
        let noise = Some(steps.heading_noise_sd_rad);
        row("heading noise in a period, by trajectories (rad)", noise);
        row("sd of the speed gain from step to step", steps.speed_step_sd);
    }
    (!rows.is_empty()).then(|| columns(&rows))
}

fn sensor(fitted: &Fit) -> String {
    let sensor = &fitted.sensor;
    let corners: Vec<String> =
        sensor.polygon_m.iter().map(|[x_m, y_m]| format!("({x_m:.3}, {y_m:.3})")).collect();
    let rates = columns(&[
        [
            "true positives in the polygon".to_owned(),
            format!("{:.4}", sensor.true_positive),
            bounds(Some(sensor.true_positive_low), Some(sensor.true_positive_high)),
        ],
        [
            "false positives without a neighbour".to_owned(),
            format!("{:.4}", sensor.false_positive),
            bounds(Some(sensor.false_positive_low), Some(sensor.false_positive_high)),
        ],
    ]);
    let reach = fitted.details.sensor.reach.iter().map(|at| {
        let high = at.high_m.map_or_else(|| "beyond".to_owned(), |high_m| format!("{high_m:.3} m"));
        let (bearing_rad, far_m, low_m) = (at.bearing_rad, at.far_m, at.low_m);
        format!("  at {bearing_rad:.3} rad {far_m:.3} m, between {low_m:.3} m and {high}")
    });
    let reach: Vec<String> = reach.collect();
    format!(
        "{rates}\nreach, centre to centre:\n{}\npolygon for centres, m ahead and left, inside the 80 % contour of {} corners:\n  {}",
        reach.join("\n"),
        fitted.details.sensor.contour_m.len(),
        corners.join(" ")
    )
}

fn period(details: &Details) -> String {
    let Some(period) = details.period else {
        return "control period: not measured".to_owned();
    };
    let jitter = period.jitter_s.map_or_else(String::new, |sd| {
        format!(", jitter {:.4} s ({})", sd.value, bounds(sd.low, sd.high))
    });
    let of_period = period.period_s;
    format!(
        "control period: {:.4} s ({}){jitter}, longest {:.4} s",
        of_period.value,
        bounds(of_period.low, of_period.high),
        period.longest_s
    )
}

/// A number of any size, four digits of it.
fn number(value: f64) -> String {
    if value == 0.0 || value.abs() >= 0.01 { format!("{value:.4}") } else { format!("{value:.6}") }
}

fn bounds(low: Option<f64>, high: Option<f64>) -> String {
    match (low, high) {
        (Some(low), Some(high)) => format!("{} to {}", number(low), number(high)),
        (Some(low), None) => format!("{} or more", number(low)),
        (None, Some(high)) => format!("up to {}", number(high)),
        (None, None) => "no interval".to_owned(),
    }
}
