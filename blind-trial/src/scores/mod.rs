//! Scores of the cases of a trial.

mod calibration;
mod confusion;
mod figure;
mod groups;
mod others;
mod power;
mod reach;
mod table;
mod view;

pub use calibration::{Bin, Calibration};
pub use confusion::Confusion;
pub use figure::{Figure, Score, Target};
pub use others::{Method, Others};
pub use power::{Power, PowerBin};
pub use reach::{Became, Reach, Reached};
pub use table::table;
pub use view::VISIBLE_T;

use crate::CaseLine;

/// All that is said of a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Scores {
    /// Quantities with their targets.
    pub table: Vec<Score>,
    /// How often an effect is named, over how visible it was.
    pub power: Power,
    /// Outcome of each single effect.
    pub reach: Reach,
    /// Which name each concealed effect was given.
    pub confusion: Confusion,
    /// How often names of a stated probability are right.
    pub calibration: Calibration,
    /// Scores of other methods on the same files; no method if none was run.
    pub others: Others,
}

impl Scores {
    /// Counts cases; `times_alone_s` are wall times of diagnoses that ran alone on the machine.
    #[must_use]
    pub fn of(lines: &[CaseLine], times_alone_s: &[f64]) -> Self {
        let calibration = Calibration::of(lines);
        Self {
            table: table(lines, &calibration, times_alone_s),
            power: Power::of(lines),
            reach: Reach::of(lines),
            confusion: Confusion::of(lines),
            others: Others::of(lines),
            calibration,
        }
    }
}
