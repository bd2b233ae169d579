//! `sma diagnose`: recordings in, the physics that the baseline model leaves out.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use identify::{
    EndedStart, FitConfig, FitProgress, ForwardModel, IdentifyError, OddStep, RigModel, Rod,
    WienerModel, early_output, odd_step, predict, static_effects,
};
use missing_physics::{
    DiagnoseConfig, DiagnoseProgress, Diagnosis, Effort, SearchStep, Stage, Verdict, diagnose,
    setting_of_rod,
};
use recording::Recording;
use rig_files::{model_file, rod_file};
use sma_effects::{EffectId, EffectSet, Hypothesis, Setting};

use crate::commands::on_threads;
use crate::commands::pictures::Pictures;
use crate::commands::since::since_reference;
use crate::commands::used::UseArgs;
use crate::earlier::Earlier;
use crate::memory::Memory;
use crate::outcome::Outcome;
use crate::provenance::Unread;
use crate::resume::Starts;
use crate::sink::{Delivery, Outputs, Sink, deliver};
use crate::terminal::{Progress, say};
use workbench::figure::{Drawn, Gallery, figures, series_csv};
use workbench::kept::{self, Kept};
use workbench::next_run;
use workbench::page;
use workbench::report::diagnosed::{Depth, Diagnosed};
use workbench::report::plot::{self, Left};
use workbench::report::series::{self, Series};
use workbench::report::static_diagnosed::StaticDiagnosed;
use workbench::sanity::{Facts, Implausible};
use workbench::{
    WorkbenchError, carry_resistivity, carry_specific_heat, each_once, gap_notes, input_notes,
    is_trained_on, read_all,
};

/// Say which physics the baseline model of a rig leaves out, or that it leaves out nothing that shows.
///
/// Fits the baseline model to the training recordings, looks for what it leaves among known effects, refits with
/// what is found, and checks both on recordings that it has not seen. It also says where model and recordings
/// part, which effects these recordings exclude, and which they cannot test. Static recordings
/// (kind = "temperature") are tested for stress coupling, phase-dependent resistance and functional fatigue.
#[derive(Debug, Args)]
#[command(
    before_help = "Example:\n  \
    sma diagnose rod.toml --train ramp01.csv step01.csv --validate ramp02.csv --save-next next.csv",
    after_help = "The first line is the verdict:\n  \
    EXPLAINED: latent heat is missing from the baseline model. With it the error on the unseen recording falls from 0.92\n  \
    to 0.33 mm RMS, 1.1 times the noise.\n\
    Then record what next.csv drives, and give it as one more training recording. To see what is said if an effect\n\
    were not known, leave it out: --without latent-heat. To try an effect that is not known, write it down:\n\n  \
    [[hypothesis]]\n  \
    id = \"fan\"\n  \
    heat_flow_w_per_m = \"-k * (T - Ta) * (1 - cos(2 * pi * t / 50))\"\n  \
    [hypothesis.parameters.k]\n  \
    unit = \"W/(m K)\"\n  \
    typical = 0.02\n  \
    bounds = [0.0, 0.2]\n\n\
    Other places: drive, shift_k, displacement. Variables: T Ta xi drive t dir y.\n\n\
    Effects: supply-limit supply-lag dead-time latent-heat radiation natural-convection phase-dependent-resistance ambient-drift\n\
    end-conduction return-point-memory loop-shape stress-coupling loop-asymmetry functional-fatigue r-phase\n\
    thermal-expansion end-stop backlash output-lag sensor-nonlinearity sensor-drift thermocouple-lag\n\n\
    Exit codes: 0 done, 1 failed, 2 usage, 3 bad input, 4 the baseline model did not converge, is implausible, or\n  \
    does not describe the recordings, 130 interrupted"
)]
pub(crate) struct DiagnoseArgs {
    /// Rod file: known properties of the rig.
    rod: PathBuf,
    /// Recordings that decide, CSV.
    #[arg(long, num_args = 1.., required = true, value_name = "CSV")]
    train: Vec<PathBuf>,
    /// Runs of the rig as it should be, CSV: says what has changed since in those of --train. Two at least, each with a slow cooling.
    /// With --report, a page shows the runs beside what the reference predicts.
    #[arg(long, num_args = 1.., value_name = "CSV", conflicts_with_all = ["validate", "from_model", "save_model", "save_next", "plots",
        "series", "resume", "effort", "time_limit_s", "verbose"])]
    pub(crate) reference: Vec<PathBuf>,
    /// Recordings to check the result on, CSV; opened once, at the end.
    #[arg(long, num_args = 1.., value_name = "CSV")]
    validate: Vec<PathBuf>,
    #[command(flatten)]
    used: UseArgs,
    /// Which reversals the hysteresis of the baseline model remembers.
    #[arg(long, value_enum, default_value_t = Memory::LastReversal)]
    pub(crate) memory: Memory,
    /// Effects that are not to be found.
    #[arg(long, num_args = 1.., value_name = "EFFECT", value_parser = EffectId::parse)]
    without: Vec<EffectId>,
    /// Hypotheses of your own that compete with the known effects, TOML: an expression at a place of the cascade.
    #[arg(long, value_name = "FILE")]
    hypothesis: Option<PathBuf>,
    /// Start one more search of the baseline model from an earlier one, or from the baseline part of one with effects.
    #[arg(long, value_name = "MODEL")]
    from_model: Option<PathBuf>,
    /// Write the model to a file, with what was found: for `sma simulate`, `sma tune`, and --from-model.
    #[arg(long, value_name = "FILE")]
    save_model: Option<PathBuf>,
    /// Write the run that would tell more, time and drive in the columns of rod.toml.
    #[arg(long, value_name = "FILE")]
    save_next: Option<PathBuf>,
    /// Draw the recording that is met worst, its loop and the errors: SVG files, each with its numbers as CSV.
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Write the result as one HTML page with figures, to read and to mail.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write every recording sample by sample, with the predictions of the models, as JSON.
    #[arg(long, value_name = "FILE")]
    series: Option<PathBuf>,
    /// Say the evidence as well: parameters, regimes, the catalogue with its limits, curves.
    #[arg(long, short)]
    verbose: bool,
    #[command(flatten)]
    pictures: Pictures,
    /// How widely is searched: quick leaves out other families of loops and other starting points, and says so; thorough tries more.
    #[arg(long, value_enum, default_value_t = EffortArg::Normal)]
    effort: EffortArg,
    /// Time after which no further part of the search is begun, s: the best so far is judged, and the parts that were left out are
    /// listed. The result then depends on the machine.
    #[arg(long, value_name = "S", value_parser = seconds)]
    time_limit_s: Option<Duration>,
    /// Seed: same seed and inputs, same result.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Threads; 0 takes all. The result does not depend on it.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
    /// Keep what the search has found in this file, and go on from what is in it. The result has the same bytes as that of
    /// a run that was not interrupted; then the file is removed.
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Write the result as JSON to a file, or to stdout instead of the text if it is "-".
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// No progress and no notes.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// Breadth of a search, as a flag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EffortArg {
    /// A first look.
    Quick,
    /// The search of the trials.
    Normal,
    /// More starts, more loops.
    Thorough,
}

impl From<EffortArg> for Effort {
    fn from(arg: EffortArg) -> Self {
        match arg {
            EffortArg::Quick => Self::Quick,
            EffortArg::Normal => Self::Normal,
            EffortArg::Thorough => Self::Thorough,
        }
    }
}

/// A time of at most a year.
fn seconds(text: &str) -> Result<Duration, String> {
    const YEAR_S: f64 = 3.2e7;
    match text.parse::<f64>() {
        Ok(time_s) if (0.0..=YEAR_S).contains(&time_s) => Ok(Duration::from_secs_f64(time_s)),
        _ => Err(format!("expected a time from 0 to {YEAR_S} s")),
    }
}

/// Places for results.
#[derive(Debug)]
struct Places {
    json: Option<Sink>,
    model: Option<Sink>,
    next: Option<Sink>,
    report: Option<Sink>,
    series: Option<Sink>,
    plots: Option<Gallery>,
}

/// Runs the command.
pub(crate) fn run(args: &DiagnoseArgs) -> anyhow::Result<Outcome> {
    on_threads(args.threads, || diagnose_rig(args))
}

fn diagnose_rig(args: &DiagnoseArgs) -> anyhow::Result<Outcome> {
    // Before the long run: a place that cannot be written to is found out now.
    let inputs = args.inputs();
    let mut outputs = Outputs::beside(&inputs);
    let places = Places {
        json: outputs.open_if(args.json.as_deref())?,
        model: outputs.open_if(args.save_model.as_deref())?,
        next: outputs.open_if(args.save_next.as_deref())?,
        report: outputs.open_if(args.report.as_deref())?,
        series: outputs.open_if(args.series.as_deref())?,
        plots: outputs.gallery_if(args.plots.as_deref())?,
    };
    outputs.reserve_if(args.resume.as_deref())?;
    let unread = Unread::of(&inputs);
    let mut rod = rod_file::read(&args.rod)?;
    let recordings = args.train.iter().chain(&args.validate);
    let recordings: Vec<PathBuf> = recordings.chain(&args.reference).cloned().collect();
    args.used.apply(&mut rod, &recordings)?;
    let (training, mut notes) = each_once(read_all(&rod, &args.train)?);
    let given = read_all(&rod, &args.validate)?;
    notes.extend(input_notes(&training, &given));
    let unseen: Vec<Recording> = given
        .into_iter()
        .filter(|one| !is_trained_on(one, &training))
        .collect();
    let rig = Rig {
        rod,
        training,
        unseen,
        notes,
    };
    if !args.reference.is_empty() {
        let made = unread.read(args.seed, &args.inputs())?;
        return since_reference(args, rig, (places.json, places.report), &made);
    }
    let model = RigModel::new(&rig.rod, args.memory.rule(), &rig.training)?;
    match &model {
        RigModel::Wiener(plain) => with_time(args, &model, plain, rig, places, unread),
        RigModel::Loop(_) | RigModel::Sadeghi(_) => without_time(args, rig, places, unread),
        RigModel::Antagonist(_) => Err(WorkbenchError::TwoRods {
            recording: rig.training[0].name().to_owned(),
        }
        .into()),
        RigModel::Thermal(_) => Err(WorkbenchError::OnlyTemperature {
            recording: rig.training[0].name().to_owned(),
        }
        .into()),
    }
}

/// Known properties of a rig, and its recordings.
#[derive(Debug)]
pub(crate) struct Rig {
    pub(crate) rod: Rod,
    pub(crate) training: Vec<Recording>,
    pub(crate) unseen: Vec<Recording>,
    /// Notes on anomalies of the recordings.
    pub(crate) notes: Vec<String>,
}

impl Rig {
    /// Puts a sample of the training right, with a note.
    fn put_right(&mut self, odd: &OddStep) {
        let recording = &mut self.training[odd.recording];
        *recording = odd.put_right(recording);
        let done = recording.adaptations().last();
        self.notes
            .extend(done.map(|done| format!("{}: {done}", recording.name())));
    }
}

fn with_time(
    args: &DiagnoseArgs,
    model: &RigModel,
    plain: &WienerModel,
    mut rig: Rig,
    places: Places,
    unread: Unread,
) -> anyhow::Result<Outcome> {
    let earlier = Earlier::read(args.from_model.as_deref(), model, &rig.training)?;
    let mut config = args.config(earlier.from, &rig)?;
    let made = unread.read(args.seed, &args.inputs())?;
    let starts = Starts::open(args.resume.as_deref(), "diagnose", &made)?;
    config.baseline.ended = starts.ended();
    let mut shown = Progress::new(
        args.quiet,
        config.baseline.starts,
        "diagnose {bar:20}  {msg}",
    );
    let mut keep = |ended: &EndedStart| starts.keep(ended);
    let mut diagnosis = diagnosed(plain, &rig, &config, &mut shown, &mut keep)?;
    // A second search has no time of its own.
    let odd = match args.time_limit_s {
        None => odd_sample(plain, &rig, &diagnosis)?,
        Some(_) => None,
    };
    if let Some(odd) = odd {
        rig.put_right(&odd);
        // Starts of before have ended at other recordings.
        config.baseline.ended = Vec::new();
        diagnosis = diagnosed(plain, &rig, &config, &mut shown, &mut |_| ())?;
    }
    shown.end();
    let specific_heat = carry_specific_heat(&rig.rod, plain, &mut diagnosis);
    let resistivity = carry_resistivity(&rig.rod, &mut diagnosis);
    let run = diagnosis
        .next_experiment
        .as_ref()
        .and_then(|next| next.run.as_ref());
    let mut notes = rig.notes.clone();
    let tau_s = diagnosis.baseline.fit.parameter("tau_s");
    let tau_s = tau_s.map(|tau_s| tau_s.values[0]);
    notes.extend(gap_notes(rig.training.iter().chain(&rig.unseen), tau_s));
    notes.extend(earlier.note);
    let diagnosed = kept::Diagnosed {
        rod: &rig.rod,
        plain: model,
        rule: args.memory.rule(),
        setting: &config.setting,
        training: &rig.training,
        unseen: &rig.unseen,
        diagnosis: &diagnosis,
    };
    let kept = places.model.as_ref();
    let kept = kept.map(|_| Kept::of(&diagnosed, made.clone()));
    notes.extend(kept.as_ref().map(|kept| kept.note.clone()));
    if places.next.is_some() && run.is_none() {
        notes.push("no next run is proposed: --save-next writes nothing".to_owned());
    }
    let diagnosed = Diagnosed {
        diagnosis: &diagnosis,
        without: &args.without,
        specific_heat,
        resistivity,
        memory: args.memory.name(),
        implausible: implausible(&rig, plain, &diagnosis)?,
        missing_for_temperature: if plain.knows_temperature() {
            Vec::new()
        } else {
            rig.rod.missing_for_temperature()
        },
        input_notes: notes,
    };
    say(args.quiet, &diagnosed.notes())?;
    let mut delivery = Delivery::default();
    if let Some((sink, model)) = places.model.zip(kept.and_then(|kept| kept.model)) {
        delivery.of(|| sink.write(&model_file::to_toml(&model)?));
    }
    if let Some((sink, run)) = places.next.zip(run) {
        delivery.of(|| sink.write(&next_run::csv(run, &rig.rod)));
    }
    let mut text = diagnosed.text(if args.verbose {
        Depth::Evidence
    } else {
        Depth::Verdict
    });
    let has_converged = diagnosis.verdict != Verdict::NotConverged;
    // Simulated only for those who want to see it.
    let is_shown = args.pictures.plot || places.plots.is_some() || places.report.is_some();
    let predicted = if is_shown || places.series.is_some() {
        all_predicted(plain, &diagnosis, &rig)?
    } else {
        Vec::new()
    };
    let drawn = (is_shown && has_converged).then(|| drawn(&diagnosed, &predicted));
    if let Some(drawn) = &drawn {
        text += &args.pictures.of(args.quiet, || {
            let worst = &drawn.compared[0];
            plot::what_is_left(worst.name, worst.recording, worst.models)
        })?;
        if let Some(gallery) = &places.plots {
            delivery.of(|| {
                gallery.hang(&figures(drawn))?;
                Ok(gallery.keep(&series_csv(drawn))?)
            });
        }
    }
    if let Some(sink) = places.report {
        delivery.of(|| {
            let mut page = page::diagnosed(&diagnosed, drawn.as_ref())?;
            page.notes(&diagnosed.notes());
            sink.write(&page.made_by(&made))
        });
    }
    if let Some(sink) = places.series {
        delivery.of(|| sink.write(&(series::json("diagnose", &predicted).to_string() + "\n")));
    }
    delivery.of(|| deliver(&text, &diagnosed.json(), places.json));
    delivery.end()?;
    starts.finish()?;
    Ok(if !has_converged {
        Outcome::NotConverged
    } else if !diagnosed.implausible.is_empty() {
        Outcome::Implausible
    } else if diagnosed.describes() {
        Outcome::Done
    } else {
        Outcome::NotDescribed
    })
}

/// The diagnosis of a rig, with its progress shown; starts of the baseline model are kept as they end.
fn diagnosed(
    plain: &WienerModel,
    rig: &Rig,
    config: &DiagnoseConfig,
    shown: &mut Progress,
    keep: &mut (dyn FnMut(&EndedStart) + Send),
) -> Result<Diagnosis, IdentifyError> {
    diagnose(plain, &rig.training, &rig.unseen, config, &mut |progress| {
        show(shown, &progress);
        if let DiagnoseProgress::Baseline(so_far) = &progress {
            keep(&so_far.ended);
        }
        ControlFlow::Continue(())
    })
}

/// A drive sample of the training that does not fit the output by the last model of a diagnosis, unless recordings are used as they are.
fn odd_sample(
    plain: &WienerModel,
    rig: &Rig,
    diagnosis: &Diagnosis,
) -> Result<Option<OddStep>, IdentifyError> {
    if !rig.rod.columns.may_mend() {
        return Ok(None);
    }
    let (model, fit): (&dyn ForwardModel, _) = match &diagnosis.extended {
        Some(extended) => (&extended.model, &extended.stage.fit),
        None => (plain, &diagnosis.baseline.fit),
    };
    odd_step(model, fit, &rig.training)
}

/// Why the last model of a diagnosis cannot be, if it cannot.
pub(crate) fn implausible(
    rig: &Rig,
    plain: &WienerModel,
    diagnosis: &Diagnosis,
) -> Result<Vec<Implausible>, IdentifyError> {
    let before = &diagnosis.baseline.fit;
    let extended = diagnosis.extended.as_ref();
    let fit = extended.map_or(before, |extended| &extended.stage.fit);
    // What has a name is no clock.
    let early = match diagnosis.verdict {
        Verdict::ExplainedInPart | Verdict::Unexplained => {
            early_output(plain, &rig.training, before)?
        }
        _ => None,
    };
    Ok(
        Facts::of(&rig.rod, fit, &rig.training, plain.knows_temperature())
            .with_early_output(early, before)
            .implausible(),
    )
}

fn without_time(
    args: &DiagnoseArgs,
    rig: Rig,
    places: Places,
    unread: Unread,
) -> anyhow::Result<Outcome> {
    let made = unread.read(args.seed, &args.inputs())?;
    let starts = Starts::open(args.resume.as_deref(), "diagnose", &made)?;
    let config = FitConfig {
        seed: args.seed,
        ended: starts.ended(),
        ..FitConfig::default()
    };
    let mut shown = Progress::new(args.quiet, config.starts, "diagnose {bar:20}  {msg}");
    let effects = static_effects(
        &rig.rod,
        args.memory.rule(),
        &rig.training,
        &config,
        &mut |progress| {
            fitting(&mut shown, progress);
            starts.keep(&progress.ended);
            ControlFlow::Continue(())
        },
    )?;
    shown.end();
    let mut notes = rig.notes;
    let unused: Vec<&str> = [
        ("--validate", !args.validate.is_empty()),
        ("--without", !args.without.is_empty()),
        ("--hypothesis", args.hypothesis.is_some()),
        ("--from-model", args.from_model.is_some()),
        ("--save-model", args.save_model.is_some()),
        ("--save-next", args.save_next.is_some()),
        ("--plots", args.plots.is_some()),
        ("--report", args.report.is_some()),
        ("--series", args.series.is_some()),
        ("--effort", args.effort != EffortArg::Normal),
        ("--time-limit-s", args.time_limit_s.is_some()),
        ("--verbose", args.verbose),
        ("--plot", args.pictures.plot),
    ]
    .into_iter()
    .filter_map(|(flag, is_given)| is_given.then_some(flag))
    .collect();
    if !unused.is_empty() {
        notes.push(format!(
            "not used on static recordings: {}",
            unused.join(", ")
        ));
    }
    let diagnosed = StaticDiagnosed {
        effects: &effects,
        output_unit: rig.training[0].output_unit(),
        seed: args.seed,
        memory: args.memory.name(),
        notes,
    };
    say(args.quiet, &diagnosed.notes)?;
    deliver(&diagnosed.text(), &diagnosed.json(), places.json)?;
    starts.finish()?;
    Ok(match diagnosed.verdict() {
        Some(Verdict::NotConverged) => Outcome::NotConverged,
        _ => Outcome::Done,
    })
}

impl DiagnoseArgs {
    /// All files that are read.
    fn inputs(&self) -> Vec<&Path> {
        std::iter::once(&self.rod)
            .chain(&self.train)
            .chain(&self.validate)
            .chain(&self.reference)
            .chain(&self.hypothesis)
            .chain(&self.from_model)
            .map(PathBuf::as_path)
            .collect()
    }

    #[allow(
        clippy::needless_update,
        reason = "a setting that is not a flag has its default"
    )]
    pub(crate) fn config(&self, from: Vec<Vec<f64>>, rig: &Rig) -> anyhow::Result<DiagnoseConfig> {
        let preset = DiagnoseConfig::default();
        let catalogue = self
            .without
            .iter()
            .fold(EffectSet::all(), |all, effect| all.without(*effect));
        let hypotheses: &[Hypothesis] = match &self.hypothesis {
            Some(path) => Hypothesis::read(path)?,
            None => &[],
        };
        Ok(DiagnoseConfig {
            setting: Setting {
                hypotheses,
                ..setting_of_rod(&rig.rod, rig.training[0].output_unit())
            },
            catalogue,
            limits: rig.rod.limits,
            baseline: FitConfig {
                from,
                starts: Effort::from(self.effort).starts(),
                until_agreed: Effort::from(self.effort).until_agreed(),
                ..preset.baseline.clone()
            },
            effort: self.effort.into(),
            time_limit: self.time_limit_s,
            seed: self.seed,
            ..preset
        })
    }
}

/// Share of the time of a diagnosis that is over when these stages begin: the middle one of 20 rigs (0.23 to 0.89, 0.56 to 0.97, and 0.84
/// to 0.98). Before them it is from a fiftieth to three quarters, which tells nothing.
const BEFORE_JUDGING: f64 = 0.7;
const BEFORE_REFIT: f64 = 0.9;
const BEFORE_LOCATING: f64 = 0.95;

pub(crate) fn show(shown: &mut Progress, progress: &DiagnoseProgress) {
    match progress {
        DiagnoseProgress::Baseline(so_far) => fitting(shown, so_far),
        DiagnoseProgress::Search { step, simulations } => {
            let how_far = format!(", {simulations} simulations");
            match step {
                SearchStep::Effects => shown.show("trying effects", None, &how_far),
                SearchStep::OtherLoops => shown.show("trying other loops", None, &how_far),
                SearchStep::MoreEffects => shown.show("trying more effects", None, &how_far),
                SearchStep::Judged => {
                    shown.show_timed("judging what could lead", BEFORE_JUDGING, &how_far);
                }
            }
        }
        DiagnoseProgress::Refit => {
            shown.show_timed("refitting with what was found", BEFORE_REFIT, "");
        }
        DiagnoseProgress::Locate => shown.show_timed("locating the error", BEFORE_LOCATING, ""),
    }
}

fn fitting(shown: &mut Progress, progress: &FitProgress) {
    let how_far = format!(", RMSE {:.4}", progress.lowest_rmse);
    let done = [progress.starts, progress.of];
    shown.show("fitting the baseline model", Some(done), &how_far);
}

/// Every recording with the predictions of the baseline and the extended model, in the order in which they were given.
pub(crate) fn all_predicted<'a>(
    plain: &WienerModel,
    diagnosis: &Diagnosis,
    rig: &'a Rig,
) -> anyhow::Result<Vec<Series<'a>>> {
    let baseline = &diagnosis.baseline;
    let n_trained = rig.training.len();
    let point = |stage: &Stage, k: usize| match k.checked_sub(n_trained) {
        None => stage.fit.point(k),
        Some(unseen) => stage.validated[unseen].point.clone(),
    };
    let recordings = rig.training.iter().chain(&rig.unseen).enumerate();
    recordings
        .map(|(k, recording)| {
            let mut models = vec![Left {
                model: "baseline",
                prediction: predict(plain, &point(baseline, k), recording)?,
            }];
            if let Some(extended) = &diagnosis.extended {
                models.push(Left {
                    model: "extended",
                    prediction: predict(&extended.model, &point(&extended.stage, k), recording)?,
                });
            }
            Ok(Series {
                recording,
                is_training: k < n_trained,
                models,
            })
        })
        .collect()
}

/// A diagnosis to be drawn: the recording that the baseline model meets worst comes first, the others in their order.
pub(crate) fn drawn<'a>(diagnosed: &Diagnosed<'a>, predicted: &'a [Series<'a>]) -> Drawn<'a> {
    let baseline = &diagnosed.diagnosis.baseline;
    let trained = baseline.fit.recordings.iter().map(|one| one.rmse);
    let errors: Vec<f64> = trained
        .chain(baseline.validated.iter().map(|one| one.rmse))
        .collect();
    let worst = (0..errors.len()).max_by(|&a, &b| errors[a].total_cmp(&errors[b]));
    let mut order: Vec<usize> = (0..predicted.len()).collect();
    order[..=worst.unwrap_or(0)].rotate_right(1);
    let named = order.into_iter().map(|k| {
        let one = &predicted[k];
        let name = diagnosed.label(one.recording.name());
        (one.recording, name, one.models.as_slice())
    });
    Drawn::new(diagnosed.diagnosis, named)
}
