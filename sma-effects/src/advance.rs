//! One sample where heat and transformation may depend on each other, in one part or two.

use wiener::thermal::Sample;

use crate::conduction::{NODES, PerZone, Transfer, ZONES, beyond_mean_k_per_s};
use crate::effect::{Acting, Before, Instant, Mapped, Moment, Trial, counted};
use crate::heat::Reference;
use crate::hypothesis::OwnMemory;
use crate::part::{Part, Stage, Turn, progress, unit};
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
    /// Coefficients of the whole sample.
    sample: &'a Sample<L>,
    /// What own hypotheses add.
    own: Option<&'a OwnMemory<L>>,
    /// Heat along the rod.
    along: Option<Along<'a, L>>,
}

/// What moves heat along the rod in a part of a sample.
#[derive(Debug)]
struct Along<'a, const L: usize> {
    transfer: &'a Transfer<L>,
    /// Nodes above the surroundings at the start, K.
    above_k: [[f64; L]; NODES],
    /// Heat into each zone beyond that at the mean conductivity, W/m.
    beyond_w_per_m: PerZone<L>,
}

/// What became of a part of a sample in `Z` zones.
#[derive(Debug)]
struct Advanced<const L: usize, const Z: usize> {
    /// What the search left, K.
    residual_k: [f64; L],
    /// Heat beyond the baseline's into each zone, W/m.
    extra_w_per_m: [[f64; L]; Z],
}

impl<const L: usize> ExtendedPlant<L> {
    /// Moves the zones to the end of the sample, in two parts if it has a turn.
    #[inline(always)]
    pub(crate) fn advance(
        &self,
        state: &mut ExtendedState<L>,
        moment: &Moment,
        power_w_per_m: [f64; L],
        turn: Option<&Turn<L>>,
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
        if let Some(turn) = turn {
            stage.divide(Part::Earlier, &turn.share, moment.dt_s);
            stage.acting.power_w_per_m = turn.earlier_w_per_m;
            self.advance_part(state, &stage, moment.dt_s, ambient_degc);
            self.show(state, moment, Instant::Turn);
            stage.divide(Part::Later, &turn.share, moment.dt_s);
            stage.acting.power_w_per_m = turn.later_w_per_m;
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
            sample: &state.sample,
            own: state.own.as_deref(),
            along: None,
        };
        let residual_k = match &mut state.ends {
            None => self.advance_zones([&mut state.middle], &leg).residual_k,
            Some(ends) => {
                let conduction = &self.effects.end_conduction;
                let length_s = stage.share.map(|share| share * dt_s);
                let beyond_per_s = &conduction.beyond_per_s;
                let transfer = ends
                    .transfers
                    .over(&length_s, &self.heat.per_tau_s, beyond_per_s);
                let mut above_k = [ends.clamp_k; NODES];
                let mut transformed = [state.middle.transformed; ZONES];
                let zones = std::iter::once(&state.middle).chain(&ends.cells);
                for (z, zone) in zones.enumerate() {
                    transformed[z] = zone.transformed;
                    for l in 0..L {
                        above_k[z][l] = zone.temperature_degc[l] - stage.acting.ambient_degc[l];
                    }
                }
                let start_k_per_s =
                    beyond_mean_k_per_s(beyond_per_s, &conduction.ways, &above_k, &transformed);
                let mut beyond_w_per_m = ends.beyond.over(&start_k_per_s, &length_s);
                for beyond in &mut beyond_w_per_m {
                    for l in 0..L {
                        beyond[l] /= self.heat.per_capacity_k_m_per_j[l];
                    }
                }
                leg.along = Some(Along {
                    transfer,
                    above_k,
                    beyond_w_per_m,
                });
                let [first, second, third, fourth, last] = &mut ends.cells;
                let zones = [&mut state.middle, first, second, third, fourth, last];
                let advanced = self.advance_zones(zones, &leg);
                let mut rate_k_per_s = advanced.extra_w_per_m;
                for rate_k_per_s in &mut rate_k_per_s {
                    for l in 0..L {
                        let power_w_per_m = rate_k_per_s[l] + stage.acting.power_w_per_m[l];
                        rate_k_per_s[l] = power_w_per_m * self.heat.per_capacity_k_m_per_j[l];
                    }
                }
                ends.clamp_k = transfer.clamp_k(&above_k, &rate_k_per_s);
                advanced.residual_k
            }
        };
        for l in 0..L {
            state.residual_k[l] = larger(state.residual_k[l], residual_k[l]);
        }
    }

    /// Moves all zones to the end of a part.
    #[inline(always)]
    fn advance_zones<const Z: usize>(
        &self,
        zones: [&mut Zone<L>; Z],
        leg: &Leg<'_, L>,
    ) -> Advanced<L, Z> {
        let mut reference_degc = [[0.0; L]; Z];
        let mut sensitivity_k_m_per_w = [[[0.0; L]; Z]; Z];
        let mut before = [Before::ZERO; Z];
        let mut share = [[0.0; L]; Z];
        let mut own_shift_k = [[0.0; L]; Z];
        let mut extra_w_per_m = [[0.0; L]; Z];
        for z in 0..Z {
            let start_degc = &zones[z].temperature_degc;
            let Reference {
                end_degc,
                sensitivity_k_m_per_w: by_itself,
            } = self.heat.reference(
                start_degc,
                leg.sample,
                leg.stage,
                leg.dt_s,
                leg.ambient_degc,
            );
            reference_degc[z] = end_degc;
            sensitivity_k_m_per_w[z][z] = by_itself;
            share[z] = zones[z].transformed;
        }
        if let Some(along) = &leg.along {
            self.conduct(
                along,
                leg.stage,
                &mut reference_degc,
                &mut sensitivity_k_m_per_w,
            );
            extra_w_per_m = core::array::from_fn(|z| along.beyond_w_per_m[z]);
        }
        if let Some(own) = leg.own {
            for z in 0..Z {
                own_shift_k[z] = own.shift_k[z];
                for l in 0..L {
                    extra_w_per_m[z][l] += own.flow_w_per_m[z][l];
                }
                for k in 0..Z {
                    for l in 0..L {
                        reference_degc[z][l] +=
                            sensitivity_k_m_per_w[z][k][l] * own.flow_w_per_m[k][l];
                    }
                }
            }
        }
        let mean = self.mean(&share);
        for z in 0..Z {
            before[z] = self.start_of(z, zones[z], mean, leg);
        }
        let mut driving = reference_degc;
        let mut slope = [[0.0; L]; Z];
        let mut end_degc = reference_degc;
        if self.path.implicit {
            let problem = Problem {
                acting: &leg.stage.acting,
                before: &before,
                reference_degc: &reference_degc,
                sensitivity_k_m_per_w: &sensitivity_k_m_per_w,
                own_shift_k: &own_shift_k,
            };
            self.solve(&problem, &zones, &mut driving, &mut slope);
        }
        for z in 0..Z {
            if self.path.wants_middle {
                self.pass_middle(z, zones[z], &driving[z], leg);
            }
            self.commit(zones[z], &driving[z], &mut share[z]);
            zones[z].slope_per_k = slope[z];
        }
        let mut residual_k = [0.0; L];
        if self.path.implicit {
            let problem = Problem {
                acting: &leg.stage.acting,
                before: &before,
                reference_degc: &reference_degc,
                sensitivity_k_m_per_w: &sensitivity_k_m_per_w,
                own_shift_k: &own_shift_k,
            };
            let mut at = Evaluated::ZERO;
            self.evaluate(&problem, &zones, [&driving, &share, &slope], &mut at);
            for z in 0..Z {
                let warmed_k = problem.warmed_k(z, &at.flow);
                for l in 0..L {
                    // The heat that is counted is that of the path taken: energy telescopes over
                    // samples, whatever Newton left.
                    end_degc[z][l] += warmed_k[l];
                    extra_w_per_m[z][l] += at.flow[z].w_per_m[l];
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
                self.note_middle(z, zones[z], &end_degc[z], leg);
            }
            zones[z].temperature_degc = end_degc[z];
        }
        Advanced {
            residual_k,
            extra_w_per_m,
        }
    }

    /// Adds what heat along the rod does to temperatures at the end, and to what flows do to them: heat beyond the mean
    /// conductivity's is one of these.
    #[inline(always)]
    fn conduct<const Z: usize>(
        &self,
        along: &Along<'_, L>,
        stage: &Stage<L>,
        end_degc: &mut [[f64; L]; Z],
        sensitivity_k_m_per_w: &mut [[[f64; L]; Z]; Z],
    ) {
        for z in 0..Z {
            let moved_k = along.transfer.moved_k(z, &along.above_k);
            for l in 0..L {
                let by_itself = sensitivity_k_m_per_w[z][z][l];
                end_degc[z][l] += moved_k[l] + by_itself * along.beyond_w_per_m[z][l];
            }
            for k in 0..Z {
                for l in 0..L {
                    let warmed_s = along.transfer.warmed_s[z][k][l];
                    let added = warmed_s * self.heat.per_capacity_k_m_per_j[l];
                    sensitivity_k_m_per_w[z][k][l] += added;
                    let power_w_per_m = stage.acting.power_w_per_m[l] + along.beyond_w_per_m[k][l];
                    end_degc[z][l] += added * power_w_per_m;
                }
            }
        }
    }

    /// Rate at which a zone follows, times the length of the part, at most 1.
    #[inline(always)]
    fn rate(&self, z: usize, leg: &Leg<'_, L>, l: usize) -> f64 {
        let per_s = self.heat.per_tau_s[l] + self.effects.end_conduction.beyond_per_s[z][z][l];
        unit(leg.dt_s * per_s) * leg.stage.share[l]
    }

    /// Share of a change over the part that is done in the middle of the sample.
    #[inline(always)]
    fn done_by_middle(&self, z: usize, leg: &Leg<'_, L>, l: usize) -> f64 {
        progress(leg.stage.middle[l], self.rate(z, leg, l))
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
    fn pass_middle(&self, z: usize, zone: &mut Zone<L>, driving_degc: &[f64; L], leg: &Leg<'_, L>) {
        let mut passed_degc = [0.0; L];
        for l in 0..L {
            let done = self.done_by_middle(z, leg, l);
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

    /// A zone at the start of a part.
    #[inline(always)]
    fn start_of(&self, z: usize, zone: &Zone<L>, mean: [f64; L], leg: &Leg<'_, L>) -> Before<L> {
        let mut before = Before {
            temperature_degc: zone.temperature_degc,
            transformed: zone.transformed,
            mean,
            slope_per_k: zone.slope_per_k,
            driving_degc: zone.driving_degc,
            ..Before::ZERO
        };
        for l in 0..L {
            let rate = self.rate(z, leg, l);
            before.rate[l] = rate;
            before.counted[l] = counted(rate);
        }
        before
    }

    /// Notes the temperature in the middle of the sample, before a zone moves on.
    #[inline(always)]
    fn note_middle(&self, z: usize, zone: &mut Zone<L>, end_degc: &[f64; L], leg: &Leg<'_, L>) {
        for l in 0..L {
            let change_k = end_degc[l] - zone.temperature_degc[l];
            let done = self.done_by_middle(z, leg, l);
            let passed_degc = zone.temperature_degc[l] + change_k * done;
            let before_degc = zone.middle_degc[l];
            let here = leg.stage.has_middle[l];
            zone.middle_degc[l] = if here { passed_degc } else { before_degc };
        }
    }
}

/// That of two which is larger in magnitude.
#[inline(always)]
fn larger(one: f64, other: f64) -> f64 {
    if other.abs() > one.abs() { other } else { one }
}
