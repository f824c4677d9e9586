//! All types of messages, for tests that hold each of them against something.

use rsrs_msgs::cdr::CdrError;
use rsrs_msgs::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, FloatingPointRange,
    GetParameterTypesRequest, GetParameterTypesResponse, GetParametersRequest,
    GetParametersResponse, IntegerRange, ListParametersRequest, ListParametersResponse,
    ListParametersResult, Log, Parameter, ParameterDescriptor, ParameterEvent, ParameterValue,
    SetParametersAtomicallyRequest, SetParametersAtomicallyResponse, SetParametersRequest,
    SetParametersResponse, SetParametersResult,
};
use rsrs_msgs::rsrs::{EStopLock, EStopLocks, Recorded, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::{
    RosMessage, builtin_interfaces, cdr, diagnostic_msgs, geometry_msgs,
    motion_capture_tracking_interfaces, nav_msgs, rosgraph_msgs, sensor_msgs,
    simulation_interfaces as simulation, std_msgs, tf2_msgs, visualization_msgs,
};

use crate::sampler;

/// A type of messages, in functions that are the same for all types.
pub struct MessageType {
    pub name: &'static str,
    /// Makes up a message from a seed, as JSON and as CDR.
    pub sample: fn(u64) -> (String, Vec<u8>),
    /// Decodes a message and encodes it again.
    pub recode: fn(&[u8]) -> Result<Vec<u8>, CdrError>,
}

impl MessageType {
    fn new<M: RosMessage>() -> Self {
        Self {
            name: M::TYPE_NAME,
            sample: |seed| {
                let message: M = sampler::sample(seed);
                let json = serde_json::to_string(&message);
                (json.expect("messages have JSON values only"), cdr::encode(&message))
            },
            recode: |bytes| cdr::decode::<M>(bytes).map(|message| cdr::encode(&message)),
        }
    }
}

macro_rules! message_types {
    ($($message:ty),+ $(,)?) => { vec![$(MessageType::new::<$message>()),+] };
}

/// All types.
pub fn all_types() -> Vec<MessageType> {
    use diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
    use geometry_msgs::{
        Point, Pose, PoseArray, PoseStamped, PoseWithCovariance, Quaternion, Transform,
        TransformStamped, Twist, TwistStamped, TwistWithCovariance, Vector3,
    };
    let mut types = message_types![
        builtin_interfaces::Time,
        builtin_interfaces::Duration,
        std_msgs::Bool,
        std_msgs::ColorRGBA,
        std_msgs::Header,
        std_msgs::String,
        Vector3,
        Twist,
        TwistStamped,
        Point,
        Quaternion,
        Pose,
        PoseArray,
        PoseStamped,
        PoseWithCovariance,
        TwistWithCovariance,
        Transform,
        TransformStamped,
        motion_capture_tracking_interfaces::NamedPose,
        motion_capture_tracking_interfaces::NamedPoseArray,
        nav_msgs::Odometry,
        rosgraph_msgs::Clock,
        sensor_msgs::CompressedImage,
        sensor_msgs::LaserScan,
        sensor_msgs::Range,
        tf2_msgs::TFMessage,
        visualization_msgs::Marker,
        visualization_msgs::MarkerArray,
        visualization_msgs::MeshFile,
        visualization_msgs::UVCoordinate,
        DiagnosticArray,
        DiagnosticStatus,
        KeyValue,
        Log,
        Parameter,
        ParameterEvent,
        ParameterValue,
        ParameterDescriptor,
        FloatingPointRange,
        IntegerRange,
        SetParametersResult,
        ListParametersResult,
        RunLease,
        RobotStatus,
        WorldDigest,
        Recorded,
        EStopLock,
        EStopLocks,
        DescribeParametersRequest,
        GetParameterTypesRequest,
        GetParameterTypesResponse,
        GetParametersRequest,
        GetParametersResponse,
        ListParametersRequest,
        ListParametersResponse,
        SetParametersAtomicallyRequest,
        SetParametersAtomicallyResponse,
        SetParametersRequest,
        SetParametersResponse,
        DescribeParametersResponse,
    ];
    types.extend(types_of_simulators());
    types
}

/// What simulators are asked, and what they answer.
fn types_of_simulators() -> Vec<MessageType> {
    message_types![
        geometry_msgs::Accel,
        simulation::Result,
        simulation::SimulatorFeatures,
        simulation::SimulationState,
        simulation::EntityCategory,
        simulation::TagsFilter,
        simulation::Bounds,
        simulation::EntityFilters,
        simulation::EntityState,
        simulation::GetSimulatorFeaturesRequest,
        simulation::GetSimulatorFeaturesResponse,
        simulation::GetSimulationStateRequest,
        simulation::GetSimulationStateResponse,
        simulation::SetSimulationStateRequest,
        simulation::SetSimulationStateResponse,
        simulation::ResetSimulationRequest,
        simulation::ResetSimulationResponse,
        simulation::StepSimulationRequest,
        simulation::StepSimulationResponse,
        simulation::GetEntitiesRequest,
        simulation::GetEntitiesResponse,
        simulation::GetEntitiesStatesRequest,
        simulation::GetEntitiesStatesResponse,
        simulation::GetEntityStateRequest,
        simulation::GetEntityStateResponse,
        simulation::SetEntityStateRequest,
        simulation::SetEntityStateResponse,
    ]
}
