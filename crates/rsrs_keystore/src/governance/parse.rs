//! The document as DDS Security 1.1, 9.4.1.2, has it, read.

use roxmltree::{Document, Node};

use super::{DomainRule, Domains, Governance, Protection, Switch, TopicRule};

/// Why a document is no governance.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GovernanceError {
    /// It is no XML.
    #[error("the governance is no XML: {reason}")]
    Xml {
        /// Line, column and reason.
        reason: String,
    },
    /// Something that it must have is missing.
    #[error("<{parent}> of the governance lacks <{element}>")]
    Missing {
        /// Where.
        parent: String,
        /// What it should have.
        element: &'static str,
    },
    /// A value that is none of those allowed.
    #[error("<{element}> of the governance is `{found}`, expected {expected}")]
    Value {
        /// Where.
        element: &'static str,
        /// Its value.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
}

pub(super) fn parse(xml: &str) -> Result<Governance, GovernanceError> {
    let document =
        Document::parse(xml).map_err(|error| GovernanceError::Xml { reason: error.to_string() })?;
    let rules = all(child(document.root_element(), "domain_access_rules")?, "domain_rule");
    Ok(Governance { rules: rules.map(domain_rule).collect::<Result<_, _>>()? })
}

fn domain_rule(node: Node<'_, '_>) -> Result<DomainRule, GovernanceError> {
    let topics = all(child(node, "topic_access_rules")?, "topic_rule");
    Ok(DomainRule {
        domains: Domains::all_in(node).collect(),
        unauthenticated_participants: switch(node, "allow_unauthenticated_participants")?,
        join_access_control: switch(node, "enable_join_access_control")?,
        discovery: protection(node, "discovery_protection_kind")?,
        liveliness: protection(node, "liveliness_protection_kind")?,
        rtps: protection(node, "rtps_protection_kind")?,
        topics: topics.map(topic_rule).collect::<Result<_, _>>()?,
    })
}

fn topic_rule(node: Node<'_, '_>) -> Result<TopicRule, GovernanceError> {
    Ok(TopicRule {
        expression: text(node, "topic_expression")?.to_owned(),
        discovery_protection: switch(node, "enable_discovery_protection")?,
        liveliness_protection: switch(node, "enable_liveliness_protection")?,
        read_access_control: switch(node, "enable_read_access_control")?,
        write_access_control: switch(node, "enable_write_access_control")?,
        metadata: protection(node, "metadata_protection_kind")?,
        data: protection(node, "data_protection_kind")?,
    })
}

impl Domains {
    /// Those of the element `<domains>` of a rule. Numbers that are none count as no domain.
    pub(crate) fn all_in(rule: Node<'_, '_>) -> impl Iterator<Item = Self> {
        let entries = all(rule, "domains").flat_map(|domains| domains.children());
        let number = |node: Node<'_, '_>| node.text().and_then(|text| text.trim().parse().ok());
        let entries: Vec<Self> = entries
            .filter_map(|entry| match entry.tag_name().name() {
                "id" => number(entry).map(|id| Self { first: id, last: id }),
                "id_range" => {
                    let end = |name| all(entry, name).next().and_then(number);
                    let first = end("min").unwrap_or(0);
                    Some(Self { first, last: end("max").unwrap_or(u16::MAX) })
                }
                _ => None,
            })
            .collect();
        entries.into_iter()
    }
}

fn all<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |node| node.has_tag_name(name))
}

fn child<'a, 'input>(
    node: Node<'a, 'input>,
    element: &'static str,
) -> Result<Node<'a, 'input>, GovernanceError> {
    let missing =
        || GovernanceError::Missing { parent: node.tag_name().name().to_owned(), element };
    all(node, element).next().ok_or_else(missing)
}

fn text<'a>(node: Node<'a, '_>, element: &'static str) -> Result<&'a str, GovernanceError> {
    Ok(child(node, element)?.text().unwrap_or_default().trim())
}

fn switch(node: Node<'_, '_>, element: &'static str) -> Result<Switch, GovernanceError> {
    let found = text(node, element)?;
    match found.to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(Switch::On),
        "false" | "0" => Ok(Switch::Off),
        _ => Err(GovernanceError::Value {
            element,
            found: found.to_owned(),
            expected: "true or false",
        }),
    }
}

fn protection(node: Node<'_, '_>, element: &'static str) -> Result<Protection, GovernanceError> {
    let found = text(node, element)?;
    let known = Protection::ALL.into_iter().find(|kind| kind.name() == found);
    known.ok_or_else(|| GovernanceError::Value {
        element,
        found: found.to_owned(),
        expected: "NONE, SIGN, ENCRYPT, SIGN_WITH_ORIGIN_AUTHENTICATION or \
                   ENCRYPT_WITH_ORIGIN_AUTHENTICATION",
    })
}
