//! Manual control of the simulator by tools, through `simulation_interfaces`, in both ways of calling
//! services.

use std::time::Duration;

use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::{Point, Quaternion};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{RobotState, RobotStatus, WorldDigest};
use rsrs_msgs::simulation_interfaces::{
    GetEntitiesRequest, GetEntitiesResponse, GetEntitiesStatesRequest, GetEntitiesStatesResponse,
    GetEntityStateRequest, GetEntityStateResponse, GetSimulationStateRequest,
    GetSimulationStateResponse, GetSimulatorFeaturesRequest, GetSimulatorFeaturesResponse,
    ResetSimulationRequest, ResetSimulationResponse, Result as Outcome, SetEntityStateRequest,
    SetEntityStateRequest1, SetEntityStateResponse, SetSimulationStateRequest,
    SetSimulationStateResponse, SimulationState, SimulatorFeatures, StepSimulationRequest,
    StepSimulationResponse,
};
use rsrs_msgs::topics;
use rsrs_ros::parameters::Mapping;
use rsrs_ros::services::ServiceClient;
use rsrs_ros::session::{NodeHandle, Session};
use rsrs_sim::episode::episode_digests;
use serde::{Deserialize, Serialize};

use crate::fleet::{
    Latest, ROBOTS, SEED, World, armed_lease, conditions, controller_status, publisher, start,
    until_it_listens,
};
use rsrs_testing::network::{TIMEOUT, eventually, in_own_network, session};

#[test]
fn tools_step_pause_reset_and_move_a_world_that_no_run_holds() {
    in_own_network(
        "manual_control::tools_step_pause_reset_and_move_a_world_that_no_run_holds",
        steering,
    );
}

#[test]
fn no_tool_moves_a_world_that_a_run_holds() {
    in_own_network("manual_control::no_tool_moves_a_world_that_a_run_holds", held);
}

/// A request to set a state that no version of the package has.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct OtherVersion {
    number: u64,
}

impl RosMessage for OtherVersion {
    const TYPE_NAME: &'static str = "simulation_interfaces/srv/SetEntityState_Request";
}

/// A tool that a person uses.
struct Tool<'a> {
    session: &'a Session,
    node: &'a NodeHandle,
    mapping: Mapping,
}

impl Tool<'_> {
    async fn call<Q: RosMessage, R: RosMessage>(&self, service: &str, request: Q) -> R {
        let service = format!("/simulator/{service}");
        let client = ServiceClient::new(self.session, self.node, &service, self.mapping);
        let client = client.expect("the name is allowed");
        client.call(&request, TIMEOUT).await.expect("the simulator answers")
    }

    async fn state(&self) -> u8 {
        let request = GetSimulationStateRequest::default();
        let answer: GetSimulationStateResponse = self.call("get_simulation_state", request).await;
        assert_eq!(answer.result.result, Outcome::OK);
        answer.state.state
    }

    async fn set_state(&self, state: u8) -> Outcome {
        let request = SetSimulationStateRequest { state: SimulationState { state } };
        let answer: SetSimulationStateResponse = self.call("set_simulation_state", request).await;
        answer.result
    }

    async fn step(&self, steps: u64) -> Outcome {
        let request = StepSimulationRequest { steps };
        let answer: StepSimulationResponse = self.call("step_simulation", request).await;
        answer.result
    }

    async fn reset(&self, scope: u8) -> Outcome {
        let request = ResetSimulationRequest { scope };
        let answer: ResetSimulationResponse = self.call("reset_simulation", request).await;
        answer.result
    }
}

async fn steering() {
    let _simulator = start();
    for mapping in [Mapping::Enhanced, Mapping::Cyclone] {
        // The middleware hands what one reader has received to the next one of the same participant,
        // and what is sent in one mapping means nothing in the other.
        let session = session();
        let node = session.node("/", "tool").expect("the name is allowed");
        steer(&Tool { session: &session, node: &node, mapping }).await;
        session.close().await;
    }
}

async fn steer(tool: &Tool<'_>) {
    let Tool { session, node, .. } = tool;
    let digests = Latest::<WorldDigest>::new(session, node, topics::WORLD_DIGEST);
    let statuses = Latest::<RobotStatus>::new(session, node, topics::SIMULATOR_STATUS);
    let world = World { conditions: conditions(), steps: 10, time: "lockstep" };
    session.wait_for_writers(topics::WORLD_DIGEST.name, 1, TIMEOUT).await.expect("it publishes");
    let duration_s = 10.0 * world.conditions.period_s;
    let expected = episode_digests(&world.conditions, SEED, duration_s).expect("the robots fit");

    crate::fleet::set(session, node, "", 0, "lockstep").await.expect("it is a choice");
    lists_what_it_can_do(tool).await;
    assert_eq!(tool.state().await, SimulationState::NO_WORLD);
    assert_eq!(tool.step(1).await.result, Outcome::INCORRECT_STATE);

    world.place(session, node).await.expect("the world can be placed");
    assert_eq!(tool.state().await, SimulationState::STOPPED);
    assert_eq!(tool.step(1).await.result, Outcome::OPERATION_FAILED, "it is not paused");
    assert_eq!(tool.set_state(SimulationState::PAUSED).await.result, Outcome::OK);
    assert_eq!(tool.step(5).await.result, Outcome::OK);
    let stepped = || digests.only().is_some_and(|digest| digest.step == 6);
    eventually("five steps are made", stepped).await;
    let digest = digests.only().expect("it has come").digest;
    assert_eq!(digest, expected[5], "a manual step is a step of the replicate");
    assert_eq!(statuses.in_state(RobotState::Idle).await.parameter_digest, 0);

    moves_a_robot(tool).await;
    assert_eq!(tool.set_state(SimulationState::PLAYING).await.result, Outcome::OK);
    assert_eq!(tool.state().await, SimulationState::PLAYING);
    eventually("it plays", || digests.only().is_some_and(|digest| digest.step > 8)).await;
    assert_eq!(tool.step(1).await.result, Outcome::OPERATION_FAILED, "it is not paused");

    assert_eq!(tool.reset(ResetSimulationRequest::TIME).await.result, 0);
    assert_eq!(tool.reset(0).await.result, Outcome::OK);
    assert_eq!(tool.state().await, SimulationState::STOPPED);
    let armed = statuses.in_state(RobotState::Armed).await;
    assert_eq!(armed.parameter_digest, world.digest(), "it is a run's world again");
    let again = tool.set_state(SimulationState::STOPPED).await;
    assert_eq!(again.result, SetSimulationStateResponse::ALREADY_IN_TARGET_STATE);
}

async fn lists_what_it_can_do(tool: &Tool<'_>) {
    let request = GetSimulatorFeaturesRequest::default();
    let answer: GetSimulatorFeaturesResponse = tool.call("get_simulator_features", request).await;
    assert!(answer.features.features.contains(&SimulatorFeatures::STEP_SIMULATION_MULTIPLE));
    let request = GetEntitiesRequest::default();
    let answer: GetEntitiesResponse = tool.call("get_entities", request).await;
    assert_eq!((answer.result.result, answer.entities.len()), (Outcome::OK, 0));
}

async fn moves_a_robot(tool: &Tool<'_>) {
    let odom = Latest::<Odometry>::new(tool.session, tool.node, topics::ODOM);
    tool.session
        .wait_for_readers(&topics::ODOM.for_robot(ROBOTS[1]), 1, TIMEOUT)
        .await
        .expect("it was just made");
    tokio::time::sleep(Duration::from_millis(300)).await;
    let mut request = SetEntityStateRequest {
        entity: ROBOTS[1].to_owned(),
        set_pose: true,
        ..SetEntityStateRequest::default()
    };
    request.state.pose.position = Point { x: 2.0, y: -1.5, z: 0.0 };
    request.state.pose.orientation = Quaternion { x: 0.0, y: 0.0, z: 0.6, w: 0.8 };

    let answer: SetEntityStateResponse = tool.call("set_entity_state", request).await;

    assert_eq!(answer.result.result, Outcome::OK, "{}", answer.result.error_message);
    let is_there = || odom.place(ROBOTS[1]).is_some_and(|place| (place[0] - 2.0).abs() < 1e-6);
    eventually("the robot is reported to be there", is_there).await;
    // As tools of Jazzy ask, whose requests have no flags at their end.
    let mut request = SetEntityStateRequest1 {
        entity: ROBOTS[0].to_owned(),
        ..SetEntityStateRequest1::default()
    };
    request.state.pose.position = Point { x: -2.0, y: 1.0, z: 0.0 };
    request.state.pose.orientation.w = 1.0;
    let answer: SetEntityStateResponse = tool.call("set_entity_state", request).await;
    assert_eq!(answer.result.result, Outcome::OK, "{}", answer.result.error_message);
    let is_there = || odom.place(ROBOTS[0]).is_some_and(|place| (place[0] + 2.0).abs() < 1e-6);
    eventually("the other robot is reported to be there", is_there).await;
    // A request that is of no version is answered, too, as its vendor calls services.
    if tool.mapping == Mapping::Enhanced {
        let answer: SetEntityStateResponse =
            tool.call("set_entity_state", OtherVersion::default()).await;
        assert_eq!(answer.result.result, Outcome::FEATURE_UNSUPPORTED);
    }

    let request = GetEntityStateRequest { entity: ROBOTS[1].to_owned() };
    let answer: GetEntityStateResponse = tool.call("get_entity_state", request).await;
    assert!((answer.state.pose.position.y + 1.5).abs() < 1e-6, "{:?}", answer.state);
    let answer: GetEntitiesStatesResponse =
        tool.call("get_entities_states", GetEntitiesStatesRequest::default()).await;
    assert_eq!(answer.entities, ROBOTS);
    assert_eq!(answer.states.len(), ROBOTS.len());
    let request = GetEntityStateRequest { entity: "robot_9".to_owned() };
    let answer: GetEntityStateResponse = tool.call("get_entity_state", request).await;
    assert_eq!(answer.result.result, Outcome::NOT_FOUND);
}

async fn held() {
    let _simulator = start();
    let session = session();
    let node = session.node("/", "tool").expect("the name is allowed");
    let robots = Latest::<RobotStatus>::new(&session, &node, topics::STATUS);
    let world = World { conditions: conditions(), steps: 0, time: "real_time" };
    until_it_listens(&session).await;
    world.place(&session, &node).await.expect("the world can be placed");
    let leases = publisher(&session, &node, topics::LEASE, ROBOTS[0]);
    let status = topics::CONTROLLER_STATUS;
    let controllers = ROBOTS.map(|robot| publisher(&session, &node, status, robot));
    let holding = async {
        let mut lease = armed_lease();
        let parameter_digest = lease.parameter_digest;
        loop {
            for (robot, echo) in ROBOTS.iter().zip(&mut lease.echoed_counter) {
                *echo = robots.get(robot).map_or(0, |status: RobotStatus| status.counter);
            }
            leases.publish(lease.clone()).await.expect("a healthy network");
            for controller in &controllers {
                let status = controller_status(parameter_digest);
                controller.publish(status).await.expect("a healthy network");
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    let trying = async {
        eventually("the robots are armed", || robots.all_in_state(RobotState::Armed)).await;
        let tool = Tool { session: &session, node: &node, mapping: Mapping::Enhanced };
        assert_eq!(tool.state().await, SimulationState::STOPPED);
        for result in [
            tool.set_state(SimulationState::PLAYING).await,
            tool.set_state(SimulationState::PAUSED).await,
            tool.set_state(SimulationState::QUITTING).await,
            tool.step(1).await,
            tool.reset(ResetSimulationRequest::ALL).await,
        ] {
            assert_eq!(result.result, Outcome::INCORRECT_STATE, "{}", result.error_message);
            assert!(result.error_message.contains("an experiment holds the robots"));
        }
        let request = SetEntityStateRequest {
            entity: ROBOTS[0].to_owned(),
            set_pose: true,
            ..SetEntityStateRequest::default()
        };
        let answer: SetEntityStateResponse = tool.call("set_entity_state", request).await;
        assert_eq!(answer.result.result, Outcome::INCORRECT_STATE);
        assert!(robots.all_in_state(RobotState::Armed));
    };
    tokio::select! {
        () = holding => {}
        () = trying => {}
    }
    session.close().await;
}
