//! One sample where heat and transformation may depend on each other, in one part or two.

use wiener::thermal::Sample;
use wiener::{NARROW, widest_vectors};

use crate::conduction::{Ends, NODES, PerZone, Transfer, ZONES, beyond_mean_k_per_s};
use crate::effect::{Acting, Before, Instant, Moment, Trial, counted};
use crate::heat::Reference;
use crate::hypothesis::OwnMemory;
use crate::part::{Part, Stage, Turn, progress, unit};
use crate::plant::Plants;
use crate::solve::{Ending, Evaluated, Problem};
use crate::state::{PlantsState, Zone};

/// Data common to all zones in a part of a sample.
#[derive(Debug)]
struct Leg<'a, const L: usize> {
    stage: &'a Stage<L>,
    /// Length of the whole sample, s.
    dt_s: f64,
    /// Temperature of the surroundings in the baseline, °C.
    ambient_degc: f64,
    /// Coefficients of the whole sample.
    sample: &'a Sample<L>,
    /// Terms of own hypotheses.
    own: Option<&'a OwnMemory<L>>,
    /// Heat along the rod.
    along: Option<&'a Along<'a, L>>,
}

/// Conduction of heat along the rod in a part of a sample.
#[derive(Debug)]
#[repr(align(64))]
struct Along<'a, const L: usize> {
    transfer: &'a Transfer<L>,
    /// Nodes above the surroundings at the start, K.
    above_k: [[f64; L]; NODES],
    /// Heat into each zone beyond that at the mean conductivity, W/m.
    beyond_w_per_m: PerZone<L>,
}

impl<const L: usize> Plants<L> {
    /// Moves the zones to the end of the sample, in two parts if it has a turn.
    #[inline(never)]
    pub(crate) fn advance(
        &self,
        state: &mut PlantsState<L>,
        moment: &Moment,
        power_w_per_m: &[f64; L],
        turn: Option<&Turn<L>>,
        ambient_degc: f64,
    ) {
        widest_vectors(
            #[inline(always)]
            || {
                let mut acting = Acting {
                    per_s: [if moment.dt_s > 0.0 {
                        1.0 / moment.dt_s
                    } else {
                        0.0
                    }; L],
                    ambient_degc: [ambient_degc; L],
                    power_w_per_m: *power_w_per_m,
                };
                if self.path.changes_ambient {
                    self.effects.ambient(moment, &mut acting.ambient_degc);
                }
                let mut stage = Stage::whole(acting);
                state.residual_k = [0.0; L];
                let parts: &[Part] = match turn {
                    None => &[Part::Whole],
                    Some(_) => &[Part::Earlier, Part::Later],
                };
                for &part in parts {
                    if let Some(turn) = turn {
                        stage.divide(part, turn, moment.dt_s);
                    }
                    self.advance_part(state, &stage, moment.dt_s, ambient_degc);
                    if part == Part::Earlier {
                        self.show(state, moment, Instant::Turn, &mut [0.0; L]);
                    }
                }
            },
        );
        if self.path.wants_middle {
            self.show(state, moment, Instant::Middle, &mut [0.0; L]);
        }
    }

    /// Moves the zones to the end of a part.
    #[inline(always)]
    fn advance_part(
        &self,
        state: &mut PlantsState<L>,
        stage: &Stage<L>,
        dt_s: f64,
        ambient_degc: f64,
    ) {
        let leg = Leg {
            stage,
            dt_s,
            ambient_degc,
            sample: &state.sample,
            own: state.own.as_deref(),
            along: None,
        };
        let mut residual_k = [0.0; L];
        match &mut state.ends {
            None => {
                residual_k = self.advance_zones([&mut state.middle], &leg, &mut [[0.0; L]]);
            }
            // `Extended` makes no full chunk of rods with ends, and none is compiled.
            Some(ends) => {
                if const { L <= NARROW } {
                    residual_k = self.advance_ends(&mut state.middle, ends, &leg);
                }
            }
        }
        for l in 0..L {
            state.residual_k[l] = larger(state.residual_k[l], residual_k[l]);
        }
    }

    /// Moves a rod with ends to the end of a part; returns what the search left, K.
    #[inline(never)]
    fn advance_ends(&self, middle: &mut Zone<L>, ends: &mut Ends<L>, leg: &Leg<'_, L>) -> [f64; L] {
        widest_vectors(
            #[inline(always)]
            || self.conducted(middle, ends, leg),
        )
    }

    #[inline(always)]
    fn conducted(&self, middle: &mut Zone<L>, ends: &mut Ends<L>, leg: &Leg<'_, L>) -> [f64; L] {
        let stage = leg.stage;
        let conduction = &self.effects.end_conduction;
        let length_s = stage.share.map(|share| share * leg.dt_s);
        let beyond_per_s = &conduction.beyond_per_s;
        let transfer = ends
            .transfers
            .over(&length_s, &self.heat.per_tau_s, beyond_per_s);
        let mut along = Along {
            transfer,
            above_k: [ends.clamp_k; NODES],
            beyond_w_per_m: [[0.0; L]; ZONES],
        };
        let mut transformed = [middle.transformed; ZONES];
        let zones = std::iter::once(&*middle).chain(&ends.cells);
        for (z, zone) in zones.enumerate() {
            transformed[z] = zone.transformed;
            for l in 0..L {
                along.above_k[z][l] = zone.temperature_degc[l] - stage.acting.ambient_degc[l];
            }
        }
        let start_k_per_s =
            beyond_mean_k_per_s(beyond_per_s, &conduction.ways, &along.above_k, &transformed);
        let beyond_k_per_s = ends.beyond.over(&start_k_per_s, &length_s);
        for z in 0..ZONES {
            for l in 0..L {
                along.beyond_w_per_m[z][l] =
                    beyond_k_per_s[z][l] / self.heat.per_capacity_k_m_per_j[l];
            }
        }
        let leg = Leg {
            along: Some(&along),
            ..*leg
        };
        let [first, second, third, fourth, last] = &mut ends.cells;
        let zones = [middle, first, second, third, fourth, last];
        // Heat beyond the baseline's, W/m, and what all heat does, K/s.
        let mut rate_k_per_s = [[0.0; L]; ZONES];
        let residual_k = self.advance_zones(zones, &leg, &mut rate_k_per_s);
        for rate_k_per_s in &mut rate_k_per_s {
            for l in 0..L {
                let power_w_per_m = rate_k_per_s[l] + stage.acting.power_w_per_m[l];
                rate_k_per_s[l] = power_w_per_m * self.heat.per_capacity_k_m_per_j[l];
            }
        }
        ends.clamp_k = transfer.clamp_k(&along.above_k, &rate_k_per_s);
        residual_k
    }

    /// Moves all zones to the end of a part; returns what the search left, K. `extra_w_per_m` receives the heat beyond
    /// the baseline's into each zone, W/m.
    #[inline(always)]
    fn advance_zones<const Z: usize>(
        &self,
        zones: [&mut Zone<L>; Z],
        leg: &Leg<'_, L>,
        extra_w_per_m: &mut [[f64; L]; Z],
    ) -> [f64; L] {
        let mut problem = Problem {
            acting: &leg.stage.acting,
            before: [Before::ZERO; Z],
            reference_degc: [[0.0; L]; Z],
            sensitivity_k_m_per_w: [[[0.0; L]; Z]; Z],
            own_shift_k: [[0.0; L]; Z],
        };
        for z in 0..Z {
            let Reference {
                end_degc,
                sensitivity_k_m_per_w: by_itself,
            } = self.heat.reference(
                &zones[z].temperature_degc,
                leg.sample,
                leg.stage,
                leg.dt_s,
                leg.ambient_degc,
            );
            problem.reference_degc[z] = end_degc;
            problem.sensitivity_k_m_per_w[z][z] = by_itself;
        }
        if let Some(along) = leg.along {
            self.conduct(along, leg.stage, &mut problem);
            extra_w_per_m.copy_from_slice(&along.beyond_w_per_m[..Z]);
        }
        if let Some(own) = leg.own {
            for z in 0..Z {
                problem.own_shift_k[z] = own.shift_k[z];
                for l in 0..L {
                    extra_w_per_m[z][l] += own.flow_w_per_m[z][l];
                }
                for k in 0..Z {
                    for l in 0..L {
                        problem.reference_degc[z][l] +=
                            problem.sensitivity_k_m_per_w[z][k][l] * own.flow_w_per_m[k][l];
                    }
                }
            }
        }
        let mut ending = Ending {
            driving_degc: problem.reference_degc,
            transformed: [[0.0; L]; Z],
            slope_per_k: [[0.0; L]; Z],
        };
        if self.path.implicit | self.path.stands_in_zone {
            let mut share = [[0.0; L]; Z];
            for z in 0..Z {
                share[z] = zones[z].transformed;
            }
            let mean = self.mean(&share);
            for z in 0..Z {
                problem.before[z] = self.start_of(z, zones[z], mean, leg);
            }
        }
        if self.path.implicit {
            self.solve(&problem, &zones, &mut ending);
            if leg.stage.part != Part::Whole {
                stay_where_no_time_passes(leg.stage, &zones, &mut ending);
            }
        }
        for z in 0..Z {
            if self.path.wants_middle {
                self.pass_middle(z, zones[z], &ending.driving_degc[z], leg);
            }
            self.commit(z, zones[z], &mut ending);
            zones[z].slope_per_k = ending.slope_per_k[z];
        }
        let mut end_degc = problem.reference_degc;
        let mut residual_k = [0.0; L];
        if self.path.implicit {
            let mut at = Evaluated::ZERO;
            self.evaluate(&problem, &zones, &ending, &mut at);
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
            let mean = self.mean(&ending.transformed);
            for z in 0..Z {
                let trial = Trial {
                    driving_degc: ending.driving_degc[z],
                    temperature_degc: end_degc[z],
                    transformed: ending.transformed[z],
                    slope_per_k: ending.slope_per_k[z],
                    mean,
                    ..Trial::ZERO
                };
                self.effects
                    .commit(&mut zones[z].effects, &problem.before[z], &trial);
            }
        }
        for z in 0..Z {
            if self.path.wants_middle {
                self.note_middle(z, zones[z], &end_degc[z], leg);
            }
            zones[z].temperature_degc = end_degc[z];
        }
        residual_k
    }

    /// Adds what heat along the rod does to temperatures at the end, and to what flows do to them: heat beyond the mean
    /// conductivity's is one of these.
    #[inline(always)]
    fn conduct<const Z: usize>(
        &self,
        along: &Along<'_, L>,
        stage: &Stage<L>,
        problem: &mut Problem<'_, L, Z>,
    ) {
        for z in 0..Z {
            let moved_k = along.transfer.moved_k(z, &along.above_k);
            let end_degc = &mut problem.reference_degc[z];
            let sensitivity_k_m_per_w = &mut problem.sensitivity_k_m_per_w[z];
            for l in 0..L {
                let by_itself = sensitivity_k_m_per_w[z][l];
                end_degc[l] += moved_k[l] + by_itself * along.beyond_w_per_m[z][l];
            }
            for k in 0..Z {
                for l in 0..L {
                    let warmed_s = along.transfer.warmed_s[z][k][l];
                    let added = warmed_s * self.heat.per_capacity_k_m_per_j[l];
                    sensitivity_k_m_per_w[k][l] += added;
                    let power_w_per_m = stage.acting.power_w_per_m[l] + along.beyond_w_per_m[k][l];
                    end_degc[l] += added * power_w_per_m;
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

    /// Takes the hysteresis of zone `z` to its driving temperature.
    #[inline(always)]
    fn commit<const Z: usize>(&self, z: usize, zone: &mut Zone<L>, ending: &mut Ending<L, Z>) {
        let driving_degc = &ending.driving_degc[z];
        zone.fraction = if Z == 1 {
            self.go(zone, driving_degc)
        } else {
            self.go_apart(zone, driving_degc)
        };
        for l in 0..L {
            ending.transformed[z][l] = self.scale.transformed(l, zone.fraction[l]);
        }
        zone.driving_degc = *driving_degc;
        zone.transformed = ending.transformed[z];
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
        let fraction = self.fraction_apart(zone, &passed_degc);
        for l in 0..L {
            let before = zone.middle_fraction[l];
            let here = leg.stage.has_middle[l];
            zone.middle_fraction[l] = if here { fraction[l] } else { before };
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

/// Keeps lanes whose part has no length as they were, to the last bit: other lanes have a part there, and the search would
/// go on for all.
#[inline(always)]
fn stay_where_no_time_passes<const L: usize, const Z: usize>(
    stage: &Stage<L>,
    zones: &[&mut Zone<L>; Z],
    ending: &mut Ending<L, Z>,
) {
    for z in 0..Z {
        for l in 0..L {
            let stays = stage.share[l] <= 0.0;
            let (driving_degc, slope_per_k) = (zones[z].driving_degc[l], zones[z].slope_per_k[l]);
            let [to_degc, to_per_k] = [ending.driving_degc[z][l], ending.slope_per_k[z][l]];
            ending.driving_degc[z][l] = if stays { driving_degc } else { to_degc };
            ending.slope_per_k[z][l] = if stays { slope_per_k } else { to_per_k };
        }
    }
}

/// That of two which is larger in magnitude.
#[inline(always)]
fn larger(one: f64, other: f64) -> f64 {
    if other.abs() > one.abs() { other } else { one }
}
