//! The heat balance alone, for recordings whose output is the temperature.

use recording::{Recording, Sampling};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::{Block, Drive, WienerParams};

use crate::cascade::{Cascade, StartAbove};
use crate::fit::VERY_STRONG;
use crate::sensor_lag::SensorLag;
use crate::temperature_unit::TemperatureUnit;
use crate::validate::samples_at_rest;
use crate::wiener_model::{AMBIENT_LEVEL, Heat, START, level, rise, tau_bounds_s};
use crate::{
    Bounds, Enters, Fit, ForwardModel, IdentifyError, ParameterInfo, ParameterState,
    ParameterVector, Rod, Scale, Scope,
};

/// Names of what belongs to a recording.
const AMBIENT: &str = "ambient_degc";
const START_RISE: &str = START[0].0;

/// A rod whose temperature is the output: eqs 1-3 without the loop.
///
/// ```text
/// τ dT/dt = λ i² - (T - T_a)          [Sadeghi, eqs 1, 2]
/// θ dT'/dt = T - T',   y = T' in the unit of the output
/// ```
///
/// T' is what a sensor shows that follows the rod with a time constant θ; 0 unless it shows. λ, the steady rise per unit of drive,
/// is searched; where the rod file gives heat capacity and resistance it follows from τ. T_a is that of the recording or of the rod
/// file; without either it is searched, for each recording. Two time constants in a row look the same whichever comes first: the
/// longer is called the rod's, unless heat capacity and resistance tell.
#[derive(Debug, Clone)]
pub struct ThermalModel {
    cascade: Cascade,
    heat: Heat,
    unit: TemperatureUnit,
    parameters: Vec<ParameterInfo>,
}

// Order of the parameters in a point; the rise is there only where it does not follow from τ.
const TAU: usize = 0;
const AMBIENT_AT: usize = 1;
const LEVEL: usize = 2;
const START_AT: usize = 3;
const LAG: usize = 4;
const RISE: usize = 5;

impl ThermalModel {
    /// Name of the sensor's time constant, that of the effect `thermocouple-lag`.
    pub const LAG: &'static str = "thermocouple_lag_s";

    /// True if an output in this unit is a temperature.
    #[must_use]
    pub fn is_for(output_unit: &str) -> bool {
        TemperatureUnit::of(output_unit).is_some()
    }

    /// The model of a rig, with bounds wide enough for the given training recordings.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] for recordings without time, an output that is no temperature, surroundings that only some recordings have,
    /// and what `[model]` says of parameters that do not exist or of values that cannot be.
    pub fn new(rod: &Rod, training: &[Recording]) -> Result<Self, IdentifyError> {
        let first = training.first().ok_or(IdentifyError::NoRecordings)?;
        let mut model = Self::template(rod, first.output_unit())?;
        let seen = seen(model.unit, training);
        model.parameters[TAU].bounds = {
            let bounds = tau_bounds_s(training)?;
            // Of a recording with gaps the usual sample is not the mean one.
            let span_s = |one: &Recording| {
                let ends = one.time_s().first().zip(one.time_s().last());
                ends.map_or(0.0, |(first, last)| last - first)
            };
            Bounds {
                upper: training.iter().map(span_s).fold(bounds.upper, f64::max),
                ..bounds
            }
        };
        model.parameters[AMBIENT_AT] = ambient(known_ambient(rod, training)?, seen);
        model.parameters[START_AT].bounds = Bounds {
            lower: -2.0 * seen.width(),
            upper: 2.0 * seen.width(),
        };
        if let Some(free) = model.parameters.get_mut(RISE) {
            *free = ParameterInfo {
                state: ParameterState::Free,
                ..rise(model.cascade.drive, training)
            };
        }
        let model = model.with_starts_of(training);
        Ok(Self {
            parameters: {
                let mut parameters = model.parameters;
                rod.apply_model(&mut parameters)?;
                parameters
            },
            ..model
        })
    }

    /// The model before anything is known of recordings; see [`WienerModel::template`](crate::WienerModel).
    pub(crate) fn template(rod: &Rod, output_unit: &str) -> Result<Self, IdentifyError> {
        let unit =
            TemperatureUnit::of(output_unit).ok_or_else(|| IdentifyError::NoTemperature {
                file: rod.file.clone(),
                unit: output_unit.to_owned(),
            })?;
        let drive = match rod.drive() {
            // A duty without its supply: then only what a duty of 1 does counts.
            Err(IdentifyError::Missing { .. }) => Drive::Duty {
                supply_v: 1.0,
                length_m: rod.length_m.unwrap_or(1.0),
            },
            known => known?,
        };
        let heat = Heat::of(rod, drive)?;
        let mut parameters = vec![
            ParameterInfo::searched("tau_s", "s", Scale::Logarithmic, Bounds::NONE),
            ambient(Some(0.0), Bounds::NONE),
            level(),
            start_rise(),
            lag(),
        ];
        if matches!(heat, Heat::Constants { .. }) {
            parameters.push(rise(drive, &[]));
        }
        Ok(Self {
            cascade: Cascade {
                drive,
                // Of a loop that nobody sees.
                rule: Rule::LastReversal,
                ambient_degc: Some(0.0),
            },
            heat,
            unit,
            parameters,
        })
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut [ParameterInfo] {
        &mut self.parameters
    }

    /// Frees the parameters of single recordings if one of these recordings differs from the stated values: the start,
    /// if it is away from the surroundings, and the level of the surroundings, if a rod at rest shows that they differ.
    /// Parameters that `[model]` fixes at another value than 0 stay.
    #[must_use]
    pub fn with_starts_of<'a>(
        mut self,
        recordings: impl IntoIterator<Item = &'a Recording>,
    ) -> Self {
        for recording in recordings {
            let begins = Begins::of(recording, self.unit);
            let stated = recording.ambient_degc().map(|recorded| recorded[0]);
            let stated = stated.or(match self.parameters[AMBIENT_AT].state {
                ParameterState::Fixed(degc) => Some(degc),
                ParameterState::Free => None,
            });
            let mut free = |index: usize| {
                let info: &mut ParameterInfo = &mut self.parameters[index];
                if info.state == ParameterState::Fixed(0.0) {
                    info.state = ParameterState::Free;
                }
            };
            match stated {
                Some(ambient_degc) if begins.is_away_from(ambient_degc) => {
                    free(START_AT);
                    if begins.rests {
                        free(LEVEL);
                    }
                }
                None if begins.moves || begins.falls_below => free(START_AT),
                _ => {}
            }
        }
        self
    }

    /// The model with a sensor that lags, and coordinates to search it from, to be tried after a fit without lag;
    /// `None` if `[model]` says something of the lag.
    ///
    /// The searches start with a small lag and the time constant of the fit without lag, which is near the sum of both.
    /// If either time constant could be the rod's, the rod thus gets the longer one.
    #[must_use]
    pub fn with_lag(&self, without: &Fit) -> Option<(Self, Vec<Vec<f64>>)> {
        /// Lags to start from, as shares of the time constant of the fit without.
        const SHARES: [f64; 2] = [0.05, 0.25];
        if self.parameters[LAG].state != ParameterState::Fixed(0.0) {
            return None;
        }
        let mut model = self.clone();
        let tau_s = without.parameters.get(TAU)?.values[0];
        let lag = &mut model.parameters[LAG];
        lag.state = ParameterState::Free;
        lag.bounds = Bounds {
            lower: 0.0,
            upper: if self.tells_which_lags() {
                self.parameters[TAU].bounds.upper.max(tau_s)
            } else {
                tau_s
            },
        };
        let vector = ParameterVector::new(model.parameters(), without.recordings.len());
        let from = SHARES.map(|share| {
            vector.coordinates(|parameter, r| {
                if parameter == LAG {
                    return Some(share * tau_s);
                }
                let values = &without.parameters.get(parameter)?.values;
                values.get(r).or(values.first()).copied()
            })
        });
        Some((model, from.to_vec()))
    }

    /// True if a fit of [`ThermalModel::with_lag`] is to be accepted: it converged, Schwarz's criterion prefers it by
    /// far, and neither time constant is on a bound.
    ///
    /// Intervals are not used: two equal time constants have unbounded intervals, although both together are well
    /// known.
    #[must_use]
    pub fn lag_shows(&self, without: &Fit, with: &Fit) -> bool {
        /// Rounding, where both are one.
        const EQUAL: f64 = 1.01;
        let [tau, lag] = [TAU, LAG].map(|index| &with.parameters[index]);
        let is_named = self.tells_which_lags() || lag.values[0] <= EQUAL * tau.values[0];
        with.converged()
            && is_named
            && !(tau.at_bound || lag.at_bound)
            && with.bic < without.bic - VERY_STRONG
    }

    /// True if a sensor that lags is part of the model.
    #[must_use]
    pub fn has_lag(&self) -> bool {
        self.parameters[LAG].state != ParameterState::Fixed(0.0)
    }

    /// True if the steady rise, which follows from the rod's time constant, distinguishes it from the sensor's.
    #[must_use]
    pub fn tells_which_lags(&self) -> bool {
        matches!(self.heat, Heat::Known { .. })
    }

    /// Names of the parameters that are a recording's own.
    #[must_use]
    pub fn is_of_recording(name: &str) -> bool {
        [AMBIENT, AMBIENT_LEVEL, START_RISE].contains(&name)
    }

    /// Temperature that the surroundings of a recording are simulated above, K: nothing where they are recorded.
    fn level_k(point: &[f64], recording: &Recording) -> f64 {
        let stated = if recording.ambient_degc().is_some() {
            0.0
        } else {
            point[AMBIENT_AT]
        };
        stated + point[LEVEL]
    }

    fn wiener_params(&self, point: &[f64]) -> WienerParams {
        WienerParams {
            heat: self
                .heat
                .balance(point[TAU], point.get(RISE).copied().unwrap_or(f64::NAN)),
            limiting_loop: LoopParams::default(),
            zeta: 1.0,
            gain: 1.0,
            offset: 0.0,
        }
    }
}

impl ForwardModel for ThermalModel {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let dt_s: &dyn Fn(usize) -> f64 = match recording.sampling() {
            Sampling::Uniform { dt_s } => &move |_| dt_s,
            _ => &|k| recording.time_s()[k + 1] - recording.time_s()[k],
        };
        let levels_k: Vec<f64> = points
            .iter()
            .map(|point| Self::level_k(point, recording))
            .collect();
        let mut sensors: Vec<SensorLag> = points
            .iter()
            .map(|point| SensorLag::new(point[TAU], point[LAG]))
            .collect();
        let (mut rod, mut shown) = (Vec::new(), Vec::new());
        let mut show = |block: Block<'_>| {
            rod.clear();
            rod.extend_from_slice(block.temperature_degc);
            shown.clear();
            shown.resize(rod.len(), 0.0);
            let rows = rod.chunks_exact_mut(block.stride);
            let rows = rows.zip(shown.chunks_exact_mut(block.stride));
            for (row, (rod, shown)) in rows.enumerate() {
                let sample = block.first_sample + row;
                for l in 0..block.members {
                    let member = block.first_member + l;
                    rod[l] += levels_k[member];
                    let before_s = match sample {
                        0 => 0.0,
                        _ => dt_s(sample - 1),
                    };
                    let sensed_degc = sensors[member].follow(rod[l], before_s);
                    shown[l] = self.unit.shown(sensed_degc);
                }
            }
            visit(Block {
                displacement: &shown,
                temperature_degc: &rod,
                ..block
            });
        };
        self.cascade
            .simulate(points, recording, &mut show, |point| {
                let start = StartAbove {
                    rise_k: point[START_AT],
                    share: 1.0,
                    since_reversal_k: 0.0,
                };
                (self.wiener_params(point), start)
            })
    }
}

/// True if the samples before the drive rises determine the recording's own parameters. Start and surroundings together
/// need a whole recording: a rod that has hardly begun to cool does not show towards which temperature.
pub(crate) fn rest_tells_all(parameters: &[ParameterInfo]) -> bool {
    let own = |info: &&ParameterInfo| {
        info.enters == Enters::Nonlinear
            && info.state == ParameterState::Free
            && [AMBIENT, AMBIENT_LEVEL].contains(&info.name)
    };
    let surroundings = parameters.iter().filter(own).count();
    let is_thermal = parameters.iter().any(|info| info.name == ThermalModel::LAG);
    let start = parameters
        .iter()
        .any(|info| info.name == START_RISE && info.state == ParameterState::Free);
    !(is_thermal && start && surroundings > 0)
}

/// Temperature of the surroundings that is stated for all recordings, °C; `None` if it is to be found.
fn known_ambient(rod: &Rod, training: &[Recording]) -> Result<Option<f64>, IdentifyError> {
    let recorded: Vec<f64> = training
        .iter()
        .filter_map(|recording| Some(recording.ambient_degc()?[0]))
        .collect();
    match (rod.ambient_degc, recorded.first()) {
        (Some(degc), _) => Ok(Some(degc)),
        (None, Some(&first)) if recorded.len() == training.len() => Ok(Some(first)),
        (None, Some(_)) => Err(IdentifyError::Missing {
            file: rod.file.clone(),
            key: "surroundings.ambient_degc",
            why: "some recordings have a column for it, others do not",
        }),
        (None, None) => Ok(None),
    }
}

/// Temperature of the surroundings, °C: known, or to be found near what was seen of the rod.
fn ambient(known_degc: Option<f64>, seen_degc: Bounds) -> ParameterInfo {
    ParameterInfo {
        scope: Scope::PerRecording,
        state: known_degc.map_or(ParameterState::Free, ParameterState::Fixed),
        ..ParameterInfo::searched(
            AMBIENT,
            "°C",
            Scale::Linear,
            Bounds {
                // A rod that is driven from the first sample to the last is never as cold.
                lower: seen_degc.lower - 2.0 * seen_degc.width(),
                upper: seen_degc.upper,
            },
        )
    }
}

/// Temperature at the start above the surroundings, of either sign: none, unless a recording says otherwise.
fn start_rise() -> ParameterInfo {
    ParameterInfo {
        scope: Scope::PerRecording,
        state: ParameterState::Fixed(0.0),
        ..ParameterInfo::searched(START_RISE, "K", Scale::Linear, Bounds::NONE)
    }
}

/// Time constant of the sensor: none, unless it shows.
fn lag() -> ParameterInfo {
    let admissible = Bounds {
        lower: 0.0,
        upper: 1e12,
    };
    ParameterInfo {
        admissible,
        state: ParameterState::Fixed(0.0),
        ..ParameterInfo::searched(ThermalModel::LAG, "s", Scale::Linear, admissible)
    }
}

/// Lowest and highest temperature of some recordings, °C.
fn seen(unit: TemperatureUnit, recordings: &[Recording]) -> Bounds {
    let all = recordings.iter().flat_map(Recording::output);
    Bounds::of(all.map(|&shown| unit.degc(shown)))
}

/// How a recording of a temperature begins.
#[derive(Debug, Clone, Copy)]
struct Begins {
    /// Mean of its first samples, °C.
    first_degc: f64,
    /// Largest error of a mean of so few samples, K.
    doubt_k: f64,
    /// True if it is undriven long enough to show a drift, and shows none.
    rests: bool,
    /// True if it moves before it is driven.
    moves: bool,
    /// True if it is colder later on.
    falls_below: bool,
}

impl Begins {
    /// Samples from which a mean is taken.
    const FEW: usize = 5;
    /// Standard errors that are no noise.
    const BEYOND_NOISE: f64 = 4.0;

    fn of(recording: &Recording, unit: TemperatureUnit) -> Self {
        let degc: Vec<f64> = recording
            .output()
            .iter()
            .map(|&shown| unit.degc(shown))
            .collect();
        let few = Self::FEW.min(degc.len());
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let first_degc = mean(&degc[..few]);
        let doubt_k = Self::BEYOND_NOISE * noise_k(&degc) / (few as f64).sqrt();
        let at_rest = samples_at_rest(recording);
        let is_seen = at_rest >= 2 * Self::FEW;
        let is_moved =
            is_seen && (mean(&degc[at_rest - few..at_rest]) - first_degc).abs() > doubt_k;
        let lowest = degc.windows(few).map(mean).fold(f64::INFINITY, f64::min);
        Self {
            first_degc,
            doubt_k,
            rests: is_seen && !is_moved,
            moves: is_moved,
            // The lowest of many means lies further out than one does.
            falls_below: lowest < first_degc - 2.0 * doubt_k,
        }
    }

    fn is_away_from(&self, ambient_degc: f64) -> bool {
        (self.first_degc - ambient_degc).abs() > self.doubt_k
    }
}

/// Noise of a temperature from sample to sample, K, standard deviation: from second differences, which no drift and no slope reach;
/// at least the step of its converter.
fn noise_k(degc: &[f64]) -> f64 {
    /// Standard deviation over median absolute value of a normal distribution.
    const NORMAL: f64 = 1.4826;
    let sorted = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values
    };
    let bends = degc.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs());
    let bends = sorted(bends.collect());
    let median_k = bends.get(bends.len() / 2).copied().unwrap_or(0.0);
    // Weights 1, -2, 1: six times the variance.
    let noise_k = NORMAL * median_k / 6.0_f64.sqrt();
    if noise_k > 0.0 {
        return noise_k;
    }
    // Most neighbors are equal: a converter, whose least step is what can be seen.
    let steps = degc.windows(2).map(|w| (w[1] - w[0]).abs());
    let steps = sorted(steps.filter(|step| *step > 0.0).collect());
    steps.first().copied().unwrap_or(0.0)
}
