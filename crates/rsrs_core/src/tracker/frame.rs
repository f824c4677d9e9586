//! Where a tracker's frame lies on the floor, which of its axes is which, and its unit.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use crate::robot::unicycle::Pose;

/// A tracker's frame on the floor.
///
/// A position is first read along the floor's axes, then put into metres, turned, and moved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrackerFrame {
    /// Where the tracker's origin is on the floor, x and y in metres.
    pub offset_m: [f64; 2],
    /// By how much the tracker's frame is turned on the floor, counterclockwise, in radians.
    pub rotation_rad: f64,
    /// Metres in one of the tracker's units: 0.001 for millimetres.
    pub scale: f64,
    /// Which of the tracker's axes are the floor's.
    pub axes: Axes,
}

impl Default for TrackerFrame {
    /// The floor's own.
    fn default() -> Self {
        Self { offset_m: [0.0; 2], rotation_rad: 0.0, scale: 1.0, axes: Axes::default() }
    }
}

/// Why a tracker's frame is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidFrame {
    /// An offset that is no place.
    #[error("`offset_m` is {0}, expected two numbers within ±{MOST_OFFSET_M} m")]
    Offset(String),
    /// More than a turn: degrees, most likely.
    #[error("`rotation_rad` is {0}, expected radians within ±2π (90° is 1.5708)")]
    Rotation(String),
    /// A scale that no unit has.
    #[error(
        "`scale` is {0}, expected metres in one of the tracker's units, {LEAST_SCALE} to \
         {MOST_SCALE} (0.001 for millimetres)"
    )]
    Scale(String),
}

/// No floor is larger.
const MOST_OFFSET_M: f64 = 10_000.0;
/// Micrometres.
const LEAST_SCALE: f64 = 1e-6;
/// Kilometres.
const MOST_SCALE: f64 = 1e3;

impl TrackerFrame {
    /// Whether poses are on the floor as they come.
    pub fn is_the_floors(&self) -> bool {
        *self == Self::default()
    }

    /// Looks whether there can be such a frame.
    pub fn check(&self) -> Result<(), InvalidFrame> {
        let [x_m, y_m] = self.offset_m;
        if ![x_m, y_m].iter().all(|offset_m| offset_m.abs() <= MOST_OFFSET_M) {
            return Err(InvalidFrame::Offset(format!("[{x_m}, {y_m}]")));
        }
        // NaN is in no range.
        let (turn_rad, scale) = (self.rotation_rad, self.scale);
        if !(-std::f64::consts::TAU..=std::f64::consts::TAU).contains(&turn_rad) {
            return Err(InvalidFrame::Rotation(turn_rad.to_string()));
        }
        if !(LEAST_SCALE..=MOST_SCALE).contains(&scale) {
            return Err(InvalidFrame::Scale(scale.to_string()));
        }
        Ok(())
    }

    /// A vector of the tracker along the floor's axes: a position in the tracker's units, or the
    /// vector part of a quaternion, whose scalar part stays as it is.
    pub fn upright(&self, vector: [f64; 3]) -> [f64; 3] {
        self.axes.of(vector)
    }

    /// A pose on the floor, out of one that is upright, in the tracker's units.
    ///
    /// # Example
    ///
    /// A tracker in millimetres whose origin is in a corner of the floor, turned by a quarter:
    ///
    /// ```
    /// use rsrs_core::robot::unicycle::Pose;
    /// use rsrs_core::tracker::TrackerFrame;
    ///
    /// let frame = TrackerFrame {
    ///     offset_m: [-2.0, -1.0],
    ///     rotation_rad: std::f64::consts::FRAC_PI_2,
    ///     scale: 0.001,
    ///     ..TrackerFrame::default()
    /// };
    /// let seen = Pose { x_m: 1500.0, y_m: -500.0, heading_rad: 0.0 };
    ///
    /// let pose = frame.on_floor(seen);
    ///
    /// assert!((pose.x_m - -1.5).abs() < 1e-12 && (pose.y_m - 0.5).abs() < 1e-12);
    /// assert_eq!(pose.heading_rad, std::f64::consts::FRAC_PI_2);
    /// ```
    pub fn on_floor(&self, seen: Pose) -> Pose {
        if self.is_the_floors() {
            return seen;
        }
        let (sine, cosine) = libm::sincos(self.rotation_rad);
        let (x_m, y_m) = (self.scale * seen.x_m, self.scale * seen.y_m);
        let heading_rad = seen.heading_rad + self.rotation_rad;
        Pose {
            x_m: cosine * x_m - sine * y_m + self.offset_m[0],
            y_m: sine * x_m + cosine * y_m + self.offset_m[1],
            heading_rad: libm::atan2(libm::sin(heading_rad), libm::cos(heading_rad)),
        }
    }
}

/// Which of the tracker's axes, and which way along it, each axis of the floor is: x, y, and up.
///
/// Only right-handed ones exist: the others are mirrors, in which robots turn the wrong way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "[String; 3]", into = "[String; 3]")]
pub struct Axes([TrackerAxis; 3]);

/// One of the tracker's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TrackerAxis {
    /// 0 is x.
    index: usize,
    /// Whether the floor's axis points against it.
    is_reversed: bool,
}

/// Why three words are no axes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidAxes {
    /// A word that names no axis.
    #[error("axis `{0}`, expected x, y, z, -x, -y or -z")]
    NoAxis(String),
    /// An axis that two of the floor's are to be.
    #[error("axes [{0}] have one of them twice, expected each of x, y and z once")]
    Twice(String),
    /// A mirror.
    #[error(
        "axes [{0}] are left-handed, in which robots turn the wrong way: turn the sign of one of them \
         (a tracker with y up has [x, -z, y])"
    )]
    LeftHanded(String),
}

impl Default for Axes {
    /// The floor's own.
    fn default() -> Self {
        Self([0, 1, 2].map(|index| TrackerAxis { index, is_reversed: false }))
    }
}

impl Axes {
    fn of(&self, vector: [f64; 3]) -> [f64; 3] {
        self.0.map(|axis| {
            let along = vector[axis.index];
            if axis.is_reversed { -along } else { along }
        })
    }

    /// 1 for axes that can be turned into the floor's, -1 for their mirror image, 0 if one is there
    /// twice.
    fn handedness(&self) -> i32 {
        let [x, y, up] = self.0.map(|axis| axis.index);
        let sign: i32 = self.0.iter().map(|axis| if axis.is_reversed { -1 } else { 1 }).product();
        match [x, y, up] {
            [0, 1, 2] | [1, 2, 0] | [2, 0, 1] => sign,
            [0, 2, 1] | [2, 1, 0] | [1, 0, 2] => -sign,
            _ => 0,
        }
    }
}

impl FromStr for TrackerAxis {
    type Err = InvalidAxes;

    fn from_str(word: &str) -> Result<Self, InvalidAxes> {
        let (is_reversed, letter) = match word.strip_prefix('-') {
            Some(letter) => (true, letter),
            None => (false, word.strip_prefix('+').unwrap_or(word)),
        };
        let index = ["x", "y", "z"].iter().position(|axis| *axis == letter);
        let index = index.ok_or_else(|| InvalidAxes::NoAxis(word.to_owned()))?;
        Ok(Self { index, is_reversed })
    }
}

impl fmt::Display for TrackerAxis {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.is_reversed { "-" } else { "" };
        write!(formatter, "{sign}{}", ["x", "y", "z"][self.index])
    }
}

impl TryFrom<[String; 3]> for Axes {
    type Error = InvalidAxes;

    fn try_from(words: [String; 3]) -> Result<Self, InvalidAxes> {
        let [x, y, up] = &words;
        let axes = Self([x.parse()?, y.parse()?, up.parse()?]);
        let found = words.join(", ");
        match axes.handedness() {
            1 => Ok(axes),
            0 => Err(InvalidAxes::Twice(found)),
            _ => Err(InvalidAxes::LeftHanded(found)),
        }
    }
}

impl From<Axes> for [String; 3] {
    fn from(axes: Axes) -> Self {
        axes.0.map(|axis| axis.to_string())
    }
}

impl fmt::Display for Axes {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, up] = self.0;
        write!(formatter, "[{x}, {y}, {up}]")
    }
}

impl JsonSchema for Axes {
    fn schema_name() -> Cow<'static, str> {
        "Axes".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let axis = json_schema!({"type": "string", "enum": ["x", "y", "z", "-x", "-y", "-z"]});
        json_schema!({"type": "array", "items": axis, "minItems": 3, "maxItems": 3})
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    /// Axes change no bit but signs.
    fn bits(vector: [f64; 3]) -> [u64; 3] {
        vector.map(|number| (number + 0.0).to_bits())
    }

    fn axes(words: [&str; 3]) -> Result<Axes, InvalidAxes> {
        words.map(str::to_owned).try_into()
    }

    #[test]
    fn twenty_four_orders_of_axes_are_right_handed_and_every_other_one_is_refused() {
        let words = ["x", "y", "z", "-x", "-y", "-z"];
        let mut n_right = 0;
        for x in words {
            for y in words {
                for up in words {
                    let Ok(axes) = axes([x, y, up]) else { continue };
                    n_right += 1;
                    let [e_x, e_y, e_up] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                        .map(|vector| axes.of(vector));
                    let cross = [
                        e_x[1] * e_y[2] - e_x[2] * e_y[1],
                        e_x[2] * e_y[0] - e_x[0] * e_y[2],
                        e_x[0] * e_y[1] - e_x[1] * e_y[0],
                    ];
                    assert_eq!(bits(cross), bits(e_up), "{axes}");
                }
            }
        }
        assert_eq!(n_right, 24);
    }

    #[test]
    fn axes_that_are_none_or_a_mirror_are_refused_with_what_to_write() {
        let text = |words| axes(words).unwrap_err().to_string();

        assert!(text(["x", "z", "y"]).contains("[x, z, y] are left-handed"));
        assert!(text(["x", "z", "y"]).ends_with("(a tracker with y up has [x, -z, y])"));
        assert!(text(["x", "y", "-z"]).contains("left-handed"));
        assert!(text(["x", "x", "z"]).contains("each of x, y and z once"));
        assert!(text(["x", "y", "up"]).contains("axis `up`"));
        assert_eq!(axes(["x", "-z", "+y"]).unwrap().to_string(), "[x, -z, y]");
    }

    #[test]
    fn a_tracker_with_y_up_is_laid_on_the_floor() {
        let frame = TrackerFrame { axes: axes(["x", "-z", "y"]).unwrap(), ..Default::default() };

        // 2 along the tracker's x, 3 towards whoever looks at it, 0.1 above the floor.
        assert_eq!(bits(frame.upright([2.0, 0.1, 3.0])), bits([2.0, -3.0, 0.1]));
        // A turn about the tracker's vertical axis is one about the floor's.
        let turn_rad = 0.7;
        let about_y = [0.0, libm::sin(turn_rad / 2.0), 0.0];
        assert_eq!(bits(frame.upright(about_y)), bits([0.0, 0.0, libm::sin(turn_rad / 2.0)]));
    }

    #[test]
    fn millimetres_are_scaled_before_they_are_turned_and_moved() {
        let frame = TrackerFrame {
            offset_m: [1.0, 2.0],
            rotation_rad: FRAC_PI_2,
            scale: 0.001,
            ..Default::default()
        };

        let pose = frame.on_floor(Pose { x_m: 1000.0, y_m: 0.0, heading_rad: PI });

        assert!((pose.x_m - 1.0).abs() < 1e-12 && (pose.y_m - 3.0).abs() < 1e-12, "{pose:?}");
        assert!((pose.heading_rad - -FRAC_PI_2).abs() < 1e-12, "it stays within half a turn");
    }

    #[test]
    fn poses_in_the_floors_own_frame_keep_every_bit() {
        let pose = Pose { x_m: 0.1, y_m: -0.3, heading_rad: 4.0 };

        assert_eq!(TrackerFrame::default().on_floor(pose), pose);
        let vector = [0.1, -0.2, 0.3];
        assert_eq!(bits(TrackerFrame::default().upright(vector)), bits(vector));
    }

    #[test]
    fn frames_that_cannot_be_are_refused() {
        let check = |frame: TrackerFrame| frame.check().unwrap_err().to_string();
        let default = TrackerFrame::default;

        assert!(
            check(TrackerFrame { rotation_rad: 90.0, ..default() }).contains("(90° is 1.5708)")
        );
        assert!(check(TrackerFrame { scale: 0.0, ..default() }).contains("`scale` is 0"));
        assert!(check(TrackerFrame { scale: f64::NAN, ..default() }).contains("`scale` is NaN"));
        assert!(check(TrackerFrame { scale: -1.0, ..default() }).contains("`scale` is -1"));
        let nowhere = [f64::INFINITY, 0.0];
        assert!(check(TrackerFrame { offset_m: nowhere, ..default() }).contains("[inf, 0]"));
    }

    #[test]
    fn a_frame_reads_back_to_the_bit_and_one_with_another_key_does_not() {
        let frame = TrackerFrame {
            offset_m: [0.1, -0.2],
            rotation_rad: 0.3,
            scale: 0.001,
            axes: axes(["z", "x", "y"]).unwrap(),
        };

        let text = serde_json::to_string(&frame).unwrap();

        assert!(text.contains("\"axes\":[\"z\",\"x\",\"y\"]"), "{text}");
        assert_eq!(serde_json::from_str::<TrackerFrame>(&text).unwrap(), frame);
        assert!(serde_json::from_str::<TrackerFrame>("{\"offset\": 1}").is_err());
        assert!(serde_json::from_str::<TrackerFrame>("{\"axes\": [\"x\", \"z\", \"y\"]}").is_err());
    }
}
