//! When each lane began to be a stable mill: the first of [`GOOD_BLOCKS`] good blocks in a row.
//!
//! Of any so many blocks in a row exactly one has a number that is one less than a multiple of
//! them. So only those are asked, and their neighbours where one of them is good: a lane that never
//! becomes a mill is asked of every third block.

use rsrs_core::phase::GOOD_BLOCKS;

/// How far around the block that is asked first others may be asked.
pub const AROUND: u64 = GOOD_BLOCKS as u64 - 1;

/// The first good blocks of lanes.
pub struct Converging {
    /// Where the row of good blocks begins.
    first_blocks: Vec<Option<u64>>,
    /// The blocks asked last, and the lanes in which they were good: asking of one lane or of all
    /// costs the same.
    known: Vec<(u64, u32)>,
}

impl Converging {
    /// So many lanes, of which nothing is known.
    pub fn new(n_lanes: usize) -> Self {
        Self { first_blocks: vec![None; n_lanes], known: Vec::new() }
    }

    /// The blocks that are to be asked, of so many.
    pub fn asked(n_blocks: u64) -> impl Iterator<Item = u64> {
        (AROUND..n_blocks).step_by(GOOD_BLOCKS)
    }

    /// The lanes that have not yet become a mill, as bits.
    pub fn open(&self) -> u32 {
        let lanes = self.first_blocks.iter().enumerate();
        lanes.fold(0, |open, (lane, first)| open | u32::from(first.is_none()) << lane)
    }

    /// Looks for a row of good blocks around one of those that are to be asked.
    ///
    /// # Arguments
    ///
    /// * `asked` — its number; those before it were searched.
    /// * `n_blocks` — how many blocks there are.
    /// * `good` — of a block and lanes as bits: those in which the block is good.
    pub fn search(&mut self, asked: u64, n_blocks: u64, good: impl FnMut(u64, u32) -> u32) {
        let open = self.open();
        let mut known = std::mem::take(&mut self.known);
        known.retain(|(block, _)| block + AROUND >= asked);
        let mut memory = Memory { open, known, good };
        self.search_with(&mut memory, asked, n_blocks);
        self.known = memory.known;
    }

    fn search_with<G: FnMut(u64, u32) -> u32>(
        &mut self,
        memory: &mut Memory<G>,
        asked: u64,
        n_blocks: u64,
    ) {
        let found = memory.good(asked, memory.open);
        let mut lengths = vec![0; self.first_blocks.len()];
        let mut firsts = vec![asked; self.first_blocks.len()];
        let mut row = found;
        for block in (asked - AROUND..=asked).rev() {
            if block < asked {
                row = memory.good(block, row);
            }
            for lane in lanes(row) {
                lengths[lane] += 1;
                firsts[lane] = block;
            }
        }
        let mut row = found & !self.settle(&lengths, &firsts);
        for block in asked + 1..n_blocks.min(asked + AROUND + 1) {
            row = memory.good(block, row);
            for lane in lanes(row) {
                lengths[lane] += 1;
            }
            row &= !self.settle(&lengths, &firsts);
        }
    }

    /// Keeps where rows begin that are long enough. Returns their lanes.
    fn settle(&mut self, lengths: &[usize], firsts: &[u64]) -> u32 {
        let mut settled = 0;
        for (lane, (length, first)) in lengths.iter().zip(firsts).enumerate() {
            if *length == GOOD_BLOCKS {
                self.first_blocks[lane].get_or_insert(*first);
                settled |= 1 << lane;
            }
        }
        settled
    }

    /// Where the row of good blocks begins, for each lane.
    pub fn first_blocks(self) -> Vec<Option<u64>> {
        self.first_blocks
    }
}

/// What is known of blocks, and who says more.
struct Memory<G> {
    open: u32,
    known: Vec<(u64, u32)>,
    good: G,
}

impl<G: FnMut(u64, u32) -> u32> Memory<G> {
    /// In which of some open lanes a block is good.
    fn good(&mut self, block: u64, lanes: u32) -> u32 {
        if lanes == 0 {
            return 0;
        }
        if let Some((_, good)) = self.known.iter().find(|(known, _)| *known == block) {
            return lanes & good;
        }
        let good = (self.good)(block, self.open);
        self.known.push((block, good));
        lanes & good
    }
}

/// The lanes of bits.
pub fn lanes(bits: u32) -> impl Iterator<Item = usize> {
    (0..u32::BITS as usize).filter(move |lane| bits >> lane & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const N_BLOCKS: u64 = 10;

    /// The definition: the first so many good blocks in a row.
    fn by_definition(good: u32, n_blocks: u64) -> Option<u64> {
        let is_row = |first: &u64| (*first..first + GOOD_BLOCKS as u64).all(|b| good >> b & 1 == 1);
        (0..(n_blocks + 1).saturating_sub(GOOD_BLOCKS as u64)).find(is_row)
    }

    #[test]
    fn every_row_of_good_blocks_is_found_where_it_begins() {
        for n_blocks in 0..=N_BLOCKS {
            for lane_0 in 0..1 << n_blocks {
                // Another lane beside it, which must not matter.
                let lane_1 = (lane_0 * 37 + 11) & ((1 << n_blocks) - 1);
                let mut converging = Converging::new(2);

                for asked in Converging::asked(n_blocks) {
                    converging.search(asked, n_blocks, |block, open| {
                        assert!(block < n_blocks && open != 0);
                        open & ((lane_0 >> block & 1) | (lane_1 >> block & 1) << 1)
                    });
                    if converging.open() == 0 {
                        break;
                    }
                }

                let expected = [lane_0, lane_1].map(|good| by_definition(good, n_blocks));
                assert_eq!(converging.first_blocks(), expected, "{lane_0:b} {lane_1:b}");
            }
        }
    }

    #[test]
    fn a_lane_that_never_becomes_a_mill_is_asked_of_every_third_block() {
        let mut n_asked = 0;
        let mut converging = Converging::new(1);

        for asked in Converging::asked(30) {
            converging.search(asked, 30, |_, _| {
                n_asked += 1;
                0
            });
        }

        assert_eq!(n_asked, 10);
    }
}
