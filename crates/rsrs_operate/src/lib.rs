//! What touches robots: runs over ROS 2, campaigns of them, trials, and watching.
//!
//! [`run`] carries out one experiment, with the nodes and the network that a simulated fleet needs;
//! [`campaign`] one after the other; [`dry_run`] the whole loop without robots; [`drive`] trials of single robots, whose tables it fills; [`watch`]
//! shows what a fleet does now, or did in a bag; [`stop`] stops every robot; [`publish`] plays a bag back onto the network. What
//! they leave are files, which `rsrs_pipeline` reads without any middleware.
//!
//! Nothing here parses arguments or prints: who stands beside the robots is a
//! [`run::operator::Operator`].

pub mod campaign;
pub mod drive;
pub mod dry_run;
pub mod publish;
pub mod run;
pub mod stop;
pub mod watch;
