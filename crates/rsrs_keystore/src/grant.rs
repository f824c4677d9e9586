//! The document of what one enclave may do, as DDS Security 1.1, 9.4.1.3, has it.

use std::time::Duration;

use crate::dates::xml_date;
use crate::error::KeystoreError;
use crate::governance::Domains;
use crate::roles::{Rights, Role};

/// The grant of one enclave.
pub(crate) struct GrantText<'a> {
    pub(crate) role: &'a Role,
    pub(crate) domain_id: u16,
    /// From when to when, since 1970.
    pub(crate) holds: (Duration, Duration),
}

impl GrantText<'_> {
    /// The text of the document, in a fleet of these robots.
    pub(crate) fn to_xml(&self, robots: &[String]) -> Result<String, KeystoreError> {
        let Rights { may_not_publish, may_not_receive, may_publish, may_receive } =
            self.role.rights(robots);
        let name = self.role.enclave();
        let (not_before, not_after) = validity(self.holds)?;
        let domains = Domains { first: self.domain_id, last: self.domain_id };
        let domains = domains.to_xml("          ");
        let rule = |kind: &str, parts: &[String]| {
            format!(
                "      <{kind}>\n        <domains>\n{domains}        </domains>\n{}      </{kind}>\n",
                parts.concat()
            )
        };
        let denied = if may_not_publish.is_empty() {
            String::new()
        } else {
            let parts =
                [topics("publish", &may_not_publish), topics("subscribe", &may_not_receive)];
            rule("deny_rule", &parts)
        };
        let allowed = rule(
            "allow_rule",
            &[topics("publish", &may_publish), topics("subscribe", &may_receive)],
        );
        Ok(format!(
            "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
             xsi:noNamespaceSchemaLocation=\
             \"http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd\">\n  \
             <permissions>\n    <grant name=\"{name}\">\n      <subject_name>CN={name}</subject_name>\n      \
             <validity>\n        <not_before>{not_before}</not_before>\n        \
             <not_after>{not_after}</not_after>\n      </validity>\n{denied}{allowed}      \
             <default>DENY</default>\n    </grant>\n  </permissions>\n</dds>\n"
        ))
    }
}

/// From when to when a grant holds, as dates of its document.
pub(crate) fn validity(
    (from, to): (Duration, Duration),
) -> Result<(String, String), KeystoreError> {
    let dates = xml_date(from).zip(xml_date(to));
    dates.ok_or(KeystoreError::Validity { from_s: from.as_secs(), to_s: to.as_secs() })
}

fn topics(kind: &str, names: &[String]) -> String {
    let line = |name: &String| format!("            <topic>{name}</topic>\n");
    let lines = names.iter().map(line).collect::<Vec<_>>().concat();
    format!("        <{kind}>\n          <topics>\n{lines}          </topics>\n        </{kind}>\n")
}
