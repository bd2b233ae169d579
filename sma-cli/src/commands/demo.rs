//! `sma demo`: all of it on a rig that conceals something, in seconds.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use comfy_table::{Cell, Table};
use identify::{Identification, Provenance, RigModel, SavedModel, WienerModel};
use missing_physics::{DiagnoseConfig, Diagnosis, RestoredModel, diagnose, setting_of_rod};
use pid_tune::{
    ClosedLoop, ClosedLoopParams, CostWeights, Disturbances, Goal, PidGains, Plants, Reference,
    Task, TunerConfig, tune,
};
use rig_files::rod_file;
use truth_plant::{Shape, Traces, TruthPlant};

use crate::commands::diagnose::{Rig as Files, all_predicted, drawn, implausible, show};
use crate::commands::on_threads;
use crate::demo_rig::{self, DT_S};
use crate::memory::Memory;
use crate::outcome::Outcome;
use crate::provenance::provenance;
use crate::sink::Outputs;
use crate::terminal::{Progress, write_stdout};
use sma_effects::Turned;
use workbench::figure::{Figure, Series, Style};
use workbench::kept::{self, Kept};
use workbench::page::{self, Page};
use workbench::report::diagnosed::{Depth, Diagnosed};
use workbench::report::number::spoken;
use workbench::report::table::{right, table, unpadded};
use workbench::{PAPER, Rig, controller, read_all};

/// The paper's memory of reversals, which the wire has.
const MEMORY: Memory = Memory::LastReversal;

/// Set points of the controllers, mm, and how long each is held, s.
const LEVELS_MM: [f64; 4] = [3.0, 1.5, 4.0, 2.5];
const HELD_S: f64 = 60.0;

/// How near a set point counts as there, mm: 2 % of the stroke.
const THERE_MM: f64 = 0.1;

/// The last part of a hold, in which the rig should stand still, s.
const LAST_S: f64 = 20.0;

/// The largest drive that the rig stands over that of the recordings.
const RESERVE: f64 = 1.2;

/// Seed of what is drawn for the recordings and the controllers' runs.
const SEEDS: [u64; 3] = [1, 2, 3];

/// Show all of it on a rig that conceals something: identify, diagnose, tune, compare, report.
///
/// Simulates a wire with physics that the baseline model does not have, by other equations than the models', and records
/// it twice. Does with the files what you would do with yours. Then tunes a controller on the baseline model and one on the
/// extended model, and runs both on the simulated wire.
#[derive(Debug, Args)]
#[command(
    before_help = "Example:\n  \
    sma demo",
    after_help = "leaves rod.toml, train.csv, unseen.csv and report.html in the folder sma-demo."
)]
pub(crate) struct DemoArgs {
    /// Folder for the rod file, the recordings and the report; files of these names in it are replaced.
    #[arg(long, default_value = "sma-demo", value_name = "DIR")]
    out: PathBuf,
    /// Threads; 0 takes all. The result does not depend on it.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
    /// No progress.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
pub(crate) fn run(args: &DemoArgs) -> anyhow::Result<Outcome> {
    on_threads(args.threads, || demo(args))
}

fn demo(args: &DemoArgs) -> anyhow::Result<Outcome> {
    let truth = demo_rig::rig();
    let paths = Paths::recorded(&args.out, &truth)?;
    let report = Outputs::beside(&paths.inputs()).open(&paths.report)?;
    write_stdout(&format!(
        "{}\nThe program is not told. It has two recordings of current and displacement:\n  {}\n  {}\n",
        demo_rig::CONCEALED,
        paths.train.display(),
        paths.unseen.display()
    ))?;
    let known = Known::read(&paths)?;
    let diagnosis = known.diagnosed(args.quiet)?;
    let diagnosed = known.said(&diagnosis)?;
    write_stdout(&format!("\n{}", diagnosed.text(Depth::Verdict)))?;
    let made = provenance(known.config.seed, &paths.inputs())?;
    let runs = known.controlled(&diagnosis, &made, &truth)?;
    write_stdout(&format!(
        "\n{}\n{}",
        Worth::INTRODUCTION,
        unpadded(&Worth(&runs).table().to_string())
    ))?;
    report.write(&known.page(&diagnosed, &Worth(&runs))?.made_by(&made))?;
    write_stdout(&format!(
        "\nAll of it with figures: {}\nTry it yourself:\n  sma diagnose {} --train {} --validate {}\n",
        paths.report.display(),
        paths.rod.display(),
        paths.train.display(),
        paths.unseen.display()
    ))?;
    Ok(Outcome::Done)
}

/// Files that the demonstration leaves behind.
#[derive(Debug)]
struct Paths {
    rod: PathBuf,
    train: PathBuf,
    unseen: PathBuf,
    report: PathBuf,
}

impl Paths {
    /// Records the rig.
    fn recorded(folder: &Path, truth: &TruthPlant) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot be made", folder.display()))?;
        let paths = Self {
            rod: folder.join("rod.toml"),
            train: folder.join("train.csv"),
            unseen: folder.join("unseen.csv"),
            report: folder.join("report.html"),
        };
        let train = demo_rig::recorded(truth, Shape::InnerLoops, SEEDS[0])?;
        let unseen = demo_rig::recorded(truth, Shape::Steps, SEEDS[1])?;
        let largest = train.drive.iter().copied().fold(0.0, f64::max);
        for (path, text) in [
            (&paths.rod, demo_rig::rod_file(truth, RESERVE * largest)),
            (&paths.train, demo_rig::csv(&train)),
            (&paths.unseen, demo_rig::csv(&unseen)),
        ] {
            Outputs::beside(&[]).open(path)?.write(&text)?;
        }
        Ok(paths)
    }

    fn inputs(&self) -> [&Path; 3] {
        [&self.rod, &self.train, &self.unseen]
    }
}

/// Data that a user would have.
#[derive(Debug)]
struct Known {
    files: Files,
    model: RigModel,
    config: DiagnoseConfig,
}

impl Known {
    fn read(paths: &Paths) -> anyhow::Result<Self> {
        let rod = rod_file::read(&paths.rod)?;
        let training = read_all(&rod, std::slice::from_ref(&paths.train))?;
        let unseen = read_all(&rod, std::slice::from_ref(&paths.unseen))?;
        Ok(Self {
            model: RigModel::new(&rod, MEMORY.rule(), &training)?,
            config: DiagnoseConfig {
                setting: setting_of_rod(&rod, training[0].output_unit()),
                limits: rod.limits,
                ..DiagnoseConfig::default()
            },
            files: Files {
                rod,
                training,
                unseen,
                notes: Vec::new(),
            },
        })
    }

    fn plain(&self) -> &WienerModel {
        let RigModel::Wiener(plain) = &self.model else {
            unreachable!("its recordings have a time");
        };
        plain
    }

    fn diagnosed(&self, quiet: bool) -> anyhow::Result<Diagnosis> {
        let Files {
            training, unseen, ..
        } = &self.files;
        let config = &self.config;
        let mut shown = Progress::new(quiet, config.baseline.starts, "diagnose {bar:20}  {msg}");
        let progress = &mut |progress| {
            show(&mut shown, &progress);
            ControlFlow::Continue(())
        };
        let diagnosis = diagnose(self.plain(), training, unseen, config, progress)?;
        shown.end();
        Ok(diagnosis)
    }

    /// The true rig under a controller tuned on the baseline model, and under one tuned on the extended model.
    fn controlled(
        &self,
        diagnosis: &Diagnosis,
        made: &Provenance,
        truth: &TruthPlant,
    ) -> anyhow::Result<Vec<Run>> {
        let Files {
            rod,
            training,
            unseen,
            ..
        } = &self.files;
        let plain = SavedModel::of(
            &Identification {
                rod,
                model: &self.model,
                effects: None,
                rule: MEMORY.rule(),
                fit: &diagnosis.baseline.fit,
                training,
                unseen,
                validated: &diagnosis.baseline.validated,
            },
            made.clone(),
        );
        let mended = Kept::of(
            &kept::Diagnosed {
                rod,
                plain: &self.model,
                rule: MEMORY.rule(),
                setting: &self.config.setting,
                training,
                unseen,
                diagnosis,
            },
            made.clone(),
        );
        let mut jobs = vec![("baseline model", Style::Plain, Job::of(&plain)?)];
        if let Some(mended) = &mended.model {
            jobs.push(("extended model", Style::Extended, Job::of(mended)?));
        }
        let (_, _, of_plain) = &jobs[0];
        let paper = of_plain.task.evaluate(&[(of_plain.rig.member, PAPER)])?;
        let weights = CostWeights::balancing(&paper[0]);
        jobs.iter()
            .map(|(tuned_on, style, job)| {
                let gains = job.tuned(&weights)?;
                let pid = *job.task.pid();
                let traces = demo_rig::controlled(truth, (pid, gains), &setpoints_mm(), SEEDS[2])?;
                Ok(Run {
                    tuned_on,
                    style: *style,
                    gains,
                    traces,
                })
            })
            .collect()
    }

    fn said<'a>(&self, diagnosis: &'a Diagnosis) -> anyhow::Result<Diagnosed<'a>> {
        Ok(Diagnosed {
            diagnosis,
            without: &[],
            specific_heat: None,
            resistivity: None,
            memory: MEMORY.name(),
            missing_for_temperature: Vec::new(),
            implausible: implausible(&self.files, self.plain(), diagnosis)?,
            input_notes: vec![demo_rig::CONCEALED.to_owned()],
        })
    }

    /// The diagnosis, and what the extended model is worth.
    fn page(&self, diagnosed: &Diagnosed<'_>, worth: &Worth<'_>) -> anyhow::Result<Page> {
        let predicted = all_predicted(self.plain(), diagnosed.diagnosis, &self.files)?;
        let drawn = drawn(diagnosed, &predicted);
        let mut page = page::diagnosed(diagnosed, Some(&drawn))?;
        page.section("What the extended model is worth: controllers on the true wire");
        page.paragraphs(Worth::INTRODUCTION);
        page.figure(&worth.figure())?;
        page.table(&worth.table());
        page.notes(&diagnosed.notes());
        Ok(page)
    }
}

fn setpoints_mm() -> Vec<f64> {
    let held = samples(HELD_S);
    let levels = LEVELS_MM.iter();
    levels.flat_map(|&level| vec![level; held]).collect()
}

fn samples(length_s: f64) -> usize {
    (length_s / DT_S) as usize
}

/// A model, and the step to the first set point that a controller is tuned for.
#[derive(Debug)]
struct Job {
    rig: Rig,
    task: Task<'static, Turned>,
}

impl Job {
    fn of(saved: &SavedModel) -> anyhow::Result<Self> {
        let rig = Rig::of(saved, &RestoredModel::new(saved)?, None)?;
        let closed_loop = ClosedLoop::new(ClosedLoopParams {
            reference: Reference::Step {
                from: rig.rest_output()?,
                to: LEVELS_MM[0],
                at_s: 0.0,
            },
            n_samples: samples(HELD_S),
            ambient_degc: rig.ambient_degc,
            feed_forward: None,
            aim: None,
            disturbances: Disturbances::default(),
        })?;
        let task = Task::new(rig.fleet, closed_loop, controller(&rig, DT_S))?;
        Ok(Self { rig, task })
    }

    /// As in the paper: an ideal sensor, and no margins that would hide what a model does not know.
    fn tuned(&self, weights: &CostWeights) -> anyhow::Result<PidGains> {
        let config = TunerConfig::for_task(&self.task, self.rig.stroke())?;
        let progress = |_: &_| ControlFlow::Continue(());
        let goal = Goal::of(*weights);
        Ok(tune(
            &self.task,
            &Plants::judged(&[self.rig.member]),
            &goal,
            &config,
            progress,
        )?
        .gains)
    }
}

/// The true rig under a controller.
#[derive(Debug)]
struct Run {
    tuned_on: &'static str,
    style: Style,
    gains: PidGains,
    traces: Traces,
}

impl Run {
    /// At each set point: when the rig is there for good, s, if it is, and how far it moves in the end, mm.
    fn holds(&self) -> Vec<(Option<f64>, f64)> {
        let held = samples(HELD_S);
        let parts = self.traces.quiet_displacement_mm.chunks(held);
        let parts = parts.zip(LEVELS_MM);
        parts
            .map(|(part, level_mm)| {
                let away = part.iter().rposition(|y| (y - level_mm).abs() > THERE_MM);
                let there = away.map_or(0, |last| last + 1);
                let last = &part[part.len() - samples(LAST_S)..];
                let ends = last
                    .iter()
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| {
                        [low.min(*y), high.max(*y)]
                    });
                // One that passes by at the very end is not there.
                let stays = there + last.len() <= held;
                let there_s = stays.then_some(there as f64 * DT_S);
                (there_s, ends[1] - ends[0])
            })
            .collect()
    }
}

/// Benefit of the extended model for control: runs of the controllers tuned on each model.
#[derive(Debug)]
struct Worth<'a>(&'a [Run]);

impl Worth<'_> {
    const INTRODUCTION: &'static str = "A PID tuned on each model for speed alone, then run on the true wire through four set points of 60 s each:";

    fn table(&self) -> Table {
        let mut table = table([
            "tuned on",
            "kp A/mm",
            "ki A/(mm s)",
            "kd A s/mm",
            "within 0.1 mm after, s",
            "moves at the end, mm",
        ]);
        for run in self.0 {
            let holds = run.holds();
            let after =
                |there_s: &Option<f64>| there_s.map_or("never".to_owned(), |s| format!("{s:.0}"));
            let after: Vec<String> = holds.iter().map(|(there_s, _)| after(there_s)).collect();
            let moves = holds
                .iter()
                .map(|(_, moves_mm)| *moves_mm)
                .fold(0.0, f64::max);
            let PidGains { kp, ki, kd } = run.gains;
            table.add_row([
                Cell::new(run.tuned_on),
                right(spoken(kp)),
                right(spoken(ki)),
                right(spoken(kd)),
                right(after.join(", ")),
                right(spoken(moves)),
            ]);
        }
        table
    }

    fn figure(&self) -> Figure {
        let runs = self.0.iter().map(|run| {
            let label = format!("PID tuned on the {}", run.tuned_on);
            let Traces {
                time_s,
                quiet_displacement_mm,
                ..
            } = &run.traces;
            Series::over(label, run.style, time_s, quiet_displacement_mm)
        });
        let time_s = &self.0[0].traces.time_s;
        let setpoint = Series::over("set point", Style::Recorded, time_s, &setpoints_mm());
        Figure {
            name: "controllers",
            caption:
                "The true wire under a controller tuned on the baseline model, and on the extended one"
                    .to_owned(),
            across: "time, s".to_owned(),
            up: "displacement, mm".to_owned(),
            series: std::iter::once(setpoint).chain(runs).collect(),
            ..Figure::default()
        }
    }
}
