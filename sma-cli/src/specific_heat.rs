//! How an uncertain specific heat widens what is said of missing effects.

use identify::{Bounds, Rod, WienerModel};
use missing_physics::{Candidate, Diagnosis, EffectId, Finding, Status};

use crate::report::number::spoken;

/// Widens the intervals of a diagnosis to hold for the whole range that the rod file gives the specific heat, and
/// says so in the sentences. Returns the range if there was anything to widen.
///
/// ```text
/// all temperature differences divided by c = C_p/C_p0 give the same displacement
/// ```
///
/// What is left out of it stays: a latent heat, a time, a share.
pub(crate) fn carry(rod: &Rod, model: &WienerModel, diagnosis: &mut Diagnosis) -> Option<Bounds> {
    let heat = Range {
        value: rod.specific_heat_j_per_kg_k?,
        ends: rod.specific_heat_range?,
    };
    if !model.carry_specific_heat(&mut diagnosis.baseline.fit) {
        return None;
    }
    if let Some(extended) = &mut diagnosis.extended {
        model.carry_specific_heat(&mut extended.stage.fit);
        let effects = extended.effects.iter();
        let parameters =
            effects.flat_map(|effect| effect.info().parameters.iter().map(|one| (*effect, one)));
        for (effect, info) in parameters {
            let fitted = &mut extended.stage.fit.parameters;
            let Some(fitted) = fitted.iter_mut().find(|one| one.info.name == info.name) else {
                continue;
            };
            for interval in fitted.intervals.iter_mut().flatten() {
                let [lower, upper] =
                    heat.widened(effect, info.unit, [interval.lower, interval.upper]);
                *interval = Bounds { lower, upper };
            }
        }
    }
    for finding in diagnosis.findings.iter_mut().chain(&mut diagnosis.suspects) {
        heat.widen(finding);
    }
    for entry in &mut diagnosis.catalogue {
        if let Status::Excluded { upper } = &mut entry.status {
            *upper = heat.widened(entry.effect, entry.unit, [0.0, *upper])[1];
        }
    }
    Some(heat.ends)
}

/// A specific heat and its range, J/(kg K).
#[derive(Debug, Clone, Copy)]
struct Range {
    value: f64,
    ends: Bounds,
}

impl Range {
    /// An interval that holds for the whole range.
    fn widened(self, effect: Candidate, unit: &str, [lower, upper]: [f64; 2]) -> [f64; 2] {
        let power = power(effect, unit);
        let factors = [self.ends.lower, self.ends.upper].map(|end| (end / self.value).powi(power));
        let end =
            |end: f64, choose: fn(f64, f64) -> f64| choose(end * factors[0], end * factors[1]);
        [end(lower, f64::min), end(upper, f64::max)]
    }

    fn widen(self, finding: &mut Finding) {
        let effect = finding.effect;
        let mut said = Vec::new();
        for parameter in &mut finding.parameters {
            let Some(interval) = parameter.ci95 else {
                continue;
            };
            let [lower, upper] = self.widened(effect, parameter.unit, interval);
            if power(effect, parameter.unit) != 0 {
                parameter.ci95 = Some([lower, upper]);
                said.push(ends([lower, upper], parameter.unit));
            }
        }
        if said.is_empty() {
            return;
        }
        finding.plausible |= finding.parameters.iter().all(|one| {
            let (Some([low, high]), Some([lower, upper])) = (one.literature, one.ci95) else {
                return one.literature.is_none();
            };
            let sign = one.value.signum();
            (sign * lower).max(sign * upper) >= low && (sign * lower).min(sign * upper) <= high
        });
        finding.sentence = format!(
            "{}; for a specific heat of {} to {} J/(kg K): {}.",
            finding.sentence.trim_end_matches('.'),
            spoken(self.ends.lower),
            spoken(self.ends.upper),
            said.join(", ")
        );
    }
}

/// An interval in words, in the unit that the sentence has.
fn ends(ends: [f64; 2], unit: &str) -> String {
    let between = |factor: f64| {
        let [lower, upper] = ends.map(|end| spoken(factor * end));
        format!("{lower} to {upper}")
    };
    match unit {
        "1" => between(1.0),
        unit if unit.starts_with("1/K") => format!("({})·10⁻⁶/K", between(1e6)),
        unit => format!("{} {unit}", between(1.0)),
    }
}

/// Power of C_p with which a parameter scales at the same displacement.
fn power(effect: Candidate, unit: &str) -> i32 {
    match (effect.effect(), unit) {
        // What radiation adds to the linear loss grows with the square of the temperature difference.
        (Some(EffectId::Radiation), _) => 2,
        // An expression says nothing of it.
        (None, _) => 0,
        (_, unit) if unit.starts_with("1/K") => 1,
        (_, "K") => -1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use missing_physics::Estimate;

    const HEAT: Range = Range {
        value: 500.0,
        ends: Bounds {
            lower: 450.0,
            upper: 840.0,
        },
    };

    fn finding(effect: EffectId, estimate: Estimate) -> Finding {
        Finding {
            effect: effect.into(),
            could_also_be: Vec::new(),
            probability: 0.9,
            parameters: vec![estimate],
            plausible: false,
            contribution: 0.5,
            sentence: "It is so.".to_owned(),
        }
    }

    fn estimate(unit: &'static str, value: f64, ci95: [f64; 2]) -> Estimate {
        Estimate {
            name: "it",
            unit,
            value,
            ci95: Some(ci95),
            literature: None,
        }
    }

    #[track_caller]
    fn assert_ends(found: Option<[f64; 2]>, expected: [f64; 2]) {
        let found = found.unwrap();
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn an_expansion_grows_with_the_specific_heat_and_says_so() {
        let mut one = finding(
            EffectId::ThermalExpansion,
            estimate("1/K", 12e-6, [11e-6, 13e-6]),
        );
        one.parameters[0].literature = Some([15e-6, 20e-6]);
        HEAT.widen(&mut one);
        assert_ends(one.parameters[0].ci95, [0.9 * 11e-6, 1.68 * 13e-6]);
        assert!(one.plausible);
        assert_eq!(
            one.sentence,
            "It is so; for a specific heat of 450 to 840 J/(kg K): (9.9 to 22)·10⁻⁶/K."
        );
    }

    #[test]
    fn a_shift_in_kelvins_shrinks_with_it_and_a_latent_heat_stays() {
        let mut one = finding(
            EffectId::FunctionalFatigue,
            estimate("K", -1.0, [-2.0, 0.5]),
        );
        HEAT.widen(&mut one);
        assert_ends(one.parameters[0].ci95, [-2.0 / 0.9, 0.5 / 0.9]);
        let latent = finding(EffectId::LatentHeat, estimate("J/kg", 15e3, [13e3, 17e3]));
        let mut widened = latent.clone();
        HEAT.widen(&mut widened);
        assert_eq!(widened, latent);
    }
}
