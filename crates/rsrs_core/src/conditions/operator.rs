//! Whether a real run was made under the conditions that were simulated.

use serde::{Deserialize, Serialize};

use crate::conditions::{Arena, Conditions, Placement};
use crate::judge::behaviour::Behaviour;
use crate::numerals::SAME;
use crate::quantity::{Axis, Number};
use crate::robot::controller::{Controller, ControllerParameters, decide};
use crate::world::WorldFile;

/// The part of the conditions `E` that the operator of a real run decides, and must keep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OperatorConditions {
    /// Number of robots.
    pub robots: usize,
    /// What every robot's controller was set to.
    pub controller: Controller,
    /// What the run is judged for; milling where a file does not name it.
    #[serde(default, skip_serializing_if = "Behaviour::is_usual")]
    pub behaviour: Behaviour,
    /// Where the robots started.
    pub placement: Placement,
    /// Where they could go.
    pub arena: Arena,
    /// What was there besides them.
    #[serde(default, skip_serializing_if = "WorldFile::is_empty")]
    pub world: WorldFile,
    /// How long the run was set to last, in seconds.
    pub duration_s: f64,
}

/// A run of another experiment, which is no evidence about a diagram.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{aspect} is {found}, expected {expected} as simulated")]
pub struct Incomparable {
    /// What differs.
    pub aspect: String,
    /// In the run, with unit.
    pub found: String,
    /// In the simulation, with unit.
    pub expected: String,
}

/// The values that an operator sets on the axes of every robot's controller: speed and turning rate, and those where
/// nothing is detected if the controller is not a mirrored one; of a table its numbers.
pub fn controller_values(controller: &Controller) -> Vec<(Axis, f64)> {
    match controller {
        Controller::Parameters(parameters) => {
            let ControllerParameters { speed_m_s, turn_rate_rad_s, undetected } = *parameters;
            let mut values = vec![(Axis::Speed, speed_m_s), (Axis::TurnRate, turn_rate_rad_s)];
            if let Some(undetected) = undetected {
                values.push((Axis::UndetectedSpeed, undetected.speed_m_s));
                values.push((Axis::UndetectedTurnRate, undetected.turn_rate_rad_s));
            }
            values
        }
        Controller::Machine(machine) => {
            let numbers = machine.numbers.iter();
            numbers
                .filter_map(|(name, value)| Some((Axis::Number(Number::new(name)?), *value)))
                .collect()
        }
    }
}

impl OperatorConditions {
    /// The circumstances that a simulated cell stands for.
    pub fn new(conditions: &Conditions, duration_s: f64) -> Self {
        Self {
            robots: conditions.robots,
            controller: conditions.controller.clone(),
            behaviour: conditions.behaviour,
            placement: conditions.placement.clone(),
            arena: conditions.arena,
            world: conditions.world.clone(),
            duration_s,
        }
    }

    /// What the operator has set on an axis; `None` for what a robot is rather than set to.
    pub fn setting(&self, axis: Axis) -> Option<f64> {
        let parameters = || self.controller.parameters();
        let undetected = || Some(decide(false, parameters()?));
        Some(match axis {
            Axis::Speed => parameters()?.speed_m_s,
            Axis::TurnRate => parameters()?.turn_rate_rad_s,
            Axis::UndetectedSpeed => undetected()?.speed_m_s,
            Axis::UndetectedTurnRate => undetected()?.turn_rate_rad_s,
            Axis::Number(_) => {
                let values = controller_values(&self.controller);
                values.into_iter().find(|(other, _)| *other == axis)?.1
            }
            Axis::Robots => self.robots as f64,
            Axis::PlacementRadius => self.placement.radius_m(),
            Axis::Arena => self.arena.side_m,
            _ => return None,
        })
    }

    /// Refuses a run whose circumstances differ from these.
    pub fn admit(&self, run: &Self) -> Result<(), Incomparable> {
        let refuse = |aspect: &str, found: String, expected: String| {
            Err(Incomparable { aspect: aspect.to_owned(), found, expected })
        };
        if run.robots != self.robots {
            return refuse("the number of robots", run.robots.to_string(), self.robots.to_string());
        }
        if run.behaviour != self.behaviour {
            let expected = self.behaviour.to_string();
            let mut found = run.behaviour.to_string();
            if found == expected {
                found += " by other rules";
            }
            return refuse("the behaviour", found, expected);
        }
        // Robots that were put there to be measured are no swarm.
        let is_pair = |it: &&Placement| matches!(it, Placement::Pair { .. });
        if let Some(pair) = [&run.placement, &self.placement].into_iter().find(is_pair) {
            return refuse("the placement", format!("{pair:?}"), "robots in a disc".to_owned());
        }
        let [found, expected] = [&run.placement, &self.placement].map(kind);
        if found != expected {
            return refuse("the placement", found.to_owned(), expected.to_owned());
        }
        let numbers = controller_values(&self.controller).into_iter().map(|(axis, _)| axis);
        let settings = Axis::ALL
            .into_iter()
            .chain(numbers.filter(|axis| matches!(axis, Axis::Number(_))))
            .filter(|axis| !axis.is_count())
            .filter_map(|axis| {
                let values = [run, self].map(|conditions| conditions.setting(axis));
                let [Some(found), Some(expected)] = values else { return None };
                Some((axis.name(), axis.unit(), found, expected))
            })
            .chain([("duration", "s", run.duration_s, self.duration_s)]);
        for (name, unit, found, expected) in settings {
            if (found - expected).abs() > SAME * expected.abs() {
                return refuse(
                    &format!("the {name}"),
                    format!("{found} {unit}"),
                    format!("{expected} {unit}"),
                );
            }
        }
        let is_machine = |controller: &Controller| controller.parameters().is_none();
        if [run, self].iter().any(|it| is_machine(&it.controller))
            && run.controller != self.controller
        {
            return refuse("the controller", "another table".to_owned(), "the table".to_owned());
        }
        if !is_same_start(&run.placement, &self.placement) {
            return refuse("the placement", format!("another {found}"), format!("the {expected}"));
        }
        if run.arena.walls != self.arena.walls {
            let named = |walls| format!("{walls:?}").to_lowercase();
            return refuse("what the walls do", named(run.arena.walls), named(self.arena.walls));
        }
        if run.world != self.world {
            let expected = self.world.in_words();
            let mut found = run.world.in_words();
            if found == expected {
                found = format!("another with {found}");
            }
            return refuse("the world", found, expected);
        }
        Ok(())
    }
}

fn kind(placement: &Placement) -> &'static str {
    match placement {
        Placement::DiscFacingOut { .. } => "disc",
        Placement::BoxFacingOut(_) => "box",
        Placement::BoxFacingAnyWay(_) => "box with headings of any way",
        Placement::Given { .. } => "table of start poses",
        Placement::Pair { .. } => "pair",
    }
}

/// Whether robots start in one box, or by one table; the radii of discs are compared as numbers are.
fn is_same_start(found: &Placement, expected: &Placement) -> bool {
    matches!(expected, Placement::DiscFacingOut { .. }) || found == expected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::Walls;
    use crate::world::Goal;

    const SIMULATED: OperatorConditions = OperatorConditions {
        robots: 9,
        controller: Controller::Parameters(ControllerParameters::mirrored(0.15, 0.75)),
        behaviour: Behaviour::MILLING,
        placement: Placement::DiscFacingOut { radius_m: 0.825 },
        arena: Arena { side_m: 15.0, walls: Walls::Stop },
        world: WorldFile::NOTHING,
        duration_s: 300.0,
    };

    fn refusal(run: &OperatorConditions) -> String {
        SIMULATED.admit(run).unwrap_err().to_string()
    }

    #[test]
    fn the_same_experiment_is_admitted_and_every_difference_is_refused_by_name() {
        assert_eq!(SIMULATED.admit(&SIMULATED.clone()), Ok(()));
        let controller = ControllerParameters::mirrored(0.15, 0.8).into();
        let placement = Placement::DiscFacingOut { radius_m: 0.6 };
        let arena = Arena { side_m: 15.0, walls: Walls::None };

        assert_eq!(
            refusal(&OperatorConditions { robots: 8, ..SIMULATED }),
            "the number of robots is 8, expected 9 as simulated"
        );
        assert_eq!(
            refusal(&OperatorConditions { controller, ..SIMULATED }),
            "the turning rate is 0.8 rad/s, expected 0.75 rad/s as simulated"
        );
        assert_eq!(
            refusal(&OperatorConditions { placement, ..SIMULATED }),
            "the placement radius is 0.6 m, expected 0.825 m as simulated"
        );
        assert_eq!(
            refusal(&OperatorConditions { arena, ..SIMULATED }),
            "what the walls do is none, expected stop as simulated"
        );
        let goal = Goal { place_m: [1.0, 0.0], radius_m: 0.3 };
        let world = WorldFile { goals: vec![goal], ..WorldFile::NOTHING };
        assert_eq!(
            refusal(&OperatorConditions { world: world.clone(), ..SIMULATED }),
            "the world is 1 goal, expected nothing but robots as simulated"
        );
        let elsewhere = Goal { place_m: [1.0, 0.5], ..goal };
        let run = OperatorConditions { world: world.clone(), ..SIMULATED };
        let simulated = WorldFile { goals: vec![elsewhere], ..WorldFile::NOTHING };
        let simulated = OperatorConditions { world: simulated, ..SIMULATED };
        assert_eq!(
            simulated.admit(&run).unwrap_err().to_string(),
            "the world is another with 1 goal, expected 1 goal as simulated"
        );
        assert_eq!(
            refusal(&OperatorConditions { duration_s: 120.0, ..SIMULATED }),
            "the duration is 120 s, expected 300 s as simulated"
        );
    }
}
