//! From SVG to PDF, for papers: lines stay lines, and texts are the outlines of the font that travels along,
//! so that a page needs no font.

use resvg::usvg::WriteOptions;
use svg2pdf::{ConversionOptions, PageOptions, to_pdf};

use crate::raster::{RasterError, parse};

/// Pixels of a picture in an inch, as CSS has them.
pub const PX_PER_INCH: f32 = 96.0;

/// Why there is no PDF.
#[derive(Debug, thiserror::Error)]
pub enum PdfError {
    /// The text cannot be read.
    #[error(transparent)]
    Parse(#[from] RasterError),
    /// The writer failed.
    #[error("pdf writer: {0}")]
    Write(String),
}

/// Writes an SVG as a PDF of one page, as large as the picture at 96 pixels to an inch. The same SVG gives
/// the same bytes.
pub fn pdf(svg: &str) -> Result<Vec<u8>, PdfError> {
    // Texts written as what they look like: svg2pdf would bring along a second reader of fonts for them.
    let outlines = parse(svg)?.to_string(&WriteOptions::default());
    to_pdf(&parse(&outlines)?, ConversionOptions::default(), PageOptions { dpi: PX_PER_INCH })
        .map_err(|error| PdfError::Write(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::{Element, line_of_text};

    #[test]
    fn a_picture_is_a_page_of_its_size_on_which_its_texts_are_drawn() {
        let page = |text| {
            let picture = Element::picture(96.0, 48.0, "one inch")
                .child(line_of_text(10.0, 30.0, text).at("font-size", 12.0));
            pdf(&picture.to_string()).unwrap()
        };

        let one = page("mill");

        assert!(one.starts_with(b"%PDF-"));
        let text = String::from_utf8_lossy(&one);
        assert!(text.contains("/MediaBox [0 0 72 36]"), "{text}");
        assert!(!text.contains("/Font"), "a reader needs no font");
        assert!(one.len() > page("").len() + 100, "the text is drawn");
        assert_eq!(one, page("mill"));
        assert!(matches!(pdf("no picture"), Err(PdfError::Parse { .. })));
    }
}
