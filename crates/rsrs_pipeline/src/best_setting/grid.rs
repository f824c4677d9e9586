//! The settings in which a robot is given its chance: speed, turning rate, number and placement.

use rsrs_core::conditions::{Settings, Walls};
use rsrs_core::diagram::axis::{Axis, AxisValues, Cell};
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::robot::harsher::tidy;
use rsrs_core::robot::profile::RobotProfile;

/// What an operator can set, and how it is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// What is the same in all cells.
    pub settings: Settings,
    /// The cells: settings only, no capabilities.
    pub cells: Vec<Cell>,
    /// Simulated time of each run, in seconds.
    pub duration_s: f64,
    /// Seed, below 2^63.
    pub seed: u64,
}

/// Values of speed and of turning rate.
const STEPS: u32 = 5;
/// A robot's least speed is tried if it is more than this share of its greatest one.
const LEAST_SPEED: f64 = 0.125;
/// As for the speed.
const LEAST_TURN_RATE: f64 = 0.1;
/// Numbers of robots.
const ROBOTS: [u32; 4] = [4, 6, 9, 12];
/// Side of the arena over the sensor's range.
const ARENA_OVER_RANGE: f64 = 20.0;
/// Side of an arena that is large enough for small robots, in metres.
const ARENA_M: f64 = 15.0;
/// Robots start in a disc "slightly larger than their maximum vision distance" (§IV step 3).
const PLACEMENT_OVER_RANGE: f64 = 1.1;
/// Radius of a dense disc over that of a body and the root of the number of robots: its robots cover
/// about a third of it.
const DENSE: f64 = 2.0;
/// Enough time for a mill to form and to last, in seconds.
const DURATION_S: f64 = 300.0;
const SEED: u64 = 1;
/// Numbers of robots of a grid that is even.
const EVEN_ROBOTS: std::ops::RangeInclusive<u32> = 3..=16;
/// Values of speed and of turning rate of such a grid.
const EVEN_STEPS: usize = 7;

impl Grid {
    /// The built-in grid of a robot: five speeds and five turning rates within its limits, 4 to 12
    /// robots, from the disc of the paper and from a dense one.
    pub fn of_robot(profile: &RobotProfile) -> Self {
        let range_m = profile.capability(Axis::Range).unwrap_or(1.0);
        let speeds = spread(profile.actuation.speed.limits_m_s, LEAST_SPEED);
        let turn_rates = spread(profile.actuation.turn.limits_rad_s, LEAST_TURN_RATE);
        let mut cells = Vec::new();
        for n_robots in ROBOTS.map(f64::from) {
            let dense_m = DENSE * profile.body.radius_m * libm::sqrt(n_robots);
            let paper_m = centimetres(PLACEMENT_OVER_RANGE * range_m);
            let dense_m = centimetres(dense_m);
            // Where the paper's disc is hardly larger than the dense one, or too small, there is one.
            let radii =
                if paper_m > 1.1 * dense_m { vec![paper_m, dense_m] } else { vec![dense_m] };
            for radius_m in &radii {
                for speed_m_s in &speeds {
                    let cell = |turn_rate_rad_s: &f64| {
                        Cell::new([
                            (Axis::Speed, *speed_m_s),
                            (Axis::TurnRate, *turn_rate_rad_s),
                            (Axis::Robots, n_robots),
                            (Axis::PlacementRadius, *radius_m),
                        ])
                        .expect("the axes are distinct and the limits are finite")
                    };
                    cells.extend(turn_rates.iter().map(cell));
                }
            }
        }
        Self::in_the_open(range_m, Vec::new(), cells)
    }

    /// The grid of a robot whose milling region is looked for: even steps of speed and turning rate
    /// within its limits, 3 to 16 robots, from the disc of the paper.
    pub fn even(profile: &RobotProfile) -> Self {
        let range_m = profile.capability(Axis::Range).unwrap_or(1.0);
        // All of the robots that mill somewhere find a place.
        let least_m = DENSE * profile.body.radius_m * libm::sqrt(f64::from(*EVEN_ROBOTS.end()));
        let radius_m = centimetres((PLACEMENT_OVER_RANGE * range_m).max(least_m));
        let even = |[least, most]: [f64; 2]| AxisValues::evenly_spaced(least, most, EVEN_STEPS).0;
        let speeds_m_s = even(profile.actuation.speed.limits_m_s);
        let turn_rates_rad_s = even(profile.actuation.turn.limits_rad_s);
        let mut cells = Vec::new();
        for n_robots in EVEN_ROBOTS.map(f64::from) {
            for speed_m_s in &speeds_m_s {
                for turn_rate_rad_s in &turn_rates_rad_s {
                    let cell = Cell::new([
                        (Axis::Speed, *speed_m_s),
                        (Axis::TurnRate, *turn_rate_rad_s),
                        (Axis::Robots, n_robots),
                    ]);
                    cells.push(cell.expect("the axes are distinct and the limits are finite"));
                }
            }
        }
        Self::in_the_open(range_m, vec![(Axis::PlacementRadius, radius_m)], cells)
    }

    /// Cells in an arena whose walls robots rarely meet.
    fn in_the_open(range_m: f64, mut values: Vec<(Axis, f64)>, cells: Vec<Cell>) -> Self {
        values.push((Axis::Arena, centimetres((ARENA_OVER_RANGE * range_m).max(ARENA_M))));
        let settings = Settings { values, walls: Walls::Stop, ..Settings::default() };
        Self { settings, cells, duration_s: DURATION_S, seed: SEED }
    }

    /// The settings of a sweep.
    ///
    /// # Returns
    ///
    /// The grid, and the capabilities that the sweep fixes: those are the robot's. Capabilities that
    /// it sweeps are left out.
    pub fn of_sweep(sweep: &SweepFile) -> (Self, Vec<(Axis, f64)>) {
        let (capabilities, values) =
            sweep.fixed.values.iter().copied().partition(|(axis, _)| axis.is_capability());
        let mut cells: Vec<Cell> = Vec::new();
        for cell in sweep.all_cells() {
            let settings = cell.iter().filter(|(axis, _)| !axis.is_capability());
            let cell = Cell::new(settings).expect("it is part of a cell");
            if !cells.contains(&cell) {
                cells.push(cell);
            }
        }
        let settings = Settings { values, ..sweep.settings() };
        let grid = Self { settings, cells, duration_s: sweep.duration_s, seed: sweep.seed };
        (grid, capabilities)
    }
}

/// Values between limits, each the same multiple of the one before, in two significant digits.
fn spread([least, most]: [f64; 2], least_share: f64) -> Vec<f64> {
    let least = least.max(least_share * most);
    let ratio = libm::pow(most / least, 1.0 / f64::from(STEPS - 1));
    let value = |step: u32| match step {
        0 => least,
        last if last == STEPS - 1 => most,
        step => significant(least * libm::pow(ratio, f64::from(step))).clamp(least, most),
    };
    let mut values: Vec<f64> = (0..STEPS).map(value).collect();
    values.dedup();
    values
}

/// A number in two significant digits.
fn significant(number: f64) -> f64 {
    let step = libm::pow(10.0, libm::floor(libm::log10(number)) - 1.0);
    tidy((number / step).round() * step)
}

fn centimetres(length_m: f64) -> f64 {
    tidy((length_m * 100.0).ceil() / 100.0)
}
