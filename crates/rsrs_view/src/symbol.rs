//! A symbol per phase, so that a mark can be read without its colour.

use rsrs_core::judge::phase::Phase;

use crate::palette::{INK, hue};
use crate::svg::{Element, number, through};

/// Radius of a real run's symbol where there is room, in pixels.
pub const MARK_PX: f64 = 5.5;

/// How a symbol is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// Of a run whose label is settled.
    Full,
    /// White in its middle, of one whose label is near another one.
    Hollow,
}

/// The mark of a real run: the phase's symbol in its hue, with a white rim, around `at_px` and
/// about twice `radius_px` wide.
pub fn mark(phase: Phase, filling: Filling, (at_px, radius_px): ((f64, f64), f64)) -> Element {
    let hollow = (filling == Filling::Hollow).then(|| {
        let inner = path(phase, at_px, 0.55 * radius_px);
        Element::path(&inner).with("fill", "#ffffff")
    });
    let path = path(phase, at_px, radius_px);
    let thin = (radius_px / MARK_PX).min(1.0);
    let outline = |stroke: &str, width_px: f64| {
        Element::path(&path)
            .with("fill", &hue(phase).hex())
            .stroked(stroke, thin * width_px)
            .with("stroke-linejoin", "round")
    };
    let whole = Element::new("g").fixed().child(outline("#ffffff", 4.0)).child(outline(INK, 1.3));
    whole.children(hollow)
}

/// Circle, diamond, square, triangle, cross: in the order of a behaviour's phases.
fn path(phase: Phase, (x_px, y_px): (f64, f64), radius_px: f64) -> String {
    let polygon = |corners: &[(f64, f64)]| {
        let corner = |(dx, dy): &(f64, f64)| (x_px + dx * radius_px, y_px + dy * radius_px);
        format!("{}Z", through(corners.iter().map(corner)))
    };
    match phase.place() {
        0 => {
            let radius = number(radius_px);
            let (left, right) = (number(x_px - radius_px), number(x_px + radius_px));
            let y = number(y_px);
            format!(
                "M{left} {y}A{radius} {radius} 0 1 1 {right} {y}A{radius} {radius} 0 1 1 {left} {y}Z"
            )
        }
        1 => polygon(&[(0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)]),
        2 => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
        3 => polygon(&[(0.0, -1.15), (1.15, 0.85), (-1.15, 0.85)]),
        _ => {
            let arm = 0.35;
            polygon(&[
                (0.0, -arm),
                (0.75, -0.75 - arm),
                (0.75 + arm, -0.75),
                (arm, 0.0),
                (0.75 + arm, 0.75),
                (0.75, 0.75 + arm),
                (0.0, arm),
                (-0.75, 0.75 + arm),
                (-0.75 - arm, 0.75),
                (-arm, 0.0),
                (-0.75 - arm, -0.75),
                (-0.75, -0.75 - arm),
            ])
        }
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::judge::behaviour::Behaviour;

    use super::*;

    #[test]
    fn every_phase_has_a_shape_of_its_own() {
        for behaviour in Behaviour::BUILT_IN {
            let phases = behaviour.phases();
            let mut paths: Vec<_> =
                phases.iter().map(|phase| path(*phase, (0.0, 0.0), 5.0)).collect();
            paths.sort();
            paths.dedup();

            assert_eq!(paths.len(), phases.len());
        }
    }
}
