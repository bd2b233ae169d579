use recording::RecordingError;
use wiener::WienerError;

/// Error in what is known of a rod, in a set of recordings or in a model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A key that this rig needs is missing.
    #[error("{file}: {key} is missing: {why}")]
    Missing {
        /// File.
        file: String,
        /// Key, with its table.
        key: &'static str,
        /// Why it is needed.
        why: &'static str,
    },
    /// `[model]` names a parameter that the model does not have.
    #[error("{file}:{line}:{column}: [model] {name}: no such parameter; this rig has {known}")]
    UnknownParameter {
        /// File.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Name as written.
        name: String,
        /// Names that would be accepted.
        known: String,
    },
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// No training recording was given.
    #[error("no training recording; at least 1 is needed")]
    NoRecordings,
    /// A training recording has no time.
    #[error("{recording}: no time; a heat balance can only be identified from timed samples")]
    Untimed {
        /// Recording.
        recording: String,
    },
    /// A recording has no stress where one is needed.
    #[error("{recording}: no stress; expected a column stress_mpa, or one named under [columns]")]
    NoStress {
        /// Recording.
        recording: String,
    },
    /// A heat balance is asked for by what records no temperature.
    #[error("{file}: output in {unit}: a thermal model needs a temperature, in degC, K or degF")]
    NoTemperature {
        /// The rod file or the model.
        file: String,
        /// Unit of the output.
        unit: String,
    },
    /// A loop is asked for of recordings whose output is the temperature.
    #[error(
        "{recording}: the output is the temperature: it shows the heat balance and no loop; use `sma identify` without a preset"
    )]
    OnlyTemperature {
        /// Recording.
        recording: String,
    },
    /// A model of one rod is asked for of recordings with two drives.
    #[error(
        "{recording}: two drives: the paper's unknowns are those of one rod; use `sma identify` without a preset"
    )]
    TwoRods {
        /// Recording.
        recording: String,
    },
    /// A recording has one drive, and the model two rods.
    #[error(
        "{recording}: one drive: the model is of two rods; name the other drive by [columns] antagonist"
    )]
    NoAntagonist {
        /// Recording.
        recording: String,
    },
    /// Recordings measure the output in different units.
    #[error("{recording}: output in {found}, but {first} is in {expected}: one unit is needed")]
    Units {
        /// Recording.
        recording: String,
        /// Its unit.
        found: String,
        /// First recording.
        first: String,
        /// Unit of the first recording.
        expected: String,
    },
    /// Recordings are driven in different ways.
    #[error(
        "{recording}: driven by {found}, but {first} by {expected}: one kind of drive is needed"
    )]
    Drives {
        /// Recording.
        recording: String,
        /// Its drive.
        found: String,
        /// First recording.
        first: String,
        /// Drive of the first recording.
        expected: String,
    },
    /// A forward model did not show what it was asked for.
    #[error(
        "{recording}: the model showed {shown} of {expected} samples, or not all points in every block"
    )]
    IncompleteBlocks {
        /// Recording.
        recording: String,
        /// Samples shown.
        shown: usize,
        /// Samples of the recording.
        expected: usize,
    },
    /// A gain that is not shared, an offset that is, or two of a kind: such are not solved for.
    #[error(
        "{name}: a model may have one shared gain and one offset for each recording, or fixed ones"
    )]
    NotSolvable {
        /// Parameter.
        name: &'static str,
    },
    /// No simulation gave a number.
    #[error(
        "no point within the bounds gives a finite cost; check the recordings for absurd values"
    )]
    NothingFinite,
    /// Whoever watches a search has ended it; nothing of it is left to return.
    #[error("ended before there was a result")]
    Stopped,
    /// A rod file asks for what the model cannot do.
    #[error(
        "{file}: drive.kind = \"temperature\": such data have no heat balance to identify; give current, duty, voltage or power"
    )]
    StaticDrive {
        /// File.
        file: String,
    },
    /// An entry of `[model]` says nothing, too much, or what cannot be.
    #[error("{file}:{line}:{column}: [model] {name}: {accepted}")]
    Entry {
        /// File.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Parameter.
        name: String,
        /// Accepted entries.
        accepted: String,
    },
    /// A saved model does not have the parameters that are to be fitted.
    #[error("{file}: a model of {found}; this rig has {expected}")]
    OtherParameters {
        /// The model file.
        file: String,
        /// Its parameters.
        found: String,
        /// Those that would be accepted.
        expected: String,
    },
    /// The optimizer of the cross-check gave up.
    #[error("cross-check: argmin failed: {said}")]
    CrossCheck {
        /// Message of argmin.
        said: String,
    },
    /// A start that is no point of the problem.
    #[error("a start of {found} coordinates; this problem has {expected}")]
    StartLength {
        /// Coordinates given.
        found: usize,
        /// Coordinates of the problem.
        expected: usize,
    },
    /// A model without a free nonlinear parameter.
    #[error("every parameter is fixed: nothing to identify")]
    NothingFree,
    /// A model that is not of this crate refuses a point or a recording.
    #[error("model")]
    Model(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// A model cannot be simulated.
    #[error("simulation")]
    Simulation(#[from] WienerError),
    /// The swarm refuses its settings.
    #[error("swarm")]
    Swarm(#[from] pso::SwarmError),
}
