//! What a person types while a bag is played.

use tokio::sync::mpsc::UnboundedReceiver;

/// What a person wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlayerKey {
    /// Pause, or go on.
    Toggle,
    /// Play the messages of one moment, and pause.
    Step,
    /// Go to so many seconds behind the start of the bag.
    GoTo(f64),
    /// Go so many seconds forward, or back where it is negative.
    GoBy(f64),
    /// End.
    Quit,
}

/// What can be typed, each with Enter.
pub const KEYS: &str = "Enter goes on, `s` makes a step, `s 42` goes to 42 s, `+10` and `-10` go on and \
                        back, `q` ends";

impl PlayerKey {
    /// What a line means; `None` for what means nothing.
    fn of(line: &str) -> Option<Self> {
        let line = line.trim();
        let seconds = |text: &str| text.trim().parse::<f64>().ok().filter(|it| it.is_finite());
        match line {
            "" | "p" => Some(Self::Toggle),
            "s" => Some(Self::Step),
            "q" => Some(Self::Quit),
            _ if line.starts_with(['+', '-']) => seconds(line).map(Self::GoBy),
            _ => seconds(line.strip_prefix("s ")?).filter(|it| *it >= 0.0).map(Self::GoTo),
        }
    }
}

/// What somebody types, where there is somebody.
pub struct Controls {
    lines: Option<UnboundedReceiver<String>>,
}

impl Controls {
    /// Listens to the keyboard.
    pub fn listen() -> Self {
        Self { lines: crate::keyboard::listen() }
    }

    /// Whether somebody is there.
    pub fn has_person(&self) -> bool {
        self.lines.is_some()
    }

    /// The next thing that the person wants; never, where there is none.
    pub async fn next(&mut self) -> PlayerKey {
        while let Some(lines) = &mut self.lines {
            match lines.recv().await {
                Some(line) => {
                    if let Some(key) = PlayerKey::of(&line) {
                        return key;
                    }
                }
                // The keyboard is gone.
                None => self.lines = None,
            }
        }
        std::future::pending().await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enter_toggles_and_other_words_mean_nothing() {
        let wishes = ["", " ", "p", "s", "q", "stop", "s x", "+", "s -3"].map(PlayerKey::of);

        let toggle = Some(PlayerKey::Toggle);
        let (step, quit) = (Some(PlayerKey::Step), Some(PlayerKey::Quit));
        assert_eq!(wishes, [toggle, toggle, toggle, step, quit, None, None, None, None]);
    }

    #[test]
    fn places_are_times_and_ways_have_a_sign() {
        let wishes = ["s 42.5", "+10", "-0.5"].map(PlayerKey::of);

        let expected = [PlayerKey::GoTo(42.5), PlayerKey::GoBy(10.0), PlayerKey::GoBy(-0.5)];
        assert_eq!(wishes, expected.map(Some));
    }
}
