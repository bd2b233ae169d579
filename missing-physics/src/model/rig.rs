//! Setting of a rig beyond its baseline, from its rod file.

use std::f64::consts::PI;

use identify::Rod;

use crate::Setting;

/// Properties of a rig that effects need, from its rod file: mass and surface per meter where diameter and density are
/// given, the share of leads, and the length in the unit of the output where a lever is given.
///
/// Without a lever, coefficients per length are for an assumed strain.
#[must_use]
pub fn setting_of_rod(rod: &Rod, output_unit: &str) -> Setting {
    let lever = rod.load.and_then(|load| load.lever);
    let per_m = match output_unit {
        "m" => Some(1.0),
        "mm" => Some(1e3),
        "um" | "µm" => Some(1e6),
        _ => None,
    };
    Setting {
        mass_kg_per_m: rod
            .section_m2()
            .zip(rod.density_kg_per_m3)
            .map(|(section_m2, density)| section_m2 * density),
        surface_m2_per_m: rod.diameter_m.map(|diameter_m| PI * diameter_m),
        lead_share: rod.lead_share(),
        length_output: rod
            .length_m
            .zip(lever)
            .zip(per_m)
            .map(|((length_m, lever), per_m)| length_m * lever.abs() * per_m),
        ..Setting::default()
    }
}
