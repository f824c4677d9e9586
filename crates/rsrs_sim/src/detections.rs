//! Detections under way: what a sensor reports arrives some steps later.

/// The last detections of all robots: a ring of `latency + 1` rows.
pub struct Detections {
    n_robots: usize,
    n_rows: usize,
    rows: Vec<bool>,
    /// Robots with a latency of their own, and that.
    own_latencies: Vec<(usize, u32)>,
}

impl Detections {
    /// A ring in which nothing was detected before the start.
    pub fn new(n_robots: usize, latency_steps: u32) -> Self {
        let n_rows = latency_steps as usize + 1;
        let rows = vec![false; n_rows * n_robots];
        Self { n_robots, n_rows, rows, own_latencies: Vec::new() }
    }

    /// The same, where some robots have a latency of their own; shape `[n_robots]`.
    pub fn with_latencies(latency_steps: &[u32]) -> Self {
        let longest = latency_steps.iter().copied().max().unwrap_or_default();
        let of_robots = latency_steps.iter().copied().enumerate();
        Self {
            own_latencies: of_robots.filter(|(_, steps)| *steps < longest).collect(),
            ..Self::new(latency_steps.len(), longest)
        }
    }

    /// Puts what was written into the row of a step where it is delivered in time: detections of robots
    /// with a shorter latency overtake those of the others.
    pub fn overtake(&mut self, step: u64) {
        for (robot, latency_steps) in &self.own_latencies {
            let made = self.rows[self.start(step) + robot];
            // The row that is delivered so many steps from now.
            let ahead = self.start(step + 1 + u64::from(*latency_steps));
            self.rows[ahead + robot] = made;
        }
    }

    /// Where the detections that are made in a step are to be written; shape `[n_robots]`.
    pub fn row_mut(&mut self, step: u64) -> &mut [bool] {
        let start = self.start(step);
        &mut self.rows[start..start + self.n_robots]
    }

    /// The detections that arrive in a step: those made `latency` steps before; shape `[n_robots]`.
    pub fn delivered(&self, step: u64) -> &[bool] {
        self.row(step + 1)
    }

    /// All detections made before a step that arrive in it or later, the oldest first; shape
    /// `[latency * n_robots]`, less those that robots with a shorter latency do not have.
    pub fn under_way(&self, step: u64) -> impl Iterator<Item = &bool> {
        (1..self.n_rows as u64).flat_map(move |age| {
            let has = move |robot: usize| {
                let own = self.own_latencies.iter().find(|(other, _)| *other == robot);
                own.is_none_or(|(_, latency_steps)| age <= u64::from(*latency_steps))
            };
            let row = self.row(step + age).iter().enumerate();
            row.filter(move |(robot, _)| has(*robot)).map(|(_, detection)| detection)
        })
    }

    fn row(&self, step: u64) -> &[bool] {
        let start = self.start(step);
        &self.rows[start..start + self.n_robots]
    }

    fn start(&self, step: u64) -> usize {
        let row = step % self.n_rows as u64;
        row as usize * self.n_robots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_robot_has_its_own_latency() {
        for latencies in [[3, 0, 1, 3], [0; 4], [2; 4]] {
            let mut detections = Detections::with_latencies(&latencies);
            let made = |robot: usize, step: u64| (step * 7 + robot as u64 * 3).is_multiple_of(4);

            for step in 0..40_u64 {
                let of_robot = |robot: usize| {
                    let before =
                        |back: u64| step.checked_sub(back).is_some_and(|at| made(robot, at));
                    let latency = u64::from(latencies[robot]);
                    (before(latency), (1..=latency).rev().map(before).collect::<Vec<_>>())
                };
                // Those that arrive first come first, and within a step the robots in their order.
                let arriving = |age: usize| {
                    let robots =
                        (0..latencies.len()).filter(move |robot| age < latencies[*robot] as usize);
                    robots.map(|robot| of_robot(robot).1[age]).collect::<Vec<_>>()
                };
                let under_way: Vec<bool> = (0..3).flat_map(arriving).collect();
                assert_eq!(
                    detections.under_way(step).copied().collect::<Vec<_>>(),
                    under_way,
                    "{step}"
                );

                for (robot, detection) in detections.row_mut(step).iter_mut().enumerate() {
                    *detection = made(robot, step);
                }
                detections.overtake(step);

                let delivered: Vec<bool> =
                    (0..latencies.len()).map(|robot| of_robot(robot).0).collect();
                assert_eq!(detections.delivered(step), delivered, "{latencies:?} {step}");
            }
        }
    }
}
