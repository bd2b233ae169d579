//! One sample where heat and transformation may depend on each other, in one part or two.

use crate::effect::{Acting, Before, Instant, Mapped, Moment, Trial, counted};
use crate::heat::{Reference, ZoneHeat};
use crate::hypothesis::OwnMemory;
use crate::part::{Part, Stage, progress};
use crate::plant::ExtendedPlant;
use crate::solve::{Evaluated, Problem};
use crate::state::{ExtendedState, Zone};

/// What is the same for all zones in a part of a sample.
#[derive(Debug)]
struct Leg<'a, const L: usize> {
    stage: &'a Stage<L>,
    /// Length of the whole sample, s.
    dt_s: f64,
    /// Temperature of the surroundings in the baseline, °C.
    ambient_degc: f64,
    /// What own hypotheses add.
    own: Option<&'a OwnMemory<L>>,
    /// What warm clamps save the ends, W/m.
    saved_w_per_m: [f64; L],
}

impl<const L: usize> ExtendedPlant<L> {
    /// Moves the zones to the end of the sample.
    #[inline(always)]
    pub(crate) fn advance(
        &self,
        state: &mut ExtendedState<L>,
        moment: &Moment,
        power_w_per_m: [f64; L],
        ambient_degc: f64,
    ) {
        let mut acting = Acting {
            per_s: [if moment.dt_s > 0.0 {
                1.0 / moment.dt_s
            } else {
                0.0
            }; L],
            ambient_degc: [ambient_degc; L],
            power_w_per_m,
        };
        self.effects.ambient(moment, &mut acting.ambient_degc);
        let mut stage = Stage::whole(acting);
        state.residual_k = [0.0; L];
        if self.path.in_parts {
            let past = &state.rod.dead_time;
            let (share, earlier_w_per_m) = (past.earlier_share, past.earlier_w_per_m);
            stage.divide(Part::Earlier, &share, moment.dt_s);
            stage.acting.power_w_per_m = earlier_w_per_m;
            self.advance_part(state, &stage, moment.dt_s, ambient_degc);
            self.show(state, moment, Instant::Turn);
            stage.divide(Part::Later, &share, moment.dt_s);
            stage.acting.power_w_per_m = power_w_per_m;
        }
        self.advance_part(state, &stage, moment.dt_s, ambient_degc);
        if self.path.wants_middle {
            self.show(state, moment, Instant::Middle);
        }
    }

    #[inline(always)]
    fn advance_part(
        &self,
        state: &mut ExtendedState<L>,
        stage: &Stage<L>,
        dt_s: f64,
        ambient_degc: f64,
    ) {
        let mut leg = Leg {
            stage,
            dt_s,
            ambient_degc,
            own: state.own.as_deref(),
            saved_w_per_m: [0.0; L],
        };
        let residual_k = match &mut state.ends {
            None => self.advance_zones([&self.middle], [&mut state.middle], &leg),
            Some(ends) => {
                let heat = [&self.middle, &self.ends];
                let (conduction, clamps) =
                    (&self.effects.end_conduction, &mut state.rod.end_conduction);
                let length_s = stage.share.map(|share| share * dt_s);
                let before_k = stage.above_ambient_k(&ends.temperature_degc);
                leg.saved_w_per_m = conduction.saved_w_per_m(clamps, &before_k, &length_s);
                let residual_k = self.advance_zones(heat, [&mut state.middle, &mut **ends], &leg);
                let after_k = stage.above_ambient_k(&ends.temperature_degc);
                let mean_k = core::array::from_fn(|l| 0.5 * (before_k[l] + after_k[l]));
                conduction.follow(clamps, &mean_k, &length_s);
                residual_k
            }
        };
        for l in 0..L {
            state.residual_k[l] = larger(state.residual_k[l], residual_k[l]);
        }
    }

    /// Moves all zones to the end of a part; returns the residual, K.
    #[inline(always)]
    fn advance_zones<const Z: usize>(
        &self,
        heat: [&ZoneHeat<L>; Z],
        zones: [&mut Zone<L>; Z],
        leg: &Leg<'_, L>,
    ) -> [f64; L] {
        let mut reference = [Reference::ZERO; Z];
        let mut before = [Before::ZERO; Z];
        let mut share = [[0.0; L]; Z];
        let mut own_shift_k = [[0.0; L]; Z];
        for z in 0..Z {
            reference[z] = heat[z].reference(zones[z], leg.stage, leg.dt_s, leg.ambient_degc);
            share[z] = zones[z].transformed;
            if let Some(own) = leg.own {
                own_shift_k[z] = own.shift_k[z];
                for l in 0..L {
                    let sensitivity = reference[z].sensitivity_k_m_per_w[l];
                    reference[z].end_degc[l] += sensitivity * own.flow_w_per_m[z][l];
                }
            }
        }
        if Z > 1 {
            for l in 0..L {
                let sensitivity = reference[Z - 1].sensitivity_k_m_per_w[l];
                reference[Z - 1].end_degc[l] += sensitivity * leg.saved_w_per_m[l];
            }
        }
        let mean = self.mean(&share);
        for z in 0..Z {
            before[z] = start_of(heat[z], zones[z], mean, leg);
        }
        let mut driving = [[0.0; L]; Z];
        let mut slope = [[0.0; L]; Z];
        let mut end_degc = [[0.0; L]; Z];
        for z in 0..Z {
            driving[z] = reference[z].end_degc;
            end_degc[z] = reference[z].end_degc;
        }
        if self.path.implicit {
            let problem = Problem {
                acting: &leg.stage.acting,
                before: &before,
                reference: &reference,
                own_shift_k: &own_shift_k,
            };
            self.solve(&problem, &zones, &mut driving, &mut slope);
        }
        for z in 0..Z {
            if self.path.wants_middle {
                self.pass_middle(heat[z], zones[z], &driving[z], leg);
            }
            self.commit(zones[z], &driving[z], &mut share[z]);
            zones[z].slope_per_k = slope[z];
        }
        let mut residual_k = [0.0; L];
        if self.path.implicit {
            let problem = Problem {
                acting: &leg.stage.acting,
                before: &before,
                reference: &reference,
                own_shift_k: &own_shift_k,
            };
            let mut at = Evaluated::ZERO;
            self.evaluate(&problem, &zones, [&driving, &share, &slope], &mut at);
            for z in 0..Z {
                for l in 0..L {
                    // The heat that is counted is that of the path taken: energy telescopes over
                    // samples, whatever Newton left.
                    end_degc[z][l] += reference[z].sensitivity_k_m_per_w[l] * at.flow[z].w_per_m[l];
                    let left_k = end_degc[z][l] - at.trial[z].temperature_degc[l];
                    residual_k[l] = larger(residual_k[l], left_k);
                }
            }
        }
        if self.path.stands_in_zone {
            let mean = self.mean(&share);
            for z in 0..Z {
                let trial = Trial {
                    driving_degc: driving[z],
                    temperature_degc: end_degc[z],
                    transformed: share[z],
                    slope_per_k: slope[z],
                    mean,
                    ..Trial::ZERO
                };
                self.effects
                    .commit(&mut zones[z].effects, &before[z], &trial);
            }
        }
        for z in 0..Z {
            if self.path.wants_middle {
                note_middle(heat[z], zones[z], &end_degc[z], leg);
            }
            zones[z].temperature_degc = end_degc[z];
        }
        residual_k
    }

    /// Takes the hysteresis of a zone to a driving temperature.
    #[inline(always)]
    fn commit(&self, zone: &mut Zone<L>, driving_degc: &[f64; L], share: &mut [f64; L]) {
        let mut mapped = Mapped {
            fraction: self.hysteresis.commit(&mut zone.memory, *driving_degc),
            slope_per_k: [0.0; L],
        };
        self.effects
            .fraction(&zone.effects, driving_degc, &mut mapped);
        for l in 0..L {
            share[l] = self.scale.transformed(l, mapped.fraction[l]);
        }
        zone.driving_degc = *driving_degc;
        zone.fraction = mapped.fraction;
        zone.transformed = *share;
    }

    /// Notes the fraction in the middle of the sample, on the way to a driving temperature.
    #[inline(always)]
    fn pass_middle(
        &self,
        heat: &ZoneHeat<L>,
        zone: &mut Zone<L>,
        driving_degc: &[f64; L],
        leg: &Leg<'_, L>,
    ) {
        let mut passed_degc = [0.0; L];
        for l in 0..L {
            let done = leg.middle(heat, l);
            let change_k = driving_degc[l] - zone.driving_degc[l];
            passed_degc[l] = zone.driving_degc[l] + change_k * done;
        }
        let mut mapped = Mapped {
            fraction: self.hysteresis.peek(&zone.memory, passed_degc).fraction,
            slope_per_k: [0.0; L],
        };
        self.effects
            .fraction(&zone.effects, &passed_degc, &mut mapped);
        for l in 0..L {
            let before = zone.middle_fraction[l];
            let here = leg.stage.has_middle[l];
            zone.middle_fraction[l] = if here { mapped.fraction[l] } else { before };
        }
    }
}

impl<const L: usize> Leg<'_, L> {
    /// dt/τ of the part.
    #[inline(always)]
    fn rate(&self, heat: &ZoneHeat<L>, l: usize) -> f64 {
        heat.rate(l, self.dt_s) * self.stage.share[l]
    }

    /// Share of a change over the part that is done in the middle of the sample.
    #[inline(always)]
    fn middle(&self, heat: &ZoneHeat<L>, l: usize) -> f64 {
        progress(self.stage.middle[l], self.rate(heat, l))
    }
}

#[inline(always)]
fn start_of<const L: usize>(
    heat: &ZoneHeat<L>,
    zone: &Zone<L>,
    mean: [f64; L],
    leg: &Leg<'_, L>,
) -> Before<L> {
    let mut before = Before {
        temperature_degc: zone.temperature_degc,
        transformed: zone.transformed,
        mean,
        slope_per_k: zone.slope_per_k,
        driving_degc: zone.driving_degc,
        ..Before::ZERO
    };
    for l in 0..L {
        let rate = leg.rate(heat, l);
        before.rate[l] = rate;
        before.counted[l] = counted(rate * heat.path_share[l], rate);
    }
    before
}

/// Notes the temperature in the middle of the sample, before a zone moves on.
#[inline(always)]
fn note_middle<const L: usize>(
    heat: &ZoneHeat<L>,
    zone: &mut Zone<L>,
    end_degc: &[f64; L],
    leg: &Leg<'_, L>,
) {
    for l in 0..L {
        let change_k = end_degc[l] - zone.temperature_degc[l];
        let passed_degc = zone.temperature_degc[l] + change_k * leg.middle(heat, l);
        let before_degc = zone.middle_degc[l];
        let here = leg.stage.has_middle[l];
        zone.middle_degc[l] = if here { passed_degc } else { before_degc };
    }
}

/// That of two which is larger in magnitude.
#[inline(always)]
fn larger(one: f64, other: f64) -> f64 {
    if other.abs() > one.abs() { other } else { one }
}
