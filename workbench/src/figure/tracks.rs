//! Figures of reference tracking under the controllers.

use super::{Figure, Series, Style};
use crate::report::tuned::TunedReport;
use crate::track::Track;

/// Of each reference the output, then the drive, under the paper's gains and the tuned ones.
#[must_use]
pub fn tracks(tuned: &TunedReport<'_>) -> Vec<Figure> {
    let (output, drive) = (&tuned.rig.output_unit, &tuned.rig.drive_unit);
    let by_reference = tuned
        .tracks
        .chunk_by(|one, another| one.name == another.name);
    let figures = by_reference.filter_map(|tracks| {
        let first = tracks.first()?;
        let reference = Series::over("reference", Style::Recorded, &first.time_s, &first.setpoint);
        let outputs = tracks.iter().map(|track| under(track, &track.output));
        let drives = tracks.iter().map(|track| under(track, &track.drive));
        let figure = |name, caption, up, series| Figure {
            name,
            caption,
            across: "time, s".to_owned(),
            up,
            series,
            ..Figure::default()
        };
        Some([
            figure(
                "output",
                format!("{}: the output should lie on the reference", first.name),
                format!("output, {output}"),
                std::iter::once(reference).chain(outputs).collect(),
            ),
            figure(
                "drive",
                format!(
                    "{}: the drive that it takes; flat at the top where it is at its limit",
                    first.name
                ),
                format!("drive, {drive}"),
                drives.collect(),
            ),
        ])
    });
    figures.flatten().collect()
}

fn under(track: &Track, values: &[f64]) -> Series {
    let style = match track.controller {
        "tuned" => Style::Extended,
        "unscheduled" => Style::Unseen,
        _ => Style::Plain,
    };
    Series::over(
        format!("{} gains", track.controller),
        style,
        &track.time_s,
        values,
    )
}
