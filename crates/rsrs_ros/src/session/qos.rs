//! Quality of service in the words of both libraries.

use ros2_client::QosProfile;
use ros2_client::qos::{self, WhenFull};
use rsrs_msgs::topics::{Durability, Qos, Reliability};
use rustdds::QosPolicies;

/// In the words of ros2-client. A full window blocks; the publishers bring their own timeout.
pub(crate) fn profile(quality: Qos) -> QosProfile {
    let reliability = match quality.reliability {
        Reliability::Reliable => qos::Reliability::Reliable { when_full: WhenFull::Block },
        Reliability::BestEffort => qos::Reliability::BestEffort,
    };
    let durability = match quality.durability {
        Durability::Volatile => qos::Durability::Volatile,
        Durability::TransientLocal => qos::Durability::TransientLocal,
    };
    let depth = usize::try_from(quality.depth).expect("a depth fits the address space");
    QosProfile::default()
        .reliability(reliability)
        .durability(durability)
        .history(qos::History::KeepLast { depth })
}

/// In the words of rustdds.
pub(super) fn policies(quality: Qos) -> QosPolicies {
    profile(quality).into()
}

/// From the types of rustdds. Discovery does not carry the depth, which is 0 here.
pub(super) fn discovered(policies: &QosPolicies) -> Qos {
    let reliability = match policies.reliability() {
        Some(rustdds::policy::Reliability::Reliable { .. }) => Reliability::Reliable,
        Some(rustdds::policy::Reliability::BestEffort) | None => Reliability::BestEffort,
    };
    let durability = match policies.durability() {
        Some(rustdds::policy::Durability::Volatile) | None => Durability::Volatile,
        Some(_) => Durability::TransientLocal,
    };
    Qos { reliability, durability, depth: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reliability_and_durability_survive_the_way_through_the_middleware() {
        for reliability in [Reliability::Reliable, Reliability::BestEffort] {
            for durability in [Durability::Volatile, Durability::TransientLocal] {
                let quality = Qos { reliability, durability, depth: 7 };

                assert_eq!(discovered(&policies(quality)), Qos { depth: 0, ..quality });
            }
        }
    }
}
