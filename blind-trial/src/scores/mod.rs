//! Scores of the cases of a trial.

mod audits;
mod calibration;
mod confusion;
mod figure;
mod groups;
mod margins;
mod others;
mod power;
mod reach;
mod table;
mod view;

pub use audits::{Audited, Predicted};
pub use calibration::{Bin, Calibration};
pub use confusion::Confusion;
pub use figure::{Figure, Score, Target};
pub use margins::{FOLLOWED, Margin, Margins};
pub use others::{Method, Others};
pub use power::{Power, PowerBin};
pub use reach::{Became, Reach, Reached};
pub use table::table;
pub use view::VISIBLE_T;

use crate::CaseLine;
use audits::audits;

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
    /// Figures with the threshold of a rule moved; `None` where the diagnoses did not note what else they would have said.
    pub margins: Option<Margins>,
    /// Predictions of residuals by a curve without physics, by what is concealed; empty where the diagnoses did not note them.
    pub audits: Vec<Audited>,
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
            margins: Margins::of(lines),
            audits: audits(lines),
            others: Others::of(lines),
            calibration,
        }
    }
}
