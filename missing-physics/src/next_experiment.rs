//! The run, or the sensor, that best tells apart what is left.

use std::ops::Range;

use identify::{IdentifyError, Limits, ResidualNoise, predict};
use rayon::prelude::*;
use recording::{Quantity, Recording, RecordingParts, Sampling};

use crate::case::{Case, Node};
use crate::diagnosis::{NextExperiment, Run};
use crate::drives::{Bench, Levels, Plan, library, seconds, short};
use crate::elsewhere::without_drifts;
use crate::separation::{Experiment, Known, Separation, least_separation};
use crate::series::Noise;
use crate::{Candidate, EffectId};

/// Distance from which a run settles it, standard deviations: of twice the log-likelihoods' difference, normal
/// with mean d² and deviation 2d, nine tenths then lie above 6, odds of 20 to 1: d²/2 - 1.282 d = 3.
const ENOUGH: f64 = 4.05;

/// Noise of a thermocouple on a thin rod, K.
const THERMOCOUPLE_K: f64 = 0.5;

/// Most samples of a run: what a look at all runs may cost.
const MOST_SAMPLES: f64 = 20_000.0;

/// Repeated runs that are tried.
const REPEATED: usize = 4;

/// Share of the squares that the decisive samples hold.
const DECISIVE: f64 = 0.5;

/// A model that could be true.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rival<'a> {
    /// What it has that the others do not.
    pub(crate) effect: Candidate,
    pub(crate) node: &'a Node,
}

/// A run and how far it separates.
#[derive(Debug, Clone)]
struct Tried {
    name: String,
    drive: Vec<f64>,
    separation: Separation,
}

/// The run of the library that tells the rivals apart soonest, within the limits of the rig; or the sensor, where no
/// run does. `None` where there is nothing to tell apart.
///
/// Without limits drive and temperature stay within those of the training, and a run is at most twice as long as the
/// longest recording.
///
/// # Errors
///
/// What the models refuse of the training.
pub(crate) fn next_experiment(
    case: &Case<'_>,
    rivals: &[Rival<'_>],
    limits: &Limits,
    noise: &Noise,
) -> Result<Option<NextExperiment>, IdentifyError> {
    if rivals.len() < 2 {
        return Ok(None);
    }
    let known = rivals
        .iter()
        .map(|rival| Known::of(case, rival.node, noise))
        .collect::<Result<Vec<_>, _>>()?;
    let training = Experiment::new(case, case.training, noise);
    let Some(now) = foreseen(&known, &training, true)? else {
        return Ok(None);
    };
    let hottest_degc = rivals
        .iter()
        .map(|rival| hottest_degc(case, rival.node, limits))
        .collect::<Result<Vec<f64>, _>>()?;
    let lab = Lab {
        bench: bench(case, rivals[0].node, limits, hottest_degc[0])?,
        case,
        known: &known,
        noise,
        hottest_degc,
    };
    let tried: Vec<Tried> = library()
        .par_iter()
        .filter_map(|plan| lab.tried(*plan))
        .collect();
    let separates: Vec<Candidate> = rivals.iter().map(|rival| rival.effect).collect();
    if let Some(best) = lab.soonest(&tried).or_else(|| lab.repeated(&tried)) {
        let run = Run {
            decisive: decisive(&best.separation.squares, best.drive.len()),
            dt_s: lab.bench.dt_s,
            drive: best.drive,
            separation: best.separation.distance,
            separation_now: now.distance,
            name: best.name,
        };
        return Ok(Some(NextExperiment {
            sentence: play(&run, &separates),
            separates,
            run: Some(run),
        }));
    }
    let farthest = tried.iter().map(|tried| tried.separation.distance);
    let farthest = farthest.fold(now.distance, f64::max);
    let with_thermocouple = thermocouple(case, &known, noise)?;
    Ok(Some(NextExperiment {
        sentence: match with_thermocouple {
            Some(distance) if distance >= ENOUGH => measure(distance, now.distance, &separates),
            _ => give_up(farthest, &separates),
        },
        separates,
        run: None,
    }))
}

/// Where runs are tried.
#[derive(Debug)]
struct Lab<'a> {
    case: &'a Case<'a>,
    known: &'a [Known<'a>],
    noise: &'a Noise,
    bench: Bench,
    /// For each rival.
    hottest_degc: Vec<f64>,
}

impl Lab<'_> {
    /// A run as strong as the limits allow; `None` if it does not fit them, or a model refuses it.
    fn tried(&self, plan: Plan) -> Option<Tried> {
        /// Trials to get below the limit.
        const TRIALS: usize = 12;
        /// Least share by which a drive is lowered.
        const LOWER: f64 = 0.97;
        let mut scale = 1.0;
        for _ in 0..TRIALS {
            let played = plan.played(&self.bench, scale)?;
            let recording = recording(self.case, played.drive, self.bench.dt_s).ok()?;
            match self.too_hot(&recording)? {
                None => {
                    let separation = self.separation(&recording)?;
                    return Some(Tried {
                        name: played.name,
                        drive: recording.drive().to_vec(),
                        separation,
                    });
                }
                Some(too_hot) => scale *= LOWER * too_hot,
            }
        }
        None
    }

    /// By which factor the drive must at least fall for all rivals to stay below the limit; `None` inside if they do.
    fn too_hot(&self, recording: &Recording) -> Option<Option<f64>> {
        let mut factor = None;
        for (known, &limit_degc) in self.known.iter().zip(&self.hottest_degc) {
            if limit_degc.is_infinite() {
                continue;
            }
            let node = known.node();
            let moved = without_drifts(&node.model, &node.points[0]);
            for point in [&moved, &node.points[0]] {
                let [start_degc, peak_degc] = start_and_peak_degc(node, point, recording).ok()?;
                if peak_degc <= limit_degc {
                    continue;
                }
                // Heat rises with the square of the drive at most.
                let rise = (limit_degc - start_degc) / (peak_degc - start_degc);
                let own = rise.clamp(0.01, 1.0).sqrt();
                factor = Some(factor.map_or(own, |least: f64| least.min(own)));
            }
        }
        Some(factor)
    }

    fn separation(&self, recording: &Recording) -> Option<Separation> {
        let recordings = std::slice::from_ref(recording);
        let experiment = Experiment::new(self.case, recordings, self.noise);
        let found = foreseen(self.known, &experiment, false).ok()??;
        found.distance.is_finite().then_some(found)
    }

    fn duration_s(&self, tried: &Tried) -> f64 {
        self.bench.dt_s * tried.drive.len() as f64
    }

    /// Of the runs that settle it the one with the most distance a minute.
    fn soonest(&self, tried: &[Tried]) -> Option<Tried> {
        let rate = |tried: &Tried| tried.separation.distance / self.duration_s(tried);
        tried
            .iter()
            .filter(|tried| tried.separation.distance >= ENOUGH)
            .reduce(|best, next| if rate(next) > rate(best) { next } else { best })
            .cloned()
    }

    /// The run that settles it soonest if it is repeated.
    fn repeated(&self, tried: &[Tried]) -> Option<Tried> {
        // T (z/d)², in whole runs.
        let mut wanted: Vec<(usize, &Tried)> = tried
            .iter()
            .filter_map(|tried| {
                let times = (ENOUGH / tried.separation.distance).powi(2).ceil();
                let samples = times * tried.drive.len() as f64;
                (samples <= self.bench.most_samples() as f64).then_some((times as usize, tried))
            })
            .collect();
        wanted.sort_by_key(|(times, tried)| times * tried.drive.len());
        wanted.iter().take(REPEATED).find_map(|&(times, tried)| {
            let drive = tried.drive.repeat(times);
            let recording = recording(self.case, drive, self.bench.dt_s).ok()?;
            if self.too_hot(&recording)?.is_some() {
                return None;
            }
            let separation = self.separation(&recording)?;
            (separation.distance >= ENOUGH).then(|| Tried {
                name: format!("{}, {times} times over", tried.name),
                drive: recording.drive().to_vec(),
                separation,
            })
        })
    }
}

fn foreseen(
    known: &[Known<'_>],
    experiment: &Experiment<'_>,
    is_repetition: bool,
) -> Result<Option<Separation>, IdentifyError> {
    let foreseen = known
        .iter()
        .map(|known| known.in_experiment(experiment, is_repetition))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(least_separation(&foreseen))
}

/// How far a repetition of the training would separate the rivals with a thermocouple on the rod; `None` where there
/// was one.
fn thermocouple(
    case: &Case<'_>,
    known: &[Known<'_>],
    noise: &Noise,
) -> Result<Option<f64>, IdentifyError> {
    if noise.temperature.n_samples > 0 {
        return Ok(None);
    }
    let noise = Noise {
        temperature: ResidualNoise {
            innovation_variance: THERMOCOUPLE_K * THERMOCOUPLE_K,
            ..ResidualNoise::of(&[])
        },
        output: noise.output.clone(),
    };
    let experiment = Experiment::with_temperature(case, case.training, &noise);
    Ok(foreseen(known, &experiment, true)?.map(|found| found.distance))
}

/// A recording of a drive, of which only what models need is known.
fn recording(case: &Case<'_>, drive: Vec<f64>, dt_s: f64) -> Result<Recording, IdentifyError> {
    let first = &case.training[0];
    let n_samples = drive.len();
    let ambient_degc = case
        .training
        .iter()
        .find_map(|recording| recording.ambient_degc())
        .map(|recorded| vec![recorded[0]; n_samples]);
    let has_thermometer = case
        .training
        .iter()
        .any(|recording| recording.temperature_degc().is_some());
    Ok(Recording::new(RecordingParts {
        name: "next experiment".to_owned(),
        time_s: Some((0..n_samples).map(|k| dt_s * k as f64).collect()),
        drive_quantity: first.drive_quantity(),
        drive,
        output_unit: first.output_unit().to_owned(),
        output: vec![0.0; n_samples],
        temperature_degc: has_thermometer.then(|| vec![0.0; n_samples]),
        ambient_degc,
        ..RecordingParts::default()
    })?)
}

/// What runs are made for: the limits, and what the likeliest model says of the rod.
fn bench(
    case: &Case<'_>,
    node: &Node,
    limits: &Limits,
    hottest_degc: f64,
) -> Result<Bench, IdentifyError> {
    let point = without_drifts(&node.model, &node.points[0]);
    let infos = identify::ForwardModel::parameters(&node.model);
    let tau = infos.iter().position(|info| info.name == "tau_s");
    let steps_s = case
        .training
        .iter()
        .filter_map(|recording| match recording.sampling() {
            Sampling::Uniform { dt_s } => Some(dt_s),
            Sampling::Jittered { median_dt_s, .. } => Some(median_dt_s),
            Sampling::Untimed => None,
        });
    // What the logger has done it can do.
    let dt_s = steps_s.fold(f64::INFINITY, f64::min);
    let lengths_s = case.training.iter().map(|recording| {
        let time_s = recording.time_s();
        time_s.last().copied().unwrap_or(0.0) - time_s.first().copied().unwrap_or(0.0)
    });
    let longest_s = 2.0 * lengths_s.fold(0.0, f64::max);
    let drives = case.training.iter().map(Recording::largest_drive);
    let largest = drives.fold(0.0, f64::max);
    let most = limits.drive_max.unwrap_or(largest);
    let most = match case.training[0].drive_quantity() {
        Quantity::Duty => most.min(1.0),
        _ => most,
    };
    let mut bench = Bench {
        dt_s,
        tau_s: tau.map_or(dt_s, |tau| point[tau]),
        longest_s: limits
            .duration_s
            .unwrap_or(longest_s)
            .min(MOST_SAMPLES * dt_s),
        full: Levels {
            low: 0.0,
            high: most,
        },
        working: Levels {
            low: 0.0,
            high: most,
        },
        middle: Levels {
            low: 0.0,
            high: most,
        },
        unit: case.training[0].drive_unit().to_owned(),
    };
    levels(case, node, &point, &mut bench, hottest_degc)?;
    Ok(bench)
}

/// The limit of temperature: that of the rig; where there is none or temperatures are known up to a factor only, what
/// the rod came to in the training. A limit of the drive alone says that the rod stands that drive.
fn hottest_degc(case: &Case<'_>, node: &Node, limits: &Limits) -> Result<f64, IdentifyError> {
    /// How much more than in the training it may be heated.
    const MARGIN: f64 = 1.05;
    match (limits.temperature_max_degc, limits.drive_max) {
        (Some(limit_degc), _) if case.base.knows_temperature() => return Ok(limit_degc),
        (None, Some(_)) => return Ok(f64::INFINITY),
        _ => {}
    }
    let mut hottest_degc = f64::NEG_INFINITY;
    for (point, recording) in node.points.iter().zip(case.training) {
        let [start_degc, peak_degc] = start_and_peak_degc(node, point, recording)?;
        hottest_degc = hottest_degc.max(start_degc + MARGIN * (peak_degc - start_degc));
    }
    Ok(hottest_degc)
}

/// First and highest temperature of the rod itself, not of what a thermocouple sees of it.
fn start_and_peak_degc(
    node: &Node,
    point: &[f64],
    recording: &Recording,
) -> Result<[f64; 2], IdentifyError> {
    let mut point = point.to_vec();
    if let Some(lag) = node.model.first_parameter(EffectId::ThermocoupleLag) {
        point[lag] = 0.0;
    }
    let shown = predict(&node.model, &point, recording)?.temperature_degc;
    let peak_degc = shown.iter().copied().fold(shown[0], f64::max);
    Ok([shown[0], peak_degc])
}

/// Between which drives the rod transforms, from a slow staircase.
fn levels(
    case: &Case<'_>,
    node: &Node,
    point: &[f64],
    bench: &mut Bench,
    hottest_degc: f64,
) -> Result<(), IdentifyError> {
    const STEPS: usize = 24;
    /// Samples of a time constant, and of a hold.
    const PER_TAU: f64 = 8.0;
    const HOLD: usize = 32;
    let height = |k: usize| bench.full.high * k as f64 / STEPS as f64;
    let up_and_down: Vec<f64> = (0..=STEPS).chain((0..STEPS).rev()).map(height).collect();
    let drive = up_and_down
        .iter()
        .flat_map(|&level| std::iter::repeat_n(level, HOLD))
        .collect();
    let staircase = recording(case, drive, bench.tau_s / PER_TAU)?;
    let shown = predict(&node.model, point, &staircase)?;
    let start = shown.output[0];
    let stroke = shown
        .output
        .iter()
        .fold(0.0, |most: f64, y| most.max((y - start).abs()));
    let at_end = |k: usize| HOLD * (k + 1) - 1;
    let share = |k: usize| (shown.output[at_end(k)] - start).abs() / stroke;
    let rising = |least: f64| {
        let found = (0..=STEPS).find(|&k| share(k) >= least);
        height(found.unwrap_or(STEPS))
    };
    let falling = |most: f64| {
        let found = (STEPS..=2 * STEPS).find(|&k| share(k) <= most);
        found.map_or(0.0, |k| up_and_down[k])
    };
    let is_safe = |k: &usize| shown.temperature_degc[at_end(*k)] <= hottest_degc;
    let safe = height((0..=STEPS).rfind(is_safe).unwrap_or(0));
    let levels = |low: f64, high: f64| Levels {
        low: low.min(high),
        high: high.max(low).min(safe),
    };
    let (working, middle) = (
        levels(falling(0.1), rising(0.9)),
        levels(falling(0.6), rising(0.6)),
    );
    (bench.working, bench.middle) = (working, middle);
    Ok(())
}

/// The shortest stretch that holds half of the sum, of the series of outputs.
fn decisive(squares: &[f64], n_samples: usize) -> Range<usize> {
    let squares = &squares[..n_samples];
    let wanted = DECISIVE * squares.iter().sum::<f64>();
    let (mut best, mut start, mut held) = (0..n_samples, 0, 0.0);
    for (end, square) in squares.iter().enumerate() {
        held += square;
        while start < end && held - squares[start] >= wanted {
            held -= squares[start];
            start += 1;
        }
        if held >= wanted && end + 1 - start < best.len() {
            best = start..end + 1;
        }
    }
    best
}

fn names(effects: &[Candidate]) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.info().name).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

fn play(run: &Run, separates: &[Candidate]) -> String {
    format!(
        "Play this run of {} from rest (--save-next next.csv writes it), and diagnose again with its recording as one more \
         of the training: {}. It should tell {} apart ({} standard deviations; these recordings again: {}).",
        seconds(run.duration_s()),
        run.name,
        names(separates),
        short(run.separation),
        short(run.separation_now),
    )
}

/// What to do where a drift of the surroundings, which nobody recorded, is or may be part of the model: no run is worth as much
/// as their temperature.
pub(crate) fn record_surroundings(separates: Vec<Candidate>) -> NextExperiment {
    NextExperiment {
        sentence: format!(
            "Record the temperature of the surroundings, as a column ambient_degc, before you play any other run: while their \
             drift is only guessed, nothing tells {} apart.",
            names(&separates)
        ),
        separates,
        run: None,
    }
}

fn measure(distance: f64, now: f64, separates: &[Candidate]) -> String {
    format!(
        "Record the rod's temperature in runs like these: that would put {} standard deviations between {}; these \
         recordings again: {}. No run within the limits tells them apart without it.",
        short(distance),
        names(separates),
        short(now),
    )
}

fn give_up(farthest: f64, separates: &[Candidate]) -> String {
    format!(
        "No run within the limits tells {} apart: at most {} standard deviations lie between them, and the rod's \
         temperature does not help.",
        names(separates),
        short(farthest),
    )
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::synthetic::{NOISE_MM, Synthetic};
    use crate::{CandidateSet, EffectSet, EffectValues};
    use identify::{Fit, FitConfig, ForwardModel, ParameterVector, RefineConfig, fit, refine};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// The slow recording alone, with one effect, and the plain model fitted to it.
    struct Slow {
        synthetic: Synthetic,
        fit: Fit,
    }

    impl Slow {
        fn of(truth: EffectId, size: f64) -> Self {
            let mut values = EffectValues::default();
            *values.slot(truth, 0).unwrap() = size;
            let mut synthetic = Synthetic::of(EffectSet::of(truth), values, 1);
            synthetic.training.truncate(1);
            let vector = ParameterVector::new(synthetic.base.parameters(), 1);
            let config = FitConfig {
                starts: 0,
                from: vec![synthetic.fit.coordinates(&vector)],
                ..FitConfig::default()
            };
            let go_on = &mut |_: &_| ControlFlow::Continue(());
            let fit = fit(&synthetic.base, &synthetic.training, &config, go_on).unwrap();
            Self { synthetic, fit }
        }

        fn case(&self) -> Case<'_> {
            let Synthetic {
                base,
                training,
                setting,
                ..
            } = &self.synthetic;
            Case::new(base, &self.fit, training, *setting)
        }
    }

    /// The model with one effect, from its typical size and from a tenth of it.
    fn node(case: &Case<'_>, effect: EffectId) -> Node {
        let baseline = case.baseline().unwrap();
        let model = case.model(CandidateSet::of(effect));
        let start = |share: f64| {
            case.moved(&baseline, &model, |_, k| {
                Some(share * effect.info().parameters[k].typical)
            })
        };
        case.refined(
            &baseline,
            CandidateSet::of(effect),
            &[start(1.0), start(0.1)],
        )
        .unwrap()
    }

    fn proposed(case: &Case<'_>, nodes: &[Node; 2], limits: &Limits) -> NextExperiment {
        let rivals = nodes.each_ref().map(|node| Rival {
            effect: node.effects.iter().next().unwrap(),
            node,
        });
        next_experiment(case, &rivals, limits, &nodes[0].noise)
            .unwrap()
            .unwrap()
    }

    /// By how many units of log-likelihood the first model is better on the old and the new recording, the new one
    /// played on a rig that it describes.
    fn advantage(case: &Case<'_>, nodes: &[Node; 2], run: &Run, seed: u64) -> f64 {
        let truth = &nodes[0];
        let point = without_drifts(&truth.model, &truth.points[0]);
        let silent = recording(case, run.drive.clone(), run.dt_s).unwrap();
        let clean = predict(&truth.model, &point, &silent).unwrap().output;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let noisy = |mm: &f64| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            mm + NOISE_MM * normal
        };
        let new = Recording::new(RecordingParts {
            name: "new".to_owned(),
            time_s: Some(silent.time_s().to_vec()),
            drive_quantity: silent.drive_quantity(),
            drive: run.drive.clone(),
            output_unit: "mm".to_owned(),
            output: clean.iter().map(noisy).collect(),
            ..RecordingParts::default()
        });
        let both = [case.training[0].clone(), new.unwrap()];
        let nats = nodes.each_ref().map(|node| {
            let starts = [node.coordinates.clone()];
            let end = refine(&node.model, &both, &starts, &RefineConfig::default()).unwrap();
            -0.5 * end.deviance
        });
        nats[0] - nats[1]
    }

    fn settles(truth: EffectId, size: f64, other: EffectId) -> NextExperiment {
        let slow = Slow::of(truth, size);
        let case = slow.case();
        let nodes = [node(&case, truth), node(&case, other)];
        let found = proposed(&case, &nodes, &Limits::default());
        let run = found.run.clone().unwrap();
        let advantage = advantage(&case, &nodes, &run, 5);
        assert!(advantage > 3.0, "{}: {advantage} nats", found.sentence);
        let apart = [run.separation, run.separation_now];
        assert!(apart[0] > ENOUGH && apart[1] < ENOUGH, "{apart:?}");
        assert!(run.decisive.end <= run.drive.len());
        found
    }

    #[test]
    fn dead_time_is_told_from_a_lag_of_the_output() {
        let found = settles(EffectId::DeadTime, 0.15, EffectId::OutputLag);
        let wanted = "It should tell dead time and lag of the output apart (";
        assert!(found.sentence.starts_with("Play this run of "));
        assert!(found.sentence.contains(wanted), "{}", found.sentence);
    }

    #[test]
    fn a_lag_of_the_output_is_told_from_dead_time() {
        settles(EffectId::OutputLag, 0.15, EffectId::DeadTime);
    }

    #[test]
    fn fatigue_is_told_from_a_drift_of_the_surroundings() {
        settles(EffectId::FunctionalFatigue, 0.12, EffectId::AmbientDrift);
    }

    #[test]
    fn radiation_is_told_from_convection() {
        settles(EffectId::Radiation, 0.5, EffectId::NaturalConvection);
    }

    #[test]
    fn the_run_stays_within_the_limits_and_is_always_the_same() {
        let slow = Slow::of(EffectId::DeadTime, 0.4);
        let case = slow.case();
        let nodes = [
            node(&case, EffectId::DeadTime),
            node(&case, EffectId::OutputLag),
        ];
        for limits in [
            Limits::default(),
            Limits {
                drive_max: Some(1.9),
                temperature_max_degc: Some(72.0),
                duration_s: Some(60.0),
            },
            Limits {
                drive_max: Some(4.0),
                temperature_max_degc: Some(90.0),
                duration_s: None,
            },
        ] {
            let found = proposed(&case, &nodes, &limits);
            assert_eq!(found, proposed(&case, &nodes, &limits));
            let run = found.run.unwrap();
            assert!(run.duration_s() <= limits.duration_s.unwrap_or(720.0) + 1e-9);
            assert!(
                run.drive
                    .iter()
                    .all(|drive| *drive <= limits.drive_max.unwrap_or(2.4))
            );
            let played = recording(&case, run.drive, run.dt_s).unwrap();
            for node in &nodes {
                let shown = predict(&node.model, &node.points[0], &played).unwrap();
                let peak_degc = shown.temperature_degc.iter().copied().fold(0.0, f64::max);
                assert!(
                    peak_degc <= limits.temperature_max_degc.unwrap_or(130.0),
                    "{peak_degc}"
                );
            }
        }
    }

    #[test]
    fn what_no_run_separates_is_said_to_be_so() {
        let slow = Slow::of(EffectId::DeadTime, 0.4);
        let case = slow.case();
        let nodes = [
            node(&case, EffectId::DeadTime),
            node(&case, EffectId::DeadTime),
        ];
        let found = proposed(&case, &nodes, &Limits::default());
        assert!(found.run.is_none());
        let wanted = "No run within the limits tells dead time and dead time apart";
        assert!(found.sentence.starts_with(wanted), "{}", found.sentence);
    }

    #[test]
    fn where_no_run_tells_a_thermocouple_may() {
        let slow = Slow::of(EffectId::LatentHeat, 5_000.0);
        let case = slow.case();
        let nodes = [
            node(&case, EffectId::LatentHeat),
            node(&case, EffectId::StressCoupling),
        ];
        let limits = Limits {
            duration_s: Some(0.2),
            ..Limits::default()
        };
        let found = proposed(&case, &nodes, &limits);
        assert!(found.run.is_none());
        let wanted = "Record the rod's temperature in runs like these: ";
        assert!(found.sentence.starts_with(wanted), "{}", found.sentence);
    }

    #[test]
    fn one_explanation_needs_no_run() {
        let slow = Slow::of(EffectId::DeadTime, 0.4);
        let case = slow.case();
        let node = node(&case, EffectId::DeadTime);
        let alone = [Rival {
            effect: EffectId::DeadTime.into(),
            node: &node,
        }];
        let found = next_experiment(&case, &alone, &Limits::default(), &node.noise).unwrap();
        assert_eq!(found, None);
    }

    #[test]
    fn the_decisive_samples_are_the_shortest_stretch_with_half() {
        assert_eq!(decisive(&[0.0, 1.0, 1.0, 4.0, 5.0, 0.0, 9.0], 6), 3..5);
        assert_eq!(decisive(&[2.0, 0.0, 0.0], 3), 0..1);
    }
}
