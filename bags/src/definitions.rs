//! Definitions of message types, from folders of `.msg` files.
//!
//! A bag carries the definition of every type in it. Those of our own messages and of the stock
//! types among them are compiled in; all others are found where ROS 2 keeps them: in the source
//! folders of a workspace or in what was installed.
//!
//! It reads `.msg` files only, not `.idl`.

mod fields;
mod hash;
mod search;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rsrs_msgs::schema;

pub use fields::TypeName;

/// What rosbag2 puts between two definitions.
const DELIMITER: &str =
    "================================================================================";

/// A type with all that it takes to decode it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Such as `std_msgs/msg/Bool`.
    pub type_name: String,
    /// Its own `.msg` text and then that of each type in it, as bags keep it.
    pub text: String,
    /// `RIHS01_` and 64 hexadecimal digits; `None` if it cannot be known.
    pub type_hash: Option<String>,
}

impl Definition {
    /// A type that is compiled in; `None` for any other.
    pub fn of_known_type(type_name: &str) -> Option<Self> {
        Some(Self {
            type_name: type_name.to_owned(),
            text: schema::schema_text(type_name)?,
            type_hash: schema::type_hash(type_name).map(str::to_owned),
        })
    }
}

/// Why a type has no definition.
#[expect(missing_docs, reason = "fields are what the message names")]
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// Something else than the name of a message type.
    #[error("{found:?} is not a type of message, expected package/msg/Name")]
    TypeName { found: String },
    /// There is no file for the type.
    #[error(
        "no file {} in {}{}", .type_name.file(), folders(.searched), wanted_by(.needed_by.as_ref())
    )]
    NotFound { type_name: TypeName, needed_by: Option<TypeName>, searched: Vec<PathBuf> },
    /// A line is no field, constant or comment.
    #[error("{}:{line}: {found:?} is neither field nor constant", .path.display())]
    Syntax { path: PathBuf, line: usize, found: String },
    /// The system refused.
    #[error("cannot read {}", .path.display())]
    Io { path: PathBuf, source: std::io::Error },
}

impl DefinitionError {
    /// What to do about it, where there is something.
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::NotFound { .. } => Some(
                "name the folder that holds the package: a workspace, its src or install folder, \
                 or a prefix such as /opt/ros/jazzy",
            ),
            Self::TypeName { .. } | Self::Syntax { .. } | Self::Io { .. } => None,
        }
    }
}

/// Folders in which definitions are looked for.
#[derive(Clone, Debug)]
pub struct Definitions {
    folders: Vec<PathBuf>,
}

/// The text of one file, with the types of its fields.
struct Parsed {
    text: String,
    dependencies: Vec<TypeName>,
}

impl Definitions {
    /// Definitions from these folders, the first one first.
    ///
    /// # Arguments
    ///
    /// * `folders` — each one a package, a folder of packages (searched 6 levels deep, such as a
    ///   workspace or its `src`), an ament prefix with `share/package/msg`, or a colcon `install`
    ///   folder of such prefixes.
    pub fn new(folders: Vec<PathBuf>) -> Self {
        Self { folders }
    }

    /// The definition of a type, with all types in it.
    ///
    /// The text is what rosbag2 writes: the type's own file first, then each type it needs, once,
    /// depth first and sorted by name, behind a line of 80 `=` and a line `MSG: package/Type`. A
    /// type that is in none of the folders may be compiled in.
    ///
    /// # Arguments
    ///
    /// * `type_name` — a full name such as `lab_msgs/msg/Battery`.
    ///
    /// # Errors
    ///
    /// [`DefinitionError`]: no such name, file or syntax.
    pub fn find(&self, type_name: &str) -> Result<Definition, DefinitionError> {
        let root = TypeName::parse(type_name)
            .ok_or_else(|| DefinitionError::TypeName { found: type_name.to_owned() })?;
        let mut read = BTreeMap::new();
        self.read(&root, None, &mut read)?;
        let mut text = read[&root].text.clone();
        let mut seen = vec![root.clone()];
        append_dependencies(&root, &read, &mut seen, &mut text);

        let type_hash = hash::rihs01(&root, &read);
        Ok(Definition { type_name: type_name.to_owned(), text, type_hash })
    }

    /// Reads a type and all types in it.
    fn read(
        &self,
        type_name: &TypeName,
        needed_by: Option<&TypeName>,
        read: &mut BTreeMap<TypeName, Parsed>,
    ) -> Result<(), DefinitionError> {
        if read.contains_key(type_name) {
            return Ok(());
        }
        let parsed = match self.file_of(type_name)? {
            Some(path) => {
                let text = fs::read_to_string(&path)
                    .map_err(|source| DefinitionError::Io { path: path.clone(), source })?;
                parse(text, &type_name.package, &path)?
            }
            None => compiled_in(type_name).ok_or_else(|| DefinitionError::NotFound {
                type_name: type_name.clone(),
                needed_by: needed_by.cloned(),
                searched: self.folders.clone(),
            })?,
        };
        let dependencies = parsed.dependencies.clone();
        read.insert(type_name.clone(), parsed);
        for dependency in &dependencies {
            self.read(dependency, Some(type_name), read)?;
        }
        Ok(())
    }

    fn file_of(&self, type_name: &TypeName) -> Result<Option<PathBuf>, DefinitionError> {
        for folder in &self.folders {
            let found = search::file_of(folder, type_name)
                .map_err(|source| DefinitionError::Io { path: folder.clone(), source })?;
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }
}

fn parse(text: String, package: &str, path: &Path) -> Result<Parsed, DefinitionError> {
    let dependencies =
        fields::dependencies(&text, package).map_err(|line| DefinitionError::Syntax {
            path: path.to_owned(),
            line,
            found: text.lines().nth(line - 1).unwrap_or_default().to_owned(),
        })?;
    Ok(Parsed { text, dependencies })
}

/// The own text of a type that is compiled in.
fn compiled_in(type_name: &TypeName) -> Option<Parsed> {
    let text = schema::schema_text(&type_name.to_string())?;
    let own = text.split(&format!("\n{DELIMITER}\n")).next()?.to_owned();
    let dependencies = fields::dependencies(&own, &type_name.package)
        .expect("what is compiled in was parsed when it was made");
    Some(Parsed { text: own, dependencies })
}

fn append_dependencies(
    of: &TypeName,
    read: &BTreeMap<TypeName, Parsed>,
    seen: &mut Vec<TypeName>,
    text: &mut String,
) {
    for dependency in &read[of].dependencies {
        if seen.contains(dependency) {
            continue;
        }
        let TypeName { package, name } = dependency;
        for part in ["\n", DELIMITER, "\nMSG: ", package, "/", name, "\n", &read[dependency].text] {
            text.push_str(part);
        }
        seen.push(dependency.clone());
        append_dependencies(dependency, read, seen, text);
    }
}

fn folders(searched: &[PathBuf]) -> String {
    if searched.is_empty() {
        return "no folder at all".to_owned();
    }
    searched.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

fn wanted_by(needed_by: Option<&TypeName>) -> String {
    needed_by.map(|type_name| format!(", needed by {type_name}")).unwrap_or_default()
}
