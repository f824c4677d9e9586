//! What a swarm did, in few words: the niche of a run.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::order::OrderParameters;
use serde::{Deserialize, Serialize};

/// How a swarm moved in the judged window, apart from which robot did what.
///
/// # Source
///
/// Scatter, radial variance and group rotation are the descriptors of D. S. Brown et al., DARS 2018;
/// here in the bins that a person would distinguish.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Niche {
    /// Whether headings circle the centroid.
    pub rotation: Rotation,
    /// How far from the centroid robots are.
    pub extent: Extent,
    /// How many are close together.
    pub clusters: Clusters,
    /// How often robots come to where they are commanded.
    pub motion: Motion,
}

/// Whether headings circle the centroid, by the normalised angular momentum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rotation {
    /// Below 0.3.
    None,
    /// From 0.3 to 0.8.
    Some,
    /// 0.8 and more.
    Full,
}

/// How far from the centroid robots are, on average.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Extent {
    /// Within half of a robot's reach.
    Narrow,
    /// Within the reach.
    Near,
    /// Within twice the reach.
    Wide,
    /// Farther.
    Far,
    /// As far as the walls.
    AtWalls,
}

/// How many robots the largest cluster has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clusters {
    /// Less than half of them.
    Loose,
    /// Half of them or more.
    Half,
    /// Nine tenths or more.
    One,
}

/// How often robots come to where they are commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Blocked for less than a quarter of the time.
    Free,
    /// More often.
    Blocked,
}

/// Robots that are this much of the way to the walls are at them: a ring that touches all four is at
/// 1, robots in the corners are farther.
const AT_WALLS: f64 = 0.85;

impl Niche {
    /// The niche of a run.
    ///
    /// # Arguments
    ///
    /// * `conditions` — its robots and arena.
    /// * `evidence` — what its judged window shows.
    pub fn of(conditions: &Conditions, evidence: &OrderParameters) -> Self {
        let robot = &conditions.robot;
        let reach_m = robot.region.reach_m(robot.sees, robot.radius_m);
        let to_walls_m = (conditions.arena.side_m / 2.0 - robot.radius_m).max(0.0);
        let radius_m = evidence.mean_radius_m;
        Self {
            rotation: match evidence.rotation {
                full if full >= 0.8 => Rotation::Full,
                some if some >= 0.3 => Rotation::Some,
                _ => Rotation::None,
            },
            extent: match radius_m {
                far if far >= AT_WALLS * to_walls_m => Extent::AtWalls,
                narrow if narrow < reach_m / 2.0 => Extent::Narrow,
                near if near < reach_m => Extent::Near,
                wide if wide < 2.0 * reach_m => Extent::Wide,
                _ => Extent::Far,
            },
            clusters: match evidence.clustered.unwrap_or(0.0) {
                one if one >= 0.9 => Clusters::One,
                half if half >= 0.5 => Clusters::Half,
                _ => Clusters::Loose,
            },
            motion: if evidence.blocked >= 0.25 { Motion::Blocked } else { Motion::Free },
        }
    }

    /// What it looks like, in words: `circling, within reach of each other`.
    pub fn in_words(self) -> String {
        let rotation = match self.rotation {
            Rotation::None => "not circling",
            Rotation::Some => "partly circling",
            Rotation::Full => "circling",
        };
        let extent = match self.extent {
            Extent::Narrow => "within half of the reach around their centre",
            Extent::Near => "within the reach around their centre",
            Extent::Wide => "within twice the reach around their centre",
            Extent::Far => "farther than twice the reach from their centre",
            Extent::AtWalls => "as far out as the walls",
        };
        let clusters = match self.clusters {
            Clusters::Loose => "",
            Clusters::Half => ", half of them in one cluster",
            Clusters::One => ", in one cluster",
        };
        let motion = match self.motion {
            Motion::Free => "",
            Motion::Blocked => ", blocked for much of the time",
        };
        format!("{rotation}, {extent}{clusters}{motion}")
    }
}
