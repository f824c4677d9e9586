//! Spreads by restricted maximum likelihood: what robots differ by at every command alike.

use serde::Serialize;

/// Spreads of gains by restricted maximum likelihood.
///
/// A gain is the mean at its command, plus what its robot differs by at every command alike, plus
/// what is left. For one command and as many trials of every robot these are the closed forms of the
/// analysis of variance; for any other table they use all of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Likelihood {
    /// Standard deviation of what robots differ by at every command alike.
    pub alike_sd: f64,
    /// Standard deviation of what is left: between trials, and between commands of one robot.
    pub rest_sd: f64,
}

/// What one robot brings.
pub(super) struct RobotTrials {
    /// Trials at each command; shape `[n_commands]`.
    n: Vec<f64>,
    /// Sum of its gains at each command, each less the mean of all gains at that command.
    sums: Vec<f64>,
}

impl RobotTrials {
    /// A robot's trials: how many there are at each command, and the sums of its gains there, less
    /// the mean of all gains at the same command. Shape `[n_commands]` both.
    pub(super) fn new(n: Vec<f64>, sums: Vec<f64>) -> Self {
        Self { n, sums }
    }

    fn n_trials(&self) -> f64 {
        self.n.iter().sum()
    }

    fn total(&self) -> f64 {
        self.sums.iter().sum()
    }
}

/// Points at which the likelihood is looked at before its top is approached: for few and uneven
/// trials it may have two.
const N_LOOKS: usize = 64;

/// Finds the spreads at which the restricted likelihood is greatest; `squares` is the sum of
/// squares of all gains about the means of their commands.
///
/// The likelihood depends on the ratio of the two variances alone, once the means and the size of
/// both are the best for that ratio. Its top is looked for over all ratios, and then approached by
/// halving until neighbouring binary fractions are left.
///
/// `None` if trials do not identify both spreads: one robot, or no more trials than there are
/// robots and commands; or if nothing is left between trials.
///
/// # Source
///
/// H. D. Patterson, R. Thompson, "Recovery of inter-block information when block sizes are unequal",
/// Biometrika 58, 1971; checked against statsmodels and scipy.
pub(super) fn likelihood(robots: &[RobotTrials], squares: f64) -> Option<Likelihood> {
    let n_trials: f64 = robots.iter().map(RobotTrials::n_trials).sum();
    let n_commands = robots.first()?.n.len();
    if robots.len() < 2 || n_trials <= (n_commands + robots.len() - 1) as f64 || squares <= 0.0 {
        return None;
    }
    let layout = Layout { robots, squares, df: n_trials - n_commands as f64 };
    let looks: Vec<f64> = (0..N_LOOKS).map(|look| look as f64 / N_LOOKS as f64).collect();
    let heights: Vec<f64> = looks.iter().map(|share| layout.at(*share).height).collect();
    let best = (0..N_LOOKS).max_by(|left, right| heights[*left].total_cmp(&heights[*right]))?;
    let below = looks[best.saturating_sub(1)];
    let above = looks.get(best + 1).copied().unwrap_or(MOST_SHARE);
    let share = top(&layout, (below, above))?;
    let at = layout.at(share);
    let rest = at.squares / layout.df;
    let ratio = share / (1.0 - share);
    Some(Likelihood { alike_sd: (ratio * rest).sqrt(), rest_sd: rest.sqrt() })
}

/// Beyond this share of all variance the rest is nothing but rounding.
const MOST_SHARE: f64 = 1.0 - 1e-12;

/// The share between two bounds at which the likelihood stops rising.
fn top(layout: &Layout, (mut low, mut high): (f64, f64)) -> Option<f64> {
    if low == 0.0 && layout.at(0.0).slope <= 0.0 {
        return Some(0.0);
    }
    if layout.at(high).slope > 0.0 {
        return None;
    }
    loop {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            return Some(middle);
        }
        if layout.at(middle).slope > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// All trials, and what their likelihood needs of them.
struct Layout<'a> {
    robots: &'a [RobotTrials],
    squares: f64,
    /// Trials less commands.
    df: f64,
}

/// The likelihood at one share of the variance.
struct At {
    /// Its logarithm, up to a constant.
    height: f64,
    /// How it rises with the ratio of the variances.
    slope: f64,
    /// Sum of squares about the best means, weighed for this ratio.
    squares: f64,
}

impl Layout<'_> {
    /// The likelihood where robots bring a share of all variance.
    fn at(&self, share: f64) -> At {
        let ratio = share / (1.0 - share);
        let n_commands = self.robots[0].n.len();
        // Normal equations of the means, at the weights of this ratio.
        let mut matrix = vec![vec![0.0; n_commands]; n_commands];
        let mut right = vec![0.0; n_commands];
        let mut squares = self.squares;
        for robot in self.robots {
            let weight = ratio / (1.0 + ratio * robot.n_trials());
            let total = robot.total();
            squares -= weight * total * total;
            for command in 0..n_commands {
                matrix[command][command] += robot.n[command];
                right[command] += robot.sums[command] - weight * total * robot.n[command];
                for (entry, other) in matrix[command].iter_mut().zip(&robot.n) {
                    *entry -= weight * robot.n[command] * other;
                }
            }
        }
        let root = cholesky(matrix);
        let half = forward(&root, &right);
        squares -= half.iter().map(|number| number * number).sum::<f64>();
        let means = backward(&root, half);
        let log_size: f64 = (0..n_commands).map(|row| 2.0 * libm::log(root[row][row])).sum();
        let (mut logs, mut pull, mut room, mut cost) = (log_size, 0.0, 0.0, 0.0);
        for robot in self.robots {
            let n_trials = robot.n_trials();
            let spread = 1.0 + ratio * n_trials;
            let expected: f64 = robot.n.iter().zip(&means).map(|(n, mean)| n * mean).sum();
            let away = robot.total() - expected;
            logs += libm::log(spread);
            pull += away * away / (spread * spread);
            cost += n_trials / spread;
            let own = forward(&root, &robot.n);
            room += own.iter().map(|number| number * number).sum::<f64>() / (spread * spread);
        }
        At {
            height: -0.5 * (self.df * libm::log(squares) + logs),
            slope: 0.5 * (self.df * pull / squares + room - cost),
            squares,
        }
    }
}

/// The lower root of a symmetric matrix.
///
/// # Panics
///
/// If the matrix is not positive: every command has a trial, so that it is.
fn cholesky(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for row in 0..matrix.len() {
        for column in 0..=row {
            let known: f64 =
                (0..column).map(|inner| matrix[row][inner] * matrix[column][inner]).sum();
            let rest = matrix[row][column] - known;
            matrix[row][column] = if row == column {
                assert!(rest > 0.0, "every command has a trial");
                rest.sqrt()
            } else {
                rest / matrix[column][column]
            };
        }
    }
    matrix
}

/// Solves with a lower root.
fn forward(root: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut solved: Vec<f64> = Vec::with_capacity(right.len());
    for (row, number) in right.iter().enumerate() {
        let known: f64 = solved.iter().zip(&root[row]).map(|(one, other)| one * other).sum();
        solved.push((number - known) / root[row][row]);
    }
    solved
}

/// Solves with the transpose of a lower root.
fn backward(root: &[Vec<f64>], mut right: Vec<f64>) -> Vec<f64> {
    for row in (0..right.len()).rev() {
        let known: f64 = (row + 1..right.len()).map(|other| root[other][row] * right[other]).sum();
        right[row] = (right[row] - known) / root[row][row];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Robots with trials at one command; gains about any mean.
    fn one_command(gains: &[&[f64]]) -> Option<Likelihood> {
        let all: Vec<f64> = gains.iter().flat_map(|own| own.iter().copied()).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let squares = all.iter().map(|gain| (gain - mean) * (gain - mean)).sum();
        let robot = |own: &&[f64]| {
            RobotTrials::new(vec![own.len() as f64], vec![own.iter().map(|gain| gain - mean).sum()])
        };
        likelihood(&gains.iter().map(robot).collect::<Vec<_>>(), squares)
    }

    #[test]
    fn as_many_trials_of_every_robot_give_the_closed_form() {
        let found = one_command(&[&[0.9, 0.92], &[0.97, 0.95], &[1.0, 0.98]]).unwrap();

        // Means of 0.91, 0.96 and 0.99 have the variance 0.0098 / 6; six deviations of 0.01 are left.
        let within: f64 = 6.0 * 0.0001 / 3.0;
        let between = 0.0098 / 6.0 - within / 2.0;
        assert!((found.rest_sd - within.sqrt()).abs() < 1e-12, "{found:?}");
        assert!((found.alike_sd - between.sqrt()).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn robots_that_differ_by_less_than_their_trials_do_not_differ() {
        let found = one_command(&[&[0.9, 1.0], &[0.91, 0.99], &[0.94, 0.96]]).unwrap();

        assert!(found.alike_sd == 0.0 && found.rest_sd > 0.03, "{found:?}");
    }

    #[test]
    fn what_trials_cannot_distinguish_has_no_spreads() {
        assert_eq!(one_command(&[&[0.9, 0.92]]), None);
        assert_eq!(one_command(&[&[0.9], &[0.92], &[0.95]]), None);
        assert_eq!(one_command(&[&[0.9, 0.9], &[0.95, 0.95]]), None);
    }
}
