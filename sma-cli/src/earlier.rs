//! An earlier model as the start of a fit.

use std::path::Path;

use identify::RigModel;
use missing_physics::known_effects;
use recording::Recording;
use rig_files::model_file;

/// Where a fit of the baseline model starts besides its own searches, and what to say of it.
#[derive(Debug, Default)]
pub(crate) struct Earlier {
    /// As [`FitConfig::from`](identify::FitConfig::from) takes it.
    pub(crate) from: Vec<Vec<f64>>,
    pub(crate) note: Option<String>,
}

impl Earlier {
    /// Takes the baseline part of a model file, if one is given.
    pub(crate) fn read(
        path: Option<&Path>,
        model: &RigModel,
        training: &[Recording],
    ) -> anyhow::Result<Self> {
        let Some(path) = path else {
            return Ok(Self::default());
        };
        let saved = model_file::read_with(path, &known_effects)?;
        Ok(Self {
            from: vec![saved.coordinates(model, training)?],
            note: saved.effects.map(|effects| {
                format!(
                    "{} has effects ({}): its baseline part is the start, the baseline model is fitted",
                    path.display(),
                    effects.names().join(", ")
                )
            }),
        })
    }
}
