//! Robots that a sweep was not made from, on the command line.

use rsrs_core::robot::other_profile::OtherProfile;

/// What to do where a sweep meets robots of another profile than its own.
#[derive(Clone, Copy, clap::Args)]
pub struct ProfileArguments {
    /// Accept a sweep of robots with another profile, and say so in the result (default: refuse it).
    #[arg(long)]
    other_profile: bool,
}

impl ProfileArguments {
    /// The same in a word.
    pub fn profile(self) -> OtherProfile {
        OtherProfile::from(self.other_profile)
    }
}
