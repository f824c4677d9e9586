use rsrs_core::conditions::{Arena, Walls};
use rsrs_fleet::experiment::Time as TimeMode;
use rsrs_fleet::simulator::{Gates, Placed};
use rsrs_msgs::geometry_msgs;
use rsrs_msgs::simulation_interfaces::TagsFilter;
use rsrs_sim::controllers::Controllers;
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;
use rsrs_testing::conditions::measured_flockbots;

use super::*;
use crate::parameters::Wanted;
use crate::rows::Rows;

/// Three robots of ours at (0, 0), (1, 0) and (2, 0) in an arena of 6 m, and a real one.
fn placed_world() -> PlacedWorld {
    let mut conditions = measured_flockbots(4);
    conditions.arena = Arena { side_m: 6.0, walls: Walls::Stop };
    let seed = Seed { seed: 1, replicate: 0 };
    let mut world = World::new(&conditions, seed).unwrap();
    let controllers = Controllers::new(&conditions, seed);
    for robot in 0..3_u32 {
        let pose = Pose { x_m: f64::from(robot), y_m: 0.0, heading_rad: 0.0 };
        world.displace(robot as usize, pose);
    }
    let names = ["robot_1", "robot_2", "robot_3", "real"].map(str::to_owned);
    let rows = Rows::new(&names, &names[..3], 4).unwrap();
    let (time, gates) = (TimeMode::RealTime, Gates::Here);
    let robots = names[..3].to_vec();
    let placed = Placed { digest: 1, robots, steps: 1, period_ns: 1, time, gates };
    PlacedWorld::new(Wanted { world, controllers, placed, conditions, rows })
}

fn picked(filters: &EntityFilters) -> Result<Vec<usize>, EntityError> {
    pick(&placed_world(), filters)
}

fn bounds(r#type: u8, points: &[[f64; 3]]) -> EntityFilters {
    let points = points.iter().map(|[x, y, z]| Vector3 { x: *x, y: *y, z: *z }).collect();
    EntityFilters { bounds: Bounds { r#type, points }, ..EntityFilters::default() }
}

#[test]
fn robots_are_picked_by_name_category_and_place() {
    let named = |filter: &str| EntityFilters { filter: filter.into(), ..EntityFilters::default() };
    let of = |category| EntityFilters {
        categories: vec![EntityCategory { category }],
        ..EntityFilters::default()
    };

    assert_eq!(picked(&EntityFilters::default()), Ok(vec![0, 1, 2, 3]));
    assert_eq!(picked(&named("robot_[13]$")), Ok(vec![0, 2]));
    assert_eq!(picked(&of(EntityCategory::ROBOT)), Ok(vec![0, 1, 2, 3]));
    assert_eq!(picked(&of(2)), Ok(vec![]));
    // Bodies have a radius of 7.5 cm.
    let near_second = bounds(Bounds::SPHERE, &[[1.0, 0.5, 0.0], [0.43, 0.0, 0.0]]);
    assert_eq!(picked(&near_second), Ok(vec![1]));
    let not_quite = bounds(Bounds::SPHERE, &[[1.0, 0.5, 0.0], [0.42, 0.0, 0.0]]);
    assert_eq!(picked(&not_quite), Ok(vec![]));
    assert_eq!(picked(&bounds(Bounds::BOX, &[[2.5, 1.0, 1.0], [0.5, -1.0, 0.0]])), Ok(vec![1, 2]));
}

#[test]
fn what_is_not_offered_is_reported() {
    let tags = TagsFilter { tags: vec!["fast".into()], filter_mode: 0 };
    let tagged = EntityFilters { tags, ..EntityFilters::default() };
    let broken = EntityFilters { filter: "(".into(), ..EntityFilters::default() };

    for (filters, code) in [(tagged, 0), (bounds(2, &[]), 0), (bounds(1, &[]), 0), (broken, 4)] {
        assert_eq!(picked(&filters).unwrap_err().code(), code, "{filters:?}");
    }
}

fn request(entity: &str) -> SetEntityStateRequest {
    let mut request = SetEntityStateRequest {
        entity: entity.to_owned(),
        set_pose: true,
        set_twist: true,
        ..SetEntityStateRequest::default()
    };
    request.state.pose = pose_message(Pose { x_m: 1.5, y_m: -1.0, heading_rad: 0.5 });
    request
}

#[test]
fn a_robot_is_put_where_it_can_be_and_nowhere_else() {
    let placed_world = placed_world();
    let (row, pose) = wanted(&placed_world, &request("robot_2")).unwrap().expect("a pose is meant");
    assert_eq!((row, pose.x_m.to_bits()), (1, 1.5_f64.to_bits()));
    let nothing = SetEntityStateRequest { set_pose: false, ..request("robot_2") };
    assert_eq!(wanted(&placed_world, &nothing), Ok(None));

    assert_eq!(wanted(&placed_world, &request("real")).unwrap_err().code(), 4);
    assert_eq!(wanted(&placed_world, &request("robot_9")).unwrap_err().code(), 2);
    for spoil in [
        |state: &mut EntityState| state.pose.position.x = f64::NAN,
        |state: &mut EntityState| state.pose.position.x = 2.95,
        |state: &mut EntityState| state.pose.position.z = 0.1,
        |state: &mut EntityState| state.pose.position.z = f64::NAN,
        |state: &mut EntityState| state.pose.orientation = turned_over(),
        |state: &mut EntityState| state.header.frame_id = "robot_1/base_link".into(),
    ] {
        let mut request = request("robot_2");
        spoil(&mut request.state);
        let error = wanted(&placed_world, &request).unwrap_err();
        assert_eq!(error.code(), SetEntityStateResponse::INVALID_POSE, "{error}");
    }
    let mut fast = request("robot_2");
    fast.state.twist.linear.x = 0.1;
    assert_eq!(wanted(&placed_world, &fast), Err(EntityError::Velocity));
    assert!(wanted(&placed_world, &SetEntityStateRequest { set_twist: false, ..fast }).is_ok());
}

fn turned_over() -> geometry_msgs::Quaternion {
    geometry_msgs::Quaternion { x: 1.0, y: 0.0, z: 0.0, w: 0.0 }
}

#[test]
fn a_state_contains_pose_and_command_of_a_robot_in_the_frame_of_the_map() {
    let mut placed_world = placed_world();
    let north = Pose { x_m: 1.0, y_m: 2.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    placed_world.advance_freely();
    placed_world.world.displace(1, north);
    let commanded = placed_world.obeyed()[1];

    let state = states(&placed_world, &[1], Time::from_nanos(5)).remove(0);

    assert_eq!((state.header.frame_id.as_str(), state.header.stamp.nanosec), ("map", 5));
    assert!((state.pose.position.y - 2.0).abs() < 1e-6);
    assert!((state.twist.linear.y - commanded.speed_m_s).abs() < 1e-6, "{:?}", state.twist);
    assert!(state.twist.linear.x.abs() < 1e-6);
    assert_eq!(state.twist.angular.z.to_bits(), commanded.turn_rate_rad_s.to_bits());
}
