//! A rod file to begin with, from what the columns of a file speak for.

use std::fmt::Write;

use recording::{Meaning, Quantity, Survey, SurveyedColumn};
use serde_json::Value;

/// A rod file, and what the user has to look at in it.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstRod {
    /// The file.
    pub text: String,
    /// Guesses and gaps, one question each, as they stand in the file.
    pub questions: Vec<String>,
}

/// Room temperature that is written down until the user knows better, °C.
const ROOM_DEGC: f64 = 22.0;

/// Full scales of converters, the least that holds a column's highest value being the likeliest.
const FULL_SCALES: [f64; 4] = [255.0, 1023.0, 4095.0, 65_535.0];

/// Writes a rod file from a survey.
#[must_use]
pub fn first_rod(survey: &Survey) -> FirstRod {
    let mut rod = Writing::default();
    rod.line(&format!(
        "# Written by `sma init` from {}. Lines with a question mark are guesses: look at them.",
        survey.file
    ));
    rod.line("");
    rod.line("# What you know of the wire; each line narrows what the data could mean.");
    rod.line("# [rod]\n# diameter_mm = 0.25\n# length_mm = 200.0\n# density_kg_per_m3 = 6450.0");
    rod.line("# specific_heat_j_per_kg_k = 500.0\n# resistance_ohm_per_m = 16.0");
    rod.line("");
    let is_static = matches!(survey.drive(), Some((_, Quantity::Temperature)));
    if survey.shows_temperature() && survey.column(Meaning::Ambient).is_none() {
        rod.line("# The temperature of the room is found from the recording, unless you know it.");
        rod.line(&format!(
            "# [surroundings]\n# ambient_degc = {ROOM_DEGC:.1}"
        ));
        rod.line("");
    } else if survey.column(Meaning::Ambient).is_none() && !is_static {
        rod.line("[surroundings]");
        rod.asked(
            &format!("ambient_degc = {ROOM_DEGC:.1}"),
            "what was the temperature of the room?",
        );
        rod.line("");
    }
    drive(&mut rod, survey);
    rod.line("");
    rod.line("[columns]");
    let drive = survey.drive().map(|(column, _)| column);
    for (key, column) in [
        ("time", survey.column(Meaning::Time)),
        ("drive", drive),
        ("output", survey.column(Meaning::Output)),
        ("temperature", survey.column(Meaning::Temperature)),
        ("ambient", survey.column(Meaning::Ambient)),
        ("stress", survey.column(Meaning::Stress)),
        ("resistance", survey.column(Meaning::Resistance)),
    ] {
        self::column(&mut rod, key, column, survey);
    }
    FirstRod {
        text: rod.text,
        questions: rod.questions,
    }
}

/// A file under way.
#[derive(Debug, Default)]
struct Writing {
    text: String,
    questions: Vec<String>,
}

impl Writing {
    fn line(&mut self, line: &str) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{line}");
    }

    /// A line that the user has to look at.
    fn asked(&mut self, line: &str, question: &str) {
        self.line(&format!("{line}  # ? {question}"));
        let line = line.trim_start_matches("# ");
        self.questions.push(format!("{line}: {question}"));
    }
}

fn drive(rod: &mut Writing, survey: &Survey) {
    rod.line("[drive]");
    let Some((column, quantity)) = survey.drive() else {
        rod.asked(
            "# kind = \"current\"",
            "what drives the actuator: current, duty, voltage, power, temperature? No column says it",
        );
        return;
    };
    let kind = format!("kind = \"{}\"", quantity.name());
    if column.is_said {
        rod.line(&kind);
    } else {
        let question = match quantity {
            Quantity::Temperature => {
                "no name says what the input is: a temperature, as its values look? Else current, duty, voltage, power"
            }
            _ => "no name says what the drive is: current, duty, voltage, power?",
        };
        rod.asked(&kind, question);
    }
    if quantity == Quantity::Duty && survey.shows_temperature() {
        rod.line("# supply_v = 12.0  # with length and resistance of the wire it makes watts of the duty");
    } else if quantity == Quantity::Duty {
        rod.asked(
            "# supply_v = 12.0",
            "which voltage does the bridge switch? V; without it and the wire's data temperatures are known by their ratios only",
        );
    }
}

fn column(rod: &mut Writing, key: &str, column: Option<&SurveyedColumn>, survey: &Survey) {
    let Some(column) = column else {
        match key {
            "time"
                if survey
                    .drive()
                    .is_none_or(|(_, quantity)| quantity != Quantity::Temperature) =>
            {
                rod.asked(
                    "time = { every_s = 1.0 }",
                    "how long is it from row to row? Until you say, times are in rows",
                );
            }
            "output" => rod.asked(
                "# output = { number = 2, unit = \"mm\" }",
                "what does it do?",
            ),
            _ => {}
        }
        return;
    };
    let place = match &column.name {
        Some(name) => format!("name = {}", Value::from(name.as_str())),
        None => format!("number = {}", column.number),
    };
    let is_duty = key == "drive" && matches!(survey.drive(), Some((_, Quantity::Duty)));
    let (unit, question) = match &column.unit {
        _ if column.holds_stamps => (None, None),
        Some(unit) if column.name.is_none() => (Some(Value::from(unit.as_str())), None),
        Some(_) => (None, None),
        None if is_duty => {
            let (unit, question) = duty(column.highest);
            rod_column(rod, key, &place, Some(unit), question);
            return;
        }
        // Whatever an actuator does keeps its unit: none is a guess.
        None if key == "output" && survey.shows_temperature() => (
            Some(Value::from("degc")),
            Some("which unit: degc, k, degf?".to_owned()),
        ),
        None if key == "output" => (None, Some("which unit?".to_owned())),
        None => {
            let unit = match (key, survey.drive()) {
                ("time", _) => "s",
                ("drive", Some((_, Quantity::Voltage))) => "V",
                ("drive", Some((_, Quantity::Power))) => "W",
                ("drive", Some((_, Quantity::Temperature))) | ("temperature" | "ambient", _) => {
                    "degc"
                }
                ("stress", _) => "MPa",
                ("resistance", _) => "ohm",
                _ => "A",
            };
            (Some(Value::from(unit)), Some("which unit?".to_owned()))
        }
    };
    let doubt = (!column.is_said).then(|| "is it this column?".to_owned());
    let asked = [doubt, question].into_iter().flatten().collect::<Vec<_>>();
    let asked = (!asked.is_empty()).then(|| asked.join(" "));
    let unit = unit.map(|unit| format!("unit = {unit}"));
    rod_column(rod, key, &place, unit, asked);
}

fn rod_column(
    rod: &mut Writing,
    key: &str,
    place: &str,
    unit: Option<String>,
    question: Option<String>,
) {
    let unit = unit.map_or(String::new(), |unit| format!(", {unit}"));
    let line = format!("{key} = {{ {place}{unit} }}");
    match question {
        Some(question) => rod.asked(&line, &question),
        None => rod.line(&line),
    }
}

/// The unit of a duty without one, and what to ask.
fn duty(highest: f64) -> (String, Option<String>) {
    if highest <= 1.0 {
        return ("unit = \"1\"".to_owned(), None);
    }
    let range = format!("its highest is {highest}");
    if highest <= 100.0 {
        let question = format!("{range}: percent, or counts with a full_scale?");
        return ("unit = \"%\"".to_owned(), Some(question));
    }
    let full_scale = FULL_SCALES.into_iter().find(|full| highest <= *full);
    let full_scale = full_scale.unwrap_or(highest);
    (
        format!("unit = \"counts\", full_scale = {full_scale}"),
        Some(format!("{range}: is that its full scale?")),
    )
}

#[cfg(test)]
mod tests {
    use rig_files::rod_file;

    use super::*;
    use std::fs;

    fn begun(csv: &str) -> FirstRod {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        fs::write(&path, csv).unwrap();
        let rod = first_rod(&recording::survey(&path).unwrap());
        // What is written is a rod file.
        rod_file::parse("rod.toml", &rod.text).unwrap();
        rod
    }

    fn rows(head: &str, drive: f64) -> String {
        let row = |k: u32| {
            let k = f64::from(k);
            let on = if (20.0..60.0).contains(&k) {
                drive
            } else {
                0.0
            };
            format!("{},{on},{:.3}\n", 0.1 * k, (0.1 * k).sin())
        };
        format!("{head}{}", (0..100).map(row).collect::<String>())
    }

    #[test]
    fn names_with_units_leave_the_room_to_ask_for() {
        let rod = begun(&rows(
            "Elapsed Time (sec),Wire Current (Amps),LVDT Position (mm)\n",
            0.5,
        ));
        assert_eq!(rod.questions.len(), 1, "{:?}", rod.questions);
        assert!(rod.text.contains("kind = \"current\""));
        assert!(
            rod.text
                .contains("drive = { name = \"Wire Current (Amps)\" }")
        );
    }

    #[test]
    fn what_is_guessed_is_asked() {
        let rod = begun(&rows("t,pwm,x\n", 200.0));
        let asked = rod.questions.join("\n");
        for expected in [
            "time = { name = \"t\", unit = \"s\" }: which unit?",
            "full_scale = 255 }: its highest is 200: is that its full scale?",
            "output = { name = \"x\" }: which unit?",
            "supply_v",
        ] {
            assert!(asked.contains(expected), "{asked}");
        }
    }

    #[test]
    fn without_a_header_values_speak() {
        let rod = begun(&rows("", 0.5));
        let asked = rod.questions.join("\n");
        assert!(
            asked.contains("time = { number = 1, unit = \"s\" }: is it this column?"),
            "{asked}"
        );
        assert!(
            asked.contains("drive = { number = 2, unit = \"A\" }"),
            "{asked}"
        );
        assert!(asked.contains("output = { number = 3 }"), "{asked}");
    }

    #[test]
    fn a_loop_over_a_temperature_needs_no_time() {
        let rod = begun("Temp [C],Strain [%]\n20,0.1\n40,0.3\n60,0.9\n40,0.7\n");
        assert!(rod.text.contains("kind = \"temperature\""));
        assert!(!rod.text.contains("every_s"), "{}", rod.text);
    }

    #[test]
    fn a_temperature_beside_a_drive_is_the_output() {
        let rod = begun(&rows("Time (s),PWM (%),Temperature\n", 40.0));
        assert_eq!(
            rod.questions,
            ["output = { name = \"Temperature\", unit = \"degc\" }: which unit: degc, k, degf?"]
        );
        assert!(!rod.text.contains("\n[surroundings]"), "{}", rod.text);
        let fahrenheit = begun(&rows("Time (s),Current (A),Temp (F)\n", 0.5));
        assert_eq!(fahrenheit.questions, [""; 0]);
    }

    #[test]
    fn without_names_and_time_a_temperature_is_known_by_its_values() {
        let row = |k: u32| {
            let phase = f64::from(k) / 20.0;
            format!(
                "{:.2}\t{:.5}\n",
                80.0 - 50.0 * phase.cos(),
                0.02 * phase.sin()
            )
        };
        let rod = begun(&(0..400).map(row).collect::<String>());
        assert!(
            rod.text.contains("drive = { number = 1, unit = \"degc\" }"),
            "{}",
            rod.text
        );
        assert!(rod.text.contains("output = { number = 2 }"), "{}", rod.text);
        // A drive that jumps is none.
        let row = |k: u32| format!("{}\t{:.5}\n", 50 * (k / 20 % 2), f64::from(k % 77).sin());
        let rod = begun(&(0..400).map(row).collect::<String>());
        assert!(!rod.text.contains("kind = \"temperature\""), "{}", rod.text);
    }
}
