//! Uncertainty of a size by how inexact the formula of the loop beside it is.

use identify::{Bounds, Fit, FittedParameter, IdentifyError};

use crate::decide::{OF_FORMULAS, RuleId};
use crate::model::case::{Case, Node};
use crate::search::families::TAKEN_UP;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, EffectParameter, LoopFamily, Role};

/// Independent shapes in which the formula of a loop may err: some five bends of either branch beyond the three that are free. Our choice. The
/// error is as likely of one as of another, and an effect that acts like the loop takes up its share.
const SHAPES: f64 = 10.0;

/// Standard errors of half a 95 % interval.
pub(crate) const HALF_95: f64 = 1.96;

/// Root mean square of that part of the error of the loop's formula which may have the shape of an effect that acts like it: 0 beside the
/// baseline model's loop.
fn along_one_shape(case: &Case<'_>) -> f64 {
    match case.setting.loop_family {
        LoopFamily::Proximity => 0.0,
        _ => OF_FORMULAS * case.output_deviation() / SHAPES.sqrt(),
    }
}

/// Standard error of an effect's first size by the error of the loop's formula, where a size of 1 shows so much; 0 of what does not act like
/// a loop.
pub(crate) fn error_of_formula(case: &Case<'_>, effect: Candidate, shown_per_unit: f64) -> f64 {
    match along_one_shape(case) {
        error if error > 0.0 && effect.info().like_loop => error / shown_per_unit,
        _ => 0.0,
    }
}

/// Least share of what an effect is said to show beside other parameters, with a probability of 97.5 %, if they absorb a share `absorbed` of
/// its square; 0 or less where it may show nothing.
///
/// The formulas that absorb it are exact to a tenth of what they absorb, and that tenth may have any of ten shapes, one of them that
/// of what is left of the effect.
pub(crate) fn certainly_shown(absorbed: f64) -> f64 {
    // The rule says it of the square.
    let exact_to = RuleId::Form.rule().threshold.sqrt();
    let hidden = (absorbed / (1.0 - absorbed)).max(0.0).sqrt();
    1.0 - HALF_95 * exact_to / SHAPES.sqrt() * hidden
}

/// Errors of sizes by that of the formula of the loop beside them.
///
/// All sizes of an effect have one relative error: what the effect may have of that error over what it explains, both root mean squares. What
/// acts like the loop may have what loops of two families differ by along one shape; what does not has a small part of what is left of the
/// recordings beyond the noise, since it is bent toward that.
#[derive(Debug, Clone, Default)]
pub(crate) struct OfFormula {
    of_effects: Vec<OfEffect>,
}

/// Error of an effect by the formula of the loop, and what the effect explains of the training, root mean squares.
#[derive(Debug, Clone, Copy)]
struct OfEffect {
    effect: Candidate,
    error: f64,
    explained: f64,
}

impl OfFormula {
    /// The errors beside the loop of a search; `noise` is the variance of the noise at least.
    pub(crate) fn beside(
        search: &mut Search<'_>,
        effects: CandidateSet,
        noise: f64,
    ) -> Result<Self, IdentifyError> {
        if search.case.setting.loop_family == LoopFamily::Proximity {
            return Ok(Self::default());
        }
        let mut of_effects = Vec::new();
        let one_shape = along_one_shape(search.case);
        for effect in effects.iter() {
            let less = search.node_without(effects, effect)?.mean_square();
            let Some(with) = search.get(effects).map(Node::mean_square) else {
                continue;
            };
            let error = match effect.info().like_loop {
                true => one_shape,
                false => ((with - noise).max(0.0) * TAKEN_UP).sqrt(),
            };
            of_effects.push(OfEffect {
                effect,
                error,
                explained: (less - with).max(0.0).sqrt(),
            });
        }
        Ok(Self { of_effects })
    }

    /// Standard error of the sizes of an effect by the formula, over them; 0 where there is none.
    pub(crate) fn relative(&self, effect: Candidate) -> f64 {
        let own = self.of(effect);
        own.map_or(0.0, |own| own.error / own.explained)
    }

    /// Standard error of the sizes over them where the effect explains so much of other recordings, a mean square.
    pub(crate) fn relative_where(&self, effect: Candidate, explained: f64) -> f64 {
        let own = self.of(effect);
        own.map_or(0.0, |own| own.error / explained.max(0.0).sqrt())
    }

    fn of(&self, effect: Candidate) -> Option<&OfEffect> {
        self.of_effects.iter().find(|one| one.effect == effect)
    }

    /// The interval of a size with its error by the formula. An end may lie beyond what is possible: then the size is not told.
    pub(crate) fn widened(
        &self,
        (effect, size): (Candidate, &EffectParameter),
        fitted: &FittedParameter,
        (value, own): (f64, Bounds),
    ) -> Bounds {
        if self.of(effect).is_none() {
            return own;
        }
        let range = fitted.info.bounds.width();
        let error = self.relative(effect) * (value - size.neutral()).abs();
        // What explains nothing may have any size.
        let half = HALF_95 * if error < range { error } else { range };
        widened_by(own, value, half)
    }

    /// Widens the intervals of all sizes of a fit.
    pub(crate) fn widen(&self, fit: &mut Fit) {
        for OfEffect { effect, .. } in &self.of_effects {
            let sizes = effect.info().parameters.iter();
            for size in sizes.filter(|parameter| parameter.role == Role::Size) {
                let of_size = |fitted: &&mut FittedParameter| fitted.info.name == size.name;
                for fitted in fit.parameters.iter_mut().filter(of_size) {
                    let wider = fitted.values.iter().zip(&fitted.intervals);
                    let wider = wider.map(|(&value, own)| {
                        own.map(|own| self.widened((*effect, size), fitted, (value, own)))
                    });
                    fitted.intervals = wider.collect();
                }
            }
        }
    }
}

/// An interval around a value with another half, in quadrature on either side.
fn widened_by(own: Bounds, value: f64, half: f64) -> Bounds {
    Bounds {
        lower: value - (value - own.lower).hypot(half),
        upper: value + (own.upper - value).hypot(half),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::search::families::{Near, cases, formulas, shaped};
    use crate::{EffectId, EffectSet, EffectValues, Effort, Setting};

    #[test]
    fn what_acts_like_another_loop_is_as_uncertain_as_its_formula() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let papers = synthetic.case();
        let setting = Setting {
            loop_family: LoopFamily::Relays,
            ..papers.setting
        };
        let relays = Case::new(papers.base, papers.fit, papers.training, setting);
        let of = |case: &Case<'_>, effect: EffectId, shown: f64| {
            error_of_formula(case, effect.into(), shown)
        };
        let nothing = [
            of(&papers, EffectId::Backlash, 1.0),
            of(&relays, EffectId::DeadTime, 1.0),
        ];
        assert_eq!(nothing.map(f64::to_bits), [0; 2]);
        // A fiftieth of 5 mm times a deviation of some 0.4 strokes, a third of it along one shape.
        let one = of(&relays, EffectId::Backlash, 1.0);
        assert!((0.005..0.02).contains(&one), "{one}");
        assert!((of(&relays, EffectId::Backlash, 4.0) / one - 0.25).abs() < 1e-12);
    }

    #[test]
    fn what_nearly_hides_behind_other_parameters_cannot_be_excluded() {
        assert!((certainly_shown(0.0) - 1.0).abs() < 1e-12);
        // A tenth of three times what is left, along one of ten shapes.
        assert!((certainly_shown(0.9) - (1.0 - 1.96 * 0.3 / 10_f64.sqrt())).abs() < 1e-12);
        assert!(certainly_shown(0.996) > 0.0);
        assert!(certainly_shown(0.997) < 0.0 && certainly_shown(1.0) < 0.0);
    }

    #[test]
    fn what_is_left_beyond_the_noise_makes_sizes_beside_another_loop_uncertain() {
        let effects = CandidateSet::of(EffectId::DeadTime);
        let values = EffectValues::typical(EffectId::DeadTime, 1.0);
        let with = EffectSet::of(EffectId::DeadTime);
        let synthetic = Synthetic::with_loop(LoopFamily::Relays, with, values, 1);
        let papers = synthetic.case();
        let formulas = formulas(&papers, 1).unwrap();
        let fits = shaped(&papers, formulas, Near::Nearer, (Effort::Normal, 1)).unwrap();
        let relays = &cases(&papers, &fits)[0];
        let of = |case: &Case<'_>, noise: f64| {
            let baseline = case.baseline().unwrap();
            let mut search = Search::new(case, baseline, effects, NOISE_MM.powi(2), 1).unwrap();
            search.grow_by_one().unwrap();
            let [less, with] = [CandidateSet::EMPTY, effects]
                .map(|set| search.get(set).map_or(f64::NAN, |node| node.mean_square()));
            let found = OfFormula::beside(&mut search, effects, noise).unwrap();
            let dead_time = Candidate::from(EffectId::DeadTime);
            // What explains a quarter elsewhere is twice as uncertain there.
            let [here, there] =
                [1.0, 0.25].map(|of| found.relative_where(dead_time, of * (less - with)));
            let relative = found.relative(dead_time);
            assert!((here - relative).abs() <= 1e-12 && (there - 2.0 * here).abs() <= 1e-12);
            (relative, less, with)
        };
        assert!(of(&papers, 0.0).0.abs() <= 0.0);
        let (relative, less, with) = of(relays, 0.0);
        let expected = (with * TAKEN_UP / (less - with)).sqrt();
        assert!(
            (relative / expected - 1.0).abs() < 1e-9,
            "{relative} {expected}"
        );
        assert!(of(relays, 2.0 * with).0 <= 0.0);
    }

    #[test]
    fn a_size_whose_formula_may_make_it_is_not_told() {
        let own = Bounds {
            lower: 0.8,
            upper: 1.0,
        };
        let wide = widened_by(own, 0.9, 0.9);
        // Beyond 0 and beyond the whole: a size over its half interval of less than 1.
        assert!(wide.lower < 0.0 && wide.upper > 1.8);
        let narrow = widened_by(own, 0.9, 0.0);
        assert_eq!(
            [narrow.lower, narrow.upper].map(f64::to_bits),
            [0.8_f64, 1.0].map(f64::to_bits)
        );
    }
}
