//! How pictures are printed, on the command line.

use std::path::Path;

use rsrs_render::picture_file::{Length, PageStyle, PictureFile};
use rsrs_view::theme::Theme;

use crate::failure::bad_arguments;

/// How pictures are printed.
#[derive(clap::Args, Clone, Copy)]
pub struct PageArguments {
    /// For a screen, or for a paper, where a caption explains it: without title, facts and notes,
    /// which become the file's description (default: screen).
    #[arg(
        long,
        value_name = "THEME",
        value_enum,
        default_value = "screen",
        hide_default_value = true
    )]
    theme: ThemeName,
    /// Width on paper, such as 88mm, 8.8cm or 3.5in; a PNG has 600 dots per inch (default: as wide
    /// as needed).
    #[arg(long, value_name = "WIDTH")]
    width: Option<Length>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ThemeName {
    Screen,
    Paper,
}

impl PageArguments {
    /// A file for pictures of this style; an extension of no picture counts as typed wrong.
    pub fn file(self, path: &Path) -> anyhow::Result<PictureFile<'_>> {
        let file = PictureFile::new(path).map_err(bad_arguments)?;
        Ok(file.styled(self.style()))
    }

    pub fn style(self) -> PageStyle {
        let theme = match self.theme {
            ThemeName::Screen => Theme::Screen,
            ThemeName::Paper => Theme::Paper,
        };
        PageStyle { theme, width: self.width }
    }
}
