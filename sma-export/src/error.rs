/// Reasons why a model cannot be exported as asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// An effect needs a search in each sample.
    #[error(
        "{effect}: needs a search for the end of each sample, and this export has formulas alone; expected a model of {known}; --to fmu exports all effects"
    )]
    Effect {
        /// Id of the effect.
        effect: &'static str,
        /// Ids of the effects that are exported.
        known: String,
    },
    /// The loop is of another family than the paper's.
    #[error(
        "loop family {family}: has no formula in this export yet; expected {expected}; --to fmu exports all families"
    )]
    Family {
        /// Id of the family.
        family: &'static str,
        /// Id of the family that is exported.
        expected: &'static str,
    },
    /// A hypothesis of one's own.
    #[error("hypotheses of your own: have no export; expected effects of the catalogue")]
    Hypotheses,
    /// The sample time is no positive number.
    #[error("sample time {value} s: must be finite and > 0")]
    SampleTime {
        /// Rejected value, s.
        value: f64,
    },
    /// A delay is longer than the plant remembers at this sample time.
    #[error(
        "dead time {delay_s} s: the plant remembers {longest} samples, {longest_s} s of this sample time; expected a longer --sample-time-s"
    )]
    DeadTime {
        /// The delay, s.
        delay_s: f64,
        /// Samples that are remembered.
        longest: usize,
        /// Their length, s.
        longest_s: f64,
    },
    /// A constant is no number of the wanted precision.
    #[error(
        "{name} = {value}: beyond the range of a {precision}; leave out --float, or look at the model"
    )]
    Range {
        /// Its name in the templates.
        name: &'static str,
        /// The value.
        value: f64,
        /// The C type.
        precision: &'static str,
    },
    /// A prefix is no identifier of C.
    #[error(
        "prefix {text:?}: must be a lower-case letter followed by at most 30 lower-case letters, digits or underscores"
    )]
    Prefix {
        /// Rejected text.
        text: String,
    },
    /// The model is not of one rod that a drive heats.
    #[error(
        "{file}: is {kind}; expected a model of one rod that a drive heats, from recordings with time, drive and displacement"
    )]
    Kind {
        /// File of the model.
        file: String,
        /// Kind of what was found.
        kind: &'static str,
    },
    /// A flag has no use for the language.
    #[error("{flag}: for --to {accepted} alone; leave it out for --to {to}")]
    Flag {
        /// The flag.
        flag: &'static str,
        /// The language that was asked for.
        to: &'static str,
        /// The languages that take it.
        accepted: String,
    },
    /// An input cannot be read.
    #[error("{file}: cannot be read: {reason}; expected {expected}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
        /// Content that would be accepted.
        expected: &'static str,
    },
    /// No recording of the model has a sample time.
    #[error("{file}: no recording of the model has a sample time; give --sample-time-s")]
    NoSampleTime {
        /// File of the model.
        file: String,
    },
    /// A file of gains is not as `sma tune --json` writes it.
    #[error("{file}:{line}:{column}: {message}; expected a file of `sma tune --json`")]
    Tuned {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Fault at that place.
        message: String,
    },
    /// A value in a file of gains cannot be exported.
    #[error("{file}: {key} = {value}: {accepted}")]
    TunedValue {
        /// The file.
        file: String,
        /// Its key.
        key: &'static str,
        /// The value.
        value: String,
        /// Values that would be accepted.
        accepted: String,
    },
    /// The library of a functional mock-up unit is none, or of another version.
    #[error(
        "the library is {found}; expected libsma_fmu.so of sma {}, beside the program or as --library", env!("CARGO_PKG_VERSION")
    )]
    Library {
        /// Kind of what was found.
        found: &'static str,
    },
    /// An archive would be larger than its format holds.
    #[error("the unit would have more than 4 GiB: expected a library and a model of a few MB")]
    TooLarge,
    /// The plant is refused.
    #[error("the model is refused")]
    Plant(#[from] sma_effects::PhysicsError),
    /// The controller is refused.
    #[error("the controller is refused")]
    Controller(#[from] pid_tune::TuneError),
}
