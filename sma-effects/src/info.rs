//! Facts about an effect, apart from its equation.

use crate::{EffectId, EffectParameter, Role};

/// Facts about an effect that are known before any recording is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectInfo {
    /// Name in files, flags and reports.
    pub id: &'static str,
    /// Name in a sentence.
    pub name: &'static str,
    /// Where it acts.
    pub block: EffectBlock,
    /// True if it can take so many shapes that a good fit does not license its name.
    pub flexible: bool,
    /// How the output follows its sizes.
    pub smoothness: Smoothness,
    /// Data that must be known before it can be computed, or distinguished from others.
    pub needs: &'static [Need],
    /// Its parameters, sizes before partners.
    pub parameters: &'static [EffectParameter],
    /// Its term in the model, in a line; the effect's own documentation gives it exactly.
    pub equation: &'static str,
    /// Sentence for a report. `{value}` stands for the size with its unit (of several, for the one
    /// that its name rests on, which has a `least`, or the largest in magnitude), `{partner}` for the partner with its unit.
    pub sentence: &'static str,
    /// Whose its values are.
    pub belongs_to: Belongs,
    /// How likely a rig has it, before any recording.
    pub presence: Presence,
    /// Those that do the same to the displacement in every rig as long as the drive is slow: losses that grow faster than
    /// the temperature, delays, slow shifts of the loop. Symmetrical and transitive: groups.
    pub acts_like: &'static [EffectId],
    /// Occurrences that the recordings must contain. If any one of them is missing, the effect does nothing, or acts as
    /// parameters of the baseline model do, whatever its size. An occurrence without which the effect is merely faint is not
    /// listed, because the smallest detectable size shows that.
    pub needs_in_recording: &'static [Occurrence],
    /// True if a simulation takes ten times as long, because the rod has several zones.
    pub costly: bool,
    /// True if a [`LoopFamily`](wiener::hysteresis::LoopFamily) other than the paper's is reported under its name.
    pub names_loop_families: bool,
    /// True if it changes nothing but how the output follows the temperature and its past, as another formula of the loop does.
    pub like_loop: bool,
    /// True if a recorded temperature of the surroundings already contains it, so that a thermometer beside the rod settles
    /// it.
    pub settled_by_ambient_record: bool,
    /// Change of the baseline model that acts as its mean over the recording: the part that cannot be distinguished from the
    /// rig.
    pub mean_acts_as: Option<ActsAs>,
}

impl EffectInfo {
    /// An effect of the rig that not every rod has, is like no other, and acts in every recording; all else is empty.
    pub(crate) const ORDINARY: Self = Self {
        id: "",
        name: "",
        block: EffectBlock::Displacement,
        flexible: false,
        smoothness: Smoothness::Smooth,
        needs: &[],
        parameters: &[],
        equation: "",
        sentence: "",
        belongs_to: Belongs::Rig,
        presence: Presence::Seldom,
        acts_like: &[],
        needs_in_recording: &[],
        costly: false,
        names_loop_families: false,
        like_loop: false,
        settled_by_ambient_record: false,
        mean_acts_as: None,
    };

    /// True if physics knows it in every rod, whatever its size.
    #[must_use]
    pub const fn in_every_rod(&self) -> bool {
        matches!(self.presence, Presence::EveryRod)
    }

    /// True if it acts alike in every recording: it belongs to the rig, and has a form of its own.
    #[must_use]
    pub const fn is_rigid(&self) -> bool {
        !self.flexible && matches!(self.belongs_to, Belongs::Rig)
    }

    /// True if it is an effect of the thermometer, not of the rod: with its sizes 0 a plant shows the rod's own temperature.
    #[must_use]
    pub const fn is_of_sensor(&self) -> bool {
        matches!(self.block, EffectBlock::Sensor)
    }

    /// Natural logarithm of the prior density of its values, in the order of its parameters, over that of the mode; at most
    /// 0, and -∞ if one is out of bounds or there are more or fewer than it has parameters.
    ///
    /// Sizes count by themselves, since they are different things. Those of a flexible effect are points of one curve,
    /// which are large together: the least likely of them counts, once.
    #[must_use]
    pub fn ln_prior(&self, values: &[f64]) -> f64 {
        if values.len() != self.parameters.len() {
            return f64::NEG_INFINITY;
        }
        let of_each = self.parameters.iter().zip(values);
        let of_each = of_each.map(|(parameter, &value)| parameter.ln_prior(value));
        if self.flexible {
            of_each.fold(0.0, f64::min)
        } else {
            of_each.sum()
        }
    }

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
    /// Heating and cooling of the rod.
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

/// Data that an effect needs beyond drive and displacement.
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
    /// [`Setting::largest_drive`](crate::Setting::largest_drive).
    LargestDrive,
    /// A drive that depends on the resistance: not a power.
    ElectricalDrive,
    /// A recorded temperature of the rod.
    TemperatureChannel,
    /// A load that grows with the stroke; to be told from the loop's own width, a second load.
    Load,
}

/// Whose the values of an effect are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Belongs {
    /// The rig's: the same in every recording of it.
    Rig,
    /// A recording's: a drift. It is held to account within it, and never carried to another.
    Recording,
    /// The rig's, by a law of the cycles since the recording began: neither the same in every recording nor free in each.
    /// It is to be asked only of recordings that start from the same state.
    History,
}

impl Belongs {
    /// Name in files.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Rig => "rig",
            Self::Recording => "recording",
            Self::History => "history",
        }
    }
}

/// How likely a rig has an effect, before any recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Presence {
    /// Physics knows it in every rod; at issue is whether it is large enough to show.
    EveryRod,
    /// Some rigs have it.
    Seldom,
}

impl Presence {
    /// Natural logarithm of the odds that a model needs it.
    ///
    /// | presence | odds | basis |
    /// | --- | --- | --- |
    /// | every rod | 1 | nothing speaks for or against its being large enough |
    /// | seldom | e⁻³, 1 to 20 | chosen: one of the twenty-two effects is expected in a rig that something is wrong with |
    #[must_use]
    pub const fn ln_odds(self) -> f64 {
        match self {
            Self::EveryRod => 0.0,
            Self::Seldom => -3.0,
        }
    }
}

/// Event that happens to a rod in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Occurrence {
    /// It follows three levels of the drive or more: they last, or are gone through slowly, in one recording or in several.
    FollowedLevels,
    /// It transforms while it cools.
    Cooling,
    /// It transforms while it heats and while it cools, in one recording or in two.
    BothBranches,
    /// It turns from heating to cooling or back, and moves.
    Reversal,
    /// It turns twice in a row in the midst of the transformation, and goes beyond the first turn.
    InnerReversals,
    /// Its transformations, partial ones by their share, add up to more than one cycle.
    SecondCycle,
}

impl Occurrence {
    /// Name in files and reports.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::FollowedLevels => "followed-levels",
            Self::Cooling => "cooling",
            Self::BothBranches => "both-branches",
            Self::Reversal => "reversal",
            Self::InnerReversals => "inner-reversals",
            Self::SecondCycle => "second-cycle",
        }
    }
}

/// Change of a parameter of the baseline model that acts as an effect of size 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActsAs {
    /// Name of that parameter.
    pub parameter: &'static str,
    /// Its change, in its unit over that of the effect's parameter.
    pub per_unit: f64,
}
