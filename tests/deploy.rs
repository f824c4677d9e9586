//! What a laboratory installs: the package, its ROS 2 prefix, launch files, the unit, the playbook.

use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::command::bring;
use crate::processes::{Process, rsrs};
use rsrs_keystore::check::problems_of;
use rsrs_keystore::create::{KeystoreRequest, create};
use rsrs_ros::confine;
use rsrs_testing::python::{DEPLOYMENT, must_run, python_with};
use serde::Deserialize;
use serde_json::Value;

const EXECUTABLES: [&str; 4] = ["controller_node", "experiment_runner", "robot_node", "sim_node"];

/// The root of the repository.
fn house() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What is written of the Debian package.
fn package() -> Value {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--no-deps", "--format-version=1", "--offline"]).current_dir(house());
    let metadata: Value = serde_json::from_str(&must_run(&mut cargo)).expect("cargo writes JSON");
    let packages = metadata["packages"].as_array().expect("a workspace has packages");
    let package = packages.iter().find(|package| package["name"] == "rsrs").expect("it is ours");
    package["metadata"]["deb"].clone()
}

/// The files of the package that stay as somebody has changed them.
fn conf_files() -> Vec<String> {
    serde_json::from_value(package()["conf-files"].clone()).expect("a list of texts")
}

/// Lays the files of the Debian package out below a folder, with the program under test in it.
fn install(root: &Path) {
    let package = package();
    for asset in package["assets"].as_array().expect("it has assets") {
        let part = |index: usize| asset[index].as_str().expect("three texts");
        let mode = u32::from_str_radix(part(2), 8).expect("an octal mode");
        let sources = sources(part(0));
        assert!(!sources.is_empty(), "nothing is at {}", part(0));
        for source in sources {
            let mut place = root.join(part(1));
            if part(1).ends_with('/') {
                place.push(source.file_name().expect("a file has a name"));
            }
            fs::create_dir_all(place.parent().expect("it has a folder")).expect("writable");
            // No link: `tar` refuses a file whose links come and go, as those of other tests would.
            fs::copy(&source, &place).expect("it is there and writable");
            fs::set_permissions(&place, fs::Permissions::from_mode(mode)).expect("ours");
        }
    }
}

/// The files that an asset names: one, or by `*` in the name some of a folder.
fn sources(pattern: &str) -> Vec<PathBuf> {
    if pattern == "target/release/rsrs" {
        return vec![PathBuf::from(env!("CARGO_BIN_EXE_rsrs"))];
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(pattern);
    let name = path.file_name().and_then(|name| name.to_str()).expect("a pattern has a name");
    let Some((prefix, suffix)) = name.split_once('*') else {
        return if path.exists() { vec![path] } else { Vec::new() };
    };
    let folder = fs::read_dir(path.parent().expect("a folder")).expect("the folder is there");
    let paths = folder.map(|entry| entry.expect("readable").path()).filter(|path| path.is_file());
    let is_meant = |path: &PathBuf| {
        path.file_name()
            .and_then(|name| name.to_str())
            .is_some_and(|name| name.starts_with(prefix) && name.ends_with(suffix))
    };
    paths.filter(is_meant).collect()
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("the target folder is writable")
}

#[test]
fn the_package_is_a_prefix_in_which_ros_finds_the_nodes() {
    let root = folder();
    install(root.path());
    let prefix = root.path().join("usr");
    let setup = prefix.join("share/rsrs/local_setup.bash");
    let mut shell = Command::new("bash");
    shell.env("AMENT_PREFIX_PATH", "/opt/ros/jazzy").arg("-c");
    // Sourced twice, as shells' start files do, it is named once.
    let script = "source \"$0\" && source \"$0\" && printf %s \"$AMENT_PREFIX_PATH\"";
    let path = must_run(shell.arg(script).arg(&setup));
    assert_eq!(path, format!("{}:/opt/ros/jazzy", prefix.display()));

    let python = python_with(&DEPLOYMENT);
    let ask = "from ament_index_python.packages import *\n\
               print(get_package_prefix('rsrs'), get_package_share_directory('rsrs'))";
    let found = must_run(Command::new(python).env("AMENT_PREFIX_PATH", &path).args(["-c", ask]));
    let share = prefix.join("share/rsrs");
    assert_eq!(found.trim(), format!("{} {}", prefix.display(), share.display()));

    let msgs = prefix.join("share/rsrs_msgs");
    let index = prefix.join("share/ament_index/resource_index");
    assert!(index.join("packages/rsrs_msgs").exists() && msgs.join("package.xml").exists());
    let listed = fs::read_to_string(index.join("rosidl_interfaces/rsrs_msgs")).expect("text");
    let mut files: Vec<String> = fs::read_dir(msgs.join("msg"))
        .expect("the types are there")
        .map(|entry| format!("msg/{}", entry.expect("readable").file_name().display()))
        .collect();
    files.sort();
    assert_eq!(listed.lines().collect::<Vec<_>>(), files, "what `ros2 interface list` finds");
    for viewer in ["swarm.rviz", "swarm.foxglove.json"] {
        assert!(share.join("config/viewers").join(viewer).exists(), "{viewer}");
    }

    let mut executables: Vec<String> = fs::read_dir(prefix.join("lib/rsrs"))
        .expect("the folder in which ROS looks for executables")
        .map(|entry| entry.expect("readable").file_name().into_string().expect("text"))
        .collect();
    executables.sort();
    assert_eq!(executables, EXECUTABLES);
    for executable in EXECUTABLES {
        let help = must_run(Command::new(prefix.join("lib/rsrs").join(executable)).arg("--help"));
        assert!(help.contains("Usage: rsrs node "), "{help}");
    }
}

#[test]
fn what_the_package_has_in_etc_stays_as_somebody_has_changed_it() {
    let root = folder();
    install(root.path());
    let mut folders = vec![root.path().join("etc")];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("it was laid out") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let below = path.strip_prefix(root.path()).expect("it is in it");
                found.push(format!("/{}", below.display()));
            }
        }
    }
    let mut conf_files = conf_files();

    found.sort();
    conf_files.sort();
    assert_eq!(found, conf_files);
}

/// A node that a launch file starts.
#[derive(Deserialize)]
struct Launched {
    executable: String,
    namespace: Option<String>,
    arguments: Vec<String>,
    /// How long after the launch it is started, in seconds.
    delay_s: f64,
}

fn launched(file: &str, given: &[String]) -> Vec<Launched> {
    launched_where(file, given, "false")
}

/// As [`launched`], with `ROS_SECURITY_ENABLE`.
fn launched_where(file: &str, given: &[String], is_secured: &str) -> Vec<Launched> {
    let python = python_with(&DEPLOYMENT);
    let script = house().join("tests/deploy/launch.py");
    let path = house().join("launch_configs/launch").join(file);
    let text = must_run(
        Command::new(python)
            .arg(script)
            .arg(path)
            .args(given)
            .env("ROS_SECURITY_ENABLE", is_secured),
    );
    serde_json::from_str(&text).expect("the script writes JSON")
}

/// Starts what a launch file starts, as `launch_ros` does, and waits until each node is ready.
fn start_all(root: &Path, nodes: &[Launched]) {
    for node in nodes {
        let mut command = Command::new(root.join("usr/lib/rsrs").join(&node.executable));
        command.args(&node.arguments).arg("--ros-args").env("ROS_DOMAIN_ID", "42");
        if let Some(namespace) = &node.namespace {
            command.args(["-r", &format!("__ns:=/{namespace}")]);
        }
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut process =
            Process(confine::start_in_own_network(&mut command).spawn().expect("it is installed"));
        let errors = process.0.stderr.take().expect("it is piped");
        let mut lines = BufReader::new(errors).lines().map(|line| line.expect("text"));
        let ready = lines.find(|line| line.contains("ready"));
        assert!(ready.is_some(), "{} ended instead of getting ready", node.executable);
    }
}

#[test]
fn launch_files_start_nodes_that_are_there() {
    let root = folder();
    install(root.path());
    let argument = |name: &str, value: &Path| format!("{name}:={}", value.display());

    let swarm = launched("simulated_swarm.launch.xml", &["robots:=robot_1,robot_2".to_owned()]);
    assert_eq!(swarm.len(), 2);
    start_all(root.path(), &swarm);

    let fleet = house().join("launch_configs/fleets/nine_virtual.yaml");
    let given =
        ["robot:=robot_3".to_owned(), "interface:=lo".to_owned(), argument("fleet", &fleet)];
    let robot = launched("robot.launch.xml", &given);
    assert_eq!(robot[0].namespace.as_deref(), Some("robot_3"));
    start_all(root.path(), &robot);

    let experiment = house().join("launch_configs/experiments/flockbot_milling.yaml");
    let experiment = argument("experiment", &experiment);
    let simulated = launched("experiment.launch.py", &[experiment.clone(), "backend:=sim".into()]);
    let names: Vec<&str> = simulated.iter().map(|node| node.executable.as_str()).collect();
    assert_eq!(names, ["sim_node", "controller_node", "experiment_runner"]);
    let robots = "robot_1,robot_2,robot_3,robot_4,robot_5,robot_6,robot_7,robot_8,robot_9";
    assert!(simulated[0].arguments.iter().any(|argument| argument == robots));
    assert!(simulated.iter().all(|node| node.delay_s == 0.0));
    start_all(root.path(), &simulated[..2]);

    let given = [experiment.clone(), "backend:=sim".into()];
    let secured = launched_where("experiment.launch.py", &given, "true");
    let apart: Vec<_> = secured.iter().map(|node| (&*node.executable, node.delay_s)).collect();
    assert_eq!(apart, [("sim_node", 0.0), ("controller_node", 2.0), ("experiment_runner", 4.0)]);

    let real = launched("experiment.launch.py", &[experiment, "interface:=wlan0".into()]);
    assert_eq!(real.len(), 1);
    assert!(real[0].arguments.join(" ").starts_with("--interface wlan0 --experiment /"));
}

#[test]
fn the_service_manager_takes_the_unit() {
    let folder = folder();
    let name = "rsrs-robot@.service";
    let unit = house().join("deploy/systemd").join(name);
    let text = fs::read_to_string(unit).expect("the unit is shipped");
    // It looks for the program, which is not installed here.
    let here = folder.path().join(name);
    let installed = [
        ("/usr/bin/rsrs", PathBuf::from(env!("CARGO_BIN_EXE_rsrs"))),
        ("/usr/libexec/rsrs", house().join("deploy/network")),
    ];
    let found = installed.iter().fold(text.clone(), |text, (path, here)| {
        text.replace(path, here.to_str().expect("a path of ours is text"))
    });
    fs::write(&here, found).expect("writable");

    let output = Command::new("systemd-analyze").args(["verify", "--man=no"]).arg(&here).output();

    let output = output.expect("this test needs systemd-analyze, of the package systemd");
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !complaints.contains(name), "{complaints}");
    let score = Command::new("systemd-analyze")
        .args(["security", "--offline=true", "--no-pager", "--threshold=17"])
        .arg(&here)
        .output()
        .expect("it was there a moment ago");
    let open = String::from_utf8_lossy(&score.stdout);
    assert!(score.status.success(), "it leaves more open than 1.7:\n{open}");
    // What the unit starts is understood: the node gets as far as its fleet file.
    let line = text.lines().find_map(|line| line.strip_prefix("ExecStart=/usr/bin/rsrs "));
    let arguments = line.expect("it starts the program").replace("%I", "robot_1");
    let mut robot = rsrs();
    robot.args(arguments.split(' ')).env("RSRS_INTERFACE", "127.0.0.1");
    let output = confine::start_in_own_network(&mut robot).output().expect("built for this test");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("/etc/rsrs/fleets/fleet.yaml"), "{error}");
}

/// Builds `rsrs.deb` of the folder `package` beside it.
fn build_package(folder: &Path, version: &str) {
    let control = format!(
        "Package: rsrs\nVersion: {version}\nArchitecture: all\n\
         Maintainer: nobody <nobody@example.org>\nDescription: for a test\n"
    );
    fs::write(folder.join("package/DEBIAN/control"), control).expect("writable");
    let build = ["--root-owner-group", "-Znone", "--build", "package", "rsrs.deb"];
    must_run(Command::new("dpkg-deb").args(build).current_dir(folder));
}

/// A laboratory of two robots and a recorder, all of them this machine, each below a folder.
struct TestBed {
    folder: tempfile::TempDir,
    python: PathBuf,
}

impl TestBed {
    fn new() -> Self {
        let folder = folder();
        let python = python_with(&DEPLOYMENT);
        let path = |name: &str| folder.path().join(name);
        install(&path("package"));
        fs::create_dir(path("package/DEBIAN")).expect("writable");
        let conf_files = conf_files().join("\n") + "\n";
        fs::write(path("package/DEBIAN/conffiles"), conf_files).expect("writable");
        for script in ["postinst", "prerm", "postrm"] {
            let ours = house().join("deploy/debian").join(script);
            fs::copy(ours, path("package/DEBIAN").join(script)).expect("it is shipped");
        }
        build_package(folder.path(), "0.1.0");
        for robot in ["robot_1", "robot_2"] {
            for part in ["var/cache", "var/lib/dpkg/info", "var/lib/dpkg/updates"] {
                fs::create_dir_all(path(robot).join(part)).expect("writable");
            }
            fs::write(path(robot).join("var/lib/dpkg/status"), "").expect("writable");
        }
        for folder in ["configs/fleets", "configs/profiles", "results/run_1"] {
            fs::create_dir_all(path(folder)).expect("writable");
        }
        for file in ["fleets/nine_flockbots.yaml", "profiles/flockbot.yaml"] {
            bring(file, &path("configs").join(file));
        }
        fs::write(path("results/run_1/run_1_0.mcap"), "a bag").expect("writable");
        fs::write(path("notes"), "").expect("writable");
        let laboratory = Self { folder, python };
        laboratory.write_inventory();
        laboratory
    }

    fn write_inventory(&self) {
        let here = self.folder.path().display();
        let python = self.python.display();
        let inventory = format!(
            "all:\n  vars: {{ansible_connection: local, ansible_python_interpreter: {python}, \
             rsrs_collected: {here}/collected}}\n\
             robots:\n  hosts: {{one: {{robot: robot_1}}, two: {{robot: robot_2}}}}\n  vars:\n    \
             rsrs_root: \"{here}/{{{{ robot }}}}\"\n    \
             rsrs_dpkg_options: [\"--root={here}/{{{{ robot }}}}\", --force-not-root, \
             --force-script-chrootless]\n    \
             rsrs_package: {here}/rsrs.deb\n    rsrs_configs: {here}/configs\n    \
             rsrs_fleet: nine_flockbots.yaml\n    rsrs_interface: wlan0\n    ros_domain_id: 7\n\
             recorders:\n  hosts: {{three: {{}}}}\n  vars: {{rsrs_bags: {here}/results}}\n"
        );
        fs::write(self.folder.path().join("inventory.yaml"), inventory).expect("writable");
    }

    /// Runs the playbook with these tags, and what else is given on its line: whether it succeeded, and what it
    /// printed.
    fn play(&self, tags: &str, offset_s: &str) -> (bool, String) {
        let tools = house().join("tests/deploy");
        let path = std::env::var("PATH").expect("there is a PATH");
        let output = Command::new(self.python.with_file_name("ansible-playbook"))
            .arg("--inventory=inventory.yaml")
            .arg(house().join("deploy/ansible/fleet.yaml"))
            .arg("--tags")
            .args(tags.split(' '))
            .current_dir(self.folder.path())
            .env("PATH", format!("{}:{path}", tools.display()))
            .env("RSRS_TEST_OFFSET_S", offset_s)
            .env("RSRS_TEST_NOTES", self.folder.path().join("notes"))
            .env("LC_ALL", "C.UTF-8")
            .output()
            .expect("it was installed for this test");
        let errors = String::from_utf8_lossy(&output.stderr);
        let printed = format!("{}\n{errors}", String::from_utf8_lossy(&output.stdout));
        (output.status.success(), printed)
    }

    fn must_play(&self, tags: &str) {
        let (has_succeeded, printed) = self.play(tags, "-0.000012");
        assert!(has_succeeded, "{printed}");
    }

    fn read(&self, name: &str) -> String {
        let path = self.folder.path().join(name);
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }
}

#[test]
fn the_playbook_brings_each_secured_robot_its_own_enclave_and_no_other() {
    let laboratory = TestBed::new();
    let here = laboratory.folder.path();
    let robots = ["robot_1", "robot_2"].map(str::to_owned);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970");
    create(&KeystoreRequest {
        folder: &here.join("keystore"),
        robots: &robots,
        domain_id: Some(7),
        now,
        validity: Some(Duration::from_secs(24 * 3600)),
        readmitted: &[],
    })
    .expect("writable");
    let inventory = laboratory.read("inventory.yaml");
    let secured = inventory.replace(
        "ros_domain_id: 7",
        &format!("ros_domain_id: 7\n    rsrs_keystore: {}/keystore", here.display()),
    );
    fs::write(here.join("inventory.yaml"), &secured).expect("writable");

    laboratory.must_play("configure");

    for (index, robot) in robots.iter().enumerate() {
        let environment = laboratory.read(&format!("{robot}/etc/rsrs/robot.env"));
        let expected = format!(
            "ROS_DOMAIN_ID=7\nROS_SECURITY_ENABLE=true\nROS_SECURITY_STRATEGY=Enforce\n\
             ROS_SECURITY_KEYSTORE=/etc/rsrs/keystore\nRSRS_START_DELAY_S={index}\n"
        );
        assert!(environment.ends_with(&expected), "{environment}");
        let enclaves = here.join(robot).join("etc/rsrs/keystore/enclaves");
        let brought: Vec<_> = fs::read_dir(&enclaves).expect("it is there").collect();
        assert_eq!(brought.len(), 1, "{brought:?}");
        assert_eq!(problems_of(&format!("/{robot}"), &enclaves.join(robot), 7, now), []);
    }

    // The inventory of somebody who does not know of the keystore.
    let before = laboratory.read("robot_1/etc/rsrs/robot.env");
    fs::write(here.join("inventory.yaml"), &inventory).expect("writable");
    let (has_succeeded, printed) = laboratory.play("configure --limit one", "-0.000012");
    assert!(!has_succeeded && printed.contains("one has a keystore"), "{printed}");
    // And of somebody who has given the robot another name since.
    let renamed = inventory
        .replace("{robot: robot_1}", "{robot: robot_9}")
        .replace("{{ robot }}", "{{ robot | replace('9', '1') }}");
    fs::write(here.join("inventory.yaml"), renamed).expect("writable");
    let (has_succeeded, printed) = laboratory.play("configure --limit one", "-0.000012");
    assert!(!has_succeeded && printed.contains("one has a keystore"), "{printed}");
    assert_eq!(laboratory.read("robot_1/etc/rsrs/robot.env"), before);
    let insisting = "ros_domain_id: 7\n    rsrs_insecure: true";
    let insisting = inventory.replace("ros_domain_id: 7", insisting);
    fs::write(here.join("inventory.yaml"), insisting).expect("writable");
    laboratory.must_play("configure --limit one");
    assert!(!laboratory.read("robot_1/etc/rsrs/robot.env").contains("SECURITY"));
}

#[test]
fn the_playbook_brings_a_fleet_to_the_floor_and_back() {
    let laboratory = TestBed::new();

    laboratory.must_play("install,configure,start,clock");
    for robot in ["robot_1", "robot_2"] {
        let program = laboratory.folder.path().join(robot).join("usr/bin/rsrs");
        assert!(fs::metadata(program).expect("installed").permissions().mode() & 0o111 != 0);
        let environment = laboratory.read(&format!("{robot}/etc/rsrs/robot.env"));
        assert!(environment.ends_with("RSRS_INTERFACE=wlan0\nROS_DOMAIN_ID=7\n"), "{environment}");
        // The fleet file finds its profiles where they were put.
        let fleet = laboratory.folder.path().join(robot).join("etc/rsrs/fleets/fleet.yaml");
        let given = ["node", "robot", "--robots", robot, "--interface", "127.0.0.1", "--port"];
        let mut node = rsrs();
        node.args(given).arg("/dev/none").arg("--config").arg(fleet);
        let mut process = Process::start(confine::start_in_own_network(&mut node));
        let errors = BufReader::new(process.0.stderr.take().expect("it is piped"));
        let mut lines = errors.lines().map(|line| line.expect("text"));
        assert!(lines.any(|line| line.contains("/dev/none")), "it does not look for its wheels");
    }

    // A newer package with another `robot.env` asks nothing, and leaves that of the fleet.
    let shipped = laboratory.folder.path().join("package/etc/rsrs/robot.env");
    fs::write(shipped, "RSRS_INTERFACE=eth9\n").expect("writable");
    build_package(laboratory.folder.path(), "0.2.0");
    laboratory.must_play("install --limit one");
    let environment = laboratory.read("robot_1/etc/rsrs/robot.env");
    assert!(environment.ends_with("RSRS_INTERFACE=wlan0\nROS_DOMAIN_ID=7\n"), "{environment}");
    assert!(laboratory.read("robot_1/var/lib/dpkg/status").contains("Version: 0.2.0"));

    let (has_succeeded, printed) = laboratory.play("clock --limit two", "0.5");
    assert!(!has_succeeded);
    assert!(printed.contains("off by 0.5 s, expected at most 0.02 s"), "{printed}");

    laboratory.must_play("stop,collect");
    let notes = laboratory.read("notes");
    for robot in ["robot_1", "robot_2"] {
        for order in ["enable", "start", "stop"] {
            let wanted = format!("{order} rsrs-robot@{robot}.service");
            assert!(notes.lines().any(|line| line == wanted), "no `{wanted}` in:\n{notes}");
        }
    }

    let log = laboratory.read("collected/robot_2.log");
    assert_eq!(log, "journal of rsrs-robot@robot_2.service\n");
    let results = laboratory.folder.path().join("results/run_1/run_1_0.mcap");
    let bag = format!("collected/bags/three{}", results.display());
    assert_eq!(laboratory.read(&bag), "a bag");
}
