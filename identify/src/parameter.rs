use pso::Bound;

/// Whether recordings share a value.
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// As it is.
    Linear,
    /// Its logarithm: for what is positive and known to a factor only.
    Logarithmic,
}

/// Whether a parameter is sought.
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

/// What is known of a parameter before a fit.
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
}

impl ParameterInfo {
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

    /// Whether nothing is searched.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What is known of the parameters, in the model's order.
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
