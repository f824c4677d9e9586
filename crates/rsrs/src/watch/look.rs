//! Colours and signs, as far as the terminal has them.

use anstream::ColorChoice;
use ratatui::style::{Color, Modifier, Style};
use rsrs_ros::environment::Environment;

/// Whether there are colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// Those of the terminal's own sixteen that can be read on light and on dark.
    On,
    /// Bold, dim and reversed letters instead.
    Off,
}

/// Which signs there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signs {
    /// Arrows, blocks and lines.
    Unicode,
    /// Letters and punctuation marks.
    Ascii,
}

/// What a line that nobody overlooks is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BannerKind {
    /// Something is to be done.
    Alarm,
    /// Something was done.
    Done,
}

/// How everything looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    pub colours: Colours,
    pub signs: Signs,
}

impl Look {
    /// By `--color`, `NO_COLOR` (<https://no-color.org>) and the character set of `LC_ALL`, `LC_CTYPE` or
    /// `LANG`, the first that is set.
    pub fn new(choice: ColorChoice, environment: &Environment) -> Self {
        let variable = |name| environment.variable(name).filter(|value| !value.is_empty());
        let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(variable);
        let is_utf_8 = locale.is_some_and(|locale| {
            let locale = locale.to_ascii_lowercase();
            locale.contains("utf-8") || locale.contains("utf8")
        });
        let colours = match choice {
            ColorChoice::Never => Colours::Off,
            ColorChoice::Auto if variable("NO_COLOR").is_some() => Colours::Off,
            ColorChoice::Auto | ColorChoice::Always | ColorChoice::AlwaysAnsi => Colours::On,
        };
        Self { colours, signs: if is_utf_8 { Signs::Unicode } else { Signs::Ascii } }
    }

    /// One sign or the other.
    pub fn sign(self, unicode: &'static str, ascii: &'static str) -> &'static str {
        match self.signs {
            Signs::Unicode => unicode,
            Signs::Ascii => ascii,
        }
    }

    fn style(self, colour: Color, modifier: Modifier) -> Style {
        match self.colours {
            Colours::On => Style::new().fg(colour),
            Colours::Off => Style::new().add_modifier(modifier),
        }
    }

    /// What moves, or is as it should be.
    pub fn good(self) -> Style {
        self.style(Color::Green, Modifier::empty())
    }

    /// What waits, or is not what it should be yet.
    pub fn waiting(self) -> Style {
        self.style(Color::Cyan, Modifier::empty())
    }

    /// What a person should look at.
    pub fn alarm(self) -> Style {
        self.style(Color::Red, Modifier::REVERSED).add_modifier(Modifier::BOLD)
    }

    /// A robot that sees another one.
    pub fn seeing(self) -> Style {
        self.style(Color::Yellow, Modifier::BOLD).add_modifier(Modifier::BOLD)
    }

    /// What matters less, or is old.
    pub fn quiet(self) -> Style {
        self.style(Color::DarkGray, Modifier::DIM)
    }

    /// A line that nobody overlooks.
    pub fn banner(self, kind: BannerKind) -> Style {
        let colour = match kind {
            BannerKind::Alarm => Color::Red,
            BannerKind::Done => Color::Green,
        };
        match self.colours {
            Colours::On => Style::new().fg(Color::White).bg(colour).add_modifier(Modifier::BOLD),
            Colours::Off => Style::new().add_modifier(Modifier::BOLD | Modifier::REVERSED),
        }
    }
}

/// Titles and names.
pub fn strong() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}
