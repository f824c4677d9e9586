//! Where the robots start: the picture that lies on the floor beside them.

use rsrs_core::conditions::Sides;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;

use crate::floor::{
    CAPTION_PX, Field, PAGE_PX, robot, round_length, scale_bar, short, tags, things, walls,
};
use crate::header::{MARGIN_PX, header};
use crate::palette::{INK, QUIET_INK};
use crate::scale::labels;
use crate::svg::{Element, line_of_text, number, rectangle};
use crate::theme::Theme;

/// Colour of the grid.
const GRID: &str = "#dde3e8";
/// From one robot to the next in the table, in pixels.
const ROW_PX: f64 = 15.0;
/// From the end of an axis to the middle of its letter, and around that, in pixels.
const LETTER_PX: f64 = 7.0;

/// Start poses and the text about them.
#[derive(Clone, Debug)]
pub struct PlacementPicture<'a> {
    /// Names and poses; the centre of the disc is the origin.
    pub robots: &'a [(String, Pose)],
    /// Where the robots' centres may lie, around the origin.
    pub area: Area,
    /// Radius of a robot's body, in metres; positive.
    pub radius_m: f64,
    /// Names and places of objects, in metres.
    pub objects: &'a [(String, [f64; 2])],
    /// What is there besides robots.
    pub world: &'a WorldFile,
    /// Distance of the walls of a square from the origin, in metres, where there are walls.
    pub walls_m: Option<f64>,
    /// Where it is looked at.
    pub theme: Theme,
    /// The title; any text.
    pub title: String,
    /// Under the title; any text.
    pub subtitle: String,
}

/// Where the centres of robots may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Area {
    /// In a disc around the origin; its radius in metres, positive.
    Disc {
        /// In metres.
        radius_m: f64,
    },
    /// In a box around the origin; its sides along x and y in metres, positive.
    Box(Sides),
    /// Where a table puts them: nothing is drawn around them.
    Table {
        /// Distance of the farthest centre from the origin, in metres.
        reach_m: f64,
    },
}

impl Area {
    /// Half of what it takes along x and y, in metres.
    fn half_extents_m(self) -> (f64, f64) {
        match self {
            Self::Disc { radius_m } => (radius_m, radius_m),
            Self::Box(Sides { width_m, height_m }) => (width_m / 2.0, height_m / 2.0),
            Self::Table { reach_m } => (reach_m, reach_m),
        }
    }

    fn caption(self) -> &'static str {
        match self {
            Self::Disc { .. } => "dashed: disc that holds the centres; cross: origin",
            Self::Box(_) => "dashed: box that holds the centres; cross: origin",
            Self::Table { .. } => "cross: origin",
        }
    }

    /// Its border, where it has one.
    fn border(self, field: &Field) -> Option<Element> {
        let (x_px, y_px) = field.point(0.0, 0.0);
        let outline = match self {
            Self::Disc { radius_m } => Element::circle((x_px, y_px), radius_m * field.px_per_m),
            Self::Box(Sides { width_m, height_m }) => {
                let (wide_px, high_px) = (width_m * field.px_per_m, height_m * field.px_per_m);
                rectangle(x_px - wide_px / 2.0, y_px - high_px / 2.0, wide_px, high_px)
            }
            Self::Table { .. } => return None,
        };
        Some(outline.outlined(QUIET_INK, 1.2).with("stroke-dasharray", "7 4"))
    }
}

impl PlacementPicture<'_> {
    /// Half of what it takes along x and y, in metres.
    fn half_extents_m(&self) -> (f64, f64) {
        let wider = |(half_x_m, half_y_m): (f64, f64), (radius_m, [x_m, y_m]): (f64, [f64; 2])| {
            (half_x_m.max(x_m.abs() + radius_m), half_y_m.max(y_m.abs() + radius_m))
        };
        let radii_m = self.world.each_object().map(|object| object.radius_m);
        let objects = radii_m.zip(self.objects.iter().map(|(_, place_m)| *place_m));
        objects.fold(self.area.half_extents_m(), wider)
    }
}

/// Draws where the robots start: their area, the origin with the axes, and every robot by its name.
/// The SVG document is self-contained, and the same text on every machine.
///
/// # Panics
///
/// If a pose or a length is not finite; the simulator places no such robot.
pub fn svg(picture: &PlacementPicture) -> String {
    let numbers = picture.robots.iter().flat_map(|(_, pose)| [pose.x_m, pose.y_m]);
    let objects_m: Vec<[f64; 2]> = picture.objects.iter().map(|(_, place_m)| *place_m).collect();
    let (half_x_m, half_y_m) = picture.half_extents_m();
    assert!(
        numbers.chain([half_x_m, half_y_m, picture.radius_m]).all(f64::is_finite),
        "a placement is made of finite numbers"
    );
    let room_px = PAGE_PX - 2.0 * MARGIN_PX;
    let (header, header_px) =
        header(picture.theme, &picture.title, &[&picture.subtitle], MARGIN_PX, room_px);
    let corners_m = [-1.0, 1.0].map(|sign| (sign * half_x_m, sign * half_y_m));
    let field = Field::around(corners_m.into_iter(), picture.radius_m, header_px + 10.0);
    let bodies =
        picture.robots.iter().map(|(_, pose)| robot(&field, *pose, picture.radius_m, (INK, None)));
    let short: Vec<String> =
        picture.robots.iter().map(|(name, _)| short(name).to_owned()).collect();
    let poses: Vec<Pose> = picture.robots.iter().map(|(_, pose)| *pose).collect();
    let names = tags(&field, &poses, &short, picture.radius_m);
    let objects = picture.objects.iter().map(|(_, [x_m, y_m])| Pose {
        x_m: *x_m,
        y_m: *y_m,
        heading_rad: 0.0,
    });
    let numbers: Vec<String> =
        picture.objects.iter().map(|(name, _)| self::short(name).to_owned()).collect();
    let least_m = picture.world.each_object().map(|it| it.radius_m).fold(f64::INFINITY, f64::min);
    let of_objects = tags(&field, &objects.collect::<Vec<Pose>>(), &numbers, least_m);
    let bottom_px = field.top_px + field.height_px + 28.0;
    let (table, end_px) = table(picture, bottom_px + 12.0);
    let page = Element::picture(PAGE_PX, end_px + 10.0, &picture.title)
        .described(&picture.theme.description([picture.subtitle.as_str()], ""))
        .children(header)
        .children(grid(&field, (half_x_m, half_y_m)))
        .children(walls(&field, picture.walls_m, Some(picture.world)))
        .children(picture.area.border(&field))
        .children(things(&field, picture.world, &objects_m))
        .children(axes(&field, half_x_m.min(half_y_m), picture))
        .children(bodies)
        .children(names)
        .children(of_objects)
        .children(scale_bar(&field, bottom_px))
        .child(small(MARGIN_PX, bottom_px, picture.area.caption()).with("fill", QUIET_INK))
        .children(table);
    format!("{page}\n")
}

fn small(x_px: f64, y_px: f64, text: &str) -> Element {
    line_of_text(x_px, y_px, text).at("font-size", CAPTION_PX)
}

/// Lines at round distances from the origin, as they would be taped onto the floor, with their numbers at
/// the left and at the top.
fn grid(field: &Field, (half_x_m, half_y_m): (f64, f64)) -> Vec<Element> {
    let step_m = round_length(half_x_m.max(half_y_m) / 3.0);
    let n = |half_m: f64| (1..=20).take_while(|step| f64::from(*step) * step_m <= half_m).count();
    let places = |half_m: f64| -> Vec<f64> {
        let n = i32::try_from(n(half_m)).expect("at most 20");
        (-n..=n).filter(|step| *step != 0).map(|step| f64::from(step) * step_m).collect()
    };
    let (xs, ys) = (places(half_x_m), places(half_y_m));
    let (left_px, upper_px) = field.point(-half_x_m, half_y_m);
    let (right_px, lower_px) = field.point(half_x_m, -half_y_m);
    let mut path: Vec<String> = Vec::new();
    let mut texts = Vec::new();
    for (x_m, text) in xs.iter().zip(labels(&xs)) {
        let x_px = field.point(*x_m, 0.0).0;
        path.push(format!("M{} {}V{}", number(x_px), number(upper_px), number(lower_px)));
        let text = small(x_px, upper_px - 4.0, &text).with("text-anchor", "middle");
        texts.push(text.with("fill", QUIET_INK));
    }
    for (y_m, text) in ys.iter().zip(labels(&ys)) {
        let y_px = field.point(0.0, *y_m).1;
        path.push(format!("M{} {}H{}", number(left_px), number(y_px), number(right_px)));
        let text = small(left_px - 4.0, y_px + 4.0, &text).with("text-anchor", "end");
        texts.push(text.with("fill", QUIET_INK));
    }
    let lines = Element::path(&path.concat()).stroked(GRID, 0.8);
    std::iter::once(lines).chain(texts).collect()
}

/// Where each robot stands and heads, in two columns (what a person with a tape reads), and where
/// they end below, in pixels.
fn table(picture: &PlacementPicture, top_px: f64) -> (Vec<Element>, f64) {
    let place = |name: &str, x_m: f64, y_m: f64| {
        format!("{name}: x {:.2} m, y {:.2} m", x_m + 0.0, y_m + 0.0)
    };
    let robots = picture.robots.iter().map(|(name, pose)| {
        let degrees = pose.heading_rad.to_degrees() + 0.0;
        format!("{}, {degrees:.0}°", place(short(name), pose.x_m, pose.y_m))
    });
    let objects = picture.objects.iter().map(|(name, [x_m, y_m])| place(name, *x_m, *y_m));
    let lines: Vec<String> = robots.chain(objects).collect();
    let n_rows = lines.len().div_ceil(2);
    let column_px = (PAGE_PX - 2.0 * MARGIN_PX) / 2.0;
    let row = |(index, line): (usize, &String)| {
        let (column, row) = ((index / n_rows) as f64, (index % n_rows) as f64);
        let x_px = MARGIN_PX + column * column_px;
        let text = line.replace('-', "\u{2212}");
        small(x_px, top_px + (row + 1.0) * ROW_PX, &text).with("fill", INK)
    };
    let texts = lines.iter().enumerate().map(row).collect();
    (texts, top_px + n_rows as f64 * ROW_PX)
}

/// Arrows for x and y at the origin, short ones, or as long as it takes for their letters to lie beside all
/// robots.
fn axes(field: &Field, half_extent_m: f64, picture: &PlacementPicture) -> [Element; 3] {
    let (x_px, y_px) = field.point(0.0, 0.0);
    let free_px = picture.radius_m * field.px_per_m + LETTER_PX;
    let is_free = |letter: (f64, f64)| {
        picture.robots.iter().all(|(_, pose)| {
            let robot = field.point(pose.x_m, pose.y_m);
            libm::hypot(robot.0 - letter.0, robot.1 - letter.1) > free_px
        })
    };
    let short_px = 0.12 * half_extent_m * field.px_per_m;
    let length_px = |way: (f64, f64)| {
        let end = |length_px: &f64| {
            let away_px = length_px + LETTER_PX;
            is_free((x_px + way.0 * away_px, y_px + way.1 * away_px))
        };
        let mut lengths_px = (0..15).map(|step| short_px * (1.0 + 0.5 * f64::from(step)));
        lengths_px.find(end).unwrap_or(short_px)
    };
    let (right_px, up_px) = (length_px((1.0, 0.0)), length_px((0.0, -1.0)));
    let (x, y) = (number(x_px), number(y_px));
    let (left, right) = (number(x_px - short_px / 2.0), number(x_px + right_px));
    let (upper, lower) = (number(y_px - up_px), number(y_px + short_px / 2.0));
    let cross =
        Element::path(&format!("M{left} {y}H{right}M{x} {lower}V{upper}")).outlined(QUIET_INK, 1.2);
    let named = |x_px, y_px, text| small(x_px, y_px, text).with("fill", QUIET_INK);
    [
        cross,
        named(x_px + right_px + 3.0, y_px + 4.0, "x"),
        named(x_px - 3.0, y_px - up_px - 4.0, "y"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(robots: &[(String, Pose)]) -> String {
        picture_in(Area::Disc { radius_m: 0.8 }, robots)
    }

    fn picture_in(area: Area, robots: &[(String, Pose)]) -> String {
        svg(&PlacementPicture {
            robots,
            area,
            radius_m: 0.075,
            objects: &[],
            world: &WorldFile::NOTHING,
            walls_m: None,
            theme: Theme::Screen,
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

    #[test]
    fn the_letters_at_the_origin_lie_under_no_robot() {
        let at = |x_m, y_m| ("robot_1".to_owned(), Pose { x_m, y_m, heading_rad: 0.0 });
        let number = |svg: &str, before: &str, name: &str| -> f64 {
            let tag =
                &svg[svg[..svg.find(before).expect("it is there")].rfind('<').expect("a tag")..];
            let value =
                tag.split(&format!(" {name}=\"")).nth(1).and_then(|it| it.split('"').next());
            value.expect("it has that").parse().expect("a number")
        };
        let up_px = |svg: &str| number(svg, ">y<", "y");
        let robots = [at(0.0, 0.14)];

        let svg = picture(&robots);

        let above_px = up_px(&picture(&[at(0.5, -0.5)])) - up_px(&svg);
        let body = &svg[svg.rfind("<circle").expect("a body is drawn")..];
        let centre_px = number(body, ">", "cy");
        let radius_px = number(body, ">", "r");
        assert!(above_px > 0.0, "the arrow is longer");
        assert!(up_px(&svg) < centre_px - radius_px, "{svg}");
    }

    #[test]
    fn a_box_is_drawn_with_its_sides_and_a_table_has_no_border() {
        let robots = [("robot_1".to_owned(), Pose { x_m: 0.2, y_m: 0.0, heading_rad: 0.0 })];

        let in_box = picture_in(Area::Box(Sides { width_m: 2.0, height_m: 0.5 }), &robots);
        let in_table = picture_in(Area::Table { reach_m: 0.2 }, &robots);

        let side = |name: &str| -> f64 {
            let dashed = in_box.lines().find(|line| line.contains("stroke-dasharray"));
            let text = dashed.expect("the box has a border").split(&format!(" {name}=\"")).nth(1);
            text.and_then(|rest| rest.split('"').next()).expect("a side").parse().expect("a number")
        };
        assert!((side("width") / side("height") - 4.0).abs() < 0.01, "{in_box}");
        assert!(!in_table.contains("stroke-dasharray"), "{in_table}");
    }
}
