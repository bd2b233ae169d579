//! A case with its files read and the baseline model fitted, for tests.

use std::ops::ControlFlow;

use identify::{FitConfig, fit, validate};
use missing_physics::Stage;

use crate::folder::Folder;
use crate::verdict::Opened;
use crate::{Case, CaseId, Family};

pub(super) fn opened(family: Family, number: u64) -> (Opened, Stage) {
    let case = Case::drawn("a seed", CaseId::guided(family, number));
    let folder = tempfile::tempdir().unwrap();
    let written = Folder::write(folder.path(), &case, &case.record().unwrap()).unwrap();
    let files = Opened::read(&written).unwrap();
    let config = FitConfig {
        starts: 2,
        ..FitConfig::default()
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fit = fit(&files.base, &files.training, &config, go_on).unwrap();
    let validated = files.unseen.iter();
    let plain = Stage {
        validated: validated
            .map(|recording| validate(&files.base, &fit, recording).unwrap())
            .collect(),
        predicted_rmse: None,
        fit,
    };
    (files, plain)
}
