use std::io;
use std::path::PathBuf;

/// Errors in the description of a fleet. A rig whose files are wrong is none of them: it is a row of the result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FleetError {
    /// A folder or a manifest cannot be read.
    #[error("{}: cannot be read", path.display())]
    Unreadable {
        /// The folder or file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A folder from which results are to be taken has none.
    #[error("{}: cannot be read; expected a folder of results, as --out of another call made it", path.display())]
    NoResults {
        /// The folder of its units.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file is no manifest by its name.
    #[error("{}: is no folder and no manifest; expected a folder of rigs, or a file that ends in .csv or .toml", path.display())]
    NotManifest {
        /// The file.
        path: PathBuf,
    },
    /// A TOML manifest cannot be understood.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Toml {
        /// The manifest.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Message of the reader.
        message: String,
    },
    /// A CSV manifest lacks a column, or has one that is not known.
    #[error("{}:{line}: columns {found}; expected name, rod, train and perhaps validate", path.display())]
    Columns {
        /// The manifest.
        path: PathBuf,
        /// Line of the header.
        line: usize,
        /// Its columns.
        found: String,
    },
    /// A row has more or fewer fields than the header.
    #[error("{}:{line}: fields: {found}; expected {expected}, as in the header", path.display())]
    Fields {
        /// The manifest.
        path: PathBuf,
        /// Line of the row.
        line: usize,
        /// Its fields.
        found: usize,
        /// Those of the header.
        expected: usize,
    },
    /// A value that every rig has is empty.
    #[error("{}:{line}: {key} is empty; expected {expected}", path.display())]
    Empty {
        /// The manifest.
        path: PathBuf,
        /// Line of the rig.
        line: usize,
        /// Its key.
        key: &'static str,
        /// Accepted values.
        expected: &'static str,
    },
    /// Two rigs have one name.
    #[error("{}:{line}: name = {name:?}: another rig has it; expected a name of its own for each", path.display())]
    NameTwice {
        /// The manifest.
        path: PathBuf,
        /// Line of the second.
        line: usize,
        /// The name.
        name: String,
    },
    /// There is no rig.
    #[error("{}: holds no rig; expected {expected}", path.display())]
    NoRig {
        /// The folder or manifest.
        path: PathBuf,
        /// Accepted content.
        expected: &'static str,
    },
    /// A result would be found as a recording by the next call.
    #[error("{}: lies among the recordings, and the next call would take it for one; give another folder", path.display())]
    AmongRecordings {
        /// Place of the result.
        path: PathBuf,
    },
}
