//! The settings in which a robot is given its chance where nobody names others: those of `init`.

use rsrs_core::conditions::{PLACEMENT_OVER_RANGE, Walls};
use rsrs_core::diagram::sweep_file::{Axes, Fixed, SweepFile};
use rsrs_core::judge::behaviour::named::NamedBehaviour;
use rsrs_core::numerals::significant;
use rsrs_core::quantity::{Axis, AxisValues, Cell};
use rsrs_core::robot::harsher::Harsher;
use rsrs_core::robot::profile::RobotProfile;

/// Where a swarm is.
#[derive(Clone, Copy)]
pub struct Floor {
    /// Side of the arena, in metres.
    pub arena_m: f64,
    /// Radius of the disc in which robots start, in metres.
    pub placement_m: f64,
}

/// Side of the arena over a robot's range: never reached in a run.
const ARENA_OVER_RANGE: f64 = 20.0;
/// Radius of the disc over the side of the arena, at most: robots do not start at its walls.
pub const PLACEMENT_OVER_ARENA: f64 = 0.4;
/// Radius of a crowded disc over that of a body and the root of the number of robots.
const CROWDED: f64 = 3.0;

impl Floor {
    /// The disc follows from the range, or where bodies do not fit into that, from their size; it
    /// lies within the arena. Without `arena_m` that is so large that its walls are not reached.
    pub fn new(range_m: f64, (n_robots, radius_m): (usize, f64), arena_m: Option<f64>) -> Self {
        let from_m = range_m.max(CROWDED * radius_m * (n_robots as f64).sqrt());
        let arena_m = arena_m.unwrap_or_else(|| significant(ARENA_OVER_RANGE * from_m));
        let placement_m = significant(PLACEMENT_OVER_RANGE * from_m);
        let placement_m = placement_m.min(significant(PLACEMENT_OVER_ARENA * arena_m));
        Self { arena_m, placement_m }
    }
}

/// What speeds and turning rates follow from.
#[derive(Clone, Copy)]
pub struct Reach {
    /// Fastest safe command, in metres per second.
    pub speed_m_s: f64,
    /// Fastest safe turn, in radians per second.
    pub turn_rate_rad_s: f64,
    /// Range of the sensor, in metres.
    pub range_m: f64,
    /// Radius of the body, in metres.
    pub radius_m: f64,
}

/// Radii of the circles that robots drive, speed over turning rate, over their range: what mills lies
/// between.
const CIRCLES_OVER_RANGE: [f64; 2] = [0.13, 0.65];
/// A circle is at least so many bodies wide ...
const LEAST_CIRCLE_OVER_RADIUS: f64 = 1.0;
/// ... and fits so often into the arena.
const CIRCLE_OVER_ARENA: f64 = 0.25;
/// Slowest speed over the fastest; the widest circle is driven at twice that.
const SLOWEST: f64 = 0.2;
/// Speeds and turning rates.
pub const STEPS: [usize; 2] = [8, 10];

impl Reach {
    /// Speeds and turning rates, each the same multiple of the one before: robots that mill drive circles
    /// of about their sensor's size, and speed over turning rate is the radius.
    pub fn axes(self, floor: Floor, [n_speeds, n_turn_rates]: [usize; 2]) -> [Vec<f64>; 2] {
        let Self { speed_m_s, turn_rate_rad_s, range_m, radius_m } = self;
        let widest_m = (CIRCLES_OVER_RANGE[1] * range_m).min(CIRCLE_OVER_ARENA * floor.arena_m);
        let least_m = (CIRCLES_OVER_RANGE[0] * range_m).max(LEAST_CIRCLE_OVER_RADIUS * radius_m);
        let fastest_rad_s = significant(speed_m_s / least_m).min(turn_rate_rad_s);
        let slowest_rad_s = (2.0 * SLOWEST * speed_m_s / widest_m).min(0.5 * fastest_rad_s);
        let speeds = spread([SLOWEST * speed_m_s, speed_m_s], n_speeds);
        [speeds, spread([slowest_rad_s, fastest_rad_s], n_turn_rates)]
    }
}

/// So many values, each the same multiple of the one before; the greatest as it is.
fn spread([least, most]: [f64; 2], n: usize) -> Vec<f64> {
    let ratio = libm::pow(most / least, 1.0 / (n as f64 - 1.0));
    let value = |step: usize| significant(least * libm::pow(ratio, step as f64)).min(most);
    let mut values: Vec<f64> = (0..n - 1).map(value).chain([most]).collect();
    values.dedup();
    values
}

/// Numbers of robots where nobody says how many there are, and the steps then.
const NUMBERS: [usize; 7] = [3, 4, 5, 6, 7, 9, 12];
const FEWER_STEPS: [usize; 2] = [6, 8];
/// Runs of every cell, in each world: as many as `init` writes down, or fewer where there are more cells.
const REPLICATES: u64 = 100;
const FEWER_REPLICATES: u64 = 40;
/// Enough time for a mill to form and to last, in seconds.
const DURATION_S: f64 = 300.0;
const SEED: u64 = 1;

/// The settings of a robot: speeds and turning rates within its limits and what its wheels can do, so many
/// robots, or a few numbers of them, from the disc of the paper.
pub fn of_robot(profile: &RobotProfile, robots: Option<usize>) -> SweepFile {
    let (numbers, steps, replicates) = match robots {
        Some(robots) => (vec![robots], STEPS, REPLICATES),
        None => (NUMBERS.to_vec(), FEWER_STEPS, FEWER_REPLICATES),
    };
    let (speed, turn) = (profile.actuation.speed.limits_m_s, profile.actuation.turn.limits_rad_s);
    let (range_m, radius_m) =
        (profile.capability(Axis::Range).unwrap_or(1.0), profile.body.radius_m);
    let most = numbers[numbers.len() - 1];
    let floor = Floor::new(range_m, (most, radius_m), None);
    let reach = Reach { speed_m_s: speed[1], turn_rate_rad_s: turn[1], range_m, radius_m };
    let within = |values: Vec<f64>, [least, most]: [f64; 2]| {
        let mut values: Vec<f64> = values.iter().map(|value| value.clamp(least, most)).collect();
        values.dedup();
        AxisValues(values)
    };
    let [speeds, turn_rates] = reach.axes(floor, steps);
    let plane = SweepFile {
        profile: String::new(),
        controller: None,
        harsher: Harsher::default(),
        behaviour: NamedBehaviour::default(),
        axes: Axes(vec![
            (Axis::Speed, within(speeds, speed)),
            (Axis::TurnRate, within(turn_rates, turn)),
            (Axis::Robots, AxisValues(numbers.iter().map(|n| *n as f64).collect())),
        ]),
        fixed: Fixed {
            values: vec![(Axis::PlacementRadius, floor.placement_m), (Axis::Arena, floor.arena_m)],
            walls: Walls::Stop,
        },
        placement: None,
        world: None,
        cells: None,
        replicates,
        duration_s: DURATION_S,
        seed: SEED,
        adaptive: None,
    };
    plane.within_wheels(profile)
}

/// A sweep without capabilities, and those that it fixes, which are the robot's; those that it sweeps
/// are left out.
pub fn without_capabilities(sweep: &SweepFile) -> (SweepFile, Vec<(Axis, f64)>) {
    let (capabilities, values): (Vec<_>, Vec<_>) =
        sweep.fixed.values.iter().copied().partition(|(axis, _)| axis.is_capability());
    if capabilities.is_empty() && !sweep.swept_axes().into_iter().any(Axis::is_capability) {
        return (sweep.clone(), capabilities);
    }
    let mut cells: Vec<Cell> = Vec::new();
    for cell in sweep.all_cells() {
        let settings = cell.iter().filter(|(axis, _)| !axis.is_capability());
        let cell = Cell::new(settings).expect("it is part of a cell");
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    let fixed = Fixed { values, walls: sweep.fixed.walls };
    let settings = SweepFile { fixed, axes: Axes::default(), cells: Some(cells), ..sweep.clone() };
    (settings, capabilities)
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::wheels::Wheels;
    use rsrs_testing::conditions::flockbot;

    use super::*;

    #[test]
    fn the_settings_of_a_robot_are_what_its_wheels_can_do() {
        let free = flockbot();
        let mut on_wheels = free.clone();
        on_wheels.actuation.wheels = Some(Wheels { base_m: 0.12, speed_max_m_s: 0.25 });

        let whole = of_robot(&free, Some(9)).resolve("plane", &free).unwrap();
        let fitting = of_robot(&on_wheels, Some(9)).resolve("cells", &on_wheels).unwrap();

        assert!(fitting.len() > whole.len() / 2 && fitting.len() < whole.len());
        assert!(fitting.iter().all(|(cell, _)| whole.iter().any(|(other, _)| other == cell)));
    }
}
