//! What a swarm did, in few words: the niche of a run.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::order::{OrderParameters, Parameter};
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
    /// As far as the walls, or along obstacles.
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

/// Robots that are this much of the way to the walls are at them. In a plain square the way is that of the mean
/// distance from the centroid: a ring that touches all four walls is at 1, robots in the corners are farther. In any
/// other arena it is that from the place with most room to the nearest wall or obstacle.
const AT_WALLS: f64 = 0.85;

impl Niche {
    /// The niche of a run, by what its judged window shows, [`Self::looks_also_at`] included;
    /// `inradius_m` is that of an arena that is no plain square, the radius of the largest disc
    /// that fits into it.
    pub fn new(
        conditions: &Conditions,
        evidence: &OrderParameters,
        inradius_m: Option<f64>,
    ) -> Self {
        let robot = &conditions.robot;
        let reach_m = robot.region.reach_m(robot.sees, robot.radius_m);
        let to_walls_m = (conditions.arena.side_m / 2.0 - robot.radius_m).max(0.0);
        let radius_m = evidence.mean_radius_m;
        let is_at_walls = match (inradius_m, Parameter::WALL_DISTANCE.value(evidence)) {
            (Some(inradius_m), Some(distance_m)) => {
                let room_m = (inradius_m - robot.radius_m).max(0.0);
                distance_m - robot.radius_m <= (1.0 - AT_WALLS) * room_m
            }
            _ => radius_m >= AT_WALLS * to_walls_m,
        };
        Self {
            rotation: match evidence.rotation {
                full if full >= 0.8 => Rotation::Full,
                some if some >= 0.3 => Rotation::Some,
                _ => Rotation::None,
            },
            extent: match radius_m {
                _ if is_at_walls => Extent::AtWalls,
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

    /// Order parameters that niches in this arena are made of and that nobody measures who is not asked to.
    pub fn looks_also_at(conditions: &Conditions) -> &'static [Parameter] {
        if conditions.free_space().is_some() { &[Parameter::WALL_DISTANCE] } else { &[] }
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

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::Settings;
    use rsrs_core::quantity::Axis;
    use rsrs_core::world::WorldFile;

    use super::*;

    use rsrs_testing::conditions::flockbot;

    /// Whether robots are at the walls of a world, by their mean distance from the centroid and from the nearest wall.
    fn are_at_walls(world: &str, [radius_m, wall_m]: [f64; 2]) -> bool {
        let profile = flockbot();
        let values = [(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 4.0)];
        let settings = Settings {
            values: values.into(),
            world: WorldFile::parse("world.yaml", world, &[4.0], &[4]).unwrap(),
            ..Settings::default()
        };
        let conditions = Conditions::resolve(&profile, &settings).unwrap();
        let inradius_m = conditions.free_space().map(|space| space.inradius_m());
        let mut evidence =
            OrderParameters { mean_radius_m: radius_m, ..OrderParameters::default() };
        for parameter in Niche::looks_also_at(&conditions) {
            parameter.set(&mut evidence, wall_m);
        }
        Niche::new(&conditions, &evidence, inradius_m).extent == Extent::AtWalls
    }

    #[test]
    fn robots_are_at_the_walls_of_whatever_arena_they_are_in() {
        let disc = "arena: {disc_m: 2}";
        let hall = "arena: {rectangle_m: [6, 1.6]}";
        let pillar = "arena: {disc_m: 2}\nobstacles: [{place_m: [0, 0], radius_m: 0.5}]";

        // A ring along the wall, 5 cm from it, and one with as much room again.
        assert!(are_at_walls(disc, [1.87, 0.13]));
        assert!(!are_at_walls(disc, [1.5, 0.5]));
        // Robots along the long walls of a hall are not far from their centroid.
        assert!(are_at_walls(hall, [1.6, 0.1]));
        assert!(!are_at_walls(hall, [1.6, 0.5]));
        // Who goes around a pillar is.
        assert!(are_at_walls(pillar, [0.65, 0.15]));
        assert!(!are_at_walls(pillar, [1.2, 0.6]));
    }

    #[test]
    fn in_a_plain_square_they_are_where_their_mean_radius_reaches_the_walls() {
        let values = vec![
            (Axis::Speed, 0.15),
            (Axis::TurnRate, 0.75),
            (Axis::Robots, 4.0),
            (Axis::Arena, 4.0),
        ];
        let profile = flockbot();
        let settings = Settings { values, ..Settings::default() };
        let conditions = Conditions::resolve(&profile, &settings).unwrap();
        let extent = |mean_radius_m| {
            let evidence = OrderParameters { mean_radius_m, ..OrderParameters::default() };
            Niche::new(&conditions, &evidence, None).extent
        };

        assert!(Niche::looks_also_at(&conditions).is_empty());
        assert_eq!(extent(0.86 * 1.925), Extent::AtWalls);
        assert_ne!(extent(0.84 * 1.925), Extent::AtWalls);
    }
}
