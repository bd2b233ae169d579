//! A curve of any shape: columns of what a model goes through, from its own state and the drive, never from what was
//! recorded.

use identify::IdentifyError;

use crate::EffectBlock;
use crate::model::case::{Case, Node};
use crate::model::tangent::Sensitivity;
use crate::pullback::local_terms::{Pull, hat, terms_of};
use crate::pullback::scene::{Passage, Scene, rates};

/// Knots of the temperature on each branch.
const TEMPERATURES: usize = 9;

/// Widths of plays, as shares of the stroke.
const PLAYS: [f64; 5] = [0.01, 0.02, 0.04, 0.08, 0.16];

/// Time constants of what follows the model's output and its temperature, over that of the heat balance.
const FOLLOWERS: [f64; 5] = [0.03, 0.1, 0.3, 2.0, 6.0];

/// The columns at a node: local terms of every block, pulled back to the output, and what follows, plays, and depends on the
/// temperature or on where the last reversal was.
pub(crate) fn of(
    case: &Case<'_>,
    node: &Node,
    sensitivities: &[Sensitivity],
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    let scene = Scene::of(case, node, sensitivities)?;
    let mut columns: Vec<Vec<f64>> = terms_of(case, &scene)
        .into_iter()
        .map(|term| term.column)
        .collect();
    let pull = Pull {
        case,
        scene: &scene,
    };
    let output = |local: &dyn Fn(&Passage) -> Vec<f64>| {
        let series: Vec<Vec<f64>> = scene.passages.iter().map(local).collect();
        pull.column(EffectBlock::Displacement, |passage, k| {
            series[passage.recording][k]
        })
    };
    let knots = temperature_knots(&scene);
    for heating in [true, false] {
        for j in 0..knots.len() {
            columns.push(pull.column(EffectBlock::Displacement, |passage, k| {
                if passage.heating[k] == heating {
                    hat(&knots, j, passage.rise_k[k])
                } else {
                    0.0
                }
            }));
        }
    }
    let stroke = scene.stroke[1] - scene.stroke[0];
    for share in PLAYS {
        columns.push(output(&|passage| played(&passage.output, share * stroke)));
    }
    for share in FOLLOWERS {
        columns.push(output(&|passage| {
            behind(&passage.output, passage, share * passage.tau_s)
        }));
        columns.push(output(&|passage| {
            behind(&passage.rise_k, passage, share * passage.tau_s)
        }));
    }
    columns.push(output(&|passage| rates(&passage.rise_k, &passage.dt_s)));
    columns.push(output(&since_reversal));
    Ok(columns)
}

/// Output of a play of some width, less its input.
fn played(output: &[f64], width: f64) -> Vec<f64> {
    let half = 0.5 * width;
    let mut held = output[0];
    output
        .iter()
        .map(|&output| {
            held = held.clamp(output - half, output + half);
            held - output
        })
        .collect()
}

/// Follower of a signal with a time constant, less the signal.
fn behind(signal: &[f64], passage: &Passage, lag_s: f64) -> Vec<f64> {
    let mut follower = signal[0];
    signal
        .iter()
        .zip(&passage.dt_s)
        .map(|(signal, dt_s)| {
            let behind = follower - signal;
            follower += (signal - follower) * -libm::expm1(-dt_s / lag_s);
            behind
        })
        .collect()
}

/// Distance of the temperature from where it last turned back, K.
fn since_reversal(passage: &Passage) -> Vec<f64> {
    let mut turned_k = passage.rise_k[0];
    (0..passage.len())
        .map(|k| {
            if k > 0 && passage.heating[k] != passage.heating[k - 1] {
                turned_k = passage.rise_k[k - 1];
            }
            passage.rise_k[k] - turned_k
        })
        .collect()
}

fn temperature_knots(scene: &Scene) -> Vec<f64> {
    let all = || scene.passages.iter().flat_map(|passage| &passage.rise_k);
    let (lowest, highest) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &k| {
        (low.min(k), high.max(k))
    });
    let step = (highest - lowest) / (TEMPERATURES - 1) as f64;
    (0..TEMPERATURES)
        .map(|j| lowest + step * j as f64)
        .collect()
}
