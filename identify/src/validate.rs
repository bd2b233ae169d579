use recording::order::rising;
use recording::{HOLD_TOLERANCE, Recording};

use crate::beginnings::beginnings;
use crate::fit::{distinct, range, root_mean_square, squares_about_own_mean};
use crate::least_squares::{LeastSquaresConfig, Minimum};
use crate::of_rig::OfRig;
use crate::problem::Problem;
use crate::quantities::{Quantities, same_quantities};
use crate::refine::ends;
use crate::thermal_model::rest_tells_all;
use crate::thinned::thinned;
use crate::{Enters, Fit, ForwardModel, IdentifyError, ParameterInfo};

/// Fewest samples at rest from which an offset is taken: fewer would carry their noise into it.
const FEWEST_AT_REST: usize = 10;

/// Where the offset of a validation recording was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OffsetSource {
    /// From the samples before the drive first rises.
    BeforeDrive {
        /// Their number.
        n_samples: usize,
    },
    /// Over the whole recording: too few samples stand before the drive rises.
    WholeRecording {
        /// Their number.
        at_rest: usize,
    },
    /// Over the whole recording: its drive never rises, so that it tests nothing.
    NeverDriven,
}

impl OffsetSource {
    /// Where the offset of a recording is read; `parameters` are those of the model with the recording's own way to begin.
    fn of(parameters: &[ParameterInfo], recording: &Recording) -> Self {
        let at_rest = samples_at_rest(recording);
        if at_rest == recording.len() {
            Self::NeverDriven
        } else if at_rest >= FEWEST_AT_REST && rest_tells_all(parameters) {
            Self::BeforeDrive { n_samples: at_rest }
        } else {
            Self::WholeRecording { at_rest }
        }
    }
}

/// How well a fitted model meets a recording that it has not seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Validated {
    /// Name of the recording.
    pub name: String,
    /// Root mean square of recording - model, in the output unit.
    pub rmse: f64,
    /// 1 - RMSE / standard deviation of the output; `None` if the output never changes.
    pub fit_fraction: Option<f64>,
    /// Number of samples.
    pub n_samples: usize,
    /// Highest less lowest output, in the output unit.
    pub output_range: f64,
    /// Offset of this recording, in the output unit.
    pub offset: f64,
    /// Where the offset was read.
    pub offset_source: OffsetSource,
    /// Values of all parameters, in the model's order: what [`predict`](crate::predict) takes.
    pub point: Vec<f64>,
}

impl Validated {
    fn with_error(
        recording: &Recording,
        rmse: f64,
        (offset, offset_source): (f64, OffsetSource),
        point: Vec<f64>,
    ) -> Self {
        let output = recording.output();
        let output_range = range(output);
        let spread = squares_about_own_mean(output) / output.len() as f64;
        Self {
            name: recording.name().to_owned(),
            rmse,
            fit_fraction: (output_range > 0.0).then(|| 1.0 - rmse / spread.sqrt()),
            n_samples: recording.len(),
            output_range,
            offset,
            offset_source,
            point,
        }
    }

    /// Root mean square over all samples of several recordings, in the output unit; `None` if there are none.
    #[must_use]
    pub fn rmse_of_all<'a>(validated: impl IntoIterator<Item = &'a Self>) -> Option<f64> {
        let (mut n, mut sum) = (0, 0.0);
        for one in validated {
            n += one.n_samples;
            sum += one.rmse * one.rmse * one.n_samples as f64;
        }
        (n > 0).then(|| (sum / n as f64).sqrt())
    }
}

/// Predicts a recording with the shared parameters frozen.
///
/// Only the recording's own parameters are set, by a rule that is the same for every model: its offset from the
/// samples before the drive first rises, or over the whole recording if there are fewer than ten, or if they cannot tell it
/// (surroundings and start of a heat balance together); its start is at rest, unless it may begin warm
/// ([`may_begin_warm`](crate::may_begin_warm)), where it is found over the whole recording. Parameters fixed at another
/// value stay.
///
/// # Errors
///
/// Any error of the model.
pub fn validate(
    model: &dyn ForwardModel,
    fit: &Fit,
    recording: &Recording,
) -> Result<Validated, IdentifyError> {
    let expected = Quantities {
        output_unit: &fit.output_unit,
        drive: fit.drive_quantity,
        drive_unit: &fit.drive_unit,
    };
    same_quantities(recording, &fit.recordings[0].name, &expected)?;
    validate_at(model, &fit.point(0), recording)
}

/// Predicts a recording with the shared values of a point frozen, such as one of `Refined::points`; see
/// [`validate`](crate::validate()). The recording must be in the units that the values are for.
///
/// # Errors
///
/// Any error of the model.
pub fn validate_at(
    model: &dyn ForwardModel,
    point: &[f64],
    recording: &Recording,
) -> Result<Validated, IdentifyError> {
    let mut frozen = OfRig::at(model, point);
    frozen.begin_as(recording);
    let mut problem = Problem::new(&frozen, std::slice::from_ref(recording))?;
    let offset_source = OffsetSource::of(&frozen.parameters, recording);
    if let OffsetSource::BeforeDrive { n_samples } = offset_source {
        let weight = |k| f64::from(u8::from(k < n_samples));
        problem.weigh_samples(vec![(0..recording.len()).map(weight).collect()]);
    }
    let few = match offset_source {
        OffsetSource::BeforeDrive { .. } => None,
        _ => thinned(std::slice::from_ref(recording), ENOUGH)?,
    };
    let starts = match &few {
        Some(few) => begun(&Problem::new(&frozen, few)?)?,
        None => beginnings(&problem)?,
    };
    let ends = ends(&problem, &starts, &LeastSquaresConfig::default())?;
    let lowest = ends
        .into_iter()
        .min_by(|(a, _), (b, _)| a.sum_of_squares.total_cmp(&b.sum_of_squares));
    let (point, solved) = match lowest {
        Some((end, solved)) => (end.point, solved),
        // Nothing is sought, or no start leads anywhere.
        None => {
            let first = starts.into_iter().next().unwrap_or_default();
            let solved = problem.solve_one(&first)?;
            (first, solved)
        }
    };
    let residuals = problem.residuals(&point, &solved)?;
    Ok(Validated::with_error(
        recording,
        root_mean_square(&residuals[0].values),
        (solved.offsets[0], offset_source),
        problem.values(&point, &solved, 0),
    ))
}

/// Samples on which the beginning of a long recording is sought before it is sought on all.
const ENOUGH: usize = 10_000;

/// Places where a search of how a recording began ends on few of its samples: the lowest, and others that are nearly as low.
fn begun(few: &Problem<'_>) -> Result<Vec<Vec<f64>>, IdentifyError> {
    let ends = ends(few, &beginnings(few)?, &LeastSquaresConfig::default())?;
    let mut minima: Vec<Minimum> = ends.into_iter().map(|(end, _)| end).collect();
    rising(&mut minima, |end| end.sum_of_squares);
    let minima = distinct(&minima, few.bounds()).into_iter();
    Ok(minima.map(|end| end.point).collect())
}

/// Validation on a recording where its own parameters have these values, and the model meets it with this root mean square error.
///
/// `point` has the values of all parameters, in the model's order; its offset is 0 if the model has none.
#[must_use]
pub fn validated_with(
    model: &dyn ForwardModel,
    point: Vec<f64>,
    recording: &Recording,
    rmse: f64,
) -> Validated {
    let mut frozen = OfRig::at(model, &point);
    frozen.begin_as(recording);
    let mut infos = frozen.parameters.iter();
    let offset = infos.position(|info| info.enters == Enters::Offset);
    let offset = offset.map_or(0.0, |place| point[place]);
    let source = OffsetSource::of(&frozen.parameters, recording);
    Validated::with_error(recording, rmse, (offset, source), point)
}

/// Samples before a drive first rises from its lowest level by more than a hundredth of its range,
/// the one at which it does included: its output is read before. All, if none ever does.
pub(crate) fn samples_at_rest(recording: &Recording) -> usize {
    let of_each = recording.drives().map(before_rise);
    of_each.fold(recording.len(), usize::min)
}

fn before_rise(drive: &[f64]) -> usize {
    let size = drive.iter().map(|drive| drive.abs());
    let lowest = size.clone().fold(f64::INFINITY, f64::min);
    let highest = size.clone().fold(0.0, f64::max);
    let level = lowest + HOLD_TOLERANCE * (highest - lowest);
    match size.clone().position(|size| size > level) {
        Some(0) => 0,
        Some(k) => k + 1,
        None => drive.len(),
    }
}
