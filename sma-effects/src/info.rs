//! What is said of an effect, apart from its equation.

/// What is known of an effect before any recording is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectInfo {
    /// Name in files, flags and reports.
    pub id: &'static str,
    /// Name in a sentence.
    pub name: &'static str,
    /// Where it acts.
    pub block: EffectBlock,
    /// Whether it can take so many shapes that a good fit does not license its name.
    pub flexible: bool,
    /// How the output follows its sizes.
    pub smoothness: Smoothness,
    /// What must be known before it can be computed, or told from others.
    pub needs: &'static [Need],
    /// Its parameters, sizes before partners.
    pub parameters: &'static [EffectParameter],
    /// What it adds to the model, in a line; the effect's own documentation says it exactly.
    pub equation: &'static str,
    /// Sentence for a report. `{value}` stands for the size with its unit (of several, for the one
    /// that its name rests on, which has a `least`, or the largest in magnitude), `{partner}` for the partner with its unit.
    pub sentence: &'static str,
}

impl EffectInfo {
    /// The partner that screening varies, the first: its number among the parameters and the values to try; `None` if
    /// there is none. Others stay at their typical values until a fit moves them.
    #[must_use]
    pub fn screened_partner(&self) -> Option<(usize, &'static [f64])> {
        let mut numbered = self.parameters.iter().enumerate();
        numbered.find_map(|(number, parameter)| match parameter.role {
            Role::Partner { grid } => Some((number, grid)),
            Role::Size => None,
        })
    }
}

/// Block of the cascade in which an effect sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EffectBlock {
    /// Between the drive and the heat in the rod.
    Drive,
    /// What heats and cools the rod.
    HeatBalance,
    /// From temperature to fraction.
    Transformation,
    /// From fraction to the measured output.
    Displacement,
    /// Between the rod and a recorded temperature.
    Sensor,
}

impl EffectBlock {
    /// Name in files and reports.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            EffectBlock::Drive => "drive",
            EffectBlock::HeatBalance => "heat-balance",
            EffectBlock::Transformation => "transformation",
            EffectBlock::Displacement => "displacement",
            EffectBlock::Sensor => "sensor",
        }
    }
}

/// How the output follows the sizes of an effect near zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Smoothness {
    /// Differentiable: secants of a thousandth and of a millionth of the typical size agree within 1 %.
    Smooth,
    /// Differentiable at zero but for a few samples beside each reversal, whose number grows with the
    /// size: the secant holds only while the size is far below the travel between reversals.
    CornersAtReversals,
}

/// What an effect needs beyond drive and displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Need {
    /// Temperatures on the Celsius scale: parameters whose scale is assumed give a meaningless size.
    AbsoluteTemperature,
    /// [`Setting::mass_kg_per_m`](crate::Setting::mass_kg_per_m).
    MassPerMeter,
    /// [`Setting::surface_m2_per_m`](crate::Setting::surface_m2_per_m).
    SurfacePerMeter,
    /// [`Setting::run_length_s`](crate::Setting::run_length_s).
    RunLength,
    /// A drive that depends on the resistance: not a power.
    ElectricalDrive,
    /// A recorded temperature of the rod.
    TemperatureChannel,
    /// A load that grows with the stroke; to be told from the loop's own width, a second load.
    Load,
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    /// Name, with its unit where it has one.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// What counts as an ordinary value; of a two-sided size, its magnitude.
    pub typical: f64,
    /// Physical bounds, both accepted.
    pub bounds: [f64; 2],
    /// Magnitude of a size below which the name does not fit, whatever it is that the recordings show; 0 where all do.
    pub least: f64,
    /// Whether it is zero in the baseline.
    pub role: Role,
    /// Range in the literature, if known.
    pub literature: Option<Literature>,
    /// Whether a recorded temperature alone tells it: without, no value does better than another, and it is best held
    /// as in the baseline.
    pub needs_thermometer: bool,
    /// Unit where the setting has no [`Setting::length_output`](crate::Setting::length_output), if that is another: see
    /// [`Setting::unit_of`](crate::Setting::unit_of).
    pub unit_without_length: Option<&'static str>,
}

/// What a parameter is in the baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// Zero in the baseline. With all sizes of an effect 0 the plant has the bits of the baseline.
    Size,
    /// Without influence where the size is zero, and so without a value there: screening tries these.
    Partner {
        /// Values to try; none but for the first partner.
        grid: &'static [f64],
    },
}

/// Whether a parameter may be negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sign {
    /// Zero or more: tests against zero are one-sided.
    NonNegative,
    /// Both signs make sense.
    Either,
}

/// A range found in the literature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Literature {
    /// Its ends, in the parameter's unit; magnitudes for a two-sided size.
    pub range: [f64; 2],
    /// Where it comes from.
    pub source: &'static str,
    /// Whether somebody looked it up for this project. Do not quote what is unchecked.
    pub checked: bool,
}

impl EffectParameter {
    pub(crate) const fn size(unit: &'static str, typical: f64, bounds: [f64; 2]) -> Self {
        Self {
            name: "",
            unit,
            typical,
            bounds,
            least: 0.0,
            role: Role::Size,
            literature: None,
            needs_thermometer: false,
            unit_without_length: None,
        }
    }

    pub(crate) const fn partner(
        unit: &'static str,
        typical: f64,
        bounds: [f64; 2],
        grid: &'static [f64],
    ) -> Self {
        Self {
            role: Role::Partner { grid },
            ..Self::size(unit, typical, bounds)
        }
    }

    pub(crate) const fn literature(self, range: [f64; 2], source: &'static str) -> Self {
        Self {
            literature: Some(Literature {
                range,
                source,
                checked: true,
            }),
            ..self
        }
    }

    pub(crate) const fn unchecked(self, range: [f64; 2], source: &'static str) -> Self {
        Self {
            literature: Some(Literature {
                range,
                source,
                checked: false,
            }),
            ..self
        }
    }

    pub(crate) const fn at_least(self, least: f64) -> Self {
        Self { least, ..self }
    }

    pub(crate) const fn told_by_thermometer(self) -> Self {
        Self {
            needs_thermometer: true,
            ..self
        }
    }

    pub(crate) const fn without_length(self, unit: &'static str) -> Self {
        Self {
            unit_without_length: Some(unit),
            ..self
        }
    }

    pub(crate) const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Whether it may be negative.
    #[must_use]
    pub const fn sign(&self) -> Sign {
        if self.bounds[0] < 0.0 {
            Sign::Either
        } else {
            Sign::NonNegative
        }
    }

    /// Value in the baseline: 0 for a size, the typical one for a partner.
    #[must_use]
    pub const fn neutral(&self) -> f64 {
        match self.role {
            Role::Size => 0.0,
            Role::Partner { .. } => self.typical,
        }
    }

    /// Whether a value is a number within the bounds.
    #[must_use]
    pub fn accepts(&self, value: f64) -> bool {
        (self.bounds[0]..=self.bounds[1]).contains(&value)
    }
}
