//! Words for a person: with a tone where a terminal shows colours, and plain everywhere else.

use std::fmt;

use anstyle::{AnsiColor, Style};
use rsrs_core::printable::{lines, one_line};

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

/// A text of spans, some of which have a tone. Of what others have put into them nothing is obeyed by a
/// terminal.
#[derive(Clone, Debug, Default)]
pub struct Words {
    spans: Vec<(Option<Tone>, String)>,
}

impl Words {
    /// A text with a tone.
    pub fn toned(tone: Tone, text: impl AsRef<str>) -> Self {
        Self { spans: vec![(Some(tone), lines(text.as_ref()).into_owned())] }
    }

    /// Adds what follows.
    #[must_use]
    pub fn then(mut self, other: impl Into<Self>) -> Self {
        self.spans.extend(other.into().spans);
        self
    }

    /// Adds what follows, with a tone.
    #[must_use]
    pub fn then_toned(self, tone: Tone, text: impl AsRef<str>) -> Self {
        self.then(Self::toned(tone, text))
    }

    /// Adds lines below these.
    #[must_use]
    pub fn below(self, other: impl Into<Self>) -> Self {
        self.then("\n").then(other)
    }

    /// Lines, one below the other.
    pub fn lines(all: impl IntoIterator<Item = impl Into<Self>>) -> Self {
        all.into_iter().map(Into::into).reduce(Self::below).unwrap_or_default()
    }

    /// The same on one line.
    pub(crate) fn on_one_line(&self) -> Self {
        let one_lined =
            |(tone, text): &(Option<Tone>, String)| (*tone, one_line(text).into_owned());
        Self { spans: self.spans.iter().map(one_lined).collect() }
    }

    /// How many characters it has.
    pub(crate) fn width(&self) -> usize {
        self.spans.iter().map(|(_, text)| text.chars().count()).sum()
    }

    /// Without spaces at its end.
    pub(crate) fn trimmed(mut self) -> Self {
        while let Some((_, last)) = self.spans.last_mut() {
            last.truncate(last.trim_end().len());
            if !last.is_empty() {
                break;
            }
            self.spans.pop();
        }
        self
    }

    /// With the codes of a terminal; what prints them leaves them out where they are not wanted.
    pub fn painted(&self) -> String {
        let painted = |(tone, text): &(Option<Tone>, String)| match tone {
            Some(tone) => format!("{}{text}{:#}", tone.style(), tone.style()),
            None => text.clone(),
        };
        let text: String = self.spans.iter().map(painted).collect();
        text.trim_end().split('\n').map(labelled).collect::<Vec<_>>().join("\n")
    }
}

/// The words alone.
impl fmt::Display for Words {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.spans.iter().try_for_each(|(_, text)| formatter.write_str(text))
    }
}

impl<T: AsRef<str>> From<T> for Words {
    fn from(text: T) -> Self {
        Self { spans: vec![(None, lines(text.as_ref()).into_owned())] }
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
    fn spans_have_their_tones_where_they_stand() {
        let words = Words::from("robot_1  ")
            .then_toned(Tone::Good, "yes")
            .below("robot_2  ")
            .then_toned(Tone::Bad, "NO");

        let expected = "robot_1  \u{1b}[1m\u{1b}[32myes\u{1b}[0m\nrobot_2  \
                        \u{1b}[1m\u{1b}[31mNO\u{1b}[0m";
        assert_eq!(words.painted(), expected);
        assert_eq!(words.to_string(), "robot_1  yes\nrobot_2  NO");
    }

    #[test]
    fn what_others_have_put_into_a_text_moves_no_cursor_and_hides_nothing() {
        let hostile = "the e-stop\u{1b}[1A\r\u{1b}[2K";
        let words = Words::from("robot_8 NO ").then_toned(Tone::Bad, hostile);

        let shown = "the e-stop\\u001b[1A\\u000d\\u001b[2K";
        assert_eq!(words.painted(), format!("robot_8 NO \u{1b}[1m\u{1b}[31m{shown}\u{1b}[0m"));
    }

    #[test]
    fn labels_stand_out_at_the_beginning_of_a_line_only() {
        let words = Words::from("the next: word\nnext: rsrs label run_1");

        assert_eq!(words.painted(), "the next: word\n\u{1b}[1mnext:\u{1b}[0m rsrs label run_1");
    }
}
