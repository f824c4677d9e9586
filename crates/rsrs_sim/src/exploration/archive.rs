//! The archive of what was found: of each niche the controller that leads to it most surely.

use std::collections::BTreeMap;

use super::Draws;
use super::niche::Niche;
use super::space::{Point, anywhere};

/// A controller and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Elite {
    /// The controller, as a point of its space.
    pub point: Point,
    /// Its number among all that were tried.
    pub number: usize,
    /// Share of its runs that ended in the niche.
    pub share: f64,
}

/// The best controller of each niche.
///
/// # Source
///
/// MAP-Elites: J.-B. Mouret and J. Clune, "Illuminating search spaces by mapping elites",
/// arXiv 1504.04909.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Archive {
    elites: BTreeMap<Niche, Elite>,
}

/// Standard deviation of a mutation, in parts of half the width of the space.
const MUTATION: f64 = 0.15;
/// Share of proposals that are new points rather than mutations.
const ANEW: f64 = 0.1;

impl Archive {
    /// Takes a controller into its niche if it leads there more surely than the one that is there,
    /// and says whether it did.
    pub fn offer(&mut self, niche: Niche, elite: Elite) -> bool {
        let is_better = self.elites.get(&niche).is_none_or(|there| elite.share > there.share);
        if is_better {
            self.elites.insert(niche, elite);
        }
        is_better
    }

    /// The controllers by niche.
    pub fn elites(&self) -> impl ExactSizeIterator<Item = (Niche, &Elite)> + '_ {
        self.elites.iter().map(|(niche, elite)| (*niche, elite))
    }

    /// Points to be tried next, `n` with `n_numbers` coordinates each: anywhere in the space as long as
    /// the archive is empty, and from then on mostly those near a controller of the archive. Seed and
    /// generation are those of their draws.
    pub fn propose(
        &self,
        (n, n_numbers): (usize, usize),
        seed: u64,
        generation: u64,
    ) -> Vec<Point> {
        let mut draws = Draws::new(seed, generation);
        let elites: Vec<&Elite> = self.elites.values().collect();
        let propose = |_| {
            if elites.is_empty() || draws.uniform() < ANEW {
                return anywhere(&mut draws, n_numbers);
            }
            let parent = elites[draws.below(elites.len())];
            let mut mutated =
                |coordinate: &f64| (coordinate + MUTATION * draws.normal()).clamp(-1.0, 1.0);
            parent.point.iter().map(&mut mutated).collect()
        };
        (0..n).map(propose).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::niche::{Clusters, Extent, Motion, Rotation};
    use super::*;

    const NICHE: Niche = Niche {
        rotation: Rotation::Full,
        extent: Extent::Near,
        clusters: Clusters::Loose,
        motion: Motion::Free,
    };

    #[test]
    fn a_niche_keeps_the_surest_controller_and_of_equals_the_first() {
        let mut archive = Archive::default();
        let elite = |number, share| Elite { point: vec![0.0; 4], number, share };

        let taken = [(1, 0.5), (2, 0.5), (3, 0.9), (4, 0.6)]
            .map(|(number, share)| archive.offer(NICHE, elite(number, share)));

        assert_eq!(taken, [true, false, true, false]);
        assert_eq!(archive.elites().next(), Some((NICHE, &elite(3, 0.9))));
    }

    #[test]
    fn proposals_stay_in_the_box_and_follow_from_seed_and_generation() {
        let mut archive = Archive::default();
        archive.offer(NICHE, Elite { point: vec![0.9, -0.9, 0.0, 1.0], number: 0, share: 1.0 });

        let proposed = archive.propose((500, 4), 7, 3);

        assert!(proposed.iter().flatten().all(|coordinate| coordinate.abs() <= 1.0));
        assert_eq!(proposed, archive.propose((500, 4), 7, 3));
        assert_ne!(proposed, archive.propose((500, 4), 7, 4));
        let is_near = |point: &&Point| (point[0] - 0.9).abs() < 0.46 && point[2].abs() < 0.46;
        assert!(proposed.iter().filter(is_near).count() > 400);
    }
}
