//! The Wiener cascade as a model to be fitted.

use recording::Recording;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::HeatBalanceParams;
use wiener::{Block, Drive, Profile, Start, WienerParams};

use crate::cascade::{Cascade, StartAbove, ambient_degc};
use crate::specific_heat::SpecificHeat;
use crate::state_of_run::{StateOfRun, in_states};
use crate::validate::samples_at_rest;
use crate::{
    Bounds, Fit, ForwardModel, IdentifyError, Ordinary, ParameterInfo, ParameterState, Rod, Scale,
    Scope,
};

/// Steady rise at the largest drive that is assumed where nothing fixes the scale of temperature, K.
///
/// Displacement and drive alone leave that scale open (all temperature differences times any factor
/// give the same output); only ratios of temperature differences mean anything then.
const ASSUMED_RISE_K: f64 = 100.0;

/// Range of the loop's widths, K: from a fraction of a kelvin to the widest alloys known.
const WIDTHS_K: Bounds = Bounds {
    lower: 0.3,
    upper: 60.0,
};

/// Loop center above ambient up to which is searched, K: the hottest NiTi wires on sale transform below
/// 120 °C, high-temperature alloys need bounds of their own in `[model]`.
const HIGHEST_CENTER_K: f64 = 150.0;

/// Temperature above ambient up to which a recording may begin, K: a drive that completes the transformation of the hottest
/// wire holds it some way above its loop.
const HIGHEST_START_K: f64 = 250.0;

/// Smallest ζ that is searched: below, branches from a limiting curve are thirty times its width long.
const SMALLEST_ZETA: f64 = 0.05;

/// Longest way from the last reversal to the start that is searched, K: one that is longer than the loop is wide tells nothing of it.
const LONGEST_BRANCH_K: f64 = 60.0;

/// Name of the parameter that says how much warmer than stated the surroundings of a recording were.
pub const AMBIENT_LEVEL: &str = "ambient_level_k";

/// Names of what else differs from run to run: by which share a recording loses more heat than the rig, and moves further.
pub const RUN_PARAMETERS: [&str; 2] = ["run_heat_loss", "run_gain"];

/// Names of what says how a recording begins, and their values at rest: no warmer than its surroundings, on the cooling curve. Those
/// of a rod, and of one that pulls against it.
pub(crate) const STARTS: [&[(&str, f64)]; 2] = [
    &START,
    &[
        ("antagonist_start_rise_k", 0.0),
        ("antagonist_start_share", 1.0),
    ],
];

/// Those of a rod; of one that has turned before, by how much it was heated (below 0: cooled) since.
pub(crate) const START: [(&str, f64); 3] = [
    ("start_rise_k", 0.0),
    ("start_share", 1.0),
    (SINCE_REVERSAL, 0.0),
];

/// Name of the parameter that says by how much a rod was heated (below 0: cooled) since it last turned before a recording.
pub const SINCE_REVERSAL: &str = "start_since_reversal_k";

/// Says which parameters a model has behind those of a rod, which it is shown.
pub(crate) type More<'a> = &'a dyn Fn(&[ParameterInfo]) -> Vec<ParameterInfo>;

/// The plain Wiener model of a rig, with the parameters that its rod file leaves open.
#[derive(Debug, Clone)]
pub struct WienerModel {
    cascade: Cascade,
    heat: Heat,
    specific_heat: Option<SpecificHeat>,
    rise_is_assumed: bool,
    parameters: Vec<ParameterInfo>,
    /// Names of the parameters of which `[model]` says something.
    stated: Vec<&'static str>,
    /// Name of the recording whose surroundings are those that the rod file states: the first of the training.
    reference: Option<String>,
}

/// Known properties of the heat balance apart from its time constant.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Heat {
    /// Heat capacity and resistance: the time constant decides all.
    Known {
        heat_capacity_j_per_m_k: f64,
        resistance_ohm_per_m: f64,
    },
    /// Not both: the steady rise per unit of drive stands beside the time constant. A drive of one unit heats with
    /// this power, W/m.
    Constants {
        unit_power_w_per_m: f64,
        resistance_ohm_per_m: f64,
    },
}

impl Heat {
    pub(crate) fn of(rod: &Rod, drive: Drive) -> Result<Self, IdentifyError> {
        Ok(match rod.material() {
            None => {
                let resistance_ohm_per_m = rod.resistance_or_typical_ohm_per_m();
                Self::Constants {
                    unit_power_w_per_m: drive.power_w_per_m([1.0], [resistance_ohm_per_m])[0],
                    resistance_ohm_per_m,
                }
            }
            Some(material) => {
                let heat = material.heat_balance().map_err(wiener::WienerError::from)?;
                Self::Known {
                    heat_capacity_j_per_m_k: heat.heat_capacity_j_per_m_k,
                    resistance_ohm_per_m: heat.resistance_ohm_per_m,
                }
            }
        })
    }

    /// The heat balance of a time constant τ, s, and where it does not follow from it of a steady rise per unit of drive.
    pub(crate) fn balance(self, tau_s: f64, rise: f64) -> HeatBalanceParams {
        match self {
            Self::Known {
                heat_capacity_j_per_m_k,
                resistance_ohm_per_m,
            } => HeatBalanceParams {
                heat_capacity_j_per_m_k,
                conductance_w_per_m_k: heat_capacity_j_per_m_k / tau_s,
                resistance_ohm_per_m,
            },
            Self::Constants {
                unit_power_w_per_m,
                resistance_ohm_per_m,
            } => {
                let conductance_w_per_m_k = unit_power_w_per_m / rise;
                HeatBalanceParams {
                    heat_capacity_j_per_m_k: tau_s * conductance_w_per_m_k,
                    conductance_w_per_m_k,
                    resistance_ohm_per_m,
                }
            }
        }
    }
}

// Order of the parameters in a point.
pub(crate) const TAU: usize = 0;
pub(crate) const CENTER: usize = 1;
pub(crate) const HALF_WIDTH: usize = 2;
pub(crate) const SPREAD: usize = 3;
const ZETA: usize = 4;
pub(crate) const GAIN: usize = 5;
pub(crate) const OFFSET: usize = 6;
pub(crate) const START_RISE: usize = 7;
pub(crate) const START_SHARE: usize = 8;
pub(crate) const START_SINCE_REVERSAL: usize = 9;
const LEVEL: usize = 10;
const HEAT_LOSS_OF_RUN: usize = 11;
const GAIN_OF_RUN: usize = 12;
const RISE: usize = 13;

impl WienerModel {
    /// The model of a rig, with bounds wide enough for the given training recordings.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] for recordings without time, a missing ambient temperature or supply, and what
    /// `[model]` says of parameters that do not exist or of values that cannot be.
    pub fn new(rod: &Rod, rule: Rule, training: &[Recording]) -> Result<Self, IdentifyError> {
        Self::with_more(rod, rule, training, &|_| Vec::new())
    }

    /// The model of a rig with further parameters behind its own, for a model that holds this one.
    pub(crate) fn with_more(
        rod: &Rod,
        rule: Rule,
        training: &[Recording],
        more: More<'_>,
    ) -> Result<Self, IdentifyError> {
        let first = training.first().ok_or(IdentifyError::NoRecordings)?;
        let ambient_degc = ambient_degc(rod, training)?;
        let cascade = Cascade::new(rod, rule)?;
        let drive = cascade.drive;
        let heat = Heat::of(rod, drive)?;
        let mut parameters = parameters(first.output_unit(), ambient_degc, tau_bounds_s(training)?);
        let has_rise = matches!(heat, Heat::Constants { .. });
        if has_rise {
            let mut rise = rise(drive, training);
            // A recorded temperature fixes the scale.
            if training
                .iter()
                .any(|recording| recording.temperature_degc().is_some())
            {
                rise.state = ParameterState::Free;
            }
            parameters.push(rise);
        }
        parameters.extend(more(&parameters));
        let state = |parameters: &[ParameterInfo]| has_rise.then(|| parameters[RISE].state);
        let assumed = state(&parameters);
        rod.apply_model(&mut parameters)?;
        let kept = state(&parameters);
        let names = parameters.iter().map(|info| info.name);
        Ok(Self {
            stated: names.filter(|name| rod.says_of(name)).collect(),
            // What the user fixes is known; what the data fix is, too.
            rise_is_assumed: kept == assumed && matches!(kept, Some(ParameterState::Fixed(_))),
            cascade,
            heat,
            specific_heat: SpecificHeat::of(rod, ambient_degc),
            parameters,
            reference: Some(first.name().to_owned()),
        })
    }

    /// The model of a rig before anything is known of recordings: its parameters have placeholders for units
    /// and bounds, to be set from elsewhere.
    pub(crate) fn template(
        rod: &Rod,
        rule: Rule,
        rise_is_assumed: bool,
        more: More<'_>,
    ) -> Result<Self, IdentifyError> {
        let cascade = Cascade::new(rod, rule)?;
        let heat = Heat::of(rod, cascade.drive)?;
        let mut parameters = parameters("1", 0.0, Bounds::NONE);
        if matches!(heat, Heat::Constants { .. }) {
            parameters.push(rise(cascade.drive, &[]));
        }
        parameters.extend(more(&parameters));
        Ok(Self {
            cascade,
            heat,
            specific_heat: None,
            rise_is_assumed,
            parameters,
            stated: Vec::new(),
            reference: None,
        })
    }

    /// Sets the reference: the recording whose surroundings are those that the rod file states.
    pub(crate) fn with_reference(self, reference: Option<&str>) -> Self {
        Self {
            reference: reference.map(str::to_owned),
            ..self
        }
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut [ParameterInfo] {
        &mut self.parameters
    }

    /// Widens the intervals of the temperatures of a fit to hold for the whole range that the rod file gives
    /// the specific heat. Returns whether there was anything to widen: a range, and a scale of temperature
    /// that rests on it.
    ///
    /// Exact in surroundings of one temperature. Covariance and values stay as they are.
    pub fn carry_specific_heat(&self, fit: &mut Fit) -> bool {
        self.specific_heat.is_some_and(|heat| heat.widen(fit))
    }

    /// True if temperatures are in kelvins. Else only ratios of their differences mean anything: an assumed rise fixes
    /// the scale by convention only.
    #[must_use]
    pub fn knows_temperature(&self) -> bool {
        !self.rise_is_assumed
    }

    /// How the drive heats the rod.
    #[must_use]
    pub fn drive(&self) -> Drive {
        self.cascade.drive
    }

    /// Rule of the hysteresis' memory.
    #[must_use]
    pub fn rule(&self) -> Rule {
        self.cascade.rule
    }

    /// Drive and surroundings of the rod in a recording.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Untimed`], [`IdentifyError::Missing`] for the ambient temperature, and what a profile
    /// refuses.
    pub fn profile<'a>(&self, recording: &'a Recording) -> Result<Profile<'a>, IdentifyError> {
        self.cascade.profile(recording)
    }

    /// Where a recording starts at a point: above its first ambient temperature, K, and between the limiting
    /// curves.
    #[must_use]
    pub fn start(&self, point: &[f64], first_ambient_degc: f64) -> Start {
        Start {
            temperature_degc: first_ambient_degc + point[START_RISE],
            share: point[START_SHARE],
            since_reversal_k: point[START_SINCE_REVERSAL],
        }
    }

    /// The model's parameters for one point; gain 1 and offset 0 unless the point has them.
    #[must_use]
    pub fn wiener_params(&self, point: &[f64]) -> WienerParams {
        WienerParams {
            heat: self
                .heat
                .balance(point[TAU], point.get(RISE).copied().unwrap_or(f64::NAN)),
            limiting_loop: LoopParams {
                loop_center_degc: point[CENTER],
                loop_half_width_k: point[HALF_WIDTH],
                loop_spread_k: point[SPREAD],
                ..LoopParams::default()
            },
            zeta: point[ZETA],
            gain: point[GAIN],
            offset: point[OFFSET],
        }
    }
}

impl WienerModel {
    /// Frees the parameters of single recordings that may not be known for all of them: the level of the surroundings
    /// where they were not recorded, and the start of the run where it may have begun warm. Parameters that `[model]`
    /// states stay. `recordings` are all that the model will be asked of, those of the training first.
    #[must_use]
    pub fn with_unknowns<'a>(&self, recordings: impl IntoIterator<Item = &'a Recording>) -> Self {
        let recordings: Vec<&Recording> = recordings.into_iter().collect();
        self.with_open_starts(recordings.iter().copied())
            .with_open_levels(recordings)
    }

    /// Frees the level of the surroundings of each recording where those of some were not recorded; that of the first recording only if
    /// the temperature of its rod was. `recordings` are all that the model will be asked of, those of the training first. A level that
    /// `[model]` states stays.
    #[must_use]
    pub fn with_open_levels<'a>(
        &self,
        recordings: impl IntoIterator<Item = &'a Recording>,
    ) -> Self {
        let mut model = self.clone();
        let mut recordings = recordings.into_iter().enumerate();
        if recordings.any(|(k, recording)| {
            recording.ambient_degc().is_none() && (k > 0 || tells_surroundings(recording))
        }) {
            model.leave_open(LEVEL);
        }
        model
    }

    /// Frees an assumed scale of temperature where surroundings of several temperatures were recorded.
    #[must_use]
    pub fn with_scale_told_by(&self, recordings: &[Recording]) -> Self {
        let mut model = self.clone();
        if model.rise_is_assumed && tell_scale(recordings) {
            model.leave_open(RISE);
            model.rise_is_assumed = false;
        }
        model
    }

    /// Frees the deviations from run to run of a rig that does not repeat: how much heat each run loses, and how far it
    /// moves. Parameters that `[model]` states stay. Only their priors ([`ParameterInfo::ordinary`]) keep them from
    /// absorbing any misfit of the model: fits must be told to count the priors ([`Prior`](crate::Prior)).
    #[must_use]
    pub fn with_state_of_runs(&self) -> Self {
        let mut model = self.clone();
        model.leave_open(HEAT_LOSS_OF_RUN);
        model.leave_open(GAIN_OF_RUN);
        model
    }

    /// Removes the reference recording: each recording has a state of its own, about the stated properties of the rig.
    #[must_use]
    pub fn without_reference_run(&self) -> Self {
        self.clone().with_reference(None)
    }

    /// True if the heat loss of single recordings, or how far they move, is free.
    #[must_use]
    pub fn has_state_of_runs(&self) -> bool {
        let of_run = [HEAT_LOSS_OF_RUN, GAIN_OF_RUN];
        of_run
            .iter()
            .any(|&index| self.parameters[index].state == ParameterState::Free)
    }

    /// Frees the start of each recording, temperature and place between the limiting curves, if one of them may have
    /// begun warm ([`may_begin_warm`]). Parameters that `[model]` states stay.
    #[must_use]
    pub fn with_open_starts<'a>(
        &self,
        recordings: impl IntoIterator<Item = &'a Recording>,
    ) -> Self {
        let mut model = self.clone();
        if recordings.into_iter().any(may_begin_warm) {
            model.leave_open(START_RISE);
            model.leave_open(START_SHARE);
        }
        model
    }

    /// Frees by how much the rod was heated since it last turned before each recording, if the start of recordings is open: a rod at rest
    /// has not turned. Where the branch to the next reversal is short it tells nothing that the place between the limiting curves does not.
    #[must_use]
    pub fn with_open_reversals(&self) -> Self {
        let mut model = self.clone();
        if self.parameters[START_RISE].state == ParameterState::Free {
            model.leave_open(START_SINCE_REVERSAL);
        }
        model
    }

    /// Leaves a parameter open unless `[model]` says something of it.
    pub(crate) fn leave_open(&mut self, index: usize) {
        let info = &mut self.parameters[index];
        if !self.stated.contains(&info.name) {
            info.state = ParameterState::Free;
        }
    }

    /// Simulates under another drive than that of the recording, of as many samples; as [`ForwardModel::simulate`].
    pub(crate) fn simulate_driven(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        drive: &[f64],
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let state = |point: &[f64]| self.state_of_run(point, recording);
        let states = points.iter().map(|point| state(point)).collect();
        let mut visit = in_states(states, visit);
        self.cascade
            .simulate_driven(points, recording, drive, &mut visit, |point| {
                let start = StartAbove {
                    rise_k: point[START_RISE],
                    share: point[START_SHARE],
                    since_reversal_k: point[START_SINCE_REVERSAL],
                };
                (state(point).of(self.wiener_params(point)), start)
            })
    }

    /// Deviation of a recording from the stated properties of the rig. It is 0 in the first training recording:
    /// properties common to all are the rig's, and a loop that lies higher acts like colder surroundings; unless the temperature of the rod
    /// was recorded, which tells them apart. Surroundings that are recorded, or stated of this recording, do not
    /// deviate; unless the scale of temperature is assumed: then their kelvins are not those of the model.
    #[must_use]
    pub fn state_of_run(&self, point: &[f64], recording: &Recording) -> StateOfRun {
        let is_reference = self.reference.as_deref() == Some(recording.name());
        let is_known = recording.ambient_degc().is_some() && !self.rise_is_assumed;
        let has_level = !is_known && (!is_reference || tells_surroundings(recording));
        let unless = |is_none: bool, place: usize| if is_none { 0.0 } else { point[place] };
        StateOfRun {
            level_k: unless(!has_level, LEVEL),
            heat_loss: unless(is_reference, HEAT_LOSS_OF_RUN),
            gain: unless(is_reference, GAIN_OF_RUN),
        }
    }
}

impl ForwardModel for WienerModel {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        self.simulate_driven(points, recording, recording.drive(), visit)
    }

    fn branches_degc(&self, point: &[f64]) -> Option<[f64; 2]> {
        Some(branches_degc(point[CENTER], point[HALF_WIDTH]))
    }
}

/// Of a loop with its center and its half width in a point.
pub(crate) fn branches_degc(center_degc: f64, half_width_k: f64) -> [f64; 2] {
    [center_degc - half_width_k, center_degc + half_width_k]
}

fn parameters(output_unit: &str, ambient_degc: f64, tau_s: Bounds) -> Vec<ParameterInfo> {
    let center = Bounds {
        lower: ambient_degc,
        upper: ambient_degc + HIGHEST_CENTER_K,
    };
    vec![
        ParameterInfo::searched("tau_s", "s", Scale::Logarithmic, tau_s),
        ParameterInfo::searched("loop_center_degc", "°C", Scale::Linear, center),
        ParameterInfo::searched("loop_half_width_k", "K", Scale::Logarithmic, WIDTHS_K),
        ParameterInfo::searched("loop_spread_k", "K", Scale::Logarithmic, WIDTHS_K),
        zeta(),
        ParameterInfo::gain(output_unit),
        ParameterInfo::offset(output_unit),
        start_rise(START[0]),
        start_share(START[1]),
        since_reversal(START[2]),
        level(),
        // Air that moves, dust on the rod, how it hangs.
        of_run(RUN_PARAMETERS[0], 0.05),
        // The mount, and what wears.
        of_run(RUN_PARAMETERS[1], 0.01),
    ]
}

/// Shape of the proximity function.
pub(crate) fn zeta() -> ParameterInfo {
    let bounds = Bounds {
        lower: SMALLEST_ZETA,
        upper: 1.0,
    };
    ParameterInfo {
        admissible: Bounds {
            lower: 1e-6,
            upper: 1.0,
        },
        ..ParameterInfo::searched("zeta", "1", Scale::Linear, bounds)
    }
}

/// Temperature at the start above ambient: none, unless `[model]` frees it.
pub(crate) fn start_rise((name, at_rest): (&'static str, f64)) -> ParameterInfo {
    let bounds = Bounds {
        lower: 0.0,
        upper: HIGHEST_START_K,
    };
    ParameterInfo {
        scope: Scope::PerRecording,
        state: ParameterState::Fixed(at_rest),
        ..ParameterInfo::searched(name, "K", Scale::Linear, bounds)
    }
}

/// Place between the limiting curves at the start: on the cooling one, unless `[model]` frees it.
pub(crate) fn start_share((name, at_rest): (&'static str, f64)) -> ParameterInfo {
    let bounds = Bounds {
        lower: 0.0,
        upper: 1.0,
    };
    ParameterInfo {
        admissible: bounds,
        scope: Scope::PerRecording,
        state: ParameterState::Fixed(at_rest),
        ..ParameterInfo::searched(name, "1", Scale::Linear, bounds)
    }
}

/// By how much a rod was heated (below 0: cooled) before the start since it last turned: it turns there, unless freed.
fn since_reversal((name, at_rest): (&'static str, f64)) -> ParameterInfo {
    let bounds = Bounds {
        lower: -LONGEST_BRANCH_K,
        upper: LONGEST_BRANCH_K,
    };
    ParameterInfo {
        scope: Scope::PerRecording,
        state: ParameterState::Fixed(at_rest),
        ..ParameterInfo::searched(name, "K", Scale::Linear, bounds)
    }
}

/// Temperature of a recording's surroundings above what is stated: none, unless freed.
pub(crate) fn level() -> ParameterInfo {
    /// Rooms differ by a few kelvins from day to day.
    const MOST_K: f64 = 10.0;
    /// As they ordinarily do.
    const ORDINARY_K: f64 = 2.0;
    let bounds = Bounds {
        lower: -MOST_K,
        upper: MOST_K,
    };
    ParameterInfo {
        scope: Scope::PerRecording,
        state: ParameterState::Fixed(0.0),
        ordinary: Some(Ordinary {
            deviation: ORDINARY_K,
            from_previous: false,
        }),
        ..ParameterInfo::searched(AMBIENT_LEVEL, "K", Scale::Linear, bounds)
    }
}

/// A share by which a recording differs from the rig: none, unless freed. `ordinary` is its deviation from run to run.
fn of_run(name: &'static str, ordinary: f64) -> ParameterInfo {
    /// Ordinary deviations within which it is searched.
    const MOST: f64 = 5.0;
    let bounds = Bounds {
        lower: -MOST * ordinary,
        upper: MOST * ordinary,
    };
    ParameterInfo {
        scope: Scope::PerRecording,
        state: ParameterState::Fixed(0.0),
        ordinary: Some(Ordinary {
            deviation: ordinary,
            from_previous: false,
        }),
        ..ParameterInfo::searched(name, "1", Scale::Linear, bounds)
    }
}

/// True if a recording tells how warm its surroundings were, where they were not recorded: a rod at rest is as warm.
fn tells_surroundings(recording: &Recording) -> bool {
    recording.temperature_degc().is_some() && recording.ambient_degc().is_none()
}

/// True if a recording may not begin at rest: it is driven from its first sample, its output moves before the drive, or the output
/// begins far from where the rod comes to when it cools.
#[must_use]
pub fn may_begin_warm(recording: &Recording) -> bool {
    /// Samples from which a mean is taken.
    const FEW: usize = 5;
    /// Share of the output's range that is no noise.
    const MOVED: f64 = 0.02;
    /// Share of it that is no drift of the zero, no expansion and no wear.
    const FAR: f64 = 0.1;
    /// Correlation of the output with the heat from which the output says where the rod is cold.
    const CLEAR: f64 = 0.5;
    let output = recording.output();
    let at_rest = samples_at_rest(recording);
    if at_rest < 2 * FEW {
        return at_rest < 2;
    }
    let mean = |range: &[f64]| range.iter().sum::<f64>() / range.len() as f64;
    let begins = mean(&output[..FEW]);
    let moved = begins - mean(&output[at_rest - FEW..at_rest]);
    let means = output.windows(FEW).map(mean);
    let (low, high) = means.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
        (y.min(low), y.max(high))
    });
    let range = high - low;
    let is_far = || match with_heat(recording) {
        // A pair of rods comes to the middle.
        _ if recording.antagonist_drive().is_some() => false,
        along if along > CLEAR => begins - low > FAR * range,
        along if along < -CLEAR => high - begins > FAR * range,
        _ => false,
    };
    moved.abs() > MOVED * range || is_far()
}

/// Correlation of the output with the power of the drive as a rod of some time constant takes it up: the largest over time constants from one
/// sample to half of the recording, with its sign.
fn with_heat(recording: &Recording) -> f64 {
    /// From one time constant to the next.
    const APART: f64 = 3.0;
    let output = recording.output();
    let n = output.len() as f64;
    let mean = output.iter().sum::<f64>() / n;
    let of_tau = |samples: f64| {
        // As of a current: any power grows with that of the drive.
        let mut power = recording
            .drive()
            .iter()
            .map(|drive| drive * drive)
            .peekable();
        let mut heat = power.peek().copied().unwrap_or(0.0);
        let (mut sum, mut square, mut along, mut own) = (0.0, 0.0, 0.0, 0.0);
        for (power, output) in power.zip(output) {
            heat += (power - heat) / (1.0 + samples);
            let output = output - mean;
            sum += heat;
            square += heat * heat;
            along += heat * output;
            own += output * output;
        }
        let variances = (square - sum * sum / n) * own;
        if variances > 0.0 {
            along / variances.sqrt()
        } else {
            0.0
        }
    };
    let taus = std::iter::successors(Some(1.0), |tau| Some(APART * tau));
    let of_each = taus.take_while(|tau| *tau < 0.5 * n).map(of_tau);
    let stronger = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
    of_each.fold(0.0, stronger)
}

/// Steady rise per unit of drive (λ for a current), fixed by assumption: so that the largest drive of
/// the training data heats by [`ASSUMED_RISE_K`] in the end.
pub(crate) fn rise(drive: Drive, training: &[Recording]) -> ParameterInfo {
    let drives = training.iter().map(Recording::largest_drive);
    let largest = drives.fold(0.0, f64::max);
    let [unit, most] = drive.power_w_per_m([1.0, largest], [1.0; 2]);
    let value = ASSUMED_RISE_K * unit / most;
    let (name, unit) = match drive {
        Drive::Current => ("lambda_k_per_a2", "K/A²"),
        Drive::Duty { .. } => ("rise_k_per_duty", "K"),
        Drive::Voltage { .. } => ("rise_k_per_v2", "K/V²"),
        Drive::Power { .. } => ("rise_k_per_w", "K/W"),
    };
    let bounds = Bounds {
        lower: 1e-3 * value,
        upper: 1e3 * value,
    };
    ParameterInfo {
        state: ParameterState::Fixed(value),
        ..ParameterInfo::searched(name, unit, Scale::Logarithmic, bounds)
    }
}

/// True if surroundings of more than one temperature were recorded: a rod that is heated as much is then as much warmer, and
/// the loop says by how many of its own kelvins.
fn tell_scale(recordings: &[Recording]) -> bool {
    let mut recorded = recordings
        .iter()
        .filter_map(Recording::ambient_degc)
        .flatten();
    let first = recorded.next();
    recorded.any(|ambient_degc| Some(ambient_degc) != first)
}

/// Time constants worth looking for, s: from that of the finest sampling to the longest recording,
/// below and beyond which nothing of an exponential shows.
pub(crate) fn tau_bounds_s(training: &[Recording]) -> Result<Bounds, IdentifyError> {
    let mut bounds = Bounds {
        lower: f64::INFINITY,
        upper: 0.0,
    };
    for recording in training {
        let untimed = || IdentifyError::Untimed {
            recording: recording.name().to_owned(),
        };
        let dt_s = recording.sampling().usual_dt_s().ok_or_else(untimed)?;
        bounds.lower = bounds.lower.min(dt_s);
        bounds.upper = bounds.upper.max(dt_s * recording.len() as f64);
    }
    Ok(bounds)
}
