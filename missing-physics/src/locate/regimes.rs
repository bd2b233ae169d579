//! Regimes: sets of samples that somebody would give a name to.

use recording::{cycles, holds};

use crate::model::case::Case;
use crate::pullback::scene::{Passage, Scene};

/// Ends of the bands of the transformed share.
const FRACTIONS: [f64; 2] = [0.3, 0.7];

/// Bands of temperature.
const TEMPERATURE_BANDS: usize = 3;

/// Share of the range of the temperature up to which a reversal is near.
const NEAR_REVERSAL: f64 = 0.15;

/// Change of the power, as a share of its range, below which the drive counts as held.
const HELD: f64 = 0.01;

/// Rates below this share of the largest are rest.
const REST: f64 = 0.02;

/// Ends of cold and start of hot, as shares of the range of the temperature.
const COLD_AND_HOT: [f64; 2] = [0.2, 0.6];

/// Most cycles of a recording that are regimes by themselves.
const MOST_CYCLES: usize = 12;

/// Fewest samples and smallest share of all of them that make a regime; the largest share.
const FEWEST_SAMPLES: usize = 20;
const SHARES: [f64; 2] = [0.01, 0.9];

/// A set of samples of the output.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Regime {
    /// Description, for people.
    pub(crate) at: String,
    /// Membership of each sample of the output: true if it belongs to the regime.
    pub(crate) members: Vec<bool>,
    pub(crate) n_members: usize,
}

/// All regimes that are neither nearly empty nor nearly everything.
pub(crate) fn regimes(case: &Case<'_>, scene: &Scene) -> Vec<Regime> {
    let partition = Partition { case, scene };
    let mut regimes = partition.by_fraction();
    regimes.extend(partition.by_temperature());
    regimes.extend(partition.by_drive());
    regimes.extend(partition.by_reversal());
    regimes.extend(partition.by_rate());
    regimes.extend(partition.at_rest());
    regimes.extend(partition.by_cycle());
    let n_samples = scene.n_outputs() as f64;
    regimes.retain(|regime| {
        let share = regime.n_members as f64 / n_samples;
        regime.n_members >= FEWEST_SAMPLES && (SHARES[0]..=SHARES[1]).contains(&share)
    });
    regimes
}

struct Partition<'a> {
    case: &'a Case<'a>,
    scene: &'a Scene,
}

impl Partition<'_> {
    fn regime(&self, at: String, belongs: impl Fn(&Passage, usize) -> bool) -> Regime {
        let mut members = vec![false; self.scene.n_outputs()];
        for passage in &self.scene.passages {
            let own = &mut members[passage.range.clone()];
            for (k, member) in own.iter_mut().enumerate() {
                *member = belongs(passage, k);
            }
        }
        Regime {
            at,
            n_members: members.iter().filter(|member| **member).count(),
            members,
        }
    }

    /// "cooling, 30-70 % transformed"
    fn by_fraction(&self) -> Vec<Regime> {
        let [low, high] = FRACTIONS;
        let percent = |fraction: f64| (100.0 * fraction).round();
        let bands = [
            (0.0, low, format!("below {} % transformed", percent(low))),
            (
                low,
                high,
                format!("{}-{} % transformed", percent(low), percent(high)),
            ),
            (high, 1.1, format!("over {} % transformed", percent(high))),
        ];
        self.on_branches(&bands, |passage, k| passage.fraction[k])
    }

    /// "heating, 48-71 °C", or which third of the range where the scale is not known.
    fn by_temperature(&self) -> Vec<Regime> {
        let [lowest, highest] = self.rise_range();
        let step_k = (highest - lowest) / TEMPERATURE_BANDS as f64;
        let ambient_degc = self.ambient_degc();
        let names = ["lowest", "middle", "highest"];
        let bands: Vec<(f64, f64, String)> = (0..TEMPERATURE_BANDS)
            .map(|band| {
                let from = lowest + band as f64 * step_k;
                let to = from + step_k;
                let name = if self.case.base.knows_temperature() {
                    format!("{:.0}-{:.0} °C", ambient_degc + from, ambient_degc + to)
                } else {
                    format!("{} third of the temperatures", names[band])
                };
                let last = band + 1 == TEMPERATURE_BANDS;
                (from, if last { f64::INFINITY } else { to }, name)
            })
            .collect();
        self.on_branches(&bands, |passage, k| passage.rise_k[k])
    }

    /// Bands of a variable on each branch, each from its lower end to before its upper one.
    fn on_branches(
        &self,
        bands: &[(f64, f64, String)],
        value: impl Fn(&Passage, usize) -> f64,
    ) -> Vec<Regime> {
        let mut regimes = Vec::new();
        for (heating, branch) in [(true, "heating"), (false, "cooling")] {
            for (from, to, name) in bands {
                regimes.push(self.regime(format!("{branch}, {name}"), |passage, k| {
                    passage.heating[k] == heating && (*from..*to).contains(&value(passage, k))
                }));
            }
            regimes.push(self.regime(branch.to_owned(), |passage, k| {
                passage.heating[k] == heating
            }));
        }
        regimes
    }

    /// By what the drive did during the last time constant.
    fn by_drive(&self) -> Vec<Regime> {
        let changes: Vec<Vec<f64>> = self.scene.passages.iter().map(change_of_power).collect();
        [
            ("while the drive is held", [-HELD, HELD]),
            ("after the drive has risen", [HELD, f64::INFINITY]),
            ("after the drive has fallen", [f64::NEG_INFINITY, -HELD]),
        ]
        .into_iter()
        .map(|(name, [from, to])| {
            self.regime(name.to_owned(), |passage, k| {
                let change = changes[passage.recording][k];
                change >= from && change <= to
            })
        })
        .collect()
    }

    fn by_reversal(&self) -> Vec<Regime> {
        let [lowest, highest] = self.rise_range();
        let near_k = NEAR_REVERSAL * (highest - lowest);
        let distances: Vec<Vec<f64>> = self.scene.passages.iter().map(from_reversal_k).collect();
        let near = |passage: &Passage, k: usize| distances[passage.recording][k] < near_k;
        vec![
            self.regime("just after a reversal".to_owned(), near),
            self.regime("far from a reversal".to_owned(), |passage, k| {
                !near(passage, k)
            }),
        ]
    }

    fn by_rate(&self) -> Vec<Regime> {
        let mut rates: Vec<f64> = self.scene.passages.iter().flat_map(speeds).collect();
        rates.sort_by(f64::total_cmp);
        let middle = rates.get(rates.len() / 2).copied().unwrap_or(0.0);
        let fast = |passage: &Passage, k: usize| passage.rate_k_per_s[k].abs() > middle;
        vec![
            self.regime("while the temperature changes fast".to_owned(), fast),
            self.regime(
                "while the temperature changes slowly".to_owned(),
                |passage, k| !fast(passage, k),
            ),
        ]
    }

    fn at_rest(&self) -> Vec<Regime> {
        let largest = self.scene.passages.iter().flat_map(speeds);
        let rest = REST * largest.fold(0.0, f64::max);
        let [lowest, highest] = self.rise_range();
        let [cold, hot] = COLD_AND_HOT.map(|share| lowest + share * (highest - lowest));
        let held: Vec<Vec<bool>> = self
            .scene
            .passages
            .iter()
            .map(|passage| {
                let mut held = vec![false; passage.len()];
                for hold in holds(&self.case.training[passage.recording], passage.tau_s) {
                    held[hold.samples].fill(true);
                }
                held
            })
            .collect();
        let resting = |passage: &Passage, k: usize| {
            passage.rate_k_per_s[k].abs() <= rest && held[passage.recording][k]
        };
        vec![
            self.regime("at rest, cold".to_owned(), |passage, k| {
                resting(passage, k) && passage.rise_k[k] <= cold
            }),
            self.regime("at rest, hot".to_owned(), |passage, k| {
                resting(passage, k) && passage.rise_k[k] >= hot
            }),
        ]
    }

    /// Cycles of the drive, and whole recordings.
    fn by_cycle(&self) -> Vec<Regime> {
        let single = self.case.training.len() == 1;
        let mut regimes = Vec::new();
        for (r, recording) in self.case.training.iter().enumerate() {
            let own = |passage: &Passage| passage.recording == r;
            if !single {
                let name = recording.name().to_owned();
                regimes.push(self.regime(name, |passage, _| own(passage)));
            }
            let cycles = cycles(recording);
            if cycles.len() < 2 {
                continue;
            }
            for (number, cycle) in cycles.iter().enumerate().take(MOST_CYCLES) {
                let name = if single {
                    format!("cycle {}", number + 1)
                } else {
                    format!("{}, cycle {}", recording.name(), number + 1)
                };
                regimes.push(self.regime(name, |passage, k| {
                    own(passage) && cycle.samples.contains(&k)
                }));
            }
        }
        regimes
    }

    /// Lowest and highest temperature above ambient, K.
    fn rise_range(&self) -> [f64; 2] {
        let rises = || {
            let passages = self.scene.passages.iter();
            passages.flat_map(|passage| passage.rise_k.iter().copied())
        };
        [
            rises().fold(f64::INFINITY, f64::min),
            rises().fold(f64::NEG_INFINITY, f64::max),
        ]
    }

    /// Temperature of the surroundings where the first recording starts, °C.
    fn ambient_degc(&self) -> f64 {
        let passage = self.scene.passages.first();
        passage.map_or(0.0, |passage| passage.first_ambient_degc)
    }
}

fn speeds(passage: &Passage) -> impl Iterator<Item = f64> + '_ {
    passage.rate_k_per_s.iter().map(|rate| rate.abs())
}

/// Change of the power over the last time constant, as a share of its range in the recording.
fn change_of_power(passage: &Passage) -> Vec<f64> {
    let power = &passage.power_k_per_s;
    let highest = power.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = power.iter().copied().fold(f64::INFINITY, f64::min);
    let range = (highest - lowest).max(f64::MIN_POSITIVE);
    let mut before = 0;
    (0..passage.len())
        .map(|k| {
            let since_s = passage.time_s[k] - passage.tau_s;
            while passage.time_s[before] < since_s {
                before += 1;
            }
            (power[k] - power[before]) / range
        })
        .collect()
}

/// Distance of the temperature from where its branch began, K.
fn from_reversal_k(passage: &Passage) -> Vec<f64> {
    let mut began = passage.rise_k[0];
    (0..passage.len())
        .map(|k| {
            if k > 0 && passage.heating[k] != passage.heating[k - 1] {
                began = passage.rise_k[k - 1];
            }
            (passage.rise_k[k] - began).abs()
        })
        .collect()
}
