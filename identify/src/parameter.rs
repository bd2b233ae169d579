use pso::Bound;
use serde::{Deserialize, Serialize};

/// Scope of a parameter: all recordings, or one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One value for all recordings: a property of the rod.
    Shared,
    /// One for each recording: where the sensor's zero was, how the run began.
    PerRecording,
}

/// How a parameter enters the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enters {
    /// Through the simulation.
    Nonlinear,
    /// As the factor in output = gain × shape + offset: solved for, not searched.
    Gain,
    /// As the offset of that line.
    Offset,
}

/// On which scale a parameter is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// As it is.
    Linear,
    /// Its logarithm: for what is positive and known to a factor only.
    Logarithmic,
}

/// State of a parameter in a fit: free or fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterState {
    /// Sought within its bounds.
    Free,
    /// Known.
    Fixed(f64),
}

/// Closed range of a parameter, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
}

impl Bounds {
    /// The range of some values; upside down without any.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let none = Self {
            lower: f64::INFINITY,
            upper: f64::NEG_INFINITY,
        };
        values.fold(none, |range, value| Self {
            lower: range.lower.min(value),
            upper: range.upper.max(value),
        })
    }

    /// No bounds at all.
    pub const NONE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
    };

    /// The upper end less the lower one.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.upper - self.lower
    }
}

/// Definition of a parameter before a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterInfo {
    /// Name, with its unit where it has a fixed one.
    pub name: &'static str,
    /// Unit; "1" for a pure number.
    pub unit: String,
    /// Range, in `unit`. Not used for gain and offset, which are solved for.
    pub bounds: Bounds,
    /// Values that mean something, in `unit`: what a user may ask for.
    pub admissible: Bounds,
    /// Scale of the search.
    pub scale: Scale,
    /// Shared, or one a recording.
    pub scope: Scope,
    /// How it enters the output.
    pub enters: Enters,
    /// Free or fixed.
    pub state: ParameterState,
    /// Prior of the parameter; `None` if it has none.
    pub ordinary: Option<Ordinary>,
}

/// Prior of a parameter on a linear scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ordinary {
    /// Standard deviation about 0, in the parameter's unit; > 0.
    pub deviation: f64,
    /// True if the deviation is about the parameter before it instead of about 0: the next knot of a curve.
    pub from_previous: bool,
}

impl ParameterInfo {
    /// A shared parameter that is searched within bounds; on a logarithmic scale it is positive.
    #[must_use]
    pub fn searched(name: &'static str, unit: &str, scale: Scale, bounds: Bounds) -> Self {
        Self {
            name,
            unit: unit.to_owned(),
            bounds,
            admissible: match scale {
                Scale::Linear => Bounds {
                    lower: -1e12,
                    upper: 1e12,
                },
                Scale::Logarithmic => Bounds {
                    lower: 1e-12,
                    upper: 1e12,
                },
            },
            scale,
            scope: Scope::Shared,
            enters: Enters::Nonlinear,
            state: ParameterState::Free,
            ordinary: None,
        }
    }

    /// The factor of the output, in its unit.
    #[must_use]
    pub fn gain(output_unit: &str) -> Self {
        Self {
            enters: Enters::Gain,
            ..Self::searched("gain", output_unit, Scale::Linear, Bounds::NONE)
        }
    }

    /// The offset of each recording's output, in its unit.
    #[must_use]
    pub fn offset(output_unit: &str) -> Self {
        Self {
            scope: Scope::PerRecording,
            enters: Enters::Offset,
            ..Self::searched("offset", output_unit, Scale::Linear, Bounds::NONE)
        }
    }

    fn is_searched(&self) -> bool {
        self.enters == Enters::Nonlinear && self.state == ParameterState::Free
    }

    fn on_search_scale(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.ln(),
        }
    }

    /// The values from `half` below a coordinate to `half` above it, as far as the bounds go.
    pub(crate) fn interval_around(&self, coordinate: f64, half: f64) -> Bounds {
        Bounds {
            lower: self.value_at(coordinate - half),
            upper: self.value_at(coordinate + half),
        }
    }

    fn value_at(&self, coordinate: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => coordinate,
            Scale::Logarithmic => coordinate.exp(),
        };
        // exp(ln x) may leave the range by rounding.
        value.clamp(self.bounds.lower, self.bounds.upper)
    }
}

/// The one place where named parameters become the vector that an optimizer sees, and back.
///
/// Its coordinates are the free nonlinear parameters on the scale of their search: first the shared
/// ones, then those of each recording in turn.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterVector {
    infos: Vec<ParameterInfo>,
    /// Indices into `infos` of the searched ones.
    shared: Vec<usize>,
    per_recording: Vec<usize>,
    n_recordings: usize,
}

impl ParameterVector {
    /// The vector of a model's parameters over some recordings.
    #[must_use]
    pub fn new(infos: &[ParameterInfo], n_recordings: usize) -> Self {
        let searched = |scope| {
            (0..infos.len())
                .filter(|&k| infos[k].is_searched() && infos[k].scope == scope)
                .collect()
        };
        Self {
            infos: infos.to_vec(),
            shared: searched(Scope::Shared),
            per_recording: searched(Scope::PerRecording),
            n_recordings,
        }
    }

    /// Number of coordinates.
    #[must_use]
    pub fn len(&self) -> usize {
        self.shared.len() + self.n_recordings * self.per_recording.len()
    }

    /// True if no parameter is searched.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Definitions of the parameters, in the model's order.
    #[must_use]
    pub fn infos(&self) -> &[ParameterInfo] {
        &self.infos
    }

    /// Bounds of the coordinates.
    #[must_use]
    pub fn bounds(&self) -> Vec<Bound> {
        (0..self.len())
            .map(|coordinate| {
                let info = &self.infos[self.parameter(coordinate)];
                Bound {
                    lower: info.on_search_scale(info.bounds.lower),
                    upper: info.on_search_scale(info.bounds.upper),
                }
            })
            .collect()
    }

    /// The coordinates that act on a recording.
    pub fn acting_on(&self, recording: usize) -> impl Iterator<Item = usize> + use<> {
        let own = self.per_recording.len();
        let first = self.shared.len() + recording * own;
        (0..self.shared.len()).chain(first..first + own)
    }

    /// Index of the parameter that a coordinate stands for.
    #[must_use]
    pub fn parameter(&self, coordinate: usize) -> usize {
        match coordinate.checked_sub(self.shared.len()) {
            None => self.shared[coordinate],
            Some(own) => self.per_recording[own % self.per_recording.len()],
        }
    }

    /// The coordinate that stands for a parameter in a recording; `None` if it is not searched.
    #[must_use]
    pub fn coordinate_of(&self, parameter: usize, recording: usize) -> Option<usize> {
        self.acting_on(recording)
            .find(|&coordinate| self.parameter(coordinate) == parameter)
    }

    /// The coordinates of known values, `value(parameter, recording)` in their units: as far as the bounds
    /// go, and the middle of the bounds where nothing is known.
    #[must_use]
    pub fn coordinates(&self, value: impl Fn(usize, usize) -> Option<f64>) -> Vec<f64> {
        self.bounds()
            .iter()
            .enumerate()
            .map(|(coordinate, bound)| {
                let own = coordinate.saturating_sub(self.shared.len());
                let recording = own / self.per_recording.len().max(1);
                let parameter = self.parameter(coordinate);
                match value(parameter, recording) {
                    Some(value) => self.infos[parameter]
                        .on_search_scale(value)
                        .clamp(bound.lower, bound.upper),
                    None => f64::midpoint(bound.lower, bound.upper),
                }
            })
            .collect()
    }

    /// Values of all parameters for one recording, in the model's order and in their units; gain and
    /// offset, which are solved for afterward, are 1 and 0.
    #[must_use]
    pub fn values(&self, coordinates: &[f64], recording: usize) -> Vec<f64> {
        let mut values: Vec<f64> = self
            .infos
            .iter()
            .map(|info| match (info.enters, info.state) {
                (Enters::Gain, _) => 1.0,
                (Enters::Offset, _) => 0.0,
                (Enters::Nonlinear, ParameterState::Fixed(value)) => value,
                (Enters::Nonlinear, ParameterState::Free) => f64::NAN,
            })
            .collect();
        for coordinate in self.acting_on(recording) {
            let parameter = self.parameter(coordinate);
            values[parameter] = self.infos[parameter].value_at(coordinates[coordinate]);
        }
        values
    }
}
