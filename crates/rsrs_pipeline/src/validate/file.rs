//! `validation.json`: whether a simulator was held against real trajectories, and what came out.

use std::collections::BTreeMap;
use std::path::Path;

use rsrs_core::capability::{CapabilityViolation, LostCapability, SensorViolation};
use rsrs_core::digest::Digest;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::TrialOrigin;
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::validation::Validation;
use serde::{Deserialize, Serialize};

use crate::files::{read_json_if_there, write_json};
use crate::provenance::ResultProvenance;
use crate::sweep::source::ResolvedSweep;

/// Name of the file in the folder of a sweep.
pub const NAME: &str = "validation.json";

/// Which simulated robot was judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The class whose robot was judged; not there where all robots have the profile of the sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Digest of the measured profile.
    pub profile_digest: String,
    /// How the simulated robot is worse.
    pub harsher: HarsherFactors,
    /// Capabilities that the sweep fixes, by axis.
    pub fixed: BTreeMap<String, f64>,
    /// Values on the capabilities that it sweeps, by axis; one of several robots was judged then.
    pub at: BTreeMap<String, f64>,
    /// Names the measured profile with what the sweep makes of it; without `at`.
    pub simulator_digest: String,
}

/// The answer.
#[derive(Clone, Debug, Serialize)]
pub struct ValidationReport {
    /// Which simulated robot was judged.
    #[serde(flatten)]
    pub judged: Judged,
    /// Whether trials are contained and the simulated robot is nowhere better.
    pub is_harsher: bool,
    /// Whether the trials are contained, and where they left.
    #[serde(flatten)]
    pub validation: Validation,
    /// Capabilities in which the simulated robot is better than the profile.
    pub capability_violations: Vec<CapabilityViolation>,
    /// Capabilities of which the factors leave it next to nothing.
    pub lost_capabilities: Vec<LostCapability>,
    /// Places at which detections contradict the simulated sensor; `None` if none were given.
    pub sensor_violations: Option<Vec<SensorViolation>>,
    /// The smallest factors with which the trials are contained; `None` if they are, or if no factor
    /// helps.
    pub smallest_factors: Option<HarsherFactors>,
    /// What the trajectories show of turning, if a profile with it contains them; then no factor is
    /// searched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turning: Option<Turning>,
    /// How far the trajectories and detections are a simulator's; `None` if they are those of robots.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trials_of: Option<TrialOrigin>,
    /// Where it comes from.
    pub provenance: ResultProvenance,
}

/// How real robots turn, where that is why they leave the simulated reach.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Turning {
    /// Time constant of their turning rate, in seconds; `None` if it is that of the profile.
    pub yaw_lag_s: Option<Estimate>,
    /// Gain of their turning rate while they drive; dimensionless; `None` if it is that of the profile.
    pub driving_gain: Option<Estimate>,
}

/// The part of an answer that is noted on pictures.
#[derive(Clone, Debug, Deserialize)]
pub struct StoredAnswer {
    /// Which simulated robot was judged.
    #[serde(flatten)]
    pub judged: Judged,
    /// Whether trials are contained and the simulated robot is nowhere better.
    pub is_harsher: bool,
    /// Whether the trials are contained.
    pub is_contained: bool,
    /// The share of simulated robots that the regions hold.
    pub share: f64,
    /// Number of trials.
    pub n_trials: usize,
    /// Those that are inside at every time.
    pub n_inside: usize,
    /// How far the trials are a simulator's; `None` if they are those of robots.
    #[serde(default)]
    pub trials_of: Option<TrialOrigin>,
}

impl Judged {
    /// The simulated robot of a sweep, at some values of the capabilities that it sweeps; if one
    /// class is judged, the sweep is that of the class.
    ///
    /// # Panics
    ///
    /// Never: what it serialises is numbers and texts.
    pub fn new(source: &ResolvedSweep, class: Option<&str>, at: &Cell) -> Self {
        let fixed = source.sweep.fixed.values.iter().filter(|(axis, _)| axis.is_capability());
        let fixed: BTreeMap<String, f64> =
            fixed.map(|(axis, value)| (axis.key().to_owned(), *value)).collect();
        let (profile_digest, harsher) =
            (source.profile.digest(), source.sweep.factors(&source.profile));
        let made = serde_json::to_string(&(&profile_digest, harsher, &fixed));
        let mut digest = Digest::new("simulator");
        digest.text(&made.expect("numbers and texts are plain data"));
        let objects = source.sweep.world().map(|world| &world.objects);
        if let Some(objects) = objects.filter(|objects| !objects.is_empty()) {
            let pushed = serde_json::to_string(objects);
            digest.text(&pushed.expect("numbers are plain data"));
        }
        Self {
            class: class.map(str::to_owned),
            profile_digest,
            harsher,
            fixed,
            at: at.iter().map(|(axis, value)| (axis.key().to_owned(), value)).collect(),
            simulator_digest: format!("{:016x}", digest.value()),
        }
    }

    /// Whether the sweep still has this robot.
    fn is_of(&self, source: &ResolvedSweep) -> bool {
        let is_same = |source: &ResolvedSweep| {
            self.simulator_digest == Self::new(source, None, &Cell::default()).simulator_digest
        };
        match &self.class {
            Some(class) => source.of_class(class).is_ok_and(|source| is_same(&source)),
            None => !source.has_profiles_of_classes() && is_same(source),
        }
    }
}

impl ValidationReport {
    /// Writes the answer into a folder.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        write_json(&folder.join(NAME), self)
    }
}

/// The answer that is kept in the folder of a sweep: whether its simulator was validated. One about
/// another profile or other factors than those of `source` does not count.
pub fn stored(folder: &Path, source: &ResolvedSweep) -> anyhow::Result<Option<StoredAnswer>> {
    let given: Option<StoredAnswer> =
        read_json_if_there(&folder.join(NAME), "no answer of `rsrs validate`")?;
    Ok(given.filter(|given| given.judged.is_of(source)))
}
