//! Elementary local terms that are no curve of one variable: each is what some physics would do to first order.

use wiener::Drive;

use crate::EffectBlock;
use crate::pullback::local_terms::{LocalTerm, Pull, Variable};
use crate::pullback::scene::{Passage, rates};

/// Lags of the drive behind itself, as shares of the time constant of the heat balance.
const DRIVE_LAGS: [f64; 3] = [1.0 / 30.0, 1.0 / 10.0, 1.0 / 3.0];

/// Time constant of a second body, over that of the rod.
const SECOND_BODY: f64 = 5.0;

/// Places in the stroke where something may begin to hold.
const CORNERS: [f64; 6] = [0.5, 0.65, 0.75, 0.85, 0.9, 0.95];

impl Pull<'_> {
    /// All of them.
    pub(crate) fn elementary(&self) -> Vec<LocalTerm> {
        let mut terms = self.of_drive();
        terms.extend(self.of_heat());
        terms.extend(self.of_transformation());
        terms.extend(self.of_displacement());
        terms
    }

    /// A series for each recording as a term.
    fn term(&self, block: EffectBlock, local: impl Fn(&Passage) -> Vec<f64>) -> LocalTerm {
        let series: Vec<Vec<f64>> = self.scene.passages.iter().map(local).collect();
        LocalTerm {
            block,
            variable: Variable::Other,
            heating: None,
            knot: 0.0,
            column: self.column(block, |passage, k| series[passage.recording][k]),
        }
    }

    /// Terms of the drive: the power that a lagging supply leaves out, and the effect of a late supply per second of delay.
    fn of_drive(&self) -> Vec<LocalTerm> {
        let heats_by_square = matches!(
            self.case.base.drive(),
            Drive::Current | Drive::Voltage { .. }
        );
        let mut terms: Vec<LocalTerm> = DRIVE_LAGS
            .iter()
            .map(|share| {
                self.term(EffectBlock::Drive, |passage| {
                    let lag_s = share * passage.tau_s;
                    if heats_by_square {
                        late_square(passage, lag_s)
                    } else {
                        let power = &passage.power_k_per_s;
                        let behind = lagging(passage, power, lag_s, power_before(passage));
                        behind.iter().map(|behind| -behind).collect()
                    }
                })
            })
            .collect();
        terms.push(self.late());
        terms
    }

    /// A late drive makes everything late, per second: pulled back through the heat it would be less exact.
    fn late(&self) -> LocalTerm {
        let mut term = self.term(EffectBlock::Displacement, |passage| {
            fallen(&passage.output, &passage.dt_s)
        });
        for passage in &self.scene.passages {
            if let Some(range) = &passage.temperatures {
                let cooler_k = fallen(&passage.rise_k, &passage.dt_s);
                let shown = term.column[range.clone()].iter_mut();
                for (shown, cooler_k) in shown.zip(cooler_k) {
                    *shown = self.case.layout.per_k * cooler_k;
                }
            }
        }
        LocalTerm {
            block: EffectBlock::Drive,
            ..term
        }
    }

    /// Heat that the rod takes up as it transforms, that a slower body stores, and that follows the resistance.
    fn of_heat(&self) -> Vec<LocalTerm> {
        let block = EffectBlock::HeatBalance;
        vec![
            self.term(block, |passage| {
                let rates = rates(&passage.fraction, &passage.dt_s);
                rates.iter().map(|rate| -rate).collect()
            }),
            self.term(block, |passage| {
                let lag_s = SECOND_BODY * passage.tau_s;
                let stored = lagging(passage, &passage.rise_k, lag_s, passage.rise_k[0]);
                stored.iter().map(|stored| stored / passage.tau_s).collect()
            }),
            self.term(block, |passage| {
                let pairs = passage.power_k_per_s.iter().zip(&passage.fraction);
                pairs.map(|(power, fraction)| power * fraction).collect()
            }),
        ]
    }

    /// Shifts of the loop by a spread that differs between the branches, by all that the rod has transformed,
    /// and by where it last turned back;
    /// and what closes minor loops.
    fn of_transformation(&self) -> Vec<LocalTerm> {
        let block = EffectBlock::Transformation;
        let mut terms = vec![
            self.term(block, |passage| {
                let branches = passage.heating.iter().map(|heating| sign(*heating));
                let pairs = branches.zip(&passage.fraction);
                pairs
                    .map(|(sign, fraction)| sign * (2.0 * fraction - 1.0))
                    .collect()
            }),
            self.term(block, transformations),
        ];
        for heating in [true, false] {
            terms.push(self.term(block, |passage| {
                let depths = depths(passage);
                let own = depths.iter().zip(&passage.heating);
                own.map(|(depth, branch)| if *branch == heating { *depth } else { 0.0 })
                    .collect()
            }));
        }
        // What closes minor loops is known in the output: it needs no pulling back.
        terms.push(LocalTerm {
            block,
            ..self.term(EffectBlock::Displacement, closing)
        });
        terms
    }

    /// Displacements by the temperature, by the speed, and beyond places in the stroke.
    fn of_displacement(&self) -> Vec<LocalTerm> {
        let block = EffectBlock::Displacement;
        let mut terms = vec![
            self.term(block, |passage| passage.rise_k.clone()),
            self.term(block, |passage| fallen(&passage.output, &passage.dt_s)),
        ];
        terms.extend(CORNERS.iter().map(|corner| LocalTerm {
            knot: *corner,
            ..self.term(block, |passage| {
                let places = passage
                    .output
                    .iter()
                    .map(|output| self.scene.place(*output));
                places.map(|place| (place - corner).max(0.0)).collect()
            })
        }));
        terms
    }
}

/// -dv/dt over the sample before each: a sensor cannot know the next one.
fn fallen(values: &[f64], dt_s: &[f64]) -> Vec<f64> {
    let rates = rates(values, dt_s);
    let before = std::iter::once(&0.0).chain(&rates);
    before.take(values.len()).map(|rate| -rate).collect()
}

fn sign(heating: bool) -> f64 {
    if heating { 1.0 } else { -1.0 }
}

/// ln(1 + n), with the number of full cycles n that the rod has transformed.
fn transformations(passage: &Passage) -> Vec<f64> {
    let mut path = 0.0;
    let mut last = passage.fraction[0];
    passage
        .fraction
        .iter()
        .map(|fraction| {
            path += (fraction - last).abs();
            last = *fraction;
            libm::log1p(0.5 * path)
        })
        .collect()
}

/// Samples at which the branches begin: the first one, and those of the reversals.
fn turns(passage: &Passage) -> Vec<usize> {
    let reversals = (1..passage.len()).filter(|&k| passage.heating[k] != passage.heating[k - 1]);
    std::iter::once(0).chain(reversals.map(|k| k - 1)).collect()
}

/// How far from a saturated rod the last reversal was, as a share of the transformation.
fn depths(passage: &Passage) -> Vec<f64> {
    let mut depth = 0.0;
    (0..passage.len())
        .map(|k| {
            if k > 0 && passage.heating[k] != passage.heating[k - 1] {
                let fraction = passage.fraction[k - 1];
                depth = if passage.heating[k] {
                    fraction
                } else {
                    1.0 - fraction
                };
            }
            depth
        })
        .collect()
}

/// Displacement that would close the minor loops.
///
/// It acts on each branch that comes back to the temperature of the reversal before its own: it rises with the
/// temperature to the step that leads to that reversal, and is gone where the rod is saturated.
fn closing(passage: &Passage) -> Vec<f64> {
    let mut closing = vec![0.0; passage.len()];
    let turns = turns(passage);
    for (n, pair) in turns.windows(2).enumerate() {
        let (returns_to, began) = (pair[0], pair[1]);
        let end = turns.get(n + 2).map_or(passage.len(), |next| next + 1);
        let way_k = passage.rise_k[returns_to] - passage.rise_k[began];
        let progress = |k: usize| (passage.rise_k[k] - passage.rise_k[began]) / way_k;
        let Some(back) = (began + 1..end).find(|&k| progress(k) >= 1.0) else {
            continue;
        };
        let gap = passage.output[returns_to] - passage.output[back];
        let to_go = |k: usize| {
            let fraction = passage.fraction[k];
            if way_k > 0.0 {
                1.0 - fraction
            } else {
                fraction
            }
        };
        for k in began + 1..end {
            let share = if k < back {
                progress(k).max(0.0)
            } else {
                to_go(k) / to_go(back).max(f64::MIN_POSITIVE)
            };
            closing[k] = gap * share.min(1.0);
        }
    }
    closing
}

/// Power of the drive that would have held the temperature at the start, K/s.
fn power_before(passage: &Passage) -> f64 {
    (passage.rise_k[0] / passage.tau_s).max(0.0)
}

/// Mean over each sample of what a power lacks whose square root follows with a time constant, K/s.
///
/// ```text
/// a(t) = a + b e^(-t/θ),   mean of a(t)² - a² = 2 a b θ (1 - e^(-dt/θ))/dt + b² θ (1 - e^(-2 dt/θ))/(2 dt)
/// ```
fn late_square(passage: &Passage, lag_s: f64) -> Vec<f64> {
    let mut follower = power_before(passage).sqrt();
    let samples = passage.power_k_per_s.iter().zip(&passage.dt_s);
    samples
        .map(|(power, dt_s)| {
            let held = power.sqrt();
            let behind = follower - held;
            let gone = -libm::expm1(-dt_s / lag_s);
            let gone_twice = -libm::expm1(-2.0 * dt_s / lag_s);
            follower -= behind * gone;
            behind * (2.0 * held * gone + 0.5 * behind * gone_twice) * lag_s / dt_s
        })
        .collect()
}

/// Mean over each sample of a signal, held over the sample, less what follows it with a time constant.
fn lagging(passage: &Passage, signal: &[f64], lag_s: f64, before: f64) -> Vec<f64> {
    let mut follower = before;
    let samples = signal.iter().zip(&passage.dt_s);
    samples
        .map(|(signal, dt_s)| {
            let behind = signal - follower;
            let gone = -libm::expm1(-dt_s / lag_s);
            follower += behind * gone;
            behind * gone * lag_s / dt_s
        })
        .collect()
}
