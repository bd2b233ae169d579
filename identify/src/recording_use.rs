//! Selection and preprocessing of recordings.

/// Selection and preprocessing of one recording: `[recordings."run3.csv"]` in a rod file, or flags of a command.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordingUse {
    /// From when to when it is used, s; rising.
    pub window_s: Option<[f64; 2]>,
    /// Spans that are left out, s; each rising.
    pub exclude_s: Vec<[f64; 2]>,
    /// Every so many rows are used, with the means of those around; ≥ 2.
    pub decimate: Option<usize>,
    /// True if the straight line from rest to rest is subtracted from the output.
    pub detrend: bool,
    /// Temperature of its surroundings, °C, where it differs from that of the rig and is no column.
    pub ambient_degc: Option<f64>,
}
