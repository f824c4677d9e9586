//! A person or a program that places robots, and confirms that they stand.

use std::pin::Pin;

use rsrs_operate::campaign::{OperatorDecision, Placer};
use tokio::sync::mpsc::UnboundedReceiver;

use crate::experiment_bar::TerminalOperator;
use crate::interrupt::asked_to_stop;
use crate::keyboard;
use crate::notes::print_always;
use rsrs_operate::run::place_command::{self, WantedPlacement};
use rsrs_render::start_poses::{RunToPlace, to_place};

/// Who is asked before a run starts.
pub enum Prompt {
    /// Nobody: it starts.
    Silent,
    /// A person; the lines that they type.
    Person(UnboundedReceiver<String>),
    /// The input was closed.
    Gone,
    /// Nobody: this program places them.
    Program(String),
}

/// What a line means; `None` for what means nothing, so that a slip starts no robot.
fn answer(line: &str) -> Option<OperatorDecision> {
    match line.trim() {
        "" => Some(OperatorDecision::Start),
        "s" => Some(OperatorDecision::Skip),
        "q" => Some(OperatorDecision::Quit),
        _ => None,
    }
}

const KEYS: &str = "Enter starts, s skips, q quits";

impl Prompt {
    /// Asks the person at the keyboard.
    pub fn at_keyboard() -> Self {
        keyboard::listen().map_or(Self::Gone, Self::Person)
    }

    async fn ask_person(&mut self) -> OperatorDecision {
        let lines = match self {
            Self::Silent | Self::Program(_) => return OperatorDecision::Start,
            Self::Gone => return OperatorDecision::Quit,
            Self::Person(lines) => lines,
        };
        // What was typed before it was asked is no answer.
        while lines.try_recv().is_ok() {}
        loop {
            print_always(KEYS);
            let line = tokio::select! {
                line = lines.recv() => line,
                _ = asked_to_stop() => return OperatorDecision::Quit,
            };
            let Some(line) = line else {
                *self = Self::Gone;
                return OperatorDecision::Quit;
            };
            if let Some(answer) = answer(&line) {
                return answer;
            }
        }
    }
}

impl Placer for Prompt {
    /// Asks, and waits for the answer; Ctrl-C and a keyboard that is gone are a `q`.
    fn place<'a>(
        &'a mut self,
        run: &'a RunToPlace<'a>,
        wanted: &'a WantedPlacement,
    ) -> Pin<Box<dyn Future<Output = anyhow::Result<OperatorDecision>> + 'a>> {
        print_always(to_place(run));
        Box::pin(async move {
            if let Self::Program(program) = self {
                place_command::place(program, wanted, &TerminalOperator).await?;
                return Ok(OperatorDecision::Start);
            }
            Ok(self.ask_person().await)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_empty_line_starts_robots() {
        let answers = ["", " ", "s", "q", "x", "start", "sq"].map(answer);

        let start = Some(OperatorDecision::Start);
        let (skip, quit) = (Some(OperatorDecision::Skip), Some(OperatorDecision::Quit));
        assert_eq!(answers, [start, start, skip, quit, None, None, None]);
    }
}
