use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use truth_plant::{Addition, TruthPlant};

use crate::sizes::size;

/// Answer of a case, which is sealed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Concealed additions; empty in a clean case.
    pub concealed: Vec<Concealed>,
    /// Family of the loop.
    pub hysteresis: String,
    /// Kind of the noise.
    pub noise: String,
    /// Which plant made the recordings: `volumes` or `lumped`; `None` where there was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plant: Option<String>,
    /// How the rig was recorded; `None` where all were as the guide asks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
}

/// A concealed piece of physics.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Concealed {
    /// Its name in the truth plant.
    pub addition: String,
    /// Its name in the catalogue; `None` if it stands in none.
    pub effect: Option<String>,
    /// Size over the usual one.
    pub size: f64,
    /// The parameter that means the same in truth and catalogue, where there is one.
    pub parameter: Option<True>,
}

/// The true value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct True {
    /// Its name in the catalogue.
    pub name: String,
    /// Its value.
    pub value: f64,
}

impl Concealed {
    /// An addition of a plant that has it.
    pub(crate) fn of(addition: Addition, size: f64, plant: &TruthPlant) -> Self {
        let parameter = parameter(addition, plant).map(|(name, value)| True {
            name: name.to_owned(),
            value,
        });
        Self {
            addition: kebab(&format!("{addition:?}")),
            effect: addition.catalogue_id().map(str::to_owned),
            size,
            parameter,
        }
    }
}

/// Parameter that means the same in the truth and in the catalogue: its name and value.
fn parameter(addition: Addition, plant: &TruthPlant) -> Option<(&'static str, f64)> {
    let name = match addition {
        Addition::SupplyLag => "supply_lag_s",
        Addition::SupplyDeadTime | Addition::OutputDelay => "dead_time_s",
        Addition::OutputFilter => "output_lag_s",
        Addition::LatentHeat => "latent_heat_j_per_kg",
        Addition::Radiation => "emissivity",
        Addition::Thermocouple => "thermocouple_lag_s",
        Addition::StressCoupling => "stress_shift_k",
        _ => return None,
    };
    Some((name, size(addition, plant)?.value))
}

fn kebab(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push('-');
        }
        text.extend(letter.to_lowercase());
    }
    text
}

/// Seal, published before the first diagnosis: SHA-256 over all answers of a plan in their order, each as JSON in a line of
/// its own, in hexadecimal. It shows later that no answer has changed.
#[must_use]
pub fn seal<'a>(answers: impl IntoIterator<Item = &'a Answer>) -> String {
    let mut digest = Sha256::new();
    for answer in answers {
        // An answer holds no map with keys that are no text, and no number that is none.
        digest.update(serde_json::to_string(answer).unwrap_or_default());
        digest.update("\n");
    }
    hex(&digest.finalize())
}

/// Bytes in hexadecimal.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(size: f64) -> Answer {
        let plant = TruthPlant::default();
        Answer {
            concealed: vec![Concealed::of(Addition::LatentHeat, size, &plant)],
            hysteresis: "l2p".to_owned(),
            noise: "white".to_owned(),
            plant: None,
            recording: None,
        }
    }

    #[test]
    fn another_answer_or_another_order_has_another_seal() {
        let of = |sizes: [f64; 2]| seal(&sizes.map(answer));
        assert_eq!(of([1.0, 0.5]), of([1.0, 0.5]));
        assert_ne!(of([1.0, 0.5]), of([0.5, 1.0]));
        assert_ne!(of([1.0, 0.5]), of([1.0, 2.0]));
        assert_ne!(of([1.0, 1.0]), seal(&[answer(1.0)]));
    }

    #[test]
    fn a_seal_holds_after_the_answer_was_written_and_read() {
        for k in 0..2000 {
            let mut written = answer(1.0);
            let value = 13.6 + f64::from(k) / 3.0_f64.sqrt();
            written.concealed[0].parameter = Some(True {
                name: "latent_heat_j_per_kg".to_owned(),
                value,
            });
            let text = serde_json::to_string(&written).unwrap();
            let read: Answer = serde_json::from_str(&text).unwrap();
            assert_eq!(seal(&[read]), seal(&[written]), "{value}");
        }
    }

    #[test]
    fn additions_have_readable_names() {
        assert_eq!(answer(1.0).concealed[0].addition, "latent-heat");
        assert_eq!(kebab("ConvectionDip"), "convection-dip");
    }
}
