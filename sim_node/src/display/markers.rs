//! A scene as markers: one marker for all bodies, one for all headings, and so on, because a viewer
//! draws five things with many points faster than many things.

use std::f64::consts::TAU;

use rsrs_core::judge::order;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::{Goal, ObjectGroup};
use rsrs_msgs::geometry_msgs::{Point, Vector3};
use rsrs_msgs::std_msgs::ColorRGBA;
use rsrs_msgs::visualization_msgs::{Marker, MarkerArray};

use super::scene::{Scene, SensorLook, seen_from};

const BODY: ColorRGBA = color(0.20, 0.45, 0.70, 1.0);
/// Robots that the simulator only follows.
const REAL_BODY: ColorRGBA = color(0.45, 0.45, 0.45, 1.0);
const HEADING: ColorRGBA = color(1.0, 1.0, 1.0, 1.0);
const BLIND: ColorRGBA = color(0.60, 0.60, 0.60, 0.5);
const SEEING: ColorRGBA = color(0.90, 0.45, 0.10, 1.0);
const RING: ColorRGBA = color(0.25, 0.65, 0.30, 0.8);
const OBJECT: ColorRGBA = color(0.90, 0.62, 0.0, 1.0);
const GOAL: ColorRGBA = color(0.0, 0.62, 0.45, 0.8);
const WALL: ColorRGBA = color(0.54, 0.43, 0.29, 1.0);
const TEXT: ColorRGBA = color(0.90, 0.90, 0.90, 1.0);

/// Width of lines, in metres.
const LINE_M: f64 = 0.01;
/// Height of the text, in metres.
const TEXT_M: f64 = 0.15;
/// Sides of the polygons that stand for the ring and for goals.
const N_RING: u32 = 48;

const fn color(r: f32, g: f32, b: f32, a: f32) -> ColorRGBA {
    ColorRGBA { r, g, b, a }
}

/// Everything of a scene.
pub fn markers(scene: &Scene) -> MarkerArray {
    let mut markers =
        vec![bodies(scene), headings(scene), sensors(scene), ring(scene), text(scene)];
    markers.extend(objects(scene));
    markers.extend(goals(scene));
    markers.extend(walls(scene));
    MarkerArray { markers }
}

/// Removes everything that was shown.
pub fn nothing() -> MarkerArray {
    MarkerArray { markers: vec![Marker { action: Marker::DELETEALL, ..Marker::default() }] }
}

fn marker(scene: &Scene, namespace: &str, kind: i32) -> Marker {
    Marker {
        header: scene.header(),
        ns: namespace.to_owned(),
        r#type: kind,
        action: Marker::ADD,
        scale: Vector3 { x: LINE_M, y: 0.0, z: 0.0 },
        ..Marker::default()
    }
}

fn bodies(scene: &Scene) -> Marker {
    let diameter_m = 2.0 * scene.look.radius_m;
    let color = |is_ours: &bool| if *is_ours { BODY } else { REAL_BODY };
    Marker {
        scale: Vector3 { x: diameter_m, y: diameter_m, z: diameter_m / 2.0 },
        points: scene.poses.iter().map(|pose| seen_from(pose, [0.0, 0.0])).collect(),
        colors: scene.is_ours.iter().map(color).collect(),
        ..marker(scene, "bodies", Marker::SPHERE_LIST)
    }
}

/// A line from each centre to the front of the body, on top of it.
fn headings(scene: &Scene) -> Marker {
    let above = |point: Point| Point { z: scene.look.radius_m, ..point };
    let line = |pose: &Pose| {
        [[0.0, 0.0], [scene.look.radius_m, 0.0]].map(|point| above(seen_from(pose, point)))
    };
    Marker {
        color: HEADING,
        points: scene.poses.iter().flat_map(line).collect(),
        ..marker(scene, "headings", Marker::LINE_LIST)
    }
}

/// The outline of each sensing region, coloured by what the sensor reports.
fn sensors(scene: &Scene) -> Marker {
    let (mut points, mut colors) = (Vec::new(), Vec::new());
    for (robot, (pose, readings)) in scene.poses.iter().zip(&scene.readings).enumerate() {
        for SensorLook { corners_m, readings: own } in scene.look.sensors_of(robot) {
            let detects = own.clone().any(|reading| readings.has(reading));
            let color = if detects { SEEING } else { BLIND };
            for (side, corner) in corners_m.iter().enumerate() {
                let next = corners_m[(side + 1) % corners_m.len()];
                points.extend([*corner, next].map(|corner| seen_from(pose, corner)));
                colors.extend([color; 2]);
            }
        }
    }
    Marker { points, colors, ..marker(scene, "sensors", Marker::LINE_LIST) }
}

/// The objects, a marker for each group of them, because all points of a marker are of one size.
fn objects(scene: &Scene) -> Vec<Marker> {
    let mut places = scene.objects_m.iter();
    let groups = (0..).zip(&scene.look.world.objects);
    let group = |(id, group): (i32, &ObjectGroup)| {
        let diameter_m = 2.0 * group.radius_m;
        let points = places.by_ref().take(group.n_objects());
        Marker {
            id,
            color: OBJECT,
            scale: Vector3 { x: diameter_m, y: diameter_m, z: diameter_m / 2.0 },
            points: points.map(|[x, y]| Point { x: *x, y: *y, z: 0.0 }).collect(),
            ..marker(scene, "objects", Marker::SPHERE_LIST)
        }
    };
    groups.map(group).collect()
}

/// The outlines of the goals, if there are some.
fn goals(scene: &Scene) -> Option<Marker> {
    let goals = &scene.look.world.goals;
    let outline = |goal: &Goal| {
        let [x, y] = goal.place_m;
        let on_it = circle(Point { x, y, z: 0.0 }, goal.radius_m);
        let sides: Vec<[Point; 2]> = on_it.windows(2).map(|side| [side[0], side[1]]).collect();
        sides.into_iter().flatten()
    };
    (!goals.is_empty()).then(|| Marker {
        color: GOAL,
        points: goals.iter().flat_map(outline).collect(),
        ..marker(scene, "goals", Marker::LINE_LIST)
    })
}

/// The walls of an arena that is no plain square, and of its obstacles, if there are some.
fn walls(scene: &Scene) -> Option<Marker> {
    let walls_m = &scene.look.walls_m;
    let side = |corners_m: &Vec<[f64; 2]>| {
        let next = corners_m.iter().cycle().skip(1);
        let sides = corners_m.iter().zip(next).flat_map(|(from, to)| [*from, *to]);
        sides.map(|[x, y]| Point { x, y, z: 0.0 }).collect::<Vec<Point>>()
    };
    (!walls_m.is_empty()).then(|| Marker {
        color: WALL,
        points: walls_m.iter().flat_map(side).collect(),
        ..marker(scene, "walls", Marker::LINE_LIST)
    })
}

/// Points around a circle, the first of which is the last one, too.
fn circle(centre: Point, radius_m: f64) -> Vec<Point> {
    let on_it = |point| {
        let (sine, cosine) = libm::sincos(TAU * f64::from(point) / f64::from(N_RING));
        Point { x: centre.x + radius_m * cosine, y: centre.y + radius_m * sine, z: 0.0 }
    };
    (0..=N_RING).map(on_it).collect()
}

/// The circle around the centroid whose radius is the robots' mean distance from it.
fn ring(scene: &Scene) -> Marker {
    let (centre, radius_m) = fit(&scene.poses);
    Marker {
        color: RING,
        points: circle(centre, radius_m),
        ..marker(scene, "ring", Marker::LINE_STRIP)
    }
}

/// What is written, just outside the ring.
fn text(scene: &Scene) -> Marker {
    let (centre, radius_m) = fit(&scene.poses);
    let mut text = Marker {
        color: TEXT,
        scale: Vector3 { x: 0.0, y: 0.0, z: TEXT_M },
        text: scene.text.clone(),
        ..marker(scene, "label", Marker::TEXT_VIEW_FACING)
    };
    let above_m = radius_m + 4.0 * scene.look.radius_m + TEXT_M;
    text.pose.position = Point { y: centre.y + above_m, ..centre };
    text
}

/// Centroid of all robots, and their mean distance from it.
fn fit(poses: &[Pose]) -> (Point, f64) {
    let n_robots = poses.len() as f64;
    let mean = |coordinate: fn(&Pose) -> f64| poses.iter().map(coordinate).sum::<f64>() / n_robots;
    let centre = Point { x: mean(|pose| pose.x_m), y: mean(|pose| pose.y_m), z: 0.0 };
    (centre, order::mean_radius_m(poses))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rsrs_core::conditions::Walls;
    use rsrs_core::robot::region::Region;
    use rsrs_core::robot::sensor::Readings;
    use rsrs_core::world::WorldFile;
    use rsrs_msgs::builtin_interfaces::Time;
    use rsrs_testing::conditions::measured_flockbots;

    use super::super::Look;
    use super::*;
    use crate::display::tests::pushing;

    fn look(region: Option<Region>) -> Look {
        let mut conditions = measured_flockbots(4);
        if let Some(region) = region {
            conditions.robot.region = region;
        }
        Look::new(&conditions)
    }

    /// Four robots on a ring of 1 m around (5, -3), the second of which sees something.
    fn scene(look: Look) -> Scene {
        let pose = |robot: u32| {
            let (sine, cosine) = libm::sincos(TAU * f64::from(robot) / 4.0);
            Pose { x_m: 5.0 + cosine, y_m: sine - 3.0, heading_rad: f64::from(robot) }
        };
        Scene {
            stamp: Time::from_nanos(7),
            names: ["a", "b", "c", "d"].map(str::to_owned).into(),
            is_ours: [true, true, true, false].into(),
            poses: (0..4).map(pose).collect(),
            objects_m: Vec::new(),
            readings: [false, true, false, false].map(Readings::from).to_vec(),
            look: Arc::new(look),
            text: "stable milling".to_owned(),
        }
    }

    fn named<'a>(array: &'a MarkerArray, namespace: &str) -> &'a Marker {
        array.markers.iter().find(|marker| marker.ns == namespace).unwrap()
    }

    #[test]
    fn the_ring_goes_through_robots_that_stand_on_one() {
        let array = markers(&scene(look(None)));

        for point in &named(&array, "ring").points {
            let distance_m = libm::hypot(point.x - 5.0, point.y + 3.0);
            assert!((distance_m - 1.0).abs() < 1e-12, "{point:?}");
        }
        let label = named(&array, "label");
        assert_eq!(label.text, "stable milling");
        assert!(label.pose.position.y > -2.0, "it is written outside the ring");
    }

    #[test]
    fn a_sensor_reaches_as_far_as_its_region_and_shows_what_it_reports() {
        let square = vec![[0.1, -0.2], [0.5, -0.2], [0.5, 0.2], [0.1, 0.2]];
        let cone = Region::Cone { half_angle_rad: 0.2, range_m: 0.75 };
        for (region, reach_m) in
            [(cone, 0.75), (Region::Polygon { corners_m: square }, libm::hypot(0.5, 0.2))]
        {
            let scene = scene(look(Some(region)));

            let sensors = markers(&scene).markers.swap_remove(2);

            assert_eq!((sensors.ns.as_str(), sensors.r#type), ("sensors", Marker::LINE_LIST));
            assert_eq!(sensors.points.len(), sensors.colors.len());
            let each = sensors.points.len() / 4;
            for (robot, points) in sensors.points.chunks(each).enumerate() {
                let pose = scene.poses[robot];
                let distance_m =
                    |point: &Point| libm::hypot(point.x - pose.x_m, point.y - pose.y_m);
                let farthest_m = points.iter().map(distance_m).fold(0.0, f64::max);
                assert!((farthest_m - reach_m).abs() < 1e-12, "{farthest_m} m");
                let color = if robot == 1 { SEEING } else { BLIND };
                assert_eq!(sensors.colors[robot * each..][..each], vec![color; each]);
            }
        }
    }

    #[test]
    fn each_robot_has_a_body_and_a_heading_and_each_one_of_ours_a_frame() {
        let scene = scene(look(None));
        let array = markers(&scene);

        let bodies = named(&array, "bodies");
        assert_eq!((bodies.points.len(), bodies.colors[0], bodies.colors[3]), (4, BODY, REAL_BODY));
        let headings = &named(&array, "headings").points;
        let (from, to) = (headings[4], headings[5]);
        let heading_rad = libm::atan2(to.y - from.y, to.x - from.x);
        assert!((heading_rad - 2.0).abs() < 1e-9, "{heading_rad}");
        let frames = scene.frames().transforms;
        let children: Vec<_> = frames.iter().map(|frame| frame.child_frame_id.as_str()).collect();
        assert_eq!(children, ["a/base_link", "b/base_link", "c/base_link"]);
        assert!(frames.iter().all(|frame| frame.header.frame_id == "map"));
        for marker in &array.markers {
            assert_eq!((marker.header.frame_id.as_str(), marker.header.stamp.nanosec), ("map", 7));
        }
    }

    #[test]
    fn walls_of_an_arena_that_is_no_plain_square_are_lines_around_it_and_around_obstacles() {
        let mut conditions = pushing("last_s: 10");
        let text = "
arena: {rectangle_m: [6, 4]}
obstacles: [{place_m: [1, -1], radius_m: 0.2}, {polygon_m: [[0, 0], [1, 0], [0, 1]]}]
";
        conditions.world = WorldFile::parse("world.yaml", text, &[], &[]).unwrap();

        let array = markers(&scene(Look::new(&conditions)));

        let points = &named(&array, "walls").points;
        assert_eq!(points.len(), 2 * (4 + 96 + 3));
        let is_from_to = |side: usize, ends: [[f64; 2]; 2]| {
            let there = points[2 * side..].iter().zip(ends);
            there.map(|(it, [x, y])| libm::hypot(it.x - x, it.y - y)).all(|away_m| away_m < 1e-12)
        };
        assert!(is_from_to(0, [[-3.0, -2.0], [3.0, -2.0]]));
        assert!(is_from_to(3, [[-3.0, 2.0], [-3.0, -2.0]]));
        assert!(is_from_to(102, [[0.0, 1.0], [0.0, 0.0]]));
        for point in &points[8..8 + 192] {
            let distance_m = libm::hypot(point.x - 1.0, point.y + 1.0);
            assert!((distance_m - 0.2).abs() < 1e-12, "{point:?}");
        }
        conditions.arena.walls = Walls::None;
        conditions.world.obstacles.clear();
        let array = markers(&scene(Look::new(&conditions)));
        assert!(array.markers.iter().all(|marker| marker.ns != "walls"), "there are none");
    }

    #[test]
    fn objects_and_goals_are_where_they_are_and_as_large_as_they_are() {
        let conditions = pushing("last_s: 10");
        let objects_m = vec![[0.1, 0.2], [0.3, 0.4], [-1.0, 0.5]];
        let scene = Scene { objects_m, ..scene(Look::new(&conditions)) };

        let array = markers(&scene);

        let objects: Vec<&Marker> =
            array.markers.iter().filter(|marker| marker.ns == "objects").collect();
        let found: Vec<(i32, f64, usize)> =
            objects.iter().map(|marker| (marker.id, marker.scale.x, marker.points.len())).collect();
        assert_eq!(found, [(0, 0.2, 2), (1, 0.5, 1)]);
        let last = objects[1].points[0];
        assert_eq!([last.x, last.y].map(f64::to_bits), [-1.0, 0.5].map(f64::to_bits));
        let goals = named(&array, "goals");
        assert_eq!(goals.points.len(), 2 * N_RING as usize);
        for point in &goals.points {
            let distance_m = libm::hypot(point.x - 0.6, point.y + 0.6);
            assert!((distance_m - 0.3).abs() < 1e-12, "{point:?}");
        }
        assert!(array.markers.iter().all(|marker| marker.ns != "walls"), "a square has none");
        let plain = markers(&self::scene(look(None)));
        assert_eq!(plain.markers.len(), 5, "where there are none, there is no marker of them");
    }
}
