//! Keys of `[drive]` for supply and leads.

use identify::{IdentifyError, Supply};
use recording::Quantity;
use toml::Spanned;

use crate::RigFileError;
use crate::rod_file::DriveTable;
use crate::source::Source;

/// Properties of the rig that the supply depends on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Supplied {
    pub(crate) drive_kind: Quantity,
    pub(crate) length_m: Option<f64>,
    pub(crate) resistance_ohm_per_m: Option<f64>,
}

impl Supplied {
    /// The rod's own resistance, Ω, or the key that it lacks.
    fn rod_ohm(&self, file: &str, why: &'static str) -> Result<f64, IdentifyError> {
        let missing = |key| IdentifyError::Missing {
            file: file.to_owned(),
            key,
            why,
        };
        let length_m = self.length_m.ok_or_else(|| missing("rod.length_mm"))?;
        let ohm_per_m = self.resistance_ohm_per_m;
        Ok(length_m * ohm_per_m.ok_or_else(|| missing("rod.resistance_ohm_per_m"))?)
    }
}

/// Checks what a file says of supply and leads.
pub(crate) fn supply(
    source: &Source<'_>,
    keys: &DriveTable,
    rig: &Supplied,
) -> Result<Supply, RigFileError> {
    let lead_resistance_ohm = leads(source, &keys.lead_resistance_ohm, rig)?;
    let limits = [
        limit(source, &keys.limit, rig.drive_kind)?,
        of_current(source, &keys.current_max_a, rig, lead_resistance_ohm)?,
        of_voltage(source, &keys.voltage_max_v, rig)?,
    ];
    // Of two limits the lower one acts.
    Ok(Supply {
        limit: limits.into_iter().flatten().reduce(f64::min),
        lead_resistance_ohm,
    })
}

fn leads(
    source: &Source<'_>,
    value: &Option<Spanned<f64>>,
    rig: &Supplied,
) -> Result<Option<f64>, RigFileError> {
    const KEY: &str = "drive.lead_resistance_ohm";
    let (Some(lead_ohm), Some(spanned)) = (source.positive(KEY, value)?, value) else {
        return Ok(None);
    };
    let reason = match rig.drive_kind {
        Quantity::Voltage | Quantity::Duty => {
            rig.rod_ohm(
                source.file,
                "leads take their share of the voltage beside the rod's own resistance, length times resistance per meter",
            )?;
            return Ok(Some(lead_ohm));
        }
        Quantity::Current => {
            "only for kind = \"voltage\" or \"duty\": a current is the same in the rod, whatever the leads"
        }
        Quantity::Power => {
            "only for kind = \"voltage\" or \"duty\": a power is that in the rod; take off what the leads heat"
        }
        Quantity::Temperature => {
            "only for kind = \"voltage\" or \"duty\": a static loop has no supply"
        }
    };
    Err(source.value(KEY, spanned, reason))
}

fn limit(
    source: &Source<'_>,
    value: &Option<Spanned<f64>>,
    kind: Quantity,
) -> Result<Option<f64>, RigFileError> {
    const KEY: &str = "drive.limit";
    match (source.positive(KEY, value)?, value) {
        (Some(_), Some(spanned)) if kind == Quantity::Temperature => {
            Err(source.value(KEY, spanned, "a static loop has no supply that saturates"))
        }
        (Some(duty), Some(spanned)) if kind == Quantity::Duty && duty > 1.0 => {
            Err(source.value(KEY, spanned, "must lie from 0 to 1, as a duty does"))
        }
        (limit, _) => Ok(limit),
    }
}

/// The voltage at which a supply of voltages has no more current.
fn of_current(
    source: &Source<'_>,
    value: &Option<Spanned<f64>>,
    rig: &Supplied,
    lead_ohm: Option<f64>,
) -> Result<Option<f64>, RigFileError> {
    const KEY: &str = "drive.current_max_a";
    let (Some(current_a), Some(spanned)) = (source.positive(KEY, value)?, value) else {
        return Ok(None);
    };
    if rig.drive_kind != Quantity::Voltage {
        let reason = "only for kind = \"voltage\"; of another drive say limit, in its own unit";
        return Err(source.value(KEY, spanned, reason));
    }
    let why = "a largest current is a voltage by the resistance of the rod, length times resistance per meter";
    let rod_ohm = rig.rod_ohm(source.file, why)?;
    Ok(Some(current_a * (rod_ohm + lead_ohm.unwrap_or(0.0))))
}

/// The current at which a supply of currents has no more voltage.
fn of_voltage(
    source: &Source<'_>,
    value: &Option<Spanned<f64>>,
    rig: &Supplied,
) -> Result<Option<f64>, RigFileError> {
    const KEY: &str = "drive.voltage_max_v";
    let (Some(voltage_v), Some(spanned)) = (source.positive(KEY, value)?, value) else {
        return Ok(None);
    };
    if rig.drive_kind != Quantity::Current {
        let reason = "only for kind = \"current\"; of another drive say limit, in its own unit";
        return Err(source.value(KEY, spanned, reason));
    }
    let why = "a largest voltage is a current by the resistance of the rod, length times resistance per meter";
    Ok(Some(voltage_v / rig.rod_ohm(source.file, why)?))
}
