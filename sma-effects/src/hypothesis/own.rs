//! The terms of one's own hypotheses in the lanes of a plant.

use wiener::Drive;

use super::{Expression, Hypothesis, MOST_HYPOTHESES, MOST_PARAMETERS, Place, VARIABLES};
use crate::EffectValues;
use crate::conduction::ZONES;

/// The hypotheses of a plant and their values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Own<const L: usize> {
    hypotheses: &'static [Hypothesis],
    /// By hypothesis, parameter and lane.
    values: [[[f64; L]; MOST_PARAMETERS]; MOST_HYPOTHESES],
}

/// Memory of the hypotheses, and their terms in the current sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OwnMemory<const L: usize> {
    /// +1 if the middle's temperature last rose, -1 if it last fell.
    direction: [f64; L],
    start_degc: [f64; L],
    drive: [f64; L],
    ambient_degc: [f64; L],
    /// Heat flow into each zone, W/m.
    pub(crate) flow_w_per_m: [[f64; L]; ZONES],
    /// Shift of the loop in each zone, K.
    pub(crate) shift_k: [[f64; L]; ZONES],
}

/// A state in which terms are evaluated, but for drive, surroundings and direction.
#[derive(Debug)]
pub(crate) struct SeenState<const L: usize> {
    pub(crate) time_s: f64,
    pub(crate) temperature_degc: [f64; L],
    /// Transformed share.
    pub(crate) transformed: [f64; L],
}

impl<const L: usize> Own<L> {
    pub(crate) fn new(hypotheses: &'static [Hypothesis], lanes: &[EffectValues; L]) -> Self {
        let mut values = [[[0.0; L]; MOST_PARAMETERS]; MOST_HYPOTHESES];
        for (h, of_one) in values.iter_mut().enumerate() {
            for (k, value) in of_one.iter_mut().enumerate() {
                *value = lanes.each_ref().map(|lane| lane.own[h][k]);
            }
        }
        Self { hypotheses, values }
    }

    pub(crate) fn has(&self, place: Place) -> bool {
        self.hypotheses
            .iter()
            .any(|hypothesis| hypothesis.place == place)
    }

    /// At the start of a run: `share` is 0 where the rod came along the heating curve.
    pub(crate) fn memory(
        &self,
        temperature_degc: [f64; L],
        share: &[f64; L],
    ) -> Option<Box<OwnMemory<L>>> {
        let memory = || {
            Box::new(OwnMemory {
                direction: share.map(|share| if share <= 0.0 { 1.0 } else { -1.0 }),
                start_degc: temperature_degc,
                drive: [0.0; L],
                ambient_degc: temperature_degc,
                flow_w_per_m: [[0.0; L]; ZONES],
                shift_k: [[0.0; L]; ZONES],
            })
        };
        (!self.hypotheses.is_empty()).then(memory)
    }

    /// Changes the drive of a sample, by the state of the rod at its beginning.
    pub(crate) fn drive(
        &self,
        memory: &OwnMemory<L>,
        kind: Drive,
        rod: &SeenState<L>,
        drive: &mut [f64; L],
    ) {
        let mut added = [0.0; L];
        self.add(Place::Drive, memory, rod, &mut added);
        for l in 0..L {
            drive[l] = driven(kind, drive[l], added[l]);
        }
    }

    /// Notes what heats zone `z` and shifts its loop over a sample, by its state at the beginning.
    pub(crate) fn heat_and_shift(&self, memory: &mut OwnMemory<L>, z: usize, zone: &SeenState<L>) {
        let mut flow_w_per_m = [0.0; L];
        self.add(Place::HeatFlow, memory, zone, &mut flow_w_per_m);
        let mut shift_k = [0.0; L];
        self.add(Place::Shift, memory, zone, &mut shift_k);
        memory.flow_w_per_m[z] = flow_w_per_m;
        memory.shift_k[z] = shift_k;
    }

    /// Adds the terms of a place; a displacement is what they are added to and see.
    #[inline(never)]
    pub(crate) fn add(
        &self,
        place: Place,
        memory: &OwnMemory<L>,
        seen: &SeenState<L>,
        to: &mut [f64; L],
    ) {
        for (hypothesis, values) in self.hypotheses.iter().zip(&self.values) {
            if hypothesis.place != place {
                continue;
            }
            for l in 0..L {
                let mut arguments = [0.0; Expression::MOST_VARIABLES];
                let (state, parameters) = arguments.split_at_mut(VARIABLES.len());
                state.copy_from_slice(&[
                    seen.temperature_degc[l],
                    memory.ambient_degc[l],
                    seen.transformed[l],
                    memory.drive[l],
                    seen.time_s,
                    memory.direction[l],
                    to[l],
                ]);
                for (parameter, value) in parameters.iter_mut().zip(values) {
                    *parameter = value[l];
                }
                let term = hypothesis.term.value(&arguments);
                to[l] += if term.is_finite() { term } else { f64::NAN };
            }
        }
    }
}

impl<const L: usize> OwnMemory<L> {
    /// Notes what acts in a sample, and from where the middle starts.
    pub(crate) fn note(
        &mut self,
        drive: &[f64; L],
        ambient_degc: f64,
        temperature_degc: &[f64; L],
    ) {
        self.drive = *drive;
        self.ambient_degc = [ambient_degc; L];
        self.start_degc = *temperature_degc;
    }

    /// Notes where the middle went over the sample.
    pub(crate) fn end(&mut self, temperature_degc: &[f64; L]) {
        for l in 0..L {
            let change_k = temperature_degc[l] - self.start_degc[l];
            if change_k > 0.0 {
                self.direction[l] = 1.0;
            } else if change_k < 0.0 {
                self.direction[l] = -1.0;
            }
        }
    }
}

/// The drive with what is added: no further out of its range than it was.
fn driven(kind: Drive, drive: f64, added: f64) -> f64 {
    let changed = drive + added;
    match kind {
        Drive::Current | Drive::Voltage { .. } => changed,
        Drive::Duty { .. } => changed.clamp(drive.min(0.0), drive.max(1.0)),
        Drive::Power { .. } => changed.clamp(drive.min(0.0), f64::INFINITY),
    }
}
