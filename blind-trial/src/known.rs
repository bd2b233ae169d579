use std::fmt::Write;

use rand::Rng;
use truth_plant::{DriveKind, TruthPlant};

use crate::chance::Chance;

/// Knowledge of the user about the rig, and the columns that he records: drawn without a look at what is concealed.
///
/// | known | of so many rigs |
/// | --- | --- |
/// | temperature of the rod | 3 in 10 |
/// | temperature of the surroundings, as a column | 3 in 10 |
/// | diameter and length | all |
/// | the spring | 1 in 2 |
/// | the lever | 8 in 10 |
/// | specific heat: exactly, as a range, not at all | 6, 3, 1 in 10 |
/// | resistance | 9 in 10 |
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Known {
    pub(crate) dimensions: bool,
    pub(crate) temperature: bool,
    pub(crate) ambient: bool,
    pub(crate) spring: bool,
    pub(crate) lever: bool,
    pub(crate) specific_heat: SpecificHeat,
    pub(crate) resistance: bool,
}

/// How well the specific heat is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SpecificHeat {
    Exactly,
    AsRange,
    NotAtAll,
}

impl Known {
    pub(crate) fn drawn(chance: &Chance) -> Self {
        let mut random = chance.of("known");
        let mut is = |share: f64| random.random::<f64>() < share;
        Self {
            dimensions: true,
            temperature: is(0.3),
            ambient: is(0.3),
            spring: is(0.5),
            lever: is(0.8),
            resistance: is(0.9),
            specific_heat: match (is(0.6), is(0.75)) {
                (true, _) => SpecificHeat::Exactly,
                (false, true) => SpecificHeat::AsRange,
                (false, false) => SpecificHeat::NotAtAll,
            },
        }
    }

    /// True if sizes are in their true units.
    pub(crate) fn has_scale(&self) -> bool {
        self.dimensions && self.resistance && self.specific_heat == SpecificHeat::Exactly
    }

    /// The rod file of a rig whose drive goes to `largest_drive`.
    pub(crate) fn rod_file(&self, plant: &TruthPlant, largest_drive: f64) -> String {
        let rod = &plant.rod;
        let mut text = String::new();
        let mut line = |text_of_line: String| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{text_of_line}");
        };
        line("[rod]".to_owned());
        if self.dimensions {
            line(format!("diameter_mm = {:.5}", 1e3 * rod.diameter_m));
            line(format!("length_mm = {:.4}", 1e3 * rod.length_m));
            line(format!("density_kg_per_m3 = {:.3}", rod.density_kg_per_m3));
        }
        let heat = rod.specific_heat_j_per_kg_k;
        match self.specific_heat {
            SpecificHeat::Exactly => line(format!("specific_heat_j_per_kg_k = {heat:.4}")),
            SpecificHeat::AsRange => line(format!(
                "specific_heat_j_per_kg_k = {{ value = {heat:.4}, range = [{:.1}, {:.1}] }}",
                0.9 * heat,
                1.1 * heat
            )),
            SpecificHeat::NotAtAll => {}
        }
        if self.resistance {
            line(format!(
                "resistance_ohm_per_m = {:.6}",
                rod.resistance_ohm_per_m
            ));
        }
        line("\n[surroundings]".to_owned());
        line(format!("ambient_degc = {:.4}", plant.ambient_degc));
        line("\n[drive]".to_owned());
        line(format!("kind = \"{}\"", kind(&plant.drive)));
        if let DriveKind::Duty { supply_v } = plant.drive {
            line(format!("supply_v = {supply_v}"));
        }
        if self.spring || self.lever {
            line("\n[load]".to_owned());
        }
        if let Some(spring) = plant.bias_spring.filter(|_| self.spring) {
            line(format!(
                "spring_n_per_mm = {:.6}",
                1e-3 * spring.stiffness_n_per_m
            ));
            line(format!("preload_n = {:.4}", spring.preload_n));
        }
        if self.lever {
            line("lever = 1.0".to_owned());
        }
        line("\n[limits]".to_owned());
        let highest = match plant.drive {
            DriveKind::Duty { .. } => 1.0,
            _ => f64::INFINITY,
        };
        line(format!(
            "drive_max = {:.6}",
            (1.2 * largest_drive).min(highest)
        ));
        line("\n[columns]".to_owned());
        line(format!("drive = \"{}\"", drive_column(&plant.drive)));
        line("output = { name = \"displacement_mm\", unit = \"mm\" }".to_owned());
        text
    }
}

fn kind(drive: &DriveKind) -> &'static str {
    match drive {
        DriveKind::Current => "current",
        DriveKind::Duty { .. } => "duty",
        DriveKind::Voltage => "voltage",
        DriveKind::Power => "power",
    }
}

/// Name of the column of the drive.
pub(crate) fn drive_column(drive: &DriveKind) -> &'static str {
    match drive {
        DriveKind::Current => "current_a",
        DriveKind::Duty { .. } => "duty",
        DriveKind::Voltage => "voltage_v",
        DriveKind::Power => "power_w",
    }
}
