use std::io;
use std::path::PathBuf;

use identify::IdentifyError;
use pid_tune::{TaskError, TuneError};
use recording::RecordingError;
use sma_effects::PhysicsError;
use wiener::WienerError;

use crate::RigError;

/// Errors in making a document, or a rig to be controlled.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorkbenchError {
    /// A model cannot be controlled as asked.
    #[error(transparent)]
    Rig(Box<RigError>),
    /// A recording is refused.
    #[error(transparent)]
    Recording(Box<RecordingError>),
    /// A rod file or a model is.
    #[error(transparent)]
    Identify(Box<IdentifyError>),
    /// Effects of a plant are.
    #[error(transparent)]
    Physics(Box<PhysicsError>),
    /// A plain plant is.
    #[error(transparent)]
    Wiener(#[from] WienerError),
    /// A controller or its task is.
    #[error(transparent)]
    Tune(#[from] TuneError),
    /// A plant or a controller is, while they run.
    #[error(transparent)]
    Task(Box<TaskError<PhysicsError>>),
    /// An input cannot be read.
    #[error("{}: cannot be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// An input is another one than when the command began.
    #[error("{}: was changed while it was read; run the command again", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// A result cannot be written.
    #[error("{}: cannot be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A result would take the place of an input.
    #[error("{}: is an input of this command; give another file for the result", path.display())]
    IsInput {
        /// The file.
        path: PathBuf,
    },
    /// Two results would go to one file.
    #[error("{}: another result of this command goes there; give each a file of its own", path.display())]
    Taken {
        /// The file.
        path: PathBuf,
    },
    /// Figures would stand among inputs, and one may have the name of an input.
    #[error("{}: holds inputs of this command; give figures a folder of their own", path.display())]
    HoldsInputs {
        /// The folder.
        path: PathBuf,
    },
    /// A result would take the place of a file that the user may have written.
    #[error("{}: is there already; expected a new file, or --force to write over it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Files that one rod file is to describe differ in their columns.
    #[error("{file}: other columns than {first}; expected the same ones, or a rod file for each")]
    OtherColumns {
        /// The file.
        file: String,
        /// The one that it differs from.
        first: String,
    },
    /// A diagnosis is asked for of recordings whose output is the temperature.
    #[error(
        "{recording}: the output is the temperature: no effect of the catalogue shows in it alone; use `sma identify`, or record what the actuator does beside its temperature"
    )]
    OnlyTemperature {
        /// The recording.
        recording: String,
    },
    /// A run is of the reference and since.
    #[error(
        "{recording}: its data are given to --reference and to --train; a run is one or the other"
    )]
    InReference {
        /// The recording.
        recording: String,
    },
    /// Laws are asked for of a rig that is no heated rod.
    #[error(
        "{recording}: --reference is for recordings of a heated rod with time, drive and displacement"
    )]
    NoReference {
        /// The recording.
        recording: String,
    },
    /// A diagnosis is asked for of two rods that pull against one another.
    #[error(
        "{recording}: two drives: effects are known of one rod only; `sma identify` fits both; for a diagnosis record each with the other cold, and name one drive"
    )]
    TwoRods {
        /// The recording.
        recording: String,
    },
    /// The folder of a result is not there.
    #[error("{}: cannot be {action}: there is no folder {}", path.display(), folder.display())]
    NoFolder {
        /// The file or folder.
        path: PathBuf,
        /// The action that failed: "written" or "made".
        action: &'static str,
        /// The folder that it would be in.
        folder: PathBuf,
    },
    /// A file stands where a folder for figures is wanted.
    #[error("{}: is a file; give a folder for the figures", path.display())]
    IsFile {
        /// The file.
        path: PathBuf,
    },
    /// A folder cannot be made.
    #[error("{}: cannot be made", path.display())]
    Make {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A figure cannot be drawn.
    #[error("{figure}: cannot be drawn: {reason}")]
    Draw {
        /// Its name.
        figure: &'static str,
        /// Message of the drawing library.
        reason: String,
    },
}

/// For lower errors that are large, and kept in a box.
macro_rules! boxed {
    ($($variant:ident: $error:ty,)+) => {
        $(impl From<$error> for WorkbenchError {
            fn from(error: $error) -> Self {
                Self::$variant(Box::new(error))
            }
        })+
    };
}

boxed! {
    Rig: RigError,
    Recording: RecordingError,
    Identify: IdentifyError,
    Physics: PhysicsError,
    Task: TaskError<PhysicsError>,
}

impl WorkbenchError {
    /// True if the input is wrong; false if the place of the result is.
    #[must_use]
    pub fn is_bad_input(&self) -> bool {
        matches!(
            self,
            Self::Rig(_)
                | Self::Recording(_)
                | Self::Identify(_)
                | Self::Physics(_)
                | Self::Wiener(_)
                | Self::Tune(_)
                | Self::Task(_)
                | Self::Changed { .. }
                | Self::Exists { .. }
                | Self::OtherColumns { .. }
                | Self::OnlyTemperature { .. }
                | Self::TwoRods { .. }
                | Self::InReference { .. }
                | Self::NoReference { .. }
        )
    }
}
