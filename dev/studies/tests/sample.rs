//! A sample of the studies, small enough for every run of the tests.

use std::ops::ControlFlow;

use blind_trial::in_order;
use missing_physics::EffectId;
use studies::{CaseId, CaseLine, Study, StudyError, run_case};

/// Effects that are concealed, one a rig, at their typical size.
const CONCEALED: [EffectId; 8] = [
    EffectId::LatentHeat,
    EffectId::Backlash,
    EffectId::EndStop,
    EffectId::OutputLag,
    EffectId::AmbientDrift,
    EffectId::ThermalExpansion,
    EffectId::PhaseDependentResistance,
    EffectId::ReturnPointMemory,
];

fn ran(cases: &[CaseId]) -> Result<Vec<CaseLine>, StudyError> {
    let mut lines = Vec::new();
    in_order(
        cases,
        2,
        |&case| run_case(case),
        |line| {
            lines.push(line);
            ControlFlow::Continue(())
        },
    );
    lines.into_iter().collect()
}

fn of(study: Study, case: u64) -> CaseId {
    CaseId { study, case }
}

#[test]
fn clean_recordings_have_no_finding_and_single_effects_are_found() {
    let white = (0..8).map(|case| of(Study::CleanWhite, case));
    let colored = (0..4).map(|case| of(Study::CleanAr1, case));
    // The first round of cases has every effect once, in the catalogue's order.
    let single = CONCEALED.map(|effect| of(Study::Single, effect as u64));
    // The long ones first: two threads then end together.
    let cases: Vec<_> = single.into_iter().chain(colored).chain(white).collect();
    let lines = ran(&cases).unwrap();
    let (single, clean) = lines.split_at(CONCEALED.len());
    assert_eq!(clean.len(), 12);
    for (line, effect) in single.iter().zip(CONCEALED) {
        assert_eq!(line.truth.as_ref().unwrap().effect, effect.id());
        assert!(line.is_found(), "{effect}: {:?}", line.diagnosis);
    }
    let with_finding: Vec<_> = clean
        .iter()
        .filter(|line| !line.diagnosis.findings.is_empty())
        .collect();
    assert!(with_finding.len() <= 1, "{with_finding:?}");
}
