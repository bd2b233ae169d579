//! Local variables of a model's blocks, sample by sample.

use std::ops::Range;

use identify::{ForwardModel, IdentifyError, ParameterVector, predict};
use recording::Recording;

use crate::model::case::{Case, Node};
use crate::model::series::Channel;
use crate::model::tangent::Sensitivity;

/// Share of the range of the temperature by which it must turn back before the branch changes: ripple of a
/// drive is no branch.
const TURN: f64 = 1e-3;

/// Step of the central difference by the loop's center, K, where the center is not free.
const CENTER_STEP_K: f64 = 1e-3;

/// Local variables in one recording; all series have a value a sample.
#[derive(Debug, Clone)]
pub(crate) struct Passage {
    /// Number of the recording.
    pub(crate) recording: usize,
    /// Its samples in the series of the outputs.
    pub(crate) range: Range<usize>,
    /// Its recorded temperatures, if there are any.
    pub(crate) temperatures: Option<Range<usize>>,
    pub(crate) time_s: Vec<f64>,
    /// Length of each sample, s; the last one is as long as the one before it.
    pub(crate) dt_s: Vec<f64>,
    /// Temperature of the rod above that of the surroundings, K.
    pub(crate) rise_k: Vec<f64>,
    /// Its rate of change, K/s.
    pub(crate) rate_k_per_s: Vec<f64>,
    /// True where the temperature rises, or rose last.
    pub(crate) heating: Vec<bool>,
    /// Transformed share, 0 to 1.
    pub(crate) fraction: Vec<f64>,
    /// Model's output, in its unit.
    pub(crate) output: Vec<f64>,
    /// Change of the output with the temperature, all of its past moved along, (output unit)/K.
    pub(crate) slope_per_k: Vec<f64>,
    /// Power of the drive over the heat capacity, K/s.
    pub(crate) power_k_per_s: Vec<f64>,
    /// Temperature of the surroundings at its start, °C.
    pub(crate) first_ambient_degc: f64,
    /// Time constant of the heat balance, s.
    pub(crate) tau_s: f64,
}

/// Local variables in all recordings.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    pub(crate) passages: Vec<Passage>,
    /// Lowest and highest output of the model.
    pub(crate) stroke: [f64; 2],
}

impl Scene {
    /// Local variables at a node; takes one simulation, and two more where the loop's center is not free.
    pub(crate) fn of(
        case: &Case<'_>,
        node: &Node,
        sensitivities: &[Sensitivity],
    ) -> Result<Self, IdentifyError> {
        let slope_per_k = slope_per_k(case, node, sensitivities)?;
        let passages: Vec<Passage> = (0..case.training.len())
            .map(|r| passage(case, node, r, &slope_per_k))
            .collect::<Result<_, _>>()?;
        let outputs = || passages.iter().flat_map(|passage| &passage.output);
        let stroke = [
            outputs().copied().fold(f64::INFINITY, f64::min),
            outputs().copied().fold(f64::NEG_INFINITY, f64::max),
        ];
        Ok(Self { passages, stroke })
    }

    /// Place of an output in the stroke of the model, 0 to 1.
    pub(crate) fn place(&self, output: f64) -> f64 {
        let [lowest, highest] = self.stroke;
        if highest > lowest {
            (output - lowest) / (highest - lowest)
        } else {
            0.0
        }
    }

    /// Number of samples of the output.
    pub(crate) fn n_outputs(&self) -> usize {
        self.passages
            .iter()
            .map(|passage| passage.range.len())
            .sum()
    }
}

impl Passage {
    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.range.len()
    }

    /// Samples of the whole time, 0 to 1.
    pub(crate) fn time_share(&self, k: usize) -> f64 {
        let (first, last) = (self.time_s[0], self.time_s[self.len() - 1]);
        (self.time_s[k] - first) / (last - first).max(f64::MIN_POSITIVE)
    }
}

fn passage(
    case: &Case<'_>,
    node: &Node,
    r: usize,
    slope_per_k: &[f64],
) -> Result<Passage, IdentifyError> {
    let (recording, point) = (&case.training[r], &node.points[r]);
    let shown = predict(&node.model, point, recording)?;
    let params = case.base.wiener_params(point);
    let first_ambient_degc = case.base.profile(recording)?.first_ambient_degc();
    let of = |channel| {
        let mut segments = case.layout.of_channel(channel);
        let found = segments.find(|one| one.recording == r);
        found.map(|segment| segment.range.clone())
    };
    let range = of(Channel::Output).unwrap_or(0..0);
    let ambient_degc = |k: usize| {
        recording
            .ambient_degc()
            .map_or(first_ambient_degc, |recorded| recorded[k])
    };
    let dt_s = dt_s(recording);
    let share = |output: &f64| {
        let share = (output - params.offset) / params.gain;
        if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let power_k_per_s = |drive: &f64| {
        let resistance = [params.heat.resistance_ohm_per_m];
        let [power_w_per_m] = case.base.drive().power_w_per_m([*drive], resistance);
        power_w_per_m / params.heat.heat_capacity_j_per_m_k
    };
    Ok(Passage {
        recording: r,
        first_ambient_degc,
        slope_per_k: slope_per_k[range.clone()].to_vec(),
        range,
        temperatures: of(Channel::Temperature),
        time_s: recording.time_s().to_vec(),
        rise_k: shown
            .temperature_degc
            .iter()
            .enumerate()
            .map(|(k, degc)| degc - ambient_degc(k))
            .collect(),
        rate_k_per_s: rates(&shown.temperature_degc, &dt_s),
        heating: directions(&shown.temperature_degc),
        fraction: shown.output.iter().map(share).collect(),
        output: shown.output,
        power_k_per_s: recording.drive().iter().map(power_k_per_s).collect(),
        tau_s: params.heat.heat_capacity_j_per_m_k / params.heat.conductance_w_per_m_k,
        dt_s,
    })
}

/// dy/dT = -dy/d(loop center): a loop that stands higher meets all temperatures later.
fn slope_per_k(
    case: &Case<'_>,
    node: &Node,
    sensitivities: &[Sensitivity],
) -> Result<Vec<f64>, IdentifyError> {
    let infos = node.model.parameters();
    let Some(center) = infos
        .iter()
        .position(|info| info.name == "loop_center_degc")
    else {
        return Ok(vec![0.0; case.layout.len()]);
    };
    let vector = ParameterVector::new(infos, case.training.len());
    let coordinate = vector.coordinate_of(center, 0);
    let mut columns = sensitivities.iter();
    if let Some(one) = columns.find(|one| coordinate.is_some() && one.coordinate == coordinate) {
        return Ok(one.column.iter().map(|by_center| -by_center).collect());
    }
    let moved = |r: usize, step_k: f64| {
        let mut point: Vec<f64> = node.points[r].clone();
        point[center] += step_k;
        point
    };
    let shown = case.layout.shown(&node.model, case.training, |r| {
        vec![moved(r, -CENTER_STEP_K), moved(r, CENTER_STEP_K)]
    })?;
    let pairs = shown[0].iter().zip(&shown[1]);
    Ok(pairs
        .map(|(below, above)| (below - above) / (2.0 * CENTER_STEP_K))
        .collect())
}

/// Lengths of the samples, s.
fn dt_s(recording: &Recording) -> Vec<f64> {
    let mut dt_s: Vec<f64> = recording
        .time_s()
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    let last = dt_s.last().copied().unwrap_or(0.0);
    dt_s.push(last);
    dt_s
}

/// Rates of change over each sample; of the last one, over the one before it.
pub(crate) fn rates(values: &[f64], dt_s: &[f64]) -> Vec<f64> {
    let mut rates: Vec<f64> = values
        .windows(2)
        .zip(dt_s)
        .map(|(pair, dt_s)| (pair[1] - pair[0]) / dt_s)
        .collect();
    rates.push(rates.last().copied().unwrap_or(0.0));
    rates
}

/// Direction of a temperature at each sample: true if it rises, or rose last.
fn directions(temperature_degc: &[f64]) -> Vec<bool> {
    let (lowest, highest) = temperature_degc
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), degc| {
            (degc.min(low), degc.max(high))
        });
    let turn_k = TURN * (highest - lowest);
    let mut rising = true;
    let mut extreme_degc = temperature_degc.first().copied().unwrap_or(0.0);
    let mut directions = vec![true; temperature_degc.len()];
    let mut turned_at = 0;
    for (k, &degc) in temperature_degc.iter().enumerate() {
        let goes_on = if rising {
            degc >= extreme_degc
        } else {
            degc <= extreme_degc
        };
        if goes_on {
            turned_at = k + 1;
            extreme_degc = degc;
        } else if (degc - extreme_degc).abs() > turn_k {
            rising = !rising;
            extreme_degc = degc;
            directions[turned_at..k].fill(rising);
            turned_at = k + 1;
        }
        directions[k] = rising;
    }
    directions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ripple_is_no_branch() {
        let degc: Vec<f64> = (0..200)
            .map(|k| {
                let k = f64::from(k);
                (100.0 - (k - 100.0).abs())
                    + if k > 20.0 {
                        0.02 * (1.7 * k).sin()
                    } else {
                        0.0
                    }
            })
            .collect();
        let directions = directions(&degc);
        assert!(directions[..=100].iter().all(|heating| *heating));
        assert!(directions[102..].iter().all(|heating| !heating));
    }

    #[test]
    fn a_hold_belongs_to_the_branch_before_it() {
        let degc = [0.0, 5.0, 10.0, 10.0, 10.0, 10.0, 4.0, 4.0, 4.0, 9.0];
        let expected = [
            true, true, true, true, true, true, false, false, false, true,
        ];
        assert_eq!(directions(&degc), expected);
    }
}
