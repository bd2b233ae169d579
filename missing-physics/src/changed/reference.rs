//! The laws of a rig from runs of it as it should be, and what has changed in others.

use std::ops::ControlFlow;

use identify::{Fit, ForwardModel, IdentifyError, Scale, WienerModel, predict};
use recording::Recording;
use recording::order::falling;

use crate::baseline::opened::{Opened, plain_fit};
use crate::changed::answered::Answered;
use crate::changed::change::{Change, Changing, Considered, LeftOut, decided, probabilities};
use crate::changed::comparison::{Comparison, Ended, to_tell_apart};
use crate::changed::discrepancy::Discrepancy;
use crate::changed::evidence::ChangeEvidence;
use crate::changed::joint::{Joint, Runs, residual};
use crate::changed::likeliest::likeliest;
use crate::changed::version::{Version, What};
use crate::config::DiagnoseConfig;
use crate::diagnose::diagnosed;
use crate::model::case::Case;
use crate::model::coarse::{COMPARED, TOLD_APART, coarse_at};
use crate::model::unseen::validated;
use crate::noise::floor::measured;
use crate::report::formula::HALF_95;
use crate::search::families::beside;
use crate::watch::{Caller, DiagnoseProgress};
use crate::{Belongs, Candidate, CandidateSet, EffectSet, ExtendedModel, Setting};

/// Odds by which an effect must be likelier than none, for each of the catalogue, to be taken into the laws.
const ODDS: f64 = 20.0;

/// Effects that are taken into the laws beside those that were found, at most.
const MORE: usize = 3;

/// Most that a run of the reference may be said to have changed by, odds: what it exceeds them by is discrepancy.
const OF_REFERENCE: f64 = 20.0;

/// The laws of a rig, how well they meet a run that they do not know, and what may have changed since.
#[derive(Debug)]
pub struct Reference {
    base: WienerModel,
    plain: Fit,
    model: ExtendedModel,
    /// Values of all parameters in each run.
    points: Vec<Vec<f64>>,
    tau_s: f64,
    runs: Vec<Recording>,
    config: DiagnoseConfig,
    discrepancy: Discrepancy,
    left_out: Vec<LeftOut>,
    /// Values of all parameters in each run, the laws from the others; empty if there is one run.
    left_out_points: Vec<Vec<f64>>,
    /// Squares a sample that runs left out leave, white, at most.
    most: f64,
    coolings: usize,
}

impl Reference {
    /// Fits the laws to runs of the rig as it should be.
    ///
    /// The diagnosis of these runs says which effects the rig has. Drifts do not count as such, and effects with zones are
    /// left out. Effects that all runs together ask for are added. Then the laws are fitted without each run in turn, and
    /// that run is asked what has changed in it. A change found there beyond odds of 20 enlarges the discrepancy against
    /// which other runs are judged. If several runs are judged, it is enlarged so many times as much.
    ///
    /// # Errors
    ///
    /// Errors of [`diagnose`](crate::diagnose), and [`IdentifyError::Stopped`] if `progress` ended it.
    pub fn of<'p>(
        base: &WienerModel,
        runs: &[Recording],
        config: &DiagnoseConfig,
        progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
    ) -> Result<Self, IdentifyError> {
        let is_law =
            |effect: Candidate| effect.info().belongs_to == Belongs::Rig && !effect.info().costly;
        let laws = config.catalogue.iter().filter(|&one| is_law(one.into()));
        let of_laws = DiagnoseConfig {
            catalogue: laws.fold(EffectSet::EMPTY, EffectSet::with),
            ..config.clone()
        };
        let caller = Caller::new(progress, &of_laws);
        let plain = plain_fit(base, runs, &of_laws, &caller)?;
        let opened = Opened::of_runs(base, &plain, runs, &of_laws, &caller)?;
        let base = opened.base.clone();
        let diagnosis = diagnosed(opened, [runs, &[]], &of_laws, &caller)?;
        let plain = diagnosis.baseline.fit;
        let (model, fit) = match diagnosis.extended {
            Some(extended) => (extended.model, extended.stage.fit),
            None => {
                let none = CandidateSet::EMPTY;
                let model = ExtendedModel::new(&base, &plain, config.setting, none);
                (model, plain.clone())
            }
        };
        let points = fit.points();
        let loop_family = model.loop_family();
        let mut reference = Self {
            tau_s: fit.tau_s(),
            coolings: coolings(&model, &points, runs)?,
            base,
            plain,
            model,
            points,
            runs: runs.to_vec(),
            config: DiagnoseConfig {
                setting: Setting {
                    loop_family,
                    ..config.setting
                },
                ..config.clone()
            },
            discrepancy: Discrepancy::default(),
            left_out: Vec::new(),
            left_out_points: Vec::new(),
            most: 1.0,
        };
        reference.learn(is_law)?;
        Ok(reference)
    }

    /// Effects that may have appeared.
    fn catalogue(&self) -> CandidateSet {
        let all = CandidateSet::all(self.config.catalogue, self.config.setting.hypotheses);
        let beside = beside(self.config.setting.loop_family, all);
        beside.iter().filter(|one| !one.info().costly).collect()
    }

    /// Takes effects that all runs ask for into the laws; then leaves each run out.
    fn learn(&mut self, is_law: impl Fn(Candidate) -> bool) -> Result<(), IdentifyError> {
        let few = coarse_at(
            COMPARED,
            &self.model,
            (&self.points, self.tau_s),
            &self.runs,
        )?;
        let case = Case::new(&self.base, &self.plain, &few, self.config.setting)
            .with_freedom_of(&self.model);
        let all: Vec<usize> = (0..few.len()).collect();
        let laws: CandidateSet = self.catalogue().iter().filter(|&one| is_law(one)).collect();
        let version = Version::unchanged(self.model.clone(), &few);
        let mut joint = Joint::unchanged(&case, version, &self.points)?;
        let runs = Runs::of(&case, &joint.residual);
        let seed = self.config.seed;
        let tau_s = self.tau_s;
        let of_size = |joint: &Joint, rms| likeliest(joint, &runs, &all, (rms, tau_s), seed);
        let comparison = |discrepancy| Comparison {
            case: &case,
            runs: &runs,
            which: &all,
            changed: &all,
            discrepancy,
            catalogue: laws,
            with_laws: false,
        };
        let asked_for = (ODDS * laws.len().max(1) as f64).ln();
        for _ in 0..MORE {
            let discrepancy = of_size(&joint, runs.rms(&joint.residual));
            let (none, found) = comparison(discrepancy).made(joint)?;
            joint = none;
            match found.into_iter().next() {
                Some(first) if first.nats > asked_for => joint = first.joint,
                _ => break,
            }
        }
        self.model = joint.version.model().clone();
        let version = Version::unchanged(self.model.clone(), &few);
        let start = joint.in_version(&version, few.len());
        let own = of_size(&joint, runs.rms(&joint.residual));
        let joint = comparison(own).settled(Joint::at(&case, version, start)?)?;
        self.points = joint.points(few.len());
        if few.len() < 2 {
            self.discrepancy = own;
            return Ok(());
        }
        let mut without = Vec::new();
        let mut squares = 0.0;
        for left in 0..few.len() {
            let others: Vec<usize> = all.iter().copied().filter(|&run| run != left).collect();
            let of_others = joint.clone().settled(&case, &runs, &others, &own)?;
            let laws = of_others.point(others[0]);
            let (met, _) = validated(&self.model, &laws, &self.runs[left..=left])?;
            squares += met[0].rmse.powi(2);
            let points = all.iter().map(|&run| match run == left {
                true => met[0].point.clone(),
                false => of_others.point(run),
            });
            self.left_out_points.push(met[0].point.clone());
            without.push((met[0].rmse, points.collect::<Vec<_>>()));
        }
        let rms = (squares / few.len() as f64).sqrt();
        let discrepancy = of_size(&joint, rms);
        let mut shares = Vec::new();
        for (left, (rmse, points)) in without.into_iter().enumerate() {
            let version = Version::unchanged(self.model.clone(), &few[left..=left]);
            let beside_others = runs.beside_others(&[left]);
            let asked = Comparison {
                runs: &beside_others,
                changed: &[left],
                catalogue: self.catalogue(),
                with_laws: true,
                ..comparison(discrepancy)
            };
            let none = asked.settled(Joint::unchanged(&case, version, &points)?)?;
            let (none, found) = asked.made(none)?;
            shares.push(share(&none, &asked));
            self.left_out.push(LeftOut {
                name: self.runs[left].name().to_owned(),
                rmse,
                nats: found.first().map_or(0.0, |first| first.nats.max(0.0)),
            });
        }
        self.discrepancy = discrepancy;
        self.most = shares.into_iter().fold(0.0, f64::max);
        Ok(())
    }

    /// By how much variances are larger than they were measured, judged by what is said of runs of the reference that were left out: of
    /// one run so much, of several so much of each.
    fn enlarged(&self, n_runs: usize) -> f64 {
        let of_one = self.left_out.iter().map(|one| one.nats);
        let most = n_runs as f64 * of_one.fold(0.0, f64::max);
        (most / OF_REFERENCE.ln()).max(1.0)
    }

    /// Finds what has changed in other runs of the rig.
    ///
    /// # Errors
    ///
    /// Errors of the models.
    pub fn changed(&self, today: &[Recording]) -> Result<Change, IdentifyError> {
        Ok(self.answered(today, false)?.0)
    }

    /// As [`Reference::changed`], with the evidence for it: predictions of the runs, states of the runs, the next run.
    ///
    /// # Errors
    ///
    /// Errors of the models.
    pub fn changed_with_evidence(
        &self,
        today: &[Recording],
    ) -> Result<(Change, ChangeEvidence), IdentifyError> {
        let (change, evidence) = self.answered(today, true)?;
        let evidence = evidence.unwrap_or_else(|| unreachable!("it was asked for"));
        Ok((change, evidence))
    }

    /// The answer, with its evidence if that is wanted. Not generic over what is made of the comparison: it is long.
    fn answered(
        &self,
        today: &[Recording],
        with_evidence: bool,
    ) -> Result<(Change, Option<ChangeEvidence>), IdentifyError> {
        let n_reference = self.runs.len();
        let all: Vec<Recording> = self.runs.iter().chain(today).cloned().collect();
        let mut points = self.points.clone();
        let (own, _) = validated(&self.model, &points[0], today)?;
        points.extend(own.iter().map(|one| one.point.clone()));
        let few = coarse_at(COMPARED, &self.model, (&points, self.tau_s), &all)?;
        let case = Case::new(&self.base, &self.plain, &few, self.config.setting)
            .with_freedom_of(&self.model);
        let version = Version::unchanged(self.model.clone(), today);
        let none = Joint::unchanged(&case, version, &points)?;
        let runs = Runs::of(&case, &none.residual);
        let which: Vec<usize> = (0..all.len()).collect();
        let changed = &which[n_reference..];
        let runs = runs.beside_others(changed);
        let enlarged = self.enlarged(today.len());
        let asked = Comparison {
            case: &case,
            runs: &runs,
            which: &which,
            changed,
            discrepancy: self.discrepancy.enlarged(enlarged),
            catalogue: self.catalogue(),
            with_laws: true,
        };
        let none = asked.settled(none)?;
        let (none, mut found) = asked.made(none)?;
        self.tell_apart(&asked, &none, &all, &mut found)?;
        let nats: Vec<f64> = found.iter().map(|one| one.nats).collect();
        let (likely, each) = probabilities(&nats);
        let considered: Vec<Considered> = found
            .iter()
            .zip(each)
            .map(|(one, probability)| self.considered(one, &asked, probability))
            .collect();
        let with = found.first().map_or(&none, |first| &first.joint);
        let excess = [&none, with].map(|joint| share(joint, &asked) * enlarged / self.most);
        let (verdict, finding) = decided(&considered, likely, excess, (n_reference, self.coolings));
        let (after, _) = validated(&with.version, &with.point(n_reference), today)?;
        let answered = Answered {
            model: &self.model,
            runs: &self.runs,
            left_out_points: &self.left_out_points,
            limits: &self.config.limits,
            today,
            asked: &asked,
            found: &found,
            validated: [&own, &after],
            with,
            finding: finding.as_ref(),
            enlarged,
        };
        let evidence = with_evidence.then(|| answered.evidence()).transpose()?;
        let of_runs = own.iter().zip(&after);
        let change = Change {
            verdict,
            finding,
            considered,
            unchanged: likely,
            coolings: self.coolings,
            left_out: self.left_out.clone(),
            laws: self.model.active().iter().collect(),
            runs: of_runs
                .map(|(before, after)| (before.name.clone(), [before.rmse, after.rmse]))
                .collect(),
            excess,
            share_compared: runs.share_compared(changed),
            output_unit: all[0].output_unit().to_owned(),
        };
        Ok((change, evidence))
    }

    /// Tells the likeliest changes of `all` runs apart on more samples.
    fn tell_apart(
        &self,
        asked: &Comparison<'_>,
        none: &Joint,
        all: &[Recording],
        found: &mut Vec<Ended>,
    ) -> Result<(), IdentifyError> {
        let n = to_tell_apart(found);
        if n < 2 {
            return Ok(());
        }
        let points = none.points(all.len());
        let more = coarse_at(TOLD_APART, &self.model, (&points, self.tau_s), all)?;
        let case = asked.case.on(&more);
        let left = residual(&case, &none.version, &none.coordinates)?;
        let noise = measured(&more, self.tau_s).lower;
        let told = Comparison {
            case: &case,
            runs: &Runs::of(&case, &left).beside_others(asked.changed),
            discrepancy: asked.discrepancy.with_noise(noise),
            ..*asked
        };
        told.told_apart(&mut found[..n])?;
        falling(found, |one| one.nats);
        Ok(())
    }

    fn considered(&self, one: &Ended, asked: &Comparison<'_>, probability: f64) -> Considered {
        let infos = ForwardModel::parameters(&one.joint.version);
        let (what, place) = match one.what {
            What::Effect(effect) => {
                let first = one.joint.version.model().first_parameter(effect);
                (Changing::Appeared(effect), first.unwrap_or(0))
            }
            What::Law(law) => {
                let what = match self.model.slot(law) {
                    Some((effect, _)) => Changing::Grown(effect),
                    None => Changing::Law(infos[law].name),
                };
                (what, infos.len() - 1)
            }
        };
        let is_logarithm =
            matches!(one.what, What::Law(law) if infos[law].scale == Scale::Logarithmic);
        let change = one.joint.point(asked.changed[0])[place];
        let system = one
            .joint
            .system(asked.runs, asked.which, &asked.discrepancy);
        let coordinate = one.joint.coordinate_of(place);
        let error = coordinate.and_then(|coordinate| system.error(coordinate));
        Considered {
            what,
            parameter: infos[place].name,
            unit: if is_logarithm {
                "1".to_owned()
            } else {
                infos[place].unit.clone()
            },
            change,
            ci95: error.map(|error| [change - HALF_95 * error, change + HALF_95 * error]),
            probability,
            nats: one.nats,
        }
    }
}

/// White squares a sample that the changed runs add to those of the others.
fn share(joint: &Joint, asked: &Comparison<'_>) -> f64 {
    let changed = |run: &usize| asked.changed.contains(run);
    let others: Vec<usize> = asked
        .which
        .iter()
        .copied()
        .filter(|run| !changed(run))
        .collect();
    let squares = |which: &[usize]| {
        let system = joint.system(asked.runs, which, &asked.discrepancy);
        system.squares()
    };
    let n: usize = asked
        .changed
        .iter()
        .map(|&run| asked.runs.n_compared(run))
        .sum();
    (squares(asked.which) - squares(&others)) / n as f64
}

/// How often the rod cools through its loop.
fn coolings(
    model: &ExtendedModel,
    points: &[Vec<f64>],
    runs: &[Recording],
) -> Result<usize, IdentifyError> {
    let infos = ForwardModel::parameters(model);
    let place = |name: &str| infos.iter().position(|info| info.name == name);
    let (Some(center), Some(half)) = (place("loop_center_degc"), place("loop_half_width_k")) else {
        return Ok(0);
    };
    let mut n = 0;
    for (run, point) in runs.iter().zip(points) {
        let [upper, lower] = [1.0, -1.0].map(|side| point[center] + side * point[half]);
        let mut was_hot = false;
        for degc in predict(model, point, run)?.temperature_degc {
            if degc > upper {
                was_hot = true;
            } else if was_hot && degc < lower {
                was_hot = false;
                n += 1;
            }
        }
    }
    Ok(n)
}
