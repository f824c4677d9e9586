//! Which of several machines a robot's pose is taken from.

use std::collections::BTreeMap;

use crate::robot::unicycle::Pose;

/// A machine that has sent no pose of a robot for so long gives way to another one, in nanoseconds.
pub const HANDOVER_NS: u64 = 200_000_000;

/// So many poses in a row that lie apart are no chance.
const MIN_APART: u32 = 5;

/// The machines that see robots, of which one counts for each robot at a time.
///
/// The machine in use is kept while its poses are fresh, so that two machines that see one robot do not
/// take turns; when it is silent, whichever has the freshest pose takes over.
#[derive(Clone, Debug)]
pub struct HandOver<M> {
    radius_m: f64,
    in_use: BTreeMap<String, InUse<M>>,
}

/// The machine that counts for a robot.
#[derive(Clone, Copy, Debug)]
struct InUse<M> {
    machine: M,
    at_ns: u64,
    pose: Pose,
    /// Poses of another one in a row that lay elsewhere, with one of this machine between any two: one
    /// that has just ended is in no disagreement with what follows it.
    n_apart: u32,
    /// Whether it was received since the last of these.
    is_heard: bool,
}

/// What becomes of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Taken<M> {
    /// It counts.
    Used,
    /// The machine in use is fresh, and this is another one that sees the robot about there.
    Spare,
    /// The machine in use is fresh, and this one sees the robot elsewhere.
    Apart {
        /// How far, in metres.
        by_m: f64,
        /// The one in use.
        other: M,
    },
}

impl<M: Copy + PartialEq> HandOver<M> {
    /// Before anything was received from a machine. Poses of two machines that agree are at most the
    /// radius of a robot's body apart.
    pub fn new(radius_m: f64) -> Self {
        Self { radius_m, in_use: BTreeMap::new() }
    }

    /// Takes a pose of a robot from a machine, received at `at_ns` on one clock for all machines.
    pub fn take(&mut self, robot: &str, machine: M, at_ns: u64, pose: Pose) -> Taken<M> {
        let Some(used) = self.in_use.get_mut(robot) else {
            let first = InUse { machine, at_ns, pose, n_apart: 0, is_heard: true };
            self.in_use.insert(robot.to_owned(), first);
            return Taken::Used;
        };
        if used.machine == machine || at_ns.saturating_sub(used.at_ns) > HANDOVER_NS {
            let n_apart = if used.machine == machine { used.n_apart } else { 0 };
            *used = InUse { machine, at_ns, pose, n_apart, is_heard: true };
            return Taken::Used;
        }
        let by_m = libm::hypot(pose.x_m - used.pose.x_m, pose.y_m - used.pose.y_m);
        if by_m <= self.radius_m {
            used.n_apart = 0;
            return Taken::Spare;
        }
        if std::mem::take(&mut used.is_heard) {
            used.n_apart = used.n_apart.saturating_add(1);
        }
        if used.n_apart < MIN_APART {
            return Taken::Spare;
        }
        Taken::Apart { by_m, other: used.machine }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn at(x_m: f64) -> Pose {
        Pose { x_m, ..Pose::default() }
    }

    #[test]
    fn the_machine_in_use_is_kept_while_it_is_fresh_and_the_other_one_takes_over_when_it_is_silent()
    {
        let mut machines = HandOver::new(0.1);

        assert_eq!(machines.take("r", 'a', 0, at(0.0)), Taken::Used);
        assert_eq!(machines.take("r", 'b', 10 * MS, at(0.01)), Taken::Spare);
        assert_eq!(machines.take("r", 'a', 100 * MS, at(0.02)), Taken::Used);
        assert_eq!(machines.take("r", 'b', 299 * MS, at(0.03)), Taken::Spare);
        assert_eq!(machines.take("r", 'b', 301 * MS, at(0.03)), Taken::Used);
        assert_eq!(machines.take("r", 'a', 302 * MS, at(0.03)), Taken::Spare);
        assert_eq!(machines.take("another", 'a', 302 * MS, at(5.0)), Taken::Used);
    }

    #[test]
    fn machines_that_see_a_robot_in_two_places_are_found_and_a_single_outlier_is_not() {
        let mut machines = HandOver::new(0.1);
        let mut both = |step: u64, b_m: f64| {
            machines.take("r", 'a', step * 10 * MS, at(0.0));
            machines.take("r", 'b', (step * 10 + 5) * MS, at(b_m))
        };

        for step in 0..20 {
            let outlier = if step == 7 { 3.0 } else { 0.05 };
            assert_eq!(both(step, outlier), Taken::Spare, "step {step}");
        }
        let apart: Vec<_> = (20..26).map(|step| both(step, 0.31)).collect();

        assert_eq!(apart[..4], [Taken::Spare; 4]);
        assert_eq!(apart[4..], [Taken::Apart { by_m: 0.31, other: 'a' }; 2]);
    }

    #[test]
    fn a_machine_that_has_ended_is_in_no_disagreement_with_the_one_that_follows() {
        let mut machines = HandOver::new(0.1);
        machines.take("r", 'a', 0, at(0.0));

        let next: Vec<_> =
            (1..20).map(|step| machines.take("r", 'b', step * MS, at(2.0))).collect();

        assert_eq!(next, [Taken::Spare; 19]);
    }
}
