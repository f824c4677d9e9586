//! What viewers are shown.

use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics;
use rsrs_msgs::visualization_msgs::{Marker, MarkerArray};

use crate::fleet::{Latest, ROBOTS, World, conditions, set, start};
use rsrs_testing::network::{eventually, in_own_network, session};

#[test]
fn viewers_get_the_frames_and_markers_of_a_world_and_lose_them_with_it() {
    in_own_network(
        "viewers::viewers_get_the_frames_and_markers_of_a_world_and_lose_them_with_it",
        viewing,
    );
}

async fn viewing() {
    let _simulator = start();
    let session = session();
    let node = session.node("/", "viewer").expect("the name is allowed");
    let frames = Latest::<TFMessage>::new(&session, &node, topics::TF);
    let markers = Latest::<MarkerArray>::new(&session, &node, topics::MARKERS);
    let world = World { conditions: conditions(), steps: 0, time: "real_time" };
    world.place(&session, &node).await.expect("the world can be placed");

    eventually("frames come", || frames.only().is_some()).await;
    let bodies = || {
        let array = markers.only()?;
        array.markers.into_iter().find(|marker| marker.ns == "bodies")
    };
    eventually("markers come", || bodies().is_some()).await;

    let tree = frames.only().expect("it has come").transforms;
    let children: Vec<String> = tree.iter().map(|frame| frame.child_frame_id.clone()).collect();
    assert_eq!(children, ROBOTS.map(|robot| format!("{robot}/base_link")));
    let points = bodies().expect("they have come").points;
    for (frame, point) in tree.iter().zip(&points) {
        let at = frame.transform.translation;
        assert_eq!((at.x.to_bits(), at.y.to_bits()), (point.x.to_bits(), point.y.to_bits()));
        assert_eq!(frame.header.frame_id, "map");
    }
    let array = markers.only().expect("it has come");
    let text = array.markers.iter().find(|marker| marker.ns == "label").expect("it has a label");
    assert!(text.text.starts_with("3 robots, 0.0 s\n"), "{}", text.text);

    set(&session, &node, "", 0, "lockstep").await.expect("no world is a choice");

    let is_wiped = || {
        let array = markers.only().expect("it has come");
        array.markers.iter().any(|marker| marker.action == Marker::DELETEALL)
    };
    eventually("what was shown is wiped", is_wiped).await;
    session.close().await;
}
