//! `rsrs init`: a folder to begin with.

use std::fmt::Display;
use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Context;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::wheels::Wheels;
use rsrs_pipeline::error::{help_of, with_help};
use rsrs_pipeline::init::{
    Robots, check_count, check_name, check_number, check_radius, check_wheel_base,
    check_wheel_speed, init,
};
use rsrs_render::init::text;

use crate::commands::{Format, report};
use crate::failure::{Outcome, bad_arguments, check_flag};
use crate::question;
use crate::wheel_arguments::WheelArguments;

/// Write a folder to begin with: profile, fleet, sweep and experiment of your own robots.
///
/// Asks for what is not given. Everything else that a profile needs is assumed, and marked so until
/// `rsrs measure` finds it; the folder can be swept at once.
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
    /// What robots do when they touch: `stop` in place with another one in front, and cannot be pushed;
    /// `push` each other; or pass through each other, `none` (default: stop).
    #[arg(long, value_name = "CONTACT")]
    contact: Option<ContactModel>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let (mut input, mut output) = (std::io::stdin().lock(), std::io::stderr());
    let mut questions = Questions::new(
        std::io::stdin().is_terminal().then_some((&mut input as _, &mut output as _)),
    );
    let robots = robots(arguments, &mut questions)?;
    let begun = init(&arguments.folder, &robots)?;
    report(arguments.format, &begun, text(&begun, robots.arena_m))?;
    Ok(Outcome::Done)
}

/// The robots of the command line, and of the answers to what it does not say.
fn robots(arguments: &Arguments, questions: &mut Questions) -> anyhow::Result<Robots> {
    let of = |axis| move |value: &f64| check_number(axis, *value);
    let name = questions.required(
        ("--name", arguments.name.clone()),
        ("name of the kind of robot", "robot".to_owned()),
        |name| check_name(name),
    )?;
    let n_robots = questions.required(
        ("--robots", arguments.robots.map(usize::from)),
        ("how many there are", 9),
        |n| check_count(*n),
    )?;
    let radius_m = questions.required(
        ("--radius", arguments.radius),
        ("radius of the body, in m", 0.075),
        |radius_m| check_radius(*radius_m),
    )?;
    let contact = questions.optional(
        ("--contact", arguments.contact),
        ("what robots do that touch: stop, push each other, or none", ContactModel::Stop),
        |_| Ok(()),
    )?;
    let speed_m_s = questions.required(
        ("--speed", arguments.speed),
        ("fastest safe speed, in m/s", 0.3),
        of(Axis::Speed),
    )?;
    let turn_rate_rad_s = questions.required(
        ("--turn-rate", arguments.turn_rate),
        ("fastest safe turn, in rad/s; a full circle is 6.28", 2.0),
        of(Axis::TurnRate),
    )?;
    let range_m = questions.required(
        ("--range", arguments.range),
        ("how far from its centre it detects another robot, in m", 1.0),
        of(Axis::Range),
    )?;
    let half_angle_rad = questions.required(
        ("--half-angle", arguments.half_angle),
        ("half of the angle in which it does, in rad; 10° are 0.175", 0.2),
        of(Axis::HalfAngle),
    )?;
    let period_s = questions.required(
        ("--period", arguments.period),
        ("time between two detections, in s", 0.1),
        of(Axis::Period),
    )?;
    let arena_m = questions.optional(
        ("--arena", arguments.arena),
        ("side of the square floor that the swarm has, in m", 4.0),
        of(Axis::Arena),
    )?;
    if !questions.missing.is_empty() {
        return Err(bad_arguments(with_help(
            format!(
                "{} not given, and standard input is no terminal",
                questions.missing.join(", ")
            ),
            "give all of them, or run it in a terminal, where it asks",
        )));
    }
    // No wheels, a base of 0, is an answer; the flags are not given for it.
    arguments.wheels.wheels()?;
    let base_m = questions.optional(
        ("--wheel-base", arguments.wheels.wheel_base),
        ("distance of its two wheels, in m; 0 if it drives on anything else", 0.0),
        |base_m| if *base_m == 0.0 { Ok(()) } else { check_wheel_base(*base_m) },
    )?;
    let wheels = match base_m {
        None | Some(0.0) => None,
        Some(base_m) => {
            let speed_max_m_s = questions.required(
                ("--wheel-speed", arguments.wheels.wheel_speed),
                ("fastest speed of a wheel over the floor, in m/s", speed_m_s),
                |wheel_m_s| check_wheel_speed(*wheel_m_s, speed_m_s),
            )?;
            Some(Wheels { base_m, speed_max_m_s })
        }
    };
    Ok(Robots {
        name,
        n_robots,
        radius_m,
        contact: contact.unwrap_or_default(),
        speed_m_s,
        turn_rate_rad_s,
        wheels,
        range_m,
        half_angle_rad,
        period_s,
        arena_m,
    })
}

/// Where answers come from, and where questions go.
type Terminal<'a> = (&'a mut dyn BufRead, &'a mut dyn Write);

/// What is not given is asked for, where there is a terminal; Enter takes what is in brackets.
struct Questions<'a> {
    terminal: Option<Terminal<'a>>,
    /// Flags of what is needed, was not given, and could not be asked for.
    missing: Vec<&'static str>,
}

impl<'a> Questions<'a> {
    fn new(terminal: Option<Terminal<'a>>) -> Self {
        Self { terminal, missing: Vec::new() }
    }

    /// What is given or answered; what is usual, and a missing flag, if nobody can be asked.
    fn required<T: FromStr + Display + Clone>(
        &mut self,
        (flag, given): (&'static str, Option<T>),
        (what, usual): (&str, T),
        check: impl Fn(&T) -> anyhow::Result<()>,
    ) -> anyhow::Result<T> {
        let answer = self.optional((flag, given), (what, usual.clone()), check)?;
        Ok(answer.unwrap_or_else(|| {
            self.missing.push(flag);
            usual
        }))
    }

    /// What is given, else the first answer that can be true; `None` if nobody can be asked.
    fn optional<T: FromStr + Display>(
        &mut self,
        (flag, given): (&str, Option<T>),
        (what, usual): (&str, T),
        check: impl Fn(&T) -> anyhow::Result<()>,
    ) -> anyhow::Result<Option<T>> {
        if let Some(given) = given {
            check_flag(flag, check(&given))?;
            return Ok(Some(given));
        }
        let Some((input, output)) = &mut self.terminal else { return Ok(None) };
        let is_word = usual.to_string().parse::<f64>().is_err();
        let alone = if is_word { "a word" } else { "a number" };
        loop {
            let before = "all was answered; nothing was written";
            let question = format!("{what} [{usual}]");
            let answer = question::put((&mut **input, &mut **output), &question, before)?;
            if answer.is_empty() {
                return Ok(Some(usual));
            }
            let refusal = match answer.parse() {
                Ok(value) => match check(&value) {
                    Ok(()) => return Ok(Some(value)),
                    Err(error) => {
                        let help =
                            help_of(&error).map_or_else(String::new, |help| format!("; {help}"));
                        format!("{error}{help}")
                    }
                },
                Err(_) => {
                    format!("`{answer}` is not understood: type {alone} only, such as {usual}")
                }
            };
            writeln!(output, "{refusal}").context("asking")?;
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

    fn answered(line: &[&str], answers: &mut &[u8], asked: &mut Vec<u8>) -> anyhow::Result<Robots> {
        robots(&arguments(line), &mut Questions::new(Some((answers, asked))))
    }

    #[test]
    fn what_is_not_given_is_asked_for_until_it_is_answered() {
        let mut answers = "\nmany\n4\n\nshove\npush\n0.2\n\n\n\n\n0.12\n0.1\n0.25\n".as_bytes();
        let mut asked = Vec::new();

        let robots = answered(&["--period", "0.13"], &mut answers, &mut asked).expect("answered");

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
        let no_contact = "`shove` is not understood: type a word only, such as stop";
        assert!(asked.contains(no_contact), "{asked}");
        assert!(
            asked.contains("`many` is not understood") && !asked.contains("detections"),
            "{asked}"
        );
        assert!(asked.contains("a wheel drives at 0.1 m/s at most"), "{asked}");
    }

    #[test]
    fn an_answer_that_cannot_be_is_refused_when_it_is_given() {
        let mut answers = "E-Puck 2\ne_puck_2\n0\n6\n35\n3.5 cm\n0.035\n\n".as_bytes();
        let mut asked = Vec::new();
        let given = ["--speed", "0.1", "--turn-rate", "2", "--range", "1", "--half-angle", "0.2"];
        let given =
            [&given[..], &["--period", "0.1", "--arena", "3", "--contact", "none"]].concat();

        let robots = answered(&given, &mut answers, &mut asked).expect("answered");

        assert_eq!((robots.name.as_str(), robots.n_robots), ("e_puck_2", 6));
        assert_eq!(robots.radius_m.to_bits(), 0.035_f64.to_bits());
        let asked = String::from_utf8(asked).expect("it is UTF-8");
        for refusal in [
            "the name is `E-Puck 2`, expected letters, digits and `_`",
            "`e_puck_2`",
            "expected a whole number from 2 to 1000",
            "the radius is 35: this looks like mm or cm",
            "`3.5 cm` is not understood: type a number only, such as 0.075",
        ] {
            assert!(asked.contains(refusal), "{refusal}: {asked}");
        }
    }

    #[test]
    fn what_is_missing_is_named_all_at_once() {
        let given = arguments(&["--name", "a", "--wheel-base", "0.1", "--wheel-speed", "0.2"]);

        let error = robots(&given, &mut Questions::new(None)).unwrap_err().to_string();

        let missing =
            "--robots, --radius, --speed, --turn-rate, --range, --half-angle, --period not given";
        assert!(error.contains(missing), "{error}");
    }
}
