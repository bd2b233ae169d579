//! How what is known of the rod to a range only widens what is said of missing effects.

use identify::{Bounds, Fit, NITI_OHM_M, NITI_RANGE_OHM_M, Rod, WienerModel};
use missing_physics::{Candidate, Diagnosis, Finding, Status};
use recording::Quantity;
use sma_effects::EffectId;

use crate::report::number::spoken;

/// Widens the intervals of a diagnosis to hold for the whole range that the rod file gives the specific heat, and
/// says so in the sentences. Returns the range if there was anything to widen.
///
/// ```text
/// all temperature differences divided by c = C_p/C_p0 give the same displacement
/// ```
///
/// Sizes that do not scale with c keep their intervals: a latent heat, a time, a share.
pub fn carry_specific_heat(
    rod: &Rod,
    model: &WienerModel,
    diagnosis: &mut Diagnosis,
) -> Option<Bounds> {
    let (value, range) = (rod.specific_heat_j_per_kg_k?, rod.specific_heat_range?);
    if !model.carry_specific_heat(&mut diagnosis.baseline.fit) {
        return None;
    }
    let heat = Uncertain {
        said: format!(
            "a specific heat of {} to {} J/(kg K)",
            spoken(range.lower),
            spoken(range.upper)
        ),
        ends: [range.lower / value, range.upper / value],
        power: power_of_specific_heat,
    };
    heat.carry(diagnosis, |fit| {
        model.carry_specific_heat(fit);
    });
    Some(range)
}

/// Widens the intervals of a diagnosis to hold for the whole range of the resistivity that stands in for a missing
/// resistance. Sizes that are counted in watts scale with the power of the drive. Returns the range, Ω m, if there was
/// anything to widen.
pub fn carry_resistivity(rod: &Rod, diagnosis: &mut Diagnosis) -> Option<Bounds> {
    if !rod.assumes_resistivity() {
        return None;
    }
    let range = NITI_RANGE_OHM_M;
    let [lower, upper] = [range.lower / NITI_OHM_M, range.upper / NITI_OHM_M];
    let resistivity = Uncertain {
        said: format!(
            "a resistivity of {} to {} µΩ m, since the resistance is not given",
            spoken(1e6 * range.lower),
            spoken(1e6 * range.upper)
        ),
        // A current heats with it, a voltage with its inverse.
        ends: if rod.drive_kind == Quantity::Current {
            [lower, upper]
        } else {
            [1.0 / upper, 1.0 / lower]
        },
        power: |effect, _| i32::from(is_counted_in_watts(effect)),
    };
    let mut findings = diagnosis.findings.iter().chain(&diagnosis.suspects);
    let goes_with_it = findings.any(|finding| is_counted_in_watts(finding.effect));
    resistivity.carry(diagnosis, |_| ());
    goes_with_it.then_some(range)
}

/// A property of the rod that is known to a range only.
#[derive(Debug, Clone)]
struct Uncertain {
    /// As sentences say it.
    said: String,
    /// Ends of the range over the value that was counted with.
    ends: [f64; 2],
    /// Power of it with which a parameter of an effect, in a unit, scales at the same displacement.
    power: fn(Candidate, &str) -> i32,
}

impl Uncertain {
    /// Widens what a diagnosis says; `of_plain` what is the baseline model's in the extended fit.
    fn carry(&self, diagnosis: &mut Diagnosis, of_plain: impl Fn(&mut Fit)) {
        if let Some(extended) = &mut diagnosis.extended {
            of_plain(&mut extended.stage.fit);
            let effects = extended.effects.iter();
            let parameters = effects
                .flat_map(|effect| effect.info().parameters.iter().map(|one| (*effect, one)));
            for (effect, info) in parameters {
                let fitted = &mut extended.stage.fit.parameters;
                let Some(fitted) = fitted.iter_mut().find(|one| one.info.name == info.name) else {
                    continue;
                };
                for interval in fitted.intervals.iter_mut().flatten() {
                    let [lower, upper] =
                        self.widened(effect, info.unit, [interval.lower, interval.upper]);
                    *interval = Bounds { lower, upper };
                }
            }
        }
        for finding in diagnosis.findings.iter_mut().chain(&mut diagnosis.suspects) {
            self.widen(finding);
        }
        for entry in &mut diagnosis.catalogue {
            if let Status::Excluded { upper } = &mut entry.status {
                *upper = self.widened(entry.effect, entry.unit, [0.0, *upper])[1];
            }
        }
    }

    /// An interval that holds for the whole range.
    fn widened(&self, effect: Candidate, unit: &str, [lower, upper]: [f64; 2]) -> [f64; 2] {
        let power = (self.power)(effect, unit);
        let factors = self.ends.map(|end| end.powi(power));
        let end =
            |end: f64, choose: fn(f64, f64) -> f64| choose(end * factors[0], end * factors[1]);
        [end(lower, f64::min), end(upper, f64::max)]
    }

    fn widen(&self, finding: &mut Finding) {
        let effect = finding.effect;
        let mut said = Vec::new();
        for parameter in &mut finding.parameters {
            let Some(interval) = parameter.ci95 else {
                continue;
            };
            let [lower, upper] = self.widened(effect, parameter.unit, interval);
            if (self.power)(effect, parameter.unit) != 0 {
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
            "{}; for {}: {}.",
            finding.sentence.trim_end_matches('.'),
            self.said,
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
        "J/kg" => format!("{} kJ/kg", between(1e-3)),
        unit => format!("{} {unit}", between(1.0)),
    }
}

/// True if the size of an effect is that of a heat flow beside the power of the drive.
fn is_counted_in_watts(effect: Candidate) -> bool {
    matches!(
        effect.effect(),
        Some(EffectId::LatentHeat | EffectId::Radiation)
    )
}

/// Power of C_p with which a parameter scales at the same displacement.
fn power_of_specific_heat(effect: Candidate, unit: &str) -> i32 {
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

    fn heat() -> Uncertain {
        Uncertain {
            said: "a specific heat of 450 to 840 J/(kg K)".to_owned(),
            ends: [0.9, 1.68],
            power: power_of_specific_heat,
        }
    }

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
        heat().widen(&mut one);
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
        heat().widen(&mut one);
        assert_ends(one.parameters[0].ci95, [-2.0 / 0.9, 0.5 / 0.9]);
        let latent = finding(EffectId::LatentHeat, estimate("J/kg", 15e3, [13e3, 17e3]));
        let mut widened = latent.clone();
        heat().widen(&mut widened);
        assert_eq!(widened, latent);
    }

    #[test]
    fn a_heat_goes_with_the_power_and_is_said_in_its_unit() {
        let mut one = finding(EffectId::LatentHeat, estimate("J/kg", 15e3, [14e3, 16e3]));
        let resistivity = Uncertain {
            said: "a resistivity of 0.76 to 1.0 µΩ m".to_owned(),
            ends: [0.95, 1.25],
            power: |effect, _| i32::from(is_counted_in_watts(effect)),
        };
        resistivity.widen(&mut one);
        assert_ends(one.parameters[0].ci95, [0.95 * 14e3, 1.25 * 16e3]);
        assert_eq!(
            one.sentence,
            "It is so; for a resistivity of 0.76 to 1.0 µΩ m: 13 to 20 kJ/kg."
        );
        let lag = finding(EffectId::SupplyLag, estimate("s", 1.0, [0.9, 1.1]));
        let mut widened = lag.clone();
        resistivity.widen(&mut widened);
        assert_eq!(widened, lag);
    }
}
