//! Laws of the decision on any population: no panic, finite numbers, and a verdict that agrees with its names.

use proptest::prelude::*;

use super::known::{Known, Oddness};
use super::said::Verdict;
use super::tests::{N, known, model, noise, sum, trace};
use super::trace::Traces;
use super::verdict::decide;
use crate::evidence::Population;
use crate::{CandidateSet, EffectId, LoopFamily};

/// A size over twelve decades, and often none.
fn size() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        (-6.0..6.0_f64).prop_map(|exponent| 10f64.powf(exponent))
    ]
}

/// Effects of a model, sizes of what it leaves of two traces and of what a curve leaves beside it, and whether it stands against a
/// bound or is too small for its names.
type Drawn = (Vec<usize>, [f64; 2], f64, bool, bool, bool);

fn models() -> impl Strategy<Value = Vec<Drawn>> {
    let effects = prop::collection::vec(0..EffectId::ALL.len(), 0..4);
    let one = (
        effects,
        [size(), size()],
        0.0..1.5_f64,
        any::<bool>(),
        any::<bool>(),
        any::<bool>(),
    );
    prop::collection::vec(one, 1..7)
}

fn population(drawn: &[Drawn], scale: f64) -> Population {
    let quiet: Vec<f64> = noise(scale, 1);
    let traces = [1, 2].map(|seed| trace(scale, seed));
    let models = drawn.iter().enumerate().map(
        |(k, (effects, sizes, curve, pressed, slight, other_loop))| {
            // The baseline model is always there.
            let names: Vec<EffectId> = match k {
                0 => Vec::new(),
                _ => effects.iter().map(|&e| EffectId::ALL[e]).collect(),
            };
            let left = |share: f64| {
                let both = [0, 1].map(|t| {
                    traces[t]
                        .iter()
                        .map(|s| s * sizes[t] * share)
                        .collect::<Vec<f64>>()
                });
                sum(&quiet, &sum(&both[0], &both[1]))
            };
            let mut made = model(&names, left(1.0), left(*curve));
            let of = |is: bool| if is { made.names } else { CandidateSet::EMPTY };
            (made.pressed, made.slight) = (of(*pressed), of(*slight));
            if *other_loop && k > 0 {
                made.family = LoopFamily::Relays;
            }
            made
        },
    );
    Population {
        models: models.collect(),
    }
}

fn oddness() -> impl Strategy<Value = Oddness> {
    (size(), size()).prop_map(|(tone, slowness)| Oddness { tone, slowness })
}

proptest! {
    #[test]
    fn a_verdict_agrees_with_its_names(
        drawn in models(),
        scale in (-6.0..6.0_f64).prop_map(|exponent| 10f64.powf(exponent)),
        output in size(),
        rounding in size(),
        of_drive in size(),
        disturbed in 0.0..1.0_f64,
        left in oddness(),
        left_by_plain in oddness(),
        seed in any::<u64>(),
    ) {
        let known = Known {
            output_squares: output * scale * scale * N as f64,
            temperature_squares: 0.0,
            rounding: rounding * scale,
            of_drive: of_drive * scale,
            disturbed,
            left,
            left_by_plain,
            seed,
            ..known()
        };
        let decided = decide(&population(&drawn, scale), &known, Traces::default());
        prop_assert_eq!(decided.is_of_names(), !decided.named.is_empty());
        let is_ambiguous = decided.named.iter().any(|one| !one.others.is_empty());
        prop_assert!(is_ambiguous || decided.verdict != Verdict::Ambiguous);
        prop_assert!(decided.explained.is_none_or(|share| share.is_finite() && share <= 1.0));
        for one in decided.named.iter().chain(&decided.suspects) {
            prop_assert!((0.0..=1.0 + 1e-9).contains(&one.probability), "{one:?}");
        }
        // Nothing is a finding and a suspect, or a finding twice.
        for (k, one) in decided.named.iter().enumerate() {
            let others = decided.named[k + 1..].iter().chain(&decided.suspects);
            prop_assert!(!others.into_iter().any(|other| other.effect == one.effect), "{one:?}");
        }
        let nameless = !matches!(decided.nameless, Verdict::Explained | Verdict::ExplainedInPart | Verdict::Ambiguous);
        prop_assert!(nameless);
    }
}
