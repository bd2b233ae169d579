//! The run, or the sensor, that best tells apart what is left.

use std::ops::Range;

use identify::{IdentifyError, Limits, ResidualNoise, in_parallel};
use recording::Recording;
use recording::order::rising;

use crate::Candidate;
use crate::model::case::{Case, Node};
use crate::model::elsewhere::without_drifts;
use crate::model::series::Noise;
use crate::next::advice::{give_up, measure, play};
use crate::next::bench::{Bench, bench, hottest_degc, recording, start_and_peak_degc};
use crate::next::drives::{Plan, library};
use crate::next::run::{NextExperiment, Run};
use crate::next::separation::{Experiment, Known, Separation, least_separation};

/// Distance from which a run settles it, standard deviations: of twice the log-likelihoods' difference, normal
/// with mean d² and deviation 2d, nine tenths then lie above 6, odds of 20 to 1: d²/2 - 1.282 d = 3.
const ENOUGH: f64 = 4.05;

/// Noise of a thermocouple on a thin rod, K.
const THERMOCOUPLE_K: f64 = 0.5;

/// Repeated runs that are tried.
const REPEATED: usize = 4;

/// Share of the squares that the decisive samples hold.
const DECISIVE: f64 = 0.5;

/// A model that could be true.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rival<'a> {
    /// Effect of this model that the other rivals do not have.
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
/// Any error of simulating the models on the training.
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
    let tried = in_parallel(&library(), |plan| lab.tried(*plan));
    let tried: Vec<Tried> = tried.into_iter().flatten().collect();
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
        rising(&mut wanted, |(times, tried)| {
            (times * tried.drive.len()) as f64
        });
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

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::{CandidateSet, EffectId, EffectSet, EffectValues};
    use identify::{
        Fit, FitConfig, ForwardModel, ParameterVector, RefineConfig, fit, predict, refine,
    };
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use recording::RecordingParts;

    /// The slow recording alone, with one effect, and the baseline model fitted to it.
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
            let vector = ParameterVector::new(node.model.parameters(), both.len());
            let starts = [vector.coordinates(|parameter, _| Some(node.points[0][parameter]))];
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
        let wanted = "It should tell dead time and lag of the output apart: ";
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
