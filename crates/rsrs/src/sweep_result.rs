//! What a sweep is once it is finished, wherever it is kept.

use rsrs_core::diagram::PhaseDiagram;

use crate::sweep_source::ResolvedSweep;

/// A finished sweep.
#[derive(Clone, Debug)]
pub struct SweepResult {
    /// What was swept.
    pub source: ResolvedSweep,
    /// What came out.
    pub diagram: PhaseDiagram,
}
