//! Sentences and times as people read them.

pub mod quantity;
pub mod shell;

use std::path::Path;

use jiff::Timestamp;
use rsrs_core::world::WorldFile;
use rsrs_pipeline::sweep::source::ResolvedSweep;

/// Log times from here on are of the wall clock, earlier ones of a simulation: none simulates
/// 30 years.
const FIRST_WALL_NS: u64 = 1_000_000_000_000_000_000;

/// A sentence with a capital letter in front.
pub fn capitalised(sentence: &str) -> String {
    let mut characters = sentence.chars();
    let first = characters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + characters.as_str()
}

/// Which file was written.
pub fn wrote(path: &Path) -> String {
    format!("wrote {}", path.display())
}

/// The robots of a sweep by the names of their profiles ([`WorldFile::robot_names`]).
pub fn robot_names(source: &ResolvedSweep) -> String {
    let names = |world: &WorldFile| world.robot_names(&source.profile);
    source.sweep.world().map_or_else(|| source.profile.name.clone(), names)
}

/// A moment of a recording: a date where the wall clock was recorded, seconds where a simulation's
/// was.
pub fn moment(time_ns: u64) -> String {
    if time_ns >= FIRST_WALL_NS
        && let Ok(timestamp) = Timestamp::from_nanosecond(time_ns.into())
    {
        return format!("{timestamp:.3}");
    }
    format!("{:.3} s", time_ns as f64 / 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_the_wall_are_dates_and_simulated_ones_are_not() {
        assert_eq!(moment(299_910_000_000), "299.910 s");
        assert_eq!(moment(1_795_248_000_000_000_000), "2026-11-21T08:00:00.000Z");
    }
}
