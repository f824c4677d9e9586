//! What a command line, a launch file and the environment set for a node, as in every ROS 2 program.
//!
//! `--ros-args -r __ns:=/robot_3 -r cmd_vel:=/base/cmd_vel -p speed:=0.15 --params-file x.yaml
//! --log-level debug --disable-rosout-logs --`, and `ROS_DOMAIN_ID`,
//! `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_LOCALHOST_ONLY` and `ROS_SECURITY_*`. What cannot be honoured is an error,
//! or a [`Note`] where ROS 2 programs usually run without it.

mod discovery;
mod error;
mod overrides;
mod remap;
mod yaml;

use std::collections::BTreeMap;
use std::path::Path;

use crate::environment::Environment;
use crate::logging::{self, Level};
use crate::parameter_value::ParameterValue;

pub(crate) use discovery::USUAL_KEYSTORE;
pub use discovery::{Note, OtherMiddleware};
pub use error::RosArgsError;
use overrides::Overrides;
use remap::Remaps;
pub use remap::TopicRules;

/// Starts the arguments that are meant for ROS 2; a second start among them is allowed there, too.
const START: &str = "--ros-args";

/// Flags with a value that ROS 2 programs take and that mean nothing here.
const WITHOUT_EFFECT: [(&str, &str); 2] = [
    ("--log-config-file", "log lines go to standard error and /rosout; set `--log-level`"),
    ("--log-file-name", "log lines go to standard error and /rosout"),
];

/// The ROS arguments of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct RosArgs {
    /// `ROS_DOMAIN_ID`; 0 to 232.
    pub domain_id: u16,
    /// What a user may not expect, to be logged.
    pub notes: Vec<Note>,
    /// Whether log lines go to `/rosout`, too.
    pub to_rosout: bool,
    /// Whether log lines go to standard error.
    to_stderr: bool,
    /// The variable that keeps this program on this machine.
    pub(crate) localhost: Option<&'static str>,
    /// The name of the enclave, if one is given.
    pub(crate) enclave: Option<String>,
    remaps: Remaps,
    overrides: Overrides,
    log_levels: Vec<(Option<String>, Level)>,
}

impl RosArgs {
    /// Understands what stands between `--ros-args` and `--` on a command line, and the environment.
    pub fn parse(arguments: &[String], environment: &Environment) -> Result<Self, RosArgsError> {
        environment.check()?;
        let discovery = discovery::read(environment)?;
        let mut parsed = Self {
            domain_id: discovery.domain_id,
            localhost: discovery.localhost,
            notes: discovery.notes,
            to_rosout: true,
            to_stderr: true,
            enclave: None,
            remaps: Remaps::default(),
            overrides: Overrides::default(),
            log_levels: Vec::new(),
        };
        let mut arguments = arguments.iter().filter(|argument| *argument != START);
        while let Some(flag) = arguments.next() {
            if !parsed.take_switch(flag) {
                parsed.take_flag(flag, arguments.next(), environment)?;
            }
        }
        Ok(parsed)
    }

    /// Takes a flag that has no value; `false` if it is none.
    fn take_switch(&mut self, flag: &str) -> bool {
        match flag {
            "--enable-rosout-logs" => self.to_rosout = true,
            "--disable-rosout-logs" => self.to_rosout = false,
            "--enable-stdout-logs" => self.to_stderr = true,
            "--disable-stdout-logs" => self.to_stderr = false,
            // Files of a logging library, of which this program writes none.
            "--enable-external-lib-logs" | "--disable-external-lib-logs" => {}
            _ => return false,
        }
        true
    }

    fn take_flag(
        &mut self,
        flag: &str,
        value: Option<&String>,
        environment: &Environment,
    ) -> Result<(), RosArgsError> {
        let known =
            ["-r", "--remap", "-p", "--param", "--params-file", "--log-level", "-e", "--enclave"];
        let without_effect = WITHOUT_EFFECT.iter().find(|(known, _)| *known == flag);
        if !known.contains(&flag) && without_effect.is_none() {
            return Err(RosArgsError::UnknownFlag { flag: flag.to_owned() });
        }
        let missing = || RosArgsError::MissingValue { flag: flag.to_owned() };
        // What begins with a dash is the next flag: of a launch file's empty substitution nothing is left.
        let value = value.filter(|value| !value.starts_with('-')).ok_or_else(missing)?;
        if let Some((flag, reason)) = without_effect {
            self.notes.push(Note::WithoutEffect { flag: format!("{flag} {value}"), reason });
            return Ok(());
        }
        match flag {
            "-r" | "--remap" => self.remaps.take(value),
            "-p" | "--param" => self.overrides.take(value),
            "--params-file" => self.overrides.take_file(Path::new(value), environment.read_file),
            "-e" | "--enclave" => {
                self.enclave = Some(value.clone());
                Ok(())
            }
            _ => self.take_log_level(value),
        }
    }

    fn take_log_level(&mut self, value: &str) -> Result<(), RosArgsError> {
        let (logger, level) = match value.split_once(":=") {
            Some((logger, level)) => (Some(logger.to_owned()), level),
            None => (None, value),
        };
        let level = level.parse().map_err(|source| RosArgsError::Level { source })?;
        self.log_levels.push((logger, level));
        Ok(())
    }

    /// Sends log lines where they are wanted, from `level` on; information and worse if none is
    /// given.
    pub fn start_logging(&self, level: Option<Level>) {
        if self.to_stderr {
            let level = level.unwrap_or(Level::Info);
            logging::init(level);
        }
    }

    /// Logs what a user may not expect, for a program without a node.
    pub fn log_notes(&self, node: &str) {
        for note in &self.notes {
            log::log!(note.level().as_log(), "[{node}] {note}");
        }
    }

    /// Refuses rules that a program would have to ignore: for a name of one of its `nodes`, by
    /// which others find it, and for a topic, where its topics cannot have other names.
    pub fn check_rules(&self, nodes: &[&str], topics: TopicRules) -> Result<(), RosArgsError> {
        self.remaps.check(nodes, topics)
    }

    /// Namespace and name of a node, after `__ns` and `__node` have replaced the given ones.
    pub fn node(&self, namespace: &str, name: &str) -> (String, String) {
        self.remaps.node(namespace, name)
    }

    /// The full name, after remapping, of a topic that is relative (`cmd_vel`), private
    /// (`~/status`) or absolute (`/clock`). Namespace and name of the node are as [`RosArgs::node`]
    /// returned them.
    pub fn topic(&self, node: (&str, &str), topic: &str) -> String {
        self.remaps.topic(node, topic)
    }

    /// The values that parameters of a node, such as `/robot_3/controller`, were given; the last
    /// one counts.
    pub fn parameters(&self, node: &str) -> BTreeMap<String, ParameterValue> {
        self.overrides.of(node)
    }

    /// Severity from which on a logger, such as `robot_3.controller`, is to log; `None` if none is
    /// given.
    pub fn log_level(&self, logger: &str) -> Option<Level> {
        let last = |wanted: Option<&str>| {
            let mut levels = self.log_levels.iter().rev();
            levels.find(|(name, _)| name.as_deref() == wanted).map(|(_, level)| *level)
        };
        last(Some(logger)).or_else(|| last(None))
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use rsrs_core::help::Help;

    use super::*;

    fn parse(line: &str) -> Result<RosArgs, RosArgsError> {
        let arguments: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let environment = Environment::new(&[], |path| match path.to_str() {
            Some("fleet.yaml") => Ok("/**: {ros__parameters: {speed: 0.2}}".to_owned()),
            _ => Err(io::Error::from(io::ErrorKind::NotFound)),
        });
        RosArgs::parse(&arguments, &environment)
    }

    #[test]
    fn a_second_start_is_none() {
        let args = parse("-r __ns:=/robot_3 --ros-args -p speed:=0.1").unwrap();

        assert_eq!(args.node("/", "controller"), ("/robot_3".into(), "controller".into()));
        assert_eq!(args.parameters("/a")["speed"], ParameterValue::Double(0.1));
    }

    #[test]
    fn what_cannot_be_understood_is_named() {
        let unknown = parse("--use-sim-time").unwrap_err();
        assert_eq!(unknown.to_string(), "unknown flag `--use-sim-time` after --ros-args");
        assert!(unknown.help().is_some());
        let missing = parse("--params-file missing.yaml").unwrap_err();
        assert_eq!(missing.to_string(), "parameter file `missing.yaml` cannot be read");
        for line in [
            "-r",
            "--disable-rosout-logs --params-file",
            "--params-file -r __ns:=/robot_3",
            "-e --disable-rosout-logs",
            "-e --ros-args -p speed:=0.1",
        ] {
            let error = parse(line).unwrap_err();
            assert!(matches!(error, RosArgsError::MissingValue { .. }), "{line}: {error}");
        }
    }

    #[test]
    fn what_launch_passes_along_is_understood_or_named() {
        let line = "--enclave /robot -e /other --log-config-file log.yaml \
            --disable-rosout-logs --disable-external-lib-logs --disable-stdout-logs \
            --enable-stdout-logs";

        let args = parse(line).unwrap();

        assert!(!args.to_rosout && args.to_stderr);
        assert_eq!(args.enclave.as_deref(), Some("/other"));
        let notes: Vec<String> = args.notes.iter().map(ToString::to_string).collect();
        assert_eq!(
            notes,
            ["`--log-config-file log.yaml` has no effect: log lines go to standard error and \
              /rosout; set `--log-level`"]
        );
    }

    #[test]
    fn the_last_parameter_counts_whether_from_a_file_or_not() {
        let file_last = parse("-p speed:=0.1 --params-file fleet.yaml").unwrap();
        let flag_last = parse("--params-file fleet.yaml -p speed:=0.1").unwrap();

        assert_eq!(file_last.parameters("/a")["speed"], ParameterValue::Double(0.2));
        assert_eq!(flag_last.parameters("/a")["speed"], ParameterValue::Double(0.1));
    }

    #[test]
    fn a_level_of_one_logger_goes_before_that_of_all() {
        let line = "--log-level warn --log-level robot_3.controller:=debug";
        let args = parse(line).unwrap();

        assert_eq!(args.log_level("robot_3.controller"), Some(Level::Debug));
        assert_eq!(args.log_level("robot_4.controller"), Some(Level::Warn));
        assert_eq!(parse("").unwrap().log_level("any"), None);
        assert!(matches!(parse("--log-level loud"), Err(RosArgsError::Level { .. })));
    }
}
