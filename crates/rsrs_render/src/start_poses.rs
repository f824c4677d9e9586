//! Where robots start, for people who put them there: as a table and as a picture.

use std::fmt::Write;

use rsrs_core::conditions::Placement;
use rsrs_core::conditions::operator::controller_values;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::Controller;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;
use rsrs_view::placement::{Area, PlacementPicture, svg};
use rsrs_view::theme::Theme;
use serde::Serialize;

/// Start poses.
#[derive(Debug, Serialize)]
pub struct StartPoses {
    /// Of the poses.
    pub seed: u64,
    /// Radius of the disc around the origin that holds the robots' centres, in metres.
    pub disc_radius_m: f64,
    /// Where they start: `disc_facing_out`, `box_facing_out`, `box_facing_any_way` or `file`.
    pub placement: &'static str,
    /// The same, with where the centres lie.
    #[serde(skip)]
    pub area: Placement,
    /// Least distance between two centres, in metres.
    pub clearance_m: f64,
    /// Radius of a robot's body, in metres.
    pub body_radius_m: f64,
    /// In the order of the fleet file.
    pub robots: Vec<StartPose>,
    /// What robots push, of a world that has some.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<StartPlace>,
    /// What is there besides robots.
    #[serde(skip)]
    pub world: WorldFile,
    /// Distance of the walls of a square from the centre, in metres, where there are walls.
    #[serde(skip)]
    pub walls_m: Option<f64>,
}

/// Where an object is at the start, from the centre.
#[derive(Debug, Serialize)]
pub struct StartPlace {
    /// Its name, as in its topic.
    pub object: String,
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
}

/// Where one robot starts, from the centre of the disc.
#[derive(Debug, Serialize)]
pub struct StartPose {
    /// Its name.
    pub robot: String,
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
    /// In (-π, π].
    pub heading_rad: f64,
    /// In (-180, 180].
    pub heading_deg: f64,
}

/// The poses as a table, and where objects are below it.
///
/// # Panics
///
/// Never: a text takes whatever is written to it.
pub fn text(starts: &StartPoses) -> String {
    let width = starts.robots.iter().map(|pose| pose.robot.len()).max().unwrap_or(0).max(5);
    let mut text = format!(
        "{} robots {}, centres at least {:.3} m apart, seed {}\n\
         x and y from the centre; heading counterclockwise from x\n\n\
         {:width$}   x (m)   y (m)  heading (°)  heading (rad)",
        starts.robots.len(),
        in_words(starts),
        starts.clearance_m,
        starts.seed,
        "robot",
    );
    for StartPose { robot, x_m, y_m, heading_rad, heading_deg } in &starts.robots {
        write!(
            text,
            "\n{robot:width$}  {x_m:>6.3}  {y_m:>6.3}  {heading_deg:>11.0}  {heading_rad:>13.3}"
        )
        .expect(ROOM);
    }
    let width = starts.objects.iter().map(|it| it.object.len()).max().unwrap_or(0);
    if width > 0 {
        write!(text, "\n\n{:width$}   x (m)   y (m)", "object").expect(ROOM);
    }
    for StartPlace { object, x_m, y_m } in &starts.objects {
        write!(text, "\n{object:width$}  {x_m:>6.3}  {y_m:>6.3}").expect(ROOM);
    }
    text
}

/// A run of a campaign whose robots are to be placed.
#[derive(Clone, Copy, Debug)]
pub struct RunToPlace<'a> {
    /// Name of the experiment.
    pub experiment: &'a str,
    /// What the robots will do.
    pub controller: &'a Controller,
    /// For how long, in seconds.
    pub duration_s: f64,
    /// Where they start.
    pub starts: &'a StartPoses,
}

/// Which run comes next, and where its robots are to be placed.
pub fn to_place(run: &RunToPlace<'_>) -> String {
    let setting = |(axis, value): (Axis, f64)| match axis {
        Axis::Number(number) => format!("{} {value}", number.name()),
        _ => format!("{value} {}", axis.unit()),
    };
    let settings: Vec<String> =
        controller_values(run.controller).into_iter().map(setting).collect();
    format!(
        "\n{}: {}, for {} s\nplace the robots:\n{}",
        run.experiment,
        settings.join(", "),
        run.duration_s,
        text(run.starts)
    )
}

/// Why writing to a text does not fail.
const ROOM: &str = "a text takes whatever is written to it";

/// The picture that lies on the floor beside the robots of an `experiment`, as SVG.
pub fn picture(starts: &StartPoses, experiment: &str, theme: Theme) -> String {
    let pose = |start: &StartPose| {
        let StartPose { x_m, y_m, heading_rad, .. } = *start;
        (start.robot.clone(), Pose { x_m, y_m, heading_rad })
    };
    let robots: Vec<(String, Pose)> = starts.robots.iter().map(pose).collect();
    let place = |it: &StartPlace| (it.object.clone(), [it.x_m, it.y_m]);
    let objects: Vec<(String, [f64; 2])> = starts.objects.iter().map(place).collect();
    svg(&PlacementPicture {
        robots: &robots,
        area: match &starts.area {
            Placement::BoxFacingOut(sides) | Placement::BoxFacingAnyWay(sides) => Area::Box(*sides),
            Placement::Given { .. } => Area::Table { reach_m: starts.disc_radius_m },
            _ => Area::Disc { radius_m: starts.disc_radius_m },
        },
        radius_m: starts.body_radius_m,
        objects: &objects,
        world: &starts.world,
        walls_m: starts.walls_m,
        title: format!("Start of {experiment}"),
        subtitle: format!("{} robots {}, seed {}", robots.len(), in_words(starts), starts.seed),
        theme,
    })
}

/// Where the centres lie, and which way the robots face.
fn in_words(starts: &StartPoses) -> String {
    match &starts.area {
        Placement::BoxFacingOut(sides) => {
            format!("in a box of {} m by {} m, facing out", sides.width_m, sides.height_m)
        }
        Placement::BoxFacingAnyWay(sides) => {
            format!("in a box of {} m by {} m, heading any way", sides.width_m, sides.height_m)
        }
        Placement::Given { .. } => "where the table puts them".to_owned(),
        _ => format!("in a disc of radius {} m, facing out", starts.disc_radius_m),
    }
}
