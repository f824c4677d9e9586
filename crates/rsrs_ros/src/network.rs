//! Which network to join, through which interfaces, and as whom.

use std::path::Path;

use rsrs_core::help::Help;

use crate::clock::since_1970;
use crate::environment::Environment;
use crate::interfaces::{self, InterfaceError, LOOPBACK};
use crate::ros_args::{Note, RosArgs, USUAL_KEYSTORE};
use crate::security::{Enclave, Member, SecurityError, SecurityRequest};
use crate::session::SessionOptions;

/// Why there is no network to join.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    /// No interface is chosen, or it does not exist.
    #[error(transparent)]
    Interface(#[from] InterfaceError),
    /// What is to be secured cannot be.
    #[error(transparent)]
    Security(#[from] SecurityError),
}

impl Help for NetworkError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Interface(error) => error.help(),
            Self::Security(error) => error.help(),
        }
    }
}

impl RosArgs {
    /// The network to join: through the interfaces that were chosen by name or address, unless the
    /// environment keeps this program on this machine; and secured, if the environment demands it,
    /// in the enclave of `member` where none is named.
    ///
    /// If no interface is chosen and ROS 2 is not set to stay on this machine, that is an error.
    pub fn network(
        &mut self,
        flags: &[String],
        environment: &Environment,
        member: Member<'_>,
    ) -> Result<SessionOptions, NetworkError> {
        let variable = environment.variable(interfaces::VARIABLE);
        let wanted = interfaces::wanted(flags, variable);
        let interfaces = match self.localhost {
            Some(because) => {
                if wanted.is_empty() || !wanted.iter().all(|name| interfaces::is_loopback(name)) {
                    let instead_of = (!wanted.is_empty()).then(|| wanted.join(", "));
                    self.notes.push(Note::Localhost { because, instead_of });
                }
                vec![LOOPBACK]
            }
            None => interfaces::chosen(&wanted)?,
        };
        let enclave = self.enclave_of(environment, member)?;
        Ok(SessionOptions { domain_id: self.domain_id, interfaces, enclave })
    }

    fn enclave_of(
        &mut self,
        environment: &Environment,
        member: Member<'_>,
    ) -> Result<Option<Enclave>, SecurityError> {
        let request = SecurityRequest::read(environment, self.enclave.as_deref())?;
        let Some(request) = request else {
            if Path::new(USUAL_KEYSTORE).is_dir() {
                self.notes.push(Note::KeystoreUnused);
            }
            return Ok(None);
        };
        let enclave = request.enclave(member, self.domain_id, since_1970())?;
        self.notes.push(match &enclave {
            Some(enclave) => Note::Secured { enclave: enclave.name().to_owned() },
            None => Note::NotSecured { keystore: request.keystore },
        });
        Ok(enclave)
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    #[test]
    fn who_is_to_stay_on_this_machine_does_so_whatever_interface_is_chosen() {
        let network = |variables: &[(&str, &str)], flags: &[&str]| {
            let flags: Vec<String> = flags.iter().map(|flag| (*flag).to_owned()).collect();
            let environment = Environment::new(variables, |_| Err(io::ErrorKind::NotFound.into()));
            let mut args = RosArgs::parse(&[], &environment).unwrap();
            let network = args.network(&flags, &environment, Member::Runner).unwrap();
            let notes: Vec<String> = args.notes.iter().map(ToString::to_string).collect();
            (network.interfaces, notes)
        };
        let range = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
        let printed = "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST: this program uses the loopback \
                    interface only";

        let by_variable = network(&[range, ("RSRS_INTERFACE", "eth9")], &[]);
        let by_flag = network(&[range, ("RSRS_INTERFACE", "eth9")], &["10.0.0.7", "eth0"]);
        let by_nobody = network(&[range], &[]);
        let the_same = network(&[range], &["lo"]);
        let old = network(&[("ROS_LOCALHOST_ONLY", "1")], &["10.0.0.7", "eth0"]);

        assert_eq!(by_variable, (vec![LOOPBACK], vec![format!("{printed}, and not `eth9`")]));
        assert_eq!(by_flag, (vec![LOOPBACK], vec![format!("{printed}, and not `10.0.0.7, eth0`")]));
        assert_eq!(by_nobody, (vec![LOOPBACK], vec![printed.to_owned()]));
        assert_eq!(the_same, (vec![LOOPBACK], vec![]));
        assert_eq!(old.0, [LOOPBACK]);
        assert!(old.1[1].starts_with("ROS_LOCALHOST_ONLY=1: this program uses"), "{:?}", old.1);
    }

    #[test]
    fn a_session_that_was_to_be_secured_is_never_plain_in_silence() {
        let variables = [
            ("RSRS_INTERFACE", "lo"),
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_KEYSTORE", "no-such-keystore"),
        ];
        let environment = Environment::new(&variables, |_| Err(io::ErrorKind::NotFound.into()));
        let mut args = RosArgs::parse(&[], &environment).unwrap();

        let network = args.network(&[], &environment, Member::Runner);

        if crate::security::IS_BUILT_IN {
            // Permissive, as ROS 2 is where no strategy is set; and it is noted.
            assert_eq!(network.unwrap().enclave, None);
            assert!(args.notes[0].to_string().contains("NOT secured"), "{:?}", args.notes);
        } else {
            let error = network.unwrap_err();
            assert!(error.to_string().contains("was built without DDS Security"), "{error}");
            assert!(error.help().is_some_and(|help| help.contains("--features security")));
        }
    }
}
