//! The lines of the serial protocol: `$BODY*CRC`, see `docs/serial_protocol.md`.

use rsrs_core::document::is_name;
use rsrs_core::robot::controller::Command;

/// Version of the protocol.
pub const VERSION: u32 = 1;

/// The longest line to a microcontroller, with its end.
pub const LONGEST: usize = 80;

/// The longest line of a microcontroller, with its end: one with many further readings.
pub const LONGEST_STATE: usize = 320;

/// CRC-16/CCITT-FALSE: polynomial 0x1021 from 0xFFFF, most significant bit first.
///
/// # Example
///
/// The check value of the catalogue of CRCs.
///
/// ```
/// assert_eq!(rsrs_robot_node::driver::serial::line::crc(b"123456789"), 0x29B1);
/// ```
pub fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |sum, byte| {
        (0..8).fold(sum ^ (u16::from(*byte) << 8), |sum, _| {
            if sum & 0x8000 == 0 { sum << 1 } else { (sum << 1) ^ 0x1021 }
        })
    })
}

/// Wheel commands as they travel: whole millimetres and milliradians per second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Setpoint {
    /// Forward speed, in mm/s.
    pub speed_mm_s: i32,
    /// Turning rate, in mrad/s.
    pub turn_rate_mrad_s: i32,
}

/// The greatest number of a setpoint; far beyond any robot on a floor.
const MOST: i32 = 30_000;

impl Setpoint {
    /// Rounds a command.
    ///
    /// # Panics
    ///
    /// If the command is not finite or beyond 30 m/s or 30 rad/s; the robot's limits are below.
    #[expect(clippy::cast_possible_truncation, reason = "the range is asserted")]
    pub fn new(command: Command) -> Self {
        let whole = |value: f64| {
            let thousandths = (value * 1000.0).round();
            assert!(thousandths.abs() <= f64::from(MOST), "{value} is beyond every robot's limits");
            thousandths as i32
        };
        Self {
            speed_mm_s: whole(command.speed_m_s),
            turn_rate_mrad_s: whole(command.turn_rate_rad_s),
        }
    }
}

/// Lines of the robot's computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToDevice {
    /// Who are you? Wheels stop, and commands from before do not count.
    Hello {
        /// Comes back in the answer.
        nonce: u16,
    },
    /// A command for the wheels.
    Drive {
        /// Counts commands, and starts again after 65,535.
        sequence: u16,
        /// The time of the last state that was received: the microcontroller's own clock gives how
        /// old the command is.
        time_ms: u32,
        /// The command.
        setpoint: Setpoint,
    },
}

impl ToDevice {
    /// The line, with its end.
    pub fn encode(&self) -> String {
        let body = match self {
            Self::Hello { nonce } => format!("H,{VERSION},{nonce}"),
            Self::Drive { sequence, time_ms, setpoint } => {
                let Setpoint { speed_mm_s, turn_rate_mrad_s } = setpoint;
                format!("V,{sequence},{time_ms},{speed_mm_s},{turn_rate_mrad_s}")
            }
        };
        encode(&body)
    }
}

/// Puts a body between its marks.
pub fn encode(body: &str) -> String {
    format!("${body}*{:04X}\n", crc(body.as_bytes()))
}

/// Lines of the microcontroller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FromDevice {
    /// The answer to [`ToDevice::Hello`].
    Identity(Identity),
    /// What the microcontroller does and measures.
    State(State),
}

/// Who a microcontroller is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// Its version of the protocol.
    pub version: u32,
    /// That of the question.
    pub nonce: u16,
    /// Name of its program.
    pub name: String,
    /// So long after the last valid command, its wheels stop, in ms.
    pub timeout_ms: u32,
    /// Whole opening angle of its distance sensor, in mrad; 0 if it has none.
    pub field_of_view_mrad: u32,
    /// Closest distance that the sensor can measure, in mm.
    pub min_range_mm: u32,
    /// Farthest distance that the sensor can measure, in mm.
    pub max_range_mm: u32,
}

/// What a microcontroller does and measures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// When it was sent, in ms by the microcontroller's own clock, which starts again after 2³².
    pub time_ms: u32,
    /// Number of the last command that it took; `None` if it took none since the greeting.
    pub sequence: Option<u16>,
    /// The command of its wheels now.
    pub setpoint: Setpoint,
    /// How it is.
    pub mode: Mode,
    /// The detection, if the microcontroller decides it.
    pub seen: Option<bool>,
    /// The reading of its distance sensor, if it has one.
    pub range: Option<RangeReading>,
    /// Voltage of the battery, in mV, if it is measured.
    pub battery_mv: Option<u32>,
    /// What further sensors report, by name.
    pub further: Vec<(String, bool)>,
}

/// How a microcontroller is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Not greeted since it was switched on.
    Fresh,
    /// Commands are obeyed.
    Driving,
    /// The last valid command is too old, or there was none: the wheels stand.
    TimedOut,
    /// Its hardware has failed: the wheels stand.
    Fault,
}

/// The reading of a distance sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeReading {
    /// So far away, in mm.
    Distance(u32),
    /// Nothing in range.
    Nothing,
    /// The measurement failed.
    Failed,
}

/// Why a line means nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineError {
    /// It lacks its marks, is too long, or is not ASCII.
    #[error("no line of the form $BODY*CRC")]
    Form,
    /// It was damaged on the way.
    #[error("checksum {found:04X}, expected {expected:04X}")]
    Checksum {
        /// The line.
        found: u16,
        /// That of its body.
        expected: u16,
    },
    /// It arrived whole, and is no line of the protocol.
    #[error("`{body}`, expected I or S with their fields")]
    Body {
        /// What is between the marks.
        body: String,
    },
    /// It arrived whole, and one of its further readings means nothing.
    #[error(
        "further reading `{found}`, expected `NAME=0` or `NAME=1` with the name of a sensor, in small letters, \
         digits and `_`"
    )]
    Reading {
        /// The reading.
        found: String,
    },
}

impl LineError {
    /// Whether it came as it was sent: then no line like it will be understood.
    pub fn is_of_its_program(&self) -> bool {
        match self {
            Self::Form | Self::Checksum { .. } => false,
            Self::Body { .. } | Self::Reading { .. } => true,
        }
    }
}

impl FromDevice {
    /// Understands a line, without its end.
    pub fn decode(line: &[u8]) -> Result<Self, LineError> {
        let body = body_of(line)?;
        let fields: Vec<&str> = body.split(',').collect();
        if let ["S", _, _, _, _, _, _, _, _, ref further @ ..] = fields[..]
            && let Some(wrong) = further.iter().find(|text| further_reading(text).is_none())
        {
            return Err(LineError::Reading { found: (*wrong).to_owned() });
        }
        let decoded = match fields[..] {
            ["I", ref fields @ ..] => identity(fields).map(Self::Identity),
            ["S", ref fields @ ..] => state(fields).map(Self::State),
            _ => None,
        };
        decoded.ok_or_else(|| LineError::Body { body: body.to_owned() })
    }
}

/// The body of a line whose marks and checksum are right.
fn body_of(line: &[u8]) -> Result<&str, LineError> {
    let text = std::str::from_utf8(line).map_err(|_not_text| LineError::Form)?;
    let (body, sum) = text
        .strip_prefix('$')
        .and_then(|rest| rest.split_once('*'))
        .filter(|(_, sum)| sum.len() == 4 && sum.bytes().all(|digit| digit.is_ascii_hexdigit()))
        .ok_or(LineError::Form)?;
    let found = u16::from_str_radix(sum, 16).expect("four hexadecimal digits are a number");
    let expected = crc(body.as_bytes());
    if found == expected { Ok(body) } else { Err(LineError::Checksum { found, expected }) }
}

fn identity(fields: &[&str]) -> Option<Identity> {
    let [version, nonce, name, timeout, field_of_view, min_range, max_range] = fields else {
        return None;
    };
    Some(Identity {
        version: version.parse().ok()?,
        nonce: nonce.parse().ok()?,
        name: (*name).to_owned(),
        timeout_ms: timeout.parse().ok()?,
        field_of_view_mrad: field_of_view.parse().ok()?,
        min_range_mm: min_range.parse().ok()?,
        max_range_mm: max_range.parse().ok()?,
    })
}

fn state(fields: &[&str]) -> Option<State> {
    let [time, sequence, speed, turn_rate, mode, seen, range, battery, further @ ..] = fields
    else {
        return None;
    };
    let setpoint =
        Setpoint { speed_mm_s: speed.parse().ok()?, turn_rate_mrad_s: turn_rate.parse().ok()? };
    Some(State {
        time_ms: time.parse().ok()?,
        sequence: optional(sequence, |text| text.parse().ok())?,
        setpoint,
        mode: match *mode {
            "N" => Mode::Fresh,
            "R" => Mode::Driving,
            "T" => Mode::TimedOut,
            "F" => Mode::Fault,
            _ => return None,
        },
        seen: optional(seen, binary)?,
        range: optional(range, |text| match text {
            "i" => Some(RangeReading::Nothing),
            "x" => Some(RangeReading::Failed),
            distance => distance.parse().ok().map(RangeReading::Distance),
        })?,
        battery_mv: optional(battery, |text| text.parse().ok())?,
        further: further.iter().map(|text| further_reading(text)).collect::<Option<_>>()?,
    })
}

fn binary(text: &str) -> Option<bool> {
    match text {
        "0" => Some(false),
        "1" => Some(true),
        _ => None,
    }
}

/// A further reading, `NAME=0` or `NAME=1`; its name is a part of a topic's.
fn further_reading(text: &str) -> Option<(String, bool)> {
    let (name, value) = text.split_once('=')?;
    is_name(name).then_some(())?;
    Some((name.to_owned(), binary(value)?))
}

/// A field that may be `-` for none; the outer `None` is a field that means nothing.
#[expect(clippy::option_option, reason = "absent and wrong are two things")]
fn optional<T>(text: &str, parse: impl FnOnce(&str) -> Option<T>) -> Option<Option<T>> {
    if text == "-" { Some(None) } else { parse(text).map(Some) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_the_documentation_are_right() {
        let documentation = include_str!("../../../../../docs/serial_protocol.md");
        let setpoint = Setpoint { speed_mm_s: 150, turn_rate_mrad_s: -750 };
        let lines = [
            ToDevice::Hello { nonce: 7 }.encode(),
            ToDevice::Drive { sequence: 42, time_ms: 81250, setpoint }.encode(),
            encode("I,1,7,rsrs_base,250,400,20,750"),
            encode("S,81300,42,150,-750,R,-,312,7400"),
            encode("S,81350,42,150,-750,R,0,-,7400,wall=1,object=0"),
        ];

        for line in lines {
            assert!(documentation.contains(line.trim_end()), "{line} is not in the documentation");
        }
    }

    #[test]
    fn a_state_is_read_field_by_field() {
        let line = encode("S,81300,42,150,-750,R,1,312,-");

        let state = State {
            time_ms: 81300,
            sequence: Some(42),
            setpoint: Setpoint { speed_mm_s: 150, turn_rate_mrad_s: -750 },
            mode: Mode::Driving,
            seen: Some(true),
            range: Some(RangeReading::Distance(312)),
            battery_mv: None,
            further: Vec::new(),
        };
        let found = FromDevice::decode(line.trim_end().as_bytes());
        assert_eq!(found, Ok(FromDevice::State(state.clone())));

        let line = encode("S,81300,42,150,-750,R,1,312,-,wall=0,object_2=1");
        let further = vec![("wall".to_owned(), false), ("object_2".to_owned(), true)];
        let state = FromDevice::State(State { further, ..state });
        assert_eq!(FromDevice::decode(line.trim_end().as_bytes()), Ok(state));
    }

    #[test]
    fn one_changed_character_makes_a_line_worthless() {
        let line = encode("S,81300,42,150,-750,R,1,312,-");
        let line = line.trim_end().as_bytes();

        for place in 0..line.len() {
            for damage in [1, 2, 16, 128] {
                let mut damaged = line.to_vec();
                damaged[place] ^= damage;
                let is_the_same = damaged.eq_ignore_ascii_case(line);
                assert!(is_the_same || FromDevice::decode(&damaged).is_err(), "{damaged:?}");
            }
        }
    }

    #[test]
    fn whole_lines_that_the_protocol_does_not_have_are_refused() {
        for body in
            ["", "S", "S,1,2,3,R,-,-,-", "S,0,1,2,3,Q,-,-,-", "S,0,1,2,3,R,2,-,-", "X,1", "I,1"]
        {
            let error = FromDevice::decode(encode(body).trim_end().as_bytes()).unwrap_err();

            assert_eq!(error, LineError::Body { body: body.to_owned() });
        }
    }

    #[test]
    fn a_further_reading_of_another_form_is_named() {
        for wrong in ["", "wall", "wall=2", "Wall=1", "a/b=1"] {
            let body = format!("S,0,1,2,3,R,1,-,-,object=1,{wrong}");

            let error = FromDevice::decode(encode(&body).trim_end().as_bytes()).unwrap_err();

            assert_eq!(error, LineError::Reading { found: wrong.to_owned() });
        }
    }

    #[test]
    fn commands_are_rounded_to_thousandths() {
        let command = Command { speed_m_s: 0.1504, turn_rate_rad_s: -0.7496 };

        let setpoint = Setpoint { speed_mm_s: 150, turn_rate_mrad_s: -750 };
        assert_eq!(Setpoint::new(command), setpoint);
    }
}
