//! A network in which a run without robots is alone.

use std::process::Command;

use anyhow::{Context, bail};
use rsrs_core::help::Help;
use rsrs_ros::confine::{self, ConfineError};
use rsrs_ros::environment::Environment;
use rsrs_ros::interfaces::{self, LOOPBACK};
use rsrs_ros::security::SecurityRequest;
use rsrs_ros::session::SessionOptions;

use rsrs_pipeline::error::{helped, with_help};
use rsrs_render::own_network::Isolation;

/// Where a run without robots happens.
#[derive(Clone, Debug)]
pub struct OwnNetwork {
    /// For sessions of this process.
    pub session: SessionOptions,
    /// How it is kept apart from others.
    pub isolation: Isolation,
}

/// The variable that selects the network of ROS 2.
const DOMAIN: &str = "ROS_DOMAIN_ID";

/// What else ROS 2 reads about discovery and security; it does not hold in here, where nobody else is.
const NOT_IN_HERE: [&str; 4] = [
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_STATIC_PEERS",
    "ROS_LOCALHOST_ONLY",
    "ROS_SECURITY_ENABLE",
];

impl OwnNetwork {
    /// Moves this process into a network of its own; where that is forbidden, picks an unused
    /// domain on the loopback interface.
    ///
    /// Call this before any thread is started.
    pub fn enter() -> anyhow::Result<Self> {
        let environment = Environment::of_this_process();
        environment.check()?;
        let is_to_be_secured = SecurityRequest::is_made(&environment).map_err(helped)?;
        match confine::into_own_network() {
            Ok(confinement) => Ok(Self {
                session: SessionOptions { domain_id: 0, interfaces: vec![LOOPBACK], enclave: None },
                isolation: Isolation::Namespace { enter_command: confinement.enter_command() },
            }),
            Err(error @ ConfineError::Forbidden { .. }) => {
                if is_to_be_secured {
                    let text =
                        format!("{error}, and on the loopback interface it would not be secured");
                    return Err(with_help(text, error.help().unwrap_or_default()));
                }
                Self::on_loopback(&error)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Whether it is a network of its own, and not the machine's loopback interface.
    pub fn is_confined(&self) -> bool {
        matches!(self.isolation, Isolation::Namespace { .. })
    }

    /// Moves this thread, and what it starts from now on, into another network of the same kind.
    pub fn another(&self) -> anyhow::Result<Self> {
        confine::thread_into_own_network()?;
        Ok(self.clone())
    }

    fn on_loopback(error: &ConfineError) -> anyhow::Result<Self> {
        let domain =
            confine::free_loopback_domain().context("looking for a domain that nobody uses")?;
        let Some(domain_id) = domain else {
            bail!("{error}, and every domain from 1 to 101 is in use on this machine");
        };
        let help = error.help().unwrap_or_else(|| "run as root".to_owned());
        Ok(Self {
            session: SessionOptions { domain_id, interfaces: vec![LOOPBACK], enclave: None },
            isolation: Isolation::Loopback { why: error.to_string(), domain_id, help },
        })
    }

    /// Gives a node the address of this network.
    pub fn configure<'a>(&self, node: &'a mut Command) -> &'a mut Command {
        for variable in NOT_IN_HERE {
            node.env_remove(variable);
        }
        node.env(DOMAIN, self.session.domain_id.to_string())
            .env(interfaces::VARIABLE, LOOPBACK.to_string())
    }
}
