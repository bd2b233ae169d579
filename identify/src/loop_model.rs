//! The hysteresis alone, for data without time.

use recording::{Quantity, Recording};
use wiener::hysteresis::{
    Hysteresis, LimitingLoop, LoopParams, Memory, Rule, SineProximity, expm1,
};
use wiener::{
    Block, Fleet, Input, Lanes, NARROW, Output, Plant, Profile, Started, WIDE, WienerError,
    lockstep,
};

use crate::input_path::{InputPath, OneWay};
use crate::wiener_model::{START, branches_degc, start_share, zeta};
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

/// Shifts of the loop by fatigue that are searched, as a share of the input's range, of either sign; see
/// [`LoopModel::with_fatigue`].
const FATIGUE_SHIFT: f64 = 0.1;

/// Changes of stroke and offset by fatigue that are searched, as a share of the stroke, of either sign.
const FATIGUE_STROKE: f64 = 0.5;

/// Rates at which fatigue fades, 1/cycle: those of the effect `functional-fatigue`.
const FADING: Bounds = Bounds {
    lower: 0.0,
    upper: 1.0,
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
    one_way: Option<OneWay>,
    fatigue: Option<Fatigue>,
}

/// How fatigue is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Fatigue {
    path: InputPath,
    /// Cycles after which it is what its parameters say.
    cycles: f64,
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
// Of fatigue, in place of those of a stress.
const FATIGUE_AT: usize = 7;

impl LoopModel {
    /// The loop of static recordings, with bounds wide enough for them.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] for no recordings, and what `[model]` says of parameters that do not exist or of
    /// values that cannot be.
    pub fn new(rod: &Rod, rule: Rule, training: &[Recording]) -> Result<Self, IdentifyError> {
        let first = training.first().ok_or(IdentifyError::NoRecordings)?;
        let range = inputs(training);
        let mut parameters = parameters(first.drive_unit(), first.output_unit(), range);
        let one_way = InputPath::over(range.width()).one_way(training);
        if one_way.is_some() {
            // Of one branch as narrow as can be the center is that of the branch, and nothing else is left open.
            let narrowest = parameters[HALF_WIDTH].bounds.lower;
            parameters[HALF_WIDTH].state = ParameterState::Fixed(narrowest);
            parameters[ZETA].state = ParameterState::Fixed(1.0);
        }
        rod.apply_model(&mut parameters)?;
        let model = Self {
            rule,
            parameters,
            one_way,
            fatigue: None,
        };
        Ok(Self {
            one_way: one_way.filter(|_| model.knows_one_branch()),
            ..model
        })
    }

    /// The one way that the input of the training goes, where nothing else tells how wide the loop is: the center is that of this
    /// branch then, and half width and ζ stand for nothing.
    #[must_use]
    pub fn one_way(&self) -> Option<OneWay> {
        self.one_way
    }

    /// True if only one branch of the loop is known, also for a model that was read from a file.
    #[must_use]
    pub fn knows_one_branch(&self) -> bool {
        let half_width = &self.parameters[HALF_WIDTH];
        matches!(half_width.state, ParameterState::Fixed(value) if value <= half_width.bounds.lower)
    }

    /// Adds functional fatigue: the loop drifts with the cycles of its input, by the law of the effect
    /// `functional-fatigue`, and each cycle leaves a lasting part (Eggeler2004 in REFERENCES.md).
    ///
    /// ```text
    /// y = gain ((1 - b s) ξ(u - a s) + c s) + offset,   s = (1 - exp(-k n))/(1 - exp(-k N))
    /// ```
    ///
    /// n counts cycles over the whole range of the input from the start of a recording, smaller ones by their path; N
    /// is the count of the longest recording. a, b and c are totals over N cycles. `None` for fewer than two cycles.
    ///
    /// # Differs from the source
    ///
    /// The effect counts cycles by the amount that transforms, and its sizes are those of the first cycle.
    #[must_use]
    pub fn with_fatigue(mut self, training: &[Recording]) -> Option<Self> {
        let range = inputs(training).width();
        let path = InputPath::over(range);
        let cycles = training.iter().map(|one| path.cycles(one.drive()));
        let cycles = cycles.fold(0.0, f64::max);
        if !(cycles >= 2.0 && cycles.is_finite()) {
            return None;
        }
        let unit = self.parameters[HALF_WIDTH].unit.clone();
        let either_sign = |most: f64| Bounds {
            lower: -most,
            upper: most,
        };
        self.parameters.truncate(FATIGUE_AT);
        let [shift, loss, lasting, fading] = Self::FATIGUE;
        let searched =
            |name, unit: &str, bounds| ParameterInfo::searched(name, unit, Scale::Linear, bounds);
        self.parameters.extend([
            searched(shift, &unit, either_sign(FATIGUE_SHIFT * range)),
            searched(loss, "1", either_sign(FATIGUE_STROKE)),
            searched(lasting, "1", either_sign(FATIGUE_STROKE)),
            searched(fading, "1/cycle", FADING),
        ]);
        self.fatigue = Some(Fatigue { path, cycles });
        Some(self)
    }

    /// The parameters of fatigue: its sizes over all cycles, then the rate at which it fades.
    pub(crate) const FATIGUE: [&'static str; 4] = [
        "fatigue_total_shift",
        "fatigue_total_stroke_loss",
        "fatigue_total_lasting",
        "fatigue_fading",
    ];

    /// Cycles that the sizes of fatigue are of.
    pub(crate) fn fatigue_cycles(&self) -> Option<f64> {
        self.fatigue.map(|fatigue| fatigue.cycles)
    }

    /// Adds stress coupling: the loop's center rises with the recorded stress, by `stress_coupling_k_per_mpa` from its
    /// value at the mean stress of the training (Clausius–Clapeyron; the reciprocal is the coefficient C, MPa/K).
    ///
    /// Shift and stroke follow the stress sample by sample; the stroke changes by `stress_gain_per_mpa` of the gain.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::NoStress`] for a recording without stress.
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

    /// Fixes the center's stress coupling at 0.
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
            one_way: None,
            fatigue: None,
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
        let has_fatigue = self.fatigue.is_some();
        let of_stress = |point: &[f64], index: usize| {
            let value = point.get(index).copied();
            value.filter(|_| !has_fatigue).unwrap_or(0.0)
        };
        let reference = points.first().and_then(|point| point.get(REFERENCE));
        let loads: Vec<f64> = match reference.filter(|_| !has_fatigue) {
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
                coupling_k_per_mpa: of_stress(point, COUPLING),
                gain_per_mpa: of_stress(point, GROWTH),
                fatigue: self.fatigue.and_then(|_| {
                    let [shift, loss, lasting, fading] =
                        point.get(FATIGUE_AT..)?.try_into().ok()?;
                    Some([shift, loss, lasting, fading])
                }),
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
        let loops = Loops {
            rule: self.rule,
            fatigue: self.fatigue,
        };
        Ok(lockstep(&loops, &members, &profile, visit)?)
    }

    fn branches_degc(&self, point: &[f64]) -> Option<[f64; 2]> {
        Some(branches_degc(point[CENTER], point[HALF_WIDTH]))
    }
}

/// The range of all inputs.
fn inputs(training: &[Recording]) -> Bounds {
    Bounds::of(training.iter().flat_map(Recording::drive).copied())
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
        start_share(START[1]),
    ]
}

/// Static loops that run side by side.
#[derive(Debug, Clone, Copy)]
struct Loops {
    rule: Rule,
    fatigue: Option<Fatigue>,
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
    /// Shift, loss, lasting part and fading by the cycles, if they count.
    fatigue: Option<[f64; 4]>,
}

/// A plant whose drive is the input of its loop. The surroundings of a profile hold the stress from its
/// reference, MPa: the loop has no surroundings.
#[derive(Debug, Clone, Copy)]
struct StaticLoop<const L: usize> {
    hysteresis: Hysteresis<L>,
    gain: [f64; L],
    offset: [f64; L],
    coupling_k_per_mpa: [f64; L],
    gain_per_mpa: [f64; L],
    fatigue: Option<Fatigue>,
    shift: [f64; L],
    stroke_loss: [f64; L],
    lasting: [f64; L],
    fading: [f64; L],
}

#[derive(Debug, Clone)]
struct LoopState<const L: usize> {
    input: [f64; L],
    load_mpa: f64,
    /// Where the play of the input stands, and the cycles so far.
    play: f64,
    cycles: f64,
    /// s: what has come of fatigue.
    come: [f64; L],
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
        let fatigue = |k: usize| members.map(|member| member.fatigue.map_or(0.0, |sizes| sizes[k]));
        let plant = StaticLoop {
            hysteresis: Hysteresis::new(limits, proximity, self.rule),
            gain: members.map(|member| member.gain),
            offset: members.map(|member| member.offset),
            coupling_k_per_mpa: members.map(|member| member.coupling_k_per_mpa),
            gain_per_mpa: members.map(|member| member.gain_per_mpa),
            fatigue: self.fatigue,
            shift: fatigue(0),
            stroke_loss: fatigue(1),
            lasting: fatigue(2),
            fading: fatigue(3),
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
            play: input[0],
            cycles: 0.0,
            come: [0.0; L],
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
            let kept = 1.0 - self.stroke_loss[l] * state.come[l];
            let left = self.gain[l] * self.lasting[l] * state.come[l];
            displacement[l] = stroke * kept * state.fraction[l] + left + self.offset[l];
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
        let mut shifted = self.shifted(input.drive, input.ambient_degc);
        if let Some(Fatigue { path, cycles }) = self.fatigue {
            // All members run over one recording.
            let play = path.pushed(state.play, input.drive[0]);
            state.cycles += path.cycles_between(state.play, play);
            state.play = play;
            for l in 0..L {
                state.come[l] = come(state.cycles, cycles, self.fading[l]);
                shifted[l] -= self.shift[l] * state.come[l];
            }
        }
        state.fraction = self.hysteresis.commit(&mut state.memory, shifted);
    }
}

/// s = (1 - exp(-k n))/(1 - exp(-k N)), at k = 0 the limit n/N.
#[inline(always)]
fn come(cycles: f64, of: f64, fading: f64) -> f64 {
    cycles * mean_rate(fading * cycles) / (of * mean_rate(fading * of))
}

/// (1 - exp(-x))/x for x ≥ 0; below 0.01 by its series, error ≤ 2e-13.
#[inline(always)]
fn mean_rate(x: f64) -> f64 {
    const NEAR_ZERO: f64 = 0.01;
    if x < NEAR_ZERO {
        1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0)))
    } else {
        // Beyond, nothing of it is left.
        -expm1(-x.min(700.0)) / x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fatigue_comes_from_nothing_to_all() {
        for fading in [0.0, 1e-9, 1e-4, 0.05, 1.0] {
            assert!(come(0.0, 80.0, fading).abs() < 1e-15);
            assert!((come(80.0, 80.0, fading) - 1.0).abs() < 1e-12);
            let direct = (-30.0 * fading).exp_m1() / (-80.0 * fading).exp_m1();
            let direct = if direct.is_finite() {
                direct
            } else {
                30.0 / 80.0
            };
            assert!((come(30.0, 80.0, fading) - direct).abs() < 1e-9, "{fading}");
        }
    }
}
