//! `sma identify`: recordings in, an identified model out.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use identify::{
    CrossVerdict, Fit, FitConfig, Identification, Loss, RigModel, Rod, SadeghiModel, SavedModel,
    Validated, cross_check, early_output, fit, predict, validate,
};
use missing_physics::{carry_loop_shape, other_loops, setting_of_rod};
use recording::{Recording, has_one_rate, repeat_floor};

use crate::commands::on_threads;
use crate::commands::pictures::Pictures;
use crate::commands::used::UseArgs;
use crate::earlier::Earlier;
use crate::memory::Memory;
use crate::outcome::Outcome;
use crate::provenance::Unread;
use crate::resume::Starts;
use crate::sink::{Delivery, Outputs, deliver};
use crate::terminal::{bar, say};
use rig_files::{model_file, rod_file};
use workbench::figure::Compared;
use workbench::page;
use workbench::report::identified::Identified;
use workbench::report::plot::{self, Left};
use workbench::report::repeated;
use workbench::report::series::{self, Series};
use workbench::sanity::Facts;
use workbench::{each_once, gap_notes, input_notes, is_trained_on, read_all};

/// Fit the grey-box model to recordings, and check it on recordings it has not seen.
///
/// rod.toml says what is known of the rig; what it omits is identified where the data allow. Several
/// training recordings are fitted together, each with its own offset.
#[derive(Debug, Args)]
#[command(
    before_help = "Example:\n  \
    sma identify rod.toml --train ramp01.csv step01.csv --validate ramp02.csv --save-model model.toml",
    after_help = "Exit codes: 0 done, 1 failed, 2 usage, 3 bad input, 4 done but not converged or implausible, 130 interrupted"
)]
pub(crate) struct IdentifyArgs {
    /// Rod file: known properties of the rig.
    rod: PathBuf,
    /// Recordings to fit, CSV.
    #[arg(long, num_args = 1.., required = true, value_name = "CSV")]
    train: Vec<PathBuf>,
    /// Recordings to check the fit on, CSV; never used in the fit.
    #[arg(long, num_args = 1.., value_name = "CSV")]
    validate: Vec<PathBuf>,
    #[command(flatten)]
    used: UseArgs,
    /// Which reversals the hysteresis remembers.
    #[arg(long, value_enum, default_value_t = Memory::LastReversal)]
    memory: Memory,
    /// Loss to minimize: the mean square, or Huber's loss, which is robust to outliers.
    #[arg(long, value_enum, default_value_t = LossArg::Squares)]
    loss: LossArg,
    /// How is searched: by several swarms with least squares after each, or as in the paper.
    #[arg(long, value_enum, default_value_t = Preset::Default)]
    preset: Preset,
    /// Independent starts of the search [default: 4; with --preset sadeghi 1].
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    starts: Option<u64>,
    /// Start one more search from an earlier model; of one with effects from its baseline part.
    #[arg(long, value_name = "MODEL")]
    from_model: Option<PathBuf>,
    /// Give the same cost to argmin's optimizers and say where they end.
    #[arg(long)]
    cross_check: bool,
    /// Write the model to a file: for `sma simulate`, `sma tune`, and --from-model.
    #[arg(long, value_name = "FILE")]
    save_model: Option<PathBuf>,
    /// Write the result as one HTML page with figures, to read and to mail.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write every recording sample by sample, with the predictions of the model, as JSON.
    #[arg(long, value_name = "FILE")]
    series: Option<PathBuf>,
    #[command(flatten)]
    pictures: Pictures,
    /// Seed: same seed and inputs, same result.
    #[arg(long, default_value_t = 1)]
    seed: u64,
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
    quiet: bool,
}

/// How is searched.
#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum Preset {
    /// Swarms for the basin, least squares for the floor.
    Default,
    /// One swarm of 50 particles and 150 moves over the paper's unknowns within its bounds.
    Sadeghi,
}

/// Loss that is minimized.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum LossArg {
    /// The mean square.
    Squares,
    /// Huber's loss.
    Huber,
}

/// Runs the command.
pub(crate) fn run(args: &IdentifyArgs) -> anyhow::Result<Outcome> {
    on_threads(args.threads, || identify(args))
}

fn identify(args: &IdentifyArgs) -> anyhow::Result<Outcome> {
    // Before the long run: a place that cannot be written to is found out now.
    let inputs = args.inputs();
    let mut outputs = Outputs::beside(&inputs);
    let json = outputs.open_if(args.json.as_deref())?;
    let save_model = outputs.open_if(args.save_model.as_deref())?;
    let report = outputs.open_if(args.report.as_deref())?;
    let series = outputs.open_if(args.series.as_deref())?;
    outputs.reserve_if(args.resume.as_deref())?;
    let unread = Unread::of(&inputs);
    let mut rod = rod_file::read(&args.rod)?;
    let recordings: Vec<PathBuf> = args.train.iter().chain(&args.validate).cloned().collect();
    args.used.apply(&mut rod, &recordings)?;
    let (training, copies) = each_once(read_all(&rod, &args.train)?);
    let unseen = read_all(&rod, &args.validate)?;
    let rule = args.memory.rule();
    let model = match args.preset {
        Preset::Default => RigModel::new(&rod, rule, &training)?
            .with_open_starts(&training)
            .seeing(&unseen),
        Preset::Sadeghi => RigModel::Sadeghi(SadeghiModel::new(&rod, rule, &training)?),
    };
    let earlier = Earlier::read(args.from_model.as_deref(), &model, &training)?;
    let made = unread.read(args.seed, &inputs)?;
    let starts = Starts::open(args.resume.as_deref(), "identify", &made)?;
    let config = FitConfig {
        ended: starts.ended(),
        ..args.config(earlier.from)
    };
    let fit = fitted(args, &model, &training, &config, &starts)?;
    let (model, mut fit) = with_lag_that_shows(args, model, fit, &training, &config, &starts)?;
    let early_output = early_output(&model, &training, &fit)?;
    let other_loops = in_doubt_of_the_loop(&rod, &model, &training, &mut fit)?;
    let heat_carried = model.carry_specific_heat(&mut fit);
    let validated = unseen
        .iter()
        .map(|recording| validate(&model, &fit, recording))
        .collect::<Result<Vec<_>, _>>()?;
    let checked = args
        .cross_check
        .then(|| cross_check(&model, &training, &fit))
        .transpose()?;
    let identified = Identified {
        fit: &fit,
        validated: &validated,
        seen: unseen
            .iter()
            .map(|one| is_trained_on(one, &training))
            .collect(),
        implausible: Facts::of(&rod, &fit, &training, model.knows_temperature())
            .with_early_output(early_output, &fit)
            .implausible(),
        cross_check: checked.as_ref(),
        knows_temperature: model.knows_temperature(),
        missing_for_temperature: rod.missing_for_temperature(),
        other_loops,
        specific_heat: rod.specific_heat_range.filter(|_| heat_carried),
        is_static: matches!(model, RigModel::Loop(_)),
        one_way: match &model {
            RigModel::Loop(one) => one.one_way(),
            _ => None,
        },
        thermal: match &model {
            RigModel::Thermal(thermal) => Some(thermal),
            _ => None,
        },
        memory: args.memory.name(),
        input_notes: {
            let tau_s = fit.parameter("tau_s").map(|tau_s| tau_s.values[0]);
            let gaps = gap_notes(training.iter().chain(&unseen), tau_s);
            let mut notes = copies;
            notes.extend(input_notes(&training, &unseen));
            notes.extend(gaps);
            let all = [training.as_slice(), &unseen].concat();
            let floor = repeat_floor(&all).filter(|floor| !floor.is_noise());
            notes.extend(floor.as_ref().and_then(repeated::said));
            notes
        },
    };
    let mut notes = identified.notes();
    notes.extend(earlier.note);
    say(args.quiet, &notes)?;
    let mut delivery = Delivery::default();
    if let Some(sink) = save_model {
        let identification = Identification {
            rod: &rod,
            model: &model,
            effects: None,
            rule,
            fit: &fit,
            training: &training,
            unseen: &unseen,
            validated: &validated,
        };
        delivery.of(|| {
            let model = SavedModel::of(&identification, made.clone());
            sink.write(&model_file::to_toml(&model)?)
        });
    }
    let mut text = identified.text();
    if args.pictures.plot || report.is_some() {
        let (recording, point) = met_worst(&fit, &training, &validated, &unseen);
        let name = identified.label(recording.name());
        let prediction = predict(&model, &point, recording)?;
        text += &args
            .pictures
            .of(args.quiet, || plot::pictures(name, recording, &prediction))?;
        if let Some(sink) = report {
            let worst = Compared {
                recording,
                name,
                models: &[Left {
                    model: "identified",
                    prediction,
                }],
                spans_s: Vec::new(),
            };
            delivery.of(|| sink.write(&page::identified(&identified, &worst)?.made_by(&made)));
        }
    }
    if let Some(sink) = series {
        let simulated = simulated(&model, &fit, &training, &validated, &unseen)?;
        delivery.of(|| sink.write(&(series::json("identify", &simulated).to_string() + "\n")));
    }
    delivery.of(|| deliver(&text, &identified.json(), json));
    delivery.end()?;
    starts.finish()?;
    let beaten = checked
        .as_ref()
        .is_some_and(|one| one.verdict == CrossVerdict::EndedLower);
    Ok(if !fit.is_found() || beaten {
        Outcome::NotConverged
    } else if identified.implausible.is_empty() {
        Outcome::Done
    } else {
        Outcome::Implausible
    })
}

impl IdentifyArgs {
    /// All files that are read.
    fn inputs(&self) -> Vec<&Path> {
        std::iter::once(&self.rod)
            .chain(&self.train)
            .chain(&self.validate)
            .chain(&self.from_model)
            .map(PathBuf::as_path)
            .collect()
    }

    fn config(&self, from: Vec<Vec<f64>>) -> FitConfig {
        let preset = match self.preset {
            Preset::Default => FitConfig::default(),
            Preset::Sadeghi => FitConfig::sadeghi(),
        };
        FitConfig {
            starts: self.starts.unwrap_or(preset.starts),
            seed: self.seed,
            loss: match self.loss {
                LossArg::Squares => Loss::Squares,
                LossArg::Huber => Loss::Huber,
            },
            from,
            ..preset
        }
    }
}

fn fitted(
    args: &IdentifyArgs,
    model: &RigModel,
    training: &[Recording],
    config: &FitConfig,
    starts: &Starts,
) -> anyhow::Result<Fit> {
    let template = "identify {bar:20} start {pos}/{len}  {msg}";
    let bar = bar(args.quiet, config.starts, template);
    let fit = fit(model, training, config, &mut |progress| {
        bar.set_length(progress.of);
        bar.set_position(progress.starts);
        bar.set_message(format!("RMSE {:.4}", progress.lowest_rmse));
        starts.keep(&progress.ended);
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    Ok(fit)
}

/// The families of loops for which the intervals hold, too, where recordings of one rate tell the loop from the lag by the shape
/// of its branches alone; `None` where they have more rates.
fn in_doubt_of_the_loop(
    rod: &Rod,
    model: &RigModel,
    training: &[Recording],
    fit: &mut Fit,
) -> anyhow::Result<Option<Vec<&'static str>>> {
    let RigModel::Wiener(plain) = model else {
        return Ok(None);
    };
    if !has_one_rate(training) {
        return Ok(None);
    }
    let setting = setting_of_rod(rod, training[0].output_unit());
    let others = other_loops(plain, fit, training, setting, fit.seed)?;
    carry_loop_shape(fit, &others);
    Ok(Some(others.iter().map(|one| one.family.id()).collect()))
}

/// The model and its fit, with a sensor that lags where that shows.
fn with_lag_that_shows(
    args: &IdentifyArgs,
    model: RigModel,
    without: Fit,
    training: &[Recording],
    config: &FitConfig,
    starts: &Starts,
) -> anyhow::Result<(RigModel, Fit)> {
    let Some((lagging, from)) = model.with_lag(&without) else {
        return Ok((model, without));
    };
    let config = FitConfig {
        from,
        starts: 0,
        ..config.clone()
    };
    let with = fitted(args, &lagging, training, &config, starts)?;
    Ok(if lagging.lag_shows(&without, &with) {
        (lagging, with)
    } else {
        (model, without)
    })
}

/// All recordings with what the model says of them, those of the fit first.
fn simulated<'a>(
    model: &RigModel,
    fit: &Fit,
    training: &'a [Recording],
    validated: &[Validated],
    unseen: &'a [Recording],
) -> anyhow::Result<Vec<Series<'a>>> {
    let trained = (0..training.len()).map(|r| (&training[r], true, fit.point(r)));
    let checked = unseen.iter().zip(validated);
    let checked = checked.map(|(recording, one)| (recording, false, one.point.clone()));
    trained
        .chain(checked)
        .map(|(recording, is_training, point)| {
            let prediction = predict(model, &point, recording)?;
            Ok(Series {
                recording,
                is_training,
                models: vec![Left {
                    model: "identified",
                    prediction,
                }],
            })
        })
        .collect()
}

/// The recording of the highest error, and the model's parameters in it.
fn met_worst<'a>(
    fit: &Fit,
    training: &'a [Recording],
    validated: &[Validated],
    unseen: &'a [Recording],
) -> (&'a Recording, Vec<f64>) {
    let trained = training.iter().enumerate().map(|(r, recording)| {
        let rmse = fit.recordings[r].rmse;
        (rmse, recording, fit.point(r))
    });
    let checked = validated
        .iter()
        .zip(unseen)
        .map(|(one, recording)| (one.rmse, recording, one.point.clone()));
    let worst = trained.chain(checked).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, recording, point)) = worst else {
        unreachable!("a fit has at least one recording");
    };
    (recording, point)
}
