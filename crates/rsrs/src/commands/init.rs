//! `rsrs init`: a folder to begin with.

use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;

use anyhow::Context;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::init::{Robots, init};
use rsrs_pipeline::wording::shell::quoted;

use crate::commands::{Format, report};
use crate::failure::Outcome;

/// Write a folder to begin with: profile, fleet, sweep and experiment of your own robots.
///
/// What is not given is asked for. Everything else that a profile needs is assumed and marked so, to be
/// replaced by what `rsrs measure` finds; the folder can be swept at once.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs init mine
  rsrs init mine --name turtlebot --robots 9 --radius 0.105 --speed 0.22 --turn-rate 2.84 \\
      --range 1.0 --half-angle 0.2 --period 0.1")]
pub struct Arguments {
    /// Folder to make; it must not exist.
    folder: PathBuf,
    /// Name of the kind of robot: small letters, digits and `_`.
    #[arg(long)]
    name: Option<String>,
    /// How many robots there are.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
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
    /// How far from its centre a robot detects another, in metres.
    #[arg(long, value_name = "M")]
    range: Option<f64>,
    /// Half of the opening angle in which it detects others, in radians.
    #[arg(long, value_name = "RAD")]
    half_angle: Option<f64>,
    /// Time between two detections, in seconds.
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Runs the command.
///
/// # Errors
///
/// If the folder exists, something is missing and nobody can be asked, or the numbers make no robot.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let robots = if std::io::stdin().is_terminal() {
        ask(arguments, &mut std::io::stdin().lock(), &mut std::io::stderr())?
    } else {
        given(arguments)?
    };
    let begun = init(&arguments.folder, &robots)?;
    let text = format!(
        "{}: {}\nnext: cd {} && rsrs sweep sweep.yaml -o results\nthen: rsrs choose results -o \
         results/choice.json && rsrs run experiment.yaml --from results -o run_1",
        begun.folder.display(),
        begun.files.join(", "),
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
        let (name, n_robots) = (name.clone(), usize::from(robots));
        return Ok(Robots {
            name,
            n_robots,
            radius_m,
            speed_m_s,
            turn_rate_rad_s,
            range_m,
            half_angle_rad,
            period_s,
        });
    }
    Err(with_help(
        format!("{} not given, and standard input is no terminal", missing.join(", ")),
        "give all of them, or run it in a terminal, where it asks",
    ))
}

/// Asks for what was not given; Enter takes what is in brackets.
fn ask(
    arguments: &Arguments,
    input: &mut impl BufRead,
    output: &mut impl Write,
) -> anyhow::Result<Robots> {
    let mut questions = Questions { input, output };
    Ok(Robots {
        name: match &arguments.name {
            Some(name) => name.clone(),
            None => questions.ask("name of the kind of robot", "robot".to_owned())?,
        },
        n_robots: match arguments.robots {
            Some(n) => usize::from(n),
            None => questions.ask("how many there are", 9)?,
        },
        radius_m: questions.number(arguments.radius, "radius of the body, in m", 0.075)?,
        speed_m_s: questions.number(arguments.speed, "fastest safe speed, in m/s", 0.3)?,
        turn_rate_rad_s: questions.number(
            arguments.turn_rate,
            "fastest safe turn, in rad/s; a full circle is 6.28",
            2.0,
        )?,
        range_m: questions.number(
            arguments.range,
            "how far from its centre it detects another robot, in m",
            1.0,
        )?,
        half_angle_rad: questions.number(
            arguments.half_angle,
            "half of the angle in which it does, in rad; 10° are 0.175",
            0.2,
        )?,
        period_s: questions.number(arguments.period, "time between two detections, in s", 0.1)?,
    })
}

/// Where questions go, and where answers come from.
struct Questions<'a, I, O> {
    input: &'a mut I,
    output: &'a mut O,
}

impl<I: BufRead, O: Write> Questions<'_, I, O> {
    fn number(&mut self, given: Option<f64>, what: &str, usual: f64) -> anyhow::Result<f64> {
        given.map_or_else(|| self.ask(what, usual), Ok)
    }

    /// Asks until the answer can be read.
    fn ask<T: std::str::FromStr + std::fmt::Display>(
        &mut self,
        what: &str,
        usual: T,
    ) -> anyhow::Result<T> {
        loop {
            write!(self.output, "{what} [{usual}]: ")
                .and_then(|()| self.output.flush())
                .context("asking")?;
            let mut line = String::new();
            if self.input.read_line(&mut line).context("reading the answer")? == 0 {
                anyhow::bail!("standard input ended before all was answered; nothing was written");
            }
            match line.trim() {
                "" => return Ok(usual),
                answer => match answer.parse() {
                    Ok(value) => return Ok(value),
                    Err(_) => writeln!(self.output, "`{answer}` is no answer").context("asking")?,
                },
            }
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
        let mut answers = "\nmany\n4\n\n0.2\n\n\n\n".as_bytes();
        let mut asked = Vec::new();

        let robots =
            ask(&arguments(&["--period", "0.13"]), &mut answers, &mut asked).expect("answered");

        let expected = Robots {
            name: "robot".to_owned(),
            n_robots: 4,
            radius_m: 0.075,
            speed_m_s: 0.2,
            turn_rate_rad_s: 2.0,
            range_m: 1.0,
            half_angle_rad: 0.2,
            period_s: 0.13,
        };
        assert_eq!(robots, expected);
        let asked = String::from_utf8(asked).expect("it is UTF-8");
        assert!(asked.contains("`many` is no answer") && !asked.contains("detections"), "{asked}");
    }

    #[test]
    fn what_is_missing_is_named_all_at_once() {
        let error = given(&arguments(&["--name", "a", "--speed", "0.2"])).unwrap_err().to_string();

        let missing = "--robots, --radius, --turn-rate, --range, --half-angle, --period not given";
        assert!(error.contains(missing), "{error}");
    }
}
