//! Words for a person: with a tone where a terminal shows colours, and plain everywhere else.

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use rsrs_core::printable::lines;

/// How something is. The words state it, too: a colour is beside them and never instead of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// As it should be: green.
    Good,
    /// Not known yet, or near another answer: yellow.
    Unclear,
    /// Not as it should be: red.
    Bad,
}

impl Tone {
    /// Good or bad.
    pub fn good_if(is_good: impl Into<bool>) -> Self {
        if is_good.into() { Self::Good } else { Self::Bad }
    }

    fn style(self) -> Style {
        let colour = match self {
            Self::Good => AnsiColor::Green,
            Self::Unclear => AnsiColor::Yellow,
            Self::Bad => AnsiColor::Red,
        };
        colour.on_default().bold()
    }
}

/// A text, parts of which have a tone.
#[derive(Clone, Debug, Default)]
pub struct Words {
    text: String,
    /// In the order in which they stand in the text; what has no tone is gone past.
    tones: Vec<(Option<Tone>, String)>,
}

impl Words {
    /// A text without a tone; of what others have put into it nothing is obeyed by a terminal.
    pub fn new(text: &(impl ToString + ?Sized)) -> Self {
        Self { text: lines(&text.to_string()).into_owned(), tones: Vec::new() }
    }

    /// Gives the next occurrence of a part a tone: the first one behind those that have one already.
    pub fn tone(mut self, tone: Tone, part: impl Into<String>) -> Self {
        self.tones.push((Some(tone), lines(&part.into()).into_owned()));
        self
    }

    /// Goes past the next occurrence of a part: what has a tone next stands behind it.
    pub fn past(mut self, part: impl Into<String>) -> Self {
        self.tones.push((None, lines(&part.into()).into_owned()));
        self
    }

    /// Adds lines below these.
    pub fn below(mut self, other: impl Into<Self>) -> Self {
        let other = other.into();
        self.text = format!("{}\n{}", self.text.trim_end(), other.text);
        self.tones.extend(other.tones);
        self
    }

    /// With the codes of a terminal; what prints them leaves them out where they are not wanted.
    pub fn painted(&self) -> String {
        let mut toned = String::new();
        let mut rest = self.text.trim_end();
        for (tone, part) in &self.tones {
            let at = rest.find(part.as_str());
            debug_assert!(at.is_some(), "“{part}” is not in “{rest}”");
            let Some(at) = at else { continue };
            let style = tone.map_or_else(Style::new, Tone::style);
            write!(toned, "{}{style}{part}{style:#}", &rest[..at])
                .expect("a string takes any text");
            rest = &rest[at + part.len()..];
        }
        toned.push_str(rest);
        toned.split('\n').map(labelled).collect::<Vec<_>>().join("\n")
    }
}

impl<T: AsRef<str>> From<T> for Words {
    fn from(text: T) -> Self {
        Self::new(text.as_ref())
    }
}

/// What a line may begin with, and how that looks.
const LABELS: [(&str, Style); 6] = [
    ("error:", AnsiColor::Red.on_default().bold()),
    ("warning:", AnsiColor::Yellow.on_default().bold()),
    ("help:", Style::new().bold()),
    ("next:", Style::new().bold()),
    ("then:", Style::new().bold()),
    ("note:", Style::new().bold()),
];

/// A line whose label catches the eye.
fn labelled(line: &str) -> String {
    let is_its = |(label, _): &&(&str, Style)| line.starts_with(label);
    match LABELS.iter().find(is_its) {
        Some((label, style)) => format!("{style}{label}{style:#}{}", &line[label.len()..]),
        None => line.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_their_tones_in_the_order_of_the_text() {
        let words = Words::from("robot_1  yes\nrobot_2  NO\nrobot_3  yes")
            .tone(Tone::Good, "yes")
            .tone(Tone::Bad, "NO")
            .tone(Tone::Good, "yes");

        let expected = "robot_1  \u{1b}[1m\u{1b}[32myes\u{1b}[0m\nrobot_2  \
                        \u{1b}[1m\u{1b}[31mNO\u{1b}[0m\nrobot_3  \u{1b}[1m\u{1b}[32myes\u{1b}[0m";
        assert_eq!(words.painted(), expected);
    }

    #[test]
    fn what_others_have_put_into_a_text_moves_no_cursor_and_hides_nothing() {
        let hostile = "the e-stop\u{1b}[1A\r\u{1b}[2K";
        let words = Words::from(format!("robot_8 NO {hostile}")).tone(Tone::Bad, hostile);

        let shown = "the e-stop\\u001b[1A\\u000d\\u001b[2K";
        assert_eq!(words.painted(), format!("robot_8 NO \u{1b}[1m\u{1b}[31m{shown}\u{1b}[0m"));
    }

    #[test]
    fn what_is_gone_past_stays_plain() {
        let words = Words::from("yes.mcap: yes").past("yes.mcap: ").tone(Tone::Good, "yes");

        assert_eq!(words.painted(), "yes.mcap: \u{1b}[1m\u{1b}[32myes\u{1b}[0m");
    }

    #[test]
    fn labels_stand_out_at_the_beginning_of_a_line_only() {
        let words = Words::from("the next: word\nnext: rsrs label run_1");

        assert_eq!(words.painted(), "the next: word\n\u{1b}[1mnext:\u{1b}[0m rsrs label run_1");
    }
}
