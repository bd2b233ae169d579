//! `rod.toml`: what is known of the rig.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::{Range, RangeInclusive};
use std::path::Path;

use recording::{Columns, Quantity, ReadOptions};
use serde::Deserialize;
use toml::Spanned;
use wiener::Drive;
use wiener::thermal::RodParams;

use crate::recording_use::{RecordingTable, RecordingUse, uses};
use crate::source::{Source, read};
use crate::supply::Supplied;
use crate::{Bounds, Enters, IdentifyError, ParameterInfo, ParameterState, Supply};

/// Lengths and diameters that are read, mm: beyond, a section would be no number.
const MEASURES_MM: RangeInclusive<f64> = 1e-9..=1e9;

/// Resistivity of NiTi, Ω m, that stands in for a resistance which is not given.
pub const NITI_OHM_M: f64 = 0.8e-6;

/// Its range, Ω m: vendors of wire give 0.76e-6 and 0.8e-6 cold, 0.82e-6 and 1e-6 hot.
pub const NITI_RANGE_OHM_M: Bounds = Bounds {
    lower: 0.76e-6,
    upper: 1e-6,
};

/// Checked content of a rod file.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    file: String,
    text: String,
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
    name: String,
    span: Range<usize>,
    wish: Wish,
}

/// Requested value or bounds of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wish {
    Fixed(f64),
    Bounds(Bounds),
}

// The file as it is written: every number with its place, so that an error can point at it.

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RodFile {
    pub(crate) rod: RodTable,
    pub(crate) surroundings: Surroundings,
    pub(crate) drive: DriveTable,
    pub(crate) load: Option<LoadTable>,
    pub(crate) limits: LimitsTable,
    pub(crate) columns: Columns,
    pub(crate) model: BTreeMap<Spanned<String>, ModelTable>,
    pub(crate) recordings: BTreeMap<String, RecordingTable>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RodTable {
    diameter_mm: Option<Spanned<f64>>,
    length_mm: Option<Spanned<f64>>,
    density_kg_per_m3: Option<Spanned<f64>>,
    specific_heat_j_per_kg_k: Option<Spanned<Uncertain>>,
    resistance_ohm_per_m: Option<Spanned<f64>>,
}

/// A number, or one with its range; places stand around the whole, since an untagged value has none
/// inside.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, or { value = number, range = [low, high] }"
)]
enum Uncertain {
    Value(f64),
    Range(UncertainTable),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct UncertainTable {
    value: f64,
    range: [f64; 2],
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Surroundings {
    ambient_degc: Option<Spanned<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct DriveTable {
    kind: Quantity,
    supply_v: Option<Spanned<f64>>,
    pub(crate) limit: Option<Spanned<f64>>,
    pub(crate) current_max_a: Option<Spanned<f64>>,
    pub(crate) voltage_max_v: Option<Spanned<f64>>,
    pub(crate) lead_resistance_ohm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoadTable {
    spring_n_per_mm: Option<Spanned<f64>>,
    preload_n: Option<Spanned<f64>>,
    lever: Option<Spanned<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct LimitsTable {
    drive_max: Option<Spanned<f64>>,
    temperature_max_degc: Option<Spanned<f64>>,
    duration_s: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelTable {
    bounds: Option<[Spanned<f64>; 2]>,
    fixed: Option<Spanned<f64>>,
}

fn uncertain(
    source: &Source<'_>,
    key: &str,
    value: &Option<Spanned<Uncertain>>,
) -> Result<(Option<f64>, Option<Bounds>), IdentifyError> {
    let Some(spanned) = value else {
        return Ok((None, None));
    };
    let here = |value| Some(Spanned::new(spanned.span(), value));
    match spanned.get_ref() {
        Uncertain::Value(value) => Ok((source.positive(key, &here(*value))?, None)),
        Uncertain::Range(UncertainTable { value, range }) => {
            source.positive(&format!("{key}.range"), &here(range[0]))?;
            let range = range.map(|end| Spanned::new(spanned.span(), end));
            let range = source.rising(&format!("{key}.range"), &range)?;
            if !(range.lower..=range.upper).contains(value) {
                let accepted = format!("must lie in its range, {} to {}", range.lower, range.upper);
                return Err(source.value(
                    &format!("{key}.value"),
                    &Spanned::new(spanned.span(), *value),
                    accepted,
                ));
            }
            Ok((
                source.positive(&format!("{key}.value"), &here(*value))?,
                Some(range),
            ))
        }
    }
}

impl Rod {
    /// Reads a rod file.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Unreadable`], and as [`Rod::parse`].
    pub fn read(path: &Path) -> Result<Self, IdentifyError> {
        let (file, text) = read(path)?;
        Self::parse(&file, &text)
    }

    /// Reads the text of a rod file; `file` is its name for errors.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Toml`] for what is not such a file, [`IdentifyError::Value`] for a value out of
    /// range, each with line and column.
    pub fn parse(file: &str, text: &str) -> Result<Self, IdentifyError> {
        let source = Source { file, text };
        let parsed: RodFile =
            toml::from_str(text).map_err(|error| source.toml(&error, source.not_a_rod_file()))?;
        Self::of(&source, parsed)
    }

    /// Checks what a file says, be it a rod file or a model that has its tables.
    pub(crate) fn of(source: &Source<'_>, parsed: RodFile) -> Result<Self, IdentifyError> {
        let RodFile {
            rod,
            drive,
            load,
            limits,
            ..
        } = &parsed;
        let (specific_heat, specific_heat_range) = uncertain(
            source,
            "rod.specific_heat_j_per_kg_k",
            &rod.specific_heat_j_per_kg_k,
        )?;
        let mm = |key, value: &Option<Spanned<f64>>| -> Result<_, IdentifyError> {
            match (source.positive(key, value)?, value) {
                (Some(mm), Some(spanned)) if !MEASURES_MM.contains(&mm) => {
                    let [least, most] = [MEASURES_MM.start(), MEASURES_MM.end()];
                    let accepted = format!("must be from {least:e} to {most:e} mm");
                    Err(source.value(key, spanned, accepted))
                }
                (mm, _) => Ok(mm.map(|mm| mm * 1e-3)),
            }
        };
        let load = match load {
            None => None,
            Some(table) => Some(Load {
                spring_n_per_mm: source.positive("load.spring_n_per_mm", &table.spring_n_per_mm)?,
                preload_n: source.finite("load.preload_n", &table.preload_n)?,
                lever: source.positive("load.lever", &table.lever)?,
            }),
        };
        let length_m = mm("rod.length_mm", &rod.length_mm)?;
        let resistance_ohm_per_m =
            source.positive("rod.resistance_ohm_per_m", &rod.resistance_ohm_per_m)?;
        let supplied = Supplied {
            drive_kind: drive.kind,
            length_m,
            resistance_ohm_per_m,
        };
        let supply = Supply::of(source, drive, &supplied)?;
        let drive_max = source.positive("limits.drive_max", &limits.drive_max)?;
        Ok(Self {
            drive_kind: drive.kind,
            supply_v: source.positive("drive.supply_v", &drive.supply_v)?,
            supply,
            length_m,
            diameter_m: mm("rod.diameter_mm", &rod.diameter_mm)?,
            density_kg_per_m3: source.positive("rod.density_kg_per_m3", &rod.density_kg_per_m3)?,
            specific_heat_j_per_kg_k: specific_heat,
            specific_heat_range,
            resistance_ohm_per_m,
            ambient_degc: ambient(
                source,
                "surroundings.ambient_degc",
                &parsed.surroundings.ambient_degc,
            )?,
            load,
            limits: Limits {
                // What the supply does not give no rig gets.
                drive_max: drive_max.map(|most| supply.limited(most)),
                temperature_max_degc: source
                    .finite("limits.temperature_max_degc", &limits.temperature_max_degc)?,
                duration_s: source.positive("limits.duration_s", &limits.duration_s)?,
            },
            columns: parsed.columns,
            uses: uses(source, &parsed.recordings)?,
            model: parsed
                .model
                .iter()
                .map(|(name, table)| model_entry(source, name, table))
                .collect::<Result<_, _>>()?,
            file: source.file.to_owned(),
            text: source.text.to_owned(),
        })
    }

    /// The tables of the file that say what the rig is and which parts of its recordings count, as they are written there; `[model]`,
    /// which says what to do with it, is not among them.
    pub(crate) fn tables(&self) -> toml::Table {
        const TABLES: [&str; 7] = [
            "rod",
            "surroundings",
            "drive",
            "load",
            "limits",
            "columns",
            "recordings",
        ];
        let mut tables: toml::Table = toml::from_str(&self.text).unwrap_or_default();
        tables.retain(|key, _| TABLES.contains(&key));
        tables
    }

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

    /// Name of the file, as errors name it.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
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
                let (line, column) = self.position(&entry.span);
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
        let (line, column) = self.position(&entry.span);
        IdentifyError::Entry {
            file: self.file.clone(),
            line,
            column,
            name: entry.name.clone(),
            accepted: accepted.to_owned(),
        }
    }

    fn position(&self, span: &Range<usize>) -> (usize, usize) {
        let source = Source {
            file: &self.file,
            text: &self.text,
        };
        source.position(span.start)
    }
}

/// Temperatures that surround a rig, °C: from a cold chamber to an oven; kelvins are not among them.
const SURROUNDINGS_DEGC: Bounds = Bounds {
    lower: -100.0,
    upper: 200.0,
};

/// A temperature of the surroundings that can be one, °C.
pub(crate) fn ambient(
    source: &Source<'_>,
    key: &str,
    value: &Option<Spanned<f64>>,
) -> Result<Option<f64>, IdentifyError> {
    let Bounds { lower, upper } = SURROUNDINGS_DEGC;
    match (source.finite(key, value)?, value) {
        (Some(degc), Some(spanned)) if !(lower..=upper).contains(&degc) => {
            let kelvins = format!(
                "must lie from {lower} to {upper} °C; {degc} K would be {:.2} °C",
                degc - 273.15
            );
            Err(source.value(key, spanned, kelvins))
        }
        (known, _) => Ok(known),
    }
}

fn model_entry(
    source: &Source<'_>,
    name: &Spanned<String>,
    table: &ModelTable,
) -> Result<ModelEntry, IdentifyError> {
    let key = format!("model.{}", name.get_ref());
    let wish = match (&table.bounds, &table.fixed) {
        (Some(bounds), None) => Wish::Bounds(source.rising(&format!("{key}.bounds"), bounds)?),
        (None, Some(fixed)) => {
            let fixed = Some(fixed.clone());
            let Some(value) = source.finite(&format!("{key}.fixed"), &fixed)? else {
                unreachable!("a value that is there stays there");
            };
            Wish::Fixed(value)
        }
        _ => {
            let (line, column) = source.position(name.span().start);
            return Err(IdentifyError::Entry {
                file: source.file.to_owned(),
                line,
                column,
                name: name.get_ref().clone(),
                accepted: "must be { fixed = value } or { bounds = [low, high] }".to_owned(),
            });
        }
    };
    Ok(ModelEntry {
        name: name.get_ref().clone(),
        span: name.span(),
        wish,
    })
}
