//! Each rule decides something: populations made up so that one statistic is on either side of its threshold.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::known::{Known, Oddness};
use super::leading;
use super::names::most_of_formula;
use super::rules::{RULES, RuleId};
use super::said::Verdict;
use super::trace::Traces;
use super::verdict::Decided;
use crate::evidence::{Anonymous, Audit, Evidence, Model, Population};
use crate::{CandidateSet, EffectId, LoopFamily};

pub(super) const N: usize = 1600;
const BLOCKS: usize = 16;

pub(super) fn noise(deviation: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..N)
        .map(|_| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            deviation * normal
        })
        .collect()
}

/// A trace of mean square `size`², and of another shape for another seed.
pub(super) fn trace(size: f64, seed: u64) -> Vec<f64> {
    let mut smooth = noise(1.0, 100 + seed);
    for k in 1..N {
        smooth[k] = 0.95 * smooth[k - 1] + (1.0_f64 - 0.95 * 0.95).sqrt() * smooth[k];
    }
    let square = smooth.iter().map(|s| s * s).sum::<f64>() / N as f64;
    smooth.iter().map(|s| s * size / square.sqrt()).collect()
}

pub(super) fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// White noise of whatever size the residual has.
fn evidence(residual: Vec<f64>) -> Evidence {
    let variance = residual.iter().map(|e| e * e).sum::<f64>() / N as f64;
    let blocks = || residual.chunks(N / BLOCKS);
    let square = |block: &[f64]| block.iter().map(|e| e * e).sum::<f64>();
    Evidence {
        nats: blocks()
            .map(|block| -0.5 * block.len() as f64 * variance.ln() - 0.5 * square(block) / variance)
            .collect(),
        squares: blocks().map(|block| [square(block), 0.0]).collect(),
        n_outputs: N,
        residual,
    }
}

pub(super) fn model(names: &[EffectId], residual: Vec<f64>, with_curve: Vec<f64>) -> Model {
    let names: CandidateSet = names.iter().map(|&name| name.into()).collect();
    let (evidence, curve) = (evidence(residual), evidence(with_curve));
    let left = |evidence: &Evidence| evidence.squares()[0];
    let share = 1.0 - left(&curve) / left(&evidence);
    let odds = names.iter().map(|name| name.info().presence.ln_odds());
    Model {
        family: LoopFamily::Proximity,
        effects: names,
        names,
        ln_prior: odds.sum(),
        pressed: CandidateSet::EMPTY,
        slight: CandidateSet::EMPTY,
        anonymous: Some(Anonymous {
            audit: Audit {
                share,
                share_at_most: share,
                p_value: if share > 0.0 { 0.001 } else { 1.0 },
            },
            evidence: curve,
        }),
        evidence,
    }
}

/// As noise leaves it.
const NOISE: Oddness = Oddness {
    tone: 0.0,
    slowness: 1.0,
};

pub(super) fn known() -> Known {
    Known {
        segments: std::iter::once(0..N).collect(),
        output_squares: 1e4 * N as f64,
        temperature_squares: 0.0,
        rounding: 0.0,
        of_drive: 0.0,
        catalogue: EffectId::ALL.into_iter().map(Into::into).collect(),
        untried: CandidateSet::EMPTY,
        disturbed: 0.0,
        left: NOISE,
        left_by_plain: NOISE,
        slip: None,
        elsewhere: Vec::new(),
        seed: 1,
    }
}

/// Noise of 1, what a lag leaves of `size`, a curve that finds three quarters of that where there is no lag, and `beside` the lag
/// another trace that only a curve finds.
fn with_lag(size: f64, beside: f64) -> Population {
    let quiet = noise(1.0, 1);
    let (lag, other) = (trace(size, 1), trace(beside, 2));
    let half: Vec<f64> = lag.iter().map(|s| 0.5 * s).collect();
    let rest = sum(&quiet, &other);
    // What a curve takes of noise.
    let worse = |series: &[f64]| sum(series, &noise(0.1, 7));
    let left_by_curve = if beside > 0.0 {
        quiet.clone()
    } else {
        worse(&quiet)
    };
    Population {
        models: vec![
            model(&[], sum(&rest, &lag), sum(&left_by_curve, &half)),
            model(&[EffectId::OutputLag], rest, left_by_curve),
        ],
    }
}

fn nothing() -> Population {
    let quiet = noise(1.0, 1);
    Population {
        models: vec![model(&[], quiet.clone(), sum(&quiet, &noise(0.1, 7)))],
    }
}

fn decide(population: &Population, known: &Known) -> Decided {
    super::verdict::decide(population, known, Traces::default())
}

fn named(decided: &Decided) -> Vec<&str> {
    decided.named.iter().map(|one| one.effect.id()).collect()
}

#[test]
fn a_name_that_beats_the_curve_holds() {
    let decided = decide(&with_lag(3.0, 0.0), &known());
    assert_eq!(decided.verdict, Verdict::Explained);
    assert_eq!(named(&decided), ["output-lag"]);
    assert!(decided.named[0].probability > 0.99);
    // All that could be explained comes back without it.
    assert!((decided.named[0].contribution - 1.0).abs() < 0.02);
    // No shift of 9,999 does as well, and each other name was tried in its place.
    let of_own = decided.traces.steps.iter();
    let mut of_own = of_own.filter(|step| step.rule.id == RuleId::Own);
    let own = of_own.next().unwrap();
    let expected = known().tried_beside(CandidateSet::EMPTY) as f64 * 1e-4;
    assert!((own.value - expected).abs() < 1e-12, "{}", own.value);
}

#[test]
fn where_nothing_is_left_nothing_is_missing() {
    assert_eq!(decide(&nothing(), &known()).verdict, Verdict::Adequate);
}

#[test]
fn a_name_that_loses_to_the_curve_does_not_hold() {
    let mut population = with_lag(3.0, 0.0);
    // The lag takes a third of what is there, the curve all but a quarter.
    let lag: Vec<f64> = trace(3.0, 1).iter().map(|s| 0.8 * s).collect();
    let residual = sum(&noise(1.0, 1), &lag);
    population.models[1] = model(&[EffectId::OutputLag], residual.clone(), residual);
    let decided = decide(&population, &known());
    assert_eq!(decided.verdict, Verdict::Unexplained);
    assert!(named(&decided).is_empty());
}

#[test]
fn what_is_left_is_that_of_all_that_lead_though_one_of_them_is_a_suspect() {
    let mut population = with_lag(3.0, 0.0);
    let left = |share: f64| {
        let rest = sum(&noise(1.0, 1), &trace(share, 2));
        let with_curve = sum(&rest, &noise(0.1, 7));
        (rest, with_curve)
    };
    let both = [EffectId::OutputLag, EffectId::EndStop];
    for (names, (rest, with_curve)) in [(&both[..1], left(0.10)), (&both[..], left(0.0))] {
        population.models.push(model(names, rest, with_curve));
    }
    population.models.remove(1);
    let decided = decide(&population, &known());
    let suspects: Vec<&str> = decided.suspects.iter().map(|one| one.effect.id()).collect();
    assert_eq!(named(&decided), ["output-lag"]);
    assert_eq!(suspects, ["end-stop"]);
    assert_eq!(decided.verdict, Verdict::Explained);
}

#[test]
fn two_names_that_do_as_well_are_one_set() {
    let mut population = with_lag(3.0, 0.0);
    let twin = population.models[1].evidence.residual.clone();
    population
        .models
        .push(model(&[EffectId::DeadTime], twin.clone(), twin));
    let decided = decide(&population, &known());
    assert_eq!(decided.verdict, Verdict::Ambiguous);
    let found = &decided.named[0];
    assert_eq!(found.others.len(), 1);
    assert!((0.3..0.7).contains(&found.probability), "{found:?}");
}

#[test]
fn a_curve_alone_may_do_better_by_a_hundredth_of_what_it_explains() {
    let held = |lag: f64, of_noise: f64| {
        let mut population = with_lag(lag, 0.0);
        let left = population.models[1].evidence.squares.iter();
        let left = left.map(|block| block.map(|square| of_noise * square));
        let left = left.collect();
        let curve = population.models[0].anonymous.as_mut().unwrap();
        curve.evidence.squares = left;
        named(&decide(&population, &known())).len()
    };
    // The lag leaves a mean square of 1; a hundredth of what a curve explains is half of that.
    assert_eq!(held(7.0, 0.6), 1);
    assert_eq!(held(7.0, 0.4), 0);
    // Here it is a hundredth.
    assert_eq!(held(1.0, 0.995), 1);
    assert_eq!(held(1.0, 0.98), 0);
}

/// Names that lead where surroundings that drift leave a four-hundredth of the mean square, fatigue the share `left` of the root
/// mean square, and both nothing; beside latent heat, without which as much as `beside` times all that is left.
fn led_with_fatigue_leaving(left: f64, beside: f64) -> CandidateSet {
    let quiet = noise(1.0, 1);
    let leaves = |share: f64, of_heat: f64| {
        let known = sum(&trace(10.0 * share, 1), &trace(10.0 * of_heat, 2));
        let rest = sum(&quiet, &known);
        let with_curve = sum(&rest, &noise(0.1, 7));
        (rest, with_curve)
    };
    let all = [
        EffectId::LatentHeat,
        EffectId::AmbientDrift,
        EffectId::FunctionalFatigue,
    ];
    let shares: [(&[EffectId], f64); 4] = [
        (&[], 1.0),
        (&all[1..2], 0.05),
        (&all[2..], left),
        (&all[1..], 0.0),
    ];
    let with_and_without_heat = shares.into_iter().flat_map(|(names, share)| {
        [(&all[..0], beside), (&all[..1], 0.0)].map(|(heat, of_heat)| {
            let (rest, with_curve) = leaves(share, of_heat);
            model(&[heat, names].concat(), rest, with_curve)
        })
    });
    leading(&Population {
        models: with_and_without_heat.collect(),
    })
    .names
}

#[test]
fn what_does_nearly_all_of_a_drifts_work_stays_beside_it() {
    let drift: CandidateSet = [EffectId::AmbientDrift.into()].into_iter().collect();
    let both = drift.with(EffectId::FunctionalFatigue);
    assert_eq!(led_with_fatigue_leaving(0.3, 0.0), both);
    assert_eq!(led_with_fatigue_leaving(0.33, 0.0), drift);
    // Nearly all of what the two explain, which is half of everything.
    let heat = EffectId::LatentHeat;
    assert_eq!(led_with_fatigue_leaving(0.3, 1.0), both.with(heat));
    assert_eq!(led_with_fatigue_leaving(0.4, 1.0), drift.with(heat));
}

#[test]
fn a_law_that_does_as_well_as_a_drift_leads() {
    use EffectId::{AmbientDrift, LoopShape, SupplyLag};
    let leads = |behind: f64| {
        let (quiet, lost) = (noise(1.0, 1), trace(3.0, 1));
        let without = sum(&quiet, &lost);
        let worse = |series: &[f64]| sum(series, &noise(0.1, 7));
        let far = sum(&without, &trace(20.0, 2));
        let mut models = vec![
            model(&[], far, worse(&without)),
            model(&[LoopShape], without.clone(), worse(&without)),
            model(&[LoopShape, AmbientDrift], quiet.clone(), worse(&quiet)),
            model(&[LoopShape, SupplyLag], quiet.clone(), worse(&quiet)),
        ];
        models[3].ln_prior = models[2].ln_prior - behind;
        leading(&Population { models }).names
    };
    let beside_the_loop = |effect: EffectId| CandidateSet::of(LoopShape).with(effect);
    assert_eq!(leads(2.9), beside_the_loop(SupplyLag));
    assert_eq!(leads(3.1), beside_the_loop(AmbientDrift));
}

#[test]
fn beside_another_loop_what_acts_like_one_may_be_its_formula_unless_it_is_large() {
    let of = |family: LoopFamily, effect: EffectId, beside: &[EffectId], over: f64| {
        let (quiet, lost) = (noise(1.0, 1), trace(3.0, 1));
        let (without, of_loop) = (sum(&quiet, &lost), trace(20.0, 2));
        let worse = |series: &[f64]| sum(series, &noise(0.1, 7));
        let all = [beside, &[effect]].concat();
        let mut models = vec![
            model(&[], sum(&without, &of_loop), worse(&without)),
            model(beside, without.clone(), worse(&without)),
            model(&all, quiet.clone(), worse(&quiet)),
        ];
        if beside.is_empty() {
            models.remove(0);
        }
        models.iter_mut().for_each(|one| one.family = family);
        let [less, with] = [1, 0].map(|back| models[models.len() - 1 - back].evidence.squares()[0]);
        let known = Known {
            output_squares: (less - with) / (most_of_formula(family) * over).powi(2),
            ..known()
        };
        let decided = decide(&Population { models }, &known);
        let own = decided.named.iter().find(|one| one.effect == effect);
        let others = own.map(|one| one.others.iter().map(|(other, _)| other.id()).collect());
        (decided.verdict, others.unwrap_or_else(Vec::new))
    };
    let verdict = |effect: EffectId, beside: &[EffectId], over: f64| {
        of(LoopFamily::Relays, effect, beside, over)
    };
    let shape = &[EffectId::LoopShape];
    let alone = (Verdict::Explained, Vec::new());
    let may_be = (Verdict::Ambiguous, vec!["loop-shape"]);
    for family in [LoopFamily::Relays, LoopFamily::Kinetics] {
        assert_eq!(of(family, EffectId::Backlash, shape, 0.98), may_be);
        assert_eq!(of(family, EffectId::Backlash, shape, 1.02), alone);
    }
    // A curve of time takes what it can of any error.
    let drift = |over: f64| verdict(EffectId::SensorDrift, shape, over).1;
    assert_eq!(drift(0.98), ["loop-shape"]);
    assert!(drift(1.02).is_empty());
    // It is no matter of the loop, or stands beside the baseline's.
    assert_eq!(verdict(EffectId::OutputLag, shape, 0.98), alone);
    assert_eq!(verdict(EffectId::Backlash, &[], 0.98), alone);
}

#[test]
fn a_remainder_is_said_from_the_error_of_a_formula_on() {
    // A hundredth of the explainable square, and less.
    let in_part = decide(&with_lag(3.0, 0.5), &known());
    assert_eq!(in_part.verdict, Verdict::ExplainedInPart);
    let whole = decide(&with_lag(30.0, 0.5), &known());
    assert_eq!(whole.verdict, Verdict::Explained);
}

#[test]
fn what_does_not_go_with_the_recordings_has_no_name() {
    let mut population = with_lag(3.0, 0.0);
    // Likelier, but what it adds is not in what is left without it.
    let unrelated = sum(&population.models[0].evidence.residual, &trace(3.0, 9));
    population.models[1].evidence.residual = unrelated;
    let decided = decide(&population, &known());
    assert!(named(&decided).is_empty());
    // What only a suspect explains is not explained.
    assert_eq!(decided.verdict, Verdict::Unexplained);
    let traces = &decided.traces.steps;
    let own = traces.iter().find(|trace| trace.rule.id == RuleId::Own);
    assert!(own.is_some_and(|trace| !trace.passed));
}

/// Verdicts of a population where one thing is known, below and above a threshold.
fn around(population: &Population, id: RuleId, set: impl Fn(&mut Known, f64)) -> [Verdict; 2] {
    [0.98, 1.02].map(|factor| {
        let mut known = known();
        set(&mut known, factor * id.rule().threshold);
        decide(population, &known).verdict
    })
}

/// Statistic of a rule that was asked of the whole.
fn asked(population: &Population, known: &Known, id: RuleId) -> f64 {
    let steps = decide(population, known).traces.steps;
    let mut of_rule = steps.iter().filter(|trace| trace.rule.id == id);
    of_rule.next().map_or(f64::NAN, |trace| trace.value)
}

#[test]
fn the_statistics_of_a_verdict_are_what_they_are_called() {
    // Of the output's variance, four times the noise, the best model leaves a quarter; of none there is no share.
    let small = Known {
        output_squares: 4.0 * N as f64,
        ..known()
    };
    let share = asked(&with_lag(3.0, 0.0), &small, RuleId::Describes);
    assert!((share - 0.75).abs() < 0.02, "{share}");
    let none = Known {
        output_squares: 0.0,
        ..known()
    };
    let share = asked(&nothing(), &none, RuleId::Describes);
    assert!(share.abs() <= 0.0, "{share}");
    // A baseline model is sure of itself where a curve finds nothing, and impossible where one, or a name, finds all.
    let curve_finds = Population {
        models: vec![model(
            &[],
            sum(&noise(1.0, 1), &trace(3.0, 1)),
            noise(1.0, 1),
        )],
    };
    for (population, expected) in [
        (nothing(), 1.0),
        (curve_finds, 0.0),
        (with_lag(3.0, 0.0), 0.0),
    ] {
        let plain = asked(&population, &known(), RuleId::Missing);
        assert!((plain - expected).abs() < 0.05, "{plain} for {expected}");
    }
    // Beside a lag that explains all no curve is needed, beside one that does not one is.
    for (beside, expected) in [(0.0, 0.0), (3.0, 1.0)] {
        let needed = asked(&with_lag(3.0, beside), &known(), RuleId::Remainder);
        assert!((needed - expected).abs() < 0.05, "{needed} for {expected}");
    }
}

#[test]
fn a_plain_model_that_predicts_too_little_describes_nothing() {
    let population = nothing();
    let left = population.plain().evidence.squares()[0];
    let found = around(&population, RuleId::Describes, |known, share| {
        known.output_squares = left / (1.0 - share);
    });
    assert_eq!(found, [Verdict::Unexplained, Verdict::Adequate]);
}

#[test]
fn what_shows_in_temperatures_alone_matters_by_more_than_a_thermometer_is_exact_to() {
    // The output is the same with and without it, and temperatures differ.
    let found = |over: f64| {
        let quiet = noise(1.0, 1);
        let curve = || sum(&quiet, &noise(0.1, 7));
        let mut models = vec![
            model(&[], quiet.clone(), curve()),
            model(&[EffectId::ThermocoupleLag], quiet.clone(), curve()),
        ];
        let missed = 100.0;
        models[0].evidence.squares[0][1] = missed;
        models[1].ln_prior = 100.0;
        let known = Known {
            temperature_squares: missed / (0.015 * over).powi(2),
            ..known()
        };
        let steps = decide(&Population { models }, &known).traces.steps;
        let mut matters = steps
            .iter()
            .filter(|trace| trace.rule.id == RuleId::Matters);
        matters
            .find(|trace| trace.of == "thermocouple-lag")
            .map(|trace| trace.passed)
    };
    assert_eq!([0.98, 1.02].map(found), [Some(false), Some(true)]);
}

#[test]
fn what_is_smaller_than_rounding_has_no_name() {
    let population = with_lag(1.0, 0.0);
    let lost = |names: usize| population.models[names].evidence.squares()[0] / N as f64;
    let found = around(&population, RuleId::Matters, |known, over| {
        known.rounding = (lost(0) - lost(1)) / over.powi(2);
    });
    assert_ne!(found[0], Verdict::Explained);
    assert_eq!(found[1], Verdict::Explained);
}

#[test]
fn what_is_less_than_any_formula_is_exact_to_has_no_name() {
    let population = with_lag(1.0, 0.0);
    let squares = |names: usize| population.models[names].evidence.squares()[0];
    let found = around(&population, RuleId::Matters, |known, share| {
        known.output_squares = (squares(0) - squares(1)) / (1e-3 * share).powi(2);
    });
    assert_eq!(found, [Verdict::Adequate, Verdict::Explained]);
}

#[test]
fn what_matters_on_recordings_that_were_not_used_has_a_name() {
    let population = with_lag(1.0, 0.0);
    let squares = |names: usize| population.models[names].evidence.squares()[0];
    let small = Known {
        output_squares: 2e6 * (squares(0) - squares(1)),
        ..known()
    };
    let lag = population.models[1].names.iter().next().unwrap();
    let least = small.least_that_matters(N);
    let found = [0.9, 1.1].map(|over: f64| {
        let elsewhere = vec![(lag, (over * least).powi(2))];
        let known = Known {
            elsewhere,
            ..small.clone()
        };
        decide(&population, &known).verdict
    });
    assert_ne!(found[0], Verdict::Explained);
    assert_eq!(found[1], Verdict::Explained);
}

#[test]
fn the_baseline_model_has_a_verdict_of_its_own() {
    let nameless = |population: &Population, known: &Known| decide(population, known).nameless;
    assert_eq!(nameless(&nothing(), &known()), Verdict::Adequate);
    // A lag is left, though it has a name.
    let with_lag = with_lag(3.0, 0.0);
    assert_eq!(decide(&with_lag, &known()).verdict, Verdict::Explained);
    assert_eq!(nameless(&with_lag, &known()), Verdict::Unexplained);
    let odd = Known {
        disturbed: 1.0,
        ..known()
    };
    assert_eq!(nameless(&nothing(), &odd), Verdict::Unexplained);
    let unlike = Known {
        output_squares: N as f64,
        ..known()
    };
    assert_eq!(nameless(&nothing(), &unlike), Verdict::Unexplained);
}

#[test]
fn a_share_is_explained_where_something_leads() {
    assert_eq!(decide(&nothing(), &known()).explained, None);
    let explained = decide(&with_lag(3.0, 0.0), &known()).explained;
    assert!(explained.is_some_and(|share| share > 0.95), "{explained:?}");
}

#[test]
fn what_follows_the_state_or_has_a_tone_is_no_noise() {
    let disturbed = around(&nothing(), RuleId::Disturbed, |known, share| {
        known.disturbed = share
    });
    assert_eq!(disturbed, [Verdict::Adequate, Verdict::Unexplained]);
    let tone = around(&nothing(), RuleId::Tone, |known, tone| {
        known.left_by_plain.tone = tone;
    });
    assert_eq!(tone, [Verdict::Adequate, Verdict::Unexplained]);
    let slow = around(&nothing(), RuleId::Slow, |known, over| {
        known.left_by_plain.slowness = over;
    });
    assert_eq!(slow, [Verdict::Adequate, Verdict::Unexplained]);
    let beside_a_name = around(&with_lag(3.0, 0.0), RuleId::Slow, |known, over| {
        known.left.slowness = over;
    });
    let expected = [Verdict::Explained, Verdict::ExplainedInPart];
    assert_eq!(beside_a_name, expected);
}

/// Names of the leading model where a small effect, a thousandth in its square, stands beside a large one; `left` is the size of what
/// only a curve finds beside both.
fn led_by(large: EffectId, small: EffectId, left: f64) -> Vec<&'static str> {
    let quiet = noise(1.0, 1);
    let (of_large, of_small) = (trace(30.0, 1), trace(1.0, 2));
    let rest = sum(&quiet, &trace(left, 3));
    let with_curve = sum(&quiet, &noise(0.1, 7));
    let with = |names: &[EffectId], more: &[&Vec<f64>]| {
        let residual = more.iter().fold(rest.clone(), |all, one| sum(&all, one));
        model(names, residual, with_curve.clone())
    };
    let population = Population {
        models: vec![
            with(&[], &[&of_large, &of_small]),
            with(&[large], &[&of_small]),
            with(&[small], &[&of_large]),
            with(&[large, small], &[]),
        ],
    };
    let names = leading(&population).names;
    names.iter().map(|name| name.id()).collect()
}

#[test]
fn a_small_effect_is_told_beside_what_it_cannot_be_an_error_of() {
    use EffectId::{AmbientDrift, Backlash, FunctionalFatigue, LoopShape, OutputLag};
    // A curve of time knows nothing of where the rod is.
    let beside_a_drift = ["ambient-drift", "backlash"];
    assert_eq!(led_by(AmbientDrift, Backlash, 0.0), beside_a_drift);
    assert_eq!(led_by(AmbientDrift, Backlash, 1.0), beside_a_drift);
    // A fatigue may be what its values miss.
    let alone = ["ambient-drift"];
    assert_eq!(led_by(AmbientDrift, FunctionalFatigue, 1.0), alone);
    // A play may be an error of the loop's curves unless it is all of that, a lag is none if nothing is left with it.
    assert_eq!(led_by(LoopShape, Backlash, 0.0), ["loop-shape", "backlash"]);
    assert_eq!(led_by(LoopShape, Backlash, 1.0), ["loop-shape"]);
    assert_eq!(
        led_by(LoopShape, OutputLag, 0.0),
        ["loop-shape", "output-lag"]
    );
    assert_eq!(led_by(LoopShape, OutputLag, 1.0), ["loop-shape"]);
}

#[test]
fn what_takes_nearly_all_that_is_left_is_told_beside_what_it_does_not_act_like() {
    // A small effect that leaves so much of a small error beside a large one, and a curve in its place.
    let names = |both: [EffectId; 2], by_small: f64, by_curve: f64| {
        let quiet = noise(1.0, 1);
        let (of_large, error) = (trace(30.0, 1), trace(1.0, 2));
        let leaving = |share: f64| {
            let left: Vec<f64> = error.iter().map(|e| share * e).collect();
            sum(&quiet, &left)
        };
        let population = Population {
            models: vec![
                model(&[], sum(&leaving(1.0), &of_large), quiet.clone()),
                model(&both[..1], leaving(1.0), leaving(by_curve)),
                model(&both, leaving(by_small), quiet.clone()),
            ],
        };
        let names = leading(&population).names;
        names.iter().map(|name| name.id()).collect::<Vec<_>>()
    };
    let loop_and_play = [EffectId::LoopShape, EffectId::Backlash];
    let heat_and_lag = [EffectId::LatentHeat, EffectId::OutputLag];
    for both in [loop_and_play, heat_and_lag] {
        let told = both.map(EffectId::id);
        assert_eq!(names(both, 0.3, 0.5), told);
        assert_eq!(names(both, 0.33, 0.5), told[..1]);
        assert_eq!(names(both, 0.2, 0.1), told[..1]);
    }
    // The error of a formula of radiation is like convection.
    let alike = [EffectId::NaturalConvection, EffectId::Radiation];
    assert_eq!(names(alike, 0.3, 0.5), [EffectId::NaturalConvection.id()]);
}

#[test]
fn two_that_act_like_a_loop_may_be_one_error_of_its_formula() {
    let quiet = noise(1.0, 1);
    let (of_loop, play, bow) = (trace(30.0, 1), trace(1.0, 2), trace(1.0, 3));
    let all = [
        EffectId::LoopShape,
        EffectId::Backlash,
        EffectId::SensorNonlinearity,
    ];
    let names = |second: EffectId| {
        let all = [all[0], all[1], second];
        let beside = [
            sum(&sum(&quiet, &play), &bow),
            sum(&quiet, &bow),
            quiet.clone(),
        ];
        let plain = model(&[], sum(&beside[0], &of_loop), quiet.clone());
        let models = beside.iter().enumerate().map(|(n, left)| {
            // A curve finds half of what is left.
            let by_curve: Vec<f64> = left
                .iter()
                .zip(&quiet)
                .map(|(left, quiet)| 0.5 * (left + quiet))
                .collect();
            model(&all[..=n], left.clone(), by_curve)
        });
        let mut models: Vec<Model> = std::iter::once(plain).chain(models).collect();
        models.push(model(
            &[all[0], all[2]],
            sum(&quiet, &play),
            sum(&quiet, &play.iter().map(|s| 0.5 * s).collect::<Vec<_>>()),
        ));
        let names = leading(&Population { models }).names;
        names.iter().map(|name| name.id()).collect::<Vec<_>>()
    };
    assert_eq!(names(all[2]), ["loop-shape"]);
    // A lag does not act like a loop.
    assert_eq!(
        names(EffectId::OutputLag),
        ["loop-shape", "backlash", "output-lag"]
    );
}

#[test]
fn what_was_ambiguous_by_a_name_that_falls_is_explained() {
    let mut found = decide(&with_lag(3.0, 0.0), &known());
    assert_eq!(found.verdict, Verdict::Explained);
    let mut second = found.named[0].clone();
    second.effect = EffectId::Backlash.into();
    second.others = vec![(EffectId::EndStop.into(), 0.5)];
    found.named.push(second);
    found.verdict = Verdict::Ambiguous;
    found.fall(CandidateSet::EMPTY);
    assert_eq!(found.verdict, Verdict::Ambiguous);
    found.fall(CandidateSet::of(EffectId::Backlash));
    assert_eq!((found.verdict, found.named.len()), (Verdict::Explained, 1));
    assert_eq!(found.suspects.len(), 1);
    found.fall(CandidateSet::of(EffectId::OutputLag));
    assert_eq!(found.verdict, found.nameless);
}

#[test]
fn a_name_that_leaves_more_than_a_curve_alone_is_none() {
    // The curve alone leaves 1 + 9/4 of 1 + 9; the lag leaves 1 + what stands beside it.
    for (beside, verdict) in [(1.0, Verdict::ExplainedInPart), (2.0, Verdict::Unexplained)] {
        let found = decide(&with_lag(3.0, beside), &known());
        assert_eq!(found.verdict, verdict, "{beside}");
        assert_eq!(found.named.is_empty(), verdict == Verdict::Unexplained);
    }
}

#[test]
fn what_a_curve_finds_beside_all_names_speaks_against_none_of_them() {
    // A large lag, a stop that a curve in its place misses by two fifths, and `beside` them what only a curve finds: so much that the curve in
    // the place of the stop leaves less than both names, by less than a hundredth of all that is explained, or by more.
    let held: [(f64, &[&str]); 2] = [(0.9, &["end-stop", "output-lag"]), (1.5, &["output-lag"])];
    for (beside, names) in held {
        let quiet = noise(1.0, 1);
        let (lag, stop, other) = (trace(10.0, 1), trace(1.5, 2), trace(beside, 3));
        let share = |of: &[f64], share: f64| of.iter().map(|s| share * s).collect::<Vec<f64>>();
        let rest = sum(&quiet, &other);
        let left_by_curve = [
            sum(&quiet, &share(&lag, 0.3)),
            sum(&quiet, &share(&stop, 0.4)),
            quiet,
        ];
        let both = [EffectId::OutputLag, EffectId::EndStop];
        let residuals = [sum(&sum(&rest, &stop), &lag), sum(&rest, &stop), rest];
        let pairs = residuals.into_iter().zip(left_by_curve).enumerate();
        let models = pairs.map(|(n, (rest, with_curve))| model(&both[..n], rest, with_curve));
        let population = Population {
            models: models.collect(),
        };
        assert_eq!(named(&decide(&population, &known())), names, "{beside}");
    }
}

#[test]
fn a_drift_that_slips_is_no_drift() {
    let found = around(&with_lag(3.0, 0.0), RuleId::Slip, |known, slip| {
        known.slip = Some((EffectId::OutputLag.into(), slip));
    });
    assert_eq!(found, [Verdict::Explained, Verdict::Unexplained]);
    // Another name than the drift's.
    let found = around(&with_lag(3.0, 0.0), RuleId::Slip, |known, slip| {
        known.slip = Some((EffectId::SensorDrift.into(), slip));
    });
    assert_eq!(found, [Verdict::Explained; 2]);
    // Where no drift goes with the recordings, neither does a slip.
    let found = around(&nothing(), RuleId::Slip, |known, slip| {
        known.slip = Some((EffectId::OutputLag.into(), slip));
    });
    assert_eq!(found, [Verdict::Adequate; 2]);
    // Where it does not slip, a tone is what is left beside it.
    let found = around(&with_lag(3.0, 0.0), RuleId::Tone, |known, tone| {
        (known.left.tone, known.slip) = (tone, Some((EffectId::OutputLag.into(), 0.0)));
    });
    assert_eq!(found, [Verdict::Explained, Verdict::ExplainedInPart]);
}

/// A population whose residuals are those of another, changed.
fn changed(population: &Population, change: impl Fn(usize, &[f64]) -> Vec<f64>) -> Population {
    let models = population.models.iter().enumerate().map(|(number, one)| {
        let names: Vec<EffectId> = EffectId::ALL
            .into_iter()
            .filter(|&effect| one.names.contains(effect))
            .collect();
        let curve = one.anonymous.as_ref().map(|curve| &curve.evidence.residual);
        let curve = curve.map_or_else(Vec::new, |curve| change(number, curve));
        model(&names, change(number, &one.evidence.residual), curve)
    });
    Population {
        models: models.collect(),
    }
}

#[test]
fn the_unit_of_the_output_moves_no_verdict() {
    for population in [with_lag(3.0, 0.0), with_lag(3.0, 0.5), nothing()] {
        let expected = decide(&population, &known());
        for scale in [1e-9, 1e-3, 1e6] {
            let known = Known {
                output_squares: known().output_squares * scale * scale,
                ..known()
            };
            let scaled = changed(&population, |_, residual| {
                residual.iter().map(|left| left * scale).collect()
            });
            let decided = decide(&scaled, &known);
            assert_eq!(decided.verdict, expected.verdict, "{scale}");
            assert_eq!(named(&decided), named(&expected), "{scale}");
        }
    }
}

#[test]
fn a_model_whose_residual_is_no_number_has_no_name() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
        for at in [0, N / 2, N - 1] {
            // The model with the lag alone.
            let spoiled = changed(&with_lag(3.0, 0.0), |number, residual| {
                let mut residual = residual.to_vec();
                if number == 1 {
                    residual[at] = value;
                }
                residual
            });
            let decided = decide(&spoiled, &known());
            assert!(named(&decided).is_empty(), "{value} at {at}: {decided:?}");
            // All models: nothing is known of them, least of all that nothing is missing.
            let spoiled = changed(&with_lag(3.0, 0.0), |_, residual| {
                let mut residual = residual.to_vec();
                residual[at] = value;
                residual
            });
            let decided = decide(&spoiled, &known());
            assert!(named(&decided).is_empty(), "{value} at {at}: {decided:?}");
            assert_ne!(decided.verdict, Verdict::Adequate, "{value} at {at}");
        }
    }
}

#[test]
fn each_rule_has_one_row_and_there_are_fifteen_at_most() {
    assert!(RULES.len() <= 15);
    for row in RULES {
        assert_eq!(RULES.iter().filter(|other| other.id == row.id).count(), 1);
        assert_eq!(row.id.rule().name, row.name);
        assert!(!row.passes(f64::NAN));
    }
}

#[test]
fn names_that_were_tried_beside_others_are_all_but_these_and_those_that_could_not_be() {
    let of = |effect: EffectId| -> CandidateSet { std::iter::once(effect.into()).collect() };
    let known = Known {
        untried: of(EffectId::DeadTime),
        ..known()
    };
    let all = EffectId::ALL.len();
    assert_eq!(known.tried_beside(of(EffectId::OutputLag)), all - 2);
    assert_eq!(known.tried_beside(of(EffectId::DeadTime)), all - 1);
}
