//! Gains of robots and of the population that they were drawn from.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::likelihood::{Likelihood, RobotTrials, likelihood};
use crate::natural_order::natural_key;
use crate::statistics::quantile::{student, student_two_sided};
use crate::statistics::variance::{Estimate, MeanSquare, mean, sd, squared_deviations};

/// What one robot delivered at one command.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotGain {
    /// Position of the robot's name.
    pub robot: usize,
    /// The command.
    pub command: f64,
    /// The gain of each trial.
    pub gains: Vec<f64>,
    /// Mean gain, with Student's interval over the trials.
    pub gain: Estimate,
}

impl RobotGain {
    /// Standard deviation of the gain between trials.
    pub fn sd(&self) -> Option<f64> {
        sd(&self.gains)
    }
}

/// How a kind of robot follows one kind of command.
///
/// A gain is the mean at its command, plus what the robot differs by, plus what the trial differs
/// by; both are normal, and their spreads are the same at all commands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Population {
    /// Robots measured.
    pub n_robots: usize,
    /// Trials made.
    pub n_trials: usize,
    /// Mean gain at each command, ascending; the size of the command counts, not its sign.
    pub by_command: Vec<CommandGain>,
    /// Standard deviation of the gain between robots at one command; `None` for one robot.
    pub robot_sd: Option<Estimate>,
    /// Standard deviation of the gain between trials of one robot at one command; `None` if there
    /// are no repetitions.
    pub trial_sd: Option<Estimate>,
    /// Spreads by restricted maximum likelihood, for robots that differ at all commands alike;
    /// `None` if trials do not identify both.
    pub likelihood: Option<Likelihood>,
    /// Whether every robot was measured at every command. If not, the interval of `robot_sd` is
    /// wider than it would have to be.
    pub is_complete: bool,
    /// Trials that do not belong to the others. They are named, and they count like all others.
    pub outliers: Vec<Outlier>,
}

/// Mean gain of the population at one command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CommandGain {
    /// Size of the command, in its unit.
    pub command: f64,
    /// Robots measured at it.
    pub n_robots: usize,
    /// Mean over robots, with Student's interval over robots; for one robot, over its trials.
    pub gain: Estimate,
}

/// Gains of every robot at every command, by robot and then by command. The robots' names make the
/// order: `robot_2` comes before `robot_10`.
pub fn robot_gains(observations: &[Observation], names: &[String]) -> Vec<RobotGain> {
    let mut cells: BTreeMap<(usize, u64), RobotGain> = BTreeMap::new();
    for observation in observations {
        let (robot, command) = (observation.robot, observation.command);
        let none = Estimate { value: 0.0, low: None, high: None };
        let cell = cells.entry((robot, command.to_bits())).or_insert_with(|| RobotGain {
            robot,
            command,
            gains: Vec::new(),
            gain: none,
        });
        cell.gains.push(observation.gain);
    }
    let mut cells: Vec<RobotGain> = cells.into_values().collect();
    for cell in &mut cells {
        cell.gain = Estimate::of_mean(&cell.gains);
    }
    cells.sort_by(|left, right| {
        let (left_name, right_name) = (&names[left.robot], &names[right.robot]);
        natural_key(left_name)
            .cmp(&natural_key(right_name))
            .then(left_name.cmp(right_name))
            .then(left.command.total_cmp(&right.command))
    });
    cells
}

/// Estimates of the population that the robots were drawn from.
///
/// # Panics
///
/// If there is no observation.
pub fn population(observations: &[Observation]) -> Population {
    let layout = Layout::new(observations);
    Population {
        n_robots: layout.robots.len(),
        n_trials: observations.len(),
        by_command: layout.by_command(),
        robot_sd: layout.robot_variance().map(|variance| variance.sd(1.0)),
        trial_sd: layout
            .within()
            .map(|within| Estimate::of_variance(&[MeanSquare { weight: 1.0, ..within }]).sd(1.0)),
        likelihood: layout.likelihood(),
        is_complete: layout.is_complete(),
        outliers: outliers(observations),
    }
}

/// Gains by robot and size of command.
struct Layout {
    robots: BTreeSet<usize>,
    commands: Vec<f64>,
    /// Gains of the trials by position of the command and robot.
    cells: BTreeMap<(usize, usize), Vec<f64>>,
}

impl Layout {
    fn new(observations: &[Observation]) -> Self {
        // Sizes are not negative, so their bits are in the order of their numbers.
        let sizes = observations.iter().map(|observation| observation.command.abs().to_bits());
        let sizes: BTreeSet<u64> = sizes.collect();
        let commands: Vec<f64> = sizes.into_iter().map(f64::from_bits).collect();
        let mut cells: BTreeMap<(usize, usize), Vec<f64>> = BTreeMap::new();
        for observation in observations {
            let size = observation.command.abs();
            let position = commands.partition_point(|command| *command < size);
            cells.entry((position, observation.robot)).or_default().push(observation.gain);
        }
        let robots = observations.iter().map(|observation| observation.robot).collect();
        Self { robots, commands, cells }
    }

    fn is_complete(&self) -> bool {
        self.cells.len() == self.robots.len() * self.commands.len()
    }

    /// Means of the robots at one command.
    fn robot_means(&self, position: usize) -> Vec<f64> {
        self.cells.range((position, 0)..(position + 1, 0)).map(|(_, gains)| mean(gains)).collect()
    }

    fn by_command(&self) -> Vec<CommandGain> {
        let one = |(position, command): (usize, &f64)| {
            let means = self.robot_means(position);
            let mut cells = self.cells.range((position, 0)..(position + 1, 0));
            let gain = match (means.len(), cells.next()) {
                (1, Some((_, gains))) => Estimate::of_mean(gains),
                _ => Estimate::of_mean(&means),
            };
            CommandGain { command: *command, n_robots: means.len(), gain }
        };
        self.commands.iter().enumerate().map(one).collect()
    }

    /// Mean square between trials of one robot at one command.
    fn within(&self) -> Option<MeanSquare> {
        let n_trials: usize = self.cells.values().map(Vec::len).sum();
        let df = (n_trials - self.cells.len()) as f64;
        let squares: f64 = self.cells.values().map(|gains| squared_deviations(gains)).sum();
        (df > 0.0).then(|| MeanSquare { weight: 0.0, value: squares / df, df })
    }

    /// Spreads of robots that differ at all commands alike.
    fn likelihood(&self) -> Option<Likelihood> {
        let at = |position: usize| self.cells.range((position, 0)..(position + 1, 0));
        let means: Vec<f64> = (0..self.commands.len())
            .map(|position| {
                mean(&at(position).flat_map(|(_, gains)| gains).copied().collect::<Vec<_>>())
            })
            .collect();
        let away = |position: usize, gains: &[f64]| -> Vec<f64> {
            gains.iter().map(|gain| gain - means[position]).collect()
        };
        let robot = |robot: &usize| {
            let (mut n, mut sums) = (Vec::new(), Vec::new());
            for position in 0..self.commands.len() {
                let gains = self.cells.get(&(position, *robot)).map_or(&[][..], Vec::as_slice);
                n.push(gains.len() as f64);
                sums.push(away(position, gains).iter().sum());
            }
            RobotTrials::new(n, sums)
        };
        let squares = self.cells.iter().map(|((position, _), gains)| {
            away(*position, gains).iter().map(|away| away * away).sum::<f64>()
        });
        likelihood(&self.robots.iter().map(robot).collect::<Vec<_>>(), squares.sum())
    }

    /// Variance between robots at one command: that of their means, without what the trials add.
    ///
    /// Means count alike however many trials they have (the analysis of unweighted means), and the
    /// trials add their variance over the harmonic mean of the repetitions.
    ///
    /// # Source
    ///
    /// J. D. Thomas, R. A. Hultquist, "Interval estimation for the unbalanced case of the one-way
    /// random effects model", Annals of Statistics 6, 1978.
    fn robot_variance(&self) -> Option<Estimate> {
        let mut terms = if self.is_complete() { self.crossed()? } else { self.nested()? };
        if let Some(within) = self.within() {
            let shares: f64 = self.cells.values().map(|gains| 1.0 / gains.len() as f64).sum();
            terms.push(MeanSquare { weight: -shares / self.cells.len() as f64, ..within });
        }
        Some(Estimate::of_variance(&terms))
    }

    /// Every robot at every command: what it differs by at all of them, and at each.
    fn crossed(&self) -> Option<Vec<MeanSquare>> {
        let (n_robots, n_commands) = (self.robots.len() as f64, self.commands.len() as f64);
        if self.robots.len() < 2 {
            return None;
        }
        let columns: Vec<Vec<f64>> =
            (0..self.commands.len()).map(|position| self.robot_means(position)).collect();
        let overall: Vec<f64> = (0..self.robots.len())
            .map(|robot| columns.iter().map(|column| column[robot]).sum::<f64>() / n_commands)
            .collect();
        let robots = n_commands * squared_deviations(&overall);
        let all: f64 = columns.iter().map(|column| squared_deviations(column)).sum();
        let df = n_robots - 1.0;
        let mut terms = vec![MeanSquare { weight: 1.0 / n_commands, value: robots / df, df }];
        if n_commands > 1.0 {
            let df = df * (n_commands - 1.0);
            let value = ((all - robots) / df).max(0.0);
            terms.push(MeanSquare { weight: 1.0 - 1.0 / n_commands, value, df });
        }
        Some(terms)
    }

    /// Some robots at some commands: pooled, with the degrees of freedom of the best command only,
    /// because a robot may differ by the same amount at all of them.
    fn nested(&self) -> Option<Vec<MeanSquare>> {
        let columns: Vec<Vec<f64>> =
            (0..self.commands.len()).map(|position| self.robot_means(position)).collect();
        let freedom: usize = columns.iter().map(|column| column.len() - 1).sum();
        let most = columns.iter().map(Vec::len).max()? - 1;
        if most == 0 {
            return None;
        }
        let all: f64 = columns.iter().map(|column| squared_deviations(column)).sum();
        let value = all / freedom as f64;
        Some(vec![MeanSquare { weight: 1.0, value, df: most as f64 }])
    }
}

/// A trial that is too far from the others of its robot and command to be one of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outlier {
    /// Line of the table.
    pub line: u64,
    /// Position of the robot's name.
    #[serde(skip)]
    pub robot: usize,
    /// The command.
    pub command: f64,
    /// The trial's gain.
    pub gain: f64,
    /// Mean gain of all trials of this robot at this command, this one included.
    pub mean_gain: f64,
    /// Probability that the farthest of as many good trials is at least so far out: the smaller,
    /// the stranger.
    pub p_value: f64,
}

/// Most that [`Outlier::p_value`] may be for a trial to be named.
const LEVEL: f64 = 0.05;

/// Names trials by their externally studentised residuals about the mean of their robot and
/// command, with Bonferroni's correction for how many trials there are.
///
/// # Source
///
/// R. D. Cook, S. Weisberg, "Residuals and Influence in Regression", 1982, 2.2.2; the `outlier_test`
/// of statsmodels, against which it is checked.
pub fn outliers(observations: &[Observation]) -> Vec<Outlier> {
    let mut cells: BTreeMap<(usize, u64), Vec<f64>> = BTreeMap::new();
    for observation in observations {
        cells
            .entry((observation.robot, observation.command.to_bits()))
            .or_default()
            .push(observation.gain);
    }
    let df = observations.len() as f64 - cells.len() as f64;
    let squares: f64 = cells.values().map(|gains| squared_deviations(gains)).sum();
    if df < 2.0 || squares == 0.0 {
        return Vec::new();
    }
    let cells: BTreeMap<(usize, u64), (usize, f64)> =
        cells.into_iter().map(|(cell, gains)| (cell, (gains.len(), mean(&gains)))).collect();
    // Most trials are near enough for their probability not to be worth computing.
    let n = observations.len() as f64;
    let near = 0.99 * student(df - 1.0, 1.0 - LEVEL / n / 2.0);
    let outlier = |observation: &Observation| {
        let (n_trials, mean_gain) = cells[&(observation.robot, observation.command.to_bits())];
        if n_trials < 2 {
            return None;
        }
        let spare = 1.0 - 1.0 / n_trials as f64;
        let residual = observation.gain - mean_gain;
        let without = squares - residual * residual / spare;
        // All others agree exactly: then any distance is too far.
        let p_value = if without <= 1e-12 * squares {
            0.0
        } else {
            let t = residual / (without / (df - 1.0) * spare).sqrt();
            if t.abs() < near {
                return None;
            }
            (student_two_sided(df - 1.0, t) * n).min(1.0)
        };
        (p_value < LEVEL).then_some(Outlier {
            line: observation.line,
            robot: observation.robot,
            command: observation.command,
            gain: observation.gain,
            mean_gain,
            p_value,
        })
    };
    observations.iter().filter_map(outlier).collect()
}

/// One trial, as a gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Position of the robot's name.
    pub robot: usize,
    /// Line of the table.
    pub line: u64,
    /// The command; its sign is the sense of a turn.
    pub command: f64,
    /// Delivered over commanded; dimensionless.
    pub gain: f64,
}
