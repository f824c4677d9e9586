//! The file of a picture.

use std::path::Path;

use rsrs_view::raster::PNG_WIDTH_PX;

use super::Length;
use crate::error::with_help;
use crate::files::write_file;

/// A file whose extension decides how a picture is written into it.
#[derive(Clone, Copy, Debug)]
pub struct PictureFile<'a> {
    path: &'a Path,
    format: Format,
    /// Width of a PNG, in pixels.
    png_width_px: u32,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Svg,
    Png,
    Pdf,
}

impl<'a> PictureFile<'a> {
    /// The file at a path.
    ///
    /// # Errors
    ///
    /// If its extension is none of `svg`, `png` and `pdf`.
    pub fn new(path: &'a Path) -> anyhow::Result<Self> {
        let format = match path.extension().and_then(|ending| ending.to_str()) {
            Some("svg") => Format::Svg,
            Some("png") => Format::Png,
            Some("pdf") => Format::Pdf,
            _ => {
                let stem = path.with_extension("").display().to_string();
                return Err(with_help(
                    format!("{} ends in none of .svg, .png and .pdf", path.display()),
                    format!("name the picture `-o {stem}.svg`, `-o {stem}.png` or `-o {stem}.pdf`"),
                ));
            }
        };
        Ok(Self { path, format, png_width_px: PNG_WIDTH_PX })
    }

    /// The same file for a picture that is so wide on paper: a PNG has 600 dots to an inch of it.
    #[must_use]
    pub fn on_paper(self, width: Length) -> Self {
        Self { png_width_px: width.dots(), ..self }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.path
    }

    /// Writes a picture.
    ///
    /// # Arguments
    ///
    /// * `svg` — the picture as text.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn write(self, svg: &str) -> anyhow::Result<()> {
        let drawn;
        let bytes = match self.format {
            Format::Svg => svg.as_bytes(),
            Format::Png => {
                drawn = rsrs_view::raster::png(svg, self.png_width_px)?;
                &drawn
            }
            Format::Pdf => {
                drawn = rsrs_view::pdf::pdf(svg)?;
                &drawn
            }
        };
        write_file(self.path, bytes)
    }
}
