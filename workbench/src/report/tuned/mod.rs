//! Report of `sma tune`: text for people, JSON for programs.

mod json;
mod schedule;
mod tables;
mod verdict;

use std::fmt::Write;

use identify::Sensor;
use pid_tune::{
    BoundEnd, Complex, CostWeights, Ending, FrontPoint, LoopAnalysis, Margins, Passage, PidGains,
    PidParams, Requirements, Robustness, SecondOpinion, Sensitivity, Terms, Tuned, Verdict,
};
use recording::DriveResolution;

pub use schedule::Schedules;

use super::number::significant;
use super::table::unpadded;
use crate::rig::Rig;
use crate::track::Track;
use crate::{Kept, Rest};

/// Ratio of costs from which gains miss what is required: far beyond that of any response.
pub(super) const MISSES: f64 = 1e12;

/// Names of the gains.
const GAINS: [&str; 3] = ["kp", "ki", "kd"];

/// The result of `sma tune`.
#[derive(Debug)]
pub struct TunedReport<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// As the sensor reads it.
    pub set_point: f64,
    /// The controller but for its gains.
    pub pid: PidParams,
    /// Step and noise of the sensor in all that is simulated.
    pub sensor: Sensor,
    /// How finely the drive can be set in all that is simulated; 0 or `None` for an ideal one.
    pub resolution: DriveResolution,
    /// Samples from a measurement to what is commanded by it.
    pub dead_time_samples: usize,
    /// Requirements that the gains meet; `None` if nothing is required.
    pub requirements: Option<Requirements>,
    /// True if the inverse of the baseline model is added to the drive.
    pub feed_forward: bool,
    /// Gain schedules that were tried; `None` if that was not asked for.
    pub schedules: Option<Schedules>,
    /// Rods over which the worst response counts, the identified one among them.
    pub n_rods: usize,
    /// Length of the response that is judged, s.
    pub duration_s: f64,
    /// Weights of the terms of the cost.
    pub weights: CostWeights,
    /// Weight of the drive's way in the end, per its unit per second.
    pub wear: f64,
    /// The gains that were found.
    pub found: Tuned,
    /// Where another optimizer ends.
    pub opinion: SecondOpinion,
    /// Controllers side by side: the one that is compared with first, then the tuned one, then others.
    pub candidates: Vec<Candidate>,
    /// How the first two end, from each side.
    pub rests: [[Rest; 3]; 2],
    /// Limit cycles of the baseline part under the first two.
    pub analyses: [LoopAnalysis; 2],
    /// Loops of the first two over frequencies, for a picture.
    pub loops: Vec<LoopPicture>,
    /// -1/N of the baseline part's hysteresis, beside the loops.
    pub describing_curve: Vec<(f64, Complex)>,
    /// Performance of the gains on rods as likely as the identified one; `None` if that was not asked for.
    pub robust: Option<Robustness>,
    /// Share of those rods on which the loop does not rest, from one side or another.
    pub restless_share: f64,
    /// Sensitivity of the response to each parameter.
    pub varied: Vec<Sensitivity<'a>>,
    /// Gains that no others beat in all terms.
    pub front: Vec<FrontPoint>,
    /// Responses to references.
    pub tracks: Vec<Track>,
    /// A recording of the rig beside what was promised of it.
    pub checked: Option<Checked>,
}

/// A recording of the rig under the tuned gains, beside what was promised.
#[derive(Debug, Clone)]
pub struct Checked {
    /// Its name.
    pub name: String,
    /// How they compare.
    pub kept: Kept,
    /// Rods that the promise was made for.
    pub n_rods: usize,
}

/// A controller and what its response to the step costs.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Its name.
    pub name: &'static str,
    /// Its gains.
    pub gains: PidGains,
    /// Terms of the cost.
    pub terms: Terms,
    /// How its response ended.
    pub ending: Ending,
    /// The cost.
    pub cost: f64,
    /// The least margins between rest and set point; `None` where the output does not answer the drive.
    pub margins: Option<Margins>,
    /// Noise gain and bandwidth there.
    pub passage: Option<Passage>,
    /// Share of the drive's range by which one jump of the sensor moves the drive.
    pub kick: f64,
}

/// A loop over frequencies, where it is steepest.
#[derive(Debug, Clone)]
pub struct LoopPicture {
    /// Name of the controller.
    pub name: &'static str,
    /// Frequencies, Hz, rising, and L there.
    pub response: Vec<(f64, Complex)>,
}

/// The five terms of eq. 13 as numbers; those of a step are `NaN` where there is none.
fn values(terms: &Terms) -> [f64; 5] {
    let step = terms.step.map_or([f64::NAN; 3], |step| {
        [step.rise_time_s, step.settling_time_s, step.overshoot]
    });
    [terms.mse, terms.energy, step[0], step[1], step[2]]
}

fn weights(weights: &CostWeights) -> [f64; 5] {
    [
        weights.mse,
        weights.energy,
        weights.rise_time,
        weights.settling_time,
        weights.overshoot,
    ]
}

impl TunedReport<'_> {
    /// For people: the verdict first, then the tables.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = self.verdict();
        let scheduled = [self.schedule_table(), self.schedules_table()]
            .into_iter()
            .flatten();
        let scheduled: Vec<String> = scheduled.map(|table| table.to_string()).collect();
        let front = self.front_table().map(|table| table.to_string());
        for part in [
            self.terms_table().to_string(),
            self.rest_table().to_string(),
            self.tracks_table().to_string(),
            self.robust_table().to_string(),
        ]
        .into_iter()
        .chain(scheduled)
        .chain(front)
        {
            let _ = write!(text, "\n{part}\n");
        }
        unpadded(&text)
    }

    /// Names of the two controllers that are compared in detail.
    #[must_use]
    pub fn compared(&self) -> [&'static str; 2] {
        [self.candidates[0].name, self.candidates[1].name]
    }

    /// The tuned controller.
    #[must_use]
    pub fn tuned(&self) -> &Candidate {
        &self.candidates[1]
    }

    /// Further notes, a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!(
            "all of this is simulated on the model: {} s at {} s a sample, drive 0 to {} {}; {} controllers, {} of \
             which missed what is required; seed {}",
            significant(self.duration_s),
            significant(self.pid.dt_s),
            significant(self.rig.drive_max),
            self.rig.drive_unit,
            self.found.evaluations,
            self.found.refused,
            self.found.seed
        )];
        let [mse, energy, rise_time, settling_time, overshoot] =
            weights(&self.weights).map(significant);
        notes.push(format!(
            "cost = {mse} · mean square error + {energy} · energy + {rise_time} · rise time + {settling_time} · settling time + \
             {overshoot} · overshoot + {} · drive's way in the end per second: each term of the response to {} counts one \
             unless --weights or --pace say otherwise",
            significant(self.wear),
            self.compared()[0]
        ));
        for (name, end) in GAINS.iter().zip(self.found.at_bound) {
            if end == Some(BoundEnd::Upper) {
                notes.push(format!("{name} is the largest that was looked for"));
            }
        }
        let [from_optimum, from_elsewhere] =
            [self.opinion.from_optimum, self.opinion.from_elsewhere];
        for (opinion, start) in [(from_optimum, "there"), (from_elsewhere, "elsewhere")] {
            if opinion.ratio >= MISSES {
                notes.push(format!(
                    "argmin's simplex, from {start}, ends at gains that miss what is required"
                ));
                continue;
            }
            notes.push(format!(
                "argmin's simplex, from {start}, ends {} ({} times the cost)",
                match opinion.verdict {
                    Verdict::Agrees => "at the same cost",
                    Verdict::EndedHigher => "higher, caught on the way",
                    Verdict::EndedLower =>
                        "LOWER: the search did not find the best; try another --seed",
                },
                significant(opinion.ratio)
            ));
        }
        notes
    }

    /// The responses, a row a sample.
    #[must_use]
    pub fn responses(&self) -> String {
        let unit = &self.rig.output_unit;
        let mut text = format!("reference,controller,time_s,setpoint_{unit},output_{unit},drive\n");
        for track in &self.tracks {
            for k in 0..track.time_s.len() {
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{}",
                    track.name,
                    track.controller,
                    track.time_s[k],
                    track.setpoint[k],
                    track.output[k],
                    track.drive[k]
                );
            }
        }
        text
    }
}

fn gains(gains: &PidGains) -> [f64; 3] {
    [gains.kp, gains.ki, gains.kd]
}
