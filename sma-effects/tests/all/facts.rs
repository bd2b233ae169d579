//! Facts about effects before any recording: whose they are, which ones are alike, and the prior of their sizes.

use sma_effects::{
    Belongs, EffectId, EffectInfo, EffectParameter, Occurrence, Presence, Role, Setting, Sign,
};

fn ids(wanted: impl Fn(&EffectInfo) -> bool) -> Vec<&'static str> {
    let all = EffectId::ALL.into_iter();
    all.filter(|effect| wanted(effect.info()))
        .map(EffectId::id)
        .collect()
}

fn parameters(wanted: impl Fn(&EffectParameter) -> bool) -> Vec<&'static str> {
    let all = EffectId::ALL.into_iter();
    all.flat_map(|effect| effect.info().parameters)
        .filter(|parameter| wanted(parameter))
        .map(|parameter| parameter.name)
        .collect()
}

fn parameter(name: &str) -> &'static EffectParameter {
    let mut all = EffectId::ALL
        .into_iter()
        .flat_map(|effect| effect.info().parameters);
    all.find(|parameter| parameter.name == name).unwrap()
}

#[test]
fn drifts_belong_to_a_recording_and_fatigue_has_a_history() {
    let of = |whose| ids(move |info| info.belongs_to == whose);
    assert_eq!(of(Belongs::Recording), ["ambient-drift", "sensor-drift"]);
    assert_eq!(of(Belongs::History), ["functional-fatigue"]);
    assert_eq!(
        ids(|info| !info.is_rigid()),
        [
            "ambient-drift",
            "loop-shape",
            "functional-fatigue",
            "sensor-drift"
        ]
    );
    let all = [Belongs::Rig, Belongs::Recording, Belongs::History];
    assert_eq!(all.map(Belongs::id), ["rig", "recording", "history"]);
}

#[test]
fn every_rod_has_a_heat_of_transformation_losses_and_expansion() {
    assert_eq!(
        ids(EffectInfo::in_every_rod),
        [
            "latent-heat",
            "radiation",
            "natural-convection",
            "thermal-expansion"
        ]
    );
    assert!(Presence::EveryRod.ln_odds().abs() <= 0.0);
    let to_one = (-Presence::Seldom.ln_odds()).exp();
    assert!((to_one - 20.0).abs() < 0.1, "{to_one}");
}

#[test]
fn likeness_is_that_of_groups() {
    let alike = |effect: EffectId| effect.info().acts_like;
    for effect in EffectId::ALL {
        assert!(!alike(effect).contains(&effect), "{effect}");
        for &other in alike(effect) {
            assert!(alike(other).contains(&effect), "{effect} {other}");
            for &third in alike(other) {
                let is_alike = third == effect || alike(effect).contains(&third);
                assert!(is_alike, "{effect} {other} {third}");
            }
        }
    }
    assert_eq!(
        ids(|info| !info.acts_like.is_empty()),
        [
            "supply-lag",
            "dead-time",
            "radiation",
            "natural-convection",
            "ambient-drift",
            "functional-fatigue",
            "output-lag"
        ]
    );
}

#[test]
fn what_waits_for_a_reversal_says_so() {
    let needing = |occurrence| ids(move |info| info.needs_in_recording.contains(&occurrence));
    for (occurrence, name, effects) in [
        (
            Occurrence::FollowedLevels,
            "followed-levels",
            ["supply-limit"],
        ),
        (Occurrence::Cooling, "cooling", ["r-phase"]),
        (
            Occurrence::BothBranches,
            "both-branches",
            ["loop-asymmetry"],
        ),
        (Occurrence::Reversal, "reversal", ["backlash"]),
        (
            Occurrence::InnerReversals,
            "inner-reversals",
            ["return-point-memory"],
        ),
        (
            Occurrence::SecondCycle,
            "second-cycle",
            ["functional-fatigue"],
        ),
    ] {
        assert_eq!(needing(occurrence), effects);
        assert_eq!(occurrence.id(), name);
    }
}

#[test]
fn facts_of_single_effects() {
    assert_eq!(ids(|info| info.costly), ["end-conduction"]);
    assert_eq!(ids(|info| info.names_loop_families), ["loop-shape"]);
    // Beside another loop they may be an error of its formula.
    assert_eq!(
        ids(|info| info.like_loop),
        [
            "return-point-memory",
            "loop-shape",
            "stress-coupling",
            "loop-asymmetry",
            "r-phase",
            "thermal-expansion",
            "end-stop",
            "backlash",
            "sensor-nonlinearity",
        ]
    );
    assert_eq!(ids(EffectInfo::is_of_sensor), ["thermocouple-lag"]);
    assert_eq!(
        ids(|info| info.settled_by_ambient_record),
        ["ambient-drift"]
    );
    let mean = EffectId::AmbientDrift.info().mean_acts_as.unwrap();
    assert_eq!(mean.parameter, "loop_center_degc");
    assert!((mean.per_unit + 1.0).abs() <= 0.0);
    assert_eq!(ids(|info| info.mean_acts_as.is_some()), ["ambient-drift"]);
}

#[test]
fn upper_bounds_that_are_ends() {
    assert_eq!(
        parameters(|parameter| parameter.upper_is_physical),
        [
            "supply_limit_share",
            "dead_time_output_share",
            "contact_ratio",
            "clamp_warming",
            "clamp_s",
            "return_point_share",
            "end_stop_share",
            "backlash_relaxed"
        ]
    );
}

#[test]
fn sizes_scale_with_the_specific_heat_as_their_units_do() {
    for effect in EffectId::ALL {
        for parameter in effect.info().parameters {
            let expected = match (effect, parameter.unit) {
                (EffectId::Radiation, _) => 2,
                (_, "K") => -1,
                (_, "1/K") => 1,
                _ => 0,
            };
            let name = parameter.name;
            assert_eq!(parameter.power_of_specific_heat, expected, "{name}");
        }
    }
    assert_eq!(
        parameters(|parameter| parameter.scales_with_power),
        ["latent_heat_j_per_kg", "emissivity"]
    );
}

#[test]
fn literature_lies_within_the_bounds() {
    for effect in EffectId::ALL {
        for parameter in effect.info().parameters {
            let Some(literature) = parameter.literature else {
                continue;
            };
            let [lower, upper] = literature.range;
            let name = parameter.name;
            assert!(lower > 0.0 && lower < upper, "{name}");
            assert!(
                parameter.accepts(lower) && parameter.accepts(upper),
                "{name}"
            );
            assert!(parameter.role == Role::Size, "{name}");
            assert!(parameter.prior().ordinary() >= parameter.typical, "{name}");
        }
    }
}

#[test]
fn what_is_ordinary_costs_nothing_and_what_is_larger_ever_more() {
    for effect in EffectId::ALL {
        for parameter in effect.info().parameters {
            let name = parameter.name;
            let [lower, upper] = parameter.bounds;
            let mut before = 0.0;
            for step in 0..=1000 {
                let value = upper * f64::from(step) / 1000.0;
                if value < lower {
                    continue;
                }
                let here = parameter.ln_prior(value);
                assert!(here <= before && here.is_finite(), "{name} {value} {here}");
                if value > parameter.prior().ordinary() {
                    assert!(here < before, "{name} {value} {here}");
                }
                before = here;
                if parameter.sign() == Sign::Either && parameter.role == Role::Size {
                    let there = parameter.ln_prior(-value);
                    assert!((there - here).abs() <= 0.0, "{name} {value}");
                }
            }
            let ordinary = [parameter.neutral(), parameter.typical];
            for value in ordinary
                .into_iter()
                .filter(|&value| parameter.accepts(value))
            {
                assert!(parameter.ln_prior(value).abs() <= 0.0, "{name} {value}");
            }
            for outside in [
                lower - 1e-9 - 1e-9 * lower.abs(),
                upper + 1e-9 * upper,
                f64::NAN,
                f64::INFINITY,
            ] {
                let there = parameter.ln_prior(outside);
                assert!(there < 0.0 && there.is_infinite(), "{name} {outside}");
            }
            // No narrower than what is ordinary, no wider than the bounds.
            let width = parameter.ln_prior_width().exp();
            assert!(width <= (upper - lower) * (1.0 + 1e-12), "{name} {width}");
            let least = parameter.prior().ordinary().min(upper - lower);
            assert!(width >= least * (1.0 - 1e-12), "{name} {width}");
        }
    }
}

#[test]
fn a_bow_ten_times_what_data_sheets_say_costs_more_than_an_ordinary_stress() {
    let bow = parameter("sensor_nonlinearity_quadratic").ln_prior(0.05);
    let stress = parameter("stress_shift_k").ln_prior(10.0);
    assert!(bow < -8.0 && stress.abs() <= 0.0, "{bow} {stress}");
    // What noise adds to an exponent of 1/3, and a heat above the calorimetry's, cost little.
    assert!(parameter("convection_exponent").ln_prior(1.0 / 3.0) > -1.5);
    assert!(parameter("latent_heat_j_per_kg").ln_prior(45e3) > -1.5);
}

#[test]
fn a_curve_counts_once_and_different_sizes_each() {
    let drift = EffectId::AmbientDrift.info();
    let knot = drift.parameters[0].ln_prior(10.0);
    let of_curve = drift.ln_prior(&[10.0, 9.0, 8.0, 10.0, -10.0, 0.0, 1.0, 2.0]);
    assert!(knot < -1.0 && (of_curve - knot).abs() <= 0.0);

    let fatigue = EffectId::FunctionalFatigue.info();
    let [shift, loss, fading] = fatigue.parameters else {
        panic!("three parameters");
    };
    let sum = shift.ln_prior(4.5) + loss.ln_prior(0.15) + fading.ln_prior(0.9);
    let of_effect = fatigue.ln_prior(&[4.5, 0.15, 0.9]);
    assert!(sum < -1.0 && (of_effect - sum).abs() < 1e-12);

    let lost = f64::NEG_INFINITY;
    assert_eq!(
        fatigue.ln_prior(&[0.0, 0.0, 1.1]).total_cmp(&lost),
        core::cmp::Ordering::Equal
    );
    assert_eq!(
        fatigue.ln_prior(&[0.0, 0.0]).total_cmp(&lost),
        core::cmp::Ordering::Equal
    );
    assert_eq!(
        drift.ln_prior(&[f64::NAN; 8]).total_cmp(&lost),
        core::cmp::Ordering::Equal
    );
}

#[test]
fn an_expansion_without_a_length_is_less_surprising() {
    let expansion = parameter("expansion_per_k");
    let unknown = Setting::default();
    let known = Setting {
        length_output: Some(100.0),
        ..Setting::default()
    };
    let at = |setting: &Setting| setting.prior_of(expansion).ln_relative(2e-5);
    assert!(at(&known) < at(&unknown) - 2.0 && at(&unknown) < 0.0);
    assert_eq!(known.prior_of(expansion), expansion.prior());
}
