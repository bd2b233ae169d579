//! The recordings of a call: read, and what is odd about them.

use std::path::{Path, PathBuf};

use identify::Rod;
use recording::{
    ReadOptions, Recording, RecordingError, Warning, drive_noise, mended, slips, stuck, wild,
};

use crate::WorkbenchError;
use crate::near_copy::is_near_copy;
use crate::report::inspected::{MOST_GAPS, gaps_at_once};
use crate::report::number::significant;

/// Reads recordings as a rod file describes them: in the order of their files, several of a file from the middle of which a span is
/// left out.
///
/// # Errors
///
/// [`WorkbenchError`] naming what is refused.
pub fn read_all(rod: &Rod, paths: &[PathBuf]) -> Result<Vec<Recording>, WorkbenchError> {
    let options = rod.read_options();
    let mut all = Vec::new();
    for path in paths {
        let read = recording::read_csv(path, &options)?;
        all.extend(as_fitted(rod, path, read)?);
    }
    Ok(all)
}

/// The parts of a recording as they are fitted: what a rod file uses of it, [`mended`] unless the file says otherwise, with fewer rows or without a
/// drift if it says so.
///
/// # Errors
///
/// As [`in_its_window`]; [`RecordingError::DecimationOutOfRange`], [`RecordingError::NoRestAtBothEnds`].
pub fn as_fitted(
    rod: &Rod,
    path: &Path,
    recording: Recording,
) -> Result<Vec<Recording>, RecordingError> {
    let wish = rod.use_of(path);
    let as_fitted = |part: Recording| {
        let mut used = part;
        if rod.columns.may_mend() {
            used = mended(&used);
        }
        if let Some(n) = wish.decimate {
            used = used.decimated(n)?;
        }
        if wish.detrend {
            used = used.detrended()?;
        }
        Ok(used)
    };
    let parts = in_its_window(rod, path, recording)?;
    parts.into_iter().map(as_fitted).collect()
}

/// A recording as it is simulated, and a note if it is not as it would be fitted: the drive in a span that is left out of the middle is
/// known, and what comes after depends on it.
///
/// # Errors
///
/// As [`as_fitted`].
pub fn as_simulated(
    rod: &Rod,
    path: &Path,
    recording: Recording,
) -> Result<(Recording, Option<String>), RecordingError> {
    let mut parts = as_fitted(rod, path, recording.clone())?;
    if let (Some(only), true) = (parts.pop(), parts.is_empty()) {
        return Ok((only, None));
    }
    let mut whole = rod.clone();
    let mut wish = rod.use_of(path);
    wish.exclude_s.clear();
    whole.uses.insert(path.display().to_string(), wish);
    let note = format!(
        "{}: spans that are left out of a fit are simulated with what is around them",
        recording.name()
    );
    let parts = as_fitted(&whole, path, recording)?.into_iter();
    match { parts }.next() {
        Some(whole) => Ok((whole, Some(note))),
        None => unreachable!("no span is left out"),
    }
}

/// The parts of a recording that a rod file uses, as they were recorded; one, unless a span is left out of the middle.
///
/// # Errors
///
/// [`RecordingError::RangeOutside`], [`RecordingError::NoTime`], [`RecordingError::AmbientTwice`].
pub fn in_its_window(
    rod: &Rod,
    path: &Path,
    recording: Recording,
) -> Result<Vec<Recording>, RecordingError> {
    let wish = rod.use_of(path);
    let mut used = recording;
    if let Some([start_s, end_s]) = wish.window_s {
        used = used.within(start_s, end_s)?;
    }
    if let Some(ambient_degc) = wish.ambient_degc {
        used = used.surrounded_by(ambient_degc)?;
    }
    if wish.exclude_s.is_empty() {
        return Ok(vec![used]);
    }
    used.excluding(&wish.exclude_s)
}

/// Reads a recording, or a drive alone where there is no output; whether there is.
///
/// # Errors
///
/// [`WorkbenchError`] naming what is refused.
pub fn read_perhaps_without_output(
    path: &Path,
    options: &ReadOptions,
) -> Result<(Recording, bool), RecordingError> {
    match recording::read_csv(path, options) {
        Ok(recording) => Ok((recording, true)),
        Err(RecordingError::MissingColumn { role: "output", .. }) => {
            Ok((recording::read_drive_csv(path, options)?, false))
        }
        Err(other) => Err(other),
    }
}

/// True if a recording holds the data of a training recording, or data that differ from them by less than noise.
#[must_use]
pub fn is_trained_on(recording: &Recording, training: &[Recording]) -> bool {
    twin(recording, training).is_some()
}

/// Training recordings, each measurement once, and a note on each copy that is left out: it would count twice, and a block of it would
/// be predicted from its own noise in the other.
#[must_use]
pub fn each_once(recordings: Vec<Recording>) -> (Vec<Recording>, Vec<String>) {
    let (mut once, mut notes) = (Vec::new(), Vec::new());
    for recording in recordings {
        match twin(&recording, &once) {
            Some(twin) => notes.push(format!(
                "{} holds the data of {}, and is left out",
                recording.name(),
                twin.name()
            )),
            None => once.push(recording),
        }
    }
    (once, notes)
}

/// Notes on anomalies of the recordings themselves; those on gaps are [`gap_notes`].
#[must_use]
pub fn input_notes(training: &[Recording], unseen: &[Recording]) -> Vec<String> {
    let mut notes = Vec::new();
    for recording in unseen {
        if let Some(twin) = twin(recording, training) {
            notes.push(format!(
                "{} holds the data of the training recording {}: it is not unseen",
                recording.name(),
                twin.name()
            ));
        }
    }
    for recording in training.iter().chain(unseen) {
        let name = recording.name();
        let adaptations = recording.adaptations().iter();
        notes.extend(adaptations.map(|adaptation| format!("{name}: {adaptation}")));
        notes.extend(wild(recording).into_iter().map(|wild| {
            let is_replaced = false;
            format!("{name}: {}", Warning::Wild { wild, is_replaced })
        }));
        notes.extend(
            slips(recording)
                .iter()
                .map(|slip| format!("{name}: {slip}")),
        );
        notes.extend(stuck(recording).map(|stuck| format!("{name}: {stuck}")));
        notes.extend(drive_noise(recording).map(|noise| {
            let is_smoothed = false;
            format!("{name}: {}", Warning::NoisyDrive { noise, is_smoothed })
        }));
    }
    notes
}

/// Gap over the time constant, up to which it is harmless: whatever the drive did there, the rod went a tenth of the way at most.
const HARMLESS: f64 = 0.1;

/// Where recordings have gaps, compared with the time constant, s, where it is known.
#[must_use]
pub fn gap_notes<'a>(
    recordings: impl IntoIterator<Item = &'a Recording>,
    tau_s: Option<f64>,
) -> Vec<String> {
    let mut notes = Vec::new();
    for recording in recordings {
        let (name, gaps) = (recording.name(), recording.gaps());
        let longest_s = gaps
            .iter()
            .fold(0.0, |longest: f64, gap| longest.max(gap.dt_s));
        let stayed = match tau_s.map(|tau_s| longest_s / tau_s) {
            None => String::new(),
            Some(share) if share <= HARMLESS => {
                format!(
                    ", and {} % of tau_s is harmless",
                    significant(100.0 * share)
                )
            }
            Some(share) => format!(
                "; {} times tau_s: if it did not, the state after the gap is another",
                significant(share)
            ),
        };
        if gaps.len() > MOST_GAPS {
            notes.push(format!(
                "{name}: gaps: {}; the drive is taken to have stayed{stayed}",
                gaps_at_once(&gaps)
            ));
            continue;
        }
        notes.extend(gaps.iter().map(|gap| {
            format!(
                "{name}: nothing recorded from {} s for {:.3} s; the drive is taken to have stayed{stayed}",
                gap.start_s, gap.dt_s
            )
        }));
    }
    notes
}

/// The recording among others that has the same data, up to what rounding or a little noise makes of them.
fn twin<'a>(recording: &Recording, others: &'a [Recording]) -> Option<&'a Recording> {
    others.iter().find(|other| is_near_copy(recording, other))
}
