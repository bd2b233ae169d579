//! Tables of a controller's response, margins and references.

use comfy_table::{Cell, Table};
use pid_tune::{Forecast, Margins, Oscillation, Passage, Percentiles, Source};

use super::{Candidate, GAINS, TunedReport, gains, values, weights};
use crate::report::number::{percent, significant};
use crate::report::table::{right, table};
use crate::{End, Rest};

/// Rows of the front that a person reads; JSON has all.
const FRONT_ROWS: usize = 16;

impl TunedReport<'_> {
    /// Terms of eq. 13, raw and weighted, a column a controller.
    #[must_use]
    pub fn terms_table(&self) -> Table {
        let mut header = vec!["", "unit"];
        header.extend(self.candidates.iter().map(|one| one.name));
        let mut table = table(header);
        let units = self.gain_units();
        for (k, name) in GAINS.iter().enumerate() {
            let mut row = vec![Cell::new(name), Cell::new(&units[k])];
            row.extend(
                self.candidates
                    .iter()
                    .map(|one| right(significant(gains(&one.gains)[k]))),
            );
            table.add_row(row);
        }
        let (drive, output) = (&self.rig.drive_unit, &self.rig.output_unit);
        let terms = [
            ("mean square error", format!("{output}²")),
            ("energy ½Σu²Δt", format!("{drive}² s")),
            ("rise time", "s".to_owned()),
            ("settling time", "s".to_owned()),
            ("overshoot", "1".to_owned()),
        ];
        let weights = weights(&self.weights);
        for (k, (name, unit)) in terms.iter().enumerate() {
            let mut row = vec![Cell::new(name), Cell::new(unit)];
            row.extend(self.candidates.iter().map(|one| {
                let value = values(&one.terms)[k];
                right(format!(
                    "{} ({})",
                    significant(value),
                    significant(weights[k] * value)
                ))
            }));
            table.add_row(row);
        }
        let mut row = |name: &str, unit: &str, said: &dyn Fn(&Candidate) -> String| {
            let mut cells = vec![Cell::new(name), Cell::new(unit)];
            cells.extend(self.candidates.iter().map(|one| right(said(one))));
            table.add_row(cells);
        };
        row("drive's way in the end", &format!("{drive}/s"), &|one| {
            let way = one.ending.travel_per_s;
            format!("{} ({})", significant(way), significant(self.wear * way))
        });
        row("cost (weighted sum)", "1", &|one| significant(one.cost));
        let margin = |of: fn(&Margins) -> f64| {
            move |one: &Candidate| {
                one.margins
                    .as_ref()
                    .map_or("-".to_owned(), |margins| endless(of(margins)))
            }
        };
        row("gain margin", "1", &margin(|margins| margins.gain_margin));
        row(
            "phase margin",
            "°",
            &margin(|margins| margins.phase_margin_rad.to_degrees()),
        );
        row(
            "delay margin",
            "s",
            &margin(|margins| margins.delay_margin_s),
        );
        row(
            "peak sensitivity Ms",
            "1",
            &margin(|margins| margins.peak_sensitivity),
        );
        let passage = |of: fn(&Passage) -> f64| {
            move |one: &Candidate| {
                one.passage
                    .as_ref()
                    .map_or("-".to_owned(), |passage| endless(of(passage)))
            }
        };
        row("bandwidth", "Hz", &passage(|passage| passage.bandwidth_hz));
        row(
            "noise gain to the drive",
            &format!("{drive}/{output}"),
            &passage(|passage| passage.noise_gain),
        );
        row(
            "drive moved by a jump of the sensor",
            "of its range",
            &|one| percent(one.kick),
        );
        table
    }

    /// How loops end, from each side: as all of it is, and as it was foreseen of the baseline part.
    #[must_use]
    pub fn rest_table(&self) -> Table {
        let mut table = table([
            "end of the loop",
            "from",
            "simulated: all effects, sensor, delay",
            "foreseen of the baseline part",
            "simulated baseline part",
        ]);
        let compared = self.compared();
        for (name, (rests, analysis)) in compared.iter().zip(self.rests.iter().zip(&self.analyses))
        {
            for (rest, outcome) in rests.iter().zip(&analysis.outcomes) {
                table.add_row([
                    *name,
                    rest.side.name(),
                    &self.ending(rest),
                    &outcome
                        .forecast
                        .map_or("rest".to_owned(), |forecast| self.foreseen(&forecast)),
                    &outcome
                        .oscillation
                        .map_or("rest".to_owned(), |found| self.cycling(&found)),
                ]);
            }
        }
        table
    }

    pub(super) fn ending(&self, rest: &Rest) -> String {
        let unit = &self.rig.output_unit;
        match rest.end {
            End::Rests => format!("rest, drive swings by {}", percent(rest.drive_swing)),
            End::Swings => format!("SWINGS by {} {unit}", significant(rest.output_swing)),
            End::Chatters => format!(
                "CHATTERS: the drive swings by {}",
                percent(rest.drive_swing)
            ),
            End::Off => format!("quiet, but {} {unit} off", significant(rest.mean_error)),
        }
    }

    fn foreseen(&self, forecast: &Forecast) -> String {
        let source = match (forecast.source, forecast.reliable) {
            (Source::Chatter, _) => "",
            (Source::DescribingFunction, true) => " (describing function)",
            (Source::DescribingFunction, false) => " (describing function, unreliable)",
        };
        format!(
            "±{} {}, {} Hz{source}",
            significant(forecast.amplitude),
            self.rig.output_unit,
            significant(forecast.frequency_hz)
        )
    }

    fn cycling(&self, found: &Oscillation) -> String {
        format!(
            "±{} {}, {} Hz",
            significant(found.sine_amplitude),
            self.rig.output_unit,
            significant(found.frequency_hz)
        )
    }

    /// Errors on each reference.
    pub fn tracks_table(&self) -> Table {
        let rmse = format!("RMSE ({})", self.rig.output_unit);
        let error = format!("steady error ({})", self.rig.output_unit);
        let mut table = table(["simulated", "controller", &rmse, &error, "saturated", ""]);
        for track in &self.tracks {
            table.add_row([
                Cell::new(&track.name),
                Cell::new(track.controller),
                right(significant(track.rmse())),
                right(
                    track
                        .steady_state_error()
                        .map_or("-".to_owned(), significant),
                ),
                right(percent(track.saturated_share())),
                Cell::new(track.recorded_rmse.map_or(String::new(), |rmse| {
                    format!("recorded under its own controller: {}", significant(rmse))
                })),
            ]);
        }
        table
    }

    /// The spread over rods as likely as the identified one.
    pub fn robust_table(&self) -> Table {
        let mut table = table([
            "response of the tuned gains",
            "rise time (s)",
            "settling time (s)",
            "overshoot",
        ]);
        if let Some((robust, step)) = self.robust.and_then(|robust| Some((robust, robust.step?))) {
            let of = |percentiles: Percentiles, shown: fn(f64) -> String| {
                right(format!(
                    "{} ({} … {})",
                    shown(percentiles.p50),
                    shown(percentiles.p5),
                    shown(percentiles.p95)
                ))
            };
            table.add_row([
                Cell::new(format!("{} draws: median (5 … 95 %)", robust.draws)),
                of(step.rise_time_s, significant),
                of(step.settling_time_s, significant),
                of(step.overshoot, percent),
            ]);
        }
        for one in &self.varied {
            let (Some(minus), Some(plus)) = (one.minus.terms.step, one.plus.terms.step) else {
                continue;
            };
            let pair = |of: fn(&pid_tune::StepTerms) -> f64, shown: fn(f64) -> String| {
                right(format!("{} / {}", shown(of(&minus)), shown(of(&plus))))
            };
            table.add_row([
                Cell::new(format!("{} -20 / +20 %", one.name)),
                pair(|step| step.rise_time_s, significant),
                pair(|step| step.settling_time_s, significant),
                pair(|step| step.overshoot, percent),
            ]);
        }
        table
    }

    /// Some controllers of the front, if it was asked for.
    #[must_use]
    pub fn front_table(&self) -> Option<Table> {
        if self.front.is_empty() {
            return None;
        }
        let mse = format!("MSE ({}²)", self.rig.output_unit);
        let energy = format!("energy ({}² s)", self.rig.drive_unit);
        let mut table = table(["kp", "ki", "kd", &mse, &energy]);
        for point in self
            .front
            .iter()
            .step_by(self.front.len().div_ceil(FRONT_ROWS))
        {
            let numbers = gains(&point.gains)
                .into_iter()
                .chain([point.terms.mse, point.terms.energy]);
            table.add_row(
                numbers
                    .map(|value| right(significant(value)))
                    .collect::<Vec<_>>(),
            );
        }
        Some(table)
    }
}

/// A number that may be beyond all others.
pub(super) fn endless(value: f64) -> String {
    if value.is_infinite() {
        "∞".to_owned()
    } else {
        significant(value)
    }
}
