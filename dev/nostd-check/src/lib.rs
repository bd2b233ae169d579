//! Proof that the model crates build without std and alloc: what an interrupt handler would call.
//!
//! `cargo check -p nostd-check` is the test, run by itself so that no other member turns features on. It
//! holds no logic of its own.

#![no_std]

use pid_tune::{
    GainSchedule, GainScheduleParams, Pid, PidGains, PidParams, PidState, Sample as Measurement,
    TuneError,
};
use sma_hysteresis::{
    Branch, Hysteresis, HysteresisError, LimitingLoop, LoopParams, Memory, Rule, SineProximity,
};
use sma_thermal::{HeatBalance, Heating, Reach, RodParams, Sample, ThermalError};
use wiener::{Drive, Input, Output, Plant, Profile, State, Wiener, WienerError, WienerParams};

/// A rod's heat balance and its sample of `dt_s`, made once at start-up.
///
/// # Errors
///
/// [`ThermalError`] naming the measure that is out of range.
pub fn warm_up(rod: &RodParams, dt_s: f64) -> Result<(HeatBalance, Sample), ThermalError> {
    let heat = HeatBalance::new([rod.heat_balance()?])?;
    let sample = heat.over(dt_s);
    Ok((heat, sample))
}

/// Temperature one sample later, °C.
#[must_use]
pub fn warm(heat: &HeatBalance, sample: &Sample, temperature_degc: f64, heating: &Heating) -> f64 {
    let [temperature_degc] = heat.step([temperature_degc], heating, sample);
    temperature_degc
}

/// Current that reaches a temperature in time, A.
///
/// # Errors
///
/// [`ThermalError`] where no current does.
pub fn current_a(heat: &HeatBalance, reach: &Reach) -> Result<f64, ThermalError> {
    heat.current_to_reach_a(reach)
}

/// A material at rest at a temperature, °C.
///
/// # Errors
///
/// [`HysteresisError`] naming the parameter that is out of range.
pub fn material(
    limiting_loop: LoopParams,
    zeta: f64,
    temperature_degc: f64,
) -> Result<(Hysteresis<1>, Memory<1>), HysteresisError> {
    let limits = LimitingLoop::new([limiting_loop])?;
    let material = Hysteresis::new(limits, SineProximity::new([zeta])?, Rule::Nested);
    let memory = material.on_limiting_curve(Branch::Cooling, [temperature_degc]);
    Ok((material, memory))
}

/// Fraction at the next temperature, °C, and its slope there, 1/K.
pub fn transform(
    material: &Hysteresis<1>,
    memory: &mut Memory<1>,
    temperature_degc: f64,
) -> (f64, f64) {
    let sensed = material.peek(memory, [temperature_degc]);
    let [fraction] = material.commit(memory, [temperature_degc]);
    (fraction, sensed.slope_per_k[0])
}

/// A cascade at rest, °C.
///
/// # Errors
///
/// [`WienerError`] naming the parameter that is out of range.
pub fn actuator(
    drive: Drive,
    params: &WienerParams,
    ambient_degc: f64,
) -> Result<(Wiener, State), WienerError> {
    let model = Wiener::new(drive, Rule::Nested, &[*params])?;
    let state = model.rest(ambient_degc);
    Ok((model, state))
}

/// One step of the cascade: what it shows, then what the drive does to it.
pub fn step(model: &Wiener, state: &mut State, input: &Input, dt_s: f64) -> Output {
    let output = model.output(state);
    model.step(state, input, dt_s);
    output
}

/// Displacement before the last sample of a profile.
pub fn last_displacement(model: &Wiener, state: &mut State, profile: &Profile<'_>) -> f64 {
    let mut displacement = f64::NAN;
    wiener::run(model, state, profile, |_, output| {
        [displacement] = output.displacement
    });
    displacement
}

/// A controller whose gains follow the level and the branch.
///
/// # Errors
///
/// [`TuneError`] naming the factor that is out of range.
pub fn scheduled(params: PidParams, factors: GainScheduleParams) -> Result<PidParams, TuneError> {
    Ok(PidParams {
        gain_schedule: Some(GainSchedule::new(factors)?),
        ..params
    })
}

/// A controller for one rod, waiting at a measured displacement.
///
/// # Errors
///
/// [`TuneError`] naming the setting that is out of range.
pub fn controller(
    params: PidParams,
    gains: PidGains,
    measured: f64,
) -> Result<(Pid, PidState), TuneError> {
    let controller = Pid::new(params, &[gains])?;
    let state = controller.rest([measured])?;
    Ok((controller, state))
}

/// The drive for the next sample: what a timer interrupt calls.
pub fn control(controller: &Pid, state: &mut PidState, setpoint: f64, measured: f64) -> f64 {
    let sample = Measurement {
        setpoint,
        measured: [measured],
        feed_forward: 0.0,
    };
    let [drive] = controller.step(state, &sample).drive;
    drive
}
