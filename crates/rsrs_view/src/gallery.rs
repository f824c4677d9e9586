//! Some runs from above, side by side.

use crate::floor::PAGE_PX;
use crate::svg::Element;
use crate::trajectory::{TrajectoryPicture, TrajectoryPictureError, elements};

/// Size of a picture in the gallery, relative to that of one alone.
const SCALE: f64 = 0.6;

/// Draws runs in rows, from left to right and from top to bottom, at most `n_columns` (1 or more)
/// in each; `title` is for screen readers.
///
/// The SVG document is self-contained, and the same text on every machine.
pub fn svg(
    title: &str,
    pictures: &[TrajectoryPicture],
    n_columns: usize,
) -> Result<String, TrajectoryPictureError> {
    let drawn = pictures.iter().map(elements).collect::<Result<Vec<_>, _>>()?;
    let n_columns = n_columns.min(drawn.len()).max(1);
    let width_px = PAGE_PX * SCALE;
    let (mut top_px, mut groups) = (0.0, Vec::new());
    for row in drawn.chunks(n_columns) {
        for (column, (elements, _)) in row.iter().enumerate() {
            let place = format!("translate({} {top_px}) scale({SCALE})", column as f64 * width_px);
            let group = Element::new("g").with("transform", &place);
            groups.push(group.children(elements.iter().cloned()));
        }
        let height_px = row.iter().map(|(_, height_px)| *height_px).fold(0.0, f64::max);
        top_px += height_px * SCALE;
    }
    let page = Element::picture(n_columns as f64 * width_px, top_px, title).children(groups);
    Ok(format!("{page}\n"))
}
