//! Many models in lockstep: dispatch and chunking, no equations.

use sma_hysteresis::Rule;

use crate::{Drive, Input, Plant, Profile, State, Wiener, WienerError, WienerParams};

/// Lanes of a full chunk: four vectors of eight, enough to hide the latency of one another.
const WIDE: usize = 32;
/// Lanes of a small chunk: one vector of eight.
const NARROW: usize = 8;
/// Samples simulated before the visitor sees them: its rows stay in the first-level cache.
const BLOCK: usize = 32;

/// Where a model starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Temperature, °C.
    pub temperature_degc: f64,
    /// Place between the limiting curves, 0 (heating) to 1 (cooling).
    pub share: f64,
}

impl Start {
    /// At ambient, cooled along the limiting curve.
    #[must_use]
    pub fn rest(ambient_degc: f64) -> Self {
        Self {
            temperature_degc: ambient_degc,
            share: 1.0,
        }
    }
}

/// One model of an ensemble, and where it starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// Its parameters.
    pub params: WienerParams,
    /// Its start.
    pub start: Start,
}

/// A stretch of the outputs of some members.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    /// Index of the first member shown.
    pub first_member: usize,
    /// Number of members shown.
    pub members: usize,
    /// Index of the first sample shown.
    pub first_sample: usize,
    /// Values a row; those after `members` are padding.
    pub stride: usize,
    /// Displacement: a row a sample, a column a member.
    pub displacement: &'a [f64],
    /// Temperature of the rod, °C, in the same layout.
    pub temperature_degc: &'a [f64],
}

/// Many Wiener models driven by one profile, in lockstep on the widest vectors the machine has.
///
/// Each member's outputs are the same bits as from [`run`](crate::run) on that model alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ensemble {
    /// Drive common to all members.
    pub drive: Drive,
    /// Rule of memory common to all members.
    pub rule: Rule,
}

impl Ensemble {
    /// Runs all members through the profile. `visit` sees blocks of outputs: member after member in
    /// chunks, sample after sample within a chunk. Memory does not grow with the profile.
    ///
    /// # Errors
    ///
    /// [`WienerError`] naming the parameter of a member that is out of range; `visit` may have seen
    /// blocks of the members before it.
    pub fn run(
        &self,
        members: &[Member],
        profile: &Profile<'_>,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), WienerError> {
        let mut first = 0;
        while first < members.len() {
            let rest = &members[first..];
            // Equal bits at every width: the choice is one of speed only.
            first += match rest.len() {
                1 => self.chunk::<1>(rest, first, profile, visit)?,
                2..=NARROW => self.chunk::<NARROW>(rest, first, profile, visit)?,
                _ => self.chunk::<WIDE>(rest, first, profile, visit)?,
            };
        }
        Ok(())
    }

    /// Runs as many of `members` as fit in `L` lanes; returns how many.
    fn chunk<const L: usize>(
        &self,
        members: &[Member],
        first_member: usize,
        profile: &Profile<'_>,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<usize, WienerError> {
        let count = members.len().min(L);
        // Empty lanes repeat the last member.
        let lane = |l: usize| members[l.min(count - 1)];
        let model = Wiener::new(
            self.drive,
            self.rule,
            &core::array::from_fn(|l| lane(l).params),
        )?;
        let mut state = model.between_limiting_curves(
            core::array::from_fn(|l| lane(l).start.temperature_degc),
            core::array::from_fn(|l| lane(l).start.share),
        );
        let mut displacement = [[0.0; L]; BLOCK];
        let mut temperature_degc = [[0.0; L]; BLOCK];
        for first_sample in (0..profile.len()).step_by(BLOCK) {
            let length = BLOCK.min(profile.len() - first_sample);
            widest_vectors(
                #[inline(always)]
                || {
                    for row in 0..length {
                        let output = model.output(&state);
                        displacement[row] = output.displacement;
                        temperature_degc[row] = output.temperature_degc;
                        advance(&model, &mut state, profile, first_sample + row);
                    }
                },
            );
            visit(Block {
                first_member,
                members: count,
                first_sample,
                stride: L,
                displacement: displacement[..length].as_flattened(),
                temperature_degc: temperature_degc[..length].as_flattened(),
            });
        }
        Ok(count)
    }
}

#[inline(always)]
fn advance<const L: usize>(
    model: &Wiener<L>,
    state: &mut State<L>,
    profile: &Profile<'_>,
    sample: usize,
) {
    let input = Input {
        drive: [profile.drive(sample); L],
        ambient_degc: profile.ambient_degc(sample),
    };
    model.step(state, &input, profile.dt_s(sample));
}

/// Runs plain loops compiled for the widest vectors the machine has: chosen at run time, one binary
/// for all machines. Without fused multiply-add in the source the bits are equal on all of them.
///
/// Mark the closure and what it calls `#[inline(always)]`, or it stays compiled for the narrowest.
#[inline(always)]
pub fn widest_vectors<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
