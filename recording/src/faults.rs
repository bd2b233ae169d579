//! The faults of rows, of which a file may have many.

use std::mem::{Discriminant, discriminant};

use crate::error::RecordingError;

/// Faults after whose row nobody reads on: the file is of another kind.
const MOST: usize = 100_000;

/// The faults of rows so far: of each kind the first, and how many there are.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    kinds: Vec<(Discriminant<RecordingError>, RecordingError, usize)>,
    n: usize,
}

impl Faults {
    /// Takes a value, or its fault; there is a number in either case, so that the rest of the row is looked at.
    pub(crate) fn or_zero(&mut self, value: Result<f64, RecordingError>) -> f64 {
        value.unwrap_or_else(|fault| {
            self.add(fault);
            0.0
        })
    }

    pub(crate) fn check(&mut self, checked: Result<(), RecordingError>) {
        if let Err(fault) = checked {
            self.add(fault);
        }
    }

    fn add(&mut self, fault: RecordingError) {
        self.n += 1;
        let kind = discriminant(&fault);
        match self.kinds.iter_mut().find(|(known, ..)| *known == kind) {
            Some((.., n)) => *n += 1,
            None => self.kinds.push((kind, fault, 1)),
        }
    }

    /// True if there are so many faults that reading stops.
    pub(crate) fn are_enough(&self) -> bool {
        self.n >= MOST
    }

    /// The fault itself, if there is one alone; all of them by kind, if there are more.
    pub(crate) fn into_result(self, file: &str) -> Result<(), RecordingError> {
        let mut kinds: Vec<(RecordingError, usize)> = self
            .kinds
            .into_iter()
            .map(|(_, fault, n)| (fault, n))
            .collect();
        match (kinds.len(), self.n) {
            (0, _) => Ok(()),
            (1, 1) => Err(kinds.remove(0).0),
            _ => Err(RecordingError::Several {
                file: file.to_owned(),
                kinds,
            }),
        }
    }
}
