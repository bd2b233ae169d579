//! Implausible results, whatever the fit: units that are mixed up, a rod file that is wrong, a loop that no rod has.
//!
//! A row of the table is a rule with its limits and one sentence. Limits are those of physics and of what is on sale, far
//! from what is merely odd: a row that fires says that the numbers are not to be used.

use identify::{EarlyOutput, Fit, NITI_OHM_M, ParameterState, Rod};
use recording::{Quantity, Recording};
use serde_json::{Value, json};

use crate::report::number::{behind, spoken};

/// A rule that a model breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Implausible {
    /// Name of the rule, for programs.
    pub rule: &'static str,
    /// The fault and where to look for its cause, in a sentence or two.
    pub said: String,
}

/// Inputs of the rules: from a rod file, a fit and its recordings.
#[derive(Debug, Clone)]
pub struct Facts<'a> {
    rod: &'a Rod,
    /// True if the drive is the input of a static loop.
    is_static: bool,
    /// True if temperatures are in kelvins.
    knows_temperature: bool,
    drive_unit: String,
    output_unit: String,
    tau_s: Option<Known>,
    center_degc: Option<Known>,
    gain: Option<f64>,
    /// Coldest and hottest that the rod was; of a static loop, the ends of its input.
    reached: [f64; 2],
    largest_drive: f64,
    /// Finest sampling and longest recording, s.
    step_s: f64,
    longest_s: f64,
    /// Lead of the output over its drive, and root mean square of the fit that ignores it; `None` without a lead.
    early: Option<(EarlyOutput, f64)>,
}

/// A parameter and how surely it is known.
#[derive(Debug, Clone, Copy)]
struct Known {
    value: f64,
    /// Lower end of the interval, where there is one; else the value.
    lower: f64,
    is_fixed: bool,
}

impl<'a> Facts<'a> {
    /// The facts of a fit to some recordings.
    #[must_use]
    pub fn of(rod: &'a Rod, fit: &Fit, training: &[Recording], knows_temperature: bool) -> Self {
        let known = |name: &str| {
            let parameter = fit.parameter(name)?;
            let value = *parameter.values.first()?;
            let interval = parameter.intervals.first().copied().flatten();
            Some(Known {
                value,
                lower: interval.map_or(value, |interval| interval.lower),
                is_fixed: matches!(parameter.info.state, ParameterState::Fixed(_)),
            })
        };
        let is_static = fit.drive_quantity == Quantity::Temperature;
        let of_all = |recordings: &dyn Fn(&Recording) -> f64, pick: fn(f64, f64) -> f64| {
            training.iter().map(recordings).fold(f64::NAN, pick)
        };
        let drives = |pick: fn(f64, f64) -> f64| {
            let all = training.iter().flat_map(Recording::drive).copied();
            all.fold(f64::NAN, pick)
        };
        let peaks = fit.recordings.iter().map(|one| one.peak_temperature_degc);
        let recorded = training.iter().filter_map(Recording::ambient_degc);
        let surroundings = recorded.flatten().copied().fold(f64::NAN, f64::min);
        Self {
            rod,
            is_static,
            knows_temperature,
            drive_unit: fit.drive_unit.clone(),
            output_unit: fit.output_unit.clone(),
            tau_s: known("tau_s"),
            center_degc: known("loop_center_degc"),
            gain: known("gain").map(|known| known.value),
            reached: if is_static {
                [drives(f64::min), drives(f64::max)]
            } else {
                let stated = rod.ambient_degc.unwrap_or(f64::NAN);
                [surroundings.min(stated), peaks.fold(f64::NAN, f64::max)]
            },
            largest_drive: of_all(&Recording::largest_drive, f64::max),
            step_s: of_all(
                &|one| one.sampling().usual_dt_s().unwrap_or(f64::NAN),
                f64::min,
            ),
            longest_s: of_all(&duration_s, f64::max),
            early: None,
        }
    }

    /// These facts, with an output of the recordings that comes before its drive.
    #[must_use]
    pub fn with_early_output(self, early: Option<EarlyOutput>, fit: &Fit) -> Self {
        Self {
            early: early.map(|early| (early, fit.train_rmse)),
            ..self
        }
    }

    /// The rules that are broken. Where the rod file itself cannot be, what follows from it is not looked at.
    #[must_use]
    pub fn implausible(&self) -> Vec<Implausible> {
        let broken = |rows: &[Row]| -> Vec<Implausible> {
            let fired = rows.iter().filter_map(|(rule, fires)| {
                let said = fires(self)?;
                Some(Implausible { rule, said })
            });
            fired.collect()
        };
        let of_rod = broken(OF_ROD);
        if of_rod.is_empty() {
            broken(OF_MODEL)
        } else {
            of_rod
        }
    }
}

/// Time from the first to the last sample, s; NaN of fewer than two.
pub(crate) fn duration_s(recording: &Recording) -> f64 {
    match recording.time_s() {
        [first_s, .., last_s] => last_s - first_s,
        _ => f64::NAN,
    }
}

/// For people, a line each, behind the word.
#[must_use]
pub fn lines(implausible: &[Implausible]) -> String {
    implausible
        .iter()
        .map(|one| format!("IMPLAUSIBLE: {}\n", one.said))
        .collect()
}

/// For programs.
#[must_use]
pub fn to_json(implausible: &[Implausible]) -> Vec<Value> {
    let entries = implausible.iter();
    entries
        .map(|one| json!({"rule": one.rule, "said": one.said}))
        .collect()
}

/// A rule, and what it says where it is broken.
type Row = (&'static str, fn(&Facts<'_>) -> Option<String>);

/// Rules on the rod file by itself.
const OF_ROD: &[Row] = &[
    ("density", density),
    ("specific-heat", specific_heat),
    ("resistivity", resistivity),
];

/// Rules on the model.
const OF_MODEL: &[Row] = &[
    ("output-before-drive", output_before_drive),
    ("rod-temperature", rod_temperature),
    ("rod-stays-cold", rod_stays_cold),
    ("drive-melts-the-rod", drive_melts_the_rod),
    ("loop-above-niti", loop_above_niti),
    ("loop-not-reached", loop_not_reached),
    ("tau-sampling", tau_sampling),
    ("tau-diameter", tau_diameter),
    ("stroke-length", stroke_length),
];

/// Densities of metals, kg/m³: from lithium to osmium; NiTi has 6450.
const DENSITIES: [f64; 2] = [500.0, 23_000.0];

fn density(facts: &Facts<'_>) -> Option<String> {
    let density = outside(facts.rod.density_kg_per_m3?, DENSITIES)?;
    Some(format!(
        "density_kg_per_m3 = {}, and no metal has that; NiTi has 6450.",
        spoken(density)
    ))
}

/// Specific heats of metals, J/(kg K): from gold and lead to beryllium; NiTi has 450 to 840.
const SPECIFIC_HEATS: [f64; 2] = [100.0, 2000.0];

fn specific_heat(facts: &Facts<'_>) -> Option<String> {
    let heat = outside(facts.rod.specific_heat_j_per_kg_k?, SPECIFIC_HEATS)?;
    Some(format!(
        "specific_heat_j_per_kg_k = {}, and no metal has that; NiTi has 450 to 840.",
        spoken(heat)
    ))
}

/// How far a resistivity may lie from NiTi's: strands that are twisted or doubled, and a radius for a diameter, make up to 4.
const RESISTIVITY_FACTOR: f64 = 5.0;

fn resistivity(facts: &Facts<'_>) -> Option<String> {
    let ohm_m = facts.rod.resistance_ohm_per_m? * facts.rod.section_m2()?;
    let near = [
        NITI_OHM_M / RESISTIVITY_FACTOR,
        NITI_OHM_M * RESISTIVITY_FACTOR,
    ];
    let ohm_m = outside(ohm_m, near)?;
    Some(format!(
        "resistance_ohm_per_m = {} in a wire of {} mm is a resistivity of {} µΩ m, and NiTi has 0.76 to 1.0. Look at both, per \
         meter and as a diameter.",
        spoken(facts.rod.resistance_ohm_per_m?),
        spoken(1e3 * facts.rod.diameter_m?),
        spoken(1e6 * ohm_m)
    ))
}

fn output_before_drive(facts: &Facts<'_>) -> Option<String> {
    let (early, rmse) = facts.early?;
    let unit = behind(&facts.output_unit);
    Some(format!(
        "the output comes {} s before the drive that causes it: with the drive that much earlier the error is {}{unit} instead of \
         {}{unit}, and time constant and loop are others. Put both columns on one clock, and look for a filter that looks ahead.",
        spoken(early.by_s),
        spoken(early.rmse),
        spoken(rmse)
    ))
}

/// Temperature above which what is said of a rod cannot be, °C: its alloy would long be annealed.
const HOTTEST_DEGC: f64 = 500.0;

fn rod_temperature(facts: &Facts<'_>) -> Option<String> {
    let [_, peak_degc] = facts.in_kelvins()?;
    (peak_degc > HOTTEST_DEGC).then(|| {
        let peak_degc = if peak_degc < 1e5 {
            format!("{peak_degc:.0}")
        } else {
            format!("{peak_degc:.1e}")
        };
        format!("the rod would reach {peak_degc} °C. Look at the units in [rod] and [drive].")
    })
}

/// Rise below which a rod does not transform, K.
const LEAST_RISE_K: f64 = 3.0;

fn rod_stays_cold(facts: &Facts<'_>) -> Option<String> {
    let [coldest_degc, peak_degc] = facts.in_kelvins()?;
    (peak_degc < coldest_degc + LEAST_RISE_K).then(|| {
        format!(
            "the rod would not get warmer than {peak_degc:.1} °C. Look at the units of the drive."
        )
    })
}

/// Melting NiTi from room temperature takes 1300 K.
const TO_MELT_K: f64 = 1300.0;

/// Time over which no wire loses heat that counts, s: the thinnest on sale, 25 µm, cools with a time constant of 40 ms.
const NO_LOSS_S: f64 = 0.01;

/// Where the scale of temperatures is known the rod's temperature says it already.
fn drive_melts_the_rod(facts: &Facts<'_>) -> Option<String> {
    if facts.is_static || facts.knows_temperature {
        return None;
    }
    let rod = facts.rod;
    let section_m2 = rod.section_m2()?;
    if rod.drive_kind != Quantity::Current {
        rod.length_m?;
    }
    let ohm_per_m = rod.resistance_ohm_per_m.unwrap_or(NITI_OHM_M / section_m2);
    let drive = rod.drive().ok()?;
    let [power_w_per_m] = drive.power_w_per_m([facts.largest_drive], [ohm_per_m]);
    let heating_k_per_s = power_w_per_m / (section_m2 * heat_j_per_m3_k(rod));
    let molten_s = TO_MELT_K / heating_k_per_s;
    (molten_s < NO_LOSS_S.min(facts.step_s)).then(|| {
        format!(
            "a drive of {} {} would melt a wire of {} mm in {} ms. Look at the units of the drive and of diameter_mm.",
            spoken(facts.largest_drive),
            facts.drive_unit,
            spoken(1e3 * rod.diameter_m.unwrap_or_default()),
            spoken(1e3 * molten_s)
        )
    })
}

/// Center of a loop that no NiTi wire on sale exceeds under its load, °C.
///
/// Wires free of stress finish their way to austenite at 120 °C at most [Frenzel2010], where their loop of 30 K has its
/// center at 105 °C; 200 MPa, which is what wires are sold for, raise it by 25 K at 8 MPa/K.
const HIGHEST_CENTER_DEGC: f64 = 130.0;

/// Centers of the loops of wires that are sold for actuators, °C: with As/Af/Ms/Mf of 68/78/52/42 that of a "70 °C" wire,
/// and that of a "90 °C" wire (88/98/72/62) with 170 MPa at 8 MPa/K.
const USUAL_CENTERS_DEGC: [f64; 2] = [60.0, 100.0];

fn loop_above_niti(facts: &Facts<'_>) -> Option<String> {
    let [ambient_degc, peak_degc] = facts.in_kelvins()?;
    let center = facts.center_degc?;
    // Said already.
    if peak_degc > HOTTEST_DEGC {
        return None;
    }
    // High-temperature alloys have their bounds in [model]: then the user knows.
    if facts.rod.says_of("loop_center_degc") || center.is_fixed {
        return None;
    }
    // The data must say so, not only allow it.
    (center.lower > HIGHEST_CENTER_DEGC).then(|| {
        format!(
            "the loop would lie at {:.0} °C, above that of any NiTi wire on sale ({HIGHEST_CENTER_DEGC} °C under load). {} \
             A high-temperature alloy needs bounds of loop_center_degc in [model].",
            center.value,
            facts.cause_of_heat(center.value - ambient_degc, ambient_degc)
        )
    })
}

fn loop_not_reached(facts: &Facts<'_>) -> Option<String> {
    let [coldest, hottest] = facts.reached;
    let center = facts.center_degc?.value;
    let unit = if facts.is_static {
        facts.drive_unit.as_str()
    } else {
        "°C"
    };
    let (place, end, verb) = if center > hottest {
        ("above", hottest, "rises to")
    } else if center < coldest {
        ("below", coldest, "falls to")
    } else {
        return None;
    };
    let what = if facts.is_static {
        "the input"
    } else {
        "the rod"
    };
    Some(format!(
        "the center of the loop would lie at {center:.1} {unit}, {place} the {end:.1} {unit} that {what} {verb}: the recordings \
         hold less than half of it, and the rest is extrapolated. Look at the units in [rod] and [drive], or drive it further."
    ))
}

/// How near to the sampling, or to the length of the recordings, a time constant counts as one with it: searches end there.
const AT_THE_END: f64 = 0.02;

fn tau_sampling(facts: &Facts<'_>) -> Option<String> {
    let tau = facts.tau_s.filter(|tau| !tau.is_fixed)?;
    let tau_s = tau.value;
    // That of the diameter says more.
    if tau_diameter(facts).is_some() {
        return None;
    }
    if tau_s < (1.0 + AT_THE_END) * facts.step_s {
        return Some(format!(
            "tau_s is {} s, no more than a step of the sampling: the rod would follow the drive at once. Look at the unit of the \
             time column.",
            spoken(tau_s)
        ));
    }
    (tau_s > (1.0 - AT_THE_END) * facts.longest_s).then(|| {
        format!(
            "tau_s is {} s, as long as the recordings: the rod would never come to rest in them. Look at the unit of the time \
             column, or record for longer.",
            spoken(tau_s)
        )
    })
}

/// Density times specific heat of NiTi, J/(m³ K): stands in where the rod file has not both.
const NITI_J_PER_M3_K: f64 = 6450.0 * 500.0;

/// Convective coefficient below which no wire in air cools, W/(m² K): radiation alone has 1 to 6, and air at rest
/// conducts as much from the thickest wire on sale.
const LEAST_COEFFICIENT: f64 = 5.0;

/// Nusselt number of a wire in a stream of water, and the conductivity of water, W/(m K): nothing else cools as well.
const NUSSELT_IN_WATER: f64 = 10.0;
const WATER_W_PER_M_K: f64 = 0.6;

fn tau_diameter(facts: &Facts<'_>) -> Option<String> {
    let tau_s = facts.tau_s.filter(|tau| !tau.is_fixed)?.value;
    let diameter_m = facts.rod.diameter_m?;
    // τ = ρ c d/(4 h).
    let heat_per_area = heat_j_per_m3_k(facts.rod) * diameter_m / 4.0;
    let most = NUSSELT_IN_WATER * WATER_W_PER_M_K / diameter_m;
    let coefficient = heat_per_area / tau_s;
    outside(coefficient, [LEAST_COEFFICIENT, most])?;
    Some(format!(
        "tau_s is {} s, and a wire of {} mm has {} s in air at rest at most, {} s in a stream of water at least. Look at the unit \
         of the time column and at diameter_mm.",
        spoken(tau_s),
        spoken(1e3 * diameter_m),
        spoken(heat_per_area / LEAST_COEFFICIENT),
        spoken(heat_per_area / most)
    ))
}

/// Strain that no NiTi recovers: single crystals have 10 %, wires 8 %.
const MOST_STRAIN: f64 = 0.1;

fn stroke_length(facts: &Facts<'_>) -> Option<String> {
    let per_m = match facts.output_unit.as_str() {
        "m" => 1.0,
        "cm" => 1e2,
        "mm" => 1e3,
        "um" | "µm" => 1e6,
        _ => return None,
    };
    let lever = facts.rod.load.and_then(|load| load.lever);
    let length = facts.rod.length_m? * lever.unwrap_or(1.0) * per_m;
    let strain = facts.gain?.abs() / length;
    (strain > MOST_STRAIN).then(|| {
        format!(
            "the stroke would be {} {}, {} % of the length, and no NiTi wire shortens by more than {} %. Look at the unit of the output \
             and at length_mm; if a lever, a pulley or a coil makes more of it, say lever in [load].",
            spoken(facts.gain.unwrap_or_default().abs()),
            facts.output_unit,
            spoken(100.0 * strain),
            100.0 * MOST_STRAIN
        )
    })
}

impl Facts<'_> {
    /// Coldest and hottest of a driven rod, °C, where temperatures are known.
    fn in_kelvins(&self) -> Option<[f64; 2]> {
        (self.knows_temperature && !self.is_static).then_some(self.reached)
    }

    /// Hint at the cause if a rod seems too hot, by its rise of temperature.
    fn cause_of_heat(&self, rise_k: f64, ambient_degc: f64) -> String {
        let rod = self.rod;
        let own_ohm = rod.resistance_ohm_per_m.zip(rod.length_m);
        let is_of_voltage = matches!(rod.drive_kind, Quantity::Voltage | Quantity::Duty);
        let Some(own_ohm) = own_ohm
            .map(|(per_m, m)| per_m * m)
            .filter(|_| is_of_voltage)
        else {
            return "Look at resistance, diameter and specific heat in [rod] and at the unit of the drive.".to_owned();
        };
        let given_ohm = rod.supply.lead_resistance_ohm.unwrap_or(0.0);
        // The rise goes with 1/(R + R_lead)².
        let leads_ohm = |degc: f64| {
            let less = rise_k / (degc - ambient_degc);
            (own_ohm + given_ohm) * less.sqrt() - own_ohm
        };
        let [low_degc, high_degc] = USUAL_CENTERS_DEGC;
        if ambient_degc.is_nan() || ambient_degc >= low_degc {
            return "If leads or contacts take part of the voltage, give lead_resistance_ohm in [drive].".to_owned();
        }
        format!(
            "If leads or contacts take part of the voltage, give lead_resistance_ohm in [drive]: {} to {} Ω would put it at \
             {high_degc} to {low_degc} °C.",
            spoken(leads_ohm(high_degc)),
            spoken(leads_ohm(low_degc))
        )
    }
}

/// Density times specific heat, J/(m³ K); NiTi's where the rod file has not both.
fn heat_j_per_m3_k(rod: &Rod) -> f64 {
    let given = rod.density_kg_per_m3.zip(rod.specific_heat_j_per_kg_k);
    given.map_or(NITI_J_PER_M3_K, |(density, heat)| density * heat)
}

/// A value that lies outside a range; NaN lies in none.
fn outside(value: f64, [lower, upper]: [f64; 2]) -> Option<f64> {
    (value < lower || value > upper).then_some(value)
}

#[cfg(test)]
mod tests {
    use rig_files::rod_file;

    use super::*;

    const ROD: &str = "[rod]\ndiameter_mm = 0.25\nlength_mm = 200.0\ndensity_kg_per_m3 = 6450.0\n\
        specific_heat_j_per_kg_k = 500.0\nresistance_ohm_per_m = 16.0\n[surroundings]\nambient_degc = 24.0\n";

    fn rod(text: &str) -> Rod {
        rod_file::parse("rod.toml", text).unwrap()
    }

    fn known(value: f64) -> Option<Known> {
        Some(Known {
            value,
            lower: value,
            is_fixed: false,
        })
    }

    /// A model of a wire that is as it should be.
    fn sound(rod: &Rod) -> Facts<'_> {
        Facts {
            rod,
            is_static: false,
            knows_temperature: true,
            drive_unit: "A".to_owned(),
            output_unit: "mm".to_owned(),
            tau_s: known(2.9),
            center_degc: known(69.6),
            gain: Some(-6.0),
            reached: [24.0, 115.0],
            largest_drive: 1.1,
            step_s: 0.05,
            longest_s: 150.0,
            early: None,
        }
    }

    fn said(facts: &Facts<'_>) -> Vec<(&'static str, String)> {
        let broken = facts.implausible().into_iter();
        broken.map(|one| (one.rule, one.said)).collect()
    }

    /// Broken rules of a sound model whose rod file differs in a line.
    fn of_rod(line: &str, instead: &str) -> Vec<(&'static str, String)> {
        assert!(ROD.contains(line));
        said(&sound(&rod(&ROD.replace(line, instead))))
    }

    /// That one rule is broken, and what it says.
    fn one(facts: &Facts<'_>) -> (&'static str, String) {
        let all = said(facts);
        assert_eq!(all.len(), 1, "{all:?}");
        all[0].clone()
    }

    #[test]
    fn an_output_has_its_cause_before_it() {
        let rod = rod(ROD);
        let early = EarlyOutput {
            by_s: 0.6,
            rmse: 0.0042,
        };
        let facts = Facts {
            early: Some((early, 0.011)),
            ..sound(&rod)
        };
        let (rule, said) = one(&facts);
        assert_eq!(rule, "output-before-drive");
        let expected = "the output comes 0.60 s before the drive that causes it";
        assert!(said.starts_with(expected), "{said}");
        assert!(said.contains("0.0042 mm instead of 0.011 mm"), "{said}");
    }

    #[test]
    fn a_sound_model_breaks_no_rule_and_neither_does_one_that_nothing_is_known_of() {
        assert_eq!(said(&sound(&rod(ROD))), []);
        let bare = rod("");
        let unknown = Facts {
            knows_temperature: false,
            tau_s: None,
            center_degc: None,
            gain: None,
            reached: [f64::NAN; 2],
            largest_drive: f64::NAN,
            step_s: f64::NAN,
            longest_s: f64::NAN,
            ..sound(&bare)
        };
        assert_eq!(said(&unknown), []);
    }

    #[test]
    fn materials_are_metals() {
        assert_eq!(
            of_rod("density_kg_per_m3 = 6450.0", "density_kg_per_m3 = 1e300"),
            [(
                "density",
                "density_kg_per_m3 = 1.0e300, and no metal has that; NiTi has 6450.".to_owned()
            )]
        );
        // g/cm³, J/(g K).
        let light = of_rod("density_kg_per_m3 = 6450.0", "density_kg_per_m3 = 6.45");
        assert_eq!(light[0].0, "density");
        assert_eq!(
            of_rod(
                "specific_heat_j_per_kg_k = 500.0",
                "specific_heat_j_per_kg_k = 0.5"
            ),
            [(
                "specific-heat",
                "specific_heat_j_per_kg_k = 0.50, and no metal has that; NiTi has 450 to 840."
                    .to_owned()
            )]
        );
        for ordinary in ["320.0", "840.0"] {
            let line = format!("specific_heat_j_per_kg_k = {ordinary}");
            assert_eq!(of_rod("specific_heat_j_per_kg_k = 500.0", &line), []);
        }
    }

    #[test]
    fn a_resistance_per_meter_is_no_whole_and_none_per_millimeter() {
        assert_eq!(
            of_rod("resistance_ohm_per_m = 16.0", "resistance_ohm_per_m = 0.016"),
            [(
                "resistivity",
                "resistance_ohm_per_m = 0.016 in a wire of 0.25 mm is a resistivity of 0.00079 µΩ m, and NiTi has 0.76 to 1.0. \
                 Look at both, per meter and as a diameter."
                    .to_owned()
            )]
        );
        // Two strands, and a radius taken for a diameter.
        for odd in ["8.0", "64.0", "4.0"] {
            let line = format!("resistance_ohm_per_m = {odd}");
            assert_eq!(of_rod("resistance_ohm_per_m = 16.0", &line), [], "{odd}");
        }
    }

    #[test]
    fn a_rod_is_neither_annealed_nor_cold() {
        let rod = rod(ROD);
        let hot = Facts {
            reached: [24.0, 6934.0],
            center_degc: known(172.0),
            ..sound(&rod)
        };
        // The loop is on the same scale: once is enough.
        assert_eq!(
            one(&hot),
            (
                "rod-temperature",
                "the rod would reach 6934 °C. Look at the units in [rod] and [drive].".to_owned()
            )
        );
        let cold = Facts {
            reached: [24.0, 25.1],
            center_degc: known(24.5),
            ..sound(&rod)
        };
        assert_eq!(
            one(&cold),
            (
                "rod-stays-cold",
                "the rod would not get warmer than 25.1 °C. Look at the units of the drive."
                    .to_owned()
            )
        );
        let arbitrary = Facts {
            knows_temperature: false,
            ..hot
        };
        assert_eq!(said(&arbitrary), []);
    }

    #[test]
    fn no_wire_lives_through_milliamperes_that_are_taken_for_amperes() {
        let rod = rod("[rod]\ndiameter_mm = 1.2\n");
        let of = |largest_drive: f64, step_s: f64| Facts {
            knows_temperature: false,
            largest_drive,
            step_s,
            tau_s: known(12.4),
            ..sound(&rod)
        };
        assert_eq!(
            one(&of(4370.0, 1.0)),
            (
                "drive-melts-the-rod",
                "a drive of 4370 A would melt a wire of 1.2 mm in 0.35 ms. Look at the units of the drive and of diameter_mm."
                    .to_owned()
            )
        );
        // 20 A/mm², what such a wire is rated for, and a pulse of twenty times as much.
        assert_eq!(said(&of(23.0, 1.0)), []);
        assert_eq!(said(&of(460.0, 1.0)), []);
    }

    #[test]
    fn a_loop_above_all_niti_under_a_voltage_is_one_of_leads() {
        let text = ROD.to_owned() + "[drive]\nkind = \"voltage\"\n";
        let hot = |text: &str| {
            let rod = rod(text);
            let facts = Facts {
                center_degc: known(143.8),
                reached: [24.0, 294.0],
                ..sound(&rod)
            };
            said(&facts)
        };
        assert_eq!(
            hot(&text),
            [(
                "loop-above-niti",
                "the loop would lie at 144 °C, above that of any NiTi wire on sale (130 °C under load). If leads or contacts take \
                 part of the voltage, give lead_resistance_ohm in [drive]: 0.82 to 2.6 Ω would put it at 100 to 60 °C. A \
                 high-temperature alloy needs bounds of loop_center_degc in [model]."
                    .to_owned()
            )]
        );
        // 2 Ω of leads put it at 69.6 °C: (3.2 + 2)² / 3.2² is the ratio of the rises. With half of that given, the rest is asked.
        let given = hot(&(text.clone() + "lead_resistance_ohm = 1.0\n"));
        assert!(given[0].1.contains("2.1 to 4.5 Ω"), "{given:?}");
        let by_current = hot(ROD);
        assert!(
            by_current[0]
                .1
                .contains("Look at resistance, diameter and specific heat in [rod]"),
            "{by_current:?}"
        );
        // Whoever knows of a hot alloy says so.
        let known = text + "[model]\nloop_center_degc = { bounds = [100.0, 250.0] }\n";
        assert_eq!(hot(&known), []);
    }

    #[test]
    fn a_loop_is_above_all_niti_only_if_its_interval_is() {
        let rod = rod(ROD);
        let of = |lower: f64| Facts {
            center_degc: Some(Known {
                value: 140.0,
                lower,
                is_fixed: false,
            }),
            reached: [24.0, 200.0],
            ..sound(&rod)
        };
        assert_eq!(said(&of(120.0)), []);
        assert_eq!(one(&of(135.0)).0, "loop-above-niti");
    }

    #[test]
    fn a_loop_lies_where_the_rod_was() {
        let rod = rod(ROD);
        let of = |center_degc: f64| Facts {
            center_degc: known(center_degc),
            ..sound(&rod)
        };
        assert_eq!(
            one(&of(118.0)),
            (
                "loop-not-reached",
                "the center of the loop would lie at 118.0 °C, above the 115.0 °C that the rod rises to: the recordings hold less \
                 than half of it, and the rest is extrapolated. Look at the units in [rod] and [drive], or drive it further."
                    .to_owned()
            )
        );
        assert!(
            one(&of(20.0))
                .1
                .contains("below the 24.0 °C that the rod falls to")
        );
        let loop_of_voltage = Facts {
            is_static: true,
            drive_unit: "V".to_owned(),
            center_degc: known(9.0),
            reached: [0.0, 8.0],
            tau_s: None,
            ..sound(&rod)
        };
        let (_, text) = one(&loop_of_voltage);
        assert!(
            text.contains("9.0 V, above the 8.0 V that the input rises to"),
            "{text}"
        );
    }

    #[test]
    fn a_time_constant_is_one_that_the_sampling_shows() {
        let thick = rod("[rod]\nlength_mm = 200.0\n");
        let of = |tau_s: f64| Facts {
            tau_s: known(tau_s),
            knows_temperature: false,
            ..sound(&thick)
        };
        assert_eq!(
            one(&of(0.05)),
            (
                "tau-sampling",
                "tau_s is 0.050 s, no more than a step of the sampling: the rod would follow the drive at once. Look at the unit of \
                 the time column."
                    .to_owned()
            )
        );
        assert_eq!(
            one(&of(150.0)),
            (
                "tau-sampling",
                "tau_s is 150 s, as long as the recordings: the rod would never come to rest in them. Look at the unit of the \
                 time column, or record for longer."
                    .to_owned()
            )
        );
        assert_eq!(said(&of(0.1)), []);
        let fixed = Facts {
            tau_s: Some(Known {
                value: 0.05,
                lower: 0.05,
                is_fixed: true,
            }),
            ..of(0.05)
        };
        assert_eq!(said(&fixed), []);
    }

    #[test]
    fn a_time_constant_is_one_of_the_diameter() {
        let rod = rod(ROD);
        let of = |tau_s: f64| Facts {
            tau_s: known(tau_s),
            longest_s: 1e6,
            step_s: 1e-3,
            ..sound(&rod)
        };
        assert_eq!(
            one(&of(2900.0)),
            (
                "tau-diameter",
                "tau_s is 2900 s, and a wire of 0.25 mm has 40 s in air at rest at most, 0.0084 s in a stream of water at least. Look \
                 at the unit of the time column and at diameter_mm."
                    .to_owned()
            )
        );
        assert_eq!(one(&of(0.0029)).0, "tau-diameter");
        // In air at rest 0.25 mm has 1 to 3 s, in water 60 ms.
        for ordinary_s in [0.06, 1.0, 3.0, 20.0] {
            assert_eq!(said(&of(ordinary_s)), [], "{ordinary_s}");
        }
        // The ends of what is on sale, in air: 25 µm at 0.04 to 0.4 s, 1.2 mm at 10 to 60 s.
        for (diameter_mm, taus_s) in [("0.025", [0.04, 0.4]), ("1.2", [10.0, 60.0])] {
            let text = format!("[rod]\ndiameter_mm = {diameter_mm}\n");
            let bare = rod_file::parse("rod.toml", &text).unwrap();
            for tau_s in taus_s {
                let facts = Facts {
                    rod: &bare,
                    knows_temperature: false,
                    largest_drive: 0.05,
                    ..of(tau_s)
                };
                assert_eq!(said(&facts), [], "{diameter_mm} {tau_s}");
            }
        }
    }

    #[test]
    fn a_wire_shortens_by_less_than_a_tenth() {
        let plain = rod(ROD);
        let of = |gain: f64, unit: &str, rod| Facts {
            gain: Some(gain),
            output_unit: unit.to_owned(),
            ..sound(rod)
        };
        assert_eq!(
            one(&of(-24.0, "mm", &plain)),
            (
                "stroke-length",
                "the stroke would be 24 mm, 12 % of the length, and no NiTi wire shortens by more than 10 %. Look at the unit of the \
                 output and at length_mm; if a lever, a pulley or a coil makes more of it, say lever in [load]."
                    .to_owned()
            )
        );
        assert_eq!(one(&of(0.024, "m", &plain)).0, "stroke-length");
        assert_eq!(said(&of(16.0, "mm", &plain)), []);
        assert_eq!(said(&of(24.0, "deg", &plain)), []);
        let levered = rod(&(ROD.to_owned() + "[load]\nlever = 3.0\n"));
        assert_eq!(said(&of(-24.0, "mm", &levered)), []);
    }

    #[test]
    fn lines_and_json_say_the_same() {
        let broken = [Implausible {
            rule: "density",
            said: "no.".to_owned(),
        }];
        assert_eq!(lines(&broken), "IMPLAUSIBLE: no.\n");
        assert_eq!(
            to_json(&broken),
            [json!({"rule": "density", "said": "no."})]
        );
        assert_eq!(lines(&[]), "");
    }
}
