//! What a sensor detects: the paper's `fig:sim_sensing`, measured in blue and simulated in red.

use rsrs_core::trials::fit::SensorMap;

use crate::chart::{BELOW_PX, Chart, LEFT_PX, legend, stroke_mark};
use crate::header::{MARGIN_PX, header};
use crate::palette::{BLUE, INK, RED};
use crate::scale::ends;
use crate::svg::{Element, number};
use crate::theme::Theme;

const PAGE_PX: f64 = 560.0;
const HIGHEST_PX: f64 = 420.0;
const MEASURED: &str = BLUE;
const SIMULATED: &str = RED;

/// A measured sensor, the simulated one, and the text about them.
#[derive(Clone, Debug)]
pub struct SensorPicture<'a> {
    /// The sensor as it was measured.
    pub map: &'a SensorMap,
    /// The simulated region, counterclockwise, in metres, in the robot's frame; 3 corners or more.
    pub simulated_m: &'a [[f64; 2]],
    /// Radius of a robot's body, in metres; positive.
    pub radius_m: f64,
    /// Where it is looked at.
    pub theme: Theme,
    /// The title; any text.
    pub title: String,
    /// Under the title; any text.
    pub subtitle: String,
}

/// Why there is no picture of a sensor.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorPictureError {
    /// There is nothing to draw.
    #[error(
        "the map has {n_places} places and the simulated region {n_corners} corners; expected 1 and 3 or more"
    )]
    Empty {
        /// Places of the map.
        n_places: usize,
        /// Corners of the simulated region.
        n_corners: usize,
    },
    /// A point is nowhere, or the body has no size.
    #[error("{name} is {found}, expected a finite number{}", if *name == "the body's radius in m" { " above 0" } else { "" })]
    NotANumber {
        /// What.
        name: &'static str,
        /// What it is.
        found: f64,
    },
}

/// Draws the places that were tried, darker the more was detected there, with both polygons.
///
/// # Source
///
/// `fig:sim_sensing`, §IV steps 1 and 2.
pub fn svg(picture: &SensorPicture) -> Result<String, SensorPictureError> {
    check(picture)?;
    let room_px = PAGE_PX - 2.0 * MARGIN_PX;
    let (texts, header_px) =
        header(picture.theme, &picture.title, &[&picture.subtitle], MARGIN_PX, room_px);
    let [x, y] = bounds(picture);
    let chart = Chart::to_scale(
        (MARGIN_PX + LEFT_PX, header_px + 12.0),
        (room_px - LEFT_PX, HIGHEST_PX),
        x,
        y,
    );
    // The measured line is wider, so that it shows where the simulated one lies on it.
    let outline = |points: &[[f64; 2]], (stroke, opacity, width_px): (&str, &str, f64)| {
        Element::path(&chart.polygon(points))
            .filled(stroke, opacity)
            .stroked(stroke, width_px)
            .with("stroke-linejoin", "round")
    };
    let entries = [
        (stroke_mark(MEASURED, 5.0), "measured: detected at least 80 % of the time".to_owned()),
        (stroke_mark(SIMULATED, 2.0), "simulated".to_owned()),
        (node_mark(11.0, 0.0, 0.8), "a neighbour's centre; darker: detected more often".to_owned()),
    ];
    let (legend, bottom_px) =
        legend(&entries, (chart.left_px, chart.bottom_px() + BELOW_PX), room_px - LEFT_PX);
    let page = Element::picture(PAGE_PX, bottom_px + 10.0, &picture.title)
        .described(&picture.theme.description([picture.subtitle.as_str()], ""))
        .children(texts)
        .child(outline(&picture.map.contour_m, (MEASURED, "0.12", 5.0)))
        .child(outline(picture.simulated_m, (SIMULATED, "0.08", 2.0)))
        .child(robot(&chart, picture.radius_m))
        .child(nodes(&chart, picture.map))
        .child(chart.frame("ahead (m)"))
        .child(chart.y_axis("left (m)"))
        .children(legend);
    Ok(format!("{page}\n"))
}

fn check(picture: &SensorPicture) -> Result<(), SensorPictureError> {
    let (n_places, n_corners) = (picture.map.nodes.len(), picture.simulated_m.len());
    if n_places == 0 || n_corners < 3 || picture.map.contour_m.len() < 3 {
        return Err(SensorPictureError::Empty { n_places, n_corners });
    }
    let name = "the body's radius in m";
    let found = picture.radius_m;
    if !(found.is_finite() && found > 0.0) {
        return Err(SensorPictureError::NotANumber { name, found });
    }
    for (name, points) in [
        ("a corner of the measured polygon", picture.map.contour_m.as_slice()),
        ("a corner of the simulated polygon", picture.simulated_m),
    ] {
        if let Some(found) = points.iter().flatten().find(|number| !number.is_finite()) {
            return Err(SensorPictureError::NotANumber { name, found: *found });
        }
    }
    Ok(())
}

/// Everything that is drawn, with a margin.
fn bounds(picture: &SensorPicture) -> [[f64; 2]; 2] {
    let places: Vec<[f64; 2]> =
        picture.map.nodes.iter().map(rsrs_core::trials::fit::SensorPoint::place_m).collect();
    let radius_m = picture.radius_m;
    let body = [[-radius_m, -radius_m], [radius_m, radius_m]];
    let all =
        || places.iter().chain(&picture.map.contour_m).chain(picture.simulated_m).chain(&body);
    [0, 1].map(|axis| {
        let [low, high] = ends(all().map(|point| point[axis]));
        let spare = 0.04 * (high - low);
        [low - spare, high + spare]
    })
}

fn robot(chart: &Chart, radius_m: f64) -> Element {
    let (x_px, y_px) = (chart.x_px(0.0), chart.y_px(0.0));
    let radius_px = chart.x_px(radius_m) - x_px;
    let body = Element::circle((x_px, y_px), radius_px).with("fill", "#ffffff");
    let heading =
        Element::path(&format!("M{} {}h{}", number(x_px), number(y_px), number(1.3 * radius_px)));
    Element::new("g").stroked(INK, 1.4).child(body).child(heading)
}

fn nodes(chart: &Chart, map: &SensorMap) -> Element {
    let nodes = map.nodes.iter().map(|node| {
        let [x_m, y_m] = node.place_m();
        let rate = node.rate;
        let tooltip = format!(
            "{:.2} m, {:.2} rad\n{} of {} readings, {:.2} to {:.2}",
            node.distance_m, node.bearing_rad, rate.detections, rate.samples, rate.low, rate.high
        );
        node_mark(chart.x_px(x_m), chart.y_px(y_m), rate.value).titled(&tooltip)
    });
    Element::new("g").children(nodes)
}

fn node_mark(x_px: f64, y_px: f64, share: f64) -> Element {
    Element::circle((x_px, y_px), 3.6).filled(INK, &number(share.clamp(0.0, 1.0))).stroked(INK, 0.7)
}
