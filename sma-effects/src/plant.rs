use wiener::hysteresis::{Hysteresis, LoopFamily, Rule, SineProximity};
use wiener::thermal::Heating;
use wiener::{Drive, Drives, Output, Shown, Stretch, Wiener, WienerParams, widest_vectors};

use crate::effect::{Base, Instant, Moment};
use crate::effects::Effects;
use crate::heat::ZoneHeat;
use crate::hypothesis::{Own, Place};
use crate::loop_scale::LoopScale;
use crate::part::Turn;
use crate::state::PlantsState;
use crate::{EffectId, EffectSet, EffectValues, Hypothesis, Need, PhysicsError, Setting};

/// The extended plants of `L` lanes, for [`ExtendedPlant`](crate::ExtendedPlant) and [`Extended`](crate::Extended) fleets.
///
/// A sample passes a short way that is inlined, and calls for what only some effects need. Each call is compiled once for
/// each instruction set: a function with everything in it would be many times what the first-level cache holds.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub(crate) struct Plants<const L: usize> {
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

/// Requirements of the active effects on a step, decided once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Path {
    pub(crate) flows: bool,
    pub(crate) shifts: bool,
    pub(crate) changes_power: bool,
    pub(crate) changes_fraction: bool,
    pub(crate) wants_middle: bool,
    pub(crate) changes_ambient: bool,
    pub(crate) stands_in_zone: bool,
    /// A sample must be solved for its end.
    pub(crate) implicit: bool,
    /// A sample is one step after another: heat, then fraction.
    is_plain: bool,
    /// The displacement is more than gain and offset.
    shows: bool,
    /// The recorded temperature is not the rod's.
    records: bool,
}

impl Path {
    fn of<const L: usize>(effects: &Effects<L>, own: &Own<L>) -> Self {
        let active = effects.active;
        let delays_output = effects.dead_time.delays_output();
        let flows = active.meets(Effects::<L>::FLOW);
        let shifts = active.meets(Effects::<L>::SHIFT);
        // The solution is written with a shift of the loop, the plain step is not.
        let implicit = flows | shifts | own.has(Place::Shift);
        let wants_middle = active.meets(Effects::<L>::WANT_MIDDLE) | delays_output;
        let stands_in_zone = active.meets(Effects::<L>::STAND_IN_ZONE);
        let has_ends = active.contains(EffectId::EndConduction);
        Self {
            flows,
            shifts,
            changes_power: active.meets(Effects::<L>::CHANGE_POWER),
            changes_fraction: active.meets(Effects::<L>::CHANGE_FRACTION),
            wants_middle,
            changes_ambient: active.meets(Effects::<L>::CHANGE_AMBIENT),
            stands_in_zone,
            implicit,
            is_plain: !(implicit | wants_middle | stands_in_zone | has_ends),
            shows: active.meets(Effects::<L>::SHOW)
                | has_ends
                | own.has(Place::Displacement)
                | delays_output,
            records: active.meets(Effects::<L>::RECORD),
        }
    }
}

impl<const L: usize> Plants<L> {
    /// The plants of `L` lanes: parameters of the baseline and of the effects for each, the setting in
    /// common.
    ///
    /// # Errors
    ///
    /// [`PhysicsError`] naming the value that is out of range, the effect that is not active, or
    /// what an active effect lacks.
    pub(crate) fn new(
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
        let asymmetry = values
            .each_ref()
            .map(|lane| lane.loop_asymmetry.loop_asymmetry);
        let limits = baseline.hysteresis().limits().with_asymmetry(asymmetry)?;
        let tails = values.each_ref().map(|lane| lane.family.tails);
        let onset = values.each_ref().map(|lane| lane.family.onset);
        let second = values.each_ref().map(|lane| lane.family.second);
        let bends = [0, 1, 2].map(|k| values.each_ref().map(|lane| lane.family.bends[k]));
        let proximity = SineProximity::new(params.each_ref().map(|lane| lane.zeta))?;
        let with_rule = |rule| {
            Hysteresis::new(limits, proximity, rule)
                .of_family(setting.loop_family)
                .with_tails(tails)?
                .with_onset(onset)?
                .with_second_population(second)?
                .with_bends(bends)
        };
        // Relays remember all reversals: that they do is what they are.
        let rule = match setting.loop_family {
            LoopFamily::Relays => Rule::Nested,
            LoopFamily::Proximity | LoopFamily::Kinetics => setting.rule,
        };
        let base = Base {
            setting,
            params,
            other_memory: with_rule(match rule {
                Rule::LastReversal => Rule::Nested,
                Rule::Nested => Rule::LastReversal,
            })?,
        };
        let own = Own::new(setting.hypotheses, values);
        let effects = Effects::new(values, &base);
        let heat = params.each_ref().map(|lane| lane.heat);
        Ok(Self {
            drive: setting.drive,
            heat: ZoneHeat::new(heat)?,
            hysteresis: with_rule(rule)?,
            scale: LoopScale::new(params),
            gain: params.each_ref().map(|lane| lane.gain),
            offset: params.each_ref().map(|lane| lane.offset),
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
    pub(crate) fn active(&self) -> EffectSet {
        self.effects.active
    }

    /// Outputs of the plants in a state.
    #[inline(always)]
    pub(crate) fn output(&self, state: &PlantsState<L>) -> Output<L> {
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

    /// Moves a state on through all samples of a stretch; shows it before each, as [`Lanes::run`](wiener::Lanes::run).
    #[inline(never)]
    pub(crate) fn run(
        &self,
        state: &mut PlantsState<L>,
        stretch: &Stretch<'_, L>,
        shown: &mut Shown<'_, L>,
    ) {
        widest_vectors(
            #[inline(always)]
            || {
                for k in 0..stretch.dt_s.len() {
                    let before = self.output(state);
                    shown.displacement[k] = before.displacement;
                    shown.temperature_degc[k] = before.temperature_degc;
                    let drive = match stretch.drive {
                        Drives::Common(drive) => [drive[k]; L],
                        Drives::Each(drives) => drives[k],
                    };
                    let part_s = stretch.dt_s[k] / self.sub_steps as f64;
                    for _ in 0..self.sub_steps {
                        self.sub_step(state, drive, stretch.ambient_degc[k], part_s);
                    }
                }
            },
        );
    }

    #[inline(always)]
    fn sub_step(
        &self,
        state: &mut PlantsState<L>,
        mut drive: [f64; L],
        ambient_degc: f64,
        dt_s: f64,
    ) {
        if !state.sample.is_of(&self.heat.balance, dt_s) {
            self.prepare(state, dt_s);
        }
        let moment = self.moment(state.time_s, dt_s);
        if state.own.is_some() {
            self.begin_own(state, &mut drive, ambient_degc);
        }
        let resistance_ohm_per_m = self.heat.balance.resistance_ohm_per_m();
        let mut power_w_per_m = self.drive.power_w_per_m(drive, resistance_ohm_per_m);
        let mut turn = None;
        if self.path.changes_power {
            if state.time_s <= 0.0 {
                self.hold(state, ambient_degc);
            }
            self.effects
                .power(&mut state.rod, &moment, &mut power_w_per_m);
            turn = self.turn(state, &power_w_per_m, ambient_degc, dt_s);
        }
        state.time_s += dt_s;
        if self.path.is_plain && turn.is_none() {
            self.advance_plainly(state, &moment, power_w_per_m, ambient_degc);
        } else {
            self.advance(state, &moment, &power_w_per_m, turn.as_ref(), ambient_degc);
        }
        if let Some(own) = &mut state.own {
            own.end(&state.middle.temperature_degc);
        }
        if self.path.shows {
            let mut displacement = [0.0; L];
            self.show(state, &moment, Instant::End, &mut displacement);
            state.displacement = displacement;
        }
        if self.path.records {
            self.record(state, &moment, ambient_degc);
        }
    }

    /// Notes the temperature that is recorded.
    #[inline(never)]
    fn record(&self, state: &mut PlantsState<L>, moment: &Moment, ambient_degc: f64) {
        let mut surroundings_degc = [ambient_degc; L];
        self.effects.ambient(moment, &mut surroundings_degc);
        state.recorded_degc = state.middle.temperature_degc;
        self.effects.temperature(
            &mut state.rod,
            &state.middle.middle_degc,
            &surroundings_degc,
            &mut state.recorded_degc,
        );
    }

    /// Before the first sample the power is what the rod loses at its start, so that it holds: none at rest.
    #[inline(never)]
    fn hold(&self, state: &mut PlantsState<L>, ambient_degc: f64) {
        let lost_w_per_m = self.heat.lost(&state.middle.temperature_degc, ambient_degc);
        self.effects.hold(&mut state.rod, &lost_w_per_m);
    }

    /// Where the rod may turn within the sample.
    #[inline(never)]
    fn turn(
        &self,
        state: &PlantsState<L>,
        power_w_per_m: &[f64; L],
        ambient_degc: f64,
        dt_s: f64,
    ) -> Option<Turn<L>> {
        if let Some(late) = &state.rod.dead_time {
            return late.turn(*power_w_per_m);
        }
        let lost_w_per_m = self.heat.lost(&state.middle.temperature_degc, ambient_degc);
        let lag = &self.effects.supply_lag;
        lag.turn(&state.rod.supply_lag, &lost_w_per_m, power_w_per_m, dt_s)
    }

    /// Evaluates the own hypotheses at the start of a sample.
    #[inline(never)]
    fn begin_own(&self, state: &mut PlantsState<L>, drive: &mut [f64; L], ambient_degc: f64) {
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
    fn prepare(&self, state: &mut PlantsState<L>, dt_s: f64) {
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
        state: &mut PlantsState<L>,
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
        zone.fraction = self.go(zone, &end_degc);
        zone.temperature_degc = end_degc;
    }
}

/// Checks that the setting provides the data that an effect needs.
fn provided(setting: &Setting, effect: EffectId) -> Result<(), PhysicsError> {
    for &need in effect.info().needs {
        let what = match need {
            Need::MassPerMeter if setting.mass_kg_per_m.is_none() => "mass_kg_per_m",
            Need::SurfacePerMeter if setting.surface_m2_per_m.is_none() => "surface_m2_per_m",
            Need::RunLength if setting.run_length_s.is_none() => "run_length_s",
            Need::LargestDrive if setting.largest_drive.is_none() => "largest_drive",
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
