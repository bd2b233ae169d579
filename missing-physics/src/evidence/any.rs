//! Laws of the auditor for any residual and any columns: no panic, finite predictions, probabilities from 0 to 1.

use proptest::prelude::*;

use super::blocks::Block;
use super::left_out::{Columns, LeftOut};
use super::shifts::{by_chance, centered};

/// Samples of a recording.
const N: usize = 64;

/// Shifts: fewer than a diagnosis makes.
const SHIFTS: usize = 99;

/// A series: zeros, a constant, one sample alone, noise, or a sine, of a size over twenty-four decades.
fn series() -> impl Strategy<Value = Vec<f64>> {
    let size = (-12.0..12.0_f64).prop_map(|exponent| 10f64.powf(exponent));
    let noise = prop::collection::vec(-1.0..1.0_f64, N);
    (0..5, size, 0..N, noise).prop_map(|(kind, size, at, noise)| {
        let value = |k: usize| match kind {
            0 => 0.0,
            1 => 1.0,
            2 => f64::from(u8::from(k == at)),
            3 => noise[k],
            _ => (0.3 * (k * (1 + at)) as f64).sin(),
        };
        (0..N).map(|k| size * value(k)).collect()
    })
}

/// Sixteen blocks of one recording, with a gap of a sample on either side.
fn blocks() -> Vec<Block> {
    let each = (0..N).step_by(4).map(|start| Block {
        recording: 0,
        output: start..start + 4,
        temperature: None,
        removed: std::iter::once(start.saturating_sub(1)..(start + 5).min(N)).collect(),
    });
    each.collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_residual_has_a_prediction_and_a_probability(
        residual in series(),
        free in prop::collection::vec(series(), 0..3),
        curve in prop::collection::vec(series(), 0..5),
        is_twice in any::<bool>(),
        seed in 0..100_u64,
    ) {
        let mut curve: Vec<&[f64]> = curve.iter().map(Vec::as_slice).collect();
        if is_twice {
            curve.extend(curve.first().copied());
        }
        let free: Vec<&[f64]> = free.iter().map(Vec::as_slice).collect();
        let blocks = blocks();
        let columns = Columns { free: &free, curve: &curve };
        let predicted = LeftOut::new(&columns, &residual, &blocks).best_predicted();
        prop_assert_eq!(predicted.len(), N);
        prop_assert!(predicted.iter().all(|one| one.is_finite()), "{:?}", predicted);
        let pair = (centered(&residual), centered(&predicted));
        let p_value = by_chance(&[pair], SHIFTS, seed);
        prop_assert!((0.01..=1.0).contains(&p_value), "{}", p_value);
    }

    #[test]
    fn a_prediction_without_columns_is_none(residual in series()) {
        let columns = Columns { free: &[], curve: &[] };
        let blocks = blocks();
        prop_assert_eq!(LeftOut::new(&columns, &residual, &blocks).best_predicted(), vec![0.0; N]);
    }
}
