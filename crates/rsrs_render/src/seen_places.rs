//! Where robots are seen now, and whether they stand where they should start.

use std::fmt::Write;

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::TrackerFrame;
use rsrs_fleet::placement::{SeenPlaces, SeenRobot};

/// Where each robot is seen, and what is not as it should be.
pub fn text(seen: &SeenPlaces) -> String {
    let mut text = format!("poses: {}\n", source(seen));
    if let Some(frame) = &seen.tracker_frame {
        writeln!(text, "the tracker's frame: {}", frame_in_words(frame)).expect(ROOM);
    }
    let width = seen.robots.iter().map(|robot| robot.robot.len()).max().unwrap_or(0).max(5);
    write!(text, "\n{:width$}   x (m)   y (m)  heading (°)     Hz  seen", "robot").expect(ROOM);
    for robot in &seen.robots {
        text.push('\n');
        text.push_str(&row(robot, width));
    }
    text.push('\n');
    for line in seen.problems.iter().chain(&seen.deviations).chain(&seen.notes) {
        write!(text, "\n{line}").expect(ROOM);
    }
    if !seen.others.is_empty() {
        write!(text, "\nalso seen, and no robot of this run: {}", seen.others.join(", "))
            .expect(ROOM);
    }
    let n_unseen = seen.robots.iter().filter(|robot| robot.pose.is_none()).count();
    let n_robots = seen.robots.len();
    let verdict = if seen.is_as_wanted {
        format!("all {n_robots} robots stand where they should start")
    } else if n_unseen > 0 {
        format!("{n_unseen} of {n_robots} robots are not seen")
    } else {
        "the robots do not stand where they should start".to_owned()
    };
    write!(text, "\n{verdict}").expect(ROOM);
    text
}

/// Why writing to a text does not fail.
const ROOM: &str = "writing to a string succeeds";

fn source(seen: &SeenPlaces) -> String {
    let shown: Vec<&str> = seen.topics.iter().map(String::as_str).take(4).collect();
    let more = seen.topics.len().saturating_sub(shown.len());
    let more = if more > 0 { format!(" and {more} more topics") } else { String::new() };
    let PoseSource::Tf = seen.pose_source else {
        return format!("{} on {}{more}", seen.pose_source, shown.join(", "));
    };
    "transforms on /tf and /tf_static".to_owned()
}

fn frame_in_words(frame: &TrackerFrame) -> String {
    let TrackerFrame { offset_m: [x_m, y_m], rotation_rad, scale, axes } = frame;
    let degrees = rotation_rad.to_degrees();
    format!("axes {axes}, × {scale} m, turned by {degrees:.1}°, its origin at ({x_m}, {y_m}) m")
}

fn row(seen: &SeenRobot, width: usize) -> String {
    let SeenRobot { robot, body, pose, age_s, rate_hz, unusable, .. } = seen;
    let called = body.as_ref().map(|body| format!(" as `{body}`")).unwrap_or_default();
    let Some(pose) = pose else {
        let why = unusable.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
        return format!("{robot:width$}       -       -            -      -  not yet{called}{why}");
    };
    let rate = rate_hz.map_or_else(|| "-".to_owned(), |hz| format!("{hz:.1}"));
    let seen = match (unusable, age_s) {
        (Some(why), _) => format!("not now{called}: {why}"),
        (None, Some(age_s)) if *age_s > 1.0 => format!("{age_s:.0} s ago{called}"),
        (None, _) => format!("now{called}"),
    };
    let (x_m, y_m, heading_deg) = (pose.x_m, pose.y_m, pose.heading_rad.to_degrees());
    format!("{robot:width$}  {x_m:>6.3}  {y_m:>6.3}  {heading_deg:>11.0}  {rate:>5}  {seen}")
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::unicycle::Pose;

    use super::*;

    fn robot(name: &str, pose: Option<Pose>) -> SeenRobot {
        SeenRobot {
            robot: name.to_owned(),
            body: None,
            frame: pose.map(|_| "map".to_owned()),
            age_s: pose.map(|_| 0.02),
            rate_hz: pose.map(|_| 99.96),
            unusable: None,
            pose,
        }
    }

    #[test]
    fn a_person_reads_where_each_robot_is_seen_and_what_is_not_as_it_should_be() {
        let axes = ["x", "-z", "y"].map(str::to_owned);
        let frame = TrackerFrame {
            scale: 0.001,
            offset_m: [1.0, -2.0],
            rotation_rad: std::f64::consts::FRAC_PI_2,
            axes: axes.try_into().unwrap(),
        };
        let mut second = robot("robot_2", None);
        second.body = Some("RigidBody 7".to_owned());
        let seen = SeenPlaces {
            pose_source: PoseSource::NamedPoses,
            topics: vec!["/poses".to_owned()],
            tracker_frame: Some(frame),
            robots: vec![
                robot("robot_1", Some(Pose { x_m: 0.5, y_m: -0.25, heading_rad: 1.0 })),
                second,
            ],
            deviations: vec![
                "robot_1: heading 57°, expected -27°, away from the centre".to_owned(),
            ],
            problems: Vec::new(),
            notes: Vec::new(),
            others: vec!["wand".to_owned()],
            is_as_wanted: false,
            looked_for_s: 2.0,
        };

        insta::assert_snapshot!(text(&seen), @r"
        poses: named_poses on /poses
        the tracker's frame: axes [x, -z, y], × 0.001 m, turned by 90.0°, its origin at (1, -2) m

        robot     x (m)   y (m)  heading (°)     Hz  seen
        robot_1   0.500  -0.250           57  100.0  now
        robot_2       -       -            -      -  not yet as `RigidBody 7`

        robot_1: heading 57°, expected -27°, away from the centre
        also seen, and no robot of this run: wand
        1 of 2 robots are not seen
        ");
    }
}
