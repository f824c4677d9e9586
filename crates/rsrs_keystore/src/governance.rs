//! The governance of a keystore: what is protected, and whether that is enough and can be carried.

mod parse;
mod write;

use std::fmt;

pub use parse::GovernanceError;

/// How much a kind of traffic is protected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protection {
    /// Not at all.
    None,
    /// Nobody else can write it.
    Sign,
    /// And nobody else can read it.
    Encrypt,
    /// As [`Protection::Sign`], also towards members that share a key.
    SignWithOriginAuthentication,
    /// As [`Protection::Encrypt`], also towards members that share a key.
    EncryptWithOriginAuthentication,
}

/// Whether something is done; an option of the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// It is.
    On,
    /// It is not.
    Off,
}

/// Domains of one entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Domains {
    /// The first.
    pub first: u16,
    /// The last.
    pub last: u16,
}

impl fmt::Display for Domains {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.first == self.last {
            write!(out, "{}", self.first)
        } else {
            write!(out, "{} to {}", self.first, self.last)
        }
    }
}

impl Domains {
    /// Whether a domain is one of them.
    pub fn contain(self, domain_id: u16) -> bool {
        (self.first..=self.last).contains(&domain_id)
    }
}

/// A whole document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Governance {
    /// The first that matches a domain holds there.
    pub rules: Vec<DomainRule>,
}

/// What holds in some domains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DomainRule {
    /// Where it holds.
    pub domains: Vec<Domains>,
    /// Whether members without a certificate may take part.
    pub unauthenticated_participants: Switch,
    /// Whether joining takes permission.
    pub join_access_control: Switch,
    /// How the announcements of topics are protected.
    pub discovery: Protection,
    /// How signs of life are protected.
    pub liveliness: Protection,
    /// How whole datagrams are protected.
    pub rtps: Protection,
    /// The first that matches a topic holds for it.
    pub topics: Vec<TopicRule>,
}

/// What holds for some topics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicRule {
    /// Which topics, as `rt/*`.
    pub expression: String,
    /// Whether it is announced as [`DomainRule::discovery`] has it.
    pub discovery_protection: Switch,
    /// Whether its signs of life are as [`DomainRule::liveliness`] has it.
    pub liveliness_protection: Switch,
    /// Whether receiving takes permission.
    pub read_access_control: Switch,
    /// Whether publishing takes permission.
    pub write_access_control: Switch,
    /// How its submessages are protected, with the payload in them.
    pub metadata: Protection,
    /// How its payloads are protected once more, by themselves.
    pub data: Protection,
}

const ALL_TOPICS: &str = "*";

/// Why a governance is not used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Weakness {
    /// No rule for the domain.
    #[error("has no rule for domain {domain_id}")]
    NoRule {
        /// The domain.
        domain_id: u16,
    },
    /// Members without a certificate may take part.
    #[error("lets participants without a certificate take part")]
    Unauthenticated,
    /// Joining takes no permission.
    #[error("lets every certificate join (enable_join_access_control is false)")]
    JoiningTakesNoPermission,
    /// Announcements or datagrams can be forged.
    #[error("has {option} NONE, expected SIGN or ENCRYPT")]
    Unprotected {
        /// The option of the document.
        option: &'static str,
    },
    /// Announcements or signs of life of topics are open, or whoever is in may publish or receive what it
    /// likes.
    #[error("has {option} false for topics `{expression}`")]
    TopicTakesNoPermission {
        /// Which topics.
        expression: String,
        /// The option of the document.
        option: &'static str,
    },
    /// Submessages of topics are not protected: whoever is on the network can forge them.
    #[error(
        "leaves submessages of topics `{expression}` unprotected (metadata_protection_kind NONE), so \
         that anybody on the network can forge them"
    )]
    Forgeable {
        /// Which topics.
        expression: String,
    },
    /// Payloads are protected by themselves, and the middleware loses those whose length is no
    /// multiple of 4 or above 65 kB.
    #[error(
        "protects payloads of topics `{expression}` by themselves (data_protection_kind), and this \
         middleware loses those whose length is no multiple of 4; submessages that are encrypted \
         contain them already"
    )]
    PayloadProtected {
        /// Which topics.
        expression: String,
    },
    /// No rule for all other topics.
    #[error("has no rule for all other topics (`*`)")]
    TopicsWithoutRule,
    /// The keys of a member, which all have that receive it, are all that it takes to send in its name.
    #[error(
        "has {option} without _WITH_ORIGIN_AUTHENTICATION, so that a thief with the keys of one \
         robot can send in the name of every member"
    )]
    MembersCanForge {
        /// The option of the document.
        option: &'static str,
    },
}

impl Weakness {
    /// Whether only who has the keys of a member can use it: such a keystore is used, with a warning.
    pub fn is_of_members(&self) -> bool {
        matches!(self, Self::MembersCanForge { .. })
    }
}

impl Protection {
    /// The same, also towards members.
    fn with_origin_authentication(self) -> Self {
        match self {
            Self::Sign => Self::SignWithOriginAuthentication,
            Self::Encrypt => Self::EncryptWithOriginAuthentication,
            kind => kind,
        }
    }

    fn lets_members_forge(self) -> bool {
        self != self.with_origin_authentication()
    }
}

impl Governance {
    /// What this middleware carries and nobody can forge, members included: SROS2's default, with
    /// announcements and submessages signed for each receiver with a key of its own, and payloads protected
    /// as a part of their submessages and not once more by themselves.
    ///
    /// Datagrams are signed for all receivers at once: what is in them is protected by itself, and to sign
    /// both for each receiver makes a fleet start twice as slowly.
    pub fn recommended(domains: Domains) -> Self {
        let rule = DomainRule {
            domains: vec![domains],
            unauthenticated_participants: Switch::Off,
            join_access_control: Switch::On,
            discovery: Protection::EncryptWithOriginAuthentication,
            liveliness: Protection::EncryptWithOriginAuthentication,
            rtps: Protection::Sign,
            topics: vec![TopicRule::recommended(ALL_TOPICS)],
        };
        Self { rules: vec![rule] }
    }

    /// Reads the text of the document.
    pub fn parse(xml: &str) -> Result<Self, GovernanceError> {
        parse::parse(xml)
    }

    /// The text of the document.
    pub fn to_xml(&self) -> String {
        write::to_xml(self)
    }

    /// What is wrong with it in a domain; nothing if it can be used.
    pub fn weaknesses(&self, domain_id: u16) -> Vec<Weakness> {
        let holds = |rule: &&DomainRule| rule.domains.iter().any(|those| those.contain(domain_id));
        match self.rules.iter().find(holds) {
            Some(rule) => rule.weaknesses(),
            None => vec![Weakness::NoRule { domain_id }],
        }
    }

    /// What is wrong with it in any of its domains: of each rule, also of those that another one goes
    /// before in some of them.
    pub fn all_weaknesses(&self) -> Vec<Weakness> {
        self.rules.iter().flat_map(DomainRule::weaknesses).collect()
    }

    /// The domains that it is for.
    pub fn domains(&self) -> impl Iterator<Item = Domains> {
        self.rules.iter().flat_map(|rule| rule.domains.iter().copied())
    }

    /// The same for the same domains and topics, with nothing wrong. What is protected more than is
    /// needed stays so.
    #[must_use]
    pub fn hardened(&self) -> Self {
        Self { rules: self.rules.iter().map(DomainRule::hardened).collect() }
    }
}

impl DomainRule {
    fn weaknesses(&self) -> Vec<Weakness> {
        let mut found = Vec::new();
        if self.unauthenticated_participants == Switch::On {
            found.push(Weakness::Unauthenticated);
        }
        if self.join_access_control == Switch::Off {
            found.push(Weakness::JoiningTakesNoPermission);
        }
        let announced = [
            ("discovery_protection_kind", self.discovery),
            ("liveliness_protection_kind", self.liveliness),
        ];
        let kinds = announced.into_iter().chain([("rtps_protection_kind", self.rtps)]);
        let open = kinds.filter(|(_, kind)| *kind == Protection::None);
        found.extend(open.map(|(option, _)| Weakness::Unprotected { option }));
        found.extend(self.topics.iter().flat_map(TopicRule::weaknesses));
        if !self.topics.iter().any(|topic| topic.expression == ALL_TOPICS) {
            found.push(Weakness::TopicsWithoutRule);
        }
        let of_topics =
            self.topics.iter().map(|topic| ("metadata_protection_kind", topic.metadata));
        let mut forgeable: Vec<_> = announced
            .into_iter()
            .chain(of_topics)
            .filter(|(_, kind)| kind.lets_members_forge())
            .map(|(option, _)| Weakness::MembersCanForge { option })
            .collect();
        forgeable.dedup();
        found.extend(forgeable);
        found
    }

    fn hardened(&self) -> Self {
        let at_least = |kind, least| if kind == Protection::None { least } else { kind };
        let protected = |kind| at_least(kind, Protection::Encrypt).with_origin_authentication();
        let mut topics: Vec<_> = self.topics.iter().map(TopicRule::hardened).collect();
        if !topics.iter().any(|topic| topic.expression == ALL_TOPICS) {
            topics.push(TopicRule::recommended(ALL_TOPICS));
        }
        Self {
            domains: self.domains.clone(),
            unauthenticated_participants: Switch::Off,
            join_access_control: Switch::On,
            discovery: protected(self.discovery),
            liveliness: protected(self.liveliness),
            rtps: at_least(self.rtps, Protection::Sign),
            topics,
        }
    }
}

impl TopicRule {
    fn recommended(expression: &str) -> Self {
        Self {
            expression: expression.to_owned(),
            discovery_protection: Switch::On,
            liveliness_protection: Switch::On,
            read_access_control: Switch::On,
            write_access_control: Switch::On,
            metadata: Protection::EncryptWithOriginAuthentication,
            data: Protection::None,
        }
    }

    fn weaknesses(&self) -> Vec<Weakness> {
        let expression = || self.expression.clone();
        let options = [
            ("enable_discovery_protection", self.discovery_protection),
            ("enable_liveliness_protection", self.liveliness_protection),
            ("enable_read_access_control", self.read_access_control),
            ("enable_write_access_control", self.write_access_control),
        ];
        let open = options.into_iter().filter(|(_, option)| *option == Switch::Off);
        let mut found: Vec<_> = open
            .map(|(option, _)| Weakness::TopicTakesNoPermission {
                expression: expression(),
                option,
            })
            .collect();
        if self.metadata == Protection::None {
            found.push(Weakness::Forgeable { expression: expression() });
        }
        if self.data != Protection::None {
            found.push(Weakness::PayloadProtected { expression: expression() });
        }
        found
    }

    fn hardened(&self) -> Self {
        let metadata = match self.metadata {
            Protection::None => Protection::Encrypt,
            // Payloads that were to be secret stay so.
            Protection::Sign if self.data == Protection::Encrypt => Protection::Encrypt,
            kind => kind,
        };
        Self {
            metadata: metadata.with_origin_authentication(),
            ..Self::recommended(&self.expression)
        }
    }
}

#[cfg(test)]
mod tests;
