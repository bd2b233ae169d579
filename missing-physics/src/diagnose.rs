//! From a rig and its recordings to a diagnosis: the stages, in their order.

use std::ops::ControlFlow;

use identify::{Fit, IdentifyError, WienerModel};
use recording::Recording;

use crate::CandidateSet;
use crate::baseline::opened::Opened;
use crate::config::DiagnoseConfig;
use crate::decide::leading;
use crate::evidence::blocks;
use crate::model::case::Case;
use crate::model::coarse::{coarse, judged};
use crate::noise::floor::of_both;
use crate::report::{Baseline, Diagnosis, Reporting, Simulations};
use crate::search::{Survey, at, families, promoted, testable};
use crate::watch::{Caller, DiagnoseProgress, SearchStep};

/// Says which physics the baseline model of a rig leaves out.
///
/// The training recordings decide; the unseen ones are opened once, at the end. `progress` is told how far it is, by any
/// thread but by one at a time, and may end it: then no simulation is begun any more.
///
/// # Errors
///
/// Errors of [`identify::fit`] and of the models; [`IdentifyError::Stopped`] if `progress` ended it.
pub fn diagnose<'p>(
    base: &WienerModel,
    training: &[Recording],
    unseen: &[Recording],
    config: &DiagnoseConfig,
    progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
) -> Result<Diagnosis, IdentifyError> {
    let caller = Caller::new(progress, config);
    let opened = Opened::of(base, [training, unseen], config, &caller)?;
    diagnosed(opened, [training, unseen], config, &caller)
}

/// Diagnosis from a baseline that is fitted already; `recordings` are the training and the unseen ones.
///
/// # Errors
///
/// Errors of [`identify::fit`] and of the models; [`IdentifyError::Stopped`] if `progress` ended it.
pub fn diagnose_from<'p>(
    base: &WienerModel,
    plain: Fit,
    recordings: [&[Recording]; 2],
    config: &DiagnoseConfig,
    progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
) -> Result<Diagnosis, IdentifyError> {
    let caller = Caller::new(progress, config);
    let opened = Opened::from(base, plain, recordings, config, &caller)?;
    diagnosed(opened, recordings, config, &caller)
}

/// Diagnosis from a baseline model in which what belongs to recordings and runs is open as far as it is asked for.
pub(crate) fn diagnosed(
    Opened {
        base,
        plain,
        is_found,
        repeats,
    }: Opened,
    [training, unseen]: [&[Recording]; 2],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<Diagnosis, IdentifyError> {
    let [judged, judged_unseen] = judged(&base, &plain, [training, unseen])?;
    let whole = Case::new(&base, &plain, training, config.setting).watched_by(caller);
    let case = whole.on(&judged);
    let all_blocks = blocks(&case);
    let reporting = Reporting {
        blocks: &all_blocks,
        baseline: Baseline::of(&case, [unseen, &judged_unseen])?,
        noise: of_both([&judged, training], plain.tau_s()),
        repeats,
        training,
        unseen: [unseen, &judged_unseen],
        config,
        caller,
    };
    caller.begin(SearchStep::Effects)?;

    // At few samples.
    let few = coarse(&base, &plain, training)?;
    let few_case = whole.on(&few);
    let few_blocks = blocks(&few_case);
    let all = CandidateSet::all(config.catalogue, config.setting.hypotheses);
    let stand_ins = match is_found {
        true => Vec::new(),
        false => families::instead(&few_case, all, (config.effort, config.seed))?,
    };
    if !is_found && stand_ins.is_empty() {
        return Ok(reporting.not_converged());
    }
    let catalogue = testable(&case, &case.baseline()?, all)?;
    let mut survey = Survey::begun(&few_case, &few_blocks, catalogue, config)?;
    caller.begin(SearchStep::OtherLoops)?;
    let loops = survey.loops(stand_ins)?;
    caller.begin(SearchStep::MoreEffects)?;
    let few_cases = families::cases(&few_case, &loops.fits);
    survey.go_on(&few_cases, &loops)?;

    // At the judged samples.
    caller.begin(SearchStep::Judged)?;
    let of_families = families::cases(&case, &loops.fits);
    let cases: Vec<&Case<'_>> = std::iter::once(&case).chain(&of_families).collect();
    let noise = reporting.noise[0].highest();
    let (searches, population) = promoted(&cases, &mut survey, &all_blocks, noise)?;

    // Judged, and told.
    let leader = at(&searches, leading(&population));
    if !is_found && leader.0 == 0 {
        return Ok(reporting.not_converged());
    }
    let simulations = Simulations::before(&plain, &loops, &survey.searches);
    reporting.reported((searches, &population), leader, simulations)
}
