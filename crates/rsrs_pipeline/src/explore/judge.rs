//! What a run is called, whoever made it: by the names of a search, for what was found to be held against robots.

use std::path::Path;

use rsrs_core::conditions::Conditions;
use rsrs_core::exploration::ExplorationSettings;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::label_with;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_sim::exploration::niche::Niche;
use rsrs_sim::exploration::space::Directions;

use super::ExploreOptions;
use super::file_names::{PROFILE, SETTINGS};
use super::trial::{Name, TestBed};
use crate::error::helped;
use crate::execution::Execution;
use crate::files::read_text;
use crate::sweep::source::read_profile;

/// Calls runs by the names of a search, in its arena, with its robots as measured.
pub struct Judge {
    conditions: Conditions,
    inradius_m: Option<f64>,
}

/// What a run shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// Everything that it may be called: a run that mills in one cluster also aggregates.
    pub names: Vec<&'static str>,
    /// In few words.
    pub niche: Niche,
    /// What its judged window shows.
    pub evidence: OrderParameters,
}

impl Judge {
    /// The judge of the search in a folder.
    pub fn of_search(folder: &Path) -> anyhow::Result<Self> {
        let robots = read_profile(&folder.join(PROFILE))?;
        let file = folder.join(SETTINGS);
        let settings = ExplorationSettings::parse(&file.display().to_string(), &read_text(&file)?)
            .map_err(helped)?;
        let has_arena = settings.world.as_ref().is_some_and(|world| world.arena.is_some());
        let options = ExploreOptions {
            wanted: settings.behaviour,
            controller: settings.controller.as_ref(),
            world: settings.world.as_ref(),
            // Where they start is no part of what a run shows.
            starts: None,
            robots: settings.robots,
            arena_m: (!has_arena).then_some(settings.arena_m),
            walls: settings.walls,
            directions: if settings.backward { Directions::Both } else { Directions::Forward },
            controllers: 1,
            replicates: settings.replicates,
            duration_s: settings.duration_s,
            seed: settings.seed,
            execution: Execution::unobserved(),
        };
        let conditions = TestBed::new(&robots, &options)?.as_measured().map_err(helped)?;
        let inradius_m = conditions.free_space().map(|space| space.inradius_m());
        Ok(Self { conditions, inradius_m })
    }

    /// What a run shows, if it is long enough and has the robots of the search.
    pub fn see(&self, run: &Trajectory) -> anyhow::Result<Seen> {
        let expected = self.conditions.robots;
        anyhow::ensure!(
            run.n_robots == expected,
            "the run has {} robots, expected {expected} as the search",
            run.n_robots
        );
        let bodies = self.conditions.bodies();
        let also = Niche::looks_also_at(&self.conditions).to_vec();
        let rules = Rules { also, ..self.conditions.behaviour.rules() };
        let evidence = label_with(run, &bodies, &rules)?.evidence;
        let niche = Niche::new(&self.conditions, &evidence, self.inradius_m);
        let mut names = Vec::new();
        for behaviour in Behaviour::all() {
            if label_with(run, &bodies, &behaviour.rules())?.phase == behaviour.wanted() {
                names.push(behaviour.key());
            }
        }
        let others = Name::OF_NICHES.into_iter();
        names.extend(others.filter(|name| name.is_shown_in(niche, &evidence)).map(Name::key));
        Ok(Seen { names, niche, evidence })
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::Walls;

    use super::*;
    use crate::explore::explore;

    #[test]
    fn a_run_that_shows_what_was_found_is_called_so() {
        let place = tempfile::tempdir().unwrap();
        let profile =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../../launch_configs/profiles/flockbot.yaml");
        let folder = place.path().join("found");
        let options = ExploreOptions {
            wanted: None,
            controller: None,
            world: None,
            starts: None,
            robots: 6,
            arena_m: Some(3.0),
            walls: Walls::Stop,
            directions: Directions::Both,
            controllers: 200,
            replicates: 4,
            duration_s: 120.0,
            seed: 1,
            execution: Execution::unobserved(),
        };
        let explored = explore(Path::new(profile), &folder, &options).unwrap();

        let judge = Judge::of_search(&folder).unwrap();

        let mut names = std::collections::BTreeSet::new();
        for (found, run) in explored.found.iter().zip(&explored.runs) {
            let seen = judge.see(&run.trajectory).unwrap();
            // What is within reach of the robots as measured is farther than what is of those made worse.
            if !["dispersal", "other"].contains(&found.name.as_str()) {
                assert!(seen.names.contains(&found.name.as_str()), "{}: {seen:?}", found.name);
                names.insert(found.name.clone());
            }
        }
        assert!(names.len() >= 3, "{names:?}");
        let other = Trajectory::new(0.1, 5);
        assert_eq!(
            judge.see(&other).unwrap_err().to_string(),
            "the run has 5 robots, expected 6 as the search"
        );
    }
}
