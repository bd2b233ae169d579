//! The hysteresis alone, for data without time.

use recording::{Quantity, Recording};
use wiener::hysteresis::{Hysteresis, LimitingLoop, LoopParams, Memory, Rule, SineProximity};
use wiener::{
    Block, Fleet, Input, Lanes, NARROW, Output, Plant, Profile, Started, WIDE, WienerError,
    lockstep,
};

use crate::wiener_model::{branches_degc, start_share, zeta};
use crate::{Bounds, ForwardModel, IdentifyError, ParameterInfo, ParameterState, Rod, Scale};

/// Narrowest loop that is searched, as a share of the input's range: below, a width is that of a sample.
const NARROWEST: f64 = 1e-3;

/// Shifts that are searched, K/MPa, of either sign: the Clausius–Clapeyron coefficients of NiTi are 5 to 15
/// MPa/K, a tenth of the upper end.
const COUPLINGS_K_PER_MPA: Bounds = Bounds {
    lower: -1.0,
    upper: 1.0,
};

/// Changes of the stroke that are searched, 1/MPa.
const GAINS_PER_MPA: Bounds = Bounds {
    lower: -0.01,
    upper: 0.01,
};

const PA_PER_MPA: f64 = 1e6;

/// A static loop: input → hysteresis → output, eqs 4-12.
///
/// ```text
/// y = gain ξ(u) + offset,   with a stress   y = gain (1 + g Δσ) ξ(u - k Δσ) + offset
/// ```
///
/// The input u is the temperature of the rod, or any other that the loop may have (a stress, the voltage of a
/// source); its unit is carried as data. Time does not count, and the output of a sample belongs to the input
/// of that sample.
#[derive(Debug, Clone)]
pub struct LoopModel {
    rule: Rule,
    parameters: Vec<ParameterInfo>,
}

// Order of the parameters in a point.
const CENTER: usize = 0;
const HALF_WIDTH: usize = 1;
const SPREAD: usize = 2;
const ZETA: usize = 3;
const GAIN: usize = 4;
const OFFSET: usize = 5;
const START_SHARE: usize = 6;
const COUPLING: usize = 7;
const REFERENCE: usize = 8;
const GROWTH: usize = 9;

impl LoopModel {
    /// The loop of static recordings, with bounds wide enough for them.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] for no recordings, and what `[model]` says of parameters that do not exist or of
    /// values that cannot be.
    pub fn new(rod: &Rod, rule: Rule, training: &[Recording]) -> Result<Self, IdentifyError> {
        let first = training.first().ok_or(IdentifyError::NoRecordings)?;
        let inputs = training.iter().flat_map(Recording::drive);
        let range = inputs.fold(
            Bounds {
                lower: f64::INFINITY,
                upper: f64::NEG_INFINITY,
            },
            |range, &input| Bounds {
                lower: range.lower.min(input),
                upper: range.upper.max(input),
            },
        );
        let mut parameters = parameters(first.drive_unit(), first.output_unit(), range);
        rod.apply_model(&mut parameters)?;
        Ok(Self { rule, parameters })
    }

    /// The same loop with a center that rises with the recorded stress, by `stress_coupling_k_per_mpa` from where
    /// it is at the mean stress of the training (Clausius–Clapeyron; the reciprocal is the coefficient C, MPa/K).
    ///
    /// Shift and stroke follow the stress sample by sample; the stroke changes by `stress_gain_per_mpa` of the gain.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::NoStress`] for a recording without one.
    pub fn with_stress_coupling(mut self, training: &[Recording]) -> Result<Self, IdentifyError> {
        let (mut sum, mut n) = (0.0, 0.0);
        for recording in training {
            let stress_pa = stress_pa(recording)?;
            sum += stress_pa.iter().map(|pa| pa / PA_PER_MPA).sum::<f64>();
            n += stress_pa.len() as f64;
        }
        let per_mpa = format!("{}/MPa", self.parameters[HALF_WIDTH].unit);
        self.parameters.truncate(COUPLING);
        self.parameters.extend([
            ParameterInfo::searched(
                Self::STRESS_EFFECTS[0],
                &per_mpa,
                Scale::Linear,
                COUPLINGS_K_PER_MPA,
            ),
            ParameterInfo {
                state: ParameterState::Fixed(sum / n),
                ..ParameterInfo::searched(
                    "stress_reference_mpa",
                    "MPa",
                    Scale::Linear,
                    Bounds::NONE,
                )
            },
            ParameterInfo::searched(
                Self::STRESS_EFFECTS[1],
                "1/MPa",
                Scale::Linear,
                GAINS_PER_MPA,
            ),
        ]);
        Ok(self)
    }

    /// The parameters that say how a stress acts: what is 0 without stress coupling first.
    pub(crate) const STRESS_EFFECTS: [&'static str; 2] =
        ["stress_coupling_k_per_mpa", "stress_gain_per_mpa"];

    /// The same with a center that the stress does not move.
    pub(crate) fn without_shift(mut self) -> Self {
        if let Some(coupling) = self.parameters.get_mut(COUPLING) {
            coupling.state = ParameterState::Fixed(0.0);
        }
        self
    }

    /// The transformed fraction at every sample of a recording, at a point of this model.
    ///
    /// # Errors
    ///
    /// As [`ForwardModel::simulate`].
    pub fn fraction(
        &self,
        point: &[f64],
        recording: &Recording,
    ) -> Result<Vec<f64>, IdentifyError> {
        let mut shape = point.to_vec();
        (shape[GAIN], shape[OFFSET]) = (1.0, 0.0);
        let mut fraction = Vec::with_capacity(recording.len());
        self.simulate(&[shape], recording, &mut |block| {
            fraction.extend(block.displacement.iter().step_by(block.stride));
        })?;
        Ok(fraction)
    }

    /// The loop before anything is known of recordings; see
    /// [`WienerModel::template`](crate::WienerModel).
    pub(crate) fn template(rule: Rule, input_unit: &str) -> Self {
        Self {
            rule,
            parameters: parameters(input_unit, "1", Bounds::NONE),
        }
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut [ParameterInfo] {
        &mut self.parameters
    }
}

impl ForwardModel for LoopModel {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let input = recording.drive();
        let loads: Vec<f64> = match points.first().and_then(|point| point.get(REFERENCE)) {
            None => Vec::new(),
            Some(reference_mpa) => stress_pa(recording)?
                .iter()
                .map(|pa| pa / PA_PER_MPA - reference_mpa)
                .collect(),
        };
        let members: Vec<LoopMember> = points
            .iter()
            .map(|point| LoopMember {
                params: LoopParams {
                    loop_center_degc: point[CENTER],
                    loop_half_width_k: point[HALF_WIDTH],
                    loop_spread_k: point[SPREAD],
                    ..LoopParams::default()
                },
                zeta: point[ZETA],
                gain: point[GAIN],
                offset: point[OFFSET],
                start: input[0],
                share: point[START_SHARE],
                coupling_k_per_mpa: point.get(COUPLING).copied().unwrap_or(0.0),
                gain_per_mpa: point.get(GROWTH).copied().unwrap_or(0.0),
                start_load_mpa: loads.first().copied().unwrap_or(0.0),
            })
            .collect();
        // A plant shows its output before the drive of the sample acts; here they belong together, so that
        // the drive of a sample is the input of the next.
        let following = |values: &[f64]| {
            let after = values.iter().skip(1).chain(values.last());
            after.copied().collect::<Vec<f64>>()
        };
        let (next, next_loads) = (following(input), following(&loads));
        let mut profile = Profile::uniform(&next, 1.0, 0.0)?;
        if !loads.is_empty() {
            profile = profile.with_ambient(&next_loads)?;
        }
        let loops = Loops { rule: self.rule };
        Ok(lockstep(&loops, &members, &profile, visit)?)
    }

    fn branches_degc(&self, point: &[f64]) -> Option<[f64; 2]> {
        Some(branches_degc(point[CENTER], point[HALF_WIDTH]))
    }
}

/// The stress of a recording that must have one.
fn stress_pa(recording: &Recording) -> Result<&[f64], IdentifyError> {
    recording
        .stress_pa()
        .ok_or_else(|| IdentifyError::NoStress {
            recording: recording.name().to_owned(),
        })
}

/// In kelvins for a temperature, else in the unit of the input.
fn parameters(input_unit: &str, output_unit: &str, range: Bounds) -> Vec<ParameterInfo> {
    let is_temperature = input_unit == Quantity::Temperature.unit();
    let (names, center_unit, unit) = if is_temperature {
        let names = ["loop_center_degc", "loop_half_width_k", "loop_spread_k"];
        (names, "°C", "K")
    } else {
        let names = ["loop_center", "loop_half_width", "loop_spread"];
        (names, input_unit, input_unit)
    };
    let span = range.upper - range.lower;
    let widths = Bounds {
        lower: NARROWEST * span,
        upper: span,
    };
    vec![
        ParameterInfo::searched(names[0], center_unit, Scale::Linear, range),
        ParameterInfo::searched(names[1], unit, Scale::Logarithmic, widths),
        ParameterInfo::searched(names[2], unit, Scale::Logarithmic, widths),
        zeta(),
        ParameterInfo::gain(output_unit),
        ParameterInfo::offset(output_unit),
        start_share(),
    ]
}

/// Static loops that run side by side.
#[derive(Debug, Clone, Copy)]
struct Loops {
    rule: Rule,
}

/// One of them.
#[derive(Debug, Clone, Copy)]
struct LoopMember {
    /// Its "temperatures" are in the unit of the input.
    params: LoopParams,
    zeta: f64,
    gain: f64,
    offset: f64,
    /// First input.
    start: f64,
    /// Place between the limiting curves there.
    share: f64,
    /// Shift of the loop with the stress.
    coupling_k_per_mpa: f64,
    /// Change of the stroke with the stress.
    gain_per_mpa: f64,
    /// First stress from its reference.
    start_load_mpa: f64,
}

/// A plant whose drive is the input of its loop. What a profile has for its surroundings is the stress from its
/// reference, MPa: the loop has no surroundings.
#[derive(Debug, Clone, Copy)]
struct StaticLoop<const L: usize> {
    hysteresis: Hysteresis<L>,
    gain: [f64; L],
    offset: [f64; L],
    coupling_k_per_mpa: [f64; L],
    gain_per_mpa: [f64; L],
}

#[derive(Debug, Clone)]
struct LoopState<const L: usize> {
    input: [f64; L],
    load_mpa: f64,
    fraction: [f64; L],
    memory: Memory<L>,
}

impl Loops {
    fn started<const L: usize>(
        self,
        members: &[LoopMember; L],
    ) -> Result<Started<L, StaticLoop<L>>, WienerError> {
        let limits = LimitingLoop::new(members.map(|member| member.params))?;
        let proximity = SineProximity::new(members.map(|member| member.zeta))?;
        let plant = StaticLoop {
            hysteresis: Hysteresis::new(limits, proximity, self.rule),
            gain: members.map(|member| member.gain),
            offset: members.map(|member| member.offset),
            coupling_k_per_mpa: members.map(|member| member.coupling_k_per_mpa),
            gain_per_mpa: members.map(|member| member.gain_per_mpa),
        };
        let share = members.map(|member| member.share);
        // All members run over one recording.
        let load_mpa = members[0].start_load_mpa;
        let state = plant.started(members.map(|member| member.start), load_mpa, share);
        Ok(Started { plant, state })
    }
}

impl Fleet for Loops {
    type Member = LoopMember;
    type Error = WienerError;

    fn narrow(
        &self,
        members: &[LoopMember; NARROW],
    ) -> Result<Box<dyn Lanes<NARROW> + Send>, WienerError> {
        Ok(self.started(members)?.boxed())
    }

    fn wide(
        &self,
        members: &[LoopMember; WIDE],
    ) -> Result<Box<dyn Lanes<WIDE> + Send>, WienerError> {
        Ok(self.started(members)?.boxed())
    }
}

impl<const L: usize> StaticLoop<L> {
    fn started(&self, input: [f64; L], load_mpa: f64, share: [f64; L]) -> LoopState<L> {
        let shifted = self.shifted(input, load_mpa);
        let memory = self.hysteresis.between_limiting_curves(shifted, share);
        LoopState {
            input,
            load_mpa,
            fraction: self.hysteresis.peek(&memory, shifted).fraction,
            memory,
        }
    }

    /// The input as the loop at the reference stress would have it.
    #[inline(always)]
    fn shifted(&self, input: [f64; L], load_mpa: f64) -> [f64; L] {
        let mut shifted = input;
        for l in 0..L {
            shifted[l] -= self.coupling_k_per_mpa[l] * load_mpa;
        }
        shifted
    }
}

impl<const L: usize> Plant<L> for StaticLoop<L> {
    type State = LoopState<L>;

    fn rest(&self, ambient_degc: f64) -> LoopState<L> {
        self.started([ambient_degc; L], 0.0, [1.0; L])
    }

    #[inline(always)]
    fn output(&self, state: &LoopState<L>) -> Output<L> {
        let mut displacement = [0.0; L];
        for l in 0..L {
            let stroke = self.gain[l] * (1.0 + self.gain_per_mpa[l] * state.load_mpa);
            displacement[l] = stroke * state.fraction[l] + self.offset[l];
        }
        Output {
            displacement,
            temperature_degc: state.input,
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut LoopState<L>, input: &Input<L>, _dt_s: f64) {
        state.input = input.drive;
        state.load_mpa = input.ambient_degc;
        let shifted = self.shifted(input.drive, input.ambient_degc);
        state.fraction = self.hysteresis.commit(&mut state.memory, shifted);
    }
}
