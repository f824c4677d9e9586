//! How much more often robots do as is wanted in one set of runs of a cell than in another.

use rsrs_core::statistics::interval_kind::IntervalKind;
use rsrs_core::statistics::share::Share;

/// Two shares of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShareDifference {
    /// The share before.
    pub from: Share,
    /// The share after.
    pub to: Share,
    /// The kind of the interval of each.
    pub kinds: [IntervalKind; 2],
}

impl ShareDifference {
    /// How much greater the share is after.
    pub fn difference(&self) -> f64 {
        self.to.value() - self.from.value()
    }

    /// Whether the 95 % intervals do not overlap.
    pub fn has_moved(&self) -> bool {
        let from = self.kinds[0].interval(self.from.hits, self.from.n);
        let to = self.kinds[1].interval(self.to.hits, self.to.n);
        from.high < to.low || to.high < from.low
    }
}
