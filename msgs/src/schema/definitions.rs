//! The table behind [`super::schema_text`]: one row per type, its text embedded from the file.

/// A type.
pub struct Definition {
    /// Its full name.
    pub type_name: &'static str,
    /// Its own text, without the types in it.
    pub text: &'static str,
    /// RIHS01, by REP 2016; held against an independent implementation in
    /// `tests/messages/oracle.rs`.
    pub hash: &'static str,
}

/// States the types of each package, with the folder of their files in this crate and their hashes
/// behind `RIHS01_`.
macro_rules! definitions {
    ($($package:literal in $folder:literal { $($name:literal: $hash:literal,)+ })+) => {
        &[$($(Definition {
            type_name: concat!($package, "/msg/", $name),
            text: include_str!(concat!("../../", $folder, "/", $name, ".msg")),
            hash: concat!("RIHS01_", $hash),
        },)+)+]
    };
}

/// All types, sorted by name.
pub const DEFINITIONS: &[Definition] = definitions! {
    "builtin_interfaces" in "definitions/builtin_interfaces/msg" {
        "Duration": "e8d009f659816f758b75334ee1a9ca5b5c0b859843261f14c7f937349599d93b",
        "Time": "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
    }
    "diagnostic_msgs" in "definitions/diagnostic_msgs/msg" {
        "DiagnosticArray": "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
        "DiagnosticStatus": "b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4",
        "KeyValue": "d68081eaa540288c5440753baecef0c4e16e81a5f78ad68902ded5100413bb42",
    }
    "geometry_msgs" in "definitions/geometry_msgs/msg" {
        "Point": "6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881",
        "Pose": "d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa",
        "PoseArray": "af0cc36d190e104d546d168d6b39df04fa4b4ccecf59cb4c9ed328d3d5004aa0",
        "PoseStamped": "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
        "PoseWithCovariance": "9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb",
        "Quaternion": "8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684",
        "Transform": "beb83fbe698636351461f6f35d1abb20010c43d55374d81bd041f1ba2581fddc",
        "TransformStamped": "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206",
        "Twist": "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
        "TwistStamped": "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
        "TwistWithCovariance": "49f574f033f095d8b6cd1beaca5ca7925e296e84af1716d16c89d38b059c8c18",
        "Vector3": "cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d",
    }
    "motion_capture_tracking_interfaces" in "definitions/motion_capture_tracking_interfaces/msg" {
        "NamedPose": "4cf25ae0f0e85da6b57344b4e95ffd3856c24b20655c53b786c6e87a7cb67157",
        "NamedPoseArray": "d4c89ff7e0670d5f83b0322513e1c8dc2c3b279a68495daa026c352f0027e5f2",
    }
    "nav_msgs" in "definitions/nav_msgs/msg" {
        "Odometry": "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    }
    "rcl_interfaces" in "definitions/rcl_interfaces/msg" {
        "FloatingPointRange": "e6af23a23c177fee5f3075c8b1e435162a9b63c863d78c06017460b49684262d",
        "IntegerRange": "f7b7fdc0f65f07702e099218e13288c3963bcb9345bde78b560e6cd19800fc5a",
        "ListParametersResult": "237ae3428413dcbcfb452b510c42355f3a2b021dc091afa3e18526d57022f1cd",
        "Log": "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
        "Parameter": "ddfe6442cffc462317adb5c92536a7b6dd55858c5c3e1e328165a6b73c2831af",
        "ParameterDescriptor": "52175dbfda6c51153101d33d2a9da05743f66f02d5ab2ca9ec4709b46b73d704",
        "ParameterEvent": "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204",
        "ParameterValue": "115fc089a387e23c7ecd3525c9189c379109119d6ab82e8dfbde0fdf6a7f9b68",
        "SetParametersResult": "cfcc0fb0371ee5159b403960ef4300f8f9d2f1fd6117c8666b7f9654d528a9b1",
    }
    "rosgraph_msgs" in "definitions/rosgraph_msgs/msg" {
        "Clock": "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    }
    "rsrs_msgs" in "msg" {
        "EStopLock": "7bcbfdcd20b88308c5684558082ee9b7cbd48247b202870652fda74527831afa",
        "EStopLocks": "6d564df3457844c82e9ce9dca722a911112715cae2255329c6f3e79556f19434",
        "Recorded": "90ae77c635bda3eeff44b90488e6843a83f6c0b87d51f650d22db1f683eaa4bb",
        "RobotStatus": "b6b6f18154ef959131ac7e6e5565b9caf08884e6c17cca484d32ab84437910ae",
        "RunLease": "bf84de2a9cf3ec29d752f4bfa9e32dcf0f96f9b71e5f5fe3c2bd3c30b6041463",
        "WorldDigest": "263acfc2b0a3d4e9721867a8f81baf10efa96839db306a44107e2c9bcdb2b482",
    }
    "sensor_msgs" in "definitions/sensor_msgs/msg" {
        "CompressedImage": "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a",
        "LaserScan": "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
        "Range": "b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
    }
    "std_msgs" in "definitions/std_msgs/msg" {
        "Bool": "feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
        "ColorRGBA": "77a7a5b9ae477306097665106e0413ba74440245b1f3d0c6d6405fe5c7813fe8",
        "Header": "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
        "String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    }
    "tf2_msgs" in "definitions/tf2_msgs/msg" {
        "TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    }
    "visualization_msgs" in "definitions/visualization_msgs/msg" {
        "Marker": "45b13ccf791f225962bf74e746f9644518855d783a6f42ba0cc14fde2b4f3ce0",
        "MarkerArray": "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
        "MeshFile": "7710ece15a148fb7c9b546364cfb215bb06098087bd6394fe5b73a493508f8c4",
        "UVCoordinate": "f27f7ed21fe360c6066944f856b801a0c0d1e94e815b6886444b42d90b196a26",
    }
};
