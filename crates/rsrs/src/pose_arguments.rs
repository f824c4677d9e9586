//! Where poses come from, on the command line.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rsrs_core::robot::pose_source::PoseSource;

/// Parses where poses come from; arrays also as they were spelt before files could name them.
pub fn pose_sources() -> impl TypedValueParser<Value = PoseSource> {
    let value = |source: PoseSource| {
        let help = match source {
            PoseSource::Odom => "`/<robot>/odom`",
            PoseSource::Pose => "`/<robot>/pose`",
            PoseSource::NamedPoses => {
                "A tracker's `NamedPoseArray`, on `/poses` if there are several"
            }
            PoseSource::PoseArray => "A tracker's `PoseArray`, on `/poses` if there are several",
            PoseSource::Tf => "`/tf`",
        };
        let earlier = match source {
            PoseSource::NamedPoses => Some("named-poses"),
            PoseSource::PoseArray => Some("pose-array"),
            PoseSource::Odom | PoseSource::Pose | PoseSource::Tf => None,
        };
        PossibleValue::new(source.key()).aliases(earlier).help(help)
    };
    let parser = PossibleValuesParser::new(PoseSource::ALL.map(value));
    parser.map(|key| {
        let key = key.replace('-', "_");
        PoseSource::from_key(&key).expect("the parser takes no other words")
    })
}
