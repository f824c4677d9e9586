//! Where the robots start: the picture that lies on the floor beside them.

use rsrs_core::unicycle::Pose;

use crate::floor::{CAPTION_PX, Field, MARGIN_PX, PAGE_PX, robot, scale_bar};
use crate::header::header;
use crate::palette::{INK, QUIET_INK};
use crate::svg::{Element, line_of_text, number};

/// Start poses and what to say about them.
#[derive(Clone, Debug)]
pub struct PlacementPicture<'a> {
    /// Names and poses; the centre of the disc is the origin.
    pub robots: &'a [(String, Pose)],
    /// Radius of the disc of the robots' centres, in metres; positive.
    pub disc_m: f64,
    /// Radius of a robot's body, in metres; positive.
    pub radius_m: f64,
    /// The title; any text.
    pub title: String,
    /// Under the title; any text.
    pub subtitle: String,
}

/// Draws where the robots start: the disc, its centre with the axes, and every robot by its name.
///
/// # Returns
///
/// A self-contained SVG document; the same text on every machine.
///
/// # Panics
///
/// If a pose or a length is not finite; the simulator places no such robot.
pub fn svg(picture: &PlacementPicture) -> String {
    let numbers = picture.robots.iter().flat_map(|(_, pose)| [pose.x_m, pose.y_m]);
    assert!(
        numbers.chain([picture.disc_m, picture.radius_m]).all(f64::is_finite),
        "a placement is made of finite numbers"
    );
    let room_px = PAGE_PX - 2.0 * MARGIN_PX;
    let (header, header_px) =
        header(&picture.title, std::slice::from_ref(&picture.subtitle), MARGIN_PX, room_px);
    let corner = |sign: f64| Pose {
        x_m: sign * picture.disc_m,
        y_m: sign * picture.disc_m,
        heading_rad: 0.0,
    };
    let field = Field::around(&[corner(-1.0), corner(1.0)], picture.radius_m, header_px + 10.0);
    let bodies = picture.robots.iter().map(|(_, pose)| robot(&field, *pose, picture.radius_m));
    let names = picture.robots.iter().map(|(name, pose)| name_of(&field, name, *pose));
    let bottom_px = field.top_px + field.height_px + 28.0;
    let caption = "dashed: disc that holds the centres; cross: origin";
    let page = Element::picture(PAGE_PX, bottom_px + 16.0, &picture.title)
        .children(header)
        .child(disc(&field, picture.disc_m))
        .children(axes(&field, picture.disc_m))
        .children(bodies)
        .children(names)
        .children(scale_bar(&field, bottom_px))
        .child(small(MARGIN_PX, bottom_px, caption).with("fill", QUIET_INK));
    format!("{page}\n")
}

fn small(x_px: f64, y_px: f64, text: &str) -> Element {
    line_of_text(x_px, y_px, text).at("font-size", CAPTION_PX)
}

fn disc(field: &Field, disc_m: f64) -> Element {
    let (x_px, y_px) = field.point(0.0, 0.0);
    Element::new("circle")
        .at("cx", x_px)
        .at("cy", y_px)
        .at("r", disc_m * field.px_per_m)
        .with("fill", "none")
        .with("stroke", QUIET_INK)
        .at("stroke-width", 1.2)
        .with("stroke-dasharray", "7 4")
}

/// Short arrows for x and y at the origin.
fn axes(field: &Field, disc_m: f64) -> [Element; 3] {
    let (x_px, y_px) = field.point(0.0, 0.0);
    let length_px = 0.12 * disc_m * field.px_per_m;
    let (x, y) = (number(x_px), number(y_px));
    let (left, right) = (number(x_px - length_px / 2.0), number(x_px + length_px));
    let (upper, lower) = (number(y_px - length_px), number(y_px + length_px / 2.0));
    let cross = Element::new("path")
        .with("d", &format!("M{left} {y}H{right}M{x} {lower}V{upper}"))
        .with("fill", "none")
        .with("stroke", QUIET_INK)
        .at("stroke-width", 1.2);
    let named = |x_px, y_px, text| small(x_px, y_px, text).with("fill", QUIET_INK);
    [
        cross,
        named(x_px + length_px + 3.0, y_px + 4.0, "x"),
        named(x_px - 3.0, y_px - length_px - 4.0, "y"),
    ]
}

/// The name on the body.
fn name_of(field: &Field, name: &str, pose: Pose) -> Element {
    let (x_px, y_px) = field.point(pose.x_m, pose.y_m);
    small(x_px, y_px + CAPTION_PX / 3.0, short(name))
        .with("text-anchor", "middle")
        .with("fill", INK)
        .with("stroke", "#ffffff")
        .at("stroke-width", 3.0)
        .with("paint-order", "stroke")
}

/// `3` of `robot_3`: what is written on a robot's lid. Names without a number stay whole.
fn short(name: &str) -> &str {
    match name.rsplit_once('_') {
        Some((_, number)) if number.bytes().all(|byte| byte.is_ascii_digit()) => number,
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(robots: &[(String, Pose)]) -> String {
        svg(&PlacementPicture {
            robots,
            disc_m: 0.8,
            radius_m: 0.075,
            title: "Start".to_owned(),
            subtitle: "2 robots".to_owned(),
        })
    }

    #[test]
    fn every_robot_is_drawn_with_its_name() {
        let at = |x_m, name: &str| (name.to_owned(), Pose { x_m, y_m: 0.0, heading_rad: 0.0 });

        let svg = picture(&[at(-0.5, "robot_17"), at(0.5, "zebra")]);

        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains(">17<") && svg.contains(">zebra<"), "{svg}");
    }

    #[test]
    fn up_on_the_floor_is_up_on_the_page() {
        let at = |y_m| ("robot_1".to_owned(), Pose { x_m: 0.0, y_m, heading_rad: 0.0 });
        let height = |svg: &str| {
            let last = svg.rfind("cy=\"").expect("a body is drawn") + 4;
            let end = last + svg[last..].find('"').expect("attributes end");
            svg[last..end].parse::<f64>().expect("a number")
        };

        assert!(height(&picture(&[at(0.5)])) < height(&picture(&[at(-0.5)])));
    }
}
