//! `rod.toml`: what is known of the rig.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::Path;

use identify::{Bounds, IdentifyError, Limits, Load, ModelEntry, Rod, Wish};
use recording::{Columns, Quantity};
use serde::Deserialize;
use toml::Spanned;

use crate::RigFileError;
use crate::recording_table::{RecordingTable, uses};
use crate::source::{Source, read_file};
use crate::supply_keys::{Supplied, supply};

/// Lengths and diameters that are read, mm: beyond, a section would be no number.
const MEASURES_MM: RangeInclusive<f64> = 1e-9..=1e9;

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
) -> Result<(Option<f64>, Option<Bounds>), RigFileError> {
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

/// Reads a rod file.
///
/// # Errors
///
/// [`RigFileError::Unreadable`], and as [`parse`].
pub fn read(path: &Path) -> Result<Rod, RigFileError> {
    let (file, text) = read_file(path)?;
    parse(&file, &text)
}

/// Reads the text of a rod file; `file` is its name for errors.
///
/// # Errors
///
/// [`RigFileError::Toml`] for what is not such a file, [`RigFileError::Value`] for a value out of range, and [`RigFileError::Model`] for an
/// entry of `[model]` that says nothing or too much, each with line and column; [`RigFileError::Model`] for a supply whose rod lacks length
/// or resistance.
pub fn parse(file: &str, text: &str) -> Result<Rod, RigFileError> {
    let source = Source { file, text };
    let parsed: RodFile =
        toml::from_str(text).map_err(|error| source.toml(&error, source.not_a_rod_file()))?;
    of(&source, parsed)
}

/// Checks what a file says, be it a rod file or a model that has its tables.
pub(crate) fn of(source: &Source<'_>, parsed: RodFile) -> Result<Rod, RigFileError> {
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
    let mm = |key, value: &Option<Spanned<f64>>| -> Result<_, RigFileError> {
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
    let supply = supply(source, drive, &supplied)?;
    let drive_max = source.positive("limits.drive_max", &limits.drive_max)?;
    Ok(Rod {
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
pub(crate) fn tables(rod: &Rod) -> toml::Table {
    const TABLES: [&str; 7] = [
        "rod",
        "surroundings",
        "drive",
        "load",
        "limits",
        "columns",
        "recordings",
    ];
    let mut tables: toml::Table = toml::from_str(&rod.text).unwrap_or_default();
    tables.retain(|key, _| TABLES.contains(&key));
    tables
}

/// True if the tables of a rod's text say what its fields say. What is used of recordings flags may have changed, and what is to be done with
/// the model is not among the tables.
pub(crate) fn is_what_its_text_says(rod: &Rod) -> bool {
    let Ok(text) = toml::to_string(&tables(rod)) else {
        return false;
    };
    let said = parse(&rod.file, &text);
    said.is_ok_and(|said| {
        let said = Rod {
            text: rod.text.clone(),
            uses: rod.uses.clone(),
            model: rod.model.clone(),
            ..said
        };
        said == *rod
    })
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
) -> Result<Option<f64>, RigFileError> {
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
) -> Result<ModelEntry, RigFileError> {
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
            }
            .into());
        }
    };
    Ok(ModelEntry {
        name: name.get_ref().clone(),
        place: source.position(name.span().start),
        wish,
    })
}
