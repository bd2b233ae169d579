//! `sma tune`: a controller for an identified model.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use identify::SavedModel;
use missing_physics::{RestoredModel, read_model};
use pid_tune::{
    ClosedLoop, ClosedLoopParams, CostWeights, Disturbances, LoopAnalysis, Pace, Pid, PidGains,
    PidParams, Reference, RodLoop, RodLoopParams, Task, Terms, TunerConfig, front, robustness,
    second_opinion, sensitivities, tune,
};
use recording::{ColumnSpec, Columns, Quantity, ReadOptions, Recording, RecordingError};

use crate::commands::on_threads;
use crate::outcome::Outcome;
use crate::provenance::provenance;
use crate::sink::{Sink, deliver};
use crate::terminal::{bar, say};
use workbench::page;
use workbench::report::tuned::{Candidate, TunedReport};
use workbench::{
    Followed, PAPER, Rig, RigError, Track, WorkbenchError, controller, of_paper,
    read_perhaps_without_output, track,
};

/// Length of a run in time constants, where none is given.
const TIME_CONSTANTS: f64 = 20.0;

/// Longest run, samples: some minutes of search.
const MOST_SAMPLES: f64 = 1e6;

/// Periods of a sine that are followed; the errors of the last one count.
const SINE_PERIODS: f64 = 3.0;

/// Tune a PID controller on an identified model: gains, how good they are, and whether the loop rests.
///
/// The swarm looks for the gains of least cost for one step of the set point, with the drive's limits. Beside
/// them stand the gains of the paper and where somebody else's optimizer ends.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    sma tune model.toml --step-output 0.5 --drive-max 2.5 --sine-hz 0.007 --sine-amplitude 0.2 --sine-bias 0.5\n\n\
    Gains are drive per error, the error in the output's own unit.")]
pub(crate) struct TuneArgs {
    /// Model, from --save-model of `sma identify` or `sma diagnose`.
    model: PathBuf,
    /// Set point of the step, as the sensor reads it; the rod starts at rest.
    #[arg(long, value_name = "Y", allow_negative_numbers = true)]
    step_output: f64,
    /// Largest drive, in its unit [default: limits.drive_max of the model].
    #[arg(long, value_name = "U", allow_negative_numbers = true)]
    drive_max: Option<f64>,
    /// Gains of your own, to stand beside the others.
    #[arg(long, num_args = 3, value_names = ["KP", "KI", "KD"])]
    gains: Option<Vec<f64>>,
    /// Length of the run, s [default: twenty time constants].
    #[arg(long, value_name = "S")]
    duration_s: Option<f64>,
    /// Sample time of the controller, s [default: that of the first training recording].
    #[arg(long, value_name = "S")]
    sample_time_s: Option<f64>,
    /// How is searched: over all gains that this rig could want, or as in the paper.
    #[arg(long, value_enum, default_value_t = Preset::Default)]
    preset: Preset,
    /// Weights of mean square error, energy, rise time, settling time and overshoot [default: such that each
    /// term of the response to the paper's gains counts one].
    #[arg(long, num_args = 5, value_names = ["MSE", "ENERGY", "RISE", "SETTLING", "OVERSHOOT"])]
    weights: Option<Vec<f64>>,
    /// From gentle (0) over balanced (0.5) to fast (1).
    #[arg(long, default_value_t = 0.5)]
    pace: f64,
    /// Sine to follow: frequency, Hz.
    #[arg(long, value_name = "F", requires_all = ["sine_amplitude", "sine_bias"])]
    sine_hz: Option<f64>,
    /// Sine to follow: amplitude, in the output's unit.
    #[arg(long, value_name = "Y", requires = "sine_hz")]
    sine_amplitude: Option<f64>,
    /// Sine to follow: mean, as the sensor reads it.
    #[arg(
        long,
        value_name = "Y",
        requires = "sine_hz",
        allow_negative_numbers = true
    )]
    sine_bias: Option<f64>,
    /// References to follow, CSV with a column `reference_…`; a recorded output beside it is compared.
    #[arg(long, num_args = 1.., value_name = "CSV")]
    reference: Vec<PathBuf>,
    /// Step of the converter that measures, in the output's unit: 5 mm in 12 bits are 0.00122.
    #[arg(long, default_value_t = 0.0, value_name = "Y")]
    quantization_step: f64,
    /// Samples from a command to its effect.
    #[arg(long, default_value_t = 0, value_name = "N")]
    dead_time_samples: usize,
    /// Models drawn from the covariance of the parameters, to see what the gains stand.
    #[arg(long, default_value_t = 200, value_name = "N")]
    draws: usize,
    /// Also list the controllers of which none is both more accurate and more sparing than another.
    #[arg(long)]
    front: bool,
    /// Seed: same seed and inputs, same result.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; 0 takes all. The result does not depend on it.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
    /// Write the result as JSON to a file, or to stdout instead of the text if it is "-".
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the result as one HTML page with figures, to read and to mail.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write the responses as CSV: to the step under each controller, then to the other references.
    #[arg(long, value_name = "FILE")]
    responses: Option<PathBuf>,
    /// No progress and no notes.
    #[arg(long, short)]
    quiet: bool,
}

/// How is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Preset {
    /// Several reliable swarms over decades of each gain.
    Default,
    /// The paper's swarm, 50 particles and 150 moves, in [0, 0, 0] to [500, 1, 1].
    Sadeghi,
}

/// Runs the command.
pub(crate) fn run(args: &TuneArgs) -> anyhow::Result<Outcome> {
    on_threads(args.threads, || tuned(args))
}

fn tuned(args: &TuneArgs) -> anyhow::Result<Outcome> {
    let mut inputs = vec![args.model.as_path()];
    inputs.extend(args.reference.iter().map(PathBuf::as_path));
    let json = Sink::open_if(args.json.as_deref(), &inputs)?;
    let responses = Sink::open_if(args.responses.as_deref(), &inputs)?;
    let html = Sink::open_if(args.report.as_deref(), &inputs)?;
    let saved = read_model(&args.model)?;
    let model = RestoredModel::new(&saved)?;
    let rig = Rig::of(&saved, &model, args.drive_max)?;
    rig.check_set_point(args.step_output)?;
    let job = Job {
        args,
        pid: args.controller(&saved, &rig)?,
        rig: &rig,
        saved: &saved,
    };
    // A sample time that is none would also make a run of no length.
    Pid::new(job.pid, &[PAPER])?;
    let closed_loop = job.step()?;
    let task = Task::new(rig.fleet, closed_loop, job.pid)?;
    let member = rig.member;
    // Fixed beforehand: each term of the response to the paper's gains counts one.
    let of_paper = of_paper(&task, &rig)?;
    let weights = Pace::new(args.pace)?.weigh(&args.weights(&of_paper));
    let config = TunerConfig {
        seed: args.seed,
        ..match args.preset {
            Preset::Default => TunerConfig::for_task(&task, rig.stroke())?,
            Preset::Sadeghi => TunerConfig::sadeghi(),
        }
    };
    let template = "tune {bar:20} move {pos}/{len}  {eta} left";
    let bar = bar(args.quiet, config.moves, template);
    let found = tune(&task, member, &weights, &config, |progress| {
        bar.set_position(progress.moves);
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    let opinion = second_opinion(&task, member, &weights, &config, &found)?;
    let mut candidates = vec![
        ("paper", PAPER, of_paper),
        ("tuned", found.gains, found.terms),
        (
            "argmin from there",
            opinion.from_optimum.gains,
            opinion.from_optimum.terms,
        ),
        (
            "argmin from elsewhere",
            opinion.from_elsewhere.gains,
            opinion.from_elsewhere.terms,
        ),
    ];
    if let Some(&[kp, ki, kd]) = args.gains.as_deref() {
        let gains = PidGains { kp, ki, kd };
        let terms = task.evaluate(&[(member, gains)])?[0];
        candidates.push(("yours", gains, terms));
    }
    let candidates = candidates
        .into_iter()
        .map(|(name, gains, terms)| Candidate {
            name,
            gains,
            terms,
            cost: weights.cost(&terms),
        })
        .collect();
    let draws = rig.draws(&saved, &model, args.draws, args.seed);
    let [response] = task.responses(&[(member, found.gains)])?[..] else {
        unreachable!("one case has one response");
    };
    let height = rig.signed(args.step_output) - rig.rest_output()?;
    let report = TunedReport {
        rig: &rig,
        oscillates: response.ending.oscillates(height),
        set_point: args.step_output,
        pid: job.pid,
        duration_s: closed_loop.params().n_samples as f64 * job.pid.dt_s,
        weights,
        found,
        opinion,
        analyses: [job.analysis(PAPER)?, job.analysis(found.gains)?],
        robust: if draws.is_empty() {
            None
        } else {
            Some(robustness(&task, found.gains, &draws)?)
        },
        varied: sensitivities(&task, found.gains, &rig.variations(&saved, &model))?,
        front: if args.front {
            front(&task, member, &weights, &config)?
        } else {
            Vec::new()
        },
        tracks: job.tracks(&closed_loop, found.gains)?,
        candidates,
    };
    say(args.quiet, &report.notes())?;
    if let Some(sink) = responses {
        sink.write(&report.responses())?;
    }
    if let Some(sink) = html {
        let made = provenance(args.seed, &inputs)?;
        sink.write(&page::tuned(&report)?.made_by(&made))?;
    }
    deliver(&report.text(), &report.json(), json)?;
    Ok(Outcome::Done)
}

impl TuneArgs {
    /// All of the controller but its gains.
    fn controller(&self, saved: &SavedModel, rig: &Rig) -> Result<PidParams, RigError> {
        let recorded = saved.recordings().iter().find_map(|one| one.sample_time_s);
        let Some(dt_s) = self.sample_time_s.or(recorded) else {
            return Err(RigError::Missing {
                what: "--sample-time-s",
                why: "no recording of the model has one",
            });
        };
        Ok(controller(rig, dt_s))
    }

    fn weights(&self, of_paper: &Terms) -> CostWeights {
        match self.weights.as_deref() {
            Some(&[mse, energy, rise_time, settling_time, overshoot]) => CostWeights {
                mse,
                energy,
                rise_time,
                settling_time,
                overshoot,
            },
            _ => CostWeights::balancing(of_paper),
        }
    }

    fn disturbances(&self) -> Disturbances<'static> {
        Disturbances {
            quantization_step: self.quantization_step,
            dead_time_samples: self.dead_time_samples,
            ..Disturbances::default()
        }
    }
}

/// What is tuned for whom.
struct Job<'a> {
    args: &'a TuneArgs,
    saved: &'a SavedModel,
    rig: &'a Rig,
    pid: PidParams,
}

impl Job<'_> {
    /// The loop around the step.
    fn step(&self) -> anyhow::Result<ClosedLoop<'static>> {
        let lasts_s = TIME_CONSTANTS * self.rig.tau_s();
        let duration_s = self.args.duration_s.unwrap_or(lasts_s);
        let reference = Reference::Step {
            from: self.rig.rest_output()?,
            to: self.rig.signed(self.args.step_output),
            at_s: 0.0,
        };
        self.closed_loop(
            self.rig,
            reference,
            self.n_samples("--duration-s", duration_s)?,
        )
    }

    fn n_samples(&self, name: &'static str, duration_s: f64) -> Result<usize, RigError> {
        let n_samples = (duration_s / self.pid.dt_s).ceil();
        if (2.0..=MOST_SAMPLES).contains(&n_samples) {
            Ok(n_samples as usize)
        } else {
            Err(RigError::Value {
                name,
                value: duration_s,
                accepted: "must be 2 to 1,000,000 sample times long",
            })
        }
    }

    fn closed_loop<'r>(
        &self,
        rig: &Rig,
        reference: Reference<'r>,
        n_samples: usize,
    ) -> anyhow::Result<ClosedLoop<'r>> {
        Ok(ClosedLoop::new(ClosedLoopParams {
            reference,
            n_samples,
            ambient_degc: rig.ambient_degc,
            feed_forward: None,
            disturbances: self.args.disturbances(),
        })?)
    }

    /// Limit cycles of the plain part.
    fn analysis(&self, gains: PidGains) -> anyhow::Result<LoopAnalysis> {
        let rod_loop = RodLoop::new(RodLoopParams {
            rod: self.rig.params,
            drive: self.rig.drive,
            rule: self.rig.rule,
            controller: self.pid,
            gains,
            setpoint: self.rig.signed(self.args.step_output),
            ambient_degc: self.rig.ambient_degc,
            dead_time_samples: self.args.dead_time_samples,
            quantization_step: self.args.quantization_step,
        })?;
        Ok(rod_loop.analyzed()?)
    }

    /// All that is followed, by the paper's gains and by the tuned ones.
    fn tracks(&self, step: &ClosedLoop<'_>, tuned: PidGains) -> anyhow::Result<Vec<Track>> {
        let mut tracks = self.both("step", self.rig, step, tuned)?;
        tracks.extend(self.sine(tuned)?);
        for path in &self.args.reference {
            tracks.extend(self.recorded(path, tuned)?);
        }
        Ok(tracks)
    }

    fn both(
        &self,
        name: &str,
        rig: &Rig,
        closed_loop: &ClosedLoop<'_>,
        tuned: PidGains,
    ) -> Result<Vec<Track>, WorkbenchError> {
        [("paper", PAPER), ("tuned", tuned)]
            .into_iter()
            .map(|(controller, gains)| {
                let followed = Followed {
                    name,
                    controller,
                    closed_loop,
                    pid: self.pid,
                    gains,
                };
                track(rig, &followed)
            })
            .collect()
    }

    fn sine(&self, tuned: PidGains) -> anyhow::Result<Vec<Track>> {
        let args = self.args;
        let (Some(frequency_hz), Some(amplitude), Some(bias)) =
            (args.sine_hz, args.sine_amplitude, args.sine_bias)
        else {
            return Ok(Vec::new());
        };
        for end in [bias - amplitude, bias + amplitude] {
            self.rig.check_set_point(end)?;
        }
        let reference = Reference::Sine {
            bias: self.rig.signed(bias),
            amplitude: self.rig.signed(amplitude),
            frequency_hz,
        }
        .checked()?;
        let period = self.n_samples("--sine-hz", 1.0 / frequency_hz)?;
        let n_samples = (SINE_PERIODS * period as f64) as usize;
        let closed_loop = self.closed_loop(self.rig, reference, n_samples)?;
        let mut tracks = self.both("sine", self.rig, &closed_loop, tuned)?;
        for track in &mut tracks {
            track.counted = n_samples - period..n_samples;
        }
        Ok(tracks)
    }

    /// A reference from a file. Where the rig's output was recorded beside it, the rod starts from the same
    /// rest position.
    fn recorded(&self, path: &Path, tuned: PidGains) -> anyhow::Result<Vec<Track>> {
        let file = self.read_reference(path)?;
        let dt_s = self.pid.dt_s;
        let time_s = file.recording.time_s();
        let lasts_s = time_s[time_s.len() - 1] - time_s[0];
        let n_samples = self.n_samples("length of the reference, s", lasts_s + dt_s)?;
        // Held between its samples, if the controller has others.
        let levels = file.recording.held_drive(dt_s, n_samples).into_iter();
        let held: Vec<f64> = levels.map(|level| self.rig.signed(level)).collect();
        let rig = if file.has_output {
            self.rig.resting_at(file.recording.output()[0])?
        } else {
            self.rig.clone()
        };
        let closed_loop = self.closed_loop(&rig, Reference::Samples(&held), n_samples)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let mut tracks = self.both(&name, &rig, &closed_loop, tuned)?;
        for track in &mut tracks {
            track.recorded_rmse = file.recorded_rmse();
        }
        Ok(tracks)
    }

    fn read_reference(&self, path: &Path) -> Result<ReferenceFile, RecordingError> {
        let columns = &self.saved.rod().columns;
        let unit = self.rig.output_unit.as_str();
        // A reference is an input like that of a static loop: a number in a unit of its own.
        let options = ReadOptions {
            columns: Columns {
                time: columns.time.clone(),
                drive: Some(ColumnSpec::name(format!("reference_{unit}")).in_unit(unit)),
                output: columns.output.clone(),
                // A reference is written, not logged.
                strict: true,
                ..Columns::default()
            },
            ..ReadOptions::new(Quantity::Temperature)
        };
        let (recording, has_output) = read_perhaps_without_output(path, &options)?;
        if recording.time_s().is_empty() {
            return Err(RecordingError::NoTime {
                file: recording.name().to_owned(),
            });
        }
        Ok(ReferenceFile {
            recording,
            has_output,
        })
    }
}

/// A reference, and perhaps what a rig made of it.
struct ReferenceFile {
    recording: Recording,
    has_output: bool,
}

impl ReferenceFile {
    fn recorded_rmse(&self) -> Option<f64> {
        let pairs = self.recording.drive().iter().zip(self.recording.output());
        let squares: f64 = pairs.map(|(r, y)| (r - y) * (r - y)).sum();
        let rmse = (squares / self.recording.len() as f64).sqrt();
        self.has_output.then_some(rmse)
    }
}
