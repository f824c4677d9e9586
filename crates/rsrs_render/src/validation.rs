//! The answer of `rsrs validate` in words, and in pictures.

use std::path::Path;

use anyhow::Context;
use rsrs_core::capability::border_m;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::trial::DrivenTrial;
use rsrs_core::trials::validation::{Exit, LEVEL, TrialPlace, Tube, Validation};
use rsrs_pipeline::files::make_folder;
use rsrs_pipeline::validate::file::{Turning, ValidationReport};
use rsrs_pipeline::validate::{Case, Validated};
use rsrs_view::reachable_set::{self, ReachPicture, TubeMembership};
use rsrs_view::sensor::{self, SensorPicture};

use crate::columns::columns;
use crate::picture;
use crate::picture_file::{PageStyle, write_svg_and_png};
use crate::words::{Tone, Words};

/// All of an answer.
pub fn text(answer: &ValidationReport) -> Words {
    let validation = &answer.validation;
    let mut blocks = vec![headline(validation)];
    let class = answer.judged.class.as_ref();
    blocks
        .extend(class.map(|class| format!("judged: the simulated robot of class {class}").into()));
    blocks.extend(answer.trials_of.map(|origin| {
        let whose = origin.whose();
        format!("note: the trials are those of {whose}: nothing is validated by them").into()
    }));
    blocks.push(robots(validation).into());
    let (of_many, of_one): (Vec<usize>, Vec<usize>) =
        (0..validation.tubes.len()).partition(|index| is_of_many(validation, *index));
    blocks.extend(of_many.into_iter().map(|index| tube(validation, index).into()));
    if !of_one.is_empty() {
        let lines = of_one.into_iter().map(|index| tube_of_one(validation, index));
        blocks.push(Words::lines(lines));
    }
    if validation.outside().next().is_some() {
        blocks.push(validation.outside().map(outside).fold("outside:".into(), Words::below));
    }
    if !validation.is_contained {
        let loses_object =
            validation.outside().all(|place| place.object.is_some()) && answer.turning.is_none();
        blocks.extend(loses_object.then(|| OBJECT_REMEDY.into()));
        blocks.push(help(answer).into());
    }
    blocks.push(capabilities(answer));
    let warning = |lost| format!("warning: {lost}").into();
    blocks.extend(answer.lost_capabilities.iter().map(warning));
    blocks.push(sensor(answer));
    blocks.into_iter().reduce(|above, block| above.then("\n\n").then(block)).unwrap_or_default()
}

/// What to look at first where all that left were to push something.
const OBJECT_REMEDY: &str = "all of these have an object: look at its `weight`, `friction` and `radius_m` in the \
     world's file first; simulated robots that push it off its middle are not turned by it, as real ones are";

fn headline(validation: &Validation) -> Words {
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
    Words::toned(Tone::good_if(validation.is_contained), verdict).then(format!(
        ": {counts}\n\
         simulated robots leave as often or more with probability {chance}; expected {LEVEL} or more"
    ))
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

/// Whether a tube may be that of many trials: their command is the same all the time, and they push nothing.
fn is_of_many(validation: &Validation, tube: usize) -> bool {
    let mut trials = validation.trials.iter().filter(|place| place.exits_of(tube).is_some());
    validation.tubes[tube].command.is_some() && trials.all(|place| place.object.is_none())
}

/// What a tube's commands were; where they changed, or something is pushed, by whose trials.
fn commands(validation: &Validation, tube: usize) -> String {
    let Tube { command, of_object, .. } = validation.tubes[tube];
    let trials = validation.trials.iter().filter(|place| place.exits_of(tube).is_some());
    let pushes = trials.clone().any(|place| place.object.is_some());
    let names: Vec<String> =
        trials.map(|place| format!("trial `{}` of {}", place.trial, place.robot)).collect();
    let whose = names.join(", ");
    let commands = match command {
        None => format!("changing commands of {whose}"),
        Some(command) => {
            let numbers = format!("{} m/s, {} rad/s", command.speed_m_s, command.turn_rate_rad_s);
            // Of several trials with these each has an object of its own.
            if pushes { format!("{numbers} in {whose}") } else { numbers }
        }
    };
    match (of_object, pushes) {
        (true, _) => format!("{commands}, the object"),
        (false, true) => format!("{commands}, the robot"),
        (false, false) => commands,
    }
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

/// One line for drives whose command changed or that push something: each is of its own kind, and there are many.
fn tube_of_one(validation: &Validation, index: usize) -> String {
    let horizons = &validation.tubes[index].horizons;
    let last = &horizons[horizons.len() - 1];
    let trials = validation.trials.iter().filter_map(|place| place.exits_of(index));
    let n_trials = trials.clone().count();
    let n_inside = trials.filter(|exits| exits.is_empty()).count();
    format!(
        "{}: {n_inside} of {n_trials} inside, area {:.4} m² after {:.1} s",
        commands(validation, index),
        last.area_m2,
        last.time_s
    )
}

/// What left, the robot or its object, a line each.
fn outside(place: &TrialPlace) -> String {
    let robot = format!("  {}, trial `{}`", place.robot, place.trial);
    let object = format!("{robot}, the object");
    let none = Vec::new();
    let of_object = place.object.as_ref().map_or(&none, |object| &object.exits);
    let bodies = [
        (robot, &place.exits, robot_off as fn(&Exit) -> String),
        (object, of_object, object_off as fn(&Exit) -> String),
    ];
    let bodies = bodies.into_iter().filter(|(_, exits, _)| !exits.is_empty());
    let lines = bodies.map(|(who, exits, off)| left(&who, exits, off));
    lines.collect::<Vec<String>>().join("\n")
}

fn left(who: &str, exits: &[Exit], off: fn(&Exit) -> String) -> String {
    let worst = exits
        .iter()
        .max_by(|left, right| distance_m(left).total_cmp(&distance_m(right)))
        .expect("what is outside has an exit");
    let by =
        match (exits.iter().any(|exit| exit.by_position), exits.iter().any(|exit| exit.by_heading))
        {
            (true, true) => "position and heading",
            (true, false) => "position",
            (false, _) => "heading",
        };
    format!(
        "{who}: by {by}, first after {:.1} s; after {:.1} s {} of the mean",
        exits[0].time_s,
        worst.time_s,
        off(worst)
    )
}

fn robot_off(exit: &Exit) -> String {
    let [ahead, beside] = sides(exit);
    let turned = side(exit.turned_rad, "rad counterclockwise", "rad clockwise");
    format!("{ahead}, {beside} and {turned}")
}

/// Nobody tracks how an object turns.
fn object_off(exit: &Exit) -> String {
    sides(exit).join(" and ")
}

fn sides(exit: &Exit) -> [String; 2] {
    [
        side(exit.ahead_m, "m ahead", "m behind"),
        side(exit.left_m, "m to the left", "m to the right"),
    ]
}

fn distance_m(exit: &Exit) -> f64 {
    exit.ahead_m * exit.ahead_m + exit.left_m * exit.left_m
}

fn side(amount: f64, positive: &str, negative: &str) -> String {
    format!("{:.3} {}", amount.abs(), if amount >= 0.0 { positive } else { negative })
}

/// What would contain the trials.
fn help(answer: &ValidationReport) -> String {
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

fn capabilities(answer: &ValidationReport) -> Words {
    let violations = &answer.capability_violations;
    if violations.is_empty() {
        return Words::from("capabilities: the simulated robot is ")
            .then_toned(Tone::Good, "nowhere better")
            .then(" than the measured one");
    }
    let head = "capabilities in which the simulated robot is better";
    listed(head, violations.iter().map(ToString::to_string))
}

fn sensor(answer: &ValidationReport) -> Words {
    match &answer.sensor_violations {
        None => Words::from("sensor: ")
            .then_toned(Tone::Unclear, "not checked")
            .then("; give `--detection`"),
        Some(violations) if violations.is_empty() => Words::from("sensor: the detections ")
            .then_toned(Tone::Good, "do not contradict")
            .then(" the simulated one"),
        Some(violations) => {
            let head = "detections that contradict the simulated sensor";
            listed(head, violations.iter().map(ToString::to_string))
        }
    }
}

/// What is not as it should be, a line each.
fn listed(head: &str, violations: impl Iterator<Item = String>) -> Words {
    let head = Words::toned(Tone::Bad, head).then(":");
    violations.fold(head, |words, violation| words.below(format!("  {violation}")))
}

/// Writes `validation.json` and its pictures into `output`; without it, into that of the sweep, if
/// `sweep` is a folder, whose diagram then notes the answer, too.
pub fn write(
    validated: &Validated,
    sweep: &Path,
    output: Option<&Path>,
    style: PageStyle,
) -> anyhow::Result<()> {
    let beside_sweep = validated.swept.as_ref().map(|_| sweep);
    if let Some(folder) = output.or(beside_sweep) {
        draw(folder, validated, style)?;
        validated.answer.write(folder)?;
    }
    match (&validated.swept, output) {
        (Some(swept), None) => picture::into_folder(sweep, swept),
        _ => Ok(()),
    }
}

/// Draws the tubes as `reach_1`, `reach_2` …, and the sensor where detections are known; as SVG and
/// PNG. Of drives whose command changed or that push something, which may be many, those outside are drawn.
fn draw(folder: &Path, validated: &Validated, style: PageStyle) -> anyhow::Result<()> {
    let Validated { case, answer, .. } = validated;
    make_folder(folder)?;
    remove_earlier(folder)?;
    for (index, tube) in answer.validation.tubes.iter().enumerate() {
        let trials = &answer.validation.trials;
        let mut exits = trials.iter().filter_map(|place| place.exits_of(index));
        if !is_of_many(&answer.validation, index) && exits.all(<[Exit]>::is_empty) {
            continue;
        }
        let svg = tube_svg(case, answer, (index, tube), style)?;
        write_svg_and_png(folder, &format!("reach_{}", index + 1), &svg, style)?;
    }
    if let Some(map) = &case.sensor {
        let robot = &case.conditions[0].robot;
        let measured = case.origin.map_or("measured", |_| "trials, simulated");
        let svg = sensor::svg(&SensorPicture {
            map,
            simulated_m: &border_m(&robot.region),
            radius_m: robot.radius_m,
            title: format!("Sensor of {}", case.source.profile.name),
            subtitle: format!(
                "{measured}: detects {:.2}, false positives {:.3}; simulated: {:.2}, {:.3}",
                map.true_positive.value,
                map.false_positive.value,
                robot.true_positive,
                robot.false_positive
            ),
            theme: style.theme,
        })?;
        write_svg_and_png(folder, "sensor", &svg, style)?;
    }
    Ok(())
}

/// Removes the pictures of an earlier answer, which may have had more of them.
fn remove_earlier(folder: &Path) -> anyhow::Result<()> {
    let is_earlier = |name: &str| {
        let (number, extension) = name.strip_prefix("reach_")?.rsplit_once('.')?;
        let is_numbered = !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit());
        Some(is_numbered && ["svg", "png"].contains(&extension))
    };
    let cannot = |what: &Path| format!("cannot remove {}", what.display());
    for entry in std::fs::read_dir(folder).with_context(|| cannot(folder))? {
        let path = entry.with_context(|| cannot(folder))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if is_earlier(&name) == Some(true) {
            std::fs::remove_file(&path).with_context(|| cannot(&path))?;
        }
    }
    Ok(())
}

fn tube_svg(
    case: &Case,
    answer: &ValidationReport,
    (index, tube): (usize, &Tube),
    style: PageStyle,
) -> anyhow::Result<String> {
    let places = case.trials.iter().zip(&answer.validation.trials);
    let of_tube = |(trial, place): (&DrivenTrial, &TrialPlace)| {
        let membership = TubeMembership::new(place.exits_of(index)?);
        let trial = if tube.of_object { trial.of_object()? } else { trial.clone() };
        Some((trial, membership))
    };
    let trials: Vec<(DrivenTrial, TubeMembership)> = places.filter_map(of_tube).collect();
    let trials: Vec<(&DrivenTrial, TubeMembership)> =
        trials.iter().map(|(trial, membership)| (trial, *membership)).collect();
    Ok(reachable_set::svg(&ReachPicture {
        tube,
        trials: &trials,
        title: format!(
            "Simulated reach of {} and {}",
            case.source.profile.name,
            case.origin.map_or_else(
                || "real trials".to_owned(),
                |origin| format!("trials of {}", origin.whose())
            )
        ),
        subtitle: format!(
            "{}; the regions hold {:.0} % of the simulated {}",
            commands(&answer.validation, index),
            answer.validation.share * 100.0,
            if tube.of_object { "objects" } else { "robots" }
        ),
        theme: style.theme,
    })?)
}
