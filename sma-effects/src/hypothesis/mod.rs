//! Effects that are not in the catalogue: described in a file by an expression.

mod expression;
mod file;
mod own;
mod vanishing;

use std::path::Path;

use crate::{EffectBlock, EffectInfo, PhysicsError, Role};
use expression::Expression;
pub(crate) use own::{Own, OwnMemory, SeenState};

/// Most hypotheses at once.
pub(crate) const MOST_HYPOTHESES: usize = 4;
/// Most parameters of a hypothesis.
pub(crate) const MOST_PARAMETERS: usize = 4;
/// Variables that an expression may use besides its parameters; `y` is last, because only a displacement has it.
const VARIABLES: [&str; 7] = ["T", "Ta", "xi", "drive", "t", "dir", "y"];
/// Number of the time among them.
const TIME: usize = 4;

/// An effect of one's own: a term at one place of the cascade, written as an expression.
///
/// ```toml
/// [[hypothesis]]                          # at most 4
/// id = "stronger-convection"              # letters, digits and hyphens; not one of the catalogue
/// name = "convection that grows with temperature"    # default: the id in words
/// sentence = "the rod loses {value} more" # default: made from the name; {value} is the size with its unit, {partner} the partner
/// belongs_to = "rig"                      # or "recording": the default if the term uses t
/// heat_flow_w_per_m = "-k * (T - Ta)^1.25"
///
/// [hypothesis.parameters.k]               # 1 to 4
/// unit = "W/(m K^1.25)"
/// typical = 0.02                          # what counts as an ordinary value
/// bounds = [0.0, 1.0]                     # both accepted
/// size = true                             # the default: zero in the baseline
/// ```
///
/// Exactly one of the places is given:
///
/// | key | the term | unit |
/// | --- | --- | --- |
/// | `drive` | is added to the drive; a duty stays within 0 and 1, a power at or above 0 | that of the drive |
/// | `heat_flow_w_per_m` | heats the rod | W/m |
/// | `shift_k` | shifts the loop upward | K |
/// | `displacement` | is added to the output, behind all other effects | that of the output |
///
/// Variables: `T` and `Ta`, temperature of the rod and of the surroundings as recorded, °C; `xi`,
/// transformed share, 0 cold to 1 hot; `drive`, in its unit; `t`, time since the start of the recording, s;
/// `dir`, +1 if the rod's temperature last rose, -1 if it last fell; `y`, the displacement before the term, in
/// `displacement` only. Operators + - * / ^ and parentheses; `pi`; abs sign sqrt cbrt exp ln log10 sin cos tan
/// asin acos atan sinh cosh tanh, and min and max of two arguments or more. At most 1000 characters and
/// 32 parentheses deep. `-x^2` is -(x^2). A power of a negative number whose exponent is no integer
/// is odd, (-x)^p = -(x^p), so that a law of flow holds both ways.
///
/// With all sizes 0 the term must vanish in every state: [`Hypothesis::parse`] tries some thousand states. A
/// parameter with `size = false` is a partner: it has no influence then, and screening tries values of it within
/// its bounds. Its effect has the name of the parameter behind the id: `stronger_convection_k`.
///
/// A term that belongs to a recording is held to account within it and not carried to another, see
/// [`Belongs`](crate::Belongs). In all other respects a hypothesis is treated as an effect that not every rod has. It
/// is like no other effect, needs nothing of a recording, and its sizes are expected up to six times the typical
/// ones, see [`SizePrior`](crate::SizePrior).
///
/// **Accuracy.** A term of drive, heat flow or shift is evaluated once a sample (or sub-step, see
/// [`Setting::sub_steps`](crate::Setting::sub_steps)), at its beginning, and held: its error is of first order in
/// dt/τ, where effects of the catalogue are of second. A displacement is evaluated at the instant that is shown.
/// In a rod with cold ends, heat flow and shift are those of each zone; drive and displacement see the mean
/// over the length, `dir` the middle. Before the first sample the drive is 0, and the surroundings have the
/// rod's temperature.
///
/// **Where a term has no value** (√-1, 1/0, an overflow), the plant has none from there on: temperature or displacement
/// are NaN, which a fit rejects. Write `max(T - Ta, 0)` where only one side is meant.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    info: &'static EffectInfo,
    place: Place,
    term: Expression,
}

/// Where a term acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    Drive,
    HeatFlow,
    Shift,
    Displacement,
}

impl Place {
    const ALL: [Self; 4] = [Self::Drive, Self::HeatFlow, Self::Shift, Self::Displacement];

    /// Key in a file.
    const fn key(self) -> &'static str {
        match self {
            Self::Drive => "drive",
            Self::HeatFlow => "heat_flow_w_per_m",
            Self::Shift => "shift_k",
            Self::Displacement => "displacement",
        }
    }

    const fn block(self) -> EffectBlock {
        match self {
            Self::Drive => EffectBlock::Drive,
            Self::HeatFlow => EffectBlock::HeatBalance,
            Self::Shift => EffectBlock::Transformation,
            Self::Displacement => EffectBlock::Displacement,
        }
    }
}

/// Most bytes of a file of hypotheses.
const MOST_BYTES: u64 = 1 << 20;

impl Hypothesis {
    /// Reads a file of hypotheses, in its order.
    ///
    /// # Errors
    ///
    /// [`PhysicsError::Unreadable`], and as [`Hypothesis::parse`].
    pub fn read(path: &Path) -> Result<&'static [Self], PhysicsError> {
        let file = path.display().to_string();
        let unreadable = |why: String| PhysicsError::Unreadable {
            file: file.clone(),
            why,
        };
        // A pipe may never give anything, and a device never end.
        let kind = std::fs::metadata(path).map_err(|error| unreadable(error.to_string()))?;
        if !kind.is_file() {
            let found = if kind.is_dir() {
                "a folder"
            } else {
                "a pipe or a device"
            };
            return Err(unreadable(format!("is {found}; expected a file")));
        }
        if kind.len() > MOST_BYTES {
            return Err(unreadable(format!(
                "is larger than {MOST_BYTES} bytes, the most that is read of such a file"
            )));
        }
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
        Self::parse(&file, &text)
    }

    /// Reads the text of such a file; `file` is its name for errors. The hypotheses are kept for the life of the program,
    /// as the catalogue is; equal texts give the same slice, so that reading a file again keeps nothing more.
    ///
    /// # Errors
    ///
    /// [`PhysicsError::Toml`] for what is no such file, [`PhysicsError::Hypothesis`] for a value that is not
    /// accepted, each with line and column.
    pub fn parse(file: &str, text: &str) -> Result<&'static [Self], PhysicsError> {
        file::parse(file, text)
    }

    /// Facts about it, as about an effect of the catalogue: sizes before partners.
    #[must_use]
    pub fn info(&self) -> &'static EffectInfo {
        self.info
    }

    /// Its expression, as written.
    #[must_use]
    pub fn expression(&self) -> &str {
        self.term.text()
    }

    /// Values for [`EffectValues::own`](crate::EffectValues::own): sizes at `multiple` times the typical ones,
    /// partners at theirs. With 0 it is the baseline.
    #[must_use]
    pub fn values(&self, multiple: f64) -> [f64; MOST_PARAMETERS] {
        let mut values = [0.0; MOST_PARAMETERS];
        for (value, parameter) in values.iter_mut().zip(self.info.parameters) {
            *value = match parameter.role {
                Role::Size => multiple * parameter.typical,
                Role::Partner { .. } => parameter.typical,
            };
        }
        values
    }

    /// Checks that each value is within its bounds, and that each value without a parameter is 0.
    pub(crate) fn checked(
        hypotheses: &'static [Self],
        values: &[[f64; MOST_PARAMETERS]; MOST_HYPOTHESES],
    ) -> Result<(), PhysicsError> {
        for (number, of_one) in values.iter().enumerate() {
            let parameters = hypotheses
                .get(number)
                .map_or(&[][..], |hypothesis| hypothesis.info.parameters);
            for (index, &value) in of_one.iter().enumerate() {
                let Some(parameter) = parameters.get(index) else {
                    if value.abs() <= 0.0 {
                        continue;
                    }
                    return Err(PhysicsError::NoOwnParameter {
                        hypothesis: number,
                        parameter: index,
                        value,
                    });
                };
                if !parameter.accepts(value) {
                    return Err(PhysicsError::OutOfBounds {
                        effect: hypotheses[number].info.id,
                        name: parameter.name,
                        value,
                        unit: parameter.unit,
                        lower: parameter.bounds[0],
                        upper: parameter.bounds[1],
                    });
                }
            }
        }
        Ok(())
    }
}
