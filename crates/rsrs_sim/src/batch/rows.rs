//! What the swarms did lately: a row of bodies for each step, in a ring.

use super::sense::Body;

/// The last states of many worlds.
pub struct Rows<F> {
    n_robots: usize,
    /// Rows in the ring.
    capacity: usize,
    bodies: Vec<Body<F>>,
}

impl<F: Copy> Rows<F> {
    /// A ring without rows.
    pub fn new() -> Self {
        Self { n_robots: 0, capacity: 0, bodies: Vec::new() }
    }

    /// Makes room for this many rows, at least two; what they hold does not matter.
    pub fn resize(&mut self, n_robots: usize, n_rows: usize, filling: F) {
        assert!(n_rows >= 2, "a step needs a row to start from and a row to end in");
        let body = Body { x_m: filling, y_m: filling, cosine: filling, sine: filling };
        if self.bodies.len() < n_robots * n_rows {
            self.bodies.resize(n_robots * n_rows, body);
        }
        (self.n_robots, self.capacity) = (n_robots, n_rows);
    }

    /// The state after so many steps; shape `[n_robots]`.
    #[inline(always)]
    pub fn at(&self, step: u64) -> &[Body<F>] {
        let start = self.start(step);
        &self.bodies[start..start + self.n_robots]
    }

    /// Where the state after so many steps is to be written; shape `[n_robots]`.
    pub fn at_mut(&mut self, step: u64) -> &mut [Body<F>] {
        let start = self.start(step);
        &mut self.bodies[start..start + self.n_robots]
    }

    /// The state after so many steps, and where the next one is to be written.
    #[inline(always)]
    pub fn step(&mut self, step: u64) -> (&[Body<F>], &mut [Body<F>]) {
        let (from, n_robots) = (self.start(step), self.n_robots);
        let after = from + n_robots;
        let to = if after == self.n_robots * self.capacity { 0 } else { after };
        if from < to {
            let (before, after) = self.bodies.split_at_mut(to);
            (&before[from..from + n_robots], &mut after[..n_robots])
        } else {
            let (before, after) = self.bodies.split_at_mut(from);
            (&after[..n_robots], &mut before[to..to + n_robots])
        }
    }

    #[inline(always)]
    fn start(&self, step: u64) -> usize {
        (step % self.capacity as u64) as usize * self.n_robots
    }
}
