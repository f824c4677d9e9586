//! Detections under way: what a sensor reports arrives some steps later.

/// The last detections of all robots: a ring of `latency + 1` rows.
pub struct Detections {
    n_robots: usize,
    n_rows: usize,
    rows: Vec<bool>,
}

impl Detections {
    /// A ring in which nothing was detected before the start.
    pub fn new(n_robots: usize, latency_steps: u32) -> Self {
        let n_rows = latency_steps as usize + 1;
        Self { n_robots, n_rows, rows: vec![false; n_rows * n_robots] }
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
    /// `[latency * n_robots]`.
    pub fn under_way(&self, step: u64) -> impl Iterator<Item = &bool> {
        (1..self.n_rows as u64).flat_map(move |age| self.row(step + age))
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
    fn a_detection_arrives_after_the_latency_and_nothing_before() {
        for latency in 0..4 {
            let mut detections = Detections::new(1, latency);

            let delivered: Vec<bool> = (0..8)
                .map(|step| {
                    detections.row_mut(step)[0] = step == 2;
                    detections.delivered(step)[0]
                })
                .collect();

            let arrival = delivered.iter().position(|detected| *detected);
            assert_eq!(arrival, Some(2 + latency as usize));
            assert_eq!(delivered.iter().filter(|detected| **detected).count(), 1);
        }
    }

    #[test]
    fn what_is_under_way_is_what_was_made_and_not_yet_delivered() {
        let mut detections = Detections::new(1, 3);
        for step in 0..5 {
            detections.row_mut(step)[0] = step == 2;
        }

        assert_eq!(detections.under_way(5).collect::<Vec<_>>(), [&true, &false, &false]);
    }
}
