//! Definitions of message types, from folders of `.msg` files.
//!
//! A bag carries the definition of every type in it. Those of our own messages and of the stock
//! types among them are compiled in; all others are found where ROS 2 keeps them: in the source
//! folders of a workspace or in what was installed.
//!
//! It reads `.msg` files only, not `.idl`.

mod search;

use std::collections::BTreeMap;
use std::path::PathBuf;

use rsrs_core::help::Help;
use rsrs_msgs::schema;

pub use rsrs_msgs::schema::TypeName;

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

impl Help for DefinitionError {
    fn help(&self) -> Option<String> {
        match self {
            Self::NotFound { .. } => Some(
                "name the folder that holds the package: a workspace, its src or install folder, \
                 or a prefix such as /opt/ros/jazzy"
                    .to_owned(),
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

impl Definitions {
    /// Definitions from these folders, the first one first.
    ///
    /// Each is a package, a folder of packages (searched 6 levels deep, such as a workspace or its
    /// `src`), an ament prefix with `share/package/msg`, or a colcon `install` folder of such
    /// prefixes.
    pub fn new(folders: Vec<PathBuf>) -> Self {
        Self { folders }
    }

    /// The definition of a type, such as `lab_msgs/msg/Battery`, with all types in it.
    ///
    /// The text is what rosbag2 writes: the type's own file first, then each type it needs, once,
    /// depth first and sorted by name, behind a line of 80 `=` and a line `MSG: package/Type`. A
    /// type that is in none of the folders may be compiled in.
    pub fn find(&self, type_name: &str) -> Result<Definition, DefinitionError> {
        let root = TypeName::parse(type_name)
            .ok_or_else(|| DefinitionError::TypeName { found: type_name.to_owned() })?;
        let mut read = BTreeMap::new();
        self.read(&root, None, &mut read)?;
        let text_of = |known: &TypeName| read[known].as_str();
        let text = schema::with_dependencies(&read[&root], &root.package, &text_of);
        let type_hash = schema::rihs01(&root, &read);
        Ok(Definition { type_name: type_name.to_owned(), text, type_hash })
    }

    /// Reads a type and all types in it.
    fn read(
        &self,
        type_name: &TypeName,
        needed_by: Option<&TypeName>,
        read: &mut BTreeMap<TypeName, String>,
    ) -> Result<(), DefinitionError> {
        if read.contains_key(type_name) {
            return Ok(());
        }
        let path = self.file_of(type_name)?;
        let text = if let Some(path) = &path {
            rsrs_files::read_text(path)
                .map_err(|source| DefinitionError::Io { path: path.clone(), source })?
        } else {
            let compiled_in = schema::own_text(&type_name.to_string()).map(str::to_owned);
            compiled_in.ok_or_else(|| DefinitionError::NotFound {
                type_name: type_name.clone(),
                needed_by: needed_by.cloned(),
                searched: self.folders.clone(),
            })?
        };
        let dependencies = schema::dependencies(&text, &type_name.package).map_err(|line| {
            let found = text.lines().nth(line - 1).unwrap_or_default().to_owned();
            DefinitionError::Syntax { path: path.unwrap_or_default(), line, found }
        })?;
        read.insert(type_name.clone(), text);
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

fn folders(searched: &[PathBuf]) -> String {
    if searched.is_empty() {
        return "no folder at all".to_owned();
    }
    searched.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

fn wanted_by(needed_by: Option<&TypeName>) -> String {
    needed_by.map(|type_name| format!(", needed by {type_name}")).unwrap_or_default()
}
