//! The run that would tell the alternatives of a finding apart.

use identify::{IdentifyError, ParameterVector, predict};

use crate::Candidate;
use crate::changed::change::{Changed, Changing};
use crate::changed::evidence::Answered;
use crate::changed::version::What;
use crate::model::case::{Case, Node};
use crate::next::advice::record_surroundings;
use crate::next::experiment::{Rival, next_experiment};
use crate::next::run::NextExperiment;

/// Most explanations that a run is sought for.
const RIVALS: usize = 3;

/// Proposes the next run. Only effects that have appeared are told apart, each where its search over all runs has ended.
pub(super) fn next_run(
    answered: &Answered<'_>,
    finding: &Changed,
) -> Result<Option<NextExperiment>, IdentifyError> {
    let leading = std::iter::once(&finding.leading.what);
    let effects = leading
        .chain(&finding.could_also_be)
        .filter_map(|what| match what {
            Changing::Appeared(effect) => Some(*effect),
            _ => None,
        });
    let effects: Vec<Candidate> = effects.take(RIVALS).collect();
    if effects.len() < 2 {
        return Ok(None);
    }
    let may_drift = |effect: &Candidate| effect.info().settled_by_ambient_record;
    let is_recorded = |run: &recording::Recording| run.ambient_degc().is_some();
    if effects.iter().any(may_drift) && !answered.today.iter().any(is_recorded) {
        return Ok(Some(record_surroundings(effects)));
    }
    let reference = answered.reference;
    let n_reference = reference.runs.len();
    let few = &answered.asked.case.training[n_reference..];
    let case = Case::new(
        &reference.base,
        &reference.plain,
        few,
        reference.config.setting,
    );
    let mut nodes: Vec<(Candidate, Node)> = Vec::new();
    for effect in effects {
        let ended = answered.found.iter();
        let Some(ended) = ended
            .into_iter()
            .find(|one| one.what == What::Effect(effect))
        else {
            continue;
        };
        let model = ended.joint.version.model().clone();
        let n_parameters = identify::ForwardModel::parameters(&model).len();
        let point = |run: usize| {
            let mut point = ended.joint.point(n_reference + run);
            point.truncate(n_parameters);
            point
        };
        let points: Vec<Vec<f64>> = (0..few.len()).map(point).collect();
        // A model that refuses a run has no rival.
        if predict(&model, &points[0], &few[0]).is_err() {
            continue;
        }
        let vector = ParameterVector::new(identify::ForwardModel::parameters(&model), few.len());
        let coordinates = vector.coordinates(|parameter, run| Some(points[run][parameter]));
        nodes.push((effect, case.node(model, coordinates, points, 0)?));
    }
    let rivals: Vec<Rival<'_>> = nodes
        .iter()
        .map(|(effect, node)| Rival {
            effect: *effect,
            node,
        })
        .collect();
    let Some(first) = rivals.first() else {
        return Ok(None);
    };
    next_experiment(&case, &rivals, &reference.config.limits, &first.node.noise)
}
