//! What a person types while a bag is played.

use std::io::{BufRead, IsTerminal};

use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

/// What a person wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Pause, or go on.
    Toggle,
    /// Play the messages of one moment, and pause.
    Step,
    /// End.
    Quit,
}

impl Wish {
    /// What a line means; `None` for what means nothing.
    fn of(line: &str) -> Option<Self> {
        match line.trim() {
            "" | "p" => Some(Self::Toggle),
            "s" => Some(Self::Step),
            "q" => Some(Self::Quit),
            _ => None,
        }
    }
}

/// Listens to the keyboard; `None` where there is nobody at it.
pub fn listen() -> Option<UnboundedReceiver<Wish>> {
    if !std::io::stdin().is_terminal() {
        return None;
    }
    let (sender, receiver) = unbounded_channel();
    // A thread that waits for a line cannot be ended; it goes with the process.
    std::thread::spawn(move || {
        let lines = std::io::stdin().lock().lines().map_while(Result::ok);
        for wish in lines.filter_map(|line| Wish::of(&line)) {
            if sender.send(wish).is_err() {
                return;
            }
        }
    });
    Some(receiver)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enter_toggles_and_other_words_mean_nothing() {
        let wishes = ["", " ", "p", "s", "q", "stop"].map(Wish::of);

        let toggle = Some(Wish::Toggle);
        assert_eq!(wishes, [toggle, toggle, toggle, Some(Wish::Step), Some(Wish::Quit), None]);
    }
}
