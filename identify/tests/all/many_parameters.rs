//! More parameters than lanes of a batch.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use crate::common;

use common::{recording, triangles};
use identify::{
    Bounds, Enters, FitConfig, ForwardModel, IdentifyError, ParameterInfo, ParameterState,
    ParameterVector, Scale, Scope, fit,
};
use recording::Recording;
use wiener::Block;

const N: usize = 75;

/// Every third belongs to a recording.
fn is_shared(k: usize) -> bool {
    !k.is_multiple_of(3)
}

/// A sum of cosines of the time, whose amplitudes are the parameters.
#[derive(Debug)]
struct Cosines(Vec<ParameterInfo>);

impl Cosines {
    fn new() -> Self {
        let bounds = Bounds {
            lower: -10.0,
            upper: 10.0,
        };
        let of = |k: usize| ParameterInfo {
            scope: if is_shared(k) {
                Scope::Shared
            } else {
                Scope::PerRecording
            },
            ..ParameterInfo::searched("amplitude", "mm", Scale::Linear, bounds)
        };
        let gain = ParameterInfo {
            enters: Enters::Gain,
            scope: Scope::Shared,
            state: ParameterState::Fixed(2.0),
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
    let truth = |k: usize, r: usize| {
        let own = if is_shared(k) { 0.0 } else { r as f64 };
        3.0 * (k as f64 + own).sin()
    };
    let training = [0, 1].map(|r| {
        let drive = recording(["a.csv", "b.csv"][r], triangles(600 + 100 * r, 5.8), 0.5);
        let amplitudes: Vec<f64> = (0..N).map(|k| truth(k, r)).collect();
        let output = |k| 2.0 * Cosines::output(&amplitudes, k, drive.len()) + r as f64;
        drive
            .with_output((0..drive.len()).map(output).collect())
            .unwrap()
    });
    let model = Cosines::new();
    let vector = ParameterVector::new(model.parameters(), training.len());
    let config = FitConfig {
        from: vec![vec![0.5; vector.len()]],
        starts: 0,
        ..FitConfig::default()
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let found = fit(&model, &training, &config, go_on).unwrap();
    for (k, parameter) in found.parameters[..N].iter().enumerate() {
        assert_eq!(parameter.values.len(), if is_shared(k) { 1 } else { 2 });
        for (r, value) in parameter.values.iter().enumerate() {
            assert!((value - truth(k, r)).abs() < 1e-5, "{k} {r}");
        }
    }
}
