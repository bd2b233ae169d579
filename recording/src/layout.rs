//! Which field of a row is what: the wanted columns, found in the first line of a file.

use crate::columns::{ColumnKey, ColumnSpec, Columns, ResistanceSpec};
use crate::error::RecordingError;
use crate::quantity::Quantity;
use crate::read::ReadOptions;
use crate::unit::{Unit, normalized, output_symbol, split_name};

/// Names of present columns that an error lists.
const MAX_LISTED: usize = 20;
/// Characters of a name or a field that an error shows.
const MAX_SHOWN: usize = 40;

/// One wanted column.
pub(crate) struct Column {
    /// Its place in a row, counted from 0.
    pub(crate) index: usize,
    /// Name in errors.
    pub(crate) label: String,
    /// How it converts; [`Unit::Own`] for what stays as it is.
    pub(crate) unit: Unit,
    /// Name of its unit in errors.
    pub(crate) unit_text: String,
    /// Counts of a duty that is always on.
    pub(crate) full_scale: f64,
}

/// The wanted columns of a file.
pub(crate) struct Layout {
    pub(crate) n_columns: usize,
    /// Seconds from row to row, where no column says it.
    pub(crate) every_s: Option<f64>,
    pub(crate) time: Option<Column>,
    pub(crate) drive: Column,
    pub(crate) antagonist: Option<Column>,
    /// `None` where only the drive is wanted.
    pub(crate) output: Option<Column>,
    pub(crate) temperature: Option<Column>,
    pub(crate) ambient: Option<Column>,
    pub(crate) stress: Option<Column>,
    pub(crate) resistance: Option<ResistanceColumns>,
}

/// The columns of a resistance.
pub(crate) enum ResistanceColumns {
    Ohm(Column),
    VoltageOverCurrent { voltage: Column, current: Column },
}

impl ResistanceColumns {
    /// The column of its own, if it has one.
    fn own(&self) -> Option<&Column> {
        match self {
            Self::Ohm(column) => Some(column),
            Self::VoltageOverCurrent { .. } => None,
        }
    }
}

/// The first line of a file.
pub(crate) struct Header<'a> {
    pub(crate) file: &'a str,
    pub(crate) line: u64,
    /// The names; `None` where the first line holds numbers.
    pub(crate) names: Option<Vec<String>>,
    pub(crate) n_columns: usize,
}

/// Role of a column.
pub(crate) struct Role {
    /// Key in the `[columns]` table.
    pub(crate) key: &'static str,
    /// Normalized names, one of which is taken if the caller names none.
    defaults: &'static [&'static str],
    /// Stems that will do too, followed by anything.
    default_stems: &'static [&'static str],
    /// Units that suit, and the same in words.
    units: &'static [Unit],
    pub(crate) units_text: &'static str,
    /// True if any other unit is accepted, too, and kept as data.
    own_unit: bool,
}

const TEMPERATURE_UNITS: (&[Unit], &str) = (
    &[Unit::DegreeCelsius, Unit::Kelvin, Unit::DegreeFahrenheit],
    "degc, k or degf",
);

impl Role {
    const fn new(
        key: &'static str,
        defaults: &'static [&'static str],
        (units, units_text): (&'static [Unit], &'static str),
    ) -> Self {
        Self {
            key,
            defaults,
            default_stems: &[],
            units,
            units_text,
            own_unit: false,
        }
    }

    pub(crate) const TIME: Self = Self::new(
        "time",
        &["time_s", "time_ms", "time_us", "time_min", "time_h"],
        (
            &[
                Unit::Second,
                Unit::Millisecond,
                Unit::Microsecond,
                Unit::Minute,
                Unit::Hour,
            ],
            "s, ms, us, min or h",
        ),
    );
    pub(crate) const OUTPUT: Self = Self {
        default_stems: &["displacement", "position"],
        own_unit: true,
        ..Self::new("output", &["displacement_mm"], (&[], ""))
    };
    const TEMPERATURE: Self = Self::new(
        "temperature",
        &["temperature_degc", "temperature_c", "temperature_k"],
        TEMPERATURE_UNITS,
    );
    const AMBIENT: Self = Self::new(
        "ambient",
        &["ambient_degc", "ambient_c", "ambient_k"],
        TEMPERATURE_UNITS,
    );

    const STRESS: Self = Self::new(
        "stress",
        &["stress_mpa", "stress_pa"],
        (&[Unit::Megapascal, Unit::Pascal], "mpa or pa"),
    );
    const RESISTANCE: Self = Self::new("resistance", &["resistance_ohm"], (&[Unit::Ohm], "ohm"));
    const RESISTANCE_VOLTAGE: Self =
        Self::new("resistance.voltage", &["voltage_v"], (&[Unit::Volt], "v"));
    const RESISTANCE_CURRENT: Self = Self::new(
        "resistance.current",
        &["current_a", "current_ma"],
        (&[Unit::Ampere, Unit::Milliampere], "a or ma"),
    );

    /// True if a column of this role must state a unit.
    pub(crate) fn needs_unit(&self) -> bool {
        !self.own_unit && !self.units.contains(&Unit::One)
    }

    /// The one column of a default name.
    pub(crate) fn default_in(&self, names: &[String]) -> Option<usize> {
        let fits_exactly = |name: &str| self.defaults.contains(&name);
        let fits_by_stem = |name: &str| {
            self.default_stems.iter().any(|stem| {
                let rest = name.strip_prefix(stem);
                rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
            })
        };
        let place =
            |fits: &dyn Fn(&str) -> bool| names.iter().position(|name| fits(&normalized(name)));
        place(&fits_exactly).or_else(|| place(&fits_by_stem))
    }

    pub(crate) const fn drive(quantity: Quantity) -> Self {
        let (defaults, units): (&'static [&'static str], _) = match quantity {
            Quantity::Current => {
                let units: &[Unit] = &[Unit::Ampere, Unit::Milliampere];
                (&["current_a", "current_ma"], (units, "a or ma"))
            }
            Quantity::Duty => {
                let units: &[Unit] = &[Unit::One, Unit::Percent, Unit::Counts];
                (
                    &["duty", "duty_1", "duty_%", "duty_percent"],
                    (units, "1, %, or counts with full_scale"),
                )
            }
            Quantity::Voltage => {
                let units: &[Unit] = &[Unit::Volt, Unit::Millivolt];
                (&["voltage_v", "voltage_mv"], (units, "v or mv"))
            }
            Quantity::Power => {
                let units: &[Unit] = &[Unit::Watt, Unit::Milliwatt];
                (&["power_w", "power_mw"], (units, "w or mw"))
            }
            Quantity::Temperature => (Self::TEMPERATURE.defaults, TEMPERATURE_UNITS),
        };
        Self {
            // The input of a static loop may be anything: a stress, the voltage of a source.
            own_unit: matches!(quantity, Quantity::Temperature),
            ..Self::new("drive", defaults, units)
        }
    }
}

/// Columns for which a file is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    DriveAndOutput,
    /// An output, if there is one, is not looked at.
    Drive,
}

impl Layout {
    /// The columns that `options` ask for, and those whose rows follow theirs.
    pub(crate) fn all(
        header: &Header<'_>,
        options: &ReadOptions,
        wanted: Wanted,
    ) -> Result<Vec<Self>, RecordingError> {
        let ways = std::iter::successors(Some(&options.columns), |way| way.then.as_deref());
        let layouts = ways
            .map(|columns| Self::new(header, options, columns, wanted))
            .collect::<Result<Vec<_>, _>>()?;
        let differs = layouts[1..]
            .iter()
            .find_map(|then| layouts[0].difference(then));
        match differs {
            None => Ok(layouts),
            Some(what) => Err(RecordingError::UnequalColumns {
                file: header.file.to_owned(),
                line: header.line,
                what,
            }),
        }
    }

    /// In which column another one's rows could not follow; time would have to start anew.
    fn difference(&self, then: &Self) -> Option<&'static str> {
        let drive_unit = |layout: &Self| match layout.drive.unit {
            Unit::Own => Some(layout.drive.unit_text.clone()),
            _ => None,
        };
        let output_unit = |layout: &Self| layout.output.as_ref().map(|c| c.unit_text.clone());
        let is_ohm = |layout: &Self| layout.resistance.as_ref().map(|r| r.own().is_some());
        [
            (
                "time",
                self.time.is_none() && then.time.is_none() && self.every_s.is_none(),
            ),
            ("drive", drive_unit(self) == drive_unit(then)),
            (
                "antagonist",
                self.antagonist.is_some() == then.antagonist.is_some(),
            ),
            ("output", output_unit(self) == output_unit(then)),
            (
                "temperature",
                self.temperature.is_some() == then.temperature.is_some(),
            ),
            ("ambient", self.ambient.is_some() == then.ambient.is_some()),
            ("stress", self.stress.is_some() == then.stress.is_some()),
            ("resistance", is_ohm(self) == is_ohm(then)),
        ]
        .into_iter()
        .find_map(|(what, same)| (!same).then_some(what))
    }

    /// Finds the wanted columns.
    fn new(
        header: &Header<'_>,
        options: &ReadOptions,
        columns: &Columns,
        wanted: Wanted,
    ) -> Result<Self, RecordingError> {
        let drive_is_temperature = options.drive_quantity == Quantity::Temperature;
        let drive = Role::drive(options.drive_quantity);

        let every_s = columns.time.as_ref().and_then(|spec| match spec.key {
            ColumnKey::EveryS(every_s) => Some(every_s),
            _ => None,
        });
        let time_spec = columns.time.as_ref().filter(|_| every_s.is_none());
        let time = match header.column(&Role::TIME, time_spec)? {
            _ if every_s.is_some() => None,
            None if !(options.allow_untimed || drive_is_temperature) => {
                return Err(header.missing_default(&Role::TIME));
            }
            time => time,
        };
        if columns.temperature.is_some() && drive_is_temperature {
            return Err(RecordingError::TwoTemperatures {
                file: header.file.to_owned(),
            });
        }
        if columns.antagonist.is_some() && drive_is_temperature {
            return Err(RecordingError::StaticAntagonist {
                file: header.file.to_owned(),
            });
        }
        // By its key alone: that there are two actuators is of the rig, not of a file.
        let antagonist = Role {
            key: "antagonist",
            ..drive
        };
        let antagonist = match &columns.antagonist {
            None => None,
            spec => header.column(&antagonist, spec.as_ref())?,
        };
        let drive = header
            .column(&drive, columns.drive.as_ref())?
            .ok_or_else(|| header.missing_default(&drive))?;
        let output = match wanted {
            Wanted::Drive => None,
            Wanted::DriveAndOutput => Some(
                header
                    .column(&Role::OUTPUT, columns.output.as_ref())?
                    .ok_or_else(|| header.missing_default(&Role::OUTPUT))?,
            ),
        };
        // A drive or an output may be a temperature, a stress or a resistance itself.
        let is_taken = |column: &Column| {
            let taken = [Some(&drive), antagonist.as_ref(), output.as_ref()];
            taken
                .into_iter()
                .flatten()
                .any(|other| other.index == column.index)
        };
        let beside = |role: &Role, spec: Option<&ColumnSpec>| {
            let column = header.column(role, spec)?;
            Ok(column.filter(|column| spec.is_some() || !is_taken(column)))
        };
        let layout = Self {
            n_columns: header.n_columns,
            every_s,
            time,
            temperature: match drive_is_temperature {
                true => None,
                false => beside(&Role::TEMPERATURE, columns.temperature.as_ref())?,
            },
            ambient: header.column(&Role::AMBIENT, columns.ambient.as_ref())?,
            stress: beside(&Role::STRESS, columns.stress.as_ref())?,
            resistance: match &columns.resistance {
                None => beside(&Role::RESISTANCE, None)?.map(ResistanceColumns::Ohm),
                Some(ResistanceSpec::Column(spec)) => header
                    .column(&Role::RESISTANCE, Some(spec))?
                    .map(ResistanceColumns::Ohm),
                Some(ResistanceSpec::VoltageOverCurrent { voltage, current }) => {
                    let voltage = header.column(&Role::RESISTANCE_VOLTAGE, Some(voltage))?;
                    let current = header.column(&Role::RESISTANCE_CURRENT, Some(current))?;
                    voltage.zip(current).map(|(voltage, current)| {
                        ResistanceColumns::VoltageOverCurrent { voltage, current }
                    })
                }
            },
            drive,
            antagonist,
            output,
        };
        layout.check_distinct(header)?;
        Ok(layout)
    }

    fn check_distinct(&self, header: &Header<'_>) -> Result<(), RecordingError> {
        let all = [
            ("time", self.time.as_ref()),
            ("drive", Some(&self.drive)),
            ("antagonist", self.antagonist.as_ref()),
            ("output", self.output.as_ref()),
            ("temperature", self.temperature.as_ref()),
            ("ambient", self.ambient.as_ref()),
            ("stress", self.stress.as_ref()),
            (
                "resistance",
                self.resistance.as_ref().and_then(ResistanceColumns::own),
            ),
        ];
        for (k, (second, column)) in all.iter().enumerate() {
            let Some(column) = column else { continue };
            let same = |other: &Option<&Column>| other.is_some_and(|o| o.index == column.index);
            if let Some((first, _)) = all[..k].iter().find(|(_, other)| same(other)) {
                return Err(RecordingError::SharedColumn {
                    file: header.file.to_owned(),
                    line: header.line,
                    column: column.label.clone(),
                    first,
                    second,
                });
            }
        }
        Ok(())
    }
}

impl Header<'_> {
    /// The column for `role`; `None` if the caller names none and no default is there.
    fn column(
        &self,
        role: &Role,
        spec: Option<&ColumnSpec>,
    ) -> Result<Option<Column>, RecordingError> {
        let Some(index) = self.locate(role, spec.map(|spec| &spec.key))? else {
            return Ok(None);
        };
        let name = self.names.as_ref().and_then(|names| names.get(index));
        let label = self.label(index);
        let unit_text = spec
            .and_then(|spec| spec.unit.as_deref())
            .or_else(|| name.and_then(|name| split_name(name).1));
        let (file, line) = (self.file.to_owned(), self.line);
        let full_scale = spec.and_then(|spec| spec.full_scale);
        let (unit, unit_text) = match (unit_text, unit_text.and_then(Unit::parse)) {
            (_, Some(Unit::Counts))
                if full_scale.is_none() && role.units.contains(&Unit::Counts) =>
            {
                return Err(RecordingError::MissingFullScale {
                    file,
                    line,
                    column: label,
                });
            }
            (_, Some(unit)) if role.units.contains(&unit) => (unit, unit.symbol().to_owned()),
            (Some(text), _) if role.own_unit => (Unit::Own, output_symbol(text)),
            (None, _) if role.own_unit && role.units.is_empty() => (Unit::Own, output_symbol("")),
            // A duty has no unit to name.
            (None, _) if role.units.contains(&Unit::One) => (Unit::One, "1".to_owned()),
            (None, _) => {
                let (role, accepted) = (role.key, role.units_text);
                return Err(RecordingError::MissingUnit {
                    file,
                    line,
                    role,
                    column: label,
                    accepted,
                });
            }
            (Some(text), _) => {
                return Err(RecordingError::WrongUnit {
                    file,
                    line,
                    role: role.key,
                    column: label,
                    unit: shown(text),
                    accepted: role.units_text,
                });
            }
        };
        Ok(Some(Column {
            index,
            label,
            unit,
            unit_text,
            full_scale: full_scale.unwrap_or(1.0),
        }))
    }

    /// Where the column for `role` stands, counted from 0.
    fn locate(
        &self,
        role: &Role,
        key: Option<&ColumnKey>,
    ) -> Result<Option<usize>, RecordingError> {
        match (key, &self.names) {
            (Some(ColumnKey::Number(number)), _) => match number.checked_sub(1) {
                Some(index) if index < self.n_columns => Ok(Some(index)),
                _ => Err(self.missing(role, number.to_string())),
            },
            (Some(ColumnKey::EveryS(every_s)), _) => {
                Err(self.missing(role, format!("{{ every_s = {every_s} }}")))
            }
            (Some(ColumnKey::Name(name)), None) => Err(self.no_header(role, name)),
            (Some(ColumnKey::Name(name)), Some(names)) => {
                let wanted = normalized(name);
                let found = match self.only(role, name, names, |present| present == wanted)? {
                    None => self.only_stem(role, name, names)?,
                    found => found,
                };
                match found {
                    None => Err(self.missing(role, format!("\"{}\"", shown(name)))),
                    found => Ok(found),
                }
            }
            (None, None) => Ok(None),
            (None, Some(names)) => {
                let wanted = role.defaults[0];
                let found = self.only(role, wanted, names, |present| {
                    role.defaults.contains(&present)
                })?;
                if found.is_some() || role.default_stems.is_empty() {
                    return Ok(found);
                }
                self.only(role, wanted, names, |present| {
                    role.default_stems.iter().any(|stem| {
                        let rest = present.strip_prefix(stem);
                        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
                    })
                })
            }
        }
    }

    /// The one column that is called `wanted` and has its unit behind that, if any.
    fn only_stem(
        &self,
        role: &Role,
        wanted: &str,
        names: &[String],
    ) -> Result<Option<usize>, RecordingError> {
        let lower = wanted.trim().to_lowercase();
        self.only(role, wanted, names, |present| {
            split_name(present).1.is_some() && split_name(present).0 == lower
        })
    }

    /// The one column whose normalized name `fits`, if any.
    fn only(
        &self,
        role: &Role,
        wanted: &str,
        names: &[String],
        fits: impl Fn(&str) -> bool,
    ) -> Result<Option<usize>, RecordingError> {
        let mut fitting = names
            .iter()
            .enumerate()
            .filter(|(_, name)| fits(&normalized(name)))
            .map(|(k, _)| k);
        let Some(first) = fitting.next() else {
            return Ok(None);
        };
        let others: Vec<usize> = fitting.collect();
        if others.is_empty() {
            return Ok(Some(first));
        }
        let described = std::iter::once(first)
            .chain(others)
            .map(|index| format!("{} (column {})", self.label(index), index + 1));
        Err(RecordingError::DoubledColumn {
            file: self.file.to_owned(),
            line: self.line,
            role: role.key,
            wanted: shown(wanted),
            fitting: listed(described),
        })
    }

    fn label(&self, index: usize) -> String {
        match self.names.as_ref().and_then(|names| names.get(index)) {
            Some(name) if !name.is_empty() => shown(name),
            _ => format!("column {}", index + 1),
        }
    }

    fn missing_default(&self, role: &Role) -> RecordingError {
        let wanted = role.defaults[0];
        match &self.names {
            Some(_) => self.missing(role, format!("\"{wanted}\"")),
            None => self.no_header(role, wanted),
        }
    }

    fn missing(&self, role: &Role, wanted: String) -> RecordingError {
        RecordingError::MissingColumn {
            file: self.file.to_owned(),
            line: self.line,
            role: role.key,
            wanted,
            n_columns: self.n_columns,
            present: listed((0..self.n_columns).map(|index| self.label(index))),
        }
    }

    fn no_header(&self, role: &Role, wanted: &str) -> RecordingError {
        RecordingError::NoHeader {
            file: self.file.to_owned(),
            line: self.line,
            role: role.key,
            wanted: shown(wanted),
        }
    }
}

/// Text from a file as an error shows it: on one line, and not all of a long one.
pub(crate) fn shown(text: &str) -> String {
    let mut shown = String::new();
    for (k, c) in text.chars().enumerate() {
        if k == MAX_SHOWN {
            shown.push('…');
            break;
        }
        if c.is_control() {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}

fn listed(mut items: impl Iterator<Item = String>) -> String {
    let mut list: Vec<String> = items.by_ref().take(MAX_LISTED).collect();
    if items.next().is_some() {
        list.push("…".to_owned());
    }
    list.join(", ")
}
