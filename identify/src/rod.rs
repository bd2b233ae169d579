//! Knowledge of the rig.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use recording::{Columns, Quantity, ReadOptions};
use wiener::Drive;
use wiener::thermal::RodParams;

use crate::{Bounds, Enters, IdentifyError, ParameterInfo, ParameterState, RecordingUse, Supply};

/// Resistivity of NiTi, Ω m, that stands in for a resistance which is not given.
pub const NITI_OHM_M: f64 = 0.8e-6;

/// Its range, Ω m: vendors of wire give 0.76e-6 and 0.8e-6 cold, 0.82e-6 and 1e-6 hot.
pub const NITI_RANGE_OHM_M: Bounds = Bounds {
    lower: 0.76e-6,
    upper: 1e-6,
};

/// Known properties of a rig; a rod file says them.
///
/// Values are not checked here: lengths, densities, resistances and limits are finite and above 0.
///
/// # Examples
///
/// ```
/// use identify::Rod;
///
/// let rod = Rod {
///     ambient_degc: Some(22.0),
///     ..Rod::default()
/// };
/// assert_eq!(rod.missing_for_temperature().len(), 4);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rod {
    /// Name of the file, as errors name it.
    pub file: String,
    /// Text of the file, whose tables a saved model keeps; empty for a rod that is in no file.
    pub text: String,
    /// Physical quantity of the drive.
    pub drive_kind: Quantity,
    /// Supply voltage of a duty drive, V.
    pub supply_v: Option<f64>,
    /// Where the supply saturates, and what leads take.
    pub supply: Supply,
    /// Length between the contacts, m.
    pub length_m: Option<f64>,
    /// Diameter, m.
    pub diameter_m: Option<f64>,
    /// Density, kg/m³.
    pub density_kg_per_m3: Option<f64>,
    /// Specific heat, J/(kg K).
    pub specific_heat_j_per_kg_k: Option<f64>,
    /// Range over which the specific heat is uncertain, J/(kg K).
    pub specific_heat_range: Option<Bounds>,
    /// Resistance, Ω/m.
    pub resistance_ohm_per_m: Option<f64>,
    /// Temperature of the surroundings, °C.
    pub ambient_degc: Option<f64>,
    /// Mechanics, where given.
    pub load: Option<Load>,
    /// Limits of the rig, for tuning and proposed experiments.
    pub limits: Limits,
    /// Which column of a recording is what.
    pub columns: Columns,
    /// The user's entries on the model's parameters.
    pub model: Vec<ModelEntry>,
    /// Selection and preprocessing of recordings, by the names of their files.
    pub uses: BTreeMap<String, RecordingUse>,
}

/// Mechanics of the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Stiffness of the bias spring, N/mm.
    pub spring_n_per_mm: Option<f64>,
    /// Force of the spring at rest, N.
    pub preload_n: Option<f64>,
    /// Displacement of the sensor over elongation of the rod.
    pub lever: Option<f64>,
}

/// Operating limits of the rig: drive, temperature, duration of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Largest drive, in its unit.
    pub drive_max: Option<f64>,
    /// Largest temperature, °C.
    pub temperature_max_degc: Option<f64>,
    /// Longest run, s.
    pub duration_s: Option<f64>,
}

/// Entry of `[model]` on one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelEntry {
    /// Name of the parameter.
    pub name: String,
    /// Line and column of the rod file where it stands, from 1.
    pub place: (usize, usize),
    /// Requested value or bounds.
    pub wish: Wish,
}

/// Requested value or bounds of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wish {
    /// It has this value.
    Fixed(f64),
    /// It is searched within them.
    Bounds(Bounds),
}

impl Rod {
    /// Selection and preprocessing of a recording, by its path as it was given, or else by the name of its file.
    #[must_use]
    pub fn use_of(&self, recording: &Path) -> RecordingUse {
        let name = recording.file_name().and_then(|name| name.to_str());
        let by = |name: Option<&str>| self.uses.get(name?).cloned();
        let used = by(recording.to_str()).or_else(|| by(name));
        used.unwrap_or_default()
    }

    /// True if `[model]` fixes a parameter or gives it bounds.
    #[must_use]
    pub fn says_of(&self, parameter: &str) -> bool {
        self.model.iter().any(|entry| entry.name == parameter)
    }

    /// How recordings of this rig are read.
    #[must_use]
    pub fn read_options(&self) -> ReadOptions {
        ReadOptions {
            columns: self.columns.clone(),
            drive_limit: self.supply.limit,
            ..ReadOptions::new(self.drive_kind)
        }
    }

    /// The drive with its wiring; lengths that do not matter for ratios are 1 m.
    ///
    /// Leads count as the length of rod that has their resistance, by which the power in the rod is the same:
    ///
    /// ```text
    /// V² R/(R l + R_lead)² = V²/(R (l + R_lead/R)²)     R per meter
    /// ```
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Missing`] if a duty drive has no supply voltage, and length and resistance of the rod are given.
    pub fn drive(&self) -> Result<Drive, IdentifyError> {
        let length_m = self.length_m.unwrap_or(1.0) + self.leads_as_rod_m();
        match (self.drive_kind, self.supply_v) {
            (Quantity::Current, _) => Ok(Drive::Current),
            (Quantity::Duty, Some(supply_v)) => Ok(Drive::Duty { supply_v, length_m }),
            // Powers are known by their ratios only, whatever the supply.
            (Quantity::Duty, None) if self.length_m.is_none() || !self.knows_resistance() => {
                Ok(Drive::Duty {
                    supply_v: 1.0,
                    length_m,
                })
            }
            (Quantity::Duty, None) => Err(IdentifyError::Missing {
                file: self.file.clone(),
                key: "drive.supply_v",
                why: "a duty says how long the supply is on, not how strong it is",
            }),
            (Quantity::Voltage, _) => Ok(Drive::Voltage { length_m }),
            (Quantity::Power, _) => Ok(Drive::Power { length_m }),
            (Quantity::Temperature, _) => Err(IdentifyError::StaticDrive {
                file: self.file.clone(),
            }),
        }
    }

    /// Length of rod that has the resistance of the leads, m; 0 without leads.
    fn leads_as_rod_m(&self) -> f64 {
        let leads = self
            .supply
            .lead_resistance_ohm
            .zip(self.resistance_ohm_per_m);
        leads.map_or(0.0, |(lead_ohm, ohm_per_m)| lead_ohm / ohm_per_m)
    }

    /// Share of the resistance between the supply's terminals that is the leads', 0 to 1.
    #[must_use]
    pub fn lead_share(&self) -> f64 {
        let leads_m = self.leads_as_rod_m();
        leads_m / (self.length_m.unwrap_or(1.0) + leads_m)
    }

    /// Heat capacity per meter, J/(m K), where diameter, density and specific heat are given.
    #[must_use]
    pub fn heat_capacity_j_per_m_k(&self) -> Option<f64> {
        let material = RodParams {
            diameter_m: self.diameter_m?,
            density_kg_per_m3: self.density_kg_per_m3?,
            specific_heat_j_per_kg_k: self.specific_heat_j_per_kg_k?,
            // Neither has a part in it.
            resistance_ohm_per_m: 1.0,
            convective_coefficient_w_per_m2_k: 1.0,
        };
        Some(material.mass_kg_per_m() * material.specific_heat_j_per_kg_k)
    }

    /// Geometry and material with a convective coefficient of 1 W/(m² K), if all that decides the
    /// temperature is known; see [`Rod::missing_for_temperature`].
    #[must_use]
    pub fn material(&self) -> Option<RodParams> {
        if !self.missing_for_temperature().is_empty() {
            return None;
        }
        Some(RodParams {
            diameter_m: self.diameter_m?,
            density_kg_per_m3: self.density_kg_per_m3?,
            specific_heat_j_per_kg_k: self.specific_heat_j_per_kg_k?,
            // Power heats the same whatever the resistance.
            resistance_ohm_per_m: self.resistance_ohm_per_m.unwrap_or(1.0),
            convective_coefficient_w_per_m2_k: 1.0,
        })
    }

    /// True if the resistance is given, or the section that it follows from.
    fn knows_resistance(&self) -> bool {
        self.resistance_ohm_per_m.is_some() || self.diameter_m.is_some()
    }

    /// Cross section, m², where the diameter is given.
    #[must_use]
    pub fn section_m2(&self) -> Option<f64> {
        self.diameter_m
            .map(|diameter_m| PI * diameter_m * diameter_m / 4.0)
    }

    /// Resistance per meter, Ω/m: that of the file, else that of NiTi in the section of the rod; 1 where that is not given
    /// either, by which powers are known by their ratios only.
    pub(crate) fn resistance_or_typical_ohm_per_m(&self) -> f64 {
        let typical = self.section_m2().map(|section_m2| NITI_OHM_M / section_m2);
        self.resistance_ohm_per_m.or(typical).unwrap_or(1.0)
    }

    /// True if the power of the drive rests on NiTi's resistivity and the section of the rod: the resistance counts and
    /// is not given.
    #[must_use]
    pub fn assumes_resistivity(&self) -> bool {
        let counts = self.drive_kind != Quantity::Power;
        counts && self.resistance_ohm_per_m.is_none() && self.diameter_m.is_some()
    }

    /// The keys without which temperatures are known by their ratios only: heat capacity and
    /// resistance per meter, the length unless current drives the rod, and the supply of a duty.
    #[must_use]
    pub fn missing_for_temperature(&self) -> Vec<&'static str> {
        let needs_length = self.drive_kind != Quantity::Current;
        let needs_resistance = self.drive_kind != Quantity::Power;
        [
            ("diameter_mm", self.diameter_m.is_none()),
            ("density_kg_per_m3", self.density_kg_per_m3.is_none()),
            (
                "specific_heat_j_per_kg_k",
                self.specific_heat_j_per_kg_k.is_none(),
            ),
            (
                "resistance_ohm_per_m",
                needs_resistance && self.resistance_ohm_per_m.is_none(),
            ),
            ("length_mm", needs_length && self.length_m.is_none()),
            (
                "supply_v",
                self.drive_kind == Quantity::Duty && self.supply_v.is_none(),
            ),
        ]
        .into_iter()
        .filter_map(|(key, missing)| missing.then_some(key))
        .collect()
    }

    /// Puts what `[model]` says into the parameters of a model.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::UnknownParameter`].
    pub(crate) fn apply_model(&self, infos: &mut [ParameterInfo]) -> Result<(), IdentifyError> {
        for entry in &self.model {
            let names: Vec<&str> = infos.iter().map(|info| info.name).collect();
            let Some(k) = names.iter().position(|&name| name == entry.name) else {
                let (line, column) = entry.place;
                return Err(IdentifyError::UnknownParameter {
                    file: self.file.clone(),
                    line,
                    column,
                    name: entry.name.clone(),
                    known: names.join(", "),
                });
            };
            let info = &mut infos[k];
            let Bounds { lower, upper } = info.admissible;
            let admissible = |value: f64| (lower..=upper).contains(&value);
            match entry.wish {
                Wish::Bounds(_) if info.enters != Enters::Nonlinear => {
                    return Err(self.entry_error(
                        entry,
                        "is solved for, not searched: fix it or leave it out",
                    ));
                }
                Wish::Bounds(bounds) if admissible(bounds.lower) && admissible(bounds.upper) => {
                    info.bounds = bounds;
                    info.state = ParameterState::Free;
                }
                Wish::Fixed(value) if admissible(value) => {
                    info.state = ParameterState::Fixed(value);
                }
                _ => {
                    let accepted = format!("must lie from {lower:e} to {upper:e} {}", info.unit);
                    return Err(self.entry_error(entry, &accepted));
                }
            }
        }
        Ok(())
    }

    fn entry_error(&self, entry: &ModelEntry, accepted: &str) -> IdentifyError {
        let (line, column) = entry.place;
        IdentifyError::Entry {
            file: self.file.clone(),
            line,
            column,
            name: entry.name.clone(),
            accepted: accepted.to_owned(),
        }
    }
}
