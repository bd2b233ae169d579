use sma_hysteresis::{
    Branch, Hysteresis, HysteresisError, LimitingLoop, LoopParams, Memory, Proximity, Rule,
    SineProximity,
};
use sma_thermal::{HeatBalance, HeatBalanceParams, Heating, Sample};

use crate::{Drive, Input, Output, Plant, Start, WienerError};

/// Parameters of one Wiener model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WienerParams {
    /// Heat balance, eq. 1.
    pub heat: HeatBalanceParams,
    /// Limiting loop, eq. 4.
    pub limiting_loop: LoopParams,
    /// Shape ζ of the proximity function, eq. 12; 0 < ζ ≤ 1.
    pub zeta: f64,
    /// Displacement at fraction 1 minus that at fraction 0, in the recording's unit.
    pub gain: f64,
    /// Displacement at fraction 0, in the recording's unit.
    pub offset: f64,
}

/// The Wiener cascade of `L` actuators side by side.
///
/// ```text
/// drive → heat balance → T → hysteresis → ξ → displacement = gain ξ + offset     [Sadeghi, figure 3]
/// ```
///
/// A linear dynamic block before a static one with memory. Left out: whatever makes the first depend
/// on the second (latent heat, a resistance that changes with the phase, stress).
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Wiener<const L: usize = 1, P = SineProximity<L>> {
    drive: Drive,
    heat: HeatBalance<L>,
    hysteresis: Hysteresis<L, P>,
    gain: [f64; L],
    offset: [f64; L],
}

/// State of a [`Wiener`] model: temperature, and which reversals the material remembers.
///
/// It belongs to the model that made it, as its [`Memory`] does; the heat balance alone would also go on
/// with another model's parameters.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub struct State<const L: usize = 1> {
    temperature_degc: [f64; L],
    fraction: [f64; L],
    memory: Memory<L>,
    /// The last sample's exponentials, kept because most samples are of one length.
    sample: Sample<L>,
}

impl<const L: usize> State<L> {
    /// Temperature of the rod, °C.
    #[must_use]
    pub fn temperature_degc(&self) -> [f64; L] {
        self.temperature_degc
    }

    /// Transformed fraction.
    #[must_use]
    pub fn fraction(&self) -> [f64; L] {
        self.fraction
    }

    /// Memory of the hysteresis.
    #[must_use]
    pub fn memory(&self) -> &Memory<L> {
        &self.memory
    }
}

impl<const L: usize> Wiener<L> {
    /// The paper's model, with parameters for each lane; drive and rule of memory are common.
    ///
    /// # Errors
    ///
    /// [`WienerError`] naming the parameter that is out of range.
    pub fn new(drive: Drive, rule: Rule, lanes: &[WienerParams; L]) -> Result<Self, WienerError> {
        let proximity = SineProximity::new(lanes.each_ref().map(|lane| lane.zeta))?;
        Self::with_proximity(drive, rule, lanes, proximity)
    }
}

impl<const L: usize, P: Proximity> Wiener<L, P> {
    /// The model with another proximity function; `zeta` of the parameters is not used.
    ///
    /// # Errors
    ///
    /// [`WienerError`] naming the parameter that is out of range.
    pub fn with_proximity(
        drive: Drive,
        rule: Rule,
        lanes: &[WienerParams; L],
        proximity: P,
    ) -> Result<Self, WienerError> {
        for lane in lanes {
            for (name, value) in [("gain", lane.gain), ("offset", lane.offset)] {
                if !value.is_finite() {
                    return Err(WienerError::Readout { name, value });
                }
            }
        }
        let limits = LimitingLoop::new(lanes.each_ref().map(|lane| lane.limiting_loop))?;
        Ok(Self {
            drive: drive.checked()?,
            heat: HeatBalance::new(lanes.each_ref().map(|lane| lane.heat))?,
            hysteresis: Hysteresis::new(limits, proximity, rule),
            gain: lanes.each_ref().map(|lane| lane.gain),
            offset: lanes.each_ref().map(|lane| lane.offset),
        })
    }

    /// The hysteresis block.
    #[must_use]
    pub fn hysteresis(&self) -> &Hysteresis<L, P> {
        &self.hysteresis
    }

    /// The heat balance.
    #[must_use]
    pub fn heat(&self) -> &HeatBalance<L> {
        &self.heat
    }

    /// A rod that came to `temperature_degc` along a limiting curve.
    #[must_use]
    pub fn on_limiting_curve(&self, branch: Branch, temperature_degc: [f64; L]) -> State<L> {
        let memory = self.hysteresis.on_limiting_curve(branch, temperature_degc);
        self.state(temperature_degc, memory)
    }

    /// A rod whose past is unknown: `share` = 0 on the heating curve, 1 on the cooling curve; see
    /// [`Hysteresis::between_limiting_curves`].
    #[must_use]
    pub fn between_limiting_curves(&self, temperature_degc: [f64; L], share: [f64; L]) -> State<L> {
        let memory = self
            .hysteresis
            .between_limiting_curves(temperature_degc, share);
        self.state(temperature_degc, memory)
    }

    /// A rod where it starts in each lane; see [`Hysteresis::restart_since_reversal`].
    #[must_use]
    pub fn starting(&self, starts: &[Start; L]) -> State<L> {
        let temperature_degc = starts.map(|start| start.temperature_degc);
        let memory = self.hysteresis.since_reversal(
            temperature_degc,
            starts.map(|start| start.share),
            starts.map(|start| start.since_reversal_k),
        );
        self.state(temperature_degc, memory)
    }

    /// A rod of known temperature and fraction.
    ///
    /// # Errors
    ///
    /// See [`Hysteresis::at`].
    pub fn at(
        &self,
        temperature_degc: [f64; L],
        fraction: [f64; L],
    ) -> Result<State<L>, HysteresisError> {
        let memory = self.hysteresis.at(temperature_degc, fraction)?;
        Ok(self.state(temperature_degc, memory))
    }

    fn state(&self, temperature_degc: [f64; L], memory: Memory<L>) -> State<L> {
        State {
            temperature_degc,
            fraction: self.hysteresis.peek(&memory, temperature_degc).fraction,
            memory,
            sample: self.heat.over(0.0),
        }
    }
}

impl<const L: usize, P: Proximity> Plant<L> for Wiener<L, P> {
    type State = State<L>;

    fn rest(&self, ambient_degc: f64) -> State<L> {
        self.on_limiting_curve(Branch::Cooling, [ambient_degc; L])
    }

    #[inline(always)]
    fn output(&self, state: &State<L>) -> Output<L> {
        let mut displacement = [0.0; L];
        for l in 0..L {
            displacement[l] = self.gain[l] * state.fraction[l] + self.offset[l];
        }
        Output {
            displacement,
            temperature_degc: state.temperature_degc,
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut State<L>, input: &Input<L>, dt_s: f64) {
        if !state.sample.is_of(&self.heat, dt_s) {
            state.sample = self.heat.over(dt_s);
        }
        let heating = Heating {
            power_w_per_m: self
                .drive
                .power_w_per_m(input.drive, self.heat.resistance_ohm_per_m()),
            ambient_degc: input.ambient_degc,
        };
        state.temperature_degc = self
            .heat
            .step(state.temperature_degc, &heating, &state.sample);
        state.fraction = self
            .hysteresis
            .commit(&mut state.memory, state.temperature_degc);
    }
}
