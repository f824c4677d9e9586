//! An evolution strategy that adapts its covariance matrix.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::Draws;

/// Searches for the point with the least cost: samples around a mean, which moves to the better ones, in
/// directions in which moving has paid.
///
/// The same seed and the same costs give the same samples.
///
/// # Source
///
/// N. Hansen, "The CMA Evolution Strategy: A Tutorial", arXiv 1604.00772, with its constants.
///
/// # Example
///
/// ```
/// use rsrs_sim::exploration::evolution_strategy::EvolutionStrategy;
///
/// let mut strategy = EvolutionStrategy::new(&[3.0, 1.0], 0.5, 1);
/// for _ in 0..100 {
///     let points = strategy.sample();
///     let costs: Vec<f64> = points.iter().map(|point| point[0].powi(2) + point[1].powi(2)).collect();
///     strategy.update(&costs);
/// }
/// assert!(strategy.mean().iter().all(|coordinate| coordinate.abs() < 1e-4));
/// ```
#[derive(Clone, Debug)]
pub struct EvolutionStrategy {
    seed: u64,
    generation: u64,
    constants: Constants,
    mean: DVector<f64>,
    /// Standard deviation of the samples over all directions.
    step: f64,
    covariance: DMatrix<f64>,
    /// Where means have moved lately, without and with the shape of the covariance.
    step_path: DVector<f64>,
    shape_path: DVector<f64>,
    axes: Axes,
    /// Steps from the mean to the samples of this generation, in units of `step`.
    sampled: Vec<DVector<f64>>,
}

/// The axes of the covariance: directions, and standard deviations along them.
#[derive(Clone, Debug)]
struct Axes {
    directions: DMatrix<f64>,
    lengths: DVector<f64>,
}

/// What follows from the number of coordinates.
#[derive(Clone, Debug)]
struct Constants {
    n: f64,
    /// Samples of a generation.
    population: usize,
    /// Of the better samples, the best one first; their sum is 1.
    weights: Vec<f64>,
    /// How many samples the weighted ones are worth.
    n_effective: f64,
    step_rate: f64,
    step_damping: f64,
    path_rate: f64,
    rank_one_rate: f64,
    rank_many_rate: f64,
    /// Expected length of a standard normal vector.
    normal_length: f64,
}

impl Constants {
    fn new(n_coordinates: usize) -> Self {
        let n = n_coordinates as f64;
        let population = 4 + (3.0 * libm::log(n)) as usize;
        let n_better = population / 2;
        let raw = |rank: usize| {
            libm::log(f64::midpoint(population as f64, 1.0)) - libm::log(rank as f64 + 1.0)
        };
        let sum: f64 = (0..n_better).map(raw).sum();
        let weights: Vec<f64> = (0..n_better).map(|rank| raw(rank) / sum).collect();
        let n_effective = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let step_rate = (n_effective + 2.0) / (n + n_effective + 5.0);
        let excess = ((n_effective - 1.0) / (n + 1.0)).sqrt() - 1.0;
        let rank_one_rate = 2.0 / ((n + 1.3) * (n + 1.3) + n_effective);
        let rank_many =
            2.0 * (n_effective - 2.0 + 1.0 / n_effective) / ((n + 2.0) * (n + 2.0) + n_effective);
        Self {
            n,
            population,
            weights,
            n_effective,
            step_rate,
            step_damping: 1.0 + 2.0 * excess.max(0.0) + step_rate,
            path_rate: (4.0 + n_effective / n) / (n + 4.0 + 2.0 * n_effective / n),
            rank_one_rate,
            rank_many_rate: rank_many.min(1.0 - rank_one_rate),
            normal_length: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

impl EvolutionStrategy {
    /// A search from the point `mean`, whose first samples have the standard deviation `step`, in
    /// units of the coordinates.
    ///
    /// # Panics
    ///
    /// If there is no coordinate, or the step is not positive.
    pub fn new(mean: &[f64], step: f64, seed: u64) -> Self {
        assert!(!mean.is_empty() && step > 0.0, "a search needs coordinates and a step");
        let n = mean.len();
        let (identity, zero) = (DMatrix::identity(n, n), DVector::zeros(n));
        Self {
            seed,
            generation: 0,
            constants: Constants::new(n),
            mean: DVector::from_column_slice(mean),
            step,
            covariance: identity.clone(),
            step_path: zero.clone(),
            shape_path: zero,
            axes: Axes { directions: identity, lengths: DVector::repeat(n, 1.0) },
            sampled: Vec::new(),
        }
    }

    /// Samples of a generation.
    pub fn population(&self) -> usize {
        self.constants.population
    }

    /// Where the search is.
    pub fn mean(&self) -> &[f64] {
        self.mean.as_slice()
    }

    /// Standard deviation of the samples over all directions.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The samples of the next generation; shape `[population][n_coordinates]`.
    pub fn sample(&mut self) -> Vec<Vec<f64>> {
        let mut draws = Draws::new(self.seed, self.generation);
        let n = self.mean.len();
        let Axes { directions, lengths } = &self.axes;
        self.sampled = (0..self.constants.population)
            .map(|_| {
                let normal = DVector::from_fn(n, |_, _| draws.normal());
                directions * lengths.component_mul(&normal)
            })
            .collect();
        let point = |sampled: &DVector<f64>| (&self.mean + sampled * self.step).as_slice().to_vec();
        self.sampled.iter().map(point).collect()
    }

    /// Moves to the better ones of the last samples, by the cost of each in their order: less is
    /// better, and what is not a number is worst.
    ///
    /// # Panics
    ///
    /// If there is not one cost for each sample.
    pub fn update(&mut self, costs: &[f64]) {
        assert_eq!(costs.len(), self.sampled.len(), "a cost for each sample");
        let constants = &self.constants;
        let mut order: Vec<usize> = (0..costs.len()).collect();
        let cost = |index: usize| if costs[index].is_nan() { f64::INFINITY } else { costs[index] };
        order.sort_by(|one, other| cost(*one).total_cmp(&cost(*other)));
        let better: Vec<(f64, &DVector<f64>)> = constants
            .weights
            .iter()
            .zip(&order)
            .map(|(weight, index)| (*weight, &self.sampled[*index]))
            .collect();
        let n = self.mean.len();
        let moved = better.iter().fold(DVector::zeros(n), |sum, (weight, by)| sum + *by * *weight);
        self.mean += &moved * self.step;

        let Axes { directions, lengths } = &self.axes;
        let in_axes = directions.transpose() * &moved;
        let whitened = directions * in_axes.component_div(lengths);
        let kept = 1.0 - constants.step_rate;
        let gain =
            (constants.step_rate * (2.0 - constants.step_rate) * constants.n_effective).sqrt();
        self.step_path = &self.step_path * kept + whitened * gain;
        self.generation += 1;
        let length = self.step_path.norm();
        let faded = 1.0 - libm::pow(kept, 2.0 * self.generation as f64);
        let is_short =
            length / faded.sqrt() < (1.4 + 2.0 / (constants.n + 1.0)) * constants.normal_length;
        let rate = constants.path_rate;
        let gain =
            if is_short { (rate * (2.0 - rate) * constants.n_effective).sqrt() } else { 0.0 };
        self.shape_path = &self.shape_path * (1.0 - rate) + &moved * gain;

        let (one, many) = (constants.rank_one_rate, constants.rank_many_rate);
        let lacking = if is_short { 0.0 } else { one * rate * (2.0 - rate) };
        let mut covariance = &self.covariance * (1.0 - one - many + lacking);
        covariance += &self.shape_path * self.shape_path.transpose() * one;
        for (weight, by) in better {
            covariance += by * by.transpose() * (many * weight);
        }
        self.covariance = covariance;
        let relative = length / constants.normal_length - 1.0;
        self.step *= libm::exp(constants.step_rate / constants.step_damping * relative);
        self.axes = Axes::new(&self.covariance);
    }
}

impl Axes {
    fn new(covariance: &DMatrix<f64>) -> Self {
        let symmetric = (covariance + covariance.transpose()) * 0.5;
        let eigen = SymmetricEigen::new(symmetric);
        // Rounding may take a length that is hardly there below zero.
        let lengths = eigen.eigenvalues.map(|value| value.max(1e-30).sqrt());
        Self { directions: eigen.eigenvectors, lengths }
    }
}
