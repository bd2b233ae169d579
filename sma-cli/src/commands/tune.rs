//! `sma tune`: a controller for an identified model.

mod results;
mod search;
mod step;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use identify::{Provenance, SavedModel, Sensor};
use missing_physics::{RestoredModel, known_effects};
use pid_tune::{
    Answers, AntiWindup, ClosedLoop, CostWeights, DerivativeOf, InverseRun, Pace, Pid, PidGains,
    PidParams, Reference, Requirements, Screen, Task, TuneError, TunerConfig,
};
use recording::{
    ColumnSpec, Columns, DriveResolution, Quantity, ReadOptions, Recording, RecordingError,
};
use rig_files::model_file;
use sma_effects::{Member, Turned};

use crate::commands::on_threads;
use crate::outcome::Outcome;
use crate::provenance::Unread;
use crate::sink::{Delivery, Outputs, Sink, deliver};
use crate::terminal::say;
use results::{Named, Results};
use search::{Problem, Structured};
use step::Step;
use workbench::page;
use workbench::report::tuned::{Checked, TunedReport};
use workbench::{
    Bench, Followed, PAPER, Promise, Rig, RigError, Scheduled, Track, WorkbenchError, controller,
    read_perhaps_without_output, track,
};

/// Length of a run in time constants, where none is given.
const TIME_CONSTANTS: f64 = 20.0;

/// Longest run, samples: some minutes of search.
const MOST_SAMPLES: f64 = 1e6;

/// Samples in which an integral follows a drive at its limit.
pub(crate) const TRACKING_SAMPLES: f64 = 10.0;

/// Rods as likely as the identified one, on which the loop has to rest as well, and for which a response is promised.
const RESTING_RODS: usize = 50;

/// Steps of a test of the rig, as shares of the way to the set point, and how long each is held, time constants.
const STEPS: [f64; 6] = [0.0, 1.0, 0.5, 1.0, 0.25, 0.75];
/// See [`STEPS`].
const STEP_TAUS: f64 = 15.0;

/// Periods of a sine that are followed; the errors of the last one count.
const SINE_PERIODS: f64 = 3.0;

/// Tune a PID controller on an identified model: gains, how good they are, and whether the loop rests.
///
/// The swarm looks for the gains of least cost for one step of the set point, with the drive's limits, the sensor as it
/// was recorded, a sample of delay, and margins. Beside them stand rules of thumb that meet the same, and where somebody
/// else's optimizer ends.
#[derive(Debug, Args)]
#[command(
    before_help = "Example:\n  \
    sma tune model.toml --step-output 0.5 --drive-max 2.5 --sine-hz 0.007 --sine-amplitude 0.2 --sine-bias 0.5",
    after_help = "Gains are drive per error, the error in the output's own unit."
)]
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
    /// Kind of search: for gains that this rig stands, or as in the paper, with an ideal sensor and nothing required.
    #[arg(long, value_enum, default_value_t = Preset::Default)]
    preset: Preset,
    #[command(flatten)]
    structure: Structure,
    #[command(flatten)]
    required: Required,
    #[command(flatten)]
    real: Real,
    /// Weights of mean square error, energy, rise time, settling time and overshoot [default: such that each
    /// term of the response to the controller that is compared with counts one].
    #[arg(long, num_args = 5, value_names = ["MSE", "ENERGY", "RISE", "SETTLING", "OVERSHOOT"])]
    weights: Option<Vec<f64>>,
    /// From gentle (0) over balanced (0.5) to fast (1).
    #[arg(long, default_value_t = 0.5)]
    pace: f64,
    /// Rods over which is tuned: the identified one, and others as likely by the covariance of the parameters.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    rods: u16,
    /// Response that counts of these rods.
    #[arg(long, value_enum, default_value_t = Counts::Worst)]
    across: Counts,
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
    /// Write what to run on the rig with the tuned gains, steps of a CSV, and what is expected of it, with a band.
    #[arg(long, value_name = "CSV")]
    test_script: Option<PathBuf>,
    /// A recording of the rig under the tuned gains, with a column `reference_…` beside the output: did it do as promised?
    #[arg(long, value_name = "CSV")]
    check: Option<PathBuf>,
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

/// Structure of the controller.
#[derive(Debug, Args)]
struct Structure {
    /// No derivative.
    #[arg(long)]
    pi: bool,
    /// Signal that the derivative looks at.
    #[arg(long, value_enum, default_value_t = Watched::Measurement)]
    derivative_of: Watched,
    /// Time constant of the derivative's filter, s [default: four samples].
    #[arg(long, value_name = "S")]
    derivative_filter_s: Option<f64>,
    /// Anti-windup of the integral.
    #[arg(long, value_enum, default_value_t = Windup::Clamping)]
    anti_windup: Windup,
    /// Share of the set point that the proportional term sees: below 1, steps of it kick less.
    #[arg(long, default_value_t = 1.0, value_name = "0..1")]
    setpoint_weight: f64,
    /// Add the inverse of the baseline model to the drive: loop and heat balance turned around.
    #[arg(long)]
    feed_forward: bool,
    /// Try gains that are larger where the rig is flatter, by the output's level and branch, by at most this factor; they stay where that
    /// saves less than 1 % of the cost.
    #[arg(
        long,
        value_name = "FACTOR",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "4",
        allow_negative_numbers = true
    )]
    gain_schedule: Option<f64>,
}

/// Requirements that gains have to meet.
#[derive(Debug, Args)]
struct Required {
    /// Smallest gain margin where the loop is steepest.
    #[arg(long, default_value_t = 2.0, value_name = "FACTOR")]
    gain_margin: f64,
    /// Smallest phase margin there, degrees.
    #[arg(long, default_value_t = 45.0, value_name = "DEG")]
    phase_margin_deg: f64,
    /// Largest share of the drive's range by which one step of the sensor, or twice its noise, may move the drive.
    #[arg(long, default_value_t = 0.05, value_name = "SHARE")]
    kick: f64,
}

/// Sensor, delay and supply between the controller and the rig.
#[derive(Debug, Args)]
struct Real {
    /// An ideal sensor, a supply without steps, and no delay: margins are required still.
    #[arg(long, conflicts_with_all = ["quantization_step", "noise", "dead_time_samples"])]
    ideal: bool,
    /// Step of the converter that measures, in the output's unit: 5 mm in 12 bits are 0.00122 [default: as recorded].
    #[arg(long, value_name = "Y")]
    quantization_step: Option<f64>,
    /// Standard deviation of the sensor's noise, in the output's unit [default: as recorded].
    #[arg(long, value_name = "Y")]
    noise: Option<f64>,
    /// Samples from a measurement to its effect on the drive [default: 1, the time to compute it].
    #[arg(long, value_name = "N")]
    dead_time_samples: Option<usize>,
    /// Step of the drive, in its unit; 0 for none [default: as recorded].
    #[arg(long, value_name = "U")]
    drive_step: Option<f64>,
    /// Drive up to which nothing acts; 0 for none [default: as recorded].
    #[arg(long, value_name = "U")]
    drive_dead_zone: Option<f64>,
}

/// How the responses of several rods are combined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Counts {
    /// The largest cost.
    Worst,
    /// The mean of the costs.
    Mean,
}

/// Signal that the derivative looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Watched {
    /// The measurement: a step of the set point gives no kick.
    Measurement,
    /// The error.
    Error,
}

/// Anti-windup of the integral.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Windup {
    /// Nothing.
    Off,
    /// The integral waits while the drive is at a limit.
    Clamping,
    /// The integral follows the drive, within ten samples.
    BackCalculation,
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
    inputs.extend(
        args.reference
            .iter()
            .chain(&args.check)
            .map(PathBuf::as_path),
    );
    let mut outputs = Outputs::beside(&inputs);
    let files = Files {
        json: outputs.open_if(args.json.as_deref())?,
        responses: outputs.open_if(args.responses.as_deref())?,
        html: outputs.open_if(args.report.as_deref())?,
        script: outputs.open_if(args.test_script.as_deref())?,
    };
    let unread = Unread::of(&inputs);
    let saved = model_file::read_with(&args.model, &known_effects)?;
    let model = RestoredModel::new(&saved)?;
    let rig = Rig::of(&saved, &model, args.drive_max)?;
    let job = Job::new(args, &saved, &rig)?;
    let highest = job.highest()?;
    let step = Step::of(&job)?;
    let fed_back = step.fed_back(&job.bench)?;
    let answers = job.answers(highest)?;
    let screen = job.screen(highest, answers.as_ref())?;
    let staying = Structured {
        bench: job.bench,
        screen: &screen,
    };
    let compared = job.compared(&job.bench.task(fed_back)?, &screen)?;
    let set_point = rig.signed(args.step_output);
    let approaches = job.bench.approaches(set_point)?;
    let approaching = job.bench.approaching(&approaches)?;
    let [_, from_hot, from_near] = approaching;
    let rods = Rods::of(&job, &model);
    let problem = Problem {
        fed_back,
        resting: [from_hot, from_near],
        set_point,
        weights: job.weights(fed_back, compared[0].1)?,
        rods: &rods.judged,
        likely: &rods.likely,
    };
    let scheduled = job.scheduled(answers.as_ref(), &screen)?;
    let searched = problem.search(&job, staying, &scheduled)?;
    let compared = compared.into_iter().map(|(name, gains)| Named {
        name,
        gains,
        structured: staying,
    });
    let named = searched.beside(compared.collect(), job.own(staying));
    let found = Results {
        job: &job,
        step: &step,
        approaching,
        rods: &rods,
        problem: &problem,
        searched: &searched,
        named: &named,
    };
    let promise = match files.script {
        Some(_) => Some(found.promise()?),
        None => None,
    };
    let report = found.report(&model)?;
    say(args.quiet, &job.notes())?;
    say(args.quiet, &report.notes())?;
    files.write(&report, promise.as_ref(), || {
        unread.read(args.seed, &inputs)
    })?;
    Ok(match &report.checked {
        Some(checked) if !checked.kept.is_kept() => Outcome::NotAsPromised,
        _ => Outcome::Done,
    })
}

/// Files that the result goes to.
struct Files {
    json: Option<Sink>,
    responses: Option<Sink>,
    html: Option<Sink>,
    script: Option<Sink>,
}

impl Files {
    fn write(
        self,
        report: &TunedReport<'_>,
        promise: Option<&Promise>,
        made: impl FnOnce() -> Result<Provenance, WorkbenchError>,
    ) -> anyhow::Result<()> {
        let mut delivery = Delivery::default();
        delivery.of(|| deliver(&report.text(), &report.json(), self.json));
        if let Some((sink, promise)) = self.script.zip(promise) {
            delivery.of(|| sink.write(&promise.csv(&report.rig.output_unit)));
        }
        if let Some(sink) = self.responses {
            delivery.of(|| sink.write(&report.responses()));
        }
        if let Some(sink) = self.html {
            delivery.of(|| sink.write(&page::tuned(report)?.made_by(&made()?)));
        }
        delivery.end()
    }
}

/// Rods besides the identified one, as likely as it is.
struct Rods {
    /// Those whose responses count; the first is the identified one.
    judged: Vec<Member>,
    /// Those on which the loop has to rest as well.
    likely: Vec<Member>,
    /// Those on which the gains are tried in the end.
    draws: Vec<Member>,
}

impl Rods {
    fn of(job: &Job<'_>, model: &RestoredModel<'_>) -> Self {
        let (args, rig) = (job.args, job.bench.rig);
        let draws = |n, seed| rig.draws(job.saved, model, n, seed);
        let mut judged = vec![rig.member];
        // Not those that the gains are tried on afterwards.
        judged.extend(draws(usize::from(args.rods) - 1, !args.seed));
        Self {
            judged,
            likely: draws(RESTING_RODS, args.seed.wrapping_add(1)),
            draws: draws(args.draws, args.seed),
        }
    }
}

impl TuneArgs {
    /// All of the controller but its gains.
    fn controller(&self, saved: &SavedModel, rig: &Rig) -> Result<PidParams, RigError> {
        let recorded = saved.recordings.iter().find_map(|one| one.sample_time_s);
        let Some(dt_s) = self.sample_time_s.or(recorded) else {
            return Err(RigError::Missing {
                what: "--sample-time-s",
                why: "no recording of the model has one",
            });
        };
        let usual = controller(rig, dt_s);
        let structure = &self.structure;
        Ok(PidParams {
            anti_windup: match structure.anti_windup {
                Windup::Off => AntiWindup::Off,
                Windup::Clamping => AntiWindup::Clamping,
                Windup::BackCalculation => AntiWindup::BackCalculation {
                    tracking_s: TRACKING_SAMPLES * dt_s,
                },
            },
            derivative_of: match structure.derivative_of {
                Watched::Measurement => DerivativeOf::Measurement,
                Watched::Error => DerivativeOf::Error,
            },
            derivative_filter_s: structure
                .derivative_filter_s
                .unwrap_or(usual.derivative_filter_s),
            setpoint_weight: structure.setpoint_weight,
            ..usual
        })
    }

    /// Accepts a largest factor of a gain schedule, and the paper's search without one.
    fn check_schedule(&self) -> Result<(), RigError> {
        let Some(value) = self.structure.gain_schedule else {
            return Ok(());
        };
        if !(value > 1.0 && value.is_finite()) {
            return Err(RigError::Value {
                name: "--gain-schedule",
                value,
                accepted: "must be finite and > 1; it is the largest factor on the gains",
            });
        }
        if self.preset == Preset::Sadeghi {
            return Err(RigError::Missing {
                what: "a requirement for --gain-schedule",
                why: "--preset sadeghi requires nothing of gains; leave one of both out",
            });
        }
        Ok(())
    }

    /// Gains that the user gave.
    fn own_gains(&self) -> Option<PidGains> {
        let &[kp, ki, kd] = self.gains.as_deref()? else {
            return None;
        };
        Some(PidGains { kp, ki, kd })
    }

    /// True if sensor and delay are ideal, as in the paper or a textbook.
    fn is_ideal(&self) -> bool {
        self.real.ideal || self.preset == Preset::Sadeghi
    }

    fn sensor(&self, saved: &SavedModel) -> Result<Sensor, RigError> {
        let recorded = if self.is_ideal() {
            None
        } else {
            saved.sensor()
        };
        let recorded = recorded.unwrap_or(Sensor::IDEAL);
        for (name, given) in [
            ("--quantization-step", self.real.quantization_step),
            ("--noise", self.real.noise),
        ] {
            if let Some(value) = given.filter(|value| !(*value >= 0.0 && value.is_finite())) {
                let accepted = "must be finite and >= 0";
                return Err(RigError::Value {
                    name,
                    value,
                    accepted,
                });
            }
        }
        Ok(Sensor {
            step: self.real.quantization_step.unwrap_or(recorded.step),
            noise: self.real.noise.unwrap_or(recorded.noise),
            ..recorded
        })
    }

    fn resolution(&self, saved: &SavedModel) -> DriveResolution {
        let recorded = match self.is_ideal() {
            true => DriveResolution::default(),
            false => saved.drive_resolution(),
        };
        DriveResolution {
            step: self.real.drive_step.or(recorded.step),
            dead_zone: self.real.drive_dead_zone.or(recorded.dead_zone),
        }
    }

    fn dead_time_samples(&self) -> usize {
        let usual = usize::from(!self.is_ideal());
        self.real.dead_time_samples.unwrap_or(usual)
    }

    fn weights(&self, balanced: &CostWeights) -> CostWeights {
        match self.weights.as_deref() {
            Some(&[mse, energy, rise_time, settling_time, overshoot]) => CostWeights {
                mse,
                energy,
                rise_time,
                settling_time,
                overshoot,
            },
            _ => *balanced,
        }
    }
}

/// Rig and options of a call.
#[derive(Clone, Copy)]
struct Job<'a> {
    args: &'a TuneArgs,
    saved: &'a SavedModel,
    bench: Bench<'a>,
}

impl<'a> Job<'a> {
    /// Rig and options, after what can be refused before the long run is.
    fn new(args: &'a TuneArgs, saved: &'a SavedModel, rig: &'a Rig) -> anyhow::Result<Self> {
        rig.check_set_point(args.step_output)?;
        args.check_schedule()?;
        let pid = args.controller(saved, rig)?;
        let job = Self {
            args,
            saved,
            bench: Bench {
                rig,
                pid,
                sensor: args.sensor(saved)?,
                dead_time_samples: args.dead_time_samples(),
                resolution: args.resolution(saved),
                seed: args.seed,
            },
        };
        // A sample time that is none would also make a run of no length.
        Pid::new(pid, &[PAPER])?;
        if let Some(gains) = args.own_gains() {
            Pid::new(pid, &[gains])?;
        }
        Ok(job)
    }

    /// Weights of the terms, fixed beforehand: each term of the response to the controller that is compared with counts one.
    fn weights(&self, fed_back: ClosedLoop<'_>, compared: PidGains) -> anyhow::Result<CostWeights> {
        let before = self
            .bench
            .task(fed_back)?
            .response(self.bench.rig.member, compared)?;
        let balanced = self.args.weights(&CostWeights::balancing(&before.terms));
        Ok(Pace::new(self.args.pace)?.weigh(&balanced))
    }

    /// How the rig answers everywhere; `None` unless a gain schedule is asked for.
    fn answers(&self, highest: f64) -> Result<Option<Answers>, WorkbenchError> {
        let schedule = self.args.structure.gain_schedule;
        schedule.map(|_| self.bench.answers(highest)).transpose()
    }

    /// Gain schedules that are tried; none unless asked for.
    fn scheduled(
        &self,
        answers: Option<&Answers>,
        screen: &Screen,
    ) -> Result<Vec<Scheduled<'a>>, WorkbenchError> {
        let asked = answers.zip(self.args.structure.gain_schedule);
        asked.map_or(Ok(Vec::new()), |(answers, largest_factor)| {
            self.bench
                .scheduled(answers, largest_factor, *screen.requirements())
        })
    }

    /// Gains that the user gave.
    fn own<'s>(&self, structured: Structured<'s>) -> Option<Named<'s>> {
        Some(Named {
            name: "yours",
            gains: self.args.own_gains()?,
            structured,
        })
    }

    /// The step.
    fn step(&self) -> anyhow::Result<Reference<'static>> {
        Ok(Reference::Step {
            from: self.bench.rig.rest_output()?,
            to: self.bench.rig.signed(self.args.step_output),
            at_s: 0.0,
        })
    }

    fn step_samples(&self) -> Result<usize, RigError> {
        let lasts_s = TIME_CONSTANTS * self.bench.rig.tau_s();
        let duration_s = self.args.duration_s.unwrap_or(lasts_s);
        self.n_samples("--duration-s", duration_s)
    }

    /// Inverse of the baseline model along a reference; none unless asked for.
    fn forward(
        &self,
        rig: &Rig,
        reference: &Reference<'_>,
        n_samples: usize,
    ) -> anyhow::Result<Option<InverseRun>> {
        if !self.args.structure.feed_forward {
            return Ok(None);
        }
        let bench = Bench { rig, ..self.bench };
        Ok(Some(bench.forward(reference, n_samples)?))
    }

    /// The highest output that is asked for, as the controller sees it: of the step, of a sine, of files.
    fn highest(&self) -> anyhow::Result<f64> {
        let (args, rig) = (self.args, self.bench.rig);
        let mut highest = rig.signed(args.step_output);
        if let (Some(bias), Some(amplitude)) = (args.sine_bias, args.sine_amplitude) {
            for end in [bias - amplitude, bias + amplitude] {
                rig.check_set_point(end)?;
                highest = highest.max(rig.signed(end));
            }
        }
        for path in args.reference.iter().chain(&args.check) {
            let file = self.read_reference(path)?;
            let is_checked = args.check.as_ref() == Some(path);
            if is_checked && !file.has_output {
                return Err(RigError::Missing {
                    what: "the output",
                    why: "--check compares what the rig did with what was promised",
                }
                .into());
            }
            let levels = file.recording.drive().iter();
            highest = levels.fold(highest, |highest, &level| highest.max(rig.signed(level)));
        }
        Ok(highest)
    }

    /// Requirements, wherever the rig is steepest up to the highest output that is asked for; beside gain schedules everywhere.
    fn screen(&self, highest: f64, answers: Option<&Answers>) -> anyhow::Result<Screen> {
        let args = self.args;
        let requirements = Requirements {
            gain_margin: args.required.gain_margin,
            phase_margin_rad: args.required.phase_margin_deg.to_radians(),
            sensor_step: self.bench.sensor.jump(),
            largest_kick: args.required.kick,
        };
        if let Some(answers) = answers {
            return Ok(Screen::everywhere(requirements, self.bench.pid, answers)?);
        }
        let steepest = self.bench.steepest(highest)?;
        Ok(Screen::new(requirements, self.bench.pid, steepest)?)
    }

    /// Controllers by rule, the first of which is compared with in detail: in the paper's search its own; else SIMC, then
    /// a relay test, each as fast as what is required allows, and the paper's gains where they have their units.
    fn compared(
        &self,
        task: &Task<'_, Turned>,
        screen: &Screen,
    ) -> anyhow::Result<Vec<(&'static str, PidGains)>> {
        let rig = self.bench.rig;
        if self.args.preset == Preset::Sadeghi {
            return Ok(vec![("paper", PAPER)]);
        }
        let mut compared = Vec::new();
        compared.extend(screen.simc().map(|gains| ("SIMC", gains)));
        let set_point = rig.signed(self.args.step_output);
        let by_relay = self.bench.relay(set_point, screen)?;
        compared.extend(by_relay.map(|gains| ("relay test", gains)));
        if rig.drive_unit == "A" && rig.output_unit == "mm" {
            compared.push(("paper", PAPER));
        }
        // A rule that saturates for ever has no response to compare with.
        let cases: Vec<_> = compared
            .iter()
            .map(|&(_, gains)| (rig.member, gains))
            .collect();
        let responses = task.responses(&cases)?;
        let mut sound = responses.iter().map(|one| one.terms.mse.is_finite());
        compared.retain(|_| sound.next().unwrap_or(false));
        if compared.is_empty() {
            // The output does not answer the drive, or so that no rule keeps what is required.
            return Err(TuneError::Unmet.into());
        }
        Ok(compared)
    }

    /// Where gains are looked for.
    fn search(
        &self,
        task: &Task<'_, Turned>,
        screen: &Screen,
    ) -> Result<TunerConfig, WorkbenchError> {
        let mut config = TunerConfig {
            seed: self.args.seed,
            ..match self.args.preset {
                Preset::Default => self.bench.search(task, screen)?,
                Preset::Sadeghi => TunerConfig::sadeghi(),
            }
        };
        if self.args.structure.pi {
            config.bounds.upper.kd = 0.0;
        }
        Ok(config)
    }

    /// Notes on assumptions.
    fn notes(&self) -> Vec<String> {
        let real = &self.args.real;
        let told = real.quantization_step.is_some() || real.noise.is_some();
        let mut notes = Vec::new();
        if self.bench.sensor == Sensor::IDEAL && !self.args.is_ideal() && !told {
            notes.push(format!(
                "{} does not say what the sensor does by itself: identify once more, or give --quantization-step and --noise",
                self.args.model.display()
            ));
        }
        let left_out = self.saved.draws(1, self.args.seed).left_out;
        if !left_out.is_empty() {
            notes.push(format!(
                "rods as likely as the identified one all have its {}: the recordings leave no finite variance to draw it from",
                left_out.join(", ")
            ));
        }
        notes
    }

    fn n_samples(&self, name: &'static str, duration_s: f64) -> Result<usize, RigError> {
        let n_samples = (duration_s / self.bench.pid.dt_s).ceil();
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

    /// All that is followed, by two controllers.
    fn tracks(&self, step: &ClosedLoop<'_>, two: &[Named<'_>]) -> anyhow::Result<Vec<Track>> {
        let mut tracks = self.both("step", self.bench.rig, step, two)?;
        tracks.extend(self.sine(two)?);
        for path in &self.args.reference {
            tracks.extend(self.recorded(path, two)?);
        }
        Ok(tracks)
    }

    fn both(
        &self,
        name: &str,
        rig: &Rig,
        closed_loop: &ClosedLoop<'_>,
        two: &[Named<'_>],
    ) -> Result<Vec<Track>, WorkbenchError> {
        two.iter()
            .map(|one| {
                let followed = Followed {
                    name,
                    controller: one.name,
                    closed_loop,
                    pid: one.structured.bench.pid,
                    gains: one.gains,
                };
                track(rig, &followed)
            })
            .collect()
    }

    /// Two controllers along a reference, on a rig.
    fn follow(
        &self,
        name: &str,
        rig: &Rig,
        (reference, n_samples): (Reference<'_>, usize),
        two: &[Named<'_>],
    ) -> anyhow::Result<Vec<Track>> {
        let noise = self.bench.noise(n_samples);
        let forward = self.forward(rig, &reference, n_samples)?;
        let closed_loop = self
            .bench
            .closed_loop(reference, n_samples, &noise, forward.as_ref())?;
        Ok(self.both(name, rig, &closed_loop, two)?)
    }

    fn sine(&self, two: &[Named<'_>]) -> anyhow::Result<Vec<Track>> {
        let args = self.args;
        let (Some(frequency_hz), Some(amplitude), Some(bias)) =
            (args.sine_hz, args.sine_amplitude, args.sine_bias)
        else {
            return Ok(Vec::new());
        };
        let reference = Reference::Sine {
            bias: self.bench.rig.signed(bias),
            amplitude: self.bench.rig.signed(amplitude),
            frequency_hz,
        }
        .checked()?;
        let period = self.n_samples("--sine-hz", 1.0 / frequency_hz)?;
        let n_samples = (SINE_PERIODS * period as f64) as usize;
        let mut tracks = self.follow("sine", self.bench.rig, (reference, n_samples), two)?;
        for track in &mut tracks {
            track.counted = n_samples - period..n_samples;
        }
        Ok(tracks)
    }

    /// Levels of the way to the set point and back, for a test of the rig: large steps, small ones, and turns.
    fn steps(&self) -> anyhow::Result<Vec<f64>> {
        let rig = self.bench.rig;
        let rest = rig.rest_output()?;
        let way = rig.signed(self.args.step_output) - rest;
        let held = self.n_samples("length of a step, s", STEP_TAUS * rig.tau_s())?;
        let levels = STEPS.map(|share| vec![rest + share * way; held]);
        Ok(levels.concat())
    }

    /// Response and band that gains promise along a reference.
    fn promise(
        &self,
        rig: &Rig,
        levels: &[f64],
        gains: PidGains,
        rods: &[Rig],
    ) -> anyhow::Result<Promise> {
        let forward = self.forward(rig, &Reference::Samples(levels), levels.len())?;
        let bench = Bench { rig, ..self.bench };
        Ok(bench.promise(gains, levels, forward.as_ref(), rods)?)
    }

    /// Compares a recording of the rig with the promise.
    fn checked(&self, path: &Path, gains: PidGains, rods: &[Rig]) -> anyhow::Result<Checked> {
        let file = self.read_reference(path)?;
        let recording = &file.recording;
        let levels = self.held(recording)?;
        let rig = self.bench.rig.resting_at(recording.output()[0])?;
        let rods = rods.iter().map(|rod| rod.resting_at(recording.output()[0]));
        let rods: Vec<Rig> = rods.collect::<Result<_, _>>()?;
        let promise = self.promise(&rig, &levels, gains, &rods)?;
        Ok(Checked {
            name: recording.name().to_owned(),
            kept: promise.kept(recording.time_s(), recording.output()),
            n_rods: promise.n_rods,
        })
    }

    /// Levels of a reference, as the controller sees them, held between its samples if the controller has others.
    fn held(&self, recording: &Recording) -> Result<Vec<f64>, RigError> {
        let dt_s = self.bench.pid.dt_s;
        let time_s = recording.time_s();
        let lasts_s = time_s[time_s.len() - 1] - time_s[0];
        let n_samples = self.n_samples("length of the reference, s", lasts_s + dt_s)?;
        let levels = recording.held_drive(dt_s, n_samples).into_iter();
        Ok(levels.map(|level| self.bench.rig.signed(level)).collect())
    }

    /// A reference from a file. Where the rig's output was recorded beside it, the rod starts from the same
    /// rest position.
    fn recorded(&self, path: &Path, two: &[Named<'_>]) -> anyhow::Result<Vec<Track>> {
        let file = self.read_reference(path)?;
        let held = self.held(&file.recording)?;
        let rig = if file.has_output {
            self.bench.rig.resting_at(file.recording.output()[0])?
        } else {
            self.bench.rig.clone()
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let reference = (Reference::Samples(&held), held.len());
        let mut tracks = self.follow(&name, &rig, reference, two)?;
        for track in &mut tracks {
            track.recorded_rmse = file.recorded_rmse();
        }
        Ok(tracks)
    }

    fn read_reference(&self, path: &Path) -> Result<ReferenceFile, RecordingError> {
        let columns = &self.saved.rod.columns;
        let unit = self.bench.rig.output_unit.as_str();
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
