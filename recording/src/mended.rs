//! A recording without what the rig did not see.

use crate::adapt::Adaptation;
use crate::drive_noise::smooth;
use crate::recording::Recording;
use crate::slip::slips;
use crate::wild::wild;

/// The recording as fits take it: samples that stand far from both neighbors ([`wild`]) are replaced by what lies between these,
/// slips of the output ([`slips`]) are taken back, and a drive with a sensor's noise ([`drive_noise`](crate::drive_noise)) by its levels and ramps. What was done is among its [`Recording::adaptations`].
///
/// A rod has inertia: what neither neighbor knows of did not reach it, or did not come from it. One such sample weighs as much in a
/// least-squares fit as thousands of others.
///
/// # Examples
///
/// ```
/// use recording::{Recording, RecordingParts, mended};
///
/// let mut drive: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 0.5 }).collect();
/// drive[150] = 22.0;
/// let recording = Recording::new(RecordingParts {
///     time_s: Some((0..200).map(f64::from).collect()),
///     drive,
///     output: (0..200).map(|k| if k < 102 { 0.0 } else { 1.0 }).collect(),
///     ..RecordingParts::default()
/// })?;
/// let mended = mended(&recording);
/// assert_eq!(mended.drive()[150], 0.5);
/// assert_eq!(
///     mended.adaptations()[0].to_string(),
///     "a sample of the drive that stands far from both neighbors, 22 A at 150 s, is replaced by the mean of its neighbors"
/// );
/// # Ok::<(), recording::RecordingError>(())
/// ```
#[must_use]
pub fn mended(recording: &Recording) -> Recording {
    let mut mended = recording.clone();
    for wild in wild(recording) {
        match wild.role {
            "time" => mended.change_time(|time_s| wild.replace(time_s)),
            "output" => wild.replace(mended.output_mut()),
            role => {
                let place = usize::from(role != "drive");
                mended
                    .drives_mut()
                    .skip(place)
                    .take(1)
                    .for_each(|drive| wild.replace(drive));
            }
        }
        let done = Adaptation::of_recording(format!("{wild}, {}", wild.replacement()));
        mended = mended.also_adapted_by(done);
    }
    for slip in slips(&mended) {
        slip.take_back(mended.output_mut());
        let done = format!(
            "{}, is taken back: what comes after is moved by as much",
            slip.short()
        );
        mended = mended.also_adapted_by(Adaptation::of_recording(done));
    }
    smoothed(mended)
}

/// The recording without a sensor's noise in its drive ([`drive_noise`](crate::drive_noise)), which is replaced by levels and ramps:
/// the last step of [`mended`].
#[must_use]
pub fn smoothed(mut recording: Recording) -> Recording {
    let Some((noise, Some(smooth))) = smooth(&recording) else {
        return recording;
    };
    recording.drive_mut().copy_from_slice(&smooth);
    recording.parts.smoothed_noise = noise.standard_deviation;
    let what = format!("{noise}, at rest, too: {}", noise.replacement());
    recording.also_adapted_by(Adaptation::of_recording(what))
}
