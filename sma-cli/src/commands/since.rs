//! `sma diagnose --reference`: what has changed since runs of the rig as it should be.

use std::ops::ControlFlow;

use identify::{Provenance, RigModel};
use missing_physics::Reference;
use recording::Recording;
use workbench::page;
use workbench::report::changed::SinceReference;
use workbench::{WorkbenchError, each_once, is_trained_on, read_all};

use super::diagnose::{DiagnoseArgs, Rig, show};
use crate::outcome::Outcome;
use crate::sink::{Delivery, Sink, deliver};
use crate::terminal::{Progress, say};

/// Fits the laws of the reference, and asks of the training recordings what has changed.
pub(crate) fn since_reference(
    args: &DiagnoseArgs,
    mut rig: Rig,
    (json, report): (Option<Sink>, Option<Sink>),
    made: &Provenance,
) -> anyhow::Result<Outcome> {
    let (reference, copies) = each_once(read_all(&rig.rod, &args.reference)?);
    rig.notes.extend(copies);
    let is_in_it = |one: &&Recording| {
        let is_named = reference.iter().any(|run| run.name() == one.name());
        is_named || is_trained_on(one, &reference)
    };
    if let Some(twice) = rig.training.iter().find(is_in_it) {
        return Err(WorkbenchError::InReference {
            recording: twice.name().to_owned(),
        }
        .into());
    }
    let model = RigModel::new(&rig.rod, args.memory.rule(), &reference)?;
    let RigModel::Wiener(plain) = &model else {
        return Err(WorkbenchError::NoReference {
            recording: reference[0].name().to_owned(),
        }
        .into());
    };
    let config = args.config(Vec::new(), &rig)?;
    let mut shown = Progress::new(
        args.quiet,
        config.baseline.starts,
        "reference {bar:20}  {msg}",
    )
    .of_a_part();
    let healthy = Reference::of(plain, &reference, &config, &mut |progress| {
        show(&mut shown, &progress);
        ControlFlow::Continue(())
    })?;
    shown.show("asking what has changed", None, "");
    // The evidence is computed only for those who want to see it.
    let (change, evidence) = if report.is_some() {
        let (change, evidence) = healthy.changed_with_evidence(&rig.training)?;
        (change, Some(evidence))
    } else {
        (healthy.changed(&rig.training)?, None)
    };
    shown.end();
    let since = SinceReference {
        change: &change,
        seed: args.seed,
        notes: rig.notes,
    };
    say(args.quiet, &since.notes)?;
    let mut delivery = Delivery::default();
    if let Some((sink, evidence)) = report.zip(evidence) {
        delivery.of(|| {
            let page = page::since(&since, &evidence, [&reference, &rig.training])?;
            sink.write(&page.made_by(made))
        });
    }
    delivery.of(|| deliver(&since.text(), &since.json(), json));
    delivery.end()?;
    Ok(Outcome::Done)
}
