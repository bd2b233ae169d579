//! Which column of a file is what.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor, value::MapAccessDeserializer};

/// Which column of a file is what: the `[columns]` table of `rod.toml`.
///
/// A column that is `None` is found by its default name, matched without case, with any unit that suits:
///
/// | key | default |
/// | --- | --- |
/// | `time` | `time_s` or `time_ms` |
/// | `drive` | by its quantity: `current_a` or `current_ma`, `duty`, `voltage_v`, `power_w`, `temperature_degc` (`_c`, `_k`) |
/// | `antagonist` | nothing |
/// | `output` | `displacement_mm`, or else the one column called `displacement`, `position`, `displacement_*` or `position_*` |
/// | `temperature` | `temperature_degc` (`_c`, `_k`), if it is there; never beside a drive that is a temperature |
/// | `ambient` | `ambient_degc` (`_c`, `_k`), if it is there |
/// | `stress` | `stress_mpa` or `stress_pa`, if it is there and neither drive nor output |
/// | `resistance` | `resistance_ohm`, if it is there and neither drive nor output |
/// | `then` | nothing |
///
/// `skip`, `decimal` and `strict` say how the file is written, `as_recorded` what fits make of it, not which column is what.
///
/// # Examples
///
/// ```
/// use recording::{ColumnSpec, Columns};
///
/// let columns = Columns {
///     drive: Some(ColumnSpec::name("pwm_duty_limb0_rev")),
///     output: Some(ColumnSpec::number(3).in_unit("mm")),
///     ..Columns::default()
/// };
/// # assert!(columns.time.is_none());
/// ```
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Columns {
    /// Time; must rise.
    pub time: Option<ColumnSpec>,
    /// Drive of the actuator.
    pub drive: Option<ColumnSpec>,
    /// Drive of a second actuator that pulls the other way, in a unit of the drive's quantity.
    pub antagonist: Option<ColumnSpec>,
    /// Output of the actuator: displacement, angle, force; keeps its unit.
    pub output: Option<ColumnSpec>,
    /// Measured temperature of the actuator.
    pub temperature: Option<ColumnSpec>,
    /// Measured temperature of the surroundings.
    pub ambient: Option<ColumnSpec>,
    /// Stress in the actuator.
    pub stress: Option<ColumnSpec>,
    /// Resistance of the actuator.
    pub resistance: Option<ResistanceSpec>,
    /// Columns whose rows follow the last row of these, of static data whose ways up and down stand side by
    /// side; the same ones in the same units.
    pub then: Option<Box<Columns>>,
    /// Lines at the head of the file that are left out, whatever stands there.
    pub skip: usize,
    /// The decimal mark, `.` or `,`; `None` takes it from the numbers.
    pub decimal: Option<char>,
    /// True if a file must be as the format says, with nothing adapted; see [`read_csv`](crate::read_csv).
    pub strict: bool,
    /// True if fits take all samples as they were recorded, instead of [`mended`](crate::mended) ones. [`Self::strict`] has
    /// this effect, too.
    pub as_recorded: bool,
}

impl Columns {
    /// True if a recording may be [`mended`](crate::mended) before it is fitted.
    #[must_use]
    pub const fn may_mend(&self) -> bool {
        !(self.as_recorded || self.strict)
    }
}

/// Where the resistance of the actuator is found.
///
/// Deserializes from a column, as [`ColumnSpec`], or from two (`{ voltage = "voltage_v", current = 2 }`), either
/// of which may be the drive, too.
#[derive(Debug, Clone, PartialEq)]
pub enum ResistanceSpec {
    /// In a column of its own.
    Column(ColumnSpec),
    /// As the voltage over the actuator and the current through it.
    VoltageOverCurrent {
        /// Voltage.
        voltage: ColumnSpec,
        /// Current.
        current: ColumnSpec,
    },
}

/// One column: where it stands and, if its name does not say it, its unit.
///
/// Deserializes from a name (`"duty"`), a number counted from 1 (`3`), or a table
/// (`{ name = "Temperature", unit = "degc" }`, `{ number = 3, unit = "mm" }`, `{ name = "pwm", unit = "counts", full_scale =
/// 255 }`; of time without a column `{ every_s = 0.01 }`).
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnSpec {
    /// Where the column stands.
    pub key: ColumnKey,
    /// Its unit; `None`: the one at the end of its name.
    pub unit: Option<String>,
    /// Counts of a duty that is always on, for one in `counts`: 255 or 1023, > 0.
    pub full_scale: Option<f64>,
}

/// Where a column stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnKey {
    /// Under this name in the header, matched without case.
    Name(String),
    /// At this place in the row, counted from 1; needs no header.
    Number(usize),
    /// Nowhere: of time only, one row every so many seconds, > 0.
    EveryS(f64),
}

impl ColumnSpec {
    /// A column by its name in the header.
    #[must_use]
    pub fn name(name: impl Into<String>) -> Self {
        Self {
            key: ColumnKey::Name(name.into()),
            unit: None,
            full_scale: None,
        }
    }

    /// A column by its number, counted from 1.
    #[must_use]
    pub fn number(number: usize) -> Self {
        Self {
            key: ColumnKey::Number(number),
            unit: None,
            full_scale: None,
        }
    }

    /// A time that no column holds: a row every `every_s` seconds, > 0.
    #[must_use]
    pub fn every_s(every_s: f64) -> Self {
        Self {
            key: ColumnKey::EveryS(every_s),
            unit: None,
            full_scale: None,
        }
    }

    /// This column, in `unit`.
    #[must_use]
    pub fn in_unit(self, unit: impl Into<String>) -> Self {
        Self {
            unit: Some(unit.into()),
            ..self
        }
    }
}

/// The table form of a column.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    name: Option<String>,
    number: Option<usize>,
    unit: Option<String>,
    every_s: Option<f64>,
    full_scale: Option<f64>,
}

impl Table {
    fn spec<E: Error>(self) -> Result<ColumnSpec, E> {
        for (key, value) in [("every_s", self.every_s), ("full_scale", self.full_scale)] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(E::custom(format!("{key} = {value}: expected a number > 0")));
            }
        }
        let spec = match (self.name, self.number, self.every_s) {
            (Some(name), None, None) => ColumnSpec::name(name),
            (None, Some(number), None) if number >= 1 => ColumnSpec::number(number),
            (None, None, Some(every_s)) => ColumnSpec::every_s(every_s),
            (None, Some(number), None) => {
                let text = format!("column number {number}: columns are counted from 1");
                return Err(E::custom(text));
            }
            _ => return Err(E::custom("a column needs either `name` or `number`")),
        };
        Ok(ColumnSpec {
            unit: self.unit,
            full_scale: self.full_scale,
            ..spec
        })
    }
}

// Written by hand: an untagged enum would answer every typing error with "did not match any
// variant".
struct SpecVisitor;

impl<'de> Visitor<'de> for SpecVisitor {
    type Value = ColumnSpec;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a column name, a column number counted from 1, or a table { name or number, unit }",
        )
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<ColumnSpec, E> {
        Ok(ColumnSpec::name(name))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<ColumnSpec, E> {
        match usize::try_from(number) {
            Ok(number) if number >= 1 => Ok(ColumnSpec::number(number)),
            _ => Err(E::custom(format!(
                "column number {number}: columns are counted from 1"
            ))),
        }
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<ColumnSpec, E> {
        // A number beyond i64 is beyond every file.
        self.visit_i64(i64::try_from(number).unwrap_or(i64::MAX))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ColumnSpec, A::Error> {
        Table::deserialize(MapAccessDeserializer::new(map))?.spec()
    }
}

impl<'de> Deserialize<'de> for ColumnSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SpecVisitor)
    }
}

/// The table form of a resistance.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ResistanceTable {
    name: Option<String>,
    number: Option<usize>,
    unit: Option<String>,
    voltage: Option<ColumnSpec>,
    current: Option<ColumnSpec>,
}

struct ResistanceVisitor;

impl<'de> Visitor<'de> for ResistanceVisitor {
    type Value = ResistanceSpec;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        SpecVisitor.expecting(f)?;
        f.write_str(" or { voltage, current }")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<ResistanceSpec, E> {
        SpecVisitor.visit_str(name).map(ResistanceSpec::Column)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<ResistanceSpec, E> {
        SpecVisitor.visit_i64(number).map(ResistanceSpec::Column)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<ResistanceSpec, E> {
        SpecVisitor.visit_u64(number).map(ResistanceSpec::Column)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ResistanceSpec, A::Error> {
        let ResistanceTable {
            name,
            number,
            unit,
            voltage,
            current,
        } = ResistanceTable::deserialize(MapAccessDeserializer::new(map))?;
        match (voltage, current) {
            (None, None) => Table {
                name,
                number,
                unit,
                every_s: None,
                full_scale: None,
            }
            .spec()
            .map(ResistanceSpec::Column),
            (Some(voltage), Some(current)) if (&name, number, &unit) == (&None, None, &None) => {
                Ok(ResistanceSpec::VoltageOverCurrent { voltage, current })
            }
            _ => Err(A::Error::custom(
                "a resistance needs `voltage` and `current`, or a column of its own",
            )),
        }
    }
}

impl<'de> Deserialize<'de> for ResistanceSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ResistanceVisitor)
    }
}
