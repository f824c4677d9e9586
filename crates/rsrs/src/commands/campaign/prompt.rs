//! Somebody or something that places robots, and says when they stand.

use tokio::sync::mpsc::UnboundedReceiver;

use crate::experiment_bar::TerminalOperator;
use crate::interrupt::asked_to_stop;
use crate::keyboard;
use crate::notes::print_note;
use rsrs_pipeline::run::place_command::{self, WantedPlacement};

/// Who is asked before a run starts.
pub enum Prompt {
    /// Nobody: it starts.
    Silent,
    /// A person; the lines that they type.
    Person(UnboundedReceiver<String>),
    /// A person who has gone, and can say no more.
    Gone,
    /// Nobody: this program places them.
    Program(String),
}

/// What a person wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The robots stand: start.
    Start,
    /// Not this one now.
    Skip,
    /// No more for now.
    Quit,
}

impl Answer {
    /// What a line means; `None` for what means nothing, so that a slip starts no robot.
    fn of(line: &str) -> Option<Self> {
        match line.trim() {
            "" => Some(Self::Start),
            "s" => Some(Self::Skip),
            "q" => Some(Self::Quit),
            _ => None,
        }
    }
}

const KEYS: &str = "Enter starts, s skips, q quits";

impl Prompt {
    /// Asks the person at the keyboard.
    pub fn at_keyboard() -> Self {
        keyboard::listen().map_or(Self::Gone, Self::Person)
    }

    /// Says what is next, and waits for the answer; Ctrl-C and a keyboard that is gone are a `q`.
    ///
    /// # Arguments
    ///
    /// * `what` — the experiment, and where its robots start.
    /// * `wanted` — the same for a program.
    ///
    /// # Errors
    ///
    /// If a program does not place the robots.
    pub async fn ask(&mut self, what: &str, wanted: &WantedPlacement) -> anyhow::Result<Answer> {
        print_note(what);
        if let Self::Program(program) = self {
            place_command::place(program, wanted, &TerminalOperator).await?;
            return Ok(Answer::Start);
        }
        Ok(self.ask_person().await)
    }

    async fn ask_person(&mut self) -> Answer {
        let lines = match self {
            Self::Silent | Self::Program(_) => return Answer::Start,
            Self::Gone => return Answer::Quit,
            Self::Person(lines) => lines,
        };
        // What was typed before it was asked is no answer.
        while lines.try_recv().is_ok() {}
        loop {
            print_note(KEYS);
            let line = tokio::select! {
                line = lines.recv() => line,
                _ = asked_to_stop() => return Answer::Quit,
            };
            let Some(line) = line else {
                *self = Self::Gone;
                return Answer::Quit;
            };
            if let Some(answer) = Answer::of(&line) {
                return answer;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_empty_line_starts_robots() {
        let answers = ["", " ", "s", "q", "x", "start", "sq"].map(Answer::of);

        let start = Some(Answer::Start);
        let (skip, quit) = (Some(Answer::Skip), Some(Answer::Quit));
        assert_eq!(answers, [start, start, skip, quit, None, None, None]);
    }
}
