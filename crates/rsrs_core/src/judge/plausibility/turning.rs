//! How a robot turned against how it was commanded to.

use std::f64::consts::PI;

use super::MOST_LAG_S;
use super::motion::Motion;

/// Turns are looked at over this time, in seconds: within it, a swarm's commands go to and fro.
const WINDOW_S: f64 = 2.0;

/// Windows start so far apart, in seconds.
const STRIDE_S: f64 = 1.0;

/// Fewer windows than this show nothing.
const MIN_WINDOWS: usize = 3;

/// And fewer than this nothing about one robot of which the others show the contrary.
const MIN_WINDOWS_ALONE: usize = 20;

/// A turn that was commanded in a window is at least so large, as a root mean square, in radians: a
/// tracker's noise makes one of 0.1.
const MIN_TURN_RAD: f64 = 0.3;

/// Turns that agree, or are reversed, correlate so strongly over all windows.
const MIN_AGREEMENT: f64 = 0.8;

/// How turning rates are compared from moment to moment, in seconds.
const MOMENT_S: f64 = 0.4;

/// A robot that follows commands from moment to moment correlates with them by this, or more: with
/// headings that are 0.1 rad wrong at 7.7 Hz it does by 0.7.
pub const MIN_FOLLOWED: f64 = 0.5;

/// How sure it must be that commands are followed, in standard errors: hundreds of pairs are
/// looked at, in hundreds of runs.
const MIN_SURE: f64 = 8.0;

/// Turns of a robot in windows, against those that it was commanded.
#[derive(Debug)]
pub struct Turning {
    n_windows: usize,
    /// Root mean square of what was commanded and what was turned in a window, in radians.
    commanded_rad: f64,
    turned_rad: f64,
    /// The largest agreement at any lag, and the largest disagreement, from -1 to 1.
    agreement: f64,
    reversal: f64,
    /// How many times as far as commanded it turned, at the lag of the stronger of both.
    slope: f64,
    /// How it follows its own commands from moment to moment.
    pub own: Followed,
}

impl Turning {
    pub fn new(motion: &Motion) -> Self {
        let lags = lags(motion, 0.1);
        let at_once = Products::new(motion, 0);
        let mut turning = Self {
            n_windows: at_once.n,
            commanded_rad: at_once.rms(at_once.commanded),
            turned_rad: at_once.rms(at_once.turned),
            agreement: -1.0,
            reversal: -1.0,
            slope: 0.0,
            own: follow(motion, motion),
        };
        for lag in lags {
            let products = Products::new(motion, lag);
            let correlation = products.correlation();
            if products.n < MIN_WINDOWS {
                continue;
            }
            if correlation.abs() > turning.agreement.max(turning.reversal) {
                turning.slope = products.both / products.commanded;
            }
            turning.agreement = turning.agreement.max(correlation);
            turning.reversal = turning.reversal.max(-correlation);
        }
        turning
    }

    /// Whether commands turn the robot so much that its turning can be judged.
    pub fn is_shown(&self) -> bool {
        self.n_windows >= MIN_WINDOWS && self.commanded_rad >= MIN_TURN_RAD
    }

    /// Whether it was commanded to turn, blocked or not.
    pub fn commanded_turns(&self) -> bool {
        self.own.commanded_rad_s >= MIN_TURN_RAD / WINDOW_S
    }

    /// Whether it turns as it is commanded, give or take its gain.
    pub fn follows(&self) -> bool {
        self.is_shown() && self.agreement > MIN_AGREEMENT && (1.0 / 3.0..3.0).contains(&self.slope)
    }

    /// Whether it turns the other way than it is commanded.
    pub fn is_reversed(&self) -> bool {
        let is_other_way = self.reversal > MIN_AGREEMENT && self.agreement < 0.5 * self.reversal;
        self.is_shown() && is_other_way && (-3.0..-1.0 / 3.0).contains(&self.slope)
    }

    /// Whether a single robot is reversed, and follows no command from moment to moment either.
    pub fn is_reversed_by_itself(&self) -> bool {
        self.n_windows >= MIN_WINDOWS_ALONE && self.is_reversed() && !self.steers()
    }

    /// Whether its heading follows its commands from moment to moment, however little it turns on the whole.
    pub fn steers(&self) -> bool {
        let Followed { correlation, reversal, .. } = self.own;
        correlation > MIN_FOLLOWED && correlation > reversal + 0.05
    }

    /// How many times as far as commanded it turned; `None` if that cannot be judged.
    pub fn factor(&self) -> Option<f64> {
        self.is_shown().then(|| self.turned_rad / self.commanded_rad)
    }
}

/// Sums of products over windows.
#[derive(Clone, Copy, Debug, Default)]
struct Products {
    n: usize,
    turned: f64,
    commanded: f64,
    both: f64,
}

impl Products {
    /// Windows in which the robot was free, with commands so many samples before them.
    fn new(motion: &Motion, lag: isize) -> Self {
        let (n_window, n_stride) = (motion.samples_in(WINDOW_S), motion.samples_in(STRIDE_S));
        let mut sums = Self::default();
        for start in (0..motion.len().saturating_sub(n_window)).step_by(n_stride) {
            let end = start + n_window;
            let (Some(from), Some(to)) = (shifted(start, lag), shifted(end, lag)) else { continue };
            if to >= motion.len() || motion.has_touched(start, end) {
                continue;
            }
            let turned_rad = motion.turned_rad[end] - motion.turned_rad[start];
            let commanded_rad = motion.to_turn_rad[to] - motion.to_turn_rad[from];
            sums.n += 1;
            sums.turned += turned_rad * turned_rad;
            sums.commanded += commanded_rad * commanded_rad;
            sums.both += turned_rad * commanded_rad;
        }
        sums
    }

    fn rms(self, sum: f64) -> f64 {
        (sum / self.n.max(1) as f64).sqrt()
    }

    fn correlation(self) -> f64 {
        let scale = (self.turned * self.commanded).sqrt();
        if scale > 0.0 { self.both / scale } else { 0.0 }
    }
}

fn shifted(at: usize, lag: isize) -> Option<usize> {
    at.checked_add_signed(-lag)
}

/// Lags to be tried, in samples, about so far apart.
fn lags(motion: &Motion, apart_s: f64) -> impl Iterator<Item = isize> + use<> {
    let to_signed = |n: usize| isize::try_from(n).unwrap_or(isize::MAX);
    let most = to_signed(motion.samples_in(MOST_LAG_S));
    let step = motion.samples_in(apart_s);
    (-most..=most).step_by(step)
}

/// How one robot's turning rate follows commands from moment to moment.
#[derive(Clone, Copy, Debug, Default)]
pub struct Followed {
    /// The largest correlation at any lag, from -1 to 1.
    pub correlation: f64,
    /// The largest correlation with the opposite.
    pub reversal: f64,
    /// Mean turning rate that was commanded, either way, in radians per second.
    pub commanded_rad_s: f64,
    /// Moments that are independent of each other.
    n_moments: f64,
}

impl Followed {
    /// Whether it is no chance that they are followed.
    pub fn is_sure(&self) -> bool {
        let standard_errors =
            libm::atanh(self.correlation.min(0.99)) * (self.n_moments - 3.0).max(0.0).sqrt();
        self.correlation > MIN_FOLLOWED && standard_errors >= MIN_SURE
    }
}

/// How the turning of one robot follows the commands of another, or its own.
pub fn follow(robot: &Motion, commanded: &Motion) -> Followed {
    let n_moment = robot.samples_in(MOMENT_S);
    let n_rates = robot.len().saturating_sub(n_moment);
    if n_rates < 3 {
        return Followed::default();
    }
    let change = |sums: &[f64], at: usize| sums[at + n_moment] - sums[at];
    let free: Vec<usize> =
        (0..n_rates).filter(|at| !robot.has_touched(*at, *at + n_moment)).collect();
    let rates = commanded.commands.iter().map(|command| command.turn_rate_rad_s.abs());
    let mut followed = Followed {
        correlation: -1.0,
        reversal: -1.0,
        commanded_rad_s: rates.sum::<f64>() / commanded.commands.len() as f64,
        n_moments: free.len() as f64 / n_moment as f64,
    };
    for lag in lags(robot, 0.05) {
        let pairs = free.iter().filter_map(|at| {
            let from = shifted(*at, lag).filter(|from| *from < n_rates)?;
            Some((change(&robot.turned_rad, *at), change(&commanded.to_turn_rad, from)))
        });
        let correlation = correlation(pairs);
        followed.correlation = followed.correlation.max(correlation);
        followed.reversal = followed.reversal.max(-correlation);
    }
    followed
}

/// Pearson's, 0 where one of both is constant.
fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut n, mut x, mut y, mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (one, other) in pairs {
        n += 1.0;
        x += one;
        y += other;
        xx += one * one;
        yy += other * other;
        xy += one * other;
    }
    if n < 3.0 {
        return 0.0;
    }
    let covariance = |sum: f64, one: f64, other: f64| sum / n - one * other / (n * n);
    let variances = covariance(xx, x, x).max(0.0) * covariance(yy, y, y).max(0.0);
    // Constant commands differ by the last bits of their sums.
    if variances < 1e-16 { 0.0 } else { covariance(xy, x, y) / variances.sqrt() }
}

/// Whether headings turn by degrees where radians are meant, as far as steps of more than half a turn
/// show it: what is commanded, times a gain, explains them.
pub fn turns_by_degrees(motion: &Motion) -> bool {
    let per_degree = 180.0 / PI;
    let lags = 0..=motion.samples_in(0.3);
    let gains = (50..=150).map(|percent| f64::from(percent) / 100.0);
    let steps: Vec<f64> =
        motion.poses.windows(2).map(|pair| pair[1].heading_rad - pair[0].heading_rad).collect();
    gains.into_iter().any(|gain| {
        lags.clone().any(|lag| {
            let (mut cosines, mut sines, mut n) = (0.0, 0.0, 0.0);
            for (step_rad, command) in steps.iter().skip(lag).zip(&motion.commands) {
                let expected_rad = per_degree * gain * command.turn_rate_rad_s * motion.period_s;
                let (sine, cosine) = libm::sincos(step_rad - expected_rad);
                (cosines, sines, n) = (cosines + cosine, sines + sine, n + 1.0);
            }
            n >= 20.0 && libm::hypot(cosines, sines) / n > 0.6
        })
    })
}
