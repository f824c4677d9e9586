//! Requests and responses of the services that a simulator offers.

use serde::{Deserialize, Serialize};

use super::{EntityFilters, EntityState, Result, SimulationState, SimulatorFeatures};
use crate::message::{RosMessage, ros_messages};

/// Asks for what the simulator can do.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetSimulatorFeaturesRequest {
    /// ROS 2 has no empty messages.
    pub structure_needs_at_least_one_member: u8,
}

/// Answers [`GetSimulatorFeaturesRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetSimulatorFeaturesResponse {
    /// The answer.
    pub features: SimulatorFeatures,
}

/// Asks for what the simulation does.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetSimulationStateRequest {
    /// ROS 2 has no empty messages.
    pub structure_needs_at_least_one_member: u8,
}

/// Answers [`GetSimulationStateRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetSimulationStateResponse {
    /// The answer.
    pub state: SimulationState,
    /// Whether it is known.
    pub result: Result,
}

/// Asks the simulation to go on, to stand, to start over or to end.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetSimulationStateRequest {
    /// What it shall do.
    pub state: SimulationState,
}

/// Answers [`SetSimulationStateRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetSimulationStateResponse {
    /// Whether it does.
    pub result: Result,
}

impl SetSimulationStateResponse {
    /// It does so already.
    pub const ALREADY_IN_TARGET_STATE: u8 = 101;
    /// It can never do so from here.
    pub const INCORRECT_TRANSITION: u8 = 103;
}

/// Asks the simulation to start over.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResetSimulationRequest {
    /// What shall begin anew: some of the bits, or 0 for all.
    pub scope: u8,
}

impl ResetSimulationRequest {
    /// The time.
    pub const TIME: u8 = 1;
    /// Where everything is.
    pub const STATE: u8 = 2;
    /// Everything.
    pub const ALL: u8 = 255;
}

/// Answers [`ResetSimulationRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResetSimulationResponse {
    /// Whether it was carried out.
    pub result: Result,
}

/// Asks a paused simulation for steps.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepSimulationRequest {
    /// How many.
    pub steps: u64,
}

/// Answers [`StepSimulationRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepSimulationResponse {
    /// Whether they were made.
    pub result: Result,
}

/// Asks for the names of entities.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GetEntitiesRequest {
    /// Which.
    pub filters: EntityFilters,
}

/// Answers [`GetEntitiesRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetEntitiesResponse {
    /// Whether they could be found.
    pub result: Result,
    /// Their names.
    pub entities: Vec<String>,
}

/// Asks for the states of entities.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GetEntitiesStatesRequest {
    /// Which.
    pub filters: EntityFilters,
}

/// Answers [`GetEntitiesStatesRequest`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GetEntitiesStatesResponse {
    /// Whether they could be found.
    pub result: Result,
    /// Their names; shape `[n_entities]`.
    pub entities: Vec<String>,
    /// Their states; shape `[n_entities]`.
    pub states: Vec<EntityState>,
}

/// Asks for the state of an entity.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetEntityStateRequest {
    /// Its name.
    pub entity: String,
}

/// Answers [`GetEntityStateRequest`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GetEntityStateResponse {
    /// Whether it could be found.
    pub result: Result,
    /// Its state, if it was.
    pub state: EntityState,
}

/// Moves an entity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SetEntityStateRequest {
    /// Its name.
    pub entity: String,
    /// Its new state; the stamp does not matter.
    pub state: EntityState,
    /// Whether the pose is meant.
    pub set_pose: bool,
    /// Whether the velocities are meant.
    pub set_twist: bool,
    /// Whether the accelerations are meant.
    pub set_acceleration: bool,
}

/// Moves an entity, as in version 1 of the package: all of the state is meant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SetEntityStateRequest1 {
    /// Its name.
    pub entity: String,
    /// Its new state; the stamp does not matter.
    pub state: EntityState,
}

impl From<SetEntityStateRequest1> for SetEntityStateRequest {
    fn from(SetEntityStateRequest1 { entity, state }: SetEntityStateRequest1) -> Self {
        Self { entity, state, set_pose: true, set_twist: true, set_acceleration: true }
    }
}

/// Answers [`SetEntityStateRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetEntityStateResponse {
    /// Whether it was set.
    pub result: Result,
}

impl SetEntityStateResponse {
    /// No robot can have this pose.
    pub const INVALID_POSE: u8 = 101;
}

/// A request of one of these services.
pub trait ServiceRequest: RosMessage {
    /// What answers it.
    type Response: RosMessage + Default;
    /// Name of the service, below that of the simulator.
    const SERVICE: &'static str;
}

/// Names each service with its type, and the types of its request and response.
macro_rules! services {
    ($($request:ty, $response:ty => $type_name:literal, $service:literal;)+) => {
        /// The services that our simulator offers.
        pub const SERVICES: &[&str] = &[$($service),+];

        $(ros_messages! {
            $request => concat!("simulation_interfaces/srv/", $type_name, "_Request"),
            $response => concat!("simulation_interfaces/srv/", $type_name, "_Response"),
        }
        impl ServiceRequest for $request {
            type Response = $response;
            const SERVICE: &'static str = $service;
        })+
    };
}

services! {
    GetSimulatorFeaturesRequest, GetSimulatorFeaturesResponse => "GetSimulatorFeatures", "get_simulator_features";
    GetSimulationStateRequest, GetSimulationStateResponse => "GetSimulationState", "get_simulation_state";
    SetSimulationStateRequest, SetSimulationStateResponse => "SetSimulationState", "set_simulation_state";
    ResetSimulationRequest, ResetSimulationResponse => "ResetSimulation", "reset_simulation";
    StepSimulationRequest, StepSimulationResponse => "StepSimulation", "step_simulation";
    GetEntitiesRequest, GetEntitiesResponse => "GetEntities", "get_entities";
    GetEntitiesStatesRequest, GetEntitiesStatesResponse => "GetEntitiesStates", "get_entities_states";
    GetEntityStateRequest, GetEntityStateResponse => "GetEntityState", "get_entity_state";
    SetEntityStateRequest, SetEntityStateResponse => "SetEntityState", "set_entity_state";
}

ros_messages! {
    SetEntityStateRequest1 => "simulation_interfaces/srv/SetEntityState_Request",
}
