//! In which order a world keeps its robots.
//!
//! Robots have numbers that never change. A large world keeps those next to each other in memory
//! that are next to each other on the floor, so that who looks around finds its neighbours in the
//! cache. No robot's step depends on that order.

/// Numbers of robots and their places in memory.
pub struct Numbering {
    /// Who is kept at each place.
    robots: Vec<u32>,
    /// Where each robot is kept.
    places: Vec<u32>,
}

impl Numbering {
    /// Robots in the order of their numbers.
    pub fn new(n_robots: usize) -> Self {
        let robots: Vec<u32> = (0..n_robots as u32).collect();
        Self { places: robots.clone(), robots }
    }

    /// Who is kept at each place; shape `[n_robots]`.
    pub fn robots(&self) -> &[u32] {
        &self.robots
    }

    /// Where each robot is kept; shape `[n_robots]`.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    /// What is kept at places, in the order of the robots.
    pub fn by_robot<'a, T: Copy>(&'a self, column: &'a [T]) -> impl Iterator<Item = T> + 'a {
        self.places.iter().map(|place| column[*place as usize])
    }

    /// Keeps at each place what was kept at another until now.
    pub fn reorder(&mut self, order: &[u32]) {
        reorder(&mut self.robots, order);
        for (place, robot) in self.robots.iter().enumerate() {
            self.places[*robot as usize] = place as u32;
        }
    }
}

/// Moves to each place what is at another.
pub fn reorder<T: Copy>(column: &mut Vec<T>, order: &[u32]) {
    *column = order.iter().map(|place| column[*place as usize]).collect();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_is_found_however_often_it_is_moved() {
        let mut numbering = Numbering::new(4);
        let mut names = vec!['a', 'b', 'c', 'd'];

        for order in [[2, 0, 3, 1], [1, 0, 2, 3], [3, 2, 1, 0]] {
            numbering.reorder(&order);
            reorder(&mut names, &order);

            assert_eq!(numbering.by_robot(&names).collect::<String>(), "abcd");
            for (place, robot) in numbering.robots().iter().enumerate() {
                assert_eq!(numbering.places()[*robot as usize], place as u32);
            }
        }
    }
}
