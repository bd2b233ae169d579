//! `sma init`: from a file of a logger to a rod file to begin with.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use recording::{Meaning, Survey, SurveyedColumn, survey};
use workbench::{Place, WorkbenchError, first_rod};

use crate::outcome::Outcome;
use crate::terminal::write_stdout;

/// Look at a recording, say what its columns are, and write a rod file to begin with.
///
/// Guesses stand in that file with a question mark.
#[derive(Debug, Args)]
#[command(before_help = "Example:\n  sma init run1.csv run2.csv --rod rod.toml")]
pub(crate) struct InitArgs {
    /// Recordings: anything that looks like a table. The first decides; the others must have its columns.
    #[arg(required = true, value_name = "CSV")]
    recordings: Vec<PathBuf>,
    /// The rod file to write.
    #[arg(long, value_name = "TOML", default_value = "rod.toml")]
    rod: PathBuf,
    /// Write over a rod file that is there.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub(crate) fn run(args: &InitArgs) -> anyhow::Result<Outcome> {
    if args.rod.exists() && !args.force {
        let path = args.rod.clone();
        return Err(WorkbenchError::Exists { path }.into());
    }
    let inputs: Vec<&std::path::Path> = args.recordings.iter().map(PathBuf::as_path).collect();
    let place = Place::open(&args.rod, &inputs)?;
    let surveys = args
        .recordings
        .iter()
        .map(|path| Ok(survey(path)?))
        .collect::<anyhow::Result<Vec<Survey>>>()?;
    let names = |survey: &Survey| -> Vec<Option<String>> {
        survey
            .columns
            .iter()
            .map(|column| column.name.clone())
            .collect()
    };
    if let Some(other) = surveys.iter().find(|one| names(one) != names(&surveys[0])) {
        let (file, first) = (other.file.clone(), surveys[0].file.clone());
        return Err(WorkbenchError::OtherColumns { file, first }.into());
    }
    let rod = first_rod(&surveys[0]);
    place.write(&rod.text)?;
    let mut text = String::new();
    for survey in &surveys {
        text += &said(survey);
    }
    let written = args.rod.display();
    // Writing to a string does not fail.
    let _ = match rod.questions.len() {
        0 => writeln!(text, "\n{written} is written."),
        _ => writeln!(text, "\n{written} is written. Please look at:"),
    };
    for question in &rod.questions {
        let _ = writeln!(text, "  ? {question}");
    }
    let files: Vec<&str> = surveys.iter().map(|one| one.file.as_str()).collect();
    // The last of several tests the fit of the others.
    let recordings = match files.as_slice() {
        [training @ .., last] if !training.is_empty() => {
            format!("{} --validate {last}", training.join(" "))
        }
        all => all.join(" "),
    };
    let _ = writeln!(
        text,
        "\nNext: sma inspect {} --rod {written}\n      sma identify {written} --train {recordings}",
        files[0]
    );
    write_stdout(&text)?;
    Ok(Outcome::Done)
}

/// The columns of a file.
fn said(survey: &Survey) -> String {
    let mut text = format!("{}: {} rows\n", survey.file, survey.n_rows);
    for adaptation in &survey.adaptations {
        let _ = writeln!(text, "  read as: {adaptation}");
    }
    let name = |column: &SurveyedColumn| match &column.name {
        Some(name) => name.clone(),
        None => format!("column {}", column.number),
    };
    let widest = survey
        .columns
        .iter()
        .map(|one| name(one).chars().count())
        .max();
    let width = widest.unwrap_or(0).max("column".len());
    let _ = writeln!(
        text,
        "  {:width$}  {:>12}  {:>12}  taken for",
        "column", "lowest", "highest"
    );
    for column in &survey.columns {
        let meaning = match column.meaning {
            None => "-".to_owned(),
            Some(Meaning::Time) => "time".to_owned(),
            Some(Meaning::Drive(quantity)) => format!("drive, {}", quantity.name()),
            Some(Meaning::Output) => "output".to_owned(),
            Some(Meaning::Temperature) => "temperature".to_owned(),
            Some(Meaning::Ambient) => "ambient".to_owned(),
            Some(Meaning::Stress) => "stress".to_owned(),
            Some(Meaning::Resistance) => "resistance".to_owned(),
        };
        let doubt = if column.is_said {
            ""
        } else {
            " (by its values)"
        };
        let [lowest, highest] = match (column.n_numbers, column.holds_stamps) {
            (_, true) => ["stamps".to_owned(), String::new()],
            (0, _) => ["no numbers".to_owned(), String::new()],
            _ => [column.lowest, column.highest].map(|value| value.to_string()),
        };
        let _ = writeln!(
            text,
            "  {:width$}  {lowest:>12}  {highest:>12}  {meaning}{doubt}",
            name(column)
        );
    }
    text
}
