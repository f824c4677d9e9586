//! The six services: names, what a request asks for, and answers out of a store.

use ros2_client::ServiceTypeName;
use rsrs_msgs::cdr::{self, ByteOrder};
use rsrs_msgs::rcl_interfaces as wire;

use super::store::{Refusal, Setter, Store};
use crate::parameter_value::ParameterValue;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Service {
    Get,
    GetTypes,
    Set,
    SetAtomically,
    List,
    Describe,
}

impl Service {
    pub(super) const ALL: [Self; 6] =
        [Self::Get, Self::GetTypes, Self::Set, Self::SetAtomically, Self::List, Self::Describe];

    /// Its name below the node's, and that of its type.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Get => ("get_parameters", "GetParameters"),
            Self::GetTypes => ("get_parameter_types", "GetParameterTypes"),
            Self::Set => ("set_parameters", "SetParameters"),
            Self::SetAtomically => ("set_parameters_atomically", "SetParametersAtomically"),
            Self::List => ("list_parameters", "ListParameters"),
            Self::Describe => ("describe_parameters", "DescribeParameters"),
        }
    }

    /// Its name below the node's.
    pub(super) fn name(self) -> &'static str {
        self.names().0
    }

    pub(super) fn ros_type(self) -> ServiceTypeName {
        ServiceTypeName::new("rcl_interfaces", self.names().1)
    }
}

/// A request that was understood.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Request {
    Get(wire::GetParametersRequest),
    GetTypes(wire::GetParameterTypesRequest),
    Set(wire::SetParametersRequest),
    SetAtomically(wire::SetParametersAtomicallyRequest),
    List(wire::ListParametersRequest),
    Describe(wire::DescribeParametersRequest),
}

impl Request {
    /// Understands the body of a request.
    pub(super) fn decode(service: Service, body: &[u8]) -> Option<Self> {
        // Every computer that runs ROS 2 today is little-endian.
        const ORDER: ByteOrder = ByteOrder::Little;
        match service {
            Service::Get => cdr::decode_body(body, ORDER).ok().map(Self::Get),
            Service::GetTypes => cdr::decode_body(body, ORDER).ok().map(Self::GetTypes),
            Service::Set => cdr::decode_body(body, ORDER).ok().map(Self::Set),
            Service::SetAtomically => cdr::decode_body(body, ORDER).ok().map(Self::SetAtomically),
            Service::List => cdr::decode_body(body, ORDER).ok().map(Self::List),
            Service::Describe => cdr::decode_body(body, ORDER).ok().map(Self::Describe),
        }
    }
}

/// An answer, and what it changed.
#[derive(Debug, PartialEq)]
pub(super) struct Reply {
    pub(super) body: Vec<u8>,
    pub(super) changes: Vec<(String, ParameterValue)>,
}

/// Whether a node agrees with changes that its descriptors allow.
pub(super) type Validate<'a> = dyn FnMut(&[(String, ParameterValue)]) -> Result<(), String> + 'a;

/// Does what a request asks for.
pub(super) fn answer(request: Request, store: &mut Store, validate: &mut Validate<'_>) -> Reply {
    let mut changes = Vec::new();
    let body = match request {
        Request::Get(request) => {
            let value = |name: &String| store.get(name).map(ParameterValue::to_wire);
            let values = request.names.iter().map(|name| value(name).unwrap_or_default()).collect();
            cdr::encode_body(&wire::GetParametersResponse { values })
        }
        Request::GetTypes(request) => {
            let value = |name: &String| store.get(name).map(ParameterValue::to_wire);
            let types = request.names.iter().map(|n| value(n).unwrap_or_default().r#type).collect();
            cdr::encode_body(&wire::GetParameterTypesResponse { types })
        }
        Request::Set(request) => {
            let results = request.parameters.into_iter().map(|parameter| {
                result(set(store, vec![parameter], validate).map(|made| changes.extend(made)))
            });
            let results = results.collect();
            cdr::encode_body(&wire::SetParametersResponse { results })
        }
        Request::SetAtomically(request) => {
            let result =
                result(set(store, request.parameters, validate).map(|made| changes.extend(made)));
            cdr::encode_body(&wire::SetParametersAtomicallyResponse { result })
        }
        Request::List(request) => {
            let (names, prefixes) = store.list(&request.prefixes, request.depth);
            let result = wire::ListParametersResult { names, prefixes };
            cdr::encode_body(&wire::ListParametersResponse { result })
        }
        Request::Describe(request) => {
            let descriptors = request.names.into_iter().map(|name| match store.descriptor(&name) {
                Some(descriptor) => descriptor.to_wire(),
                None => wire::ParameterDescriptor { name, ..Default::default() },
            });
            let descriptors = descriptors.collect();
            cdr::encode_body(&wire::DescribeParametersResponse { descriptors })
        }
    };
    Reply { body, changes }
}

/// Sets all of these or none; returns what was set.
fn set(
    store: &mut Store,
    parameters: Vec<wire::Parameter>,
    validate: &mut Validate<'_>,
) -> Result<Vec<(String, ParameterValue)>, Refusal> {
    let changes = parameters
        .into_iter()
        .map(|wire::Parameter { name, value }| match ParameterValue::from_wire(value) {
            Some(value) => Ok((name, value)),
            None => Err(Refusal::NotSet { name }),
        })
        .collect::<Result<Vec<_>, _>>()?;
    store.check(&changes, Setter::Anybody)?;
    validate(&changes).map_err(|reason| Refusal::Validator { reason })?;
    store.apply(&changes);
    Ok(changes)
}

fn result(outcome: Result<(), Refusal>) -> wire::SetParametersResult {
    match outcome {
        Ok(()) => wire::SetParametersResult { successful: true, reason: String::new() },
        Err(refusal) => {
            wire::SetParametersResult { successful: false, reason: refusal.to_string() }
        }
    }
}

#[cfg(test)]
mod tests {
    use rsrs_msgs::RosMessage;

    use super::*;
    use crate::parameter_value::{Descriptor, ParameterKind};
    use crate::services::mapping::{Mapping, understood};

    const RUSTDDS: [u8; 2] = [0x01, 0x12];
    const CYCLONE: [u8; 2] = [0x01, 0x10];

    fn understand(service: Service, vendor: [u8; 2], bytes: &[u8]) -> Option<(Mapping, Request)> {
        understood(vendor, bytes, |body| Request::decode(service, body))
    }

    fn store() -> Store {
        let mut store = Store::default();
        for (name, value) in [("speed", 0.15), ("turn_rate", 0.75)] {
            let mut descriptor = Descriptor::new(name, ParameterKind::Double, "In SI units.");
            descriptor.range = Some((0.0, 2.0));
            store.declare(descriptor, ParameterValue::Double(value)).unwrap();
        }
        store
    }

    fn parameters(values: &[(&str, f64)]) -> Vec<wire::Parameter> {
        let parameter = |&(name, value): &(&str, f64)| wire::Parameter {
            name: name.into(),
            value: ParameterValue::Double(value).to_wire(),
        };
        values.iter().map(parameter).collect()
    }

    fn ask<R: RosMessage>(request: Request, store: &mut Store) -> R {
        let answer = answer(request, store, &mut |_| Ok(()));
        cdr::decode_body(&answer.body, ByteOrder::Little).unwrap()
    }

    fn with_header(body: &[u8]) -> Vec<u8> {
        // As rmw_cyclonedds does: half of a GUID, then the sequence number, high word first.
        [&[0, 0, 0, 7, 0, 0, 1, 3, 0, 0, 0, 0, 1, 0, 0, 0], body].concat()
    }

    #[test]
    fn a_request_is_understood_in_either_mapping_whatever_the_vendor() {
        let get = wire::GetParametersRequest { names: vec!["speed".into()] };
        // The shortest request of all: 12 bytes of zeros, padded to 16 before the depth.
        let list = wire::ListParametersRequest::default();
        for (service, plain, request) in [
            (Service::Get, cdr::encode_body(&get), Request::Get(get)),
            (Service::List, cdr::encode_body(&list), Request::List(list)),
        ] {
            for vendor in [RUSTDDS, CYCLONE] {
                let decode = |bytes: &[u8]| understand(service, vendor, bytes).unwrap();
                assert_eq!(decode(&plain), (Mapping::Enhanced, request.clone()));
                assert_eq!(decode(&with_header(&plain)), (Mapping::Cyclone, request.clone()));
            }
        }
        assert_eq!(understand(Service::Set, RUSTDDS, &[0xff; 40]), None);
        assert_eq!(understand(Service::Set, CYCLONE, &[]), None);
    }

    #[test]
    fn set_atomically_sets_all_or_none() {
        let mut store = store();
        let request = |values| {
            let parameters = parameters(values);
            Request::SetAtomically(wire::SetParametersAtomicallyRequest { parameters })
        };

        let bad: wire::SetParametersAtomicallyResponse =
            ask(request(&[("speed", 0.2), ("turn_rate", 9.0)]), &mut store);
        assert!(!bad.result.successful);
        assert_eq!(store.get("speed"), Some(&ParameterValue::Double(0.15)));

        let good: wire::SetParametersAtomicallyResponse =
            ask(request(&[("speed", 0.2), ("turn_rate", 1.0)]), &mut store);
        assert!(good.result.successful);
        assert_eq!(store.get("turn_rate"), Some(&ParameterValue::Double(1.0)));
    }

    #[test]
    fn set_sets_what_it_can() {
        let mut store = store();
        let parameters = parameters(&[("height", 1.0), ("speed", 0.2)]);

        let answer = answer(
            Request::Set(wire::SetParametersRequest { parameters }),
            &mut store,
            &mut |_| Ok(()),
        );

        let response: wire::SetParametersResponse =
            cdr::decode_body(&answer.body, ByteOrder::Little).unwrap();
        let successful: Vec<bool> = response.results.iter().map(|r| r.successful).collect();
        assert_eq!(successful, [false, true]);
        assert_eq!(answer.changes, [("speed".into(), ParameterValue::Double(0.2))]);
    }

    #[test]
    fn the_node_has_the_last_word() {
        let mut store = store();
        let parameters = parameters(&[("speed", 0.2)]);
        let request = Request::SetAtomically(wire::SetParametersAtomicallyRequest { parameters });

        let answer = answer(request, &mut store, &mut |changes| {
            Err(format!("not with {} changes", changes.len()))
        });

        let response: wire::SetParametersAtomicallyResponse =
            cdr::decode_body(&answer.body, ByteOrder::Little).unwrap();
        assert_eq!(response.result.reason, "not with 1 changes");
        assert_eq!(answer.changes, []);
        assert_eq!(store.get("speed"), Some(&ParameterValue::Double(0.15)));
    }

    #[test]
    fn a_value_that_is_not_set_does_not_undeclare() {
        let parameters = vec![wire::Parameter { name: "speed".into(), ..Default::default() }];

        let response: wire::SetParametersResponse =
            ask(Request::Set(wire::SetParametersRequest { parameters }), &mut store());

        assert_eq!(response.results[0].reason, "parameter 'speed' cannot be undeclared");
    }

    #[test]
    fn what_does_not_exist_is_not_set_in_answers() {
        let names = vec!["height".to_owned(), "speed".to_owned()];

        let values: wire::GetParametersResponse =
            ask(Request::Get(wire::GetParametersRequest { names: names.clone() }), &mut store());
        let types: wire::GetParameterTypesResponse = ask(
            Request::GetTypes(wire::GetParameterTypesRequest { names: names.clone() }),
            &mut store(),
        );
        let descriptors: wire::DescribeParametersResponse =
            ask(Request::Describe(wire::DescribeParametersRequest { names }), &mut store());

        assert_eq!(values.values[0].r#type, wire::ParameterType::NOT_SET);
        assert_eq!(types.types, [wire::ParameterType::NOT_SET, wire::ParameterType::DOUBLE]);
        assert_eq!(
            descriptors.descriptors[1].floating_point_range[0].to_value.to_bits(),
            2f64.to_bits()
        );
    }
}
