//! The first plant: the rod in finite volumes, with steps of the integrator's own choice.

use crate::integrator::Integrator;
use crate::rig::{Rig, Sample};
use crate::simulate::Machine;
use crate::{Hysteresis, TruthError, TruthPlant};

/// Steps of a sample at least, where the path between samples is filtered or delayed.
const STEPS_FOR_ELECTRONICS: f64 = 32.0;
/// Steps of a sample at least, where friction must see the path turn.
const STEPS_FOR_FRICTION: f64 = 8.0;

/// The plant under way, with its state.
#[derive(Debug)]
pub(crate) struct Volumes<'a, H: Hysteresis> {
    rig: Rig<'a, H>,
    state: Vec<f64>,
    integrator: Integrator,
}

impl<'a, H: Hysteresis> Volumes<'a, H> {
    /// The plant at rest.
    pub(crate) fn at_rest(
        plant: &'a TruthPlant,
        operator: &'a H,
        sample: Sample,
    ) -> Result<Self, TruthError> {
        let (rig, state) = Rig::at_rest(plant, operator, sample)?;
        let steps = match (plant.output_filter, plant.friction) {
            (Some(_), _) => STEPS_FOR_ELECTRONICS,
            (None, Some(_)) => STEPS_FOR_FRICTION,
            (None, None) => 1.0,
        };
        let longest_s = plant.longest_step_s.min(sample.length_s / steps);
        let integrator = Integrator::new(rig.layout.n_states, plant.tolerance_k, longest_s);
        Ok(Self {
            rig,
            state,
            integrator,
        })
    }
}

impl<H: Hysteresis> Machine for Volumes<'_, H> {
    fn begin(&mut self, sample: Sample) {
        self.rig.begin(sample);
    }

    fn advance(&mut self, target: f64, span_s: (f64, f64), index: usize) -> Result<(), TruthError> {
        self.rig.command(span_s.0, target);
        let Self {
            rig,
            state,
            integrator,
        } = self;
        integrator
            .advance(rig, state, span_s)
            .map_err(|_| TruthError::Diverged { index })
    }

    fn end_sample(&mut self) {
        self.rig.end_sample();
    }

    fn output_m(&self) -> f64 {
        self.rig.output_m()
    }

    fn middle_degc(&self) -> f64 {
        self.rig.middle_degc()
    }

    fn bead_degc(&self) -> Option<f64> {
        self.rig.bead_degc(&self.state)
    }

    fn mean_fraction(&self) -> f64 {
        self.rig.mean_fraction()
    }
}
