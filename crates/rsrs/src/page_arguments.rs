//! How pictures are printed, on the command line.

use std::path::Path;

use rsrs_pipeline::error::with_help;
use rsrs_render::picture_file::{Length, PageStyle, PictureFile};
use rsrs_view::theme::Theme;

use crate::failure::bad_arguments;

/// How pictures are printed.
#[derive(clap::Args, Clone, Copy)]
pub struct PageArguments {
    /// For a screen, or for a paper, where a caption explains it: without title, facts and notes,
    /// which become the file's description (default: screen).
    #[arg(long, value_name = "THEME", value_enum)]
    theme: Option<ThemeName>,
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

    /// The same where a picture is drawn only if `-o` names one.
    pub fn file_if(self, path: Option<&Path>) -> anyhow::Result<Option<PictureFile<'_>>> {
        self.check(path, "name it with `-o`")?;
        path.map(|path| self.file(path)).transpose()
    }

    /// Refuses a style where no picture is drawn; `help` is what else to type.
    pub fn check(self, drawn: Option<&Path>, help: &'static str) -> anyhow::Result<()> {
        let given = [("--theme", self.theme.is_some()), ("--width", self.width.is_some())];
        match (drawn, given.into_iter().find(|(_, is_given)| *is_given)) {
            (None, Some((style, _))) => Err(bad_arguments(with_help(
                format!("`{style}` is for pictures, and none is asked for"),
                help,
            ))),
            _ => Ok(()),
        }
    }

    pub fn style(self) -> PageStyle {
        let theme = match self.theme {
            None | Some(ThemeName::Screen) => Theme::Screen,
            Some(ThemeName::Paper) => Theme::Paper,
        };
        PageStyle { theme, width: self.width }
    }
}
