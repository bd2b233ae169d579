//! Figures as files: SVG for people and papers, and what is drawn as CSV.

mod compared;
mod diagnosed;
mod loops;
mod since;
mod svg;
mod tracks;

use std::fmt::Write;
use std::fs::create_dir;
use std::path::{Path, PathBuf};

pub use compared::Compared;
pub use diagnosed::{Drawn, figures, ladder, same_drive, series_csv};
pub use loops::loops;
pub use since::{BAND_DEVIATIONS, Since, with_change};
pub use svg::inline;
pub use tracks::tracks;

use crate::{Place, WorkbenchError};

/// Curves over one axis.
#[derive(Debug, Default)]
pub struct Figure {
    /// Its files' name without an ending.
    pub name: &'static str,
    /// Caption, which says what to see in it.
    pub caption: String,
    /// Label of the horizontal axis, with its unit.
    pub across: String,
    /// Label of the vertical axis, with its unit.
    pub up: String,
    /// The curves, drawn in this order.
    pub series: Vec<Series>,
    /// Stretches across that are shaded.
    pub shaded: Vec<[f64; 2]>,
    /// A band behind the curves: across, its lower end, its upper end.
    pub band: Vec<[f64; 3]>,
    /// True if the vertical axis is logarithmic; then all values are > 0.
    pub log_up: bool,
    /// Words for 0, 1, 2, … across, where the curves are bars; empty for numbers.
    pub words: Vec<String>,
}

/// One curve of a figure.
#[derive(Debug)]
pub struct Series {
    /// Its name in the legend.
    pub label: String,
    /// How it is drawn.
    pub style: Style,
    /// Points: across, up.
    pub points: Vec<[f64; 2]>,
}

impl Series {
    /// A curve of points: across, up.
    pub fn new(
        label: impl Into<String>,
        style: Style,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        Self {
            label: label.into(),
            style,
            points: points.into_iter().collect(),
        }
    }

    /// Values over others, one each.
    pub fn over(label: impl Into<String>, style: Style, across: &[f64], up: &[f64]) -> Self {
        Self::new(label, style, across.iter().zip(up).map(|(&x, &y)| [x, y]))
    }
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// A broad gray line, beneath the others.
    Recorded,
    /// The baseline model's color.
    Plain,
    /// That of the model with effects.
    Extended,
    /// That of an error on training recordings.
    Training,
    /// That of one on unseen recordings.
    Unseen,
    /// A thin black line.
    Noise,
}

impl Figure {
    /// All points, a line each: the curve, where it stands across, and how high.
    fn csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let mut csv = format!("curve,{},{}\n", quoted(&self.across), quoted(&self.up));
        for series in &self.series {
            for [x, y] in &series.points {
                // Writing to a string does not fail.
                let _ = writeln!(csv, "{},{x},{y}", quoted(&series.label));
            }
        }
        csv
    }
}

/// Label of an axis: a quantity and its unit, if it has one.
fn axis(quantity: &str, unit: &str) -> String {
    match unit {
        "1" => quantity.to_owned(),
        unit => format!("{quantity}, {unit}"),
    }
}

/// A folder for figures; it is made when there is something to put in it.
#[derive(Debug)]
pub struct Gallery(PathBuf);

impl Gallery {
    /// A folder that exists, or can be made.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::IsFile`], [`WorkbenchError::NoFolder`], [`WorkbenchError::HoldsInputs`] for a folder of one of the
    /// `inputs`.
    pub fn at(folder: &Path, inputs: &[&Path]) -> Result<Self, WorkbenchError> {
        if folder.exists() && !folder.is_dir() {
            return Err(WorkbenchError::IsFile {
                path: folder.to_owned(),
            });
        }
        let whole = folder.canonicalize().ok();
        let is_inside = |input: &Path| {
            let input = input.canonicalize().ok();
            let of_input = input.as_deref().and_then(Path::parent);
            of_input.is_some() && of_input == whole.as_deref()
        };
        if inputs.iter().copied().any(is_inside) {
            return Err(WorkbenchError::HoldsInputs {
                path: folder.to_owned(),
            });
        }
        let parent = folder
            .parent()
            .filter(|parent| !parent.as_os_str().is_empty());
        if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
            return Err(WorkbenchError::NoFolder {
                path: folder.to_owned(),
                action: "made",
                folder: parent.to_owned(),
            });
        }
        Ok(Self(folder.to_owned()))
    }

    /// Writes the figures, each as SVG and as CSV.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] if a figure cannot be drawn, or a file written.
    pub fn hang(&self, figures: &[Figure]) -> Result<(), WorkbenchError> {
        for figure in figures {
            self.write(&format!("{}.svg", figure.name), &svg::svg(figure)?)?;
            self.write(&format!("{}.csv", figure.name), &figure.csv())?;
        }
        Ok(())
    }

    /// Writes tables: the name of each file, and its text.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] if a file cannot be written.
    pub fn keep(&self, tables: &[(String, String)]) -> Result<(), WorkbenchError> {
        tables
            .iter()
            .try_for_each(|(name, text)| self.write(name, text))
    }

    fn write(&self, name: &str, text: &str) -> Result<(), WorkbenchError> {
        let Self(folder) = self;
        if !folder.is_dir() {
            create_dir(folder).map_err(|source| WorkbenchError::Make {
                path: folder.clone(),
                source,
            })?;
        }
        Place::open(&folder.join(name), &[])?.write(text)
    }
}
