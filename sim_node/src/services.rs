//! The services of package `simulation_interfaces`: what tools ask of any simulator.

use rsrs_msgs::simulation_interfaces::{self as wire, Result as Outcome, ServiceRequest};
use rsrs_ros::services::{self, Responder, Service, decode};
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
    let request = |body: &[u8]| {
        let older = || decode::<wire::SetEntityStateRequest1>(body).map(Into::into);
        decode::<wire::SetEntityStateRequest>(body).or_else(older)
    };
    let offered: [Service; wire::SERVICES.len()] = [
        ends.offer(decode, |_: wire::GetSimulatorFeaturesRequest, responder| {
            Call::Features(responder)
        })?,
        ends.offer(decode, |_: wire::GetSimulationStateRequest, responder| Call::State(responder))?,
        ends.offer(decode, Call::SetState)?,
        ends.offer(decode, Call::Reset)?,
        ends.offer(decode, Call::Step)?,
        ends.offer(decode, Call::Entities)?,
        ends.offer(decode, Call::EntitiesStates)?,
        ends.offer(decode, Call::EntityState)?,
        ends.offer(request, Call::SetEntityState)?,
    ];
    Ok(offered.into())
}

struct Ends<'a, H> {
    session: &'a Session,
    node: &'a NodeHandle,
    received: H,
}

impl<H: Fn(Call) + Clone + Send + 'static> Ends<'_, H> {
    fn offer<Q: ServiceRequest>(
        &self,
        decode: impl Fn(&[u8]) -> Option<Q> + Send + 'static,
        call: impl Fn(Q, Responder<Q::Response>) -> Call + Send + 'static,
    ) -> anyhow::Result<Service> {
        let received = self.received.clone();
        let deliver = move |request, responder| received(call(request, responder));
        Ok(services::offer(self.session, self.node, Q::SERVICE, decode, deliver)?)
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
