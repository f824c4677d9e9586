//! From SVG to PNG, with a font that travels along.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{ImageHrefResolver, Options, Tree, fontdb};
use rsrs_core::help::Help;

/// Subsets of `DejaVu Sans`; `fonts/README.md` states how they were made.
pub(crate) const FONTS: [&[u8]; 2] = [
    include_bytes!("../fonts/DejaVuSans-subset.ttf"),
    include_bytes!("../fonts/DejaVuSans-Bold-subset.ttf"),
];

/// Their family.
pub(crate) const FONT_FAMILY: &str = "DejaVu Sans";

/// Width of pictures whose width nobody gave, in pixels: sharp in print across a column.
pub const PNG_WIDTH_PX: u32 = 1600;

/// The longest side of a PNG, in pixels.
pub const MOST_PX: u32 = 16_384;

/// Why there is no PNG.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// The text is no SVG.
    #[error("not a drawable svg")]
    Svg(#[source] Box<resvg::usvg::Error>),
    /// The picture would have no pixel, or too many of them.
    #[error("a picture of {width_px} x {height_px} px; expected 1 to {MOST_PX} px on each side")]
    Size {
        /// The width asked for, in pixels.
        width_px: u32,
        /// The height that follows from the picture's shape, in pixels.
        height_px: u32,
    },
    /// The encoder failed.
    #[error("png encoder: {0}")]
    Encode(String),
}

impl Help for RasterError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Size { .. } => Some("ask for a width of about 1600 px".to_owned()),
            Self::Svg { .. } | Self::Encode { .. } => None,
        }
    }
}

/// Draws an SVG of this crate as a PNG on white, `width_px` wide (1 to [`MOST_PX`] pixels); the
/// height follows.
///
/// Uses the embedded font for every text, and loads nothing that the SVG refers to, so the same SVG
/// gives the same picture on every machine.
///
/// # Errors
///
/// [`RasterError::Size`] if a side would be 0 or above [`MOST_PX`].
pub fn png(svg: &str, width_px: u32) -> Result<Vec<u8>, RasterError> {
    let tree = parse(svg)?;
    let scale = width_px as f32 / tree.size().width();
    let height_px = (scale * tree.size().height()).round() as u32;
    let is_drawable = |side_px: u32| (1..=MOST_PX).contains(&side_px);
    if !is_drawable(width_px) || !is_drawable(height_px) {
        return Err(RasterError::Size { width_px, height_px });
    }

    let pixmap = pixmap(&tree, (width_px, height_px))?;
    encode(&pixmap).map_err(|error| RasterError::Encode(error.to_string()))
}

/// Draws an SVG on white, as wide as asked for.
pub(crate) fn pixmap(
    tree: &Tree,
    (width_px, height_px): (u32, u32),
) -> Result<Pixmap, RasterError> {
    let mut pixmap =
        Pixmap::new(width_px, height_px).ok_or(RasterError::Size { width_px, height_px })?;
    pixmap.fill(Color::WHITE);
    let scale = width_px as f32 / tree.size().width();
    resvg::render(tree, Transform::from_scale(scale, scale), &mut pixmap.as_mut());
    Ok(pixmap)
}

/// Three bytes a pixel, for nothing shows through white, and as small as it is worth waiting for:
/// smaller ones take as long to encode as to draw.
fn encode(pixmap: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    let pixels = pixmap.pixels().iter();
    let colours: Vec<u8> = pixels.flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&colours)?;
    writer.finish()?;
    Ok(bytes)
}

/// Reads an SVG with the embedded font, its texts as outlines.
pub fn parse(svg: &str) -> Result<Tree, RasterError> {
    // A film has hundreds of frames.
    static LOADED: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
        let mut fonts = fontdb::Database::new();
        for font in FONTS {
            fonts.load_font_data(font.to_vec());
        }
        fonts.set_sans_serif_family(FONT_FAMILY);
        Arc::new(fonts)
    });
    let options = Options {
        fontdb: LOADED.clone(),
        font_family: FONT_FAMILY.to_owned(),
        // The default opens files that an SVG names.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    Tree::from_str(svg, &options).map_err(|source| RasterError::Svg(Box::new(source)))
}

/// Width of one line of text as drawn, in pixels: the truth behind the table in `text.rs`.
#[cfg(test)]
pub(crate) fn width_of_rendered_text_px(text: &str, size_px: f64, weight: &str) -> f64 {
    let line = crate::svg::line_of_text(0.0, size_px, text)
        .with("font-family", FONT_FAMILY)
        .with("font-weight", weight)
        .at("font-size", size_px);
    let svg = crate::svg::Element::picture(2000.0, 100.0, "text").child(line).to_string();
    let tree = parse(&svg).expect("the writer writes svg");
    let drawn = tree.root().children().last().expect("the text is drawn");
    f64::from(drawn.abs_bounding_box().width())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::{Element, line_of_text, rectangle};

    fn letters(text: &str) -> String {
        let line = line_of_text(5.0, 30.0, text).at("font-size", 24.0);
        Element::picture(200.0, 50.0, "letters").child(line).to_string()
    }

    fn dark_pixels(png: &[u8]) -> usize {
        let pixmap = Pixmap::decode_png(png).unwrap();
        pixmap.pixels().iter().filter(|pixel| pixel.red() < 128).count()
    }

    #[test]
    fn a_png_has_the_width_asked_for_and_the_shape_of_the_svg() {
        let pixmap = Pixmap::decode_png(&png(&letters("ring"), 400).unwrap()).unwrap();

        assert_eq!((pixmap.width(), pixmap.height()), (400, 100));
    }

    #[test]
    fn letters_are_drawn_with_the_embedded_font() {
        assert_eq!(dark_pixels(&png(&letters(" "), 400).unwrap()), 0);
        for text in ["ring", "\u{3b8}\u{3c9}\u{394}", "\u{2265}\u{2212}\u{b0}\u{b7}\u{d7}\u{2014}"]
        {
            assert!(dark_pixels(&png(&letters(text), 400).unwrap()) > 100, "{text}");
        }
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        for width_px in [0, MOST_PX + 1] {
            let error = png(&letters("ring"), width_px).unwrap_err();
            assert!(matches!(error, RasterError::Size { .. }), "{error}");
        }
        assert!(matches!(png("no svg", 100), Err(RasterError::Svg { .. })));
    }

    #[test]
    fn files_that_a_picture_names_are_not_opened() {
        let black = Element::new("svg")
            .with("xmlns", "http://www.w3.org/2000/svg")
            .at("width", 10.0)
            .at("height", 10.0)
            .child(rectangle(0.0, 0.0, 10.0, 10.0))
            .to_string();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("black.svg");
        std::fs::write(&path, &black).unwrap();
        let image = Element::new("image")
            .with("href", path.to_str().unwrap())
            .at("width", 10.0)
            .at("height", 10.0);
        let naming = Element::picture(20.0, 20.0, "image").child(image).to_string();

        assert_eq!(dark_pixels(&png(&black, 10).unwrap()), 100);
        assert_eq!(dark_pixels(&png(&naming, 20).unwrap()), 0);
    }
}
