//! What the swarms did lately: a row of bodies for each step, in a ring, and where it matters what
//! each robot was commanded.

use rsrs_core::judge::number::Number;

use super::sense::Body;

/// The last states of many worlds.
pub struct Rows<F: Number> {
    n_robots: usize,
    /// Rows in the ring.
    capacity: usize,
    bodies: Vec<Body<F>>,
    /// Whether each robot answered a detection; empty where both answers are alike for the judge.
    detected: Vec<F::Mask>,
}

/// A step: the bodies before it, where those after it are to be written, and where what robots
/// detected is.
pub type RowStep<'a, F> = (&'a [Body<F>], &'a mut [Body<F>], &'a mut [<F as Number>::Mask]);

impl<F: Number> Rows<F> {
    /// A ring without rows.
    pub fn new() -> Self {
        Self { n_robots: 0, capacity: 0, bodies: Vec::new(), detected: Vec::new() }
    }

    /// Makes room for this many rows, at least two; what they hold does not matter.
    pub fn resize(&mut self, n_robots: usize, n_rows: usize, filling: F) {
        assert!(n_rows >= 2, "a step needs a row to start from and a row to end in");
        let body = Body { x_m: filling, y_m: filling, cosine: filling, sine: filling };
        if self.bodies.len() < n_robots * n_rows {
            self.bodies.resize(n_robots * n_rows, body);
        }
        self.detected.clear();
        (self.n_robots, self.capacity) = (n_robots, n_rows);
    }

    /// Keeps from now on what robots detected, too.
    pub fn keep_detections(&mut self, no: F::Mask) {
        self.detected.resize(self.n_robots * self.capacity, no);
    }

    /// The state after so many steps; shape `[n_robots]`.
    #[inline(always)]
    pub fn at(&self, step: u64) -> &[Body<F>] {
        let start = self.start(step);
        &self.bodies[start..start + self.n_robots]
    }

    /// What a robot detected in this step, if that is kept.
    #[inline(always)]
    pub fn detected(&self, step: u64, robot: usize) -> F::Mask {
        self.detected[self.start(step) + robot]
    }

    /// Where the state after so many steps is to be written; shape `[n_robots]`.
    pub fn at_mut(&mut self, step: u64) -> &mut [Body<F>] {
        let start = self.start(step);
        &mut self.bodies[start..start + self.n_robots]
    }

    /// The state after so many steps, where the next one is to be written, and where what is detected
    /// in between; that is empty where it is not kept.
    #[inline(always)]
    pub fn step(&mut self, step: u64) -> RowStep<'_, F> {
        let (from, n_robots) = (self.start(step), self.n_robots);
        let after = from + n_robots;
        let to = if after == self.n_robots * self.capacity { 0 } else { after };
        let detected = if self.detected.is_empty() {
            &mut self.detected[..]
        } else {
            &mut self.detected[from..from + n_robots]
        };
        if from < to {
            let (before, after) = self.bodies.split_at_mut(to);
            (&before[from..from + n_robots], &mut after[..n_robots], detected)
        } else {
            let (before, after) = self.bodies.split_at_mut(from);
            (&after[..n_robots], &mut before[to..to + n_robots], detected)
        }
    }

    #[inline(always)]
    fn start(&self, step: u64) -> usize {
        (step % self.capacity as u64) as usize * self.n_robots
    }
}
