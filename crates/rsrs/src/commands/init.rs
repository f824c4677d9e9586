//! `rsrs init`: a folder to begin with.

use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;

use anyhow::Context;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::wheels::Wheels;
use rsrs_files::quoted;
use rsrs_pipeline::error::{help_of, with_help};
use rsrs_pipeline::init::{
    Robots, check_count, check_name, check_number, check_radius, check_wheel_base,
    check_wheel_speed, init,
};

use crate::commands::{Format, report};
use crate::failure::{Outcome, bad_arguments, check_flag};
use crate::wheel_arguments::WheelArguments;

/// Write a folder to begin with: profile, fleet, sweep and experiment of your own robots.
///
/// What is not given is asked for. Everything else that a profile needs is assumed and marked so, to be
/// replaced by what `rsrs measure` finds; the folder can be swept at once.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs init mine
  rsrs init mine --name turtlebot --robots 9 --radius 0.105 --speed 0.22 --turn-rate 2.84 \\
      --range 1.0 --half-angle 0.2 --period 0.1 --arena 4")]
pub struct Arguments {
    /// Folder to make; it must not exist.
    folder: PathBuf,
    /// Name of the kind of robot: letters, digits and `_`.
    #[arg(long)]
    name: Option<String>,
    /// How many robots there are.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16))]
    robots: Option<u16>,
    /// Radius of a robot's body, in metres.
    #[arg(long, value_name = "M")]
    radius: Option<f64>,
    /// Fastest safe speed, in metres per second.
    #[arg(long, value_name = "M_PER_S")]
    speed: Option<f64>,
    /// Fastest safe turn, in radians per second.
    #[arg(long, value_name = "RAD_PER_S")]
    turn_rate: Option<f64>,
    #[command(flatten)]
    wheels: WheelArguments,
    /// How far from its centre a robot detects another, in metres.
    #[arg(long, value_name = "M")]
    range: Option<f64>,
    /// Half of the opening angle in which it detects others, in radians.
    #[arg(long, value_name = "RAD")]
    half_angle: Option<f64>,
    /// Time between two detections, in seconds.
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// Side of the square floor that the swarm has, in metres (default: so large that no robot comes to
    /// its walls).
    #[arg(long, value_name = "M")]
    arena: Option<f64>,
    /// What robots do when they touch: `stop` in place with another one in front, and be moved by nobody;
    /// `push` each other; or pass through each other, `none` (default: stop).
    #[arg(long, value_name = "CONTACT")]
    contact: Option<ContactModel>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let robots = if std::io::stdin().is_terminal() {
        ask(arguments, &mut std::io::stdin().lock(), &mut std::io::stderr())?
    } else {
        given(arguments)?
    };
    let begun = init(&arguments.folder, &robots)?;
    let arena = match robots.arena_m {
        Some(_) => String::new(),
        None => ", so large that no robot comes to its walls; give yours with `--arena`".to_owned(),
    };
    let text = format!(
        "{}: {}\narena of {} m{arena}; robots start in a disc of {} m radius\nnext: cd {} && rsrs sweep sweep.yaml -o results\nthen: rsrs choose results -o \
         results/choice.json && rsrs run experiment.yaml --from results -o run_1",
        begun.folder.display(),
        begun.files.join(", "),
        begun.arena_m,
        begun.placement_radius_m,
        quoted(&begun.folder)
    );
    report(arguments.format, &begun, &text)?;
    Ok(Outcome::Done)
}

/// Everything from the command line; what is missing is named all at once.
fn given(arguments: &Arguments) -> anyhow::Result<Robots> {
    let Arguments { name, robots, radius, speed, turn_rate, range, half_angle, period, .. } =
        arguments;
    let missing: Vec<&str> = [
        ("--name", name.is_none()),
        ("--robots", robots.is_none()),
        ("--radius", radius.is_none()),
        ("--speed", speed.is_none()),
        ("--turn-rate", turn_rate.is_none()),
        ("--range", range.is_none()),
        ("--half-angle", half_angle.is_none()),
        ("--period", period.is_none()),
    ]
    .into_iter()
    .filter_map(|(flag, is_missing)| is_missing.then_some(flag))
    .collect();
    if let (
        Some(name),
        Some(robots),
        Some(radius_m),
        Some(speed_m_s),
        Some(turn_rate_rad_s),
        Some(range_m),
        Some(half_angle_rad),
        Some(period_s),
    ) = (name, *robots, *radius, *speed, *turn_rate, *range, *half_angle, *period)
    {
        check_flag("--name", check_name(name))?;
        check_flag("--robots", check_count(usize::from(robots)))?;
        check_flag("--radius", check_radius(radius_m))?;
        for (flag, axis, value) in [
            ("--speed", Axis::Speed, Some(speed_m_s)),
            ("--turn-rate", Axis::TurnRate, Some(turn_rate_rad_s)),
            ("--range", Axis::Range, Some(range_m)),
            ("--half-angle", Axis::HalfAngle, Some(half_angle_rad)),
            ("--period", Axis::Period, Some(period_s)),
            ("--arena", Axis::Arena, arguments.arena),
        ] {
            check_flag(flag, value.map_or(Ok(()), |value| check_number(axis, value)))?;
        }
        let wheels = arguments.wheels.wheels()?;
        if let Some(Wheels { speed_max_m_s, .. }) = wheels {
            check_flag("--wheel-speed", check_wheel_speed(speed_max_m_s, speed_m_s))?;
        }
        let (name, n_robots) = (name.clone(), usize::from(robots));
        return Ok(Robots {
            name,
            n_robots,
            radius_m,
            contact: arguments.contact.unwrap_or_default(),
            speed_m_s,
            turn_rate_rad_s,
            wheels,
            range_m,
            half_angle_rad,
            period_s,
            arena_m: arguments.arena,
        });
    }
    Err(bad_arguments(with_help(
        format!("{} not given, and standard input is no terminal", missing.join(", ")),
        "give all of them, or run it in a terminal, where it asks",
    )))
}

/// Asks for what was not given; Enter takes what is in brackets.
fn ask(
    arguments: &Arguments,
    input: &mut impl BufRead,
    output: &mut impl Write,
) -> anyhow::Result<Robots> {
    let mut questions = Questions { input, output };
    let of = |axis| move |value: &f64| check_number(axis, *value);
    let asked = Robots {
        name: questions.or_ask(
            arguments.name.clone(),
            ("name of the kind of robot", "robot".to_owned()),
            |name| check_name(name),
        )?,
        n_robots: questions.or_ask(
            arguments.robots.map(usize::from),
            ("how many there are", 9),
            |n| check_count(*n),
        )?,
        radius_m: questions.or_ask(
            arguments.radius,
            ("radius of the body, in m", 0.075),
            |radius_m| check_radius(*radius_m),
        )?,
        contact: questions.or_ask(
            arguments.contact,
            ("what robots do that touch: stop, push each other, or none", ContactModel::Stop),
            |_| Ok(()),
        )?,
        speed_m_s: questions.or_ask(
            arguments.speed,
            ("fastest safe speed, in m/s", 0.3),
            of(Axis::Speed),
        )?,
        turn_rate_rad_s: questions.or_ask(
            arguments.turn_rate,
            ("fastest safe turn, in rad/s; a full circle is 6.28", 2.0),
            of(Axis::TurnRate),
        )?,
        wheels: None,
        range_m: questions.or_ask(
            arguments.range,
            ("how far from its centre it detects another robot, in m", 1.0),
            of(Axis::Range),
        )?,
        half_angle_rad: questions.or_ask(
            arguments.half_angle,
            ("half of the angle in which it does, in rad; 10° are 0.175", 0.2),
            of(Axis::HalfAngle),
        )?,
        period_s: questions.or_ask(
            arguments.period,
            ("time between two detections, in s", 0.1),
            of(Axis::Period),
        )?,
        arena_m: Some(questions.or_ask(
            arguments.arena,
            ("side of the square floor that the swarm has, in m", 4.0),
            of(Axis::Arena),
        )?),
    };
    let base_m = questions.or_ask(
        arguments.wheels.wheel_base,
        ("distance of its two wheels, in m; 0 if it drives on anything else", 0.0),
        |base_m| if *base_m == 0.0 { Ok(()) } else { check_wheel_base(*base_m) },
    )?;
    if base_m == 0.0 {
        return Ok(asked);
    }
    let speed_max_m_s = questions.or_ask(
        arguments.wheels.wheel_speed,
        ("fastest speed of a wheel over the floor, in m/s", asked.speed_m_s),
        |wheel_m_s| check_wheel_speed(*wheel_m_s, asked.speed_m_s),
    )?;
    Ok(Robots { wheels: Some(Wheels { base_m, speed_max_m_s }), ..asked })
}

/// Where questions go, and where answers come from.
struct Questions<'a, I, O> {
    input: &'a mut I,
    output: &'a mut O,
}

impl<I: BufRead, O: Write> Questions<'_, I, O> {
    /// What was given, else the first answer that can be true.
    fn or_ask<T: std::str::FromStr + std::fmt::Display>(
        &mut self,
        given: Option<T>,
        (what, usual): (&str, T),
        check: impl Fn(&T) -> anyhow::Result<()>,
    ) -> anyhow::Result<T> {
        if let Some(given) = given {
            return Ok(given);
        }
        let is_word = usual.to_string().parse::<f64>().is_err();
        let alone = if is_word { "a word" } else { "a number" };
        loop {
            write!(self.output, "{what} [{usual}]: ")
                .and_then(|()| self.output.flush())
                .context("asking")?;
            let mut line = String::new();
            if self.input.read_line(&mut line).context("reading the answer")? == 0 {
                anyhow::bail!("standard input ended before all was answered; nothing was written");
            }
            let answer = line.trim();
            if answer.is_empty() {
                return Ok(usual);
            }
            let refusal = match answer.parse() {
                Ok(value) => match check(&value) {
                    Ok(()) => return Ok(value),
                    Err(error) => {
                        let help =
                            help_of(&error).map_or_else(String::new, |help| format!("; {help}"));
                        format!("{error}{help}")
                    }
                },
                Err(_) => format!("`{answer}` is no answer: {alone} alone is, such as {usual}"),
            };
            writeln!(self.output, "{refusal}").context("asking")?;
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn arguments(line: &[&str]) -> Arguments {
        Line::parse_from([["rsrs", "mine"].as_slice(), line].concat()).arguments
    }

    #[test]
    fn what_is_not_given_is_asked_for_until_it_is_answered() {
        let mut answers = "\nmany\n4\n\nshove\npush\n0.2\n\n\n\n\n0.12\n0.1\n0.25\n".as_bytes();
        let mut asked = Vec::new();

        let robots =
            ask(&arguments(&["--period", "0.13"]), &mut answers, &mut asked).expect("answered");

        let expected = Robots {
            name: "robot".to_owned(),
            n_robots: 4,
            radius_m: 0.075,
            contact: ContactModel::Push,
            speed_m_s: 0.2,
            turn_rate_rad_s: 2.0,
            wheels: Some(Wheels { base_m: 0.12, speed_max_m_s: 0.25 }),
            range_m: 1.0,
            half_angle_rad: 0.2,
            period_s: 0.13,
            arena_m: Some(4.0),
        };
        assert_eq!(robots, expected);
        let asked = String::from_utf8(asked).expect("it is UTF-8");
        let no_contact = "`shove` is no answer: a word alone is, such as stop";
        assert!(asked.contains(no_contact), "{asked}");
        assert!(asked.contains("`many` is no answer") && !asked.contains("detections"), "{asked}");
        assert!(asked.contains("a wheel drives at 0.1 m/s at most"), "{asked}");
    }

    #[test]
    fn an_answer_that_cannot_be_is_refused_when_it_is_given() {
        let mut answers = "E-Puck 2\ne_puck_2\n0\n6\n35\n3.5 cm\n0.035\n\n".as_bytes();
        let mut asked = Vec::new();
        let given = ["--speed", "0.1", "--turn-rate", "2", "--range", "1", "--half-angle", "0.2"];
        let given =
            [&given[..], &["--period", "0.1", "--arena", "3", "--contact", "none"]].concat();

        let robots = ask(&arguments(&given), &mut answers, &mut asked).expect("answered");

        assert_eq!((robots.name.as_str(), robots.n_robots), ("e_puck_2", 6));
        assert_eq!(robots.radius_m.to_bits(), 0.035_f64.to_bits());
        let asked = String::from_utf8(asked).expect("it is UTF-8");
        for refusal in [
            "the name is `E-Puck 2`, expected letters, digits and `_`",
            "`e_puck_2`",
            "expected a whole number from 2 to 1000",
            "the radius is 35: this looks like mm or cm",
            "`3.5 cm` is no answer: a number alone is, such as 0.075",
        ] {
            assert!(asked.contains(refusal), "{refusal}: {asked}");
        }
    }

    #[test]
    fn what_is_missing_is_named_all_at_once() {
        let error = given(&arguments(&["--name", "a", "--speed", "0.2"])).unwrap_err().to_string();

        let missing = "--robots, --radius, --turn-rate, --range, --half-angle, --period not given";
        assert!(error.contains(missing), "{error}");
    }
}
