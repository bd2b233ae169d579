//! JSON of `sma diagnose` for programs.

use identify::Validated;
use missing_physics::{
    Curve, Entry, Finding, LoopFamily, Mismatch, NextExperiment, Remainder, Run, Stage, Status,
    Trace,
};
use serde_json::{Value, json};

use super::findings::literature;
use super::{Diagnosed, otherwise, runs};
use crate::report::identified::parameters_json;
use crate::report::repeated;
use crate::sanity;

fn trace(trace: &Trace) -> Value {
    json!({
        "rule": trace.rule.name,
        "of": trace.of,
        "value": trace.value,
        "threshold": trace.rule.threshold,
        "passed": trace.passed,
    })
}

impl Diagnosed<'_> {
    /// DESIGN's document.
    pub fn json(&self) -> Value {
        let diagnosis = self.diagnosis;
        let (floor, explained) = (diagnosis.noise_floor, diagnosis.explained);
        let extended = diagnosis.extended.as_ref().map(|extended| {
            let mut stage = stage(&extended.stage);
            stage["effects"] = json!(extended.names());
            let family = extended.model.loop_family();
            if family != LoopFamily::Proximity {
                stage["loop_family"] = json!(family.id());
            }
            stage
        });
        json!({
            "schema_version": 1,
            "command": "diagnose",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": diagnosis.seed,
            "verdict": diagnosis.verdict.id(),
            "implausible": sanity::to_json(&self.implausible),
            "output_unit": diagnosis.baseline.fit.output_unit,
            "noise_floor": {"lower": floor.lower, "upper": floor.upper, "class": floor.class.id(), "of_drive": floor.of_drive},
            "repeats": diagnosis.repeats.as_ref().map(repeated::json),
            "runs": runs::json(diagnosis),
            "baseline": stage(&diagnosis.baseline),
            "extended": extended,
            "explained_fraction": {
                "train": explained.and_then(|explained| explained.train),
                "validate": explained.and_then(|explained| explained.validate),
                "validate_interval": explained.and_then(|explained| explained.validate_interval),
                "by_findings": explained.and_then(|explained| explained.by_findings),
            },
            "mismatch": mismatch(&diagnosis.mismatch),
            "findings": diagnosis.findings.iter().map(finding).collect::<Vec<_>>(),
            "suspects": diagnosis.suspects.iter().map(suspect).collect::<Vec<_>>(),
            "remainder": diagnosis.remainder.as_ref().map(remainder),
            "catalogue": diagnosis.catalogue.iter().map(|entry| self.entry(entry)).collect::<Vec<_>>(),
            "next_experiment": diagnosis.next_experiment.as_ref().map(next_experiment),
            "predictable": diagnosis.audit.map(|audit| json!({
                "share": audit.share,
                "share_at_most": audit.share_at_most,
                "p_value": audit.p_value,
            })),
            "trace": diagnosis.traces.iter().map(trace).collect::<Vec<_>>(),
            "otherwise": diagnosis.otherwise.iter().map(otherwise::json).collect::<Vec<_>>(),
            "left_out": diagnosis.left_out.iter().map(|part| part.id()).collect::<Vec<_>>(),
            "simulations": diagnosis.simulations.total(),
            "simulations_of": {
                "baseline": diagnosis.simulations.baseline,
                "other_loops": diagnosis.simulations.other_loops,
                "search": diagnosis.simulations.search,
                "judged": diagnosis.simulations.judged,
            },
            "specific_heat_range_carried": self.specific_heat.map(|range| [range.lower, range.upper]),
            "resistivity_range_carried": self.resistivity.map(|range| [range.lower, range.upper]),
            "memory": self.memory,
            "notes": self.notes(),
        })
    }

    fn entry(&self, entry: &Entry) -> Value {
        let is_left_out = self
            .without
            .iter()
            .any(|left_out| entry.effect == *left_out);
        let verdict = if is_left_out {
            "not_testable"
        } else {
            entry.status.id()
        };
        let upper_limit = match entry.status {
            Status::Excluded { upper } if !is_left_out => Some(upper),
            _ => None,
        };
        let reason = match entry.status {
            _ if is_left_out => Some("left out by --without".to_owned()),
            Status::Unknown { need } => Some(format!("needs {}", self.needed(need))),
            _ => None,
        };
        json!({
            "effect": entry.effect.id(),
            "verdict": verdict,
            "t": entry.t,
            "absorption": entry.absorption,
            "minimum_detectable": entry.minimum_detectable,
            "unit": entry.unit,
            "upper_limit": upper_limit,
            "reason": reason,
        })
    }
}

fn stage(stage: &Stage) -> Value {
    json!({
        "train_rmse": stage.fit.train_rmse,
        "predicted_rmse": stage.predicted_rmse,
        "validate_rmse": Validated::rmse_of_all(&stage.validated),
        "temperature_rmse_k": stage.fit.temperature_rmse_k,
        "parameters": parameters_json(&stage.fit),
    })
}

fn finding(finding: &Finding) -> Value {
    let parameters: Vec<Value> = finding
        .parameters
        .iter()
        .map(|one| {
            json!({
                "name": one.name,
                "value": one.value,
                "ci95": one.ci95,
                "unit": one.unit,
                "literature": one.literature,
            })
        })
        .collect();
    let others: Vec<&str> = finding
        .could_also_be
        .iter()
        .map(|effect| effect.id())
        .collect();
    json!({
        "effect": finding.effect.id(),
        "could_also_be": others,
        "probability": finding.probability,
        "parameters": parameters,
        "literature": literature(finding),
        "plausible": finding.plausible,
        "contribution": finding.contribution,
        "sentence": finding.sentence,
    })
}

/// Without a probability: that is against the rest of the catalogue, which does not account for the misfit.
fn suspect(suspect: &Finding) -> Value {
    let mut document = finding(suspect);
    document["probability"] = Value::Null;
    document
}

fn mismatch(mismatch: &Mismatch) -> Value {
    let cells: Vec<Value> = mismatch
        .cells
        .iter()
        .map(|cell| {
            json!({
                "where": cell.at,
                "share": cell.share,
                "occupancy": cell.occupancy,
                "p_value": cell.p_value,
            })
        })
        .collect();
    let spans: Vec<Value> = mismatch
        .spans
        .iter()
        .map(|span| {
            json!({
                "recording": span.recording,
                "start_s": span.start_s,
                "end_s": span.end_s,
                "share": span.share,
            })
        })
        .collect();
    let blocks: Vec<Value> = mismatch
        .blocks
        .iter()
        .map(|(block, probability)| json!({"block": block.id(), "probability": probability}))
        .collect();
    let bands: Vec<Value> = mismatch
        .bands
        .iter()
        .map(|band| json!({"hz": band.hz, "share": band.share}))
        .collect();
    json!({
        "block": mismatch.block.map(|(block, _)| block.id()),
        "block_probability": mismatch.block.map(|(_, probability)| probability),
        "blocks": blocks,
        "cells": cells,
        "spans": spans,
        "bands": bands,
    })
}

fn remainder(left: &Remainder) -> Value {
    let shape = left.shape.as_ref().map(|shape| {
        let curve = |Curve { heating, points }: &Curve| {
            let points: Vec<Value> = points
                .iter()
                .map(|[variable, value, half]| json!({"at": variable, "value": value, "ci95_half": half}))
                .collect();
            json!({"branch": if *heating { "heating" } else { "cooling" }, "points": points})
        };
        json!({
            "block": shape.block.id(),
            "variable": shape.variable,
            "value": shape.value,
            "share": shape.share,
            "curves": shape.curves.iter().map(curve).collect::<Vec<_>>(),
        })
    });
    json!({
        "rms": left.rms,
        "share": left.share,
        "mismatch": mismatch(&left.mismatch),
        "shape": shape,
    })
}

/// The drive itself is a file: --save-next.
fn next_experiment(next: &NextExperiment) -> Value {
    let separates: Vec<&str> = next.separates.iter().map(|effect| effect.id()).collect();
    let run = |run: &Run| {
        let [start, end] = [run.decisive.start, run.decisive.end].map(|k| run.dt_s * k as f64);
        json!({
            "name": run.name,
            "dt_s": run.dt_s,
            "duration_s": run.duration_s(),
            "separation": run.separation,
            "separation_now": run.separation_now,
            "decisive_s": [start, end],
        })
    };
    json!({
        "separates": separates,
        "sentence": next.sentence,
        "run": next.run.as_ref().map(run),
    })
}
