//! Which domain, and how far to look for others.

use std::fmt;
use std::path::PathBuf;

use super::RosArgsError;
use crate::environment::Environment;
use crate::logging::Level;

/// Where a robot has its keystore, as the playbook and the pages have it.
pub(crate) const USUAL_KEYSTORE: &str = "/etc/rsrs/keystore";

/// Something in the environment or the arguments that a person may not expect to be as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Note {
    /// The environment keeps this program on this machine, whatever interface was chosen.
    Localhost {
        /// The variable and its value.
        because: &'static str,
        /// The interface that was chosen and is not used.
        instead_of: Option<String>,
    },
    /// An argument for ROS 2 that means nothing to this program.
    WithoutEffect {
        /// The argument.
        flag: String,
        /// Why not.
        reason: &'static str,
    },
    /// This program is secured.
    Secured {
        /// The name of its enclave.
        enclave: String,
    },
    /// This program is not secured, although that was asked for: it has no enclave.
    NotSecured {
        /// Where it was looked for.
        keystore: PathBuf,
    },
    /// There is a keystore in `/etc/rsrs/keystore`, and protection is not asked for.
    KeystoreUnused,
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE=OFF`.
    RangeOff,
    /// `ROS_STATIC_PEERS`.
    StaticPeers,
    /// `RMW_IMPLEMENTATION` is none that programs of ours understand.
    Middleware(OtherMiddleware),
    /// `ROS_LOCALHOST_ONLY=1`.
    LocalhostOnly,
    /// A domain whose ports the kernel may give to other programs.
    EphemeralPorts {
        /// The domain.
        domain_id: u16,
    },
}

impl Note {
    /// How urgent it is for a person to read it.
    pub fn level(&self) -> Level {
        match self {
            Self::Secured { .. } => Level::Info,
            _ => Level::Warn,
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Localhost { because, instead_of } => {
                write!(formatter, "{because}: this program uses the loopback interface only")?;
                match instead_of {
                    Some(interface) => write!(formatter, ", and not `{interface}`"),
                    None => Ok(()),
                }
            }
            Self::WithoutEffect { flag, reason } => {
                write!(formatter, "`{flag}` has no effect: {reason}")
            }
            Self::Secured { enclave } => {
                write!(formatter, "secured by DDS Security, enclave `{enclave}`")
            }
            Self::KeystoreUnused => write!(
                formatter,
                "there is a keystore in {USUAL_KEYSTORE}, and ROS_SECURITY_ENABLE is not `true`: \
                 everybody on the network is obeyed"
            ),
            Self::NotSecured { keystore } => write!(
                formatter,
                "NOT secured: {} has no enclave for this program, and ROS_SECURITY_STRATEGY is not \
                 Enforce",
                keystore.display()
            ),
            Self::RangeOff => formatter.write_str(
                "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF is not honoured: \
                 this middleware always discovers; LOCALHOST stays on this machine",
            ),
            Self::StaticPeers => formatter.write_str(
                "ROS_STATIC_PEERS is not honoured: this middleware has no static peers, and finds others \
                 by multicast only; where a network carries none, a tunnel that carries Ethernet does",
            ),
            Self::Middleware(other) => other.fmt(formatter),
            Self::LocalhostOnly => formatter.write_str(
                "ROS_LOCALHOST_ONLY=1 is deprecated in ROS 2 and means \
                 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST; other programs that use it may not be found",
            ),
            Self::EphemeralPorts { domain_id } => write!(
                formatter,
                "ROS_DOMAIN_ID={domain_id} uses ports that other programs may be given; \
                 those below 102 do not"
            ),
        }
    }
}

/// A middleware of ROS 2 that does not speak RTPS, the protocol of DDS, by which programs of ours are found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherMiddleware {
    /// The value of `RMW_IMPLEMENTATION`.
    pub found: String,
}

/// What names the middleware of ROS 2.
const RMW: &str = "RMW_IMPLEMENTATION";
/// Those that speak RTPS.
const RTPS: [&str; 6] = [
    "rmw_fastrtps_cpp",
    "rmw_fastrtps_dynamic_cpp",
    "rmw_cyclonedds_cpp",
    "rmw_connextdds",
    "rmw_connext_cpp",
    "rmw_gurumdds_cpp",
];

impl OtherMiddleware {
    /// The one that the environment names; `None` if it names none, or one that speaks RTPS.
    pub fn new(environment: &Environment) -> Option<Self> {
        let found = environment.variable(RMW)?;
        let is_other = !found.is_empty() && !RTPS.contains(&found);
        is_other.then(|| Self { found: found.to_owned() })
    }

    /// What it means where no robot is found, on one line.
    pub fn in_short(&self) -> String {
        format!("{RMW}={}: robots that are started so are not found", self.found)
    }
}

impl fmt::Display for OtherMiddleware {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{RMW}={}: programs of ROS 2 that are started so speak no RTPS, and this program speaks \
             nothing else, so neither finds the other; start them with {RMW}={} or {}",
            self.found, RTPS[0], RTPS[2]
        )
    }
}

/// What the environment sets for discovery.
#[derive(Debug)]
pub(super) struct Discovery {
    pub(super) domain_id: u16,
    /// The variable that keeps this program on this machine.
    pub(super) localhost: Option<&'static str>,
    pub(super) notes: Vec<Note>,
}

/// Highest domain whose ports exist (RTPS 9.6.2).
const LAST_DOMAIN: u16 = 232;
/// Domains whose ports Linux hands out to any program (`net.ipv4.ip_local_port_range`).
const EPHEMERAL_DOMAINS: std::ops::RangeInclusive<u16> = 102..=214;

pub(super) fn read(environment: &Environment) -> Result<Discovery, RosArgsError> {
    let mut notes = Vec::new();
    let domain_id = domain_id(environment.variable("ROS_DOMAIN_ID").unwrap_or_default())?;
    if EPHEMERAL_DOMAINS.contains(&domain_id) {
        notes.push(Note::EphemeralPorts { domain_id });
    }

    // It goes before the newer variable in ROS 2, too.
    let is_local_only = environment.variable("ROS_LOCALHOST_ONLY") == Some("1");
    let range = environment.variable("ROS_AUTOMATIC_DISCOVERY_RANGE").unwrap_or_default();
    let mut localhost = is_local_only.then_some("ROS_LOCALHOST_ONLY=1");
    notes.extend(is_local_only.then_some(Note::LocalhostOnly));
    match range {
        "LOCALHOST" => drop(localhost.get_or_insert("ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST")),
        "OFF" if !is_local_only => notes.push(Note::RangeOff),
        "OFF" | "" | "SUBNET" | "SYSTEM_DEFAULT" => {}
        _ => return Err(RosArgsError::DiscoveryRange { found: range.to_owned() }),
    }
    if environment.variable("ROS_STATIC_PEERS").is_some_and(|peers| !peers.is_empty()) {
        notes.push(Note::StaticPeers);
    }
    notes.extend(OtherMiddleware::new(environment).map(Note::Middleware));
    Ok(Discovery { domain_id, localhost, notes })
}

fn domain_id(text: &str) -> Result<u16, RosArgsError> {
    if text.is_empty() {
        return Ok(0);
    }
    let domain_id = text.parse().ok().filter(|domain_id| *domain_id <= LAST_DOMAIN);
    domain_id.ok_or_else(|| RosArgsError::Domain { found: text.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_variables(variables: &[(&str, &str)]) -> Result<Discovery, RosArgsError> {
        read(&Environment::new(variables, |_| unreachable!("no file is asked for")))
    }

    #[test]
    fn variables_mean_what_they_mean_in_ros_and_what_is_not_honoured_is_noted() {
        let range = "ROS_AUTOMATIC_DISCOVERY_RANGE";
        let (peers, only) = ("ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY");
        for (variables, domain_id, expected, notes) in [
            (&[][..], 0, None, &[][..]),
            (&[(range, "LOCALHOST")], 0, Some("ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"), &[]),
            (&[(range, "SUBNET")], 0, None, &[]),
            // The old variable goes before the new one.
            (
                &[(range, "SUBNET"), (only, "1")],
                0,
                Some("ROS_LOCALHOST_ONLY=1"),
                &[Note::LocalhostOnly],
            ),
            (&[("ROS_DOMAIN_ID", "102")], 102, None, &[Note::EphemeralPorts { domain_id: 102 }]),
            (&[("ROS_DOMAIN_ID", "215")], 215, None, &[]),
        ] {
            let found = read_variables(variables).unwrap();

            assert_eq!((found.domain_id, found.localhost), (domain_id, expected), "{variables:?}");
            assert_eq!(found.notes, notes, "{variables:?}");
        }
        let notes =
            read_variables(&[(range, "OFF"), (peers, "10.0.0.1"), (only, "0")]).unwrap().notes;
        assert_eq!(notes, [Note::RangeOff, Note::StaticPeers]);
        assert!(notes.iter().all(|note| note.to_string().contains("not honoured")));
        let lower_case = read_variables(&[(range, "localhost")]);
        assert!(matches!(lower_case, Err(RosArgsError::DiscoveryRange { .. })));
    }

    #[test]
    fn a_domain_that_does_not_exist_is_refused() {
        for found in ["233", "-1", "one", "1.0", "70000"] {
            let error = read_variables(&[("ROS_DOMAIN_ID", found)]).unwrap_err();

            assert!(matches!(error, RosArgsError::Domain { .. }), "{found}: {error}");
        }
    }

    #[test]
    fn a_middleware_that_speaks_no_rtps_is_noted_with_what_to_type() {
        let notes = |value| read_variables(&[(RMW, value)]).unwrap().notes;

        for value in ["", "rmw_fastrtps_cpp", "rmw_cyclonedds_cpp"] {
            assert_eq!(notes(value), [], "{value}");
        }
        let noted = notes("rmw_zenoh_cpp");
        assert_eq!(noted.len(), 1);
        let text = noted[0].to_string();
        assert!(text.starts_with("RMW_IMPLEMENTATION=rmw_zenoh_cpp: programs of ROS 2"), "{text}");
        assert!(text.ends_with("with RMW_IMPLEMENTATION=rmw_fastrtps_cpp or rmw_cyclonedds_cpp"));
    }
}
