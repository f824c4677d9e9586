//! From a fit to a profile: every number with where it comes from.

use std::collections::BTreeMap;

use super::{CommandGain, Drift, Fit, Population, StepNoise, YawLag};
use crate::robot::contact::ContactModel;
use crate::robot::harsher::tidy;
use crate::robot::profile::{
    Actuation, Body, Computation, Gust, Provenance, RobotProfile, SpeedActuation, SpeedGain,
    TurnActuation, TurnGain,
};
use crate::robot::sensor::{Sees, Sensing, SensorDetails};
use crate::robot::wheels::Wheels;
use crate::statistics::variance::Estimate;

/// What trials of step 1 cannot measure, and what stands in for it.
///
/// The default is a Flockbot's body, of which the paper gives the radius only.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmeasured {
    /// Radius of the body, in metres.
    pub radius_m: f64,
    /// Where the radius is from, if somebody gave it; goes into the profile's provenance.
    pub radius_source: Option<String>,
    /// Front sector of contact, in radians.
    pub front_half_angle_rad: f64,
    /// Whether a blocked robot still turns.
    pub rotates_while_blocked: bool,
    /// What robots do when they touch.
    pub contact: ContactModel,
    /// The two wheels, if somebody gave them.
    pub wheels: Option<Wheels>,
    /// Time constant of the turning rate, in seconds.
    pub yaw_lag_s: f64,
    /// Correlation time of gusts, in seconds.
    pub gust_time_constant_s: f64,
    /// Steps by which a detection arrives late.
    pub latency_steps: u32,
    /// Control period where no table of periods is given, in seconds.
    pub period_s: f64,
    /// Why these are the numbers; goes into the profile's provenance.
    pub reason: String,
}

impl Default for Unmeasured {
    fn default() -> Self {
        Self {
            radius_m: 0.075,
            radius_source: None,
            front_half_angle_rad: 1.2217,
            rotates_while_blocked: true,
            contact: ContactModel::Stop,
            wheels: None,
            yaw_lag_s: 0.0,
            gust_time_constant_s: 2.0,
            latency_steps: 0,
            period_s: 0.13,
            reason: "as the Flockbot's profile; not among the trials".to_owned(),
        }
    }
}

/// Texts of provenance by dotted path.
struct Sources<'a> {
    numbers: BTreeMap<String, String>,
    reason: &'a str,
}

impl Sources<'_> {
    fn measured(&mut self, key: &str, source: String) {
        self.numbers.insert(key.to_owned(), source);
    }

    fn assumed(&mut self, key: &str) {
        self.numbers.insert(key.to_owned(), format!("assumed: {}", self.reason));
    }

    /// A standard deviation, or zero with the reason.
    fn sd(&mut self, key: &str, sd: Option<Estimate>, source: &str) -> f64 {
        let Some(sd) = sd else {
            self.numbers.insert(key.to_owned(), format!("assumed to be none: {source}"));
            return 0.0;
        };
        self.measured(key, format!("{source}{}", interval(sd)));
        number(sd.value)
    }
}

impl Fit {
    /// The profile of the measured robot, which is of the kind `name`, with a polygon and
    /// `sees: centre`. It passes its own check; `unmeasured` is what was given to [`super::fit`].
    ///
    /// The spread of a gain in a profile is that of one robot in one run. It is drawn once for a
    /// run, so it holds what robots differ by and what their trials differ by, added as variances.
    pub fn profile(&self, name: &str, unmeasured: &Unmeasured) -> RobotProfile {
        let mut sources = Sources { numbers: BTreeMap::new(), reason: &unmeasured.reason };
        match &unmeasured.radius_source {
            Some(source) => sources.measured("body.radius_m", source.clone()),
            None => sources.assumed("body.radius_m"),
        }
        sources.assumed("body.front_half_angle_rad");
        RobotProfile {
            name: name.to_owned(),
            body: Body {
                radius_m: unmeasured.radius_m,
                front_half_angle_rad: unmeasured.front_half_angle_rad,
                rotates_while_blocked: unmeasured.rotates_while_blocked,
                contact: unmeasured.contact,
                contact_friction: None,
            },
            actuation: self.actuation(&mut sources, unmeasured),
            sensing: self.sensing(&mut sources, unmeasured),
            further_sensors: Vec::new(),
            computation: Computation { period_s: self.period(&mut sources, unmeasured) },
            provenance: Provenance {
                source: self.source(),
                trials: self.details.moved_by.origin(),
                numbers: sources.numbers,
            },
        }
    }

    fn source(&self) -> String {
        let files = &self.details.files;
        let period = files.period.as_ref().map(|file| format!(", {file}")).unwrap_or_default();
        let arc = files.arc.as_ref().map(|file| format!("{file}, ")).unwrap_or_default();
        let origin = self.details.moved_by.origin();
        let whose = origin.map(|origin| format!("trials of {}: ", origin.whose()));
        format!(
            "fitted to {}{}, {}, {arc}{}{period}; assumed where marked",
            whose.unwrap_or_default(),
            files.speed,
            files.turn,
            files.detection
        )
    }

    fn actuation(&self, sources: &mut Sources, unmeasured: &Unmeasured) -> Actuation {
        let details = &self.details;
        let drift = details.drift;
        let (speed_file, turn_file) = (&details.files.speed, &details.files.turn);
        let speed = gains(sources, "actuation.speed", "m_s", &details.speed, speed_file);
        let turn = gains(sources, "actuation.turn", "rad_s", &details.turn, turn_file);
        let (bias, noise, gust) = strays(drift, details.steps, speed_file);
        sources.assumed("actuation.gust.time_constant_s");
        let driving = self.driving(sources);
        if unmeasured.wheels.is_some() {
            for key in ["base_m", "speed_max_m_s"] {
                sources.measured(&format!("actuation.wheels.{key}"), "given".to_owned());
            }
        }
        let yaw_lag_s = yaw_lag_s(sources, details.yaw_lag, unmeasured.yaw_lag_s);
        Actuation {
            speed: SpeedActuation {
                limits_m_s: speed.limits,
                gain_by_command: speed
                    .table
                    .iter()
                    .map(|(commanded_m_s, mean)| SpeedGain {
                        commanded_m_s: *commanded_m_s,
                        mean: *mean,
                    })
                    .collect(),
                robot_sd: speed.sd,
                step_sd: step_sd(sources, details.steps),
            },
            turn: TurnActuation {
                limits_rad_s: turn.limits,
                gain_by_command: turn
                    .table
                    .iter()
                    .map(|(commanded_rad_s, mean)| TurnGain {
                        commanded_rad_s: *commanded_rad_s,
                        mean: *mean,
                    })
                    .collect(),
                driving_gain_by_command: driving,
                robot_sd: turn.sd,
                step_sd: 0.0,
                bias_sd_rad_s: sources.sd("actuation.turn.bias_sd_rad_s", bias.0, &bias.1),
                heading_noise_sd_rad: sources.sd(
                    "actuation.turn.heading_noise_sd_rad",
                    noise.0,
                    &noise.1,
                ),
            },
            wheels: unmeasured.wheels,
            gust: Gust {
                sd_m_s: sources.sd("actuation.gust.sd_m_s", gust.0, &gust.1),
                time_constant_s: unmeasured.gust_time_constant_s,
            },
            yaw_lag_s,
        }
    }

    /// Mean gains of turns while driving, where they were measured.
    fn driving(&self, sources: &mut Sources) -> Option<Vec<TurnGain>> {
        let file = self.details.files.arc.as_ref()?;
        let commands = &self.details.arc.as_ref()?.by_command;
        for (position, one) in commands.iter().enumerate() {
            let entry = format!("actuation.turn.driving_gain_by_command.{position}");
            mean_of_robots(sources, &entry, "rad_s", one, file);
        }
        let gain = |one: &CommandGain| TurnGain {
            commanded_rad_s: number(one.command),
            mean: number(one.gain.value),
        };
        Some(commands.iter().map(gain).collect())
    }

    fn sensing(&self, sources: &mut Sources, unmeasured: &Unmeasured) -> Sensing {
        let map = &self.details.sensor;
        let file = &self.details.files.detection;
        for corner in 0..map.polygon_m.len() {
            for axis in 0..2 {
                sources.measured(
                    &format!("sensing.polygon_m.{corner}.{axis}"),
                    format!("{file}: convex polygon inside the 80 % contour of the detections"),
                );
            }
        }
        for (key, place, rate) in [
            ("sensing.true_positive", "inside the polygon", map.true_positive),
            ("sensing.false_positive", "without a neighbour", map.false_positive),
        ] {
            sources.measured(
                key,
                format!(
                    "{file}: {} of {} readings {place}, 95 % interval {:.4} to {:.4} \
                     (Clopper-Pearson)",
                    rate.detections, rate.samples, rate.low, rate.high
                ),
            );
        }
        sources.assumed("sensing.latency_steps");
        Sensing {
            sees: Sees::Centre,
            cone: None,
            polygon_m: Some(map.polygon_m.clone()),
            true_positive: number(map.true_positive.value),
            false_positive: number(map.false_positive.value),
            latency_steps: unmeasured.latency_steps,
            details: SensorDetails::default(),
        }
    }

    fn period(&self, sources: &mut Sources, unmeasured: &Unmeasured) -> f64 {
        let key = "computation.period_s";
        let (Some(period), Some(file)) = (self.details.period, &self.details.files.period) else {
            sources.assumed(key);
            return unmeasured.period_s;
        };
        let jitter = period
            .jitter_s
            .map(|jitter| format!("; jitter {:.4} s", jitter.value))
            .unwrap_or_default();
        sources.measured(key, format!("{file}: mean{}{jitter}", interval(period.period_s)));
        number(period.period_s.value)
    }
}

/// The speed's noise from step to step, where trajectories show it.
fn step_sd(sources: &mut Sources, steps: Option<StepNoise>) -> f64 {
    match steps.and_then(|steps| steps.speed_step_sd.map(|sd| (sd, steps.n_trials))) {
        Some((sd, n)) => {
            let source = format!("{n} trajectories, step by step");
            sources.sd("actuation.speed.step_sd", Some(sd), &source)
        }
        None => 0.0,
    }
}

/// The gains of one kind of command as the profile has them.
struct Gains {
    limits: [f64; 2],
    table: Vec<(f64, f64)>,
    sd: f64,
}

fn gains(
    sources: &mut Sources,
    path: &str,
    unit: &str,
    population: &Population,
    file: &str,
) -> Gains {
    let commands = &population.by_command;
    for (position, one) in commands.iter().enumerate() {
        let entry = format!("{path}.gain_by_command.{position}");
        mean_of_robots(sources, &entry, unit, one, file);
    }
    let most = commands[commands.len() - 1].command;
    // One command alone is a limit at one end only.
    let least = if commands.len() > 1 { commands[0].command } else { 0.0 };
    for (position, which) in ["slowest", "fastest"].into_iter().enumerate() {
        let text = if position == 0 && commands.len() == 1 {
            "assumed: one command was tried, and standing still is safe".to_owned()
        } else {
            format!("{file}: the {which} command that was tried")
        };
        sources.measured(&format!("{path}.limits_{unit}.{position}"), text);
    }
    let parts = [("between robots", population.robot_sd), ("between trials", population.trial_sd)];
    let measured: Vec<String> = parts
        .iter()
        .filter_map(|(name, sd)| sd.map(|sd| format!("{name} {:.4}{}", sd.value, interval(sd))))
        .collect();
    let variance: f64 = parts.iter().filter_map(|(_, sd)| *sd).map(|sd| sd.value * sd.value).sum();
    let text = if measured.is_empty() {
        "assumed to be none: one trial of one robot gives no spread".to_owned()
    } else {
        format!("{file}: {}, added as variances", measured.join(" and "))
    };
    sources.measured(&format!("{path}.robot_sd"), text);
    sources.measured(
        &format!("{path}.step_sd"),
        "assumed to be none: whole trials do not show single steps; what trials differ by is in \
         robot_sd"
            .to_owned(),
    );
    Gains {
        limits: [number(least), number(most)],
        table: commands.iter().map(|one| (number(one.command), number(one.gain.value))).collect(),
        sd: number(variance.sqrt()),
    }
}

/// Where a mean gain at one command is from.
fn mean_of_robots(sources: &mut Sources, entry: &str, unit: &str, one: &CommandGain, file: &str) {
    sources.measured(&format!("{entry}.commanded_{unit}"), format!("{file}: as commanded"));
    let n_robots = one.n_robots;
    let plural = if n_robots == 1 { "robot" } else { "robots" };
    let text = format!("{file}: mean of {n_robots} {plural}{}", interval(one.gain));
    sources.measured(&format!("{entry}.mean"), text);
}

/// The time constant of the turning rate, where trajectories show one.
fn yaw_lag_s(sources: &mut Sources, found: Option<YawLag>, assumed_s: f64) -> f64 {
    let key = "actuation.yaw_lag_s";
    let Some(lag) = found else {
        sources.assumed(key);
        return assumed_s;
    };
    let turns = format!("{} trajectories that turn", lag.n_trials);
    let found = format!("{:.4} s{}", lag.lag_s.value, interval(lag.lag_s));
    if lag.is_certain() {
        sources.measured(key, format!("{turns}: {found}"));
        return number(lag.lag_s.value);
    }
    let none = format!(
        "{turns} show none that is certainly more than the control period, {} s: {found}",
        number(lag.period_s)
    );
    sources.measured(key, none);
    0.0
}

type Stray = (Option<Estimate>, String);

/// Bias, heading noise and gusts with their sources.
fn strays(drift: Option<Drift>, steps: Option<StepNoise>, file: &str) -> (Stray, Stray, Stray) {
    let by_step = steps.map(|steps| {
        let text = format!("{} trajectories, step by step", steps.n_trials);
        (Some(steps.heading_noise_sd_rad), text)
    });
    let Some(drift) = drift else {
        let none = || (None, format!("{file} has neither heading_change_rad nor lateral_m"));
        return (none(), by_step.unwrap_or_else(none), none());
    };
    let n = drift.n_trials;
    let bias = (Some(drift.bias_sd_rad_s), format!("{file}: {n} straight runs"));
    let noise = match drift.heading_noise_sd_rad {
        Some(_) => (drift.heading_noise_sd_rad, format!("{file}: {n} straight runs")),
        None => (None, format!("{file}: no robot drove straight twice")),
    };
    let gust = match drift.gust_sd_m_s {
        // A zero within the interval: a disturbance that is not significant is none.
        Some(Estimate { low: Some(0.0), high, .. }) => {
            (None, format!("{file} shows none, at most {} m/s", short(high.unwrap_or_default())))
        }
        Some(_) => (
            drift.gust_sd_m_s,
            format!("{file}: what the heading change does not explain of the lateral distance"),
        ),
        None => (None, format!("{file} needs heading_change_rad and lateral_m, with repetitions")),
    };
    (bias, by_step.unwrap_or(noise), gust)
}

fn interval(estimate: Estimate) -> String {
    match (estimate.low, estimate.high) {
        (Some(low), Some(high)) => format!(", 95 % interval {} to {}", short(low), short(high)),
        _ => ", without an interval".to_owned(),
    }
}

/// Four significant digits.
fn short(number: f64) -> String {
    let magnitude = if number == 0.0 { 0.0 } else { libm::floor(libm::log10(number.abs())) };
    let decimals = (3.0 - magnitude).clamp(0.0, 12.0) as usize;
    format!("{number:.decimals$}")
}

/// Six significant digits: more would pretend, and less would show.
fn number(number: f64) -> f64 {
    if number == 0.0 {
        return 0.0;
    }
    let unit = libm::pow(10.0, libm::floor(libm::log10(number.abs())) - 5.0);
    tidy((number / unit).round() * unit)
}
