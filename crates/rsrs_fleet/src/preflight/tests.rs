use super::*;
use crate::e_stop::LockCause;
use crate::message::{self, StopCause};

fn expected() -> Expected {
    Expected {
        robots: vec!["robot_1".to_owned(), "robot_2".to_owned()],
        simulator: true,
        topics: ["/robot_1/cmd_vel", "/robot_2/cmd_vel"]
            .map(|name| ExpectedTopic {
                name: name.to_owned(),
                type_name: "geometry_msgs/msg/TwistStamped".to_owned(),
                publishers: Publishers::One,
            })
            .to_vec(),
        ..Expected::default()
    }
}

fn publisher(topic: &str, type_name: &str) -> Endpoint {
    Endpoint {
        topic: topic.to_owned(),
        type_name: format!("geometry_msgs/msg/{type_name}"),
        node: None,
        guid: [0; 16],
    }
}

fn status(state: RobotState, stop_cause: StopCause, stop_reason: &str) -> Status {
    let stop_reason = stop_reason.to_owned();
    Status { stop_reason, ..message::tests::status(state, stop_cause) }
}

fn complete() -> Seen {
    let names = ["robot_1".to_owned(), "robot_2".to_owned()];
    Seen {
        graph: Graph {
            publishers: vec![
                publisher("/robot_1/cmd_vel", "TwistStamped"),
                publisher("/robot_2/cmd_vel", "TwistStamped"),
            ],
            simulator: true,
            ..Graph::default()
        },
        robots: names
            .clone()
            .map(|name| (name, status(RobotState::Idle, StopCause::NoRun, "")))
            .into(),
        controllers: names.into(),
        ..Seen::default()
    }
}

#[test]
fn every_problem_is_named_at_once() {
    let mut seen = complete();
    seen.graph.simulator = false;
    seen.graph.publishers = vec![
        publisher("/robot_1/cmd_vel", "Twist"),
        publisher("/robot_2/cmd_vel", "TwistStamped"),
        publisher("/robot_2/cmd_vel", "TwistStamped"),
    ];
    seen.robots.remove("robot_1");
    seen.robots.insert(
        "robot_2".to_owned(),
        status(RobotState::Fault, StopCause::Hardware, "motor driver hot"),
    );
    seen.controllers.remove("robot_2");
    seen.other_runs.insert("other".to_owned());
    seen.e_stop = Locks([(Source([3; 16]), LockCause::Engaged)].into());

    let sentences: Vec<_> = problems(&expected(), &seen).iter().map(ToString::to_string).collect();

    assert_eq!(
        sentences,
        [
            "the e-stop is engaged",
            "another runner is active, run other",
            "no simulator discovered",
            "robot_1: no status received",
            "robot_2: motor driver hot",
            "robot_2: no status of its controller received",
            "/robot_1/cmd_vel: type is geometry_msgs/msg/Twist, expected \
             geometry_msgs/msg/TwistStamped: set `cmd_vel: twist` in the fleet file, and start the \
             controller with `-p cmd_vel_type:=twist`",
            "/robot_2/cmd_vel: 2 publishers, expected 1 (two of one name?)",
        ]
    );
}

#[test]
fn a_node_that_has_another_topic_in_its_place_is_named() {
    let detection = "/robot_1/detection";
    let mut expected = expected();
    expected.topics = ["/robot_1/cmd_vel", detection]
        .map(|name| ExpectedTopic {
            name: name.to_owned(),
            type_name: if name == detection {
                "std_msgs/msg/Bool"
            } else {
                "geometry_msgs/msg/Twist"
            }
            .to_owned(),
            publishers: Publishers::One,
        })
        .to_vec();
    let end = |topic: &str, type_name: &str| Endpoint {
        node: Some("/robot_1/controller".to_owned()),
        topic: topic.to_owned(),
        type_name: type_name.to_owned(),
        guid: [0; 16],
    };
    let mut seen = complete();
    seen.graph.publishers = vec![end("/base/cmd_vel", "geometry_msgs/msg/Twist")];
    seen.graph.subscribers = vec![
        end("/swarm/e_stop", "std_msgs/msg/Bool"),
        end("/robot_1/virtual_detection", "std_msgs/msg/Bool"),
        end("/camera/seen", "std_msgs/msg/Bool"),
    ];

    let renamed = |topic: &str, renamed: &str| {
        let node = "/robot_1/controller".to_owned();
        Problem::Renamed { topic: topic.to_owned(), node, renamed: renamed.to_owned() }
    };
    let both = [renamed("/robot_1/cmd_vel", "/base/cmd_vel"), renamed(detection, "/camera/seen")];
    assert_eq!(problems(&expected, &seen), both);
    seen.graph.publishers.clear();
    seen.graph.subscribers.pop();

    let none = ["/robot_1/cmd_vel", detection];
    let none = none.map(|topic| Problem::NoPublisher { topic: topic.to_owned(), nearest: None });
    assert_eq!(problems(&expected, &seen), none, "nothing of it is there");
}

fn sentences(expected: &Expected, seen: &Seen) -> Vec<String> {
    problems(expected, seen).iter().map(ToString::to_string).collect()
}

#[test]
fn clocks_batteries_and_diagnostics_are_looked_at() {
    let mut expected = expected();
    expected.battery_min_v =
        [("robot_1".to_owned(), 6.6), ("robot_2".to_owned(), 6.6)].into_iter().collect();
    let mut seen = complete();
    seen.robots.get_mut("robot_1").expect("it is there").battery_v = 6.25;
    seen.clocks.insert("robot_1".to_owned(), clock(-61.5, Some(0.26)));
    seen.clocks.insert("robot_2".to_owned(), clock(0.9, Some(0.26)));
    seen.diagnostic_errors.insert(DiagnosticError {
        robot: "robot_2".to_owned(),
        part: "robot_2: link".to_owned(),
        message: "no answer".to_owned(),
    });

    assert_eq!(
        sentences(&expected, &seen),
        [
            "robot_1: battery at 6.25 V, expected at least 6.60 V",
            "robot_1: clock 61.5 s behind ours, and it has changed by 0.3 s since it was received \
             first, so its stamps cannot be aligned (let chrony set it)",
            "robot_2: battery unknown, expected at least 6.60 V",
            "robot_2: diagnostics: robot_2: link: no answer",
        ]
    );
}

#[test]
fn a_machine_that_is_too_slow_is_reported_and_no_robot_blamed() {
    let mut seen = complete();
    seen.graph.simulator = false;
    seen.robots.remove("robot_1");
    seen.controllers.clear();
    seen.clocks.insert("robot_2".to_owned(), clock(-4.6, None));
    seen.behind_s = Some(4.7);

    let slow = sentences(&expected(), &seen);
    seen.behind_s = Some(0.02);
    let in_time = sentences(&expected(), &seen);

    assert_eq!(
        slow,
        [
            "this machine is too slow: what it receives waits 4.7 s until it is looked at, expected at \
          most 0.5 s"
        ]
    );
    assert_eq!(in_time.len(), 5, "{in_time:?}");
}

#[test]
fn robots_that_the_e_stop_holds_are_named_with_what_releases_them() {
    let mut seen = complete();
    seen.robots.insert("robot_2".to_owned(), status(RobotState::Stopped, StopCause::EStop, ""));

    assert_eq!(
        sentences(&expected(), &seen),
        ["the e-stop holds robot_2 (`rsrs stop --release` lets them go)"]
    );
}

#[test]
fn two_robots_of_one_name_and_none_of_a_name_are_different_problems() {
    let mut expected = expected();
    expected.topics.push(ExpectedTopic {
        name: "/robot_1/status".to_owned(),
        type_name: "geometry_msgs/msg/Twist".to_owned(),
        publishers: Publishers::AtMostOne,
    });
    let mut seen = complete();
    assert_eq!(sentences(&expected, &seen), [] as [String; 0]);

    seen.graph.publishers.extend([(); 2].map(|()| publisher("/robot_1/status", "Twist")));

    assert_eq!(
        sentences(&expected, &seen),
        ["/robot_1/status: 2 publishers, expected 1 (two of one name?)"]
    );
}

#[test]
fn a_base_that_waits_for_another_type_of_command_is_named() {
    let mut seen = complete();
    let subscriber = |robot: u8, node: &str, type_name| Endpoint {
        node: Some(node.to_owned()),
        ..publisher(&format!("/robot_{robot}/cmd_vel"), type_name)
    };
    seen.graph.subscribers = vec![
        // One that takes both, one that does not, and an onlooker.
        subscriber(1, "/robot_1/base", "TwistStamped"),
        subscriber(1, "/robot_1/base", "Twist"),
        subscriber(2, "/robot_2/base", "Twist"),
        subscriber(2, "/plotter", "Twist"),
    ];

    assert_eq!(
        sentences(&expected(), &seen),
        ["/robot_2/cmd_vel: /robot_2/base waits for geometry_msgs/msg/Twist, and \
             geometry_msgs/msg/TwistStamped is sent: set `cmd_vel: twist` in the fleet file, and start \
             the controller with `-p cmd_vel_type:=twist`"]
    );
}

#[test]
fn who_holds_its_lease_is_reported_of_each_robot() {
    let all = expected();
    let one = Expected { controller_only: ["robot_2".to_owned()].into(), ..expected() };

    assert_eq!(all.leases(), ["lease: gate on all 2 robots"]);
    let [gated, alone] = &one.leases()[..] else { panic!("{:?}", one.leases()) };
    assert_eq!(gated, "lease: gate on robot_1");
    assert!(alone.starts_with("robot_2: lease: controller only"), "{alone}");
}

#[test]
fn a_robot_whose_lease_nobody_holds_is_named_with_what_to_type() {
    let expected = Expected { controller_only: ["robot_2".to_owned()].into(), ..expected() };
    let mut seen = complete();
    seen.robots.remove("robot_2");

    let [problem] = &problems(&expected, &seen)[..] else { panic!("one problem") };

    let printed = problem.to_string();
    assert!(printed.starts_with("robot_2: nobody holds its lease"), "{printed}");
    assert!(printed.contains("-p lease:=controller"), "{printed}");
}

/// Robots at these places, each in its frame.
fn at(places: [(&str, f64); 2]) -> (Expected, Seen) {
    let robots = ["robot_1", "robot_2"].map(str::to_owned);
    let expected = Expected {
        apart: Some(Apart { robots: robots.clone().into(), radius_m: 0.075 }),
        ..expected()
    };
    let poses = robots.into_iter().zip(places).map(|(robot, (frame, x_m))| {
        (robot, (frame.to_owned(), Pose { x_m, y_m: 0.0, heading_rad: 0.0 }))
    });
    (expected, Seen { poses: poses.collect(), ..complete() })
}

#[test]
fn robots_on_one_spot_are_refused() {
    let (expected, seen) = at([("odom", 0.0), ("odom", 0.0)]);
    let printed = sentences(&expected, &seen);
    assert!(
        printed.len() == 1 && printed[0].starts_with("robot_1, robot_2 are on one spot"),
        "{printed:?}"
    );

    let (expected, seen) = at([("odom", 0.0), ("odom", 0.15)]);
    assert_eq!(sentences(&expected, &seen), [""; 0]);
}

#[test]
fn frames_that_no_transform_ties_together_are_refused() {
    let (expected, mut seen) = at([("robot_1/odom", 0.0), ("/robot_2/odom", 0.0)]);
    let printed = sentences(&expected, &seen);
    assert_eq!(
        printed,
        ["poses are in different frames that no transform on /tf or /tf_static ties together: \
          robot_1 in `robot_1/odom`, robot_2 in `robot_2/odom` (publish them in one frame)"]
    );

    for robot in ["robot_1", "robot_2"] {
        seen.parents.insert(format!("{robot}/odom"), "map".to_owned());
    }
    assert_eq!(sentences(&expected, &seen), [""; 0]);
}

#[test]
fn poses_that_cannot_be_used_are_refused_where_poses_are_needed() {
    let (expected, mut seen) = at([("odom", 0.0), ("odom", 1.0)]);
    let reason = "no orientation: a quaternion of length 0.000, expected 1";
    seen.unusable_poses.insert("robot_2".to_owned(), reason.to_owned());

    assert_eq!(
        sentences(&expected, &seen),
        [format!("robot_2: its pose cannot be used: {reason}")]
    );
    assert_eq!(sentences(&Expected { apart: None, ..expected }, &seen), [""; 0]);
}

fn clock(ahead_s: f64, change_s: Option<f64>) -> ClockLead {
    ClockLead { ahead_s, change_s }
}

#[test]
fn poses_of_another_clock_are_noted_if_it_is_steady_and_else_refused() {
    let mut seen = complete();
    let tracker = clock(-1_763_969_600.0, Some(0.02));
    seen.pose_clocks.insert("robot_1".to_owned(), tracker);
    seen.pose_clocks
        .insert("robot_2".to_owned(), ClockLead { ahead_s: -1_763_969_600.1, ..tracker });

    assert_eq!(sentences(&expected(), &seen), [""; 0]);
    assert_eq!(
        clock_notes(&expected(), &seen),
        [
            "note: robot_1, robot_2: poses are stamped 1763969600.0 s behind our clock; they are aligned \
          by when they are received"
        ]
    );

    for (change_s, expected_text) in
        [(Some(-3.0), "changed by 3.0 s"), (None, "its stamps have not come for 2 s yet")]
    {
        seen.pose_clocks.insert("robot_1".to_owned(), ClockLead { change_s, ..tracker });

        let printed = sentences(&expected(), &seen);

        assert_eq!(printed.len(), 1, "{printed:?}");
        assert!(printed[0].starts_with("robot_1: its poses are stamped 1763969600.0 s behind our"));
        assert!(printed[0].contains(expected_text), "{printed:?}");
    }
}

#[test]
fn a_robot_of_a_simulator_without_a_world_is_refused_where_no_simulator_is_set() {
    let mut seen = complete();
    seen.robots.insert("robot_1".to_owned(), status(RobotState::Idle, StopCause::NoWorld, ""));

    assert_eq!(sentences(&expected(), &seen), [""; 0], "the run sets its conditions");
    let printed = sentences(&Expected { simulator: false, ..expected() }, &seen);

    assert!(
        printed.len() == 1 && printed[0].starts_with("robot_1: its simulator has placed no world")
    );
}

#[test]
fn an_epoch_that_no_runner_made_is_named_with_its_robot() {
    let mut seen = complete();
    let robot = Status { epoch: u64::MAX, ..status(RobotState::Idle, StopCause::NoRun, "") };
    seen.robots.insert("robot_1".to_owned(), robot);

    let printed = sentences(&expected(), &seen);

    assert!(printed[0].starts_with("robot_1: epoch 18446744073709551615 refused"), "{printed:?}");
}

#[test]
fn a_robot_whose_commands_nobody_receives_is_refused_and_onlookers_drive_none() {
    let topics = ["/robot_1/cmd_vel", "/robot_2/cmd_vel", "/robot_2/hardware/cmd_vel"];
    let expected =
        Expected { obeyed: topics.map(str::to_owned).into_iter().collect(), ..expected() };
    let mut seen = complete();
    let subscriber = |topic: &str, node: Option<&str>| Endpoint {
        node: node.map(str::to_owned),
        ..publisher(topic, "TwistStamped")
    };
    seen.graph.subscribers = vec![
        subscriber("/robot_1/cmd_vel", Some("/rsrs_watch")),
        subscriber("/robot_1/cmd_vel", Some("/_ros2cli_7")),
        subscriber("/robot_2/cmd_vel", Some("/robot_2/robot")),
    ];

    let printed = sentences(&expected, &seen);
    seen.graph.subscribers.push(subscriber("/robot_1/cmd_vel", None));
    let with_a_base = sentences(&expected, &seen);
    seen.graph.publishers.push(publisher("/robot_2/hardware/cmd_vel", "Twist"));
    let with_a_gate_before_nothing = sentences(&expected, &seen);

    assert_eq!(
        printed,
        [
            "/robot_1/cmd_vel: nobody receives it, so the robot would stand (start its base; `ros2 topic \
          info -v /robot_1/cmd_vel` shows who subscribes)"
        ]
    );
    assert_eq!(with_a_base, [""; 0], "a program without a name may be a base");
    assert_eq!(with_a_gate_before_nothing.len(), 1);
    assert!(with_a_gate_before_nothing[0].starts_with("/robot_2/hardware/cmd_vel: nobody"));
}

fn wanted(name: &str) -> ExpectedTopic {
    ExpectedTopic {
        name: name.to_owned(),
        type_name: "geometry_msgs/msg/PoseStamped".to_owned(),
        publishers: Publishers::One,
    }
}

#[test]
fn a_topic_that_is_missing_is_named_with_the_nearest_that_is_there() {
    let names = ["/robot_1/pose", "/robot_2/pose", "/mocap/robot_1/pose", "/objects/object_3/pose"];
    let expected = Expected { topics: names.map(wanted).to_vec(), ..Expected::default() };
    let mut seen = Seen::default();
    seen.graph.publishers = [
        ("/robot_1/poze", "PoseStamped"),
        ("/robot_2/poses", "PoseArray"),
        ("/robot_3/pose", "PoseStamped"),
        ("/robot_2/goal", "PoseStamped"),
        ("/vrpn/mocap/robot_1/pose", "PoseStamped"),
    ]
    .map(|(topic, type_name)| publisher(topic, type_name))
    .to_vec();

    assert_eq!(
        sentences(&expected, &seen),
        [
            "/robot_1/pose: no publisher; did you mean /robot_1/poze?",
            "/robot_2/pose: no publisher",
            "/mocap/robot_1/pose: no publisher; did you mean /vrpn/mocap/robot_1/pose?",
            "/objects/object_3/pose: no publisher (an object of the run's world: have it tracked, or take it out of \
             the world's file)",
        ]
    );
}

#[test]
fn objects_that_the_world_does_not_have_are_named_before_a_run() {
    let objects = ["object_1", "object_2"].map(str::to_owned);
    let mut expected = Expected { objects: Some(objects.into()), ..Expected::default() };
    let mut seen = Seen::default();
    let tracked = ["/objects/object_1/pose", "/objects/object_2/pose", "/objects/object_3/pose"];
    seen.graph.publishers = tracked.map(|topic| publisher(topic, "PoseStamped")).to_vec();

    let with_objects = sentences(&expected, &seen);
    let noted = object_note(&expected, &seen.graph);
    expected.objects = Some(BTreeSet::new());
    let without = (problems(&expected, &seen), object_note(&expected, &seen.graph));
    expected.objects = None;
    let simulated = (problems(&expected, &seen), object_note(&expected, &seen.graph));

    assert_eq!(
        with_objects,
        [
            "/objects/object_3/pose: the run's world has 2 objects, object_1 to object_2 (add what is tracked to the \
          world's file, give it the name of an object, or take it off the floor)"
        ]
    );
    assert_eq!((noted, without.0, simulated), (None, vec![], (vec![], None)));
    let note = without.1.expect("nobody expects objects");
    assert!(note.contains("/objects/object_2/pose") && note.contains("has no objects"), "{note}");
}

#[test]
fn a_controller_of_another_type_has_one_cure_by_what_its_base_takes() {
    let mut seen = complete();
    seen.graph.publishers =
        ["/robot_1/cmd_vel", "/robot_2/cmd_vel"].map(|topic| publisher(topic, "Twist")).to_vec();
    seen.graph.subscribers =
        vec![publisher("/robot_1/cmd_vel", "TwistStamped"), publisher("/robot_2/cmd_vel", "Twist")];

    assert_eq!(
        sentences(&expected(), &seen),
        [
            "/robot_1/cmd_vel: type is geometry_msgs/msg/Twist, expected geometry_msgs/msg/TwistStamped: start the \
             controller with `-p cmd_vel_type:=twist_stamped`",
            "/robot_2/cmd_vel: type is geometry_msgs/msg/Twist, expected geometry_msgs/msg/TwistStamped: set \
             `cmd_vel: twist` in the fleet file",
        ]
    );
}
