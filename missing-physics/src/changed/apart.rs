//! The run that would tell the alternatives of a finding apart.

use identify::{ForwardModel, IdentifyError, Limits, ParameterVector};
use recording::Recording;

use crate::Candidate;
use crate::changed::change::{Changed, Changing};
use crate::changed::comparison::{Comparison, Ended};
use crate::changed::version::What;
use crate::model::case::{Case, Node};
use crate::next::advice::record_surroundings;
use crate::next::experiment::{Rival, next_experiment};
use crate::next::run::NextExperiment;

/// Most explanations that a run is sought for.
const RIVALS: usize = 3;

/// Proposes the next run. Only effects that have appeared are told apart, each where its search over all runs has ended, and only if
/// the leading change is one of them; what the reference says of the laws does not count.
pub(super) fn next_run(
    asked: &Comparison<'_>,
    found: &[Ended],
    finding: &Changed,
    limits: &Limits,
) -> Result<Option<NextExperiment>, IdentifyError> {
    let Changing::Appeared(_) = finding.leading.what else {
        return Ok(None);
    };
    let leading = std::iter::once(&finding.leading.what);
    let all = leading.chain(&finding.could_also_be);
    let effects = all.filter_map(|what| match what {
        Changing::Appeared(effect) => Some(*effect),
        _ => None,
    });
    let effects: Vec<Candidate> = effects.take(RIVALS).collect();
    if effects.len() < 2 {
        return Ok(None);
    }
    let of_all = asked.case;
    let today: Vec<Recording> = asked
        .changed
        .iter()
        .map(|&run| of_all.training[run].clone())
        .collect();
    let may_drift = |effect: &Candidate| effect.info().settled_by_ambient_record;
    let is_recorded = |run: &Recording| run.ambient_degc().is_some();
    if effects.iter().any(may_drift) && !today.iter().any(is_recorded) {
        return Ok(Some(record_surroundings(effects)));
    }
    let case = of_all.on(&today);
    let mut nodes: Vec<(Candidate, Node)> = Vec::new();
    for effect in effects {
        if let Some(ended) = found.iter().find(|one| one.what == What::Effect(effect)) {
            nodes.push((effect, node(&case, ended, asked.changed)?));
        }
    }
    let rivals = nodes.iter().map(|(effect, node)| Rival {
        effect: *effect,
        node,
    });
    let rivals: Vec<Rival<'_>> = rivals.collect();
    match rivals.first() {
        Some(first) => next_experiment(&case, &rivals, limits, &first.node.noise),
        None => Ok(None),
    }
}

/// A model with a change in the runs that have it.
fn node(case: &Case<'_>, ended: &Ended, changed: &[usize]) -> Result<Node, IdentifyError> {
    let model = ended.joint.version.model().clone();
    let infos = model.parameters();
    let points: Vec<Vec<f64>> = changed
        .iter()
        .map(|&run| ended.joint.point(run)[..infos.len()].to_vec())
        .collect();
    let vector = ParameterVector::new(infos, points.len());
    let coordinates = vector.coordinates(|parameter, run| Some(points[run][parameter]));
    case.node(model, coordinates, points, 0)
}
