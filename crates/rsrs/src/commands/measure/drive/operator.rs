//! Questions to the operator: the readings of tape and stopwatch, and whether all stands where it
//! should.

use std::future::poll_fn;
use std::io::{BufRead, Write};
use std::task::Poll;

use anyhow::Context;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_experiment_runner::plan::Plan;

use crate::interrupt::asked_to_stop;
use crate::question;
use rsrs_operate::drive::Ready;
use rsrs_operate::drive::result::Motion;
use rsrs_pipeline::error::with_help;

/// Asks on standard error for what the robot did, and reads the answers from standard input; a
/// signal, or the end of the input, ends it with an error.
///
/// What is not understood is asked again: the trial was driven already.
pub async fn ask(plan: &Plan) -> anyhow::Result<Motion> {
    let record = &plan.record;
    let command = record.conditions.controller.parameters().expect("a trial has one command");
    let driven_s = record.duration_s;
    let bag = plan.bag.display();
    let unanswered = || format!("{bag} has no poses, so the operator's measurement is needed");
    let motion = asked(move |interview| interview.motion(command, driven_s)).await;
    let motion = motion.and_then(|motion| {
        motion.ok_or_else(|| {
            with_help(
                "interrupted before the answer",
                "the trial was driven: write what you measured into the table, or drive it again",
            )
        })
    });
    motion.with_context(unanswered)
}

/// Puts a question to the person at the terminal; `None` if a signal comes before the answer.
async fn asked<T: Send + 'static>(
    question: impl FnOnce(&mut Terminal) -> anyhow::Result<T> + Send + 'static,
) -> anyhow::Result<Option<T>> {
    let mut stop = std::pin::pin!(asked_to_stop());
    // Before the question appears, so that a signal that follows it at once is not missed.
    if poll_fn(|context| Poll::Ready(stop.as_mut().poll(context).is_ready())).await {
        return Ok(None);
    }
    let (sender, answer) = tokio::sync::oneshot::channel();
    // A thread that waits for a line cannot be ended; it goes with the process.
    std::thread::spawn(move || {
        // Standard error is not locked: others report there while a question waits.
        let mut interview = Interview { input: std::io::stdin().lock(), output: std::io::stderr() };
        // Nobody waits for it when the command was ended meanwhile.
        drop(sender.send(question(&mut interview)));
    });
    tokio::select! {
        answer = answer => answer.context("the thread that asks has ended")?.map(Some),
        _ = stop => Ok(None),
    }
}

/// Prints on standard error what to do, and waits until it is done; a signal ends it.
pub async fn ready(words: &str) -> anyhow::Result<Ready> {
    let words = words.to_owned();
    Ok(asked(move |interview| interview.ready(&words)).await?.unwrap_or(Ready::End))
}

/// Where questions go, and where answers come from.
struct Interview<I, O> {
    input: I,
    output: O,
}

/// Where the person is.
type Terminal = Interview<std::io::StdinLock<'static>, std::io::Stderr>;

impl<I: BufRead, O: Write> Interview<I, O> {
    /// The questions for a command that was driven for some seconds.
    fn motion(&mut self, command: ControllerParameters, driven_s: f64) -> anyhow::Result<Motion> {
        let ControllerParameters { speed_m_s, turn_rate_rad_s, .. } = command;
        let time = format!("time that it took, in s (Enter: {driven_s})");
        match (speed_m_s > 0.0, turn_rate_rad_s > 0.0) {
            (true, false) => Ok(Motion::Straight {
                commanded_m_s: speed_m_s,
                distance_m: self.required("distance along the line, in m")?,
                duration_s: self.optional(&time)?.unwrap_or(driven_s),
                lateral_m: self.optional(
                    "where it ended beside the line, in m, left is positive (Enter: not measured)",
                )?,
                heading_change_rad: self.optional(
                    "change of its heading, in rad, left is positive (Enter: not measured)",
                )?,
            }),
            (false, _) => Ok(Motion::Turn {
                commanded_rad_s: turn_rate_rad_s,
                angle_rad: self.required("angle turned, in rad; a full circle is 6.2832")?,
                duration_s: self.optional(&time)?.unwrap_or(driven_s),
            }),
            (true, true) => Ok(Motion::Curve {
                commanded_m_s: speed_m_s,
                commanded_rad_s: turn_rate_rad_s,
                angle_rad: self.required("angle turned, in rad; a full circle is 6.2832")?,
                duration_s: self.optional(&time)?.unwrap_or(driven_s),
            }),
        }
    }

    fn ready(&mut self, words: &str) -> anyhow::Result<Ready> {
        loop {
            let question = format!("{words}; then Enter (s skips it, q ends here)");
            let answer = self.answer(&question, "the placement was confirmed")?;
            match answer.as_str() {
                "" => return Ok(Ready::Go),
                "s" => return Ok(Ready::Skip),
                "q" => return Ok(Ready::End),
                other => writeln!(self.output, "`{other}` is not understood").context("asking")?,
            }
        }
    }

    fn answer(&mut self, question: &str, before: &str) -> anyhow::Result<String> {
        question::put((&mut self.input, &mut self.output), question, before)
    }

    fn required(&mut self, question: &str) -> anyhow::Result<f64> {
        loop {
            if let Some(number) = self.optional(question)? {
                return Ok(number);
            }
        }
    }

    /// One question; `None` for an empty answer.
    fn optional(&mut self, question: &str) -> anyhow::Result<Option<f64>> {
        loop {
            let answer = self.answer(question, &format!("the answer to `{question}`"))?;
            if answer.is_empty() {
                return Ok(None);
            }
            match answer.parse::<f64>() {
                Ok(number) if number.is_finite() => return Ok(Some(number)),
                _ => writeln!(self.output, "`{answer}` is no number, expected one such as 1.98")
                    .context("asking")?,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRAIGHT: ControllerParameters = ControllerParameters::mirrored(0.15, 0.0);

    fn printed(command: ControllerParameters, lines: &str) -> (anyhow::Result<Motion>, String) {
        let mut interview = Interview { input: lines.as_bytes(), output: Vec::new() };
        let motion = interview.motion(command, 13.0);
        (motion, String::from_utf8(interview.output).unwrap())
    }

    #[test]
    fn tape_and_stopwatch_make_a_straight_run() {
        let motion = printed(STRAIGHT, "1.95\n12.8\n\n0.05\n").0.unwrap();

        let expected = Motion::Straight {
            commanded_m_s: 0.15,
            distance_m: 1.95,
            duration_s: 12.8,
            lateral_m: None,
            heading_change_rad: Some(0.05),
        };
        assert_eq!(motion, expected);
    }

    #[test]
    fn what_is_no_number_is_asked_again() {
        let turn = ControllerParameters::mirrored(0.0, 0.5);

        let (motion, asked) = printed(turn, "a circle\n\n6.1\n\n");

        let expected = Motion::Turn { commanded_rad_s: 0.5, angle_rad: 6.1, duration_s: 13.0 };
        assert_eq!(motion.unwrap(), expected);
        assert!(asked.contains("`a circle` is no number, expected one such as 1.98"), "{asked}");
        assert_eq!(asked.matches("angle turned").count(), 3, "{asked}");
    }

    #[test]
    fn a_trial_begins_when_the_operator_confirms() {
        let answered = |lines: &str| {
            let mut interview = Interview { input: lines.as_bytes(), output: Vec::new() };
            (interview.ready("put it there"), String::from_utf8(interview.output).unwrap())
        };

        assert_eq!(answered("\n").0.unwrap(), Ready::Go);
        assert_eq!(answered("s\n").0.unwrap(), Ready::Skip);
        let (ready, asked) = answered("yes\nq\n");
        assert_eq!(ready.unwrap(), Ready::End);
        assert!(asked.contains("`yes` is not understood\nput it there; then Enter"), "{asked}");
        assert!(answered("").0.unwrap_err().to_string().contains("standard input ended"));
    }

    #[test]
    fn a_closed_input_is_reported() {
        let error = printed(STRAIGHT, "").0.unwrap_err().to_string();

        assert!(error.contains("standard input ended before the answer to `distance"), "{error}");
    }
}
