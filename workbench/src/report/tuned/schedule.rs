//! Gain schedules in words, tables and JSON.

use comfy_table::{Cell, Table};
use pid_tune::{GainSchedule, SCHEDULE_LEVELS};
use serde_json::{Value, json};

use super::TunedReport;
use crate::TriedSchedule;
use crate::report::number::{percent, significant};
use crate::report::table::{right, table};

/// Gain schedules that were tried.
#[derive(Debug, Clone)]
pub struct Schedules {
    /// Each of them.
    pub tried: Vec<TriedSchedule>,
    /// Cost of the best gains that stay; `None` if none meet what is required.
    pub unscheduled: Option<f64>,
}

impl Schedules {
    /// The cheapest, if any gains along a schedule meet what is required; of equal ones the first.
    fn cheapest(&self) -> Option<(&TriedSchedule, f64)> {
        let tried = self.tried.iter().filter_map(|one| Some((one, one.cost?)));
        tried.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl TunedReport<'_> {
    /// Says which schedule the gains follow, or why none; `None` unless that was asked for.
    pub(super) fn schedule_sentence(&self) -> Option<String> {
        let schedules = self.schedules.as_ref()?;
        let n_tried = schedules.tried.len();
        let Some(schedule) = &self.pid.gain_schedule else {
            let best = match (schedules.unscheduled, schedules.cheapest()) {
                (Some(staying), Some((_, cost))) if cost < staying => {
                    format!("the best of {n_tried} gain schedules saves less than 1 % of the cost")
                }
                (_, Some(_)) => format!("none of {n_tried} gain schedules saves any of the cost"),
                (_, None) => {
                    format!("none of {n_tried} gain schedules has gains that meet what is required")
                }
            };
            return Some(format!("The gains are the same at every level: {best}."));
        };
        let Some((one, _)) = schedules.cheapest() else {
            unreachable!("the gains follow a schedule that was tried");
        };
        let (by, exponent) = (one.by(), one.exponent);
        let than = match schedules.unscheduled {
            Some(staying) => format!(
                "they cost {} less than the best gains that stay",
                percent(1.0 - self.found.cost / staying)
            ),
            None => "no gains that stay meet what is required".to_owned(),
        };
        Some(format!(
            "kp, ki and kd are those of the level where the rig is steepest; elsewhere they are larger, by up to {}, by the {by} of the output \
             (slope to the power of -{exponent}): {than}.",
            significant(schedule.largest()),
        ))
    }

    /// Factors over level and branch; `None` without a schedule.
    #[must_use]
    pub fn schedule_table(&self) -> Option<Table> {
        let schedule = self.pid.gain_schedule.as_ref()?;
        let level = format!("output ({})", self.rig.output_unit);
        let header = [
            level.as_str(),
            "factor on kp, ki, kd: heating (1)",
            "cooling (1)",
        ];
        let mut table = table(header);
        let params = schedule.params();
        for index in 0..SCHEDULE_LEVELS {
            table.add_row([
                Cell::new(significant(self.rig.signed(schedule.level(index)))),
                right(significant(params.heating[index])),
                right(significant(params.cooling[index])),
            ]);
        }
        Some(table)
    }

    /// Costs of the schedules that were tried; `None` unless that was asked for.
    #[must_use]
    pub fn schedules_table(&self) -> Option<Table> {
        let schedules = self.schedules.as_ref()?;
        let mut table = table(["gain schedule by", "exponent (1)", "cost (1)"]);
        let cost = |cost: Option<f64>| match cost {
            Some(cost) => right(significant(cost)),
            None => right("misses what is required".to_owned()),
        };
        table.add_row([
            Cell::new("none: gains that stay"),
            right("-".to_owned()),
            cost(schedules.unscheduled),
        ]);
        for one in &schedules.tried {
            table.add_row([
                Cell::new(one.by()),
                right(significant(one.exponent)),
                cost(one.cost),
            ]);
        }
        Some(table)
    }

    /// Adds what was asked for to the document for programs.
    pub(super) fn put_schedules(&self, document: &mut Value) {
        let Some(schedules) = &self.schedules else {
            return;
        };
        let schedule = self.pid.gain_schedule.as_ref();
        document["controller"]["gain_schedule"] =
            schedule.map_or(Value::Null, |schedule| self.schedule_json(schedule));
        let tried = schedules.tried.iter().map(
            |one| json!({"exponent": one.exponent, "by_branch": one.by_branch, "cost": one.cost}),
        );
        document["gain_schedules"] = json!({
            "unscheduled_cost": schedules.unscheduled,
            "tried": tried.collect::<Vec<_>>(),
        });
    }

    /// Factors from level to level, levels as the sensor reads them.
    fn schedule_json(&self, schedule: &GainSchedule) -> Value {
        let params = schedule.params();
        json!({
            "outputs": params.outputs.map(|output| self.rig.signed(output)),
            "turn": params.turn,
            "heating": params.heating,
            "cooling": params.cooling,
        })
    }
}
