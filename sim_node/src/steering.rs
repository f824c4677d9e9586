//! Manual control of the simulator through `simulation_interfaces`.

use rsrs_fleet::simulator::{ManualCommand, ManualControlRefused, PlaybackState};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::simulation_interfaces::{
    self as wire, Result as Outcome, SimulationState, SimulatorFeatures,
};
use rsrs_ros::clock::wall_time;

use crate::entities::{self, EntityError};
use crate::event_loop::{Simulation, Step};
use crate::placed_world::PlacedWorld;
use crate::services::{Call, done, outcome};

/// What this simulator can do.
const FEATURES: [u16; 10] = [
    SimulatorFeatures::ENTITY_BOUNDS_BOX,
    SimulatorFeatures::ENTITY_CATEGORIES,
    SimulatorFeatures::ENTITY_STATE_GETTING,
    SimulatorFeatures::ENTITY_STATE_SETTING,
    SimulatorFeatures::SIMULATION_RESET,
    SimulatorFeatures::SIMULATION_STATE_GETTING,
    SimulatorFeatures::SIMULATION_STATE_SETTING,
    SimulatorFeatures::SIMULATION_STATE_PAUSE,
    SimulatorFeatures::STEP_SIMULATION_SINGLE,
    SimulatorFeatures::STEP_SIMULATION_MULTIPLE,
];

/// What only people can read.
const CUSTOM_INFO: &str = "A world is placed by the parameters of this node; by hand it can be \
    moved while no experiment holds it, each robot driven by its conditions' controller.";

impl Simulation<'_> {
    /// Does what is asked, and answers.
    pub async fn answer(&mut self, call: Call) -> anyhow::Result<()> {
        match call {
            Call::Features(responder) => responder.send(features()),
            Call::State(responder) => {
                let state = SimulationState { state: self.state() };
                responder.send(wire::GetSimulationStateResponse { state, result: done() });
            }
            Call::SetState(request, responder) => {
                let result = self.set_state(request.state.state).await?;
                responder.send(wire::SetSimulationStateResponse { result });
            }
            Call::Reset(request, responder) => {
                let result = self.reset(request.scope).await?;
                responder.send(wire::ResetSimulationResponse { result });
            }
            Call::Step(request, responder) => match self.step(request.steps).await? {
                Some(result) => responder.send(wire::StepSimulationResponse { result }),
                // The answer is given when the steps are made.
                None => self.steps = Some(Step { asked: request.steps, responder }),
            },
            Call::SetEntityState(request, responder) => {
                let result = self.move_entity(&request).await?;
                responder.send(wire::SetEntityStateResponse { result });
            }
            Call::Entities(..) | Call::EntitiesStates(..) | Call::EntityState(..) => {
                self.send(call);
            }
        }
        Ok(())
    }

    /// Answers what only asks for robots.
    fn send(&self, call: Call) {
        let stamp = self.stamp();
        let placed_world = self.placed_world.as_ref().ok_or(ManualControlRefused::NoWorld);
        match call {
            Call::Entities(request, responder) => {
                let (result, rows) = picked(placed_world, &request.filters);
                let entities = names(self.placed_world.as_ref(), &rows);
                responder.send(wire::GetEntitiesResponse { result, entities });
            }
            Call::EntitiesStates(request, responder) => {
                let (result, rows) = picked(placed_world, &request.filters);
                let placed_world = self.placed_world.as_ref();
                let states =
                    placed_world.map(|placed_world| entities::states(placed_world, &rows, stamp));
                let (entities, states) = (names(placed_world, &rows), states.unwrap_or_default());
                responder.send(wire::GetEntitiesStatesResponse { result, entities, states });
            }
            Call::EntityState(request, responder) => {
                let found = placed_world.map_err(held).and_then(|placed_world| {
                    let row =
                        entities::row(placed_world, &request.entity).map_err(|e| refused(&e))?;
                    Ok(entities::states(placed_world, &[row], stamp).remove(0))
                });
                let (result, state) = match found {
                    Ok(state) => (done(), state),
                    Err(result) => (result, wire::EntityState::default()),
                };
                responder.send(wire::GetEntityStateResponse { result, state });
            }
            _ => unreachable!("all other calls change something, and are answered by `answer`"),
        }
    }

    fn state(&self) -> u8 {
        match self.machine.playback_state() {
            PlaybackState::NoWorld => SimulationState::NO_WORLD,
            PlaybackState::Stopped => SimulationState::STOPPED,
            PlaybackState::Playing => SimulationState::PLAYING,
            PlaybackState::Paused => SimulationState::PAUSED,
        }
    }

    async fn set_state(&mut self, wanted: u8) -> anyhow::Result<Outcome> {
        use wire::SetSimulationStateResponse as Response;
        let now = self.state();
        if let Err(refusal) = self.machine.check_manual_control()
            && !(refusal == ManualControlRefused::NoWorld && wanted == SimulationState::QUITTING)
        {
            return Ok(held(refusal));
        }
        if wanted == now {
            return Ok(outcome(Response::ALREADY_IN_TARGET_STATE, "it does so already"));
        }
        match wanted {
            SimulationState::STOPPED => {
                self.place().await?;
                Ok(done())
            }
            SimulationState::PLAYING => self.apply_manual(ManualCommand::Play).await,
            SimulationState::PAUSED => self.apply_manual(ManualCommand::Pause).await,
            SimulationState::QUITTING => {
                self.is_quitting = true;
                Ok(done())
            }
            _ => Ok(outcome(
                Response::INCORRECT_TRANSITION,
                "expected stopped (0), playing (1), paused (2) or quitting (3)",
            )),
        }
    }

    async fn reset(&mut self, scope: u8) -> anyhow::Result<Outcome> {
        use wire::ResetSimulationRequest as Request;
        let both = Request::TIME | Request::STATE;
        if scope != 0 && scope & both != both {
            let text = "the time and where robots are start over together or not at all";
            return Ok(outcome(Outcome::FEATURE_UNSUPPORTED, text));
        }
        if let Err(refusal) = self.machine.check_manual_control() {
            return Ok(held(refusal));
        }
        self.place().await?;
        Ok(done())
    }

    /// Starts to make steps; an answer if there is nothing to wait for.
    async fn step(&mut self, steps: u64) -> anyhow::Result<Option<Outcome>> {
        if steps == 0 {
            return Ok(Some(outcome(Outcome::OPERATION_FAILED, "expected at least 1 step")));
        }
        let result = self.apply_manual(ManualCommand::Step { steps }).await?;
        Ok((result.result != Outcome::OK).then_some(result))
    }

    async fn move_entity(
        &mut self,
        request: &wire::SetEntityStateRequest,
    ) -> anyhow::Result<Outcome> {
        if let Err(refusal) = self.machine.check_manual_control() {
            return Ok(held(refusal));
        }
        let placed_world =
            self.placed_world.as_mut().expect("a world under manual control is there");
        match entities::wanted(placed_world, request) {
            Ok(None) => Ok(done()),
            Ok(Some((row, pose))) => {
                placed_world.world.displace(row, pose);
                self.apply_manual(ManualCommand::EntityMoved).await
            }
            Err(error) => Ok(refused(&error)),
        }
    }

    async fn apply_manual(&mut self, command: ManualCommand) -> anyhow::Result<Outcome> {
        match self.machine.apply_manual(command, self.start.elapsed()) {
            Ok(actions) => {
                self.act(actions).await?;
                Ok(done())
            }
            Err(refusal) => Ok(held(refusal)),
        }
    }

    /// The time of the last step in lockstep, wall-clock time in real time.
    fn stamp(&self) -> Time {
        self.stamp_ns.map_or_else(wall_time, Time::from_nanos)
    }
}

fn features() -> wire::GetSimulatorFeaturesResponse {
    let features = SimulatorFeatures {
        features: FEATURES.to_vec(),
        spawn_formats: Vec::new(),
        custom_info: CUSTOM_INFO.to_owned(),
    };
    wire::GetSimulatorFeaturesResponse { features }
}

fn picked(
    placed_world: Result<&PlacedWorld, ManualControlRefused>,
    filters: &wire::EntityFilters,
) -> (Outcome, Vec<usize>) {
    // Without a world there are no robots.
    let Ok(placed_world) = placed_world else { return (done(), Vec::new()) };
    match entities::pick(placed_world, filters) {
        Ok(rows) => (done(), rows),
        Err(error) => (refused(&error), Vec::new()),
    }
}

fn names(placed_world: Option<&PlacedWorld>, rows: &[usize]) -> Vec<String> {
    let names = placed_world.map_or(&[][..], |placed_world| &placed_world.rows.names);
    rows.iter().map(|row| names[*row].clone()).collect()
}

fn refused(error: &EntityError) -> Outcome {
    outcome(error.code(), &error.to_string())
}

fn held(refusal: ManualControlRefused) -> Outcome {
    let code = match refusal {
        ManualControlRefused::NoWorld | ManualControlRefused::Held => Outcome::INCORRECT_STATE,
        ManualControlRefused::NotPaused => Outcome::OPERATION_FAILED,
    };
    outcome(code, &refusal.to_string())
}
