//! Rigs that are recorded as they should be, run after run in another state, and once more after something has changed.

use std::fmt::{self, Write};

use identify::WienerModel;
use missing_physics::{Change, DiagnoseConfig, setting_of_rod};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Quantity, Recording, RecordingParts};
use rig_files::rod_file;
use serde::{Deserialize, Serialize};
use truth_plant::{
    Addition, BiasSpring, Draw, DriveKind, DriveName, DriveProfile, FamilyKind, NoiseKind, Shape,
    Traces, TruthError, TruthPlant,
};
use wiener::hysteresis::Rule;

use crate::Line;

/// Standard deviations of what differs from run to run: surroundings, K; heat loss and stroke, shares.
const AMBIENT_K: f64 = 2.0;
const HEAT_LOSS: f64 = 0.05;
const STROKE: f64 = 0.01;

/// Runs of the reference and of today.
const RUNS: [usize; 2] = [4, 2];

/// Samples of a run.
const SAMPLES: usize = 3_000;

/// Sizes of changes, over their usual ones: in turn, as those of the trial.
const SIZES: [f64; 3] = [1.0, 0.5, 2.0];

/// Loops, in turn: the baseline model's and two that it can only come near.
const LOOPS: [(FamilyKind, &str); 3] = [
    (FamilyKind::L2p, "l2p"),
    (FamilyKind::Preisach, "preisach"),
    (FamilyKind::Cosine, "cosine"),
];

/// Preload of the spring that every rig has, and what it adds over the stroke, Pa.
const PRELOAD_PA: f64 = 100e6;

/// Additions that may change. Left out: drifts of one run, additions that need a thermometer or several zones, and
/// additions without a size.
const CHANGES: [Addition; 14] = [
    Addition::SupplyLag,
    Addition::PhaseResistivity,
    Addition::FreeConvection,
    Addition::Radiation,
    Addition::LatentHeat,
    Addition::LoopAsymmetry,
    Addition::RPhase,
    Addition::StressCoupling,
    Addition::EndStop,
    Addition::ThermalExpansion,
    Addition::Friction,
    Addition::SensorCubic,
    Addition::OutputFilter,
    Addition::OutputDelay,
];

/// Diagnosis of the runs of today.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answered {
    /// Its number.
    pub number: u64,
    /// Name of the rig, or names of its recordings.
    pub of: String,
    /// Id of what has changed, in the catalogue; `None` if nothing has.
    pub changed: Option<String>,
    /// Its size, in the unit that the study says.
    pub size: f64,
    /// The verdict.
    pub verdict: String,
    /// Ids that are named: the likeliest, and what would explain the runs as well.
    pub named: Vec<String>,
    /// Coolings of the reference.
    pub coolings: usize,
    /// [`Change::excess`].
    pub excess: [f64; 2],
}

impl Line for Answered {
    type Key = u64;

    fn key(&self) -> u64 {
        self.number
    }
}

impl Answered {
    /// The answer to a change.
    #[must_use]
    pub fn new(number: u64, of: String, changed: Option<(String, f64)>, change: &Change) -> Self {
        let finding = change.finding.iter();
        let named = finding.flat_map(|finding| {
            let others = finding.could_also_be.iter().map(|other| other.id());
            std::iter::once(finding.leading.what.id()).chain(others)
        });
        let (changed, size) = changed.unzip();
        Self {
            number,
            of,
            changed,
            size: size.unwrap_or(0.0),
            verdict: change.verdict.id().to_owned(),
            named: named.map(str::to_owned).collect(),
            coolings: change.coolings,
            excess: change.excess,
        }
    }

    /// True if the effect that has changed is among the named ones.
    #[must_use]
    pub fn is_named(&self) -> bool {
        self.changed
            .as_ref()
            .is_some_and(|id| self.named.contains(id))
    }

    /// True if effects are named, and the one that has changed is not among them.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        !self.named.is_empty() && !self.is_named()
    }
}

/// Its loop.
impl fmt::Display for ChangedRig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.family.1)
    }
}

/// How often answers are right, in two lines: where something has changed, and where nothing has.
#[must_use]
pub fn said<'a>(answers: impl IntoIterator<Item = &'a Answered>) -> String {
    let (some, none): (Vec<_>, Vec<_>) = answers
        .into_iter()
        .partition(|answer| answer.changed.is_some());
    let count = |of: &[&Answered], is: &dyn Fn(&Answered) -> bool| {
        of.iter().filter(|answer| is(answer)).count()
    };
    let is = |id: &'static str| move |answer: &Answered| answer.verdict == id;
    format!(
        "changed: {} of {} named, {} named wrongly, {} unexplained, {} unchanged, {} with too short a reference\n\
         nothing: {} of {} with a name, {} unexplained, {} with too short a reference\n",
        count(&some, &Answered::is_named),
        some.len(),
        count(&some, &Answered::is_wrong),
        count(&some, &is("unexplained")),
        count(&some, &is("unchanged")),
        count(&some, &is("reference_too_short")),
        count(&none, &Answered::is_wrong),
        none.len(),
        count(&none, &is("unexplained")),
        count(&none, &is("reference_too_short")),
    )
}

/// A rig, and what changes in it.
#[derive(Debug)]
pub struct ChangedRig {
    family: (FamilyKind, &'static str),
    plant: TruthPlant,
    change: Addition,
    /// Size of the change over its usual one.
    size: f64,
    drives: Vec<DriveProfile>,
    seed: u64,
}

impl ChangedRig {
    /// The rig of this number; changes go round with it, then their sizes.
    #[must_use]
    pub fn drawn(seed: u64, number: u64) -> Self {
        let seed = seed.wrapping_add(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let draw = Draw::new(seed);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let kinds = [DriveName::Current, DriveName::Duty, DriveName::Voltage];
        let drive = kinds[random.random_range(0..kinds.len())];
        let family = LOOPS[(number % 3) as usize];
        let mut plant = draw.plant(family.0, drive);
        let section_m2 = plant.rod.section_m2();
        plant.bias_spring = Some(BiasSpring {
            stiffness_n_per_m: PRELOAD_PA * section_m2 / plant.stroke_m,
            preload_n: PRELOAD_PA * section_m2,
        });
        draw.noise(NoiseKind::White, &mut plant);
        let n = RUNS[0] + RUNS[1];
        let drives: Vec<DriveProfile> = (0..n as u64)
            .map(|run| {
                let shape = Shape::ALL[random.random_range(0..Shape::ALL.len())];
                Draw::new(seed ^ (run + 1)).drive(shape, &plant, SAMPLES)
            })
            .collect();
        let round = number / CHANGES.len() as u64;
        Self {
            change: CHANGES[(number % CHANGES.len() as u64) as usize],
            size: SIZES[(round % 3) as usize],
            family,
            plant,
            drives,
            seed,
        }
    }

    /// Name of what changes, in the catalogue.
    #[must_use]
    pub fn effect(&self) -> &'static str {
        self.change.catalogue_id().unwrap_or("none")
    }

    /// Size of the change over its usual one.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.size
    }

    fn with_change(&self, plant: &TruthPlant, run: usize) -> TruthPlant {
        let mut plant = plant.clone();
        let profile = &self.drives[run];
        let run_s = profile.dt_s * profile.drive.len() as f64;
        let spring = plant.bias_spring;
        self.change.install(&mut plant, self.size, run_s);
        plant.bias_spring = spring;
        plant
    }

    /// The plant in the state of a run.
    fn in_state(&self, plant: &TruthPlant, run: usize) -> TruthPlant {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed.wrapping_add(1000 + run as u64));
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut plant = plant.clone();
        plant.ambient_degc += AMBIENT_K * normal();
        plant.convective_coefficient_w_per_m2_k *= 1.0 + HEAT_LOSS * normal();
        plant.stroke_m *= 1.0 + STROKE * normal();
        plant
    }

    fn simulated(&self, plant: &TruthPlant, run: usize) -> Result<Traces, TruthError> {
        let profile = &self.drives[run];
        plant.simulate(&profile.drive, profile.dt_s, self.seed ^ (run as u64) << 8)
    }

    /// Its `rod.toml`.
    fn rod_file(&self) -> String {
        let rod = &self.plant.rod;
        let mut text = format!(
            "[rod]\ndiameter_mm = {:.5}\nlength_mm = {:.4}\ndensity_kg_per_m3 = {:.3}\nspecific_heat_j_per_kg_k = {:.4}\n\
             resistance_ohm_per_m = {:.6}\n[surroundings]\nambient_degc = {:.3}\n[load]\nlever = 1.0\n[drive]\nkind = ",
            1e3 * rod.diameter_m,
            1e3 * rod.length_m,
            rod.density_kg_per_m3,
            rod.specific_heat_j_per_kg_k,
            rod.resistance_ohm_per_m,
            self.plant.ambient_degc,
        );
        // Writing to a string does not fail.
        let _ = match self.plant.drive {
            DriveKind::Duty { supply_v } => {
                writeln!(text, "\"duty\"\nsupply_v = {supply_v}")
            }
            DriveKind::Voltage => writeln!(text, "\"voltage\""),
            DriveKind::Power => writeln!(text, "\"power\""),
            DriveKind::Current => writeln!(text, "\"current\""),
        };
        text
    }

    /// The runs of the reference, and those of today, with the change or without.
    ///
    /// # Errors
    ///
    /// Errors of the plants.
    pub fn recorded(&self, has_changed: bool) -> Result<[Vec<Recording>; 2], TruthError> {
        let record = |run: usize| -> Result<Recording, TruthError> {
            let mut plant = self.in_state(&self.plant, run);
            if has_changed && run >= RUNS[0] {
                plant = self.with_change(&plant, run);
            }
            let traces = self.simulated(&plant, run)?;
            let parts = RecordingParts {
                name: format!("run_{run}.csv"),
                time_s: Some(traces.time_s),
                drive_quantity: match plant.drive {
                    DriveKind::Duty { .. } => Quantity::Duty,
                    DriveKind::Voltage => Quantity::Voltage,
                    DriveKind::Power => Quantity::Power,
                    DriveKind::Current => Quantity::Current,
                },
                drive: traces.drive,
                output_unit: "mm".to_owned(),
                output: traces.displacement_mm,
                ..RecordingParts::default()
            };
            match Recording::new(parts) {
                Ok(recording) => Ok(recording),
                Err(error) => unreachable!("as many finite samples of each: {error}"),
            }
        };
        let runs = 0..RUNS[0] + RUNS[1];
        let mut reference = runs.map(record).collect::<Result<Vec<_>, _>>()?;
        let today = reference.split_off(RUNS[0]);
        Ok([reference, today])
    }

    /// The baseline model of the rig and the settings of its diagnosis.
    ///
    /// # Errors
    ///
    /// Errors of the rod file and of the baseline model.
    pub fn model(
        &self,
        reference: &[Recording],
    ) -> Result<(WienerModel, DiagnoseConfig), Box<dyn std::error::Error>> {
        let rod = rod_file::parse("rod.toml", &self.rod_file())?;
        let base = WienerModel::new(&rod, Rule::LastReversal, reference)?;
        let config = DiagnoseConfig {
            setting: setting_of_rod(&rod, "mm"),
            ..DiagnoseConfig::default()
        };
        Ok((base, config))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(changed: Option<&str>, verdict: &str, named: &[&str]) -> Answered {
        Answered {
            number: 0,
            of: "l2p".to_owned(),
            changed: changed.map(str::to_owned),
            size: 1.0,
            verdict: verdict.to_owned(),
            named: named.iter().map(|&id| id.to_owned()).collect(),
            coolings: 4,
            excess: [1.0; 2],
        }
    }

    #[test]
    fn names_are_right_if_the_truth_is_among_them() {
        let answers = [
            answered(Some("backlash"), "changed", &["output-lag", "backlash"]),
            answered(Some("backlash"), "changed", &["output-lag"]),
            answered(Some("radiation"), "unchanged", &[]),
            answered(None, "unchanged", &[]),
            answered(None, "changed", &["zeta"]),
        ];
        let text = said(&answers);
        assert!(
            text.starts_with("changed: 1 of 3 named, 1 named wrongly, 0 unexplained, 1 unchanged")
        );
        assert!(text.contains("\nnothing: 1 of 2 with a name, "));
    }

    #[test]
    fn a_rig_is_recorded_in_ever_other_states_and_only_today_changes() {
        let rig = ChangedRig::drawn(1, 3);
        assert_eq!((rig.effect(), rig.size()), ("radiation", 1.0));
        let [reference, unchanged] = rig.recorded(false).unwrap();
        let [again, changed] = rig.recorded(true).unwrap();
        assert_eq!([reference.len(), changed.len()], RUNS);
        assert_eq!(reference, again);
        assert_ne!(unchanged[0].output(), changed[0].output());
        assert_eq!(unchanged[0].drive(), changed[0].drive());
    }
}
