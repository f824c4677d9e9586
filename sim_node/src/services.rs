//! The services of package `simulation_interfaces`: what tools ask of any simulator.

use rsrs_msgs::RosMessage;
use rsrs_msgs::simulation_interfaces::{self as wire, Result as Outcome};
use rsrs_ros::services::{self, Responder, Service};
use rsrs_ros::session::{NodeHandle, Session};

/// A request, and the client that waits for its response.
pub enum Call {
    /// What the simulator can do.
    Features(Responder<wire::GetSimulatorFeaturesResponse>),
    /// What it does.
    State(Responder<wire::GetSimulationStateResponse>),
    /// What it shall do.
    SetState(wire::SetSimulationStateRequest, Responder<wire::SetSimulationStateResponse>),
    /// To start over.
    Reset(wire::ResetSimulationRequest, Responder<wire::ResetSimulationResponse>),
    /// To make steps.
    Step(wire::StepSimulationRequest, Responder<wire::StepSimulationResponse>),
    /// Which robots there are.
    Entities(wire::GetEntitiesRequest, Responder<wire::GetEntitiesResponse>),
    /// Where they are.
    EntitiesStates(wire::GetEntitiesStatesRequest, Responder<wire::GetEntitiesStatesResponse>),
    /// Where one is.
    EntityState(wire::GetEntityStateRequest, Responder<wire::GetEntityStateResponse>),
    /// To put one somewhere.
    SetEntityState(wire::SetEntityStateRequest, Responder<wire::SetEntityStateResponse>),
}

/// Offers all of them, below the simulator's name; `received` takes every call.
pub fn offer(
    session: &Session,
    node: &NodeHandle,
    received: impl Fn(Call) + Clone + Send + 'static,
) -> anyhow::Result<Vec<Service>> {
    let ends = Ends { session, node, received };
    Ok(vec![
        ends.offer::<wire::GetSimulatorFeaturesRequest, _>(
            "get_simulator_features",
            |_, responder| Call::Features(responder),
        )?,
        ends.offer::<wire::GetSimulationStateRequest, _>(
            "get_simulation_state",
            |_, responder| Call::State(responder),
        )?,
        ends.offer("set_simulation_state", Call::SetState)?,
        ends.offer("reset_simulation", Call::Reset)?,
        ends.offer("step_simulation", Call::Step)?,
        ends.offer("get_entities", Call::Entities)?,
        ends.offer("get_entities_states", Call::EntitiesStates)?,
        ends.offer("get_entity_state", Call::EntityState)?,
        ends.offer_with_older_request::<wire::SetEntityStateRequest1, _, _>(
            "set_entity_state",
            Call::SetEntityState,
        )?,
    ])
}

struct Ends<'a, H> {
    session: &'a Session,
    node: &'a NodeHandle,
    received: H,
}

impl<H: Fn(Call) + Clone + Send + 'static> Ends<'_, H> {
    fn offer<Q: RosMessage, R: RosMessage + Default>(
        &self,
        name: &str,
        call: impl Fn(Q, Responder<R>) -> Call + Send + 'static,
    ) -> anyhow::Result<Service> {
        let received = self.received.clone();
        Ok(services::offer(self.session, self.node, name, move |request, responder| {
            received(call(request, responder));
        })?)
    }

    fn offer_with_older_request<Older, Q, R>(
        &self,
        name: &str,
        call: impl Fn(Q, Responder<R>) -> Call + Send + 'static,
    ) -> anyhow::Result<Service>
    where
        Older: RosMessage,
        Q: RosMessage + From<Older>,
        R: RosMessage + Default,
    {
        let received = self.received.clone();
        let deliver = move |request, responder| received(call(request, responder));
        Ok(services::offer_with_older_request::<Older, Q, R>(
            self.session,
            self.node,
            name,
            deliver,
        )?)
    }
}

/// It was carried out.
pub fn done() -> Outcome {
    outcome(Outcome::OK, "")
}

/// How a call went, as it is answered.
pub fn outcome(result: u8, error_message: &str) -> Outcome {
    Outcome { result, error_message: error_message.to_owned() }
}
