//! What a process may do, as far as that decides whether it can start.

use std::str::FromStr;

use roxmltree::{Document, Node};
use x509_cert::name::Name;

use crate::governance::Domains;

/// The permissions of a process: grants, of which one should be its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Permissions {
    /// In the order of the document.
    pub grants: Vec<Grant>,
}

/// What one certificate may do.
#[derive(Clone, Debug, PartialEq)]
pub struct Grant {
    /// Whose certificate, as the document has it: `CN=/robot_3`.
    pub subject: String,
    /// When it begins and when it ends, as the document has it.
    pub validity: (String, String),
    /// In which domains it allows anything.
    pub domains: Vec<Domains>,
}

/// A document that is none of permissions.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PermissionsError {
    /// It is no XML.
    #[error("the permissions are no XML: {reason}")]
    Xml {
        /// Line, column and reason.
        reason: String,
    },
    /// Something that each grant has is missing.
    #[error("a grant of the permissions lacks <{element}>")]
    Missing {
        /// What it should have.
        element: &'static str,
    },
}

impl Permissions {
    /// Reads the text of the document.
    pub fn parse(xml: &str) -> Result<Self, PermissionsError> {
        let document = Document::parse(xml)
            .map_err(|error| PermissionsError::Xml { reason: error.to_string() })?;
        let grants = document.descendants().filter(|node| node.has_tag_name("grant"));
        Ok(Self { grants: grants.map(grant).collect::<Result<_, _>>()? })
    }

    /// The grant of a certificate, by the subject that it names.
    pub fn grant_of(&self, subject: &str) -> Option<&Grant> {
        self.grants.iter().find(|grant| {
            let written = Name::from_str(grant.subject.trim());
            written.is_ok_and(|name| name.to_string() == subject)
        })
    }
}

fn grant(node: Node<'_, '_>) -> Result<Grant, PermissionsError> {
    let text = |element: &'static str| {
        let found = node.descendants().find(|node| node.has_tag_name(element));
        let text = found.and_then(|node| node.text()).map(|text| text.trim().to_owned());
        text.ok_or(PermissionsError::Missing { element })
    };
    let rules = node.children().filter(|node| node.has_tag_name("allow_rule"));
    Ok(Grant {
        subject: text("subject_name")?,
        validity: (text("not_before")?, text("not_after")?),
        domains: rules.flat_map(Domains::all_in).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const XML: &str = "<dds><permissions><grant name='/robot_3'>\
        <subject_name>CN=/robot_3</subject_name>\
        <validity><not_before>2026-01-01T00:00:00</not_before>\
        <not_after>2036-01-01T00:00:00</not_after></validity>\
        <allow_rule><domains><id>7</id></domains><publish><topics><topic>rt/a</topic></topics>\
        </publish></allow_rule><default>DENY</default></grant></permissions></dds>";

    #[test]
    fn a_grant_is_found_by_the_name_of_its_certificate() {
        let permissions = Permissions::parse(XML).unwrap();

        let grant = permissions.grant_of("CN=/robot_3").unwrap();

        assert!(grant.domains.iter().any(|domains| domains.contain(7)));
        assert!(!grant.domains.iter().any(|domains| domains.contain(0)));
        assert_eq!(grant.validity.1, "2036-01-01T00:00:00");
        assert_eq!(permissions.grant_of("CN=/robot_33"), None);
    }

    #[test]
    fn what_a_grant_lacks_is_named() {
        let error = Permissions::parse(&XML.replace("subject_name", "name")).unwrap_err();

        assert_eq!(error, PermissionsError::Missing { element: "subject_name" });
        assert!(matches!(Permissions::parse("<dds>"), Err(PermissionsError::Xml { .. })));
    }
}
