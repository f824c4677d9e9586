//! The ends of services that carry raw bytes: ros2-client only passes them on, so that each request is
//! understood and answered in the mapping of the one who asked.

use futures::StreamExt;
use ros2_client::service::{Client, RmwRequestId, Server, ServiceMapping};
use ros2_client::{Name, ServiceTypeName};
use rsrs_msgs::topics::Qos;

use super::mapping::{Mapping, reply, understood};
use crate::session::{Bytes, NodeHandle, Session, SessionError, profile};

/// As for every service of ROS 2.
const SERVICE_QOS: Qos = Qos::reliable(10);

/// The end that answers.
pub(crate) type RawServer = Server<Bytes, Bytes>;

/// The end that asks.
pub(crate) type RawClient = Client<Bytes, Bytes>;

/// Makes the answering end of a service such as `/simulator/step_simulation`.
pub(crate) fn server(
    session: &Session,
    node: &NodeHandle,
    service: &str,
    type_name: &ServiceTypeName,
) -> Result<RawServer, SessionError> {
    let name = parsed(service)?;
    let qos = profile(SERVICE_QOS);
    // The mapping is ours to choose: the bytes are passed on as they are.
    let mapping = ServiceMapping::Enhanced;
    session.with_node(node, 2, |node| {
        node.create_server(mapping, &name, type_name, qos.clone(), qos.clone())
            .map_err(|error| SessionError::endpoint(service, &error))
    })
}

/// Makes the asking end of a service such as `/simulator/step_simulation`.
pub(crate) fn client(
    session: &Session,
    node: &NodeHandle,
    service: &str,
    type_name: &ServiceTypeName,
    mapping: Mapping,
) -> Result<RawClient, SessionError> {
    let name = parsed(service)?;
    let qos = profile(SERVICE_QOS);
    let mapping = match mapping {
        Mapping::Enhanced => ServiceMapping::Enhanced,
        Mapping::Cyclone => ServiceMapping::Cyclone,
    };
    session.with_node(node, 2, |node| {
        node.create_client(mapping, &name, type_name, qos.clone(), qos.clone())
            .map_err(|error| SessionError::endpoint(service, &error))
    })
}

/// Answers one request after the other; `service` stands in the log.
///
/// `decode` understands a request without a header. `answer` makes the body of the answer, and
/// `refusal` that for a request that cannot be understood; where they make `None`, nothing is sent.
pub(crate) async fn answer_all<Q, A>(
    service: String,
    server: RawServer,
    decode: impl Fn(&[u8]) -> Option<Q>,
    refusal: impl Fn() -> Option<Vec<u8>>,
    mut answer: impl FnMut(Q) -> A,
) where
    A: Future<Output = Option<Vec<u8>>>,
{
    let mut requests = server.receive_request_stream();
    while let Some(received) = requests.next().await {
        match received {
            Ok((id, Bytes(bytes))) => {
                let asked = understood(vendor_of(id), &bytes, &decode);
                let (mapping, body) = if let Some((mapping, request)) = asked {
                    (mapping, answer(request).await)
                } else {
                    log::warn!("`{service}`: request of another type or version, refused");
                    (Mapping::likely(vendor_of(id), &bytes), refusal())
                };
                let Some(body) = body else {
                    log::warn!("`{service}`: a request is not answered");
                    continue;
                };
                let answer = Bytes(reply(mapping, &bytes, &body));
                // The identity of the request goes along in both mappings, so that clients of the
                // other one, who receive the response too, can see that it is not theirs.
                if let Err(error) = server.async_send_response(id, answer).await {
                    log::warn!("`{service}`: no answer: {error}");
                }
            }
            Err(error) => log::warn!("`{service}`: {error}"),
        }
        tokio::task::coop::consume_budget().await;
    }
}

fn parsed(service: &str) -> Result<Name, SessionError> {
    Name::parse(service)
        .map_err(|error| SessionError::Name { name: service.to_owned(), reason: error.to_string() })
}

/// The vendor of the client.
fn vendor_of(id: RmwRequestId) -> [u8; 2] {
    let [first, second, ..] = id.writer_gid.to_bytes16();
    [first, second]
}
