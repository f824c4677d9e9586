//! The files of pictures, and how they are printed.

mod length;

use std::borrow::Cow;
use std::path::Path;

use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::write_file;
use rsrs_view::raster::PNG_WIDTH_PX;
use rsrs_view::resized;
use rsrs_view::theme::Theme;

pub use length::Length;

/// A file whose extension decides how a picture is written into it.
#[derive(Clone, Copy, Debug)]
pub struct PictureFile<'a> {
    path: &'a Path,
    format: Format,
    style: PageStyle,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Svg,
    Png,
    Pdf,
}

impl<'a> PictureFile<'a> {
    /// The file at a path that ends in `.svg`, `.png` or `.pdf`.
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
        Ok(Self { path, format, style: PageStyle::default() })
    }

    /// The same file for a picture that is printed in a style.
    #[must_use]
    pub fn styled(self, style: PageStyle) -> Self {
        Self { style, ..self }
    }

    /// How it is printed.
    pub fn style(&self) -> PageStyle {
        self.style
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.path
    }

    /// Writes a picture that is given as SVG.
    pub fn write(self, svg: &str) -> anyhow::Result<()> {
        let svg = &*self.style.fitted(svg);
        let drawn;
        let bytes = match self.format {
            Format::Svg => svg.as_bytes(),
            Format::Png => {
                drawn = rsrs_view::raster::png(svg, self.style.png_width_px())?;
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

/// How a picture is printed.
#[derive(Clone, Copy, Debug, Default)]
pub struct PageStyle {
    /// Where it is looked at.
    pub theme: Theme,
    /// Its width; as wide as it takes if not given.
    pub width: Option<Length>,
}

impl PageStyle {
    /// A picture as wide as it is to be: one that was laid out at another width is scaled.
    fn fitted(self, svg: &str) -> Cow<'_, str> {
        self.width.map_or(Cow::Borrowed(svg), |width| Cow::Owned(resized(svg, width.px())))
    }

    /// Width of a PNG, in pixels: 600 to an inch of paper.
    fn png_width_px(self) -> u32 {
        self.width.map_or(PNG_WIDTH_PX, Length::dots)
    }
}

/// Writes an SVG as `NAME.svg` and as `NAME.png`.
pub fn write_svg_and_png(
    folder: &Path,
    name: &str,
    svg: &str,
    style: PageStyle,
) -> anyhow::Result<()> {
    for ending in ["svg", "png"] {
        let path = folder.join(format!("{name}.{ending}"));
        PictureFile::new(&path)?.styled(style).write(svg)?;
    }
    Ok(())
}
