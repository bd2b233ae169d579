//! Elementary terms that a block of the cascade could lack, pulled back to the output.
//!
//! ```text
//! heat balance     dδT/dt = -δT/τ + q(t),   δy = g δT,   g = dy/dT = -dy/d(loop center)
//! transformation   δT = -shift,             δy = -g shift
//! displacement                              δy itself
//! ```
//!
//! To first order, and the loop's memory moves along: nothing is simulated but the model itself.

use crate::EffectBlock;
use crate::model::case::Case;
use crate::model::projection::norm;
use crate::pullback::scene::{Passage, Scene};

/// Knots of a curve on each branch.
pub(crate) const KNOTS: usize = 5;

/// Length of a column, relative to the longest of its block, below which it says nothing.
const SMALLEST_TERM: f64 = 1e-6;

/// Half cosines of a slow course over a recording.
const SLOW: usize = 3;

/// Variable that a term is a function of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variable {
    /// Temperature above ambient, K.
    Rise,
    /// Transformed share, 0 to 1.
    Fraction,
    /// Place in the model's stroke, 0 to 1.
    Place,
    /// Of something else: an elementary term by itself.
    Other,
    /// Time since the recording began, as a share of it.
    Time,
}

/// Trace in the output of a local term of size 1.
#[derive(Debug, Clone)]
pub(crate) struct LocalTerm {
    pub(crate) block: EffectBlock,
    pub(crate) variable: Variable,
    /// The branch on which it acts; `None` for both.
    pub(crate) heating: Option<bool>,
    /// Value of the variable where the term is largest.
    pub(crate) knot: f64,
    /// Series over the layout.
    pub(crate) column: Vec<f64>,
}

/// Traces of local terms in all blocks: curves of the local variable on each branch, and the elementary terms
/// that no such curve can show.
///
/// A heat term is in K/s, a shift of the loop in K, a displacement in the unit of the output.
pub(crate) fn terms_of(case: &Case<'_>, scene: &Scene) -> Vec<LocalTerm> {
    let pull = Pull { case, scene };
    let mut terms = pull.heat_curves();
    terms.extend(pull.shifts());
    terms.extend(pull.displacements());
    terms.extend(pull.elementary());
    without_negligible(terms)
}

/// A slow course of time in each block but the drive, one after the other for each recording: surroundings
/// that warm, a loop that wanders, a sensor that drifts.
pub(crate) fn drifts_of(case: &Case<'_>, scene: &Scene) -> Vec<LocalTerm> {
    let pull = Pull { case, scene };
    let blocks = [
        EffectBlock::HeatBalance,
        EffectBlock::Transformation,
        EffectBlock::Displacement,
    ];
    let mut terms = Vec::new();
    for block in blocks {
        for r in 0..scene.passages.len() {
            for j in 1..=SLOW {
                let column = pull.column(block, |passage, k| {
                    if passage.recording == r {
                        half_cosine(j, passage.time_share(k))
                    } else {
                        0.0
                    }
                });
                terms.push(LocalTerm {
                    block,
                    variable: Variable::Time,
                    heating: None,
                    knot: j as f64,
                    column,
                });
            }
        }
    }
    without_negligible(terms)
}

/// cos(π j s).
fn half_cosine(j: usize, share: f64) -> f64 {
    libm::cos(std::f64::consts::PI * j as f64 * share)
}

/// Pulls local terms back to the output.
pub(crate) struct Pull<'a> {
    pub(crate) case: &'a Case<'a>,
    pub(crate) scene: &'a Scene,
}

impl Pull<'_> {
    /// Trace of a local term, given sample by sample.
    pub(crate) fn column(
        &self,
        block: EffectBlock,
        term: impl Fn(&Passage, usize) -> f64,
    ) -> Vec<f64> {
        let mut column = vec![0.0; self.case.layout.len()];
        for passage in &self.scene.passages {
            let local: Vec<f64> = (0..passage.len()).map(|k| term(passage, k)).collect();
            let shown = &mut column[passage.range.clone()];
            match block {
                EffectBlock::Transformation => {
                    for (k, shown) in shown.iter_mut().enumerate() {
                        *shown = -passage.slope_per_k[k] * local[k];
                    }
                }
                EffectBlock::Displacement | EffectBlock::Sensor => shown.copy_from_slice(&local),
                EffectBlock::Drive | EffectBlock::HeatBalance => {
                    let warmer_k = warmer_k(passage, &local);
                    for (k, shown) in shown.iter_mut().enumerate() {
                        *shown = passage.slope_per_k[k] * warmer_k[k];
                    }
                    if let Some(range) = &passage.temperatures {
                        let per_k = self.case.layout.per_k;
                        for (shown, warmer_k) in column[range.clone()].iter_mut().zip(&warmer_k) {
                            *shown = per_k * warmer_k;
                        }
                    }
                }
            }
        }
        column
    }

    /// Hats at the knots of a variable, on heating and on cooling.
    fn curves(
        &self,
        block: EffectBlock,
        variable: Variable,
        knots: &[f64],
        value: impl Fn(&Passage, usize) -> f64,
    ) -> Vec<LocalTerm> {
        let mut terms = Vec::new();
        for heating in [true, false] {
            for (j, &knot) in knots.iter().enumerate() {
                let column = self.column(block, |passage, k| {
                    if passage.heating[k] == heating {
                        hat(knots, j, value(passage, k))
                    } else {
                        0.0
                    }
                });
                terms.push(LocalTerm {
                    block,
                    variable,
                    heating: Some(heating),
                    knot,
                    column,
                });
            }
        }
        terms
    }

    /// Heat as a function of the temperature.
    fn heat_curves(&self) -> Vec<LocalTerm> {
        let knots = self.rise_knots();
        let rise = |passage: &Passage, k: usize| passage.rise_k[k];
        self.curves(EffectBlock::HeatBalance, Variable::Rise, &knots, rise)
    }

    /// Shifts of the loop as functions of the fraction.
    fn shifts(&self) -> Vec<LocalTerm> {
        let knots: Vec<f64> = evenly(0.0, 1.0);
        let fraction = |passage: &Passage, k: usize| passage.fraction[k];
        let block = EffectBlock::Transformation;
        self.curves(block, Variable::Fraction, &knots, fraction)
    }

    /// Displacements as functions of the place in the stroke.
    fn displacements(&self) -> Vec<LocalTerm> {
        let block = EffectBlock::Displacement;
        let knots: Vec<f64> = evenly(0.0, 1.0);
        let place = |passage: &Passage, k: usize| self.scene.place(passage.output[k]);
        self.curves(block, Variable::Place, &knots, place)
    }

    /// Knots of the temperature: half way between equal steps and equal numbers of samples.
    fn rise_knots(&self) -> Vec<f64> {
        let mut rise_k: Vec<f64> = self
            .scene
            .passages
            .iter()
            .flat_map(|passage| passage.rise_k.iter().copied())
            .collect();
        rise_k.sort_by(f64::total_cmp);
        let last = rise_k.len().saturating_sub(1);
        let (Some(&lowest), Some(&highest)) = (rise_k.first(), rise_k.get(last)) else {
            return Vec::new();
        };
        evenly(lowest, highest)
            .iter()
            .enumerate()
            .map(|(j, even)| f64::midpoint(*even, rise_k[j * last / (KNOTS - 1)]))
            .collect()
    }
}

fn evenly(from: f64, to: f64) -> Vec<f64> {
    (0..KNOTS)
        .map(|j| from + (to - from) * j as f64 / (KNOTS - 1) as f64)
        .collect()
}

/// Linear B-spline: 1 at knot j, 0 at its neighbors; the outermost ones go on beyond the last knot.
pub(crate) fn hat(knots: &[f64], j: usize, value: f64) -> f64 {
    let value = value.clamp(knots[0], knots[knots.len() - 1]);
    let toward = |neighbor: f64| {
        let distance = (neighbor - knots[j]).abs();
        if distance > 0.0 {
            1.0 - (value - knots[j]).abs() / distance
        } else {
            0.0
        }
    };
    if value < knots[j] {
        toward(knots[j - 1]).max(0.0)
    } else if value > knots[j] {
        toward(knots[j + 1]).max(0.0)
    } else {
        1.0
    }
}

/// How much warmer the rod is that a heat source q, K/s, held over each sample, has warmed since the start.
///
/// ```text
/// δT_(k+1) = δT_k e^(-dt/τ) + q_k τ (1 - e^(-dt/τ))
/// ```
fn warmer_k(passage: &Passage, source_k_per_s: &[f64]) -> Vec<f64> {
    let mut warmer = 0.0;
    let sources = source_k_per_s.iter().zip(&passage.dt_s);
    sources
        .map(|(source, dt_s)| {
            let now = warmer;
            let gone = -libm::expm1(-dt_s / passage.tau_s);
            warmer += (source * passage.tau_s - warmer) * gone;
            now
        })
        .collect()
}

fn without_negligible(mut terms: Vec<LocalTerm>) -> Vec<LocalTerm> {
    let longest = |block| {
        let own = terms.iter().filter(|term| term.block == block);
        own.map(|term| norm(&term.column)).fold(0.0, f64::max)
    };
    let blocks = [
        EffectBlock::Drive,
        EffectBlock::HeatBalance,
        EffectBlock::Transformation,
        EffectBlock::Displacement,
    ];
    let least = blocks.map(|block| (block, SMALLEST_TERM * longest(block)));
    terms.retain(|term| {
        let own = least.iter().find(|(block, _)| *block == term.block);
        own.is_some_and(|(_, least)| norm(&term.column) > *least)
    });
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::projection::dot;
    use crate::model::synthetic::Synthetic;
    use crate::model::tangent::{LARGEST_SECANT, sensitivities, traces};
    use crate::{EffectId, EffectSet, EffectValues};

    /// Largest cosine between the trace of a simulated effect and a term of its block.
    fn likeness(effect: EffectId) -> f64 {
        let rig = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let case = rig.case();
        let node = case.baseline().unwrap();
        let sensitivities = sensitivities(&case, &node).unwrap();
        let terms = terms_of(&case, &Scene::of(&case, &node, &sensitivities).unwrap());
        let own = terms
            .iter()
            .filter(|term| term.block == effect.info().block);
        let secant =
            &traces(&case, &node, effect.into(), &[LARGEST_SECANT], None).unwrap()[0].secant;
        own.map(|term| dot(secant, &term.column) / (norm(secant) * norm(&term.column)))
            .map(f64::abs)
            .fold(0.0, f64::max)
    }

    #[test]
    fn terms_are_what_effects_do_to_first_order() {
        for effect in [
            EffectId::DeadTime,
            EffectId::SupplyLag,
            EffectId::FunctionalFatigue,
            EffectId::OutputLag,
            EffectId::ThermalExpansion,
        ] {
            let likeness = likeness(effect);
            assert!(likeness > 0.9, "{effect:?} {likeness}");
        }
    }

    #[test]
    fn hats_add_up_to_one() {
        let knots = [0.0, 1.0, 2.5, 4.0, 8.0];
        for value in [-1.0, 0.0, 0.3, 1.0, 3.9, 7.0, 9.0] {
            let sum: f64 = (0..knots.len()).map(|j| hat(&knots, j, value)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{value} {sum}");
        }
    }
}
