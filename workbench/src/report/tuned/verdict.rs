//! The gains and what they do, in sentences.

use std::fmt::Write;

use pid_tune::{AntiWindup, DerivativeOf};
use recording::DriveResolution;

use super::tables::endless;
use super::{Checked, GAINS, TunedReport, gains};
use crate::End;
use crate::report::number::{percent, significant};
use crate::rig::BEYOND;

/// Ratio to a requirement below which it holds gains back.
const NEARLY: f64 = 1.03;
/// Share of the cost from which it is said that a requirement has a price.
const WORTH_SAYING: f64 = 0.002;

impl TunedReport<'_> {
    /// The gains and what they do, in sentences.
    #[must_use]
    pub fn verdict(&self) -> String {
        let found = &self.found;
        let units = self.gain_units();
        let gains: Vec<String> = gains(&found.gains)
            .iter()
            .zip(GAINS.iter().zip(&units))
            .map(|(value, (name, unit))| format!("{name} {} {unit}", significant(*value)))
            .collect();
        let mut text = self
            .checked
            .as_ref()
            .map_or_else(String::new, |one| self.checked_sentence(one));
        if !self.rig.converged {
            text +=
                "The model was NOT CONVERGED when it was identified: do not trust what follows.\n";
        }
        if self.rig.drive_max > BEYOND * self.rig.largest_drive {
            let _ = writeln!(
                text,
                "The drive may reach {} {unit}; the model was fitted to at most {} {unit}: beyond, it is a guess.",
                significant(self.rig.drive_max),
                significant(self.rig.largest_drive),
                unit = self.rig.drive_unit,
            );
        }
        let _ = writeln!(text, "{}", gains.join(", "));
        let _ = writeln!(text, "{}", self.form());
        if let Some(schedule) = self.schedule_sentence() {
            let _ = writeln!(text, "{schedule}");
        }
        if let Some(step) = self.tuned().terms.step {
            let left_s = self.duration_s - self.pid.dt_s;
            let within = |verb: &str, time_s: f64| {
                if time_s >= left_s {
                    format!("does not {verb} within {} s", significant(left_s))
                } else {
                    format!("{verb}s within {} s", significant(time_s))
                }
            };
            let _ = writeln!(
                text,
                "The step to {} {} {}, {} and overshoots {}.",
                significant(self.set_point),
                self.rig.output_unit,
                within("rise", step.rise_time_s),
                within("settle", step.settling_time_s),
                percent(step.overshoot)
            );
        }
        if !self.rig.effects.is_empty() {
            let _ = writeln!(text, "All of it is with {}.", self.rig.effects.join(", "));
        }
        let _ = writeln!(text, "{}", self.margins_sentence());
        let _ = writeln!(text, "{}", self.sensor_sentence());
        if let Some(supply) = self.supply_sentence() {
            let _ = writeln!(text, "{supply}");
        }
        text += &self.rest_sentence();
        if let Some(limit) = self.limit_sentence() {
            let _ = write!(text, "\n{limit}");
        }
        if let Some(robust) = self.robust
            && let Some(step) = robust.step
        {
            let _ = write!(
                text,
                "\nOf {} rods as likely as the identified one, {} do not come to rest and {} do not settle.",
                robust.draws,
                percent(self.restless_share),
                percent(step.unsettled_share)
            );
        }
        text + "\n"
    }

    /// Says if the rig did as promised, and what to do if not.
    fn checked_sentence(&self, checked: &Checked) -> String {
        let (name, kept) = (&checked.name, &checked.kept);
        let unit = &self.rig.output_unit;
        let errors = format!(
            "the error on the reference is {} {unit}, {} were expected",
            significant(kept.rmse),
            significant(kept.expected_rmse)
        );
        let inside = format!(
            "{} of its samples lie where {} rods as likely as the identified one would be",
            percent(kept.inside_share),
            checked.n_rods
        );
        if kept.is_kept() {
            return format!("{name}: the rig did as promised. {inside}; {errors}.\n");
        }
        let (at_s, outside) = kept.worst.unwrap_or_default();
        format!(
            "{name}: the rig DID NOT do as promised. Only {inside}; {errors}. It is farthest off at {} s, by {} {unit}.\n\
             If the drive was recorded as well, what is missing is asked with: sma diagnose rod.toml --train {name}\n",
            significant(at_s),
            significant(outside)
        )
    }

    fn margins_sentence(&self) -> String {
        let Some(margins) = self.tuned().margins else {
            return "The output does not answer small changes of the drive: there are no margins."
                .to_owned();
        };
        let place = match self.schedules {
            None => "Where the loop is steepest",
            Some(_) => "At the worst level and branch",
        };
        if !margins.stable {
            return format!("{place}, small swings GROW: there is no margin.");
        }
        format!(
            "{place}: gain margin {}, phase margin {}°, delay margin {} s, peak sensitivity {}.",
            endless(margins.gain_margin),
            endless(margins.phase_margin_rad.to_degrees()),
            endless(margins.delay_margin_s),
            significant(margins.peak_sensitivity),
        )
    }

    /// Names the requirements that keep the gains from being cheaper; `None` if none does.
    fn limit_sentence(&self) -> Option<String> {
        let required = self.requirements?;
        let tuned = self.tuned();
        let mut limits = Vec::new();
        if let Some(margins) = tuned.margins {
            if margins.gain_margin < NEARLY * required.gain_margin {
                limits.push("the gain margin");
            }
            if margins.phase_margin_rad < NEARLY * required.phase_margin_rad {
                limits.push("the phase margin");
            }
        }
        if NEARLY * tuned.kick > required.largest_kick {
            limits.push("the sensor");
        }
        let price = self.found.cost / self.found.lowest - 1.0;
        if price >= WORTH_SAYING {
            return Some(format!(
                "Rest decides: gains that cost {} less do not rest on all of {} rods.",
                percent(price / (1.0 + price)),
                self.found.rest_on
            ));
        }
        if limits.is_empty() {
            return Some(
                "No requirement holds the gains back: they are those of least cost.".to_owned(),
            );
        }
        Some(format!(
            "The gains are held back by {}.",
            limits.join(" and ")
        ))
    }

    fn sensor_sentence(&self) -> String {
        let unit = &self.rig.output_unit;
        let jump = self.sensor.jump();
        if jump <= 0.0 {
            return "The sensor is taken for ideal: noise and converter of a real one move the drive."
                .to_owned();
        }
        let what = if self.sensor.step >= jump {
            "One step of the sensor"
        } else {
            "A jump of the sensor by twice its noise"
        };
        format!(
            "{what} ({} {unit}) moves the drive by {} of its range{}.",
            significant(jump),
            percent(self.tuned().kick),
            self.requirements.map_or(String::new(), |required| format!(
                "; at most {} are allowed",
                percent(required.largest_kick)
            )),
        )
    }

    /// How finely the drive can be set, unless it is taken for ideal.
    fn supply_sentence(&self) -> Option<String> {
        let unit = &self.rig.drive_unit;
        let seen = |value: Option<f64>| value.filter(|value| *value > 0.0).map(significant);
        let DriveResolution { step, dead_zone } = self.resolution;
        let what = match (seen(step), seen(dead_zone)) {
            (Some(step), None) => format!("sets the drive in steps of {step} {unit}"),
            (None, Some(edge)) => format!("gives nothing below {edge} {unit}"),
            (Some(step), Some(edge)) => {
                format!(
                    "sets the drive in steps of {step} {unit}, and gives nothing below {edge} {unit}"
                )
            }
            (None, None) => return None,
        };
        Some(format!("The supply {what}."))
    }

    /// How the tuned loop ends, and what would help where it does not rest.
    fn rest_sentence(&self) -> String {
        let [_, rests] = &self.rests;
        if rests.iter().all(|rest| rest.end == End::Rests) {
            let most = rests
                .iter()
                .map(|rest| rest.drive_swing)
                .fold(0.0, f64::max);
            return format!(
                "The loop comes to rest, from cold, from hot and from near the set point. There the drive swings by at most {} \
                 of its range.",
                percent(most)
            );
        }
        let ends: Vec<String> = rests
            .iter()
            .map(|rest| format!("from {} {}", rest.side.name(), self.ending(rest)))
            .collect();
        let any = |end: End| rests.iter().any(|rest| rest.end == end);
        let advice = if any(End::Chatters) {
            "A slower sample time (--sample-time-s), a longer filter (--derivative-filter-s), or a controller without \
             derivative (--pi) would be quieter."
        } else if any(End::Swings) {
            "Larger margins (--gain-margin, --phase-margin-deg) or a gentler --pace would calm it."
        } else {
            "The drive is at a limit, or the integral is too slow for twelve time constants."
        };
        let only_off = rests
            .iter()
            .all(|rest| matches!(rest.end, End::Rests | End::Off));
        let what = if only_off {
            "REACH THE SET POINT"
        } else {
            "REST"
        };
        format!("THE LOOP DOES NOT {what}: {}. {advice}", ends.join(", "))
    }

    /// The controller as one would write it down for firmware.
    fn form(&self) -> String {
        let sign = if self.rig.is_turned() {
            ", signs of output and reference changed"
        } else {
            ""
        };
        let windup = match self.pid.anti_windup {
            AntiWindup::Off => "integral without limit".to_owned(),
            AntiWindup::Clamping => "integral clamped at the limits".to_owned(),
            AntiWindup::BackCalculation { tracking_s } => {
                format!("back-calculation over {} s", significant(tracking_s))
            }
        };
        let weight = self.pid.setpoint_weight;
        let weighed = if weight < 1.0 {
            format!(
                ", the proportional term sees {} of the reference",
                percent(weight)
            )
        } else {
            String::new()
        };
        let watched = match self.pid.derivative_of {
            DerivativeOf::Measurement => "measurement",
            DerivativeOf::Error => "error",
        };
        let forward = if self.feed_forward {
            ", the model's inverse added to the drive and its output aimed at; margins and rest are those of the feedback"
        } else {
            ""
        };
        format!(
            "parallel form every {} s, drive 0 to {} {}, {windup}, derivative of the {watched} filtered over {} s\
             {weighed}{forward}{sign}",
            significant(self.pid.dt_s),
            significant(self.rig.drive_max),
            self.rig.drive_unit,
            significant(self.pid.derivative_filter_s),
        )
    }

    /// Drive per error, per error and second, and drive seconds per error.
    pub(super) fn gain_units(&self) -> [String; 3] {
        let (drive, output) = (&self.rig.drive_unit, &self.rig.output_unit);
        [
            format!("{drive}/{output}"),
            format!("{drive}/({output} s)"),
            format!("{drive} s/{output}"),
        ]
    }
}
