//! Package `simulation_interfaces` 2.1: how ROS 2 tools steer any simulator.
//!
//! Only what our simulator offers is here; the definitions are in `definitions/`.

mod services;

use serde::{Deserialize, Serialize};

use crate::geometry_msgs::{Accel, Pose, Twist, Vector3};
use crate::message::ros_messages;
use crate::std_msgs::Header;

pub use services::{
    GetEntitiesRequest, GetEntitiesResponse, GetEntitiesStatesRequest, GetEntitiesStatesResponse,
    GetEntityStateRequest, GetEntityStateResponse, GetSimulationStateRequest,
    GetSimulationStateResponse, GetSimulatorFeaturesRequest, GetSimulatorFeaturesResponse,
    ResetSimulationRequest, ResetSimulationResponse, SERVICES, ServiceRequest,
    SetEntityStateRequest, SetEntityStateRequest1, SetEntityStateResponse,
    SetSimulationStateRequest, SetSimulationStateResponse, StepSimulationRequest,
    StepSimulationResponse,
};

/// Whether a request was carried out.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Result {
    /// [`Result::OK`], or why not; services have codes of their own from 101 on.
    pub result: u8,
    /// The same for people; empty if it was.
    pub error_message: String,
}

impl Result {
    /// The simulator cannot do this, and never will.
    pub const FEATURE_UNSUPPORTED: u8 = 0;
    /// It was carried out.
    pub const OK: u8 = 1;
    /// There is no entity of that name.
    pub const NOT_FOUND: u8 = 2;
    /// Not now.
    pub const INCORRECT_STATE: u8 = 3;
    /// It was tried and failed.
    pub const OPERATION_FAILED: u8 = 4;
}

/// What a simulator can do.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SimulatorFeatures {
    /// Some of the constants.
    pub features: Vec<u16>,
    /// Formats that entities can be spawned from.
    pub spawn_formats: Vec<String>,
    /// For people.
    pub custom_info: String,
}

impl SimulatorFeatures {
    /// Entities can be picked by a box around them.
    pub const ENTITY_BOUNDS_BOX: u16 = 6;
    /// Entities can be picked by their category.
    pub const ENTITY_CATEGORIES: u16 = 8;
    /// States of entities can be read.
    pub const ENTITY_STATE_GETTING: u16 = 10;
    /// States of entities can be set.
    pub const ENTITY_STATE_SETTING: u16 = 11;
    /// The simulation can be reset.
    pub const SIMULATION_RESET: u16 = 20;
    /// Its state can be read.
    pub const SIMULATION_STATE_GETTING: u16 = 24;
    /// Its state can be set.
    pub const SIMULATION_STATE_SETTING: u16 = 25;
    /// It can be paused.
    pub const SIMULATION_STATE_PAUSE: u16 = 26;
    /// It can make one step.
    pub const STEP_SIMULATION_SINGLE: u16 = 31;
    /// It can make many steps.
    pub const STEP_SIMULATION_MULTIPLE: u16 = 32;
}

/// What a simulation does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SimulationState {
    /// [`SimulationState::STOPPED`] and its kin.
    pub state: u8,
}

impl SimulationState {
    /// It stands at its start.
    pub const STOPPED: u8 = 0;
    /// It goes on.
    pub const PLAYING: u8 = 1;
    /// It stands where it is.
    pub const PAUSED: u8 = 2;
    /// The program ends.
    pub const QUITTING: u8 = 3;
    /// There is no world.
    pub const NO_WORLD: u8 = 4;
}

/// What kind of thing an entity is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EntityCategory {
    /// [`EntityCategory::ROBOT`], or something that our worlds have none of.
    pub category: u8,
}

impl EntityCategory {
    /// A robot.
    pub const ROBOT: u8 = 1;
}

/// Picks entities by their tags.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TagsFilter {
    /// None picks all.
    pub tags: Vec<String>,
    /// 0: any of them; 1: all of them.
    pub filter_mode: u8,
}

/// A volume.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// [`Bounds::EMPTY`] and its kin.
    pub r#type: u8,
    /// Two opposite corners of a box; or the centre of a sphere, and its radius as `x`.
    pub points: Vec<Vector3>,
}

impl Bounds {
    /// No bounds.
    pub const EMPTY: u8 = 0;
    /// A box along the axes.
    pub const BOX: u8 = 1;
    /// A sphere.
    pub const SPHERE: u8 = 3;
}

/// Which entities are asked for: those that pass every filter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EntityFilters {
    /// A regular expression for the name; empty passes all.
    pub filter: String,
    /// Any of these; none passes all.
    pub categories: Vec<EntityCategory>,
    /// By tags.
    pub tags: TagsFilter,
    /// By place.
    pub bounds: Bounds,
}

/// Where an entity is, and how it moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EntityState {
    /// When, and the frame of all that follows.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
    /// Velocities as seen in the frame of the header.
    pub twist: Twist,
    /// Accelerations as seen in the frame of the header.
    pub acceleration: Accel,
}

ros_messages! {
    Result => "simulation_interfaces/msg/Result",
    SimulatorFeatures => "simulation_interfaces/msg/SimulatorFeatures",
    SimulationState => "simulation_interfaces/msg/SimulationState",
    EntityCategory => "simulation_interfaces/msg/EntityCategory",
    TagsFilter => "simulation_interfaces/msg/TagsFilter",
    Bounds => "simulation_interfaces/msg/Bounds",
    EntityFilters => "simulation_interfaces/msg/EntityFilters",
    EntityState => "simulation_interfaces/msg/EntityState",
}
