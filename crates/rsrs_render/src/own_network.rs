//! Where a run without robots happens, for people who want to look inside.

/// How the network of a run without robots is kept apart.
#[derive(Clone, Debug)]
pub enum Isolation {
    /// It is a network namespace.
    Namespace {
        /// What starts a command in it, in front of that command.
        enter_command: String,
    },
    /// It is the loopback interface of the machine, in a domain that nobody else uses.
    Loopback {
        /// Why it is no namespace.
        why: String,
        /// The domain.
        domain_id: u16,
        /// What would make it one.
        help: String,
    },
}

/// How to look inside, or why the network is not one of its own.
pub fn text(isolation: &Isolation) -> String {
    match isolation {
        Isolation::Namespace { enter_command } => format!(
            "no packet leaves this machine; to look inside:\n  {enter_command} env ROS_DOMAIN_ID=0 rviz2"
        ),
        Isolation::Loopback { why, domain_id, help } => format!(
            "{why}: using the loopback interface in domain {domain_id}, where nobody else is; {help}"
        ),
    }
}
