use wiener::hysteresis::{Branch, Hysteresis, LoopFamily, Rule, SineProximity};
use wiener::thermal::Heating;
use wiener::{Drive, Input, Output, Plant, Wiener, WienerParams};

use crate::effect::{Base, Instant, Mapped, Moment};
use crate::effects::Effects;
use crate::heat::ZoneHeat;
use crate::hypothesis::{Own, Place};
use crate::loop_scale::LoopScale;
use crate::part::Turn;
use crate::{
    EffectId, EffectSet, EffectValues, ExtendedState, Hypothesis, Need, PhysicsError, Setting,
};

/// The Wiener cascade of `L` actuators side by side, with any of the effects.
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
/// with the baseline's temperature B, heat along the rod included. A few Newton iterations solve it together with the hysteresis, in each
/// lane until it is met. With all sizes 0 the outputs are the bits of [`Wiener`], whatever is active, because each
/// effect adds an exact zero.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtendedPlant<const L: usize = 1> {
    drive: Drive,
    pub(crate) heat: ZoneHeat<L>,
    pub(crate) hysteresis: Hysteresis<L>,
    pub(crate) scale: LoopScale<L>,
    pub(crate) gain: [f64; L],
    pub(crate) offset: [f64; L],
    pub(crate) effects: Effects<L>,
    pub(crate) own: Own<L>,
    pub(crate) path: Path,
    pub(crate) newton_iterations: usize,
    sub_steps: usize,
    start_s: f64,
    /// 0 if the length of the run is unknown.
    per_run_s: f64,
}

/// What the active effects ask of a step: decided once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Path {
    /// A sample must be solved for its end.
    pub(crate) implicit: bool,
    /// The power reaches the rod late; the supply lags, so that a sample in which the rod turns has two parts.
    is_late: bool,
    lags: bool,
    pub(crate) wants_middle: bool,
    pub(crate) changes_ambient: bool,
    pub(crate) stands_in_zone: bool,
    /// The rod has ends.
    has_ends: bool,
    /// The displacement is more than gain and offset.
    shows: bool,
    /// The recorded temperature is not the rod's.
    records: bool,
}

impl Path {
    fn of<const L: usize>(effects: &Effects<L>, own: &Own<L>) -> Self {
        let active = effects.active;
        let delays_output = effects.dead_time.delays_output();
        Self {
            // The solution is written with a shift of the loop, the plain step is not.
            implicit: active.meets(Effects::<L>::IMPLICIT) | own.has(Place::Shift),
            is_late: active.contains(EffectId::DeadTime),
            lags: active.contains(EffectId::SupplyLag),
            wants_middle: active.meets(Effects::<L>::WANT_MIDDLE) | delays_output,
            changes_ambient: active.meets(Effects::<L>::CHANGE_AMBIENT),
            stands_in_zone: active.meets(Effects::<L>::STAND_IN_ZONE),
            has_ends: active.contains(EffectId::EndConduction),
            shows: active.meets(Effects::<L>::SHOW.with(EffectId::EndConduction))
                | own.has(Place::Displacement)
                | delays_output,
            records: active.meets(Effects::<L>::RECORD),
        }
    }

    /// Whether a sample is one step after another: heat, then fraction.
    #[inline(always)]
    fn is_plain(self) -> bool {
        !(self.implicit | self.is_late | self.wants_middle | self.stands_in_zone | self.has_ends)
    }
}

impl<const L: usize> ExtendedPlant<L> {
    /// The plants of `L` lanes: parameters of the baseline and of the effects for each, the setting in
    /// common.
    ///
    /// # Errors
    ///
    /// [`PhysicsError`] naming the value that is out of range, the effect that is not active, or
    /// what an active effect lacks.
    pub fn new(
        setting: &Setting,
        params: &[WienerParams; L],
        values: &[EffectValues; L],
    ) -> Result<Self, PhysicsError> {
        setting.checked()?;
        for effect in setting.active.iter() {
            provided(setting, effect)?;
        }
        for lane in values {
            lane.checked(setting.active)?;
            Hypothesis::checked(setting.hypotheses, &lane.own)?;
        }
        let baseline = Wiener::new(setting.drive, setting.rule, params)?;
        let asymmetry = values.map(|lane| lane.loop_asymmetry.loop_asymmetry);
        let limits = baseline.hysteresis().limits().with_asymmetry(asymmetry)?;
        let proximity = SineProximity::new(params.map(|lane| lane.zeta))?;
        // Relays remember all reversals: that they do is what they are.
        let rule = match setting.loop_family {
            LoopFamily::Relays => Rule::Nested,
            LoopFamily::Proximity | LoopFamily::Kinetics => setting.rule,
        };
        let base = Base {
            setting,
            params,
            other_memory: Hysteresis::new(
                limits,
                proximity,
                match rule {
                    Rule::LastReversal => Rule::Nested,
                    Rule::Nested => Rule::LastReversal,
                },
            )
            .of_family(setting.loop_family),
        };
        let own = Own::new(setting.hypotheses, values);
        let effects = Effects::new(values, &base);
        let heat = params.map(|lane| lane.heat);
        Ok(Self {
            drive: setting.drive,
            heat: ZoneHeat::new(heat)?,
            hysteresis: Hysteresis::new(limits, proximity, rule).of_family(setting.loop_family),
            scale: LoopScale::new(params),
            gain: params.map(|lane| lane.gain),
            offset: params.map(|lane| lane.offset),
            path: Path::of(&effects, &own),
            effects,
            own,
            newton_iterations: setting.newton_iterations,
            sub_steps: setting.sub_steps,
            start_s: setting.start_s,
            per_run_s: setting.run_length_s.map_or(0.0, |length_s| 1.0 / length_s),
        })
    }

    /// The effects that may have a size.
    #[must_use]
    pub fn active(&self) -> EffectSet {
        self.effects.active
    }

    #[inline(always)]
    fn sub_step(&self, state: &mut ExtendedState<L>, input: &Input<L>, dt_s: f64) {
        if !state.sample.is_of(&self.heat.balance, dt_s) {
            self.prepare(state, dt_s);
        }
        let moment = self.moment(state.time_s, dt_s);
        let resistance_ohm_per_m = self.heat.balance.resistance_ohm_per_m();
        let mut drive = input.drive;
        if state.own.is_some() {
            self.begin_own(state, &mut drive, input.ambient_degc);
        }
        let mut power_w_per_m = self.drive.power_w_per_m(drive, resistance_ohm_per_m);
        self.effects
            .power(&mut state.rod, &moment, &mut power_w_per_m);
        state.time_s += dt_s;
        let turn = self.turn(state, power_w_per_m, input.ambient_degc, dt_s);
        if self.path.is_plain() && turn.is_none() {
            self.advance_plainly(state, &moment, power_w_per_m, input.ambient_degc);
        } else {
            let ambient_degc = input.ambient_degc;
            self.advance(state, &moment, power_w_per_m, turn.as_ref(), ambient_degc);
        }
        if let Some(own) = &mut state.own {
            own.end(&state.middle.temperature_degc);
        }
        if self.path.shows {
            state.displacement = self.show(state, &moment, Instant::End);
        }
        if self.path.records {
            let mut surroundings_degc = [input.ambient_degc; L];
            self.effects.ambient(&moment, &mut surroundings_degc);
            state.recorded_degc = state.middle.temperature_degc;
            self.effects.temperature(
                &mut state.rod,
                &state.middle.middle_degc,
                &surroundings_degc,
                &mut state.recorded_degc,
            );
        }
    }

    /// Where the rod may turn within the sample.
    #[inline(always)]
    fn turn(
        &self,
        state: &ExtendedState<L>,
        power_w_per_m: [f64; L],
        ambient_degc: f64,
        dt_s: f64,
    ) -> Option<Turn<L>> {
        if self.path.is_late {
            return Some(state.rod.dead_time.turn(power_w_per_m));
        }
        if !self.path.lags {
            return None;
        }
        let lost_w_per_m = self.heat.lost(&state.middle.temperature_degc, ambient_degc);
        let lag = &self.effects.supply_lag;
        lag.turn(&state.rod.supply_lag, &lost_w_per_m, &power_w_per_m, dt_s)
    }

    /// Evaluates the own hypotheses at the start of a sample.
    #[inline(never)]
    fn begin_own(&self, state: &mut ExtendedState<L>, drive: &mut [f64; L], ambient_degc: f64) {
        let Some(mut own) = state.own.take() else {
            return;
        };
        own.note(drive, ambient_degc, &state.middle.temperature_degc);
        let rod = self.seen_by_own(state, None);
        self.own.drive(&own, self.drive, &rod, drive);
        let cells = state.ends.iter().flat_map(|ends| &ends.cells);
        for (z, zone) in std::iter::once(&state.middle).chain(cells).enumerate() {
            let seen = self.seen_by_own(state, Some(zone));
            self.own.heat_and_shift(&mut own, z, &seen);
        }
        state.own = Some(own);
    }

    /// Coefficients for samples of another length.
    #[inline(never)]
    fn prepare(&self, state: &mut ExtendedState<L>, dt_s: f64) {
        state.sample = self.heat.balance.over(dt_s);
        self.effects.over(&mut state.rod, dt_s);
    }

    #[inline(always)]
    pub(crate) fn moment(&self, time_s: f64, dt_s: f64) -> Moment {
        let run_share = |time_s: f64| (self.start_s + time_s) * self.per_run_s;
        Moment {
            dt_s,
            run_share_middle: run_share(time_s + 0.5 * dt_s),
            run_share_end: run_share(time_s + dt_s),
        }
    }

    /// A sample of the baseline, but for power, surroundings and what becomes of the fraction.
    #[inline(always)]
    fn advance_plainly(
        &self,
        state: &mut ExtendedState<L>,
        moment: &Moment,
        power_w_per_m: [f64; L],
        ambient_degc: f64,
    ) {
        let zone = &mut state.middle;
        let heating = Heating {
            power_w_per_m,
            ambient_degc,
        };
        let heat = &self.heat;
        let mut end_degc = heat
            .balance
            .step(zone.temperature_degc, &heating, &state.sample);
        if self.path.changes_ambient {
            let mut warmer_k = [0.0; L];
            self.effects.ambient(moment, &mut warmer_k);
            heat.warm(&mut end_degc, &state.sample, &warmer_k);
        }
        if let Some(own) = &state.own {
            heat.heat(&mut end_degc, &state.sample, &own.flow_w_per_m[0]);
        }
        let mut mapped = Mapped {
            fraction: self.hysteresis.commit(&mut zone.memory, end_degc),
            slope_per_k: [0.0; L],
        };
        self.effects.fraction(&zone.effects, &end_degc, &mut mapped);
        zone.temperature_degc = end_degc;
        zone.fraction = mapped.fraction;
    }
}

impl<const L: usize> Plant<L> for ExtendedPlant<L> {
    type State = ExtendedState<L>;

    fn rest(&self, ambient_degc: f64) -> ExtendedState<L> {
        self.on_limiting_curve(Branch::Cooling, [ambient_degc; L])
    }

    #[inline(always)]
    fn output(&self, state: &ExtendedState<L>) -> Output<L> {
        Output {
            displacement: if self.path.shows {
                state.displacement
            } else {
                self.read_out(&state.middle.fraction)
            },
            temperature_degc: if self.path.records {
                state.recorded_degc
            } else {
                state.middle.temperature_degc
            },
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut ExtendedState<L>, input: &Input<L>, dt_s: f64) {
        let part_s = dt_s / self.sub_steps as f64;
        for _ in 0..self.sub_steps {
            self.sub_step(state, input, part_s);
        }
    }
}

/// Whether the setting provides what an effect needs.
fn provided(setting: &Setting, effect: EffectId) -> Result<(), PhysicsError> {
    for &need in effect.info().needs {
        let what = match need {
            Need::MassPerMeter if setting.mass_kg_per_m.is_none() => "mass_kg_per_m",
            Need::SurfacePerMeter if setting.surface_m2_per_m.is_none() => "surface_m2_per_m",
            Need::RunLength if setting.run_length_s.is_none() => "run_length_s",
            // The others are for those who interpret the output: it can be computed without.
            _ => continue,
        };
        return Err(PhysicsError::Missing {
            effect: effect.id(),
            what,
        });
    }
    Ok(())
}
