use identify::IdentifyError;

/// Error in a rod file or a model file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigFileError {
    /// A file cannot be read.
    #[error("{file}: cannot be read")]
    Unreadable {
        /// File.
        file: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A file is not of its layout: syntax, unknown key, wrong type.
    #[error("{file}:{line}:{column}: {message}")]
    Toml {
        /// File.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Message of the parser: found and accepted input.
        message: String,
    },
    /// A value is out of range.
    #[error("{file}:{line}:{column}: {key} = {value}: {accepted}")]
    Value {
        /// File.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Key.
        key: String,
        /// Rejected value.
        value: f64,
        /// Accepted values.
        accepted: String,
    },
    /// An entry of a model file says what cannot be.
    #[error("{file}:{line}:{column}: {what}: {accepted}")]
    Saved {
        /// File.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The entry.
        what: String,
        /// Accepted entries.
        accepted: String,
    },
    /// A file is no model file at all.
    #[error(
        "{file}: no schema_version; a model comes from --save-model of `sma identify` or `sma diagnose`"
    )]
    NoModel {
        /// File.
        file: String,
    },
    /// A model file names no recording that the model was fitted to.
    #[error(
        "{file}: recording: none has role = \"train\"; expected the recordings that the model was fitted to, as --save-model writes them"
    )]
    Untrained {
        /// File.
        file: String,
    },
    /// A model has no form in TOML.
    #[error("model of {file}: cannot be written")]
    Unwritable {
        /// The rod file.
        file: String,
        /// Why.
        #[source]
        source: toml::ser::Error,
    },
    /// The text of a model's rod says something else than its fields.
    #[error(
        "model of {file}: its rod is not what the text of {file} says; expected a rod as it was read"
    )]
    OtherRod {
        /// The rod file.
        file: String,
    },
    /// A rig or a model cannot be as the file says.
    #[error(transparent)]
    Model(#[from] IdentifyError),
}
