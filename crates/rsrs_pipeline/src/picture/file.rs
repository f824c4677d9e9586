//! The file of a picture.

use std::path::Path;

use super::PNG_WIDTH_PX;
use crate::error::with_help;
use crate::files::write_file;

/// A file whose extension says how a picture is written into it.
#[derive(Clone, Copy, Debug)]
pub struct PictureFile<'a> {
    path: &'a Path,
    format: Format,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Svg,
    Png,
}

impl<'a> PictureFile<'a> {
    /// The file at a path.
    ///
    /// # Errors
    ///
    /// If its extension is neither `svg` nor `png`.
    pub fn new(path: &'a Path) -> anyhow::Result<Self> {
        let format = match path.extension().and_then(|ending| ending.to_str()) {
            Some("svg") => Format::Svg,
            Some("png") => Format::Png,
            _ => {
                let stem = path.with_extension("").display().to_string();
                return Err(with_help(
                    format!("{} ends in neither .svg nor .png", path.display()),
                    format!("name the picture `-o {stem}.svg` or `-o {stem}.png`"),
                ));
            }
        };
        Ok(Self { path, format })
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
        match self.format {
            Format::Svg => write_file(self.path, svg.as_bytes()),
            Format::Png => write_file(self.path, &rsrs_view::raster::png(svg, PNG_WIDTH_PX)?),
        }
    }
}
