use wiener::{Drives, Input, NARROW, Output, Plant, Shown, Start, Stretch, WienerParams};

use crate::conduction::CELLS;
use crate::plant::Plants;
use crate::state::PlantsState;
use crate::{EffectSet, EffectValues, PhysicsError, Setting};

/// The Wiener cascade of one actuator with any of the effects.
///
/// ```text
/// drive → P(·) → m C_p dT/dt = P - hA (T - T_a) + q(·) → ξ = loop(T - ΔT(·)) → y = gain ξ + offset + …
/// ```
///
/// Over a sample the heat flow beyond the baseline's counts with one value q̄, and what is linear is
/// exact:
///
/// ```text
/// T_1 = B + S q̄(T_0, T_1, ξ_0, ξ_1),   S = (1 - e^(-dt/τ))/(hA)
/// ```
///
/// with the baseline's temperature B, heat along the rod included. A few Newton iterations solve it together with the
/// hysteresis until it is met. With all sizes 0 the outputs are the bits of [`Wiener`](wiener::Wiener), whatever is
/// active, because each effect adds an exact zero.
///
/// It is the first lane of a small chunk of [`Extended`](crate::Extended), so that the equations are compiled once: a
/// fleet runs sixteen plants in about the time that this runs one.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtendedPlant {
    lanes: Plants<NARROW>,
}

/// State of an [`ExtendedPlant`], and of no other: coefficients of that plant are kept in it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtendedState {
    lanes: PlantsState<NARROW>,
}

impl ExtendedPlant {
    /// The plant of these parameters of the baseline and of the effects.
    ///
    /// # Errors
    ///
    /// [`PhysicsError`] naming the value that is out of range, the effect that is not active, or
    /// what an active effect lacks.
    pub fn new(
        setting: &Setting,
        params: &WienerParams,
        values: &EffectValues,
    ) -> Result<Self, PhysicsError> {
        let lanes = Plants::new(setting, &[*params; NARROW], &[*values; NARROW])?;
        Ok(Self { lanes })
    }

    /// The effects that may have a size.
    #[must_use]
    pub fn active(&self) -> EffectSet {
        self.lanes.active()
    }

    /// A rod whose past is unknown: `share` = 0 on the heating curve, 1 on the cooling curve, as in
    /// [`Hysteresis::between_limiting_curves`](wiener::hysteresis::Hysteresis::between_limiting_curves).
    /// All of it has that temperature, and is held there until the first sample: all lags have settled.
    #[must_use]
    pub fn between_limiting_curves(&self, temperature_degc: f64, share: f64) -> ExtendedState {
        self.starting(&Start {
            temperature_degc,
            share,
            since_reversal_k: 0.0,
        })
    }

    /// A rod where it starts. All of it has that temperature, and is held there until the first sample.
    #[must_use]
    pub fn starting(&self, start: &Start) -> ExtendedState {
        let lanes = self.lanes.starting(&[*start; NARROW]);
        ExtendedState { lanes }
    }
}

impl Plant for ExtendedPlant {
    type State = ExtendedState;

    fn rest(&self, ambient_degc: f64) -> ExtendedState {
        self.between_limiting_curves(ambient_degc, 1.0)
    }

    fn output(&self, state: &ExtendedState) -> Output {
        let shown = self.lanes.output(&state.lanes);
        Output {
            displacement: [shown.displacement[0]],
            temperature_degc: [shown.temperature_degc[0]],
        }
    }

    fn step(&self, state: &mut ExtendedState, input: &Input, dt_s: f64) {
        let stretch = Stretch {
            drive: Drives::Common(&input.drive),
            ambient_degc: &[input.ambient_degc],
            dt_s: &[dt_s],
        };
        let mut before = Shown {
            displacement: &mut [[0.0; NARROW]],
            temperature_degc: &mut [[0.0; NARROW]],
        };
        self.lanes.run(&mut state.lanes, &stretch, &mut before);
    }
}

impl ExtendedState {
    /// Temperature of the rod, of its middle if the ends are colder, °C.
    #[must_use]
    pub fn temperature_degc(&self) -> f64 {
        self.lanes.middle.temperature_degc[0]
    }

    /// Temperature next to the clamps, °C; `None` while end conduction is not active.
    #[must_use]
    pub fn end_temperature_degc(&self) -> Option<f64> {
        let ends = self.lanes.ends.as_ref()?;
        Some(ends.cells[CELLS - 1].temperature_degc[0])
    }

    /// Fraction, of the middle if the ends differ.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        self.lanes.middle.fraction[0]
    }

    /// Time since the start of the run, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.lanes.time_s
    }

    /// Residual of the Newton search of the last sub-step, K: the temperature of the heat balance less the
    /// temperature at which the hysteresis was evaluated. Of several zones, the residual of the largest
    /// magnitude. Exactly 0 if nothing had to be searched.
    #[must_use]
    pub fn residual_k(&self) -> f64 {
        self.lanes.residual_k[0]
    }
}
