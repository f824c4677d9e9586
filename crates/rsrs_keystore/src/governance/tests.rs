use super::*;

const ZERO: Domains = Domains { first: 0, last: 0 };

/// As `ros2 security create_keystore` writes it.
fn of_sros2() -> Governance {
    let mut governance = Governance::recommended(ZERO);
    governance.rules[0].topics[0].data = Protection::Encrypt;
    governance
}

#[test]
fn what_is_written_is_read_back() {
    for last in [0, 7] {
        let written = Governance::recommended(Domains { first: 0, last });

        assert_eq!(Governance::parse(&written.to_xml()), Ok(written));
    }
}

#[test]
fn what_is_recommended_has_no_weakness_where_it_holds() {
    let governance = Governance::recommended(Domains { first: 3, last: 5 });

    assert_eq!(governance.weaknesses(4), []);
    assert_eq!(governance.weaknesses(0), [Weakness::NoRule { domain_id: 0 }]);
}

#[test]
fn the_default_of_sros2_is_not_carried_and_can_be_hardened() {
    let weaknesses = of_sros2().weaknesses(0);

    assert_eq!(weaknesses, [Weakness::PayloadProtected { expression: "*".to_owned() }]);
    assert_eq!(of_sros2().hardened(), Governance::recommended(ZERO));
}

#[test]
fn each_way_to_be_open_is_a_weakness_that_hardening_ends() {
    type Opened = fn(&mut DomainRule);
    let ways: [(Opened, &str); 15] = [
        (|rule| rule.unauthenticated_participants = Switch::On, "without a certificate"),
        (|rule| rule.join_access_control = Switch::Off, "enable_join_access_control"),
        (|rule| rule.discovery = Protection::None, "discovery_protection_kind NONE"),
        (|rule| rule.liveliness = Protection::None, "liveliness_protection_kind NONE"),
        (|rule| rule.rtps = Protection::None, "rtps_protection_kind NONE"),
        (|rule| rule.topics[0].metadata = Protection::None, "forge"),
        (|rule| rule.topics[0].data = Protection::Sign, "multiple of 4"),
        (|rule| rule.topics[0].discovery_protection = Switch::Off, "enable_discovery_protection"),
        (|rule| rule.topics[0].liveliness_protection = Switch::Off, "enable_liveliness_protection"),
        (|rule| rule.topics[0].write_access_control = Switch::Off, "enable_write_access_control"),
        (|rule| rule.topics[0].read_access_control = Switch::Off, "enable_read_access_control"),
        (|rule| rule.topics[0].expression = "rt/a*".to_owned(), "all other topics"),
        (|rule| rule.discovery = Protection::Encrypt, "discovery_protection_kind without"),
        (|rule| rule.liveliness = Protection::Sign, "liveliness_protection_kind without"),
        (|rule| rule.topics[0].metadata = Protection::Encrypt, "metadata_protection_kind without"),
    ];
    for (open, expected) in ways {
        let mut governance = Governance::recommended(ZERO);
        open(&mut governance.rules[0]);

        let weaknesses = governance.weaknesses(0);

        assert_eq!(weaknesses.len(), 1, "{weaknesses:?}");
        assert!(weaknesses[0].to_string().contains(expected), "{}", weaknesses[0]);
        assert_eq!(governance.hardened().weaknesses(0), []);
    }
}

#[test]
fn hardening_keeps_payloads_secret_that_were() {
    let mut governance = of_sros2();
    governance.rules[0].topics[0].metadata = Protection::Sign;

    let hardened = governance.hardened();

    assert_eq!(hardened.rules[0].topics[0].metadata, Protection::EncryptWithOriginAuthentication);
}

#[test]
fn what_a_document_lacks_or_has_wrong_is_named() {
    let xml = Governance::recommended(ZERO).to_xml();

    let lacks = Governance::parse(&xml.replace("rtps_protection_kind", "rtps")).unwrap_err();
    let wrong = Governance::parse(&xml.replace("SIGN", "SIGNED")).unwrap_err();

    assert_eq!(lacks.to_string(), "<domain_rule> of the governance lacks <rtps_protection_kind>");
    assert!(wrong.to_string().contains("is `SIGNED`, expected NONE, SIGN"), "{wrong}");
    assert!(matches!(Governance::parse("dds"), Err(GovernanceError::Xml { .. })));
}

#[test]
fn the_first_rule_of_a_domain_holds() {
    let mut governance = of_sros2();
    governance.rules.insert(0, Governance::recommended(ZERO).rules.remove(0));

    assert_eq!(governance.weaknesses(0), []);
}
