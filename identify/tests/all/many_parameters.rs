//! More parameters than lanes of a batch.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use crate::common;

use common::{recording, triangles};
use identify::{
    Bounds, Enters, FitConfig, ForwardModel, IdentifyError, ParameterInfo, Scale, Scope, fit,
};
use recording::Recording;
use wiener::Block;

const N: usize = 75;

/// A sum of cosines of the time, whose amplitudes are the parameters.
#[derive(Debug)]
struct Cosines(Vec<ParameterInfo>);

impl Cosines {
    fn new() -> Self {
        let bounds = Bounds {
            lower: -10.0,
            upper: 10.0,
        };
        let of = |_| ParameterInfo::searched("amplitude", "mm", Scale::Linear, bounds);
        let gain = ParameterInfo {
            enters: Enters::Gain,
            state: identify::ParameterState::Fixed(1.0),
            ..of(0)
        };
        let offset = ParameterInfo {
            enters: Enters::Offset,
            scope: Scope::PerRecording,
            ..of(0)
        };
        Self((0..N).map(of).chain([gain, offset]).collect())
    }

    fn output(point: &[f64], sample: usize, n_samples: usize) -> f64 {
        let phase = PI * (sample as f64 + 0.5) / n_samples as f64;
        let terms = point[..N].iter().enumerate();
        terms
            .map(|(k, amplitude)| amplitude * (phase * (k + 1) as f64).cos())
            .sum()
    }
}

impl ForwardModel for Cosines {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.0
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        for sample in 0..recording.len() {
            let of = |point: &Vec<f64>| Self::output(point, sample, recording.len());
            let displacement: Vec<f64> = points.iter().map(of).collect();
            visit(Block {
                first_member: 0,
                members: points.len(),
                first_sample: sample,
                stride: points.len(),
                displacement: &displacement,
                temperature_degc: &displacement,
            });
        }
        Ok(())
    }
}

#[test]
fn as_many_parameters_are_fitted_as_a_model_has() {
    let drive = recording("a.csv", triangles(600, 5.8), 0.5);
    let truth: Vec<f64> = (0..N).map(|k| 3.0 * (k as f64).sin()).collect();
    let output = (0..drive.len()).map(|k| Cosines::output(&truth, k, drive.len()));
    let drive = drive.with_output(output.collect()).unwrap();
    let model = Cosines::new();
    let config = FitConfig {
        from: vec![vec![0.5; N]],
        starts: 0,
        ..FitConfig::default()
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let found = fit(&model, &[drive], &config, go_on).unwrap();
    assert_eq!(found.parameters.len(), N + 2);
    for (parameter, expected) in found.parameters.iter().zip(&truth) {
        assert!((parameter.values[0] - expected).abs() < 1e-5);
    }
}
