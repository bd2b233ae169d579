//! A model on recordings that were not used.
//!
//! A recording's own parameters (where its zero was, a drift) are not known of another recording. They are fitted to
//! every other stretch of it, and the error on the stretches between counts; then the other way round. One law for
//! every model.

use identify::{
    AMBIENT_LEVEL, ForwardModel, IdentifyError, LeastSquaresConfig, OfRig, ParameterInfo,
    ParameterState, ParameterVector, Prior, RUN_PARAMETERS, RefineConfig, ResidualNoise, Validated,
    beginnings_of, predict, refine, try_in_parallel, validated_with,
};
use recording::Recording;

/// Stretches of a recording: so many that of each passage through the transformation, where alone the output tells of the
/// surroundings, some are fitted and some count.
const STRETCHES: usize = 240;
/// Samples of a stretch, at least.
const SHORTEST: usize = 4;

/// Iterations of a fit of what belongs to a recording.
const ITERATIONS: usize = 12;

/// Iterations after which only the lowest of several starts go on.
const RACE: usize = 4;

/// Error of a model, as a share of what the output varies by, against which what is to be expected of a recording's own parameters
/// counts: about what a good model leaves. It matters where no fitted stretch tells anything of them.
const ORDINARY_ERROR: f64 = 0.01;

/// Surroundings over what was written down from which such a fit starts, K.
const LEVELS_K: [f64; 3] = [0.0, -2.0, 2.0];

/// Squared errors of a model on each stretch of a recording, where what belongs to the recording comes from the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unseen {
    /// Number of samples and sum of squares of each stretch.
    pub(crate) stretches: Vec<(f64, f64)>,
    /// Recorded - model of the output and of the temperature, recording after recording.
    residual: Vec<Met>,
}

/// Recorded - model of a sample: of the output, and of the temperature, K, which is 0 where none is recorded.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Met {
    output: f64,
    temperature_k: f64,
}

impl Met {
    fn less(self, other: Self) -> Self {
        Self {
            output: self.output - other.output,
            temperature_k: self.temperature_k - other.temperature_k,
        }
    }

    /// Product with another, that of the temperatures with a weight.
    fn times(self, other: Self, temperature_weight: f64) -> f64 {
        self.output * other.output + temperature_weight * (self.temperature_k * other.temperature_k)
    }
}

/// The error of a model at a point, of which the shared values count, on recordings that were not used; their temperatures count with a
/// weight, (output unit/K)².
pub(crate) fn unseen(
    model: &dyn ForwardModel,
    (point, temperature_weight): (&[f64], f64),
    recordings: &[Recording],
) -> Result<Unseen, IdentifyError> {
    let of_each = try_in_parallel(recordings, |recording| {
        Ok(of_recording(model, (point, temperature_weight), recording)?.0)
    })?;
    Ok(Unseen::of_all(of_each))
}

/// Validation of a model at a point on each of some recordings that were not used, with the values of all parameters that belong to it by
/// their outputs, and its error on them.
pub(crate) fn validated(
    model: &dyn ForwardModel,
    point: &[f64],
    recordings: &[Recording],
) -> Result<(Vec<Validated>, Unseen), IdentifyError> {
    validated_by(model, (point, 0.0), [recordings, recordings])
}

/// [`validated`] by the samples of each recording on which models are judged: they give the values of all parameters that belong to it, by
/// their temperatures as well, with a weight, (output unit/K)², and count as the error.
pub(crate) fn validated_by(
    model: &dyn ForwardModel,
    (point, temperature_weight): (&[f64], f64),
    [recordings, judged]: [&[Recording]; 2],
) -> Result<(Vec<Validated>, Unseen), IdentifyError> {
    let pairs: Vec<(&Recording, &Recording)> = recordings.iter().zip(judged).collect();
    let of_each = try_in_parallel(&pairs, |(recording, judged)| {
        let (own, whole) = of_recording(model, (point, temperature_weight), judged)?;
        let mut square = own.squares() / judged.len() as f64;
        if recording.len() > judged.len() {
            // Between the samples on which it is judged there is noise, too.
            let [of_all, of_judged] =
                [recording, judged].map(|one| mean_square(model, &whole, one));
            square = (square + of_all? - of_judged?).max(0.0);
        }
        let validated = validated_with(model, whole, recording, square.sqrt());
        Ok((validated, own))
    })?;
    let (validated, of_each): (Vec<Validated>, Vec<Unseen>) = of_each.into_iter().unzip();
    Ok((validated, Unseen::of_all(of_each)))
}

/// Mean square of what a model leaves of a recording at a point.
fn mean_square(
    model: &dyn ForwardModel,
    point: &[f64],
    recording: &Recording,
) -> Result<f64, IdentifyError> {
    let shown = predict(model, point, recording)?.output;
    let pairs = recording.output().iter().zip(shown);
    let squares = pairs.map(|(recorded, shown)| (recorded - shown).powi(2));
    Ok(squares.sum::<f64>() / recording.len() as f64)
}

fn of_recording(
    model: &dyn ForwardModel,
    (point, temperature_weight): (&[f64], f64),
    recording: &Recording,
) -> Result<(Unseen, Vec<f64>), IdentifyError> {
    let mut of_rig = OfRig::at(model, point);
    of_rig.begin_as(recording);
    for info in &mut of_rig.parameters {
        // Nobody wrote it down of this recording, whatever the training was like.
        if info.name == "ambient_level_k" && info.state == ParameterState::Fixed(0.0) {
            info.state = ParameterState::Free;
        }
    }
    let vector = ParameterVector::new(of_rig.parameters(), 1);
    // As the training began, and as it may have begun, in surroundings as warm or cold as laboratories are.
    let mut starts = vec![vector.coordinates(|parameter, _| Some(point[parameter]))];
    for begun in beginnings_of(&of_rig, recording)? {
        let begun = vector.values(&begun, 0);
        for level_k in LEVELS_K {
            let start = vector.coordinates(|parameter, _| {
                Some(match of_rig.parameters()[parameter].name {
                    AMBIENT_LEVEL => level_k,
                    _ => begun[parameter],
                })
            });
            if !starts.contains(&start) {
                starts.push(start);
            }
        }
    }
    let n = recording.len();
    let length = n.div_ceil(STRETCHES).max(SHORTEST).min(n);
    let mut stretches = vec![(0.0, 0.0); n.div_ceil(length)];
    let mut residual = vec![Met::default(); n];
    let own = std::slice::from_ref(recording);
    let mean = recording.output().iter().sum::<f64>() / n as f64;
    let squares = recording.output().iter().map(|y| (y - mean).powi(2));
    let error_variance = ORDINARY_ERROR.powi(2) * squares.sum::<f64>() / n as f64;
    let fitted = |weigh: &dyn Fn(usize) -> bool, starts: &[Vec<f64>], prior| {
        let weights = (0..n).map(|k| f64::from(u8::from(weigh(k))));
        let config = RefineConfig {
            least_squares: LeastSquaresConfig {
                iterations: ITERATIONS,
                relative_offset: 1e-3,
                ..LeastSquaresConfig::default()
            },
            weights: Some(vec![weights.collect()]),
            temperature_weight,
            prior,
            race_iterations: RACE,
        };
        refine(&of_rig, own, starts, &config)
    };
    let of_errors = Prior::Variance(error_variance);
    let mut whole = fitted(&|_| true, &starts, of_errors)?;
    let mut prior = of_errors;
    if of_rig.parameters.iter().any(is_of_run) {
        // As in the training: beside as many samples as are independent.
        let shown = predict(model, &whole.points[0], recording)?.output;
        let pairs = recording.output().iter().zip(&shown);
        let residual: Vec<f64> = pairs.map(|(recorded, shown)| recorded - shown).collect();
        let n_effective = ResidualNoise::of(&[&residual]).n_effective;
        prior = Prior::Profiled(n_effective.max(1.0));
        starts = vec![whole.coordinates.clone()];
        whole = fitted(&|_| true, &starts, prior)?;
    }
    let halves = try_in_parallel(&[0, 1], |&scored| {
        let refined = fitted(&|k| k / length % 2 != scored, &starts, prior)?;
        let shown = predict(model, &refined.points[0], recording)?;
        Ok((refined.coordinates, shown))
    })?;
    let mut ends = Vec::new();
    for (scored, (coordinates, shown)) in halves.into_iter().enumerate() {
        ends.push(coordinates);
        let temperatures = recording.temperature_degc();
        for (k, (recorded, output)) in recording.output().iter().zip(&shown.output).enumerate() {
            let stretch = k / length;
            if stretch % 2 == scored {
                let output = recorded - output;
                residual[k] = Met {
                    output,
                    temperature_k: temperatures
                        .map_or(0.0, |own| own[k] - shown.temperature_degc[k]),
                };
                stretches[stretch].0 += 1.0;
                stretches[stretch].1 += output.powi(2);
            }
        }
    }
    let own = Unseen {
        stretches,
        residual,
    };
    if own.squares() < n as f64 * whole.mean_square {
        // What was fitted to all is no nearer than what was predicted: there is a lower minimum.
        let again = fitted(&|_| true, &ends, prior)?;
        if again.deviance < whole.deviance {
            whole = again;
        }
    }
    Ok((own, whole.points.swap_remove(0)))
}

/// True if a parameter is one of those that differ from run to run, and is free.
fn is_of_run(info: &ParameterInfo) -> bool {
    RUN_PARAMETERS.contains(&info.name) && info.state == ParameterState::Free
}

impl Unseen {
    /// Of all recordings, one after another.
    fn of_all(of_each: Vec<Self>) -> Self {
        let (mut stretches, mut residual) = (Vec::new(), Vec::new());
        for one in of_each {
            stretches.extend(one.stretches);
            residual.extend(one.residual);
        }
        Self {
            stretches,
            residual,
        }
    }

    /// Of stretches alone, samples and squares of each.
    #[cfg(test)]
    pub(crate) fn of_squares(stretches: Vec<(f64, f64)>) -> Self {
        Self {
            stretches,
            residual: Vec::new(),
        }
    }

    /// Sum of squares.
    pub(crate) fn squares(&self) -> f64 {
        self.stretches.iter().map(|(_, squares)| squares).sum()
    }

    /// Mean square; `None` of no samples.
    pub(crate) fn mean_square(&self) -> Option<f64> {
        let n: f64 = self.stretches.iter().map(|(n, _)| n).sum();
        (n > 0.0).then(|| self.squares() / n)
    }

    /// Share of what it changes against another model that comes true, and the standard error of that by stretches; `None` where
    /// it changes nothing. Recorded temperatures count with a weight, (output unit/K)²: a lag of the thermocouple changes nothing else.
    ///
    /// ```text
    /// b = Σ e Δ / Σ Δ²,   e what the other leaves, Δ the change;   below a half the change makes the recording worse
    /// ```
    pub(crate) fn comes_true(&self, other: &Self, temperature_weight: f64) -> Option<[f64; 2]> {
        let mut place = 0;
        let sums: Vec<[f64; 2]> = self
            .stretches
            .iter()
            .map(|&(n, _)| {
                let own = place..place + n as usize;
                place = own.end;
                let pairs = self.residual[own.clone()].iter().zip(&other.residual[own]);
                pairs.fold([0.0; 2], |[along, square], (&with, &without)| {
                    let change = without.less(with);
                    let times = |one: Met| one.times(change, temperature_weight);
                    [along + times(without), square + times(change)]
                })
            })
            .collect();
        let square: f64 = sums.iter().map(|[_, square]| square).sum();
        let share = sums.iter().map(|[along, _]| along).sum::<f64>() / square;
        let spread: f64 = sums
            .iter()
            .map(|[along, square]| (along - share * square).powi(2))
            .sum();
        let n = sums.len() as f64;
        let error = (spread * n / (n - 1.0).max(1.0)).sqrt() / square;
        (square > 0.0).then_some([share, error])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::{EffectSet, EffectValues};
    use recording::{Quantity, RecordingParts};

    /// Two stretches of two samples each that leave the same everywhere.
    fn leaving(output: f64, temperature_k: f64) -> Unseen {
        Unseen {
            stretches: vec![(2.0, 2.0 * output * output); 2],
            residual: vec![
                Met {
                    output,
                    temperature_k,
                };
                4
            ],
        }
    }

    #[test]
    fn a_change_of_the_recorded_temperature_alone_comes_true_as_far_as_it_counts() {
        let share = |with: &Unseen, without: &Unseen, weight: f64| {
            with.comes_true(without, weight).map(|[share, _]| share)
        };
        let [with, without] = [leaving(1.0, 0.0), leaving(1.0, 2.0)];
        assert!(share(&with, &without, 0.0).is_none());
        assert!((share(&with, &without, 0.5).unwrap() - 1.0).abs() < 1e-12);
        // It makes the output worse by as much as the temperature better.
        let worse = leaving(1.0 + 2.0_f64.sqrt(), 0.0);
        let both = share(&worse, &without, 0.5).unwrap();
        assert!(both < 0.5, "{both}");
        assert!(share(&worse, &without, 1e6).unwrap() > 0.999);
    }

    /// A cold wire that hardly warms, in a room that is warmer than the training's: its output stays where it is.
    #[test]
    fn a_thermometer_tells_how_warm_a_room_is_where_the_output_does_not() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let node = synthetic.case().baseline().unwrap();
        let mut infos = node.model.parameters().iter();
        let place = infos.position(|info| info.name == AMBIENT_LEVEL).unwrap();
        let cold = |output: Vec<f64>, temperature_degc: Option<Vec<f64>>| {
            let parts = RecordingParts {
                name: "cold".to_owned(),
                time_s: Some((0..200).map(f64::from).collect()),
                drive: (0..200).map(|k| 0.05 * f64::from(k / 100)).collect(),
                drive_quantity: Quantity::Current,
                output,
                output_unit: "mm".to_owned(),
                temperature_degc,
                ..RecordingParts::default()
            };
            Recording::new(parts).unwrap()
        };
        const WARMER_K: f64 = 3.0;
        let mut warmer = node.points[0].clone();
        warmer[place] += WARMER_K;
        let shown = predict(&node.model, &warmer, &cold(vec![0.0; 200], None)).unwrap();
        let noisy = |(k, mm): (usize, f64)| mm + 3.0 * NOISE_MM * ((k * k) as f64).sin();
        let output = shown.output.into_iter().enumerate().map(noisy).collect();
        let recorded = [cold(output, Some(shown.temperature_degc))];
        let found_k = |weight: f64| {
            let at = (&node.points[0][..], weight);
            let both = [&recorded[..], &recorded[..]];
            validated_by(&node.model, at, both).unwrap().0[0].point[place]
        };
        // Of a thermometer with noise of 0.2 K.
        let weight = (NOISE_MM / 0.2).powi(2);
        assert!(
            (found_k(weight) - WARMER_K).abs() < 0.2,
            "{}",
            found_k(weight)
        );
        assert!(found_k(0.0) < 0.5 * WARMER_K, "{}", found_k(0.0));
    }
}
