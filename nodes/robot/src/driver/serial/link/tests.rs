use proptest::prelude::*;

use super::super::line::encode;
use super::*;

const FORWARD: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

fn receive(link: &mut Link, body: &str, at_ms: u64) -> Result<Vec<Report>, LinkError> {
    link.on_bytes(encode(body).as_bytes(), ms(at_ms))
}

/// A link whose microcontroller has identified itself, and stands.
fn greeted() -> Link {
    let mut link = Link::new(7, ms(0));
    let greeting = link.on_tick(ms(0)).unwrap();
    assert_eq!(greeting, Some(encode("H,1,7")));
    assert_eq!(receive(&mut link, "I,1,7,test,250,400,20,750", 0), Ok(vec![]));
    assert_eq!(receive(&mut link, "S,40,-,0,0,T,-,-,-", 0), Ok(vec![Report::Up]));
    link
}

#[test]
fn no_command_is_sent_before_the_microcontroller_has_identified_itself() {
    let mut link = Link::new(7, ms(0));

    assert_eq!(link.drive(FORWARD, ms(0)), None);
    receive(&mut link, "I,1,6,test,250,400,20,750", 0).unwrap();
    assert_eq!(link.drive(FORWARD, ms(0)), None, "that was the answer to an earlier greeting");
    assert_eq!(greeted().drive(FORWARD, ms(0)), Some(encode("V,1,40,150,750")));
}

#[test]
fn greetings_are_repeated_until_patience_ends() {
    let mut link = Link::new(7, ms(0));

    assert!(link.on_tick(ms(0)).unwrap().is_some());
    assert!(link.on_tick(ms(199)).unwrap().is_none());
    assert!(link.on_tick(ms(200)).unwrap().is_some());
    assert_eq!(link.on_tick(ms(5000)), Err(LinkError::NoAnswer));
}

#[test]
fn a_microcontroller_that_does_not_fit_is_refused() {
    let mut link = Link::new(7, ms(0));
    assert_eq!(
        receive(&mut link, "I,2,7,test,250,400,20,750", 0),
        Err(LinkError::Version { found: 2 })
    );

    let mut link = Link::new(7, ms(0));
    assert_eq!(
        receive(&mut link, "I,1,7,test,2000,400,20,750", 0),
        Err(LinkError::Timeout { found_ms: 2000 })
    );
}

#[test]
fn a_state_brings_what_it_carries() {
    let mut link = greeted();

    let reports = receive(&mut link, "S,40,-,0,0,T,1,312,7400", 10).unwrap();

    let [Report::Sensed(sensed), Report::Battery(battery_v)] = &reports[..] else {
        panic!("{reports:?}");
    };
    assert_eq!(sensed.seen, Some(true));
    let range = sensed.range.as_ref().expect("a distance was sent");
    assert_eq!((range.range, range.max_range, range.field_of_view), (0.312, 0.75, 0.4));
    assert!((battery_v - 7.4).abs() < 1e-6);
}

#[test]
fn a_wrong_further_reading_is_reported_and_named_when_no_state_is_left() {
    let mut link = greeted();
    let wrong = "further reading `wall=2`, expected `NAME=0` or `NAME=1` with the name of a sensor, in small \
                 letters, digits and `_`";

    let reports = receive(&mut link, "S,90,-,0,0,T,1,-,-,wall=2", 10);

    assert_eq!(reports, Ok(vec![Report::Refused(wrong.to_owned())]));
    let silent = link.on_tick(ms(500)).unwrap_err().to_string();
    let expected = "no state of the microcontroller for 500 ms, its last line was refused: ";
    assert_eq!(silent, format!("{expected}{wrong}"));
    let damaged = encode("S,90,-,0,0,T,1,-,-").replace('T', "R");
    assert_eq!(greeted().on_bytes(damaged.as_bytes(), ms(10)), Ok(vec![]), "a cable is no program");
}

#[test]
fn silence_ends_the_conversation() {
    let mut link = greeted();

    assert_eq!(link.on_tick(ms(499)), Ok(None));
    assert_eq!(link.due(), ms(500));
    assert_eq!(link.on_tick(ms(500)), Err(LinkError::Silent { refused: None }));
}

#[test]
fn a_microcontroller_that_talks_but_does_not_listen_is_noticed() {
    let mut link = greeted();
    link.drive(FORWARD, ms(0)).unwrap();

    for at_ms in (50..500).step_by(50) {
        receive(&mut link, "S,40,-,0,0,T,-,-,-", at_ms).unwrap();
        assert_eq!(link.on_tick(ms(at_ms)), Ok(None));
    }
    assert_eq!(link.on_tick(ms(500)), Err(LinkError::Unacknowledged));
}

#[test]
fn wheels_that_report_another_command_are_noticed() {
    let mut link = greeted();
    link.drive(FORWARD, ms(0)).unwrap();
    assert_eq!(receive(&mut link, "S,40,1,150,750,R,-,-,-", 10), Ok(vec![]));

    let found = Setpoint { speed_mm_s: 250, turn_rate_mrad_s: 750 };
    let expected = Setpoint { speed_mm_s: 150, turn_rate_mrad_s: 750 };
    assert_eq!(
        receive(&mut link, "S,40,1,250,750,R,-,-,-", 20),
        Err(LinkError::WrongWheels { found, expected })
    );
}

#[test]
fn wheels_that_run_on_after_the_timeout_are_noticed() {
    let mut link = greeted();
    link.drive(FORWARD, ms(0)).unwrap();

    let error = receive(&mut link, "S,40,1,150,750,T,-,-,-", 300).unwrap_err();

    assert!(matches!(error, LinkError::WrongWheels { .. }), "{error:?}");
}

#[test]
fn a_command_that_was_never_sent_a_restart_and_a_fault_end_the_conversation() {
    for (body, expected) in [
        ("S,40,9,0,0,R,-,-,-", LinkError::NeverSent { found: 9 }),
        ("S,40,-,0,0,N,-,-,-", LinkError::Restarted),
        ("S,40,-,0,0,F,-,-,-", LinkError::Fault),
    ] {
        assert_eq!(receive(&mut greeted(), body, 0), Err(expected));
    }
}

#[test]
fn a_line_without_an_end_does_not_take_the_next_one_with_it() {
    let mut link = greeted();
    link.on_bytes(b"$S,40,-,0,0,T,1", ms(10)).unwrap();

    let reports = receive(&mut link, "S,40,-,0,0,T,0,-,-", 10).unwrap();

    assert_eq!(reports.len(), 1);
    assert_eq!(link.counts(), Counts { understood: 3, garbled: 1 });
}

#[test]
fn a_flood_without_an_end_is_thrown_away() {
    let mut link = greeted();

    link.on_bytes(&vec![b'$'; 100_000], ms(10)).unwrap();
    link.on_bytes(&vec![b'7'; 100_000], ms(10)).unwrap();

    assert!(link.line.capacity() <= 2 * LONGEST_STATE);
    assert_eq!(receive(&mut link, "S,40,-,0,0,T,0,-,-", 10).unwrap().len(), 1);
}

#[test]
fn command_numbers_start_again() {
    let mut link = greeted();

    for count in 1..=70_000_u32 {
        link.drive(FORWARD, ms(0)).expect("the way is free");
        let sequence = count % 65_536;
        receive(&mut link, &format!("S,40,{sequence},150,750,R,-,-,-"), 0).unwrap();
    }
}

proptest! {
    #[test]
    fn noise_is_no_message_and_no_panic(noise in proptest::collection::vec(any::<u8>(), 0..2000)) {
        let mut link = greeted();

        prop_assert_eq!(link.on_bytes(&noise, ms(10)), Ok(vec![]));
    }

    #[test]
    fn what_comes_in_pieces_is_what_comes_at_once(cuts in proptest::collection::vec(1_usize..9, 40)) {
        let whole = encode("S,40,-,0,0,T,1,312,7400");
        let mut left = whole.as_bytes();
        let (mut link, mut reports) = (greeted(), Vec::new());

        for cut in cuts {
            let (piece, rest) = left.split_at(cut.min(left.len()));
            left = rest;
            reports.extend(link.on_bytes(piece, ms(10)).unwrap());
        }
        reports.extend(link.on_bytes(left, ms(10)).unwrap());

        prop_assert_eq!(reports, receive(&mut greeted(), "S,40,-,0,0,T,1,312,7400", 10).unwrap());
    }
}
