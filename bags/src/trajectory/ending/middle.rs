//! The middle of any number of numbers, in little memory and exactly.

/// How many numbers around the middle are kept; that of ten million independent numbers wanders by
/// a twentieth of this.
const N_KEPT: usize = 1 << 16;

/// Numbers of which those around the middle are kept, and of the others only how many there are.
#[derive(Default)]
pub struct Middle {
    n_below: usize,
    n_above: usize,
    /// What lies from the lower to the upper bound.
    kept: Vec<u64>,
    low: Option<u64>,
    high: Option<u64>,
}

impl Middle {
    /// How many numbers were added.
    pub fn len(&self) -> usize {
        self.n_below + self.kept.len() + self.n_above
    }

    /// Adds a number.
    pub fn add(&mut self, number: u64) {
        if self.low.is_some_and(|low| number < low) {
            self.n_below += 1;
        } else if self.high.is_some_and(|high| number > high) {
            self.n_above += 1;
        } else {
            self.kept.push(number);
            if self.kept.len() == 2 * N_KEPT {
                self.narrow();
            }
        }
    }

    /// The number at a place in the order of all, the least at zero; `None` if it was not kept.
    pub fn at(&mut self, place: usize) -> Option<u64> {
        let place = place.checked_sub(self.n_below).filter(|place| *place < self.kept.len())?;
        Some(*self.kept.select_nth_unstable(place).1)
    }

    /// Forgets what is far from the middle.
    fn narrow(&mut self) {
        self.kept.sort_unstable();
        let middle = (self.len() / 2).saturating_sub(self.n_below);
        let start = middle.saturating_sub(N_KEPT / 2).min(self.kept.len() - N_KEPT);
        self.n_above += self.kept.len() - start - N_KEPT;
        self.n_below += start;
        self.kept.truncate(start + N_KEPT);
        self.kept.drain(..start);
        self.low = self.kept.first().copied();
        self.high = self.kept.last().copied();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random enough (splitmix64).
    fn noise(n: u64) -> u64 {
        let mut mixed = n.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn both(numbers: &[u64]) -> (Option<u64>, u64) {
        let mut middle = Middle::default();
        for number in numbers {
            middle.add(*number);
        }
        let mut sorted = numbers.to_vec();
        sorted.sort_unstable();
        assert_eq!(middle.len(), numbers.len());
        (middle.at(numbers.len() / 2), sorted[numbers.len() / 2])
    }

    #[test]
    fn the_middle_of_a_million_numbers_is_that_of_all_of_them_sorted() {
        let spread: Vec<u64> =
            (0..1_000_000).map(|n| 130_000_000 + noise(n) % 20_000_000).collect();
        let equal = vec![130_000_000; 1_000_000];
        let two: Vec<u64> = (0..1_000_000).map(|n| 33_000_000 + noise(n) % 2).collect();

        for numbers in [spread, equal, two] {
            let (found, expected) = both(&numbers);

            assert_eq!(found, Some(expected));
        }
    }

    #[test]
    fn a_middle_that_wandered_away_is_not_made_up() {
        let rising: Vec<u64> = (0..1_000_000).collect();

        assert_eq!(both(&rising).0, None);
    }
}
