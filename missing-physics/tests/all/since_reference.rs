//! Changes of a rig since reference runs, in which it was as it should be; each run is in a state of its own.

use std::ops::ControlFlow;
use std::sync::LazyLock;

use fixtures::wire::ROD;
use identify::WienerModel;
use missing_physics::{Change, ChangeVerdict, DiagnoseConfig, Reference};
use recording::Recording;
use rig_files::rod_file;
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Setting};
use wiener::hysteresis::Rule;

use crate::common;
use common::{noisy, params, played, recording, setting, triangles_a};

const DT_S: f64 = 0.5;

/// A run in which the wire loses more heat by a share, and moves further by another; it has latent heat, and what has changed.
fn ran(
    name: &str,
    heights_a: &[f64],
    [heat_loss, gain]: [f64; 2],
    changed: Option<(EffectId, f64)>,
) -> Recording {
    let mut effects = EffectValues::typical(EffectId::LatentHeat, 1.0);
    let mut active = EffectSet::of(EffectId::LatentHeat);
    if let Some((effect, size)) = changed {
        *effects.slot(effect, 0).unwrap() = size;
        active = active.with(effect);
    }
    let mut wire = params();
    wire.heat.conductance_w_per_m_k *= 1.0 + heat_loss;
    wire.gain *= 1.0 + gain;
    let drive = triangles_a(heights_a);
    let setting = Setting {
        active,
        ..setting()
    };
    let output = played(&Extended { setting }, wire, effects, &drive, DT_S);
    recording(name, drive, noisy(output), DT_S)
}

fn reference() -> Vec<Recording> {
    vec![
        ran("a.csv", &[2.3, 1.9], [0.0, 0.0], None),
        ran("b.csv", &[2.1, 2.4], [0.05, -0.01], None),
        ran("c.csv", &[2.4, 2.0], [-0.04, 0.008], None),
    ]
}

static LAWS: LazyLock<Reference> = LazyLock::new(|| laws(&reference(), EffectSet::all()));

fn laws(reference: &[Recording], catalogue: EffectSet) -> Reference {
    let base = WienerModel::new(
        &rod_file::parse("rod.toml", ROD).unwrap(),
        Rule::LastReversal,
        reference,
    )
    .unwrap();
    let config = DiagnoseConfig {
        setting: setting(),
        catalogue,
        ..DiagnoseConfig::default()
    };
    Reference::of(
        &base,
        reference,
        &config,
        &mut |_| ControlFlow::Continue(()),
    )
    .unwrap()
}

fn today(laws: &Reference, changed: Option<(EffectId, f64)>) -> Change {
    laws.changed(&[ran("today.csv", &[2.0, 2.3], [0.06, 0.01], changed)])
        .unwrap()
}

#[test]
fn a_change_is_named_with_its_size_and_none_is_said_of_another_state() {
    let none = today(&LAWS, None);
    assert_eq!(none.verdict, ChangeVerdict::Unchanged, "{:?}", none.finding);
    assert_eq!(none.laws, [EffectId::LatentHeat]);
    assert!(none.coolings >= 4, "{}", none.coolings);
    for one in &none.left_out {
        assert!(one.rmse < 0.01, "{one:?}");
    }
    let size = 0.03;
    let change = today(&LAWS, Some((EffectId::Backlash, size)));
    assert_eq!(change.verdict, ChangeVerdict::Changed);
    let finding = change.finding.unwrap();
    assert_eq!(finding.leading.what.id(), "backlash");
    assert_eq!(finding.could_also_be, []);
    let [low, high] = finding.leading.ci95.unwrap();
    assert!(
        (finding.leading.change - size).abs() < 0.1 * size && high - low < 0.3 * size,
        "{low} {high}"
    );
    let [before, after] = change.runs[0].1;
    assert!(before > 3.0 * after, "{before} {after}");
}

#[test]
fn a_law_that_is_another_is_said_to_be() {
    let mut effects = EffectValues::typical(EffectId::LatentHeat, 1.0);
    effects.latent_heat.latent_heat_j_per_kg *= 1.5;
    let setting = Setting {
        active: EffectSet::of(EffectId::LatentHeat),
        ..setting()
    };
    let drive = triangles_a(&[2.0, 2.3]);
    let output = played(&Extended { setting }, params(), effects, &drive, DT_S);
    let run = recording("today.csv", drive, noisy(output), DT_S);
    let change = LAWS.changed(&[run]).unwrap();
    let finding = change.finding.unwrap();
    assert_eq!(finding.leading.what.id(), "latent-heat");
    let grown = 0.5 * EffectId::LatentHeat.info().parameters[0].typical;
    assert!((finding.leading.change - grown).abs() < 0.1 * grown);
}

#[test]
fn one_run_alone_is_no_reference() {
    // Whatever may have changed, there is nothing to compare it with.
    let catalogue = EffectSet::of(EffectId::LatentHeat).with(EffectId::OutputLag);
    let laws = laws(&reference()[..1], catalogue);
    let change = today(&laws, Some((EffectId::OutputLag, 2.0)));
    assert_eq!(change.verdict, ChangeVerdict::ReferenceTooShort);
    assert_eq!(change.finding, None);
}

#[test]
fn evidence_shows_the_runs_as_the_answer_has_them() {
    let late_s = 0.6 * EffectId::DeadTime.info().parameters[0].typical;
    let late = Some((EffectId::DeadTime, late_s));
    let run = ran("today.csv", &[2.0, 2.3], [0.06, 0.01], late);
    let (change, evidence) = LAWS
        .changed_with_evidence(std::slice::from_ref(&run))
        .unwrap();
    let rms = |of: &Recording, predicted: &[f64]| {
        let pairs = of.output().iter().zip(predicted);
        let squares: f64 = pairs.map(|(own, model)| (own - model).powi(2)).sum();
        (squares / of.len() as f64).sqrt()
    };
    let near = |found: f64, told: f64| (found - told).abs() < 0.1 * told;
    let [traced] = &evidence.since[..] else {
        panic!("one run");
    };
    let [before, after] = change.runs[0].1;
    assert!(near(rms(&run, &traced.unchanged_output), before));
    let changed = traced.changed_output.as_ref().unwrap();
    assert!(near(rms(&run, changed), after));
    assert!(before > after);
    assert!(!traced.deviation_over_time_s.is_empty());
    // The band is as wide as what is left of the runs that were left out, or wider.
    let n_left_out = [evidence.left_out.len(), change.left_out.len()];
    assert_eq!(n_left_out, [reference().len(); 2]);
    for ((own, traced), told) in reference()
        .iter()
        .zip(&evidence.left_out)
        .zip(&change.left_out)
    {
        assert!(near(rms(own, &traced.unchanged_output), told.rmse));
        assert!(traced.changed_output.is_none());
        let widest = traced.deviation_over_time_s.iter().map(|one| one[1]);
        assert!(widest.fold(0.0, f64::max) > 0.8 * told.rmse);
    }
    assert!(evidence.enlarged >= 1.0);
    let heat_loss = evidence
        .states
        .iter()
        .find(|one| one.parameter == "run_heat_loss")
        .unwrap();
    assert_eq!(heat_loss.prior_deviation, Some(0.05));
    assert!((heat_loss.deviation().unwrap() - 0.045).abs() < 0.02);
    assert_eq!(
        [heat_loss.of_reference.len(), heat_loss.since.len()],
        [3, 1]
    );
    // Alternatives that these runs do not tell apart, and advice on them.
    assert!(!change.finding.unwrap().could_also_be.is_empty());
    let next = evidence.next.unwrap();
    assert!(next.separates.contains(&EffectId::DeadTime.into()));
    assert!(next.separates.len() > 1 && next.sentence.contains("apart"));
}
