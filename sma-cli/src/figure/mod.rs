//! Figures as files: SVG for people and papers, and what is drawn as CSV.

mod compared;
mod diagnosed;
mod svg;
mod tracks;

use std::fmt::Write;
use std::fs::create_dir;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

pub(crate) use compared::Compared;
pub(crate) use diagnosed::{Drawn, figures};
pub(crate) use svg::inline;
pub(crate) use tracks::tracks;

use crate::sink::Sink;

/// Curves over one axis.
#[derive(Debug, Default)]
pub(crate) struct Figure {
    /// Its files' name without an ending.
    pub(crate) name: &'static str,
    /// What to see in it.
    pub(crate) caption: String,
    /// What stands across, with its unit, and what stands up.
    pub(crate) across: String,
    pub(crate) up: String,
    pub(crate) series: Vec<Series>,
    /// Stretches across that are shaded.
    pub(crate) shaded: Vec<[f64; 2]>,
    /// Words for 0, 1, 2, … across, where the curves are bars; empty for numbers.
    pub(crate) words: Vec<String>,
}

/// One curve of a figure.
#[derive(Debug)]
pub(crate) struct Series {
    pub(crate) label: String,
    pub(crate) style: Style,
    pub(crate) points: Vec<[f64; 2]>,
}

impl Series {
    pub(crate) fn new(
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
    pub(crate) fn over(label: impl Into<String>, style: Style, across: &[f64], up: &[f64]) -> Self {
        Self::new(label, style, across.iter().zip(up).map(|(&x, &y)| [x, y]))
    }
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Style {
    /// A broad gray line, beneath the others.
    Recorded,
    /// The plain model's color.
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

/// A folder for figures; it is made when there is something to put in it.
#[derive(Debug)]
pub(crate) struct Gallery(PathBuf);

impl Gallery {
    /// A folder that exists, or can be made.
    pub(crate) fn at(folder: &Path) -> anyhow::Result<Self> {
        if folder.exists() && !folder.is_dir() {
            bail!(
                "{}: is a file; give a folder for the figures",
                folder.display()
            );
        }
        let parent = folder
            .parent()
            .filter(|parent| !parent.as_os_str().is_empty());
        if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
            bail!(
                "{}: cannot be made: there is no folder {}",
                folder.display(),
                parent.display()
            );
        }
        Ok(Self(folder.to_owned()))
    }

    /// Writes the figures, each as SVG and as CSV.
    pub(crate) fn hang(&self, figures: &[Figure]) -> anyhow::Result<()> {
        let Self(folder) = self;
        if !folder.is_dir() {
            create_dir(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
        }
        for figure in figures {
            let file = |ending: &str| folder.join(figure.name).with_extension(ending);
            Sink::open(&file("svg"), &[])?.write(&svg::svg(figure)?)?;
            Sink::open(&file("csv"), &[])?.write(&figure.csv())?;
        }
        Ok(())
    }
}
