//! A folder to begin with: profile, fleet, sweep and experiment of one's own robots.

use std::path::{Path, PathBuf};

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::numerals::significant;
use rsrs_core::quantity::{Axis, OtherUnit};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::wheels::Wheels;
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::fleet_file::FleetFile;
use rsrs_sim::sweep::{Runs, SweepError};
use serde::Serialize;

use crate::best_setting::grid::{Floor, Reach, STEPS};
use crate::error::with_help;
use crate::files::{make_folder, write_file};

/// What is given of the robots; all else is assumed, and marked so.
#[derive(Clone, Debug, PartialEq)]
pub struct Robots {
    /// Name of the kind: letters, digits and `_`.
    pub name: String,
    /// How many there are; at least 2.
    pub n_robots: usize,
    /// Radius of the body, in metres.
    pub radius_m: f64,
    /// What they do when they touch.
    pub contact: ContactModel,
    /// Fastest safe command, in metres per second.
    pub speed_m_s: f64,
    /// Fastest safe turn, in radians per second.
    pub turn_rate_rad_s: f64,
    /// Its two wheels, if that is what it drives on.
    pub wheels: Option<Wheels>,
    /// How far from its centre a robot detects another, in metres.
    pub range_m: f64,
    /// Half of the sensor's opening angle, in radians.
    pub half_angle_rad: f64,
    /// Time between two detections, in seconds.
    pub period_s: f64,
    /// Side of the square floor that the swarm has, in metres; `None` for one so large that its walls
    /// are not reached.
    pub arena_m: Option<f64>,
}

/// What was written.
#[derive(Clone, Debug, Serialize)]
pub struct Begun {
    /// The folder.
    pub folder: PathBuf,
    /// Its files, in the order in which one reads them.
    pub files: Vec<&'static str>,
    /// Side of the arena in the sweep, in metres.
    pub arena_m: f64,
    /// Radius of the disc in which robots start, in metres.
    pub placement_radius_m: f64,
}

const PROFILE: &str = "profile.yaml";
const SWEEP: &str = "sweep.yaml";
const EXPERIMENT: &str = "experiment.yaml";

/// Slowest command over the fastest, and slowest turn over the fastest.
const SLOWEST: [f64; 2] = [0.1, 0.05];

/// Writes the folder, which must not exist; numbers that make no robot are refused before.
pub fn init(folder: &Path, robots: &Robots) -> anyhow::Result<Begun> {
    if folder.exists() {
        return Err(with_help(
            format!("{} exists", folder.display()),
            "give a folder that does not exist",
        ));
    }
    check(robots)?;
    let Robots { range_m, n_robots, radius_m, arena_m, .. } = *robots;
    let floor = Floor::new(range_m, (n_robots, radius_m), arena_m);
    let texts = texts(robots, floor);
    check_texts(&texts)?;
    make_folder(folder)?;
    for (name, text) in &texts {
        write_file(&folder.join(name), text.as_bytes())?;
    }
    let files = texts.iter().map(|(name, _)| *name).collect();
    let Floor { arena_m, placement_m: placement_radius_m } = floor;
    Ok(Begun { folder: folder.to_owned(), files, arena_m, placement_radius_m })
}

/// Refuses what is no name, and numbers that are likely in another unit.
fn check(robots: &Robots) -> anyhow::Result<()> {
    check_name(&robots.name)?;
    check_count(robots.n_robots)?;
    check_radius(robots.radius_m)?;
    for (axis, value) in [
        (Axis::Speed, robots.speed_m_s),
        (Axis::TurnRate, robots.turn_rate_rad_s),
        (Axis::Range, robots.range_m),
        (Axis::HalfAngle, robots.half_angle_rad),
        (Axis::Period, robots.period_s),
    ] {
        check_number(axis, value)?;
    }
    let Robots { range_m, radius_m, .. } = robots;
    if range_m <= radius_m {
        return Err(with_help(
            format!(
                "the range of the sensor is {range_m} m, and the body it sits in has a radius of {radius_m} m"
            ),
            "it is from the centre of the robot on: add the radius to what the sensor reaches beyond the body",
        ));
    }
    robots.arena_m.map_or(Ok(()), |arena_m| check_number(Axis::Arena, arena_m))?;
    robots.wheels.map_or(Ok(()), |wheels| {
        check_wheel_base(wheels.base_m)?;
        check_wheel_speed(wheels.speed_max_m_s, robots.speed_m_s)
    })
}

/// Refuses what is no distance of two wheels in metres, with the likely unit.
pub fn check_wheel_base(base_m: f64) -> anyhow::Result<()> {
    anyhow::ensure!(
        base_m > 0.0 && base_m.is_finite(),
        "the distance of the wheels is {base_m} m, expected a number above 0"
    );
    anyhow::ensure!(
        base_m <= 2.0 * MOST_RADIUS_M,
        "the distance of the wheels is {base_m}: this looks like mm or cm, expected m"
    );
    Ok(())
}

/// Refuses what is no speed of a wheel, and one at which the robot cannot drive as fast as it does.
pub fn check_wheel_speed(wheel_m_s: f64, speed_m_s: f64) -> anyhow::Result<()> {
    check_number(Axis::Speed, wheel_m_s)?;
    anyhow::ensure!(
        wheel_m_s >= speed_m_s,
        "a wheel drives at {wheel_m_s} m/s at most, and the robot straight ahead at {speed_m_s} m/s: expected \
         {speed_m_s} or more"
    );
    Ok(())
}

/// Refuses what is no number of robots in a swarm.
pub fn check_count(n_robots: usize) -> anyhow::Result<()> {
    anyhow::ensure!(n_robots != 1, "one robot is no swarm: expected 2 or more");
    anyhow::ensure!((2..=1000).contains(&n_robots), "expected a whole number from 2 to 1000");
    Ok(())
}

/// Refuses what is no name of a kind of robot, with a name that is near.
pub fn check_name(name: &str) -> anyhow::Result<()> {
    let is_letter = |it: char| it.is_ascii_alphanumeric() || it == '_';
    if name.starts_with(|it: char| it.is_ascii_alphabetic()) && name.chars().all(is_letter) {
        return Ok(());
    }
    let plain = name.trim().to_lowercase();
    let plain: String = plain.chars().map(|it| if is_letter(it) { it } else { '_' }).collect();
    let near = plain.trim_start_matches(|it: char| !it.is_ascii_alphabetic());
    let near = if near.is_empty() { "robot" } else { near };
    Err(with_help(
        format!("the name is `{name}`, expected letters, digits and `_`"),
        format!("names of robots begin with it, as in ROS: `{near}`"),
    ))
}

/// Refuses what is no radius of a body in metres, with the likely unit.
pub fn check_radius(radius_m: f64) -> anyhow::Result<()> {
    if !(radius_m > 0.0 && radius_m.is_finite()) {
        anyhow::bail!("the radius is {radius_m} m, expected a number above 0");
    }
    if radius_m > MOST_RADIUS_M {
        anyhow::bail!("the radius is {radius_m}: this looks like mm or cm, expected m");
    }
    Ok(())
}

/// No robot of this method is larger, in metres.
const MOST_RADIUS_M: f64 = 2.0;

/// Refuses what is no number of a robot, and one that is likely in another unit.
pub fn check_number(axis: Axis, value: f64) -> anyhow::Result<()> {
    let is_line_of_sight = axis == Axis::HalfAngle && value == 0.0;
    if !(value > 0.0 && value.is_finite() || is_line_of_sight) {
        anyhow::bail!("the {} is {value}, expected a number above 0", axis.name());
    }
    axis.check_unit(value).map_err(|OtherUnit { found, likely, .. }| {
        let message = format!(
            "the {} is {found}: this looks like {likely}, expected {}",
            axis.name(),
            axis.unit()
        );
        match axis {
            Axis::HalfAngle => with_help(message, in_radians(found)),
            _ => anyhow::anyhow!(message),
        }
    })?;
    let most = axis.bounds().most;
    if axis == Axis::HalfAngle && value > most {
        return Err(with_help(
            format!("the {} is {value}, expected at most {most} rad", axis.name()),
            in_radians(value),
        ));
    }
    Ok(())
}

/// `4° are 0.070 rad`.
fn in_radians(degrees: f64) -> String {
    format!("{degrees}° are {:.3} rad", degrees.to_radians())
}

/// The files, in the order in which one reads them.
fn texts(robots: &Robots, floor: Floor) -> Vec<(&'static str, String)> {
    let Robots { name, n_robots, speed_m_s, turn_rate_rad_s, range_m, radius_m, .. } = robots;
    let reach = Reach {
        speed_m_s: *speed_m_s,
        turn_rate_rad_s: *turn_rate_rad_s,
        range_m: *range_m,
        radius_m: *radius_m,
    };
    let [speeds, turn_rates] = reach.axes(floor, STEPS);
    let least_m_s = significant(SLOWEST[0] * speed_m_s);
    let least_rad_s = significant(SLOWEST[1] * turn_rate_rad_s).min(turn_rates[0]);
    let friction = match robots.contact {
        ContactModel::Push => FRICTION,
        ContactModel::Stop | ContactModel::None => ("", ""),
    };
    let wheels = robots.wheels.map_or_else(Default::default, wheels_text);
    let values = [
        ("@NAME@", name.clone()),
        ("@WHEELS@", wheels.0),
        ("@WHEELS_SOURCE@", wheels.1),
        ("@N_ROBOTS@", n_robots.to_string()),
        ("@RADIUS_M@", robots.radius_m.to_string()),
        ("@FIT_FLAGS@", fit_flags(robots)),
        ("@CONTACT@", format!("{}{}", robots.contact.name(), friction.0)),
        ("@CONTACT_SOURCE@", friction.1.to_owned()),
        ("@SPEED_M_S@", speed_m_s.to_string()),
        ("@LEAST_SPEED_M_S@", least_m_s.to_string()),
        ("@SETTINGS@", settings(&speeds, &turn_rates, robots.wheels)),
        ("@TURN_RATE_RAD_S@", turn_rate_rad_s.to_string()),
        ("@LEAST_TURN_RATE_RAD_S@", least_rad_s.to_string()),
        ("@HALF_ANGLE_RAD@", robots.half_angle_rad.to_string()),
        ("@RANGE_M@", range_m.to_string()),
        ("@PERIOD_S@", robots.period_s.to_string()),
        ("@PLACEMENT_M@", floor.placement_m.to_string()),
        ("@ARENA_M@", floor.arena_m.to_string()),
        ("@ARENA_IS@", if robots.arena_m.is_some() { "given" } else { NEVER_REACHED }.to_owned()),
    ];
    let filled = |template: &str| {
        values.iter().fold(template.to_owned(), |text, (key, value)| text.replace(key, value))
    };
    let member = |robot: usize| format!("  {name}_{robot}: {{enabled: true, type: {name}}}\n");
    let members: Vec<String> = (1..=*n_robots).map(member).collect();
    vec![
        (PROFILE, filled(include_str!("init/profile.yaml"))),
        (FleetFile::NAME, filled(include_str!("init/fleet.yaml")) + &members.concat()),
        (SWEEP, filled(include_str!("init/sweep.yaml"))),
        (EXPERIMENT, filled(include_str!("init/experiment.yaml"))),
    ]
}

/// The speeds and turning rates of a sweep: two axes, or where wheels cannot do both at once, a list.
fn settings(speeds: &[f64], turn_rates: &[f64], wheels: Option<Wheels>) -> String {
    let can = |speed_m_s: f64, turn_rate_rad_s: f64| {
        wheels.is_none_or(|wheels| wheels.can(Command { speed_m_s, turn_rate_rad_s }))
    };
    let both = speeds.iter().flat_map(|speed| turn_rates.iter().map(move |turn| (*speed, *turn)));
    let (fitting, beyond): (Vec<_>, Vec<_>) = both.partition(|(speed, turn)| can(*speed, *turn));
    if beyond.is_empty() {
        return format!(
            "axes:   # all that can be an axis: rsrs sweep --list-axes\n  speed_m_s: {speeds:?}\n  \
             turn_rate_rad_s: {turn_rates:?}"
        );
    }
    let cell = |(speed, turn)| format!("\n  - {{speed_m_s: {speed}, turn_rate_rad_s: {turn}}}");
    let cells: String = fitting.into_iter().map(cell).collect();
    format!("cells:   # without those that ask more of a wheel than the profile has{cells}")
}

/// What else `rsrs measure fit` has to be told of a body.
fn fit_flags(Robots { contact, wheels, .. }: &Robots) -> String {
    let contact = match contact {
        ContactModel::Stop => String::new(),
        ContactModel::Push | ContactModel::None => format!(" --contact {}", contact.name()),
    };
    let wheels = wheels.map_or_else(String::new, |Wheels { base_m, speed_max_m_s }| {
        format!(" --wheel-base {base_m} --wheel-speed {speed_max_m_s}")
    });
    contact + &wheels
}

/// Two wheels, in a profile and under its provenance.
fn wheels_text(Wheels { base_m, speed_max_m_s }: Wheels) -> (String, String) {
    let keys = ["base_m", "speed_max_m_s"];
    (
        format!("\n  wheels: {{base_m: {base_m}, speed_max_m_s: {speed_max_m_s}}}"),
        keys.map(|key| format!("\n    actuation.wheels.{key}: \"given\"")).concat(),
    )
}

/// The friction of bodies that push, in a profile and under its provenance.
const FRICTION: (&str, &str) = (
    "\n  contact_friction: 0.0   # between bodies that push each other; at 0 they slide",
    "\n    body.contact_friction: \"assumed: bodies slide along each other\"",
);

/// What stands behind the side of an arena that was not given.
const NEVER_REACHED: &str = "so large that no robot comes to its walls; give yours with --arena";

/// Reads what is about to be written as it will be read, so that no folder is left that does not work.
fn check_texts(texts: &[(&'static str, String)]) -> anyhow::Result<()> {
    let text = |wanted: &str| {
        let found = texts.iter().find(|(name, _)| *name == wanted);
        found.map(|(_, text)| text.as_str()).expect("every file is among them")
    };
    let profile = RobotProfile::parse(PROFILE, text(PROFILE))?;
    let sweep = SweepFile::parse(SWEEP, text(SWEEP)).map_err(crate::error::helped)?;
    let cells = sweep.resolve(SWEEP, &profile).map_err(crate::error::helped)?;
    let conditions: Vec<Conditions> = cells.into_iter().map(|(_, conditions)| conditions).collect();
    let runs = Runs { seed: sweep.seed, replicates: 1, duration_s: sweep.duration_s, n_threads: 1 };
    rsrs_sim::sweep::check(&conditions[..1], runs).map_err(|error| match error {
        SweepError::Placement { source, .. } => {
            with_help(source.to_string(), "give a larger arena, or fewer robots")
        }
        SweepError::Judge { source, .. } => source.into(),
    })?;
    FleetFile::parse(FleetFile::NAME, text(FleetFile::NAME)).map_err(crate::error::helped)?;
    ExperimentFile::parse(EXPERIMENT, text(EXPERIMENT)).map_err(crate::error::helped)?;
    Ok(())
}
