//! Poses and commands straight out of their bytes.
//!
//! Nine tenths of an odometry are covariances that the judge does not ask for. What is not as
//! expected to the last byte is left to the decoder of all messages.

use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::cdr::ENCAPSULATION;
use rsrs_msgs::geometry_msgs::{Quaternion, Twist, TwistStamped, Vector3};
use rsrs_msgs::std_msgs::Header;

use crate::trajectory::pose::RawPose;

/// Two matrices of covariances and a velocity stand behind the pose in an odometry.
const BEHIND_ODOMETRY: usize = 8 * (36 + 6 + 36);

/// Bytes that may follow a message, to fill the last group of four.
const MAX_PADDING: usize = 3;

/// The pose in a `nav_msgs/Odometry`.
pub fn odometry(bytes: &[u8]) -> Option<RawPose> {
    let mut fields = Fields::of(bytes)?;
    let stamp = fields.header()?;
    fields.text()?;
    let raw = fields.pose(stamp)?;
    fields.take(BEHIND_ODOMETRY)?;
    fields.is_done().then_some(raw)
}

/// The pose in a `geometry_msgs/PoseStamped`.
pub fn pose_stamped(bytes: &[u8]) -> Option<RawPose> {
    let mut fields = Fields::of(bytes)?;
    let stamp = fields.header()?;
    let raw = fields.pose(stamp)?;
    fields.is_done().then_some(raw)
}

/// A `geometry_msgs/TwistStamped`, without the name of its frame.
pub fn twist_stamped(bytes: &[u8]) -> Option<TwistStamped> {
    let mut fields = Fields::of(bytes)?;
    let header = Header { stamp: fields.header()?, frame_id: String::new() };
    let twist = fields.twist()?;
    fields.is_done().then_some(TwistStamped { header, twist })
}

/// A `geometry_msgs/Twist`.
pub fn twist(bytes: &[u8]) -> Option<Twist> {
    let mut fields = Fields::of(bytes)?;
    let twist = fields.twist()?;
    fields.is_done().then_some(twist)
}

/// Fields of a little-endian message that are taken from the front.
struct Fields<'a> {
    body: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    fn of(bytes: &'a [u8]) -> Option<Self> {
        let (encapsulation, body) = bytes.split_at_checked(ENCAPSULATION.len())?;
        (encapsulation[..2] == ENCAPSULATION[..2]).then_some(Self { body, at: 0 })
    }

    fn take(&mut self, n_bytes: usize) -> Option<&'a [u8]> {
        let taken = self.body.get(self.at..self.at.checked_add(n_bytes)?)?;
        self.at += n_bytes;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        self.at = self.at.next_multiple_of(4);
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    fn f64s<const N: usize>(&mut self) -> Option<[f64; N]> {
        self.at = self.at.next_multiple_of(8);
        let (numbers, _) = self.take(8 * N)?.as_chunks::<8>();
        let mut read = [0.0; N];
        for (read, number) in read.iter_mut().zip(numbers) {
            *read = f64::from_le_bytes(*number);
        }
        Some(read)
    }

    /// Passes over a plain text.
    fn text(&mut self) -> Option<()> {
        let length = usize::try_from(self.u32()?).ok()?;
        let (zero, text) = self.take(length)?.split_last()?;
        (*zero == 0 && text.is_ascii() && !text.contains(&0)).then_some(())
    }

    /// Passes over a header but for its stamp.
    fn header(&mut self) -> Option<Time> {
        let (sec, nanosec) = (self.u32()?.cast_signed(), self.u32()?);
        self.text()?;
        Some(Time { sec, nanosec })
    }

    fn pose(&mut self, stamp: Time) -> Option<RawPose> {
        let [x, y, z, qx, qy, qz, w] = self.f64s()?;
        let orientation = Quaternion { x: qx, y: qy, z: qz, w };
        Some(RawPose::nameless(stamp, Vector3 { x, y, z }, orientation))
    }

    fn twist(&mut self) -> Option<Twist> {
        let [x, y, z, around_x, around_y, around_z] = self.f64s()?;
        let angular = Vector3 { x: around_x, y: around_y, z: around_z };
        Some(Twist { linear: Vector3 { x, y, z }, angular })
    }

    fn is_done(&self) -> bool {
        self.body.len() - self.at <= MAX_PADDING
    }
}

#[cfg(test)]
mod tests {
    use rsrs_msgs::cdr;
    use rsrs_msgs::geometry_msgs::{Point, PoseStamped};
    use rsrs_msgs::nav_msgs::Odometry;

    use super::*;
    use crate::trajectory::pose;

    fn header() -> Header {
        Header { stamp: Time { sec: 7, nanosec: 9 }, frame_id: "map".to_owned() }
    }

    #[test]
    fn messages_give_the_same_as_the_decoder_and_no_cut_one_gives_anything() {
        let mut odometry = Odometry { header: header(), ..Odometry::default() };
        odometry.child_frame_id = "robot_12/base_link".to_owned();
        odometry.pose.pose.position = Point { x: 1.5, y: -2.0, z: 3.0 };
        odometry.pose.pose.orientation = Quaternion { x: 0.0, y: 0.0, z: 0.6, w: 0.8 };
        let stamped = PoseStamped { header: header(), pose: odometry.pose.pose };
        let linear = Vector3 { x: 0.15, y: 0.0, z: 0.0 };
        let angular = Vector3 { x: 0.0, y: 0.0, z: -0.75 };
        let twist = Twist { linear, angular };
        let command = TwistStamped { header: header(), twist };

        let bytes = cdr::encode(&odometry);
        let expected = pose::of_odometry("", odometry).sample(3).unwrap();
        assert_eq!(super::odometry(&bytes).unwrap().sample(3).unwrap(), expected);
        assert!(super::odometry(&bytes[..bytes.len() - 1]).is_none());
        let bytes = cdr::encode(&stamped);
        assert_eq!(pose_stamped(&bytes).unwrap().sample(3).unwrap(), expected);
        assert!(pose_stamped(&[&bytes[..], &[0; 4]].concat()).is_none());
        let bytes = cdr::encode(&command);
        let read = twist_stamped(&bytes).unwrap();
        assert_eq!((read.header.stamp, read.twist), (command.header.stamp, twist));
        assert!(twist_stamped(&bytes[..40]).is_none());
        assert_eq!(super::twist(&cdr::encode(&twist)), Some(twist));
    }
}
