//! How pictures are printed, on the command line.

use rsrs_pipeline::picture_file::{Length, PageStyle};
use rsrs_view::theme::Theme;

/// How pictures are printed.
#[derive(clap::Args, Clone, Copy)]
pub struct PageArguments {
    /// Where it is looked at: on a screen, or in a paper, above a caption, without title, facts and notes,
    /// which are in the file as its description (default: screen).
    #[arg(
        long,
        value_name = "THEME",
        value_enum,
        default_value = "screen",
        hide_default_value = true
    )]
    theme: ThemeName,
    /// Width on paper, such as 88mm, 8.8cm or 3.5in; a PNG has 600 dots to an inch of it (default: as wide
    /// as it takes).
    #[arg(long, value_name = "WIDTH")]
    width: Option<Length>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ThemeName {
    Screen,
    Paper,
}

impl PageArguments {
    /// The style of the pictures.
    pub fn style(self) -> PageStyle {
        let theme = match self.theme {
            ThemeName::Screen => Theme::Screen,
            ThemeName::Paper => Theme::Paper,
        };
        PageStyle { theme, width: self.width }
    }
}
