//! `[recordings."run3.csv"]`: selection and preprocessing of a recording, as the rod file writes it.

use std::collections::BTreeMap;

use identify::{Bounds, RecordingUse};
use serde::Deserialize;
use toml::Spanned;

use crate::RigFileError;
use crate::rod_file::ambient;
use crate::source::Source;

/// [`RecordingUse`] as the file writes it.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RecordingTable {
    window_s: Option<[Spanned<f64>; 2]>,
    exclude_s: Vec<[Spanned<f64>; 2]>,
    decimate: Option<Spanned<i64>>,
    detrend: bool,
    ambient_degc: Option<Spanned<f64>>,
}

/// Checks what a file says of its recordings.
pub(crate) fn uses(
    source: &Source<'_>,
    recordings: &BTreeMap<String, RecordingTable>,
) -> Result<BTreeMap<String, RecordingUse>, RigFileError> {
    let checked = recordings.iter().map(|(name, table)| {
        let key = |key: &str| format!("recordings.\"{name}\".{key}");
        let span = |name: &str, range: &[Spanned<f64>; 2]| {
            let Bounds { lower, upper } = source.rising(&key(name), range)?;
            Ok::<_, RigFileError>([lower, upper])
        };
        let window_s = table.window_s.as_ref();
        let exclude_s = table.exclude_s.iter();
        let decimate = table.decimate.as_ref().map(|wished| {
            let n = usize::try_from(*wished.get_ref()).ok();
            n.filter(|n| *n >= 2).ok_or_else(|| {
                let value = Spanned::new(wished.span(), *wished.get_ref() as f64);
                source.value(&key("decimate"), &value, "must be a whole number ≥ 2")
            })
        });
        let used = RecordingUse {
            window_s: window_s.map(|range| span("window_s", range)).transpose()?,
            exclude_s: exclude_s
                .map(|range| span("exclude_s", range))
                .collect::<Result<_, _>>()?,
            decimate: decimate.transpose()?,
            detrend: table.detrend,
            ambient_degc: ambient(source, &key("ambient_degc"), &table.ambient_degc)?,
        };
        Ok((name.clone(), used))
    });
    checked.collect()
}
