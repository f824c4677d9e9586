//! How a picture is printed.

use std::borrow::Cow;

use rsrs_view::raster::PNG_WIDTH_PX;
use rsrs_view::resized;
use rsrs_view::theme::Theme;

use super::Length;

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
    pub(super) fn fitted(self, svg: &str) -> Cow<'_, str> {
        self.width.map_or(Cow::Borrowed(svg), |width| Cow::Owned(resized(svg, width.px())))
    }

    /// Width of a PNG, in pixels: 600 to an inch of paper.
    pub(super) fn png_width_px(self) -> u32 {
        self.width.map_or(PNG_WIDTH_PX, Length::dots)
    }
}
