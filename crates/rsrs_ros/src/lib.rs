//! The only crate that names the middleware: session, arguments, parameters, clock, raw topics.
//!
//! Everything that a driver needs from ROS 2 is here, so that another transport would change this
//! crate and no other.
//!
//! * [`session`] — one participant with any number of nodes, publishers and subscriptions.
//! * [`parameters`] — the six parameter services for many nodes, and a client for them.
//! * [`services`] — services of any other type, and a client.
//! * [`clock`] — wall-clock time, and time since boot.
//! * [`environment`] and [`ros_args`] — variables, `--ros-args`, parameter files, `ROS_DOMAIN_ID` and its kin.
//! * [`network`] — which network to join, by those.
//! * [`confine`] and [`interfaces`] — where the packets may go.
//! * [`security`] — which enclave of a keystore a process has.
//! * [`runtime`] — on what a program of nodes runs.
//! * [`shutdown`], [`logging`], [`complaints`] and [`printing`] — how a node ends, what it logs, and who prints it.
//! * [`e_stop`] and [`cmd_vel`] — the three topics of the e-stop, and velocity commands of either type.
//!
//! What it does not do: lifecycle nodes, actions, discovery servers, static peers.

pub mod clock;
pub mod cmd_vel;
pub mod complaints;
pub mod confine;
pub mod e_stop;
pub mod environment;
pub mod interfaces;
mod kernel;
pub mod logging;
pub mod network;
pub mod node_arguments;
mod parameter_value;
pub mod parameters;
pub mod printing;
pub mod ros_args;
pub mod runtime;
pub mod security;
pub mod services;
pub mod session;
pub mod shutdown;
