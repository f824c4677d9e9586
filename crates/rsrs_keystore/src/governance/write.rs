//! The document as DDS Security 1.1, 9.4.1.2, has it, written.

use super::{DomainRule, Domains, Governance, Protection, Switch, TopicRule};

const START: &str = "\
<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"
    xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd\">
";

impl Protection {
    pub(super) const ALL: [Self; 5] = [
        Self::None,
        Self::Sign,
        Self::Encrypt,
        Self::SignWithOriginAuthentication,
        Self::EncryptWithOriginAuthentication,
    ];

    /// Its name in the document.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::None => "NONE",
            Self::Sign => "SIGN",
            Self::Encrypt => "ENCRYPT",
            Self::SignWithOriginAuthentication => "SIGN_WITH_ORIGIN_AUTHENTICATION",
            Self::EncryptWithOriginAuthentication => "ENCRYPT_WITH_ORIGIN_AUTHENTICATION",
        }
    }
}

impl Switch {
    fn name(self) -> &'static str {
        match self {
            Self::On => "true",
            Self::Off => "false",
        }
    }
}

pub(super) fn to_xml(governance: &Governance) -> String {
    let rules: String = governance.rules.iter().map(domain_rule).collect();
    format!("{START}  <domain_access_rules>\n{rules}  </domain_access_rules>\n</dds>\n")
}

fn domain_rule(rule: &DomainRule) -> String {
    let elements = [
        ("allow_unauthenticated_participants", rule.unauthenticated_participants.name()),
        ("enable_join_access_control", rule.join_access_control.name()),
        ("discovery_protection_kind", rule.discovery.name()),
        ("liveliness_protection_kind", rule.liveliness.name()),
        ("rtps_protection_kind", rule.rtps.name()),
    ];
    let domains: String = rule.domains.iter().map(|those| those.to_xml("          ")).collect();
    let topics: String = rule.topics.iter().map(topic_rule).collect();
    format!(
        "    <domain_rule>\n      <domains>\n{domains}      </domains>\n{}      \
         <topic_access_rules>\n{topics}      </topic_access_rules>\n    </domain_rule>\n",
        lines("      ", &elements)
    )
}

fn topic_rule(rule: &TopicRule) -> String {
    let expression = rule.expression.replace('&', "&amp;").replace('<', "&lt;");
    let elements = [
        ("topic_expression", expression.as_str()),
        ("enable_discovery_protection", rule.discovery_protection.name()),
        ("enable_liveliness_protection", rule.liveliness_protection.name()),
        ("enable_read_access_control", rule.read_access_control.name()),
        ("enable_write_access_control", rule.write_access_control.name()),
        ("metadata_protection_kind", rule.metadata.name()),
        ("data_protection_kind", rule.data.name()),
    ];
    let lines = lines("          ", &elements);
    format!("        <topic_rule>\n{lines}        </topic_rule>\n")
}

fn lines(indent: &str, elements: &[(&str, &str)]) -> String {
    let line = |(name, value): &(&str, &str)| format!("{indent}<{name}>{value}</{name}>\n");
    elements.iter().map(line).collect::<Vec<_>>().concat()
}

impl Domains {
    /// One line of the element `<domains>`, of this document or of permissions.
    pub fn to_xml(self, indent: &str) -> String {
        let Self { first, last } = self;
        if first == last {
            return format!("{indent}<id>{first}</id>\n");
        }
        format!("{indent}<id_range><min>{first}</min><max>{last}</max></id_range>\n")
    }
}
