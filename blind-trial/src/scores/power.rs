use crate::{CaseLine, Family, Proportion};

/// Lower ends of the bins of the oracle score; the first begins at 0.
const FROM: [f64; 7] = [0.0, 2.0, 5.0, 10.0, 20.0, 50.0, 200.0];

/// How often a single effect is named, over how visible it was.
#[derive(Debug, Clone, PartialEq)]
pub struct Power {
    /// By oracle score.
    pub bins: Vec<PowerBin>,
}

/// Effects of about one oracle score.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerBin {
    /// Lowest score.
    pub from_t: f64,
    /// Share that is in the stated set.
    pub stated: Proportion,
    /// Share whose strongest name is the truth.
    pub top: Proportion,
}

impl Power {
    pub(super) fn of(lines: &[CaseLine]) -> Self {
        let singles: Vec<&CaseLine> = lines
            .iter()
            .filter(|line| line.case.family == Family::Single)
            .collect();
        let bins = FROM.iter().enumerate().map(|(k, &from_t)| {
            let end = FROM.get(k + 1).copied().unwrap_or(f64::INFINITY);
            let inside: Vec<&&CaseLine> = singles
                .iter()
                .filter(|line| {
                    let mut oracles = line.opened.oracles.iter();
                    oracles.any(|oracle| (from_t..end).contains(&oracle.t))
                })
                .collect();
            PowerBin {
                from_t,
                stated: Proportion::of(&inside, |line| line.states_all()),
                top: Proportion::of(&inside, |line| line.top() == Some(line.truth())),
            }
        });
        Self {
            bins: bins.collect(),
        }
    }
}
