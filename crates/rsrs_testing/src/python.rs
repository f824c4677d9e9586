//! Cached Python environments, for tests that use other implementations: all that there are.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a Python environment holds. Few hold much: each is hundreds of megabytes of what the others
/// have, too.
pub struct Environment<'a> {
    /// The name of its folder.
    pub name: &'a str,
    /// Exact requirements, installed with what they depend on.
    pub packages: &'a [&'a str],
    /// Exact requirements of packages whose files alone matter.
    pub files_only: &'a [&'a str],
}

/// Other people's readers of bags and messages.
pub const BAGS: Environment = Environment {
    name: "bags",
    packages: &["mcap-ros2-support==0.6.0", "rosbags==0.11.9"],
    files_only: &["ros-rcl-interfaces==2.0.3"],
};

/// Another implementation of DDS.
pub const CYCLONE: Environment =
    Environment { name: "cyclone", packages: &["cyclonedds==11.0.1"], files_only: &[] };

/// Statistics, optimisation, tables and notebooks.
pub const SCIENCE: Environment = Environment {
    name: "science",
    packages: &[
        "cma==4.*",
        "ipykernel==7.*",
        "matplotlib==3.*",
        "mcap-ros2-support==0.6.0",
        "mcap==1.*",
        "nbclient==0.10.*",
        "numpy==2.*",
        "polars==1.*",
        "pyarrow==26.0.1",
        "scipy==1.17.*",
        "statsmodels==0.14.*",
    ],
    files_only: &[],
};

/// What installs robots, finds packages and checks files.
pub const DEPLOYMENT: Environment = Environment {
    name: "deployment",
    packages: &[
        "ansible-core>=2.15,<2.20",
        "jsonschema==4.*",
        "pyyaml==6.*",
        "ros-jazzy-ament-index-python==1.8.1",
    ],
    files_only: &[],
};

/// rclpy of ROS 2 Jazzy over Fast DDS, with common messages.
pub const JAZZY: Environment = Environment {
    name: "jazzy",
    packages: &[
        "ros-jazzy-diagnostic-msgs==5.3.6",
        "ros-jazzy-geometry-msgs==5.3.6",
        "ros-jazzy-nav-msgs==5.3.6",
        "ros-jazzy-rclpy[fastrtps]==7.1.6",
        "ros-jazzy-sensor-msgs==5.3.6",
        "ros-jazzy-std-msgs==5.3.6",
        "ros-jazzy-visualization-msgs==5.3.6",
    ],
    files_only: &[],
};

/// The same of ROS 2 Kilted.
pub const KILTED: Environment = Environment {
    name: "kilted",
    packages: &[
        "ros-kilted-diagnostic-msgs==5.5.1",
        "ros-kilted-geometry-msgs==5.5.1",
        "ros-kilted-nav-msgs==5.5.1",
        "ros-kilted-rclpy[fastrtps]==9.1.2",
        "ros-kilted-sensor-msgs==5.5.1",
        "ros-kilted-std-msgs==5.5.1",
        "ros-kilted-visualization-msgs==5.5.1",
    ],
    files_only: &[],
};

/// What drives a browser, and checks whether everybody can use a page.
pub const BROWSER: Environment = Environment {
    name: "browser",
    packages: &["playwright==1.65.2", "axe-playwright-python==0.1.8"],
    files_only: &[],
};

/// The simulator of the paper's group.
const SWARMSIM: Environment =
    Environment { name: "swarmsim", packages: &["swarmsim==1.2.5"], files_only: &[] };

/// What the robots in `MuJoCo` need, with ROS.
const MUJOCO: &str = include_str!("../../../docs/examples/mujoco/requirements.txt");

/// Makes sure that all environments are there.
///
/// # Panics
///
/// As [`python_with`] and [`python_with_swarmsim`].
pub fn install_all() {
    for environment in [BAGS, CYCLONE, SCIENCE, DEPLOYMENT, JAZZY, KILTED, BROWSER] {
        python_with(&environment);
    }
    python_with_mujoco();
    python_with_swarmsim();
}

/// Makes sure that an environment is there, and gives its interpreter.
///
/// It is kept under Cargo's target directory and made once; other test processes wait for it.
///
/// # Panics
///
/// If this machine has no `python3` with `venv`, or reaches no package index.
pub fn python_with(environment: &Environment) -> PathBuf {
    python_from(Path::new("python3"), environment)
}

/// An interpreter with `MuJoCo`, without ROS.
///
/// # Panics
///
/// As [`python_with`].
pub fn python_with_mujoco() -> PathBuf {
    let is_needed = |line: &&str| !line.starts_with("ros-") && !line.is_empty();
    let packages: Vec<&str> = MUJOCO.lines().filter(is_needed).collect();
    python_with(&Environment { name: "mujoco", packages: &packages, files_only: &[] })
}

/// An interpreter with swarmsim.
///
/// # Panics
///
/// If this machine has no Python that swarmsim runs on, or swarmsim cannot be installed.
pub fn python_with_swarmsim() -> PathBuf {
    let base = interpreters().into_iter().find(|python| is_new_enough(python)).expect(
        "this test compares with swarmsim, which needs Python 3.12 or newer, and none was found on \
         the path, among those of pyenv and those of uv: \
         `python3 -m pip install uv && uv python install 3.12` installs one",
    );
    python_from(&base, &SWARMSIM)
}

/// Where a Python may be: on the path, among those of pyenv, whose names on the path only work for
/// the version that was chosen, and among those of uv, which are not on the path.
fn interpreters() -> Vec<PathBuf> {
    let on_path = ["python3.14", "python3.13", "python3.12", "python3"].map(PathBuf::from);
    let home = std::env::home_dir().unwrap_or_default();
    let folder = |variable: &str, usual: &str| {
        std::env::var_os(variable).map_or_else(|| home.join(usual), PathBuf::from)
    };
    let of_pyenv = folder("PYENV_ROOT", ".pyenv").join("versions");
    let of_uv = folder("UV_PYTHON_INSTALL_DIR", ".local/share/uv/python");
    let mut kept: Vec<PathBuf> = [of_pyenv, of_uv]
        .into_iter()
        .filter_map(|versions| fs::read_dir(versions).ok())
        .flatten()
        .filter_map(Result::ok)
        .map(|version| version.path().join("bin/python3"))
        .collect();
    kept.sort();
    kept.reverse();
    on_path.into_iter().chain(kept).collect()
}

fn is_new_enough(python: &Path) -> bool {
    let ask = "import sys, venv; sys.exit(sys.version_info < (3, 12))";
    Command::new(python)
        .args(["-c", ask])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// [`python_with`], of another interpreter than the machine's `python3`.
fn python_from(base: &Path, environment: &Environment) -> PathBuf {
    let Environment { name, packages, files_only } = environment;
    // Tests lie in `target/PROFILE/deps`.
    let test = std::env::current_exe().expect("a running test has an executable");
    let target = test.ancestors().nth(3).expect("the folder of a test lies in the target folder");
    let folder = target.join("tmp").join(format!(".venv-{name}"));
    fs::create_dir_all(target.join("tmp")).expect("the target folder is writable");
    let lock = File::create(folder.with_extension("lock")).expect("the target folder is writable");
    lock.lock().expect("the file system of the target folder has locks");

    let python = folder.join("bin/python");
    let ready = folder.join("ready");
    let wanted = [*packages, *files_only].concat().join("\n");
    if fs::read_to_string(&ready).is_ok_and(|installed| installed == wanted) {
        return python;
    }
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("a half-made environment can be removed");
    }
    must_run(Command::new(base).args(["-m", "venv"]).arg(&folder));
    // Most of what is installed is never imported, so nothing is compiled until it is.
    let install =
        ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"];
    must_run(Command::new(&python).args(install).args(*packages));
    if !files_only.is_empty() {
        must_run(Command::new(&python).args(install).arg("--no-deps").args(*files_only));
    }
    fs::write(&ready, wanted).expect("the new environment is writable");
    python
}

/// Runs a command to its end and gives what it printed.
///
/// # Panics
///
/// If it cannot start or fails; the message holds what it wrote to its standard error.
pub fn must_run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| {
        panic!("{command:?} does not start: {error}; this test needs python3 with venv and pip")
    });
    assert!(
        output.status.success(),
        "{command:?} failed; this test needs python3 with venv, and pip with a package index:\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("the scripts print text")
}

/// What a script prints about a text, of which it gets the path of a file in `folder`, the
/// `CARGO_TARGET_TMPDIR` of a crate.
///
/// # Panics
///
/// As [`python_with`] and [`must_run`].
pub fn answer(script: &Path, folder: &str, text: &str) -> String {
    let name = script.file_name().expect("a script is a file");
    let file = Path::new(folder).join(name).with_extension("json");
    fs::write(&file, text).expect("the target folder is writable");
    must_run(Command::new(python_with(&SCIENCE)).arg(script).arg(&file))
}
