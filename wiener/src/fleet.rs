//! Many plants in lockstep: dispatch and chunking, no equations.

use crate::{Input, Plant, Profile};

/// Lanes of a full chunk: four vectors of eight, enough to hide the latency of one another.
const WIDE: usize = 32;
/// Lanes of a chunk between: the eight trials of a least-squares search and differences by eight parameters.
const MEDIUM: usize = 16;
/// Lanes of a small chunk: one vector of eight.
const NARROW: usize = 8;
/// Samples simulated before the visitor sees them: its rows stay in the first-level cache.
const BLOCK: usize = 32;

/// Plants of one kind that [`lockstep`] runs side by side: how to make `L` of them.
///
/// [`Ensemble`](crate::Ensemble) is the fleet of Wiener models; an extended plant has its own.
pub trait Fleet {
    /// What tells one plant from another, and where it starts.
    type Member: Copy;
    /// What can be wrong with a member.
    type Error;
    /// Makes the plants of `L` members, lane by lane, with the state that they start from.
    ///
    /// Lanes must not influence each other. Mark [`Plant::output`] and [`Plant::step`] and what they
    /// call `#[inline(always)]`, or they stay compiled for the narrowest vectors.
    ///
    /// # Errors
    ///
    /// What is wrong with a member.
    fn start<const L: usize>(
        &self,
        members: &[Self::Member; L],
    ) -> Result<Started<L, impl Plant<L>>, Self::Error>;
}

/// `L` plants side by side and the state that they start from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Started<const L: usize, Q: Plant<L>> {
    /// The plants.
    pub plant: Q,
    /// Their state.
    pub state: Q::State,
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

/// Runs all members of a fleet through the profile on the widest vectors the machine has. `visit` sees
/// blocks of outputs: member after member in chunks, sample after sample within a chunk. Memory does
/// not grow with the profile.
///
/// Each member's outputs are the same bits as from [`run`](crate::run) on that plant alone, if its lanes
/// keep to plain arithmetic.
///
/// # Errors
///
/// That of [`Fleet::start`] for the first chunk that it refuses; `visit` may have seen blocks of the
/// members before it.
pub fn lockstep<F: Fleet>(
    fleet: &F,
    members: &[F::Member],
    profile: &Profile<'_>,
    visit: &mut dyn FnMut(Block<'_>),
) -> Result<(), F::Error> {
    let mut first = 0;
    while first < members.len() {
        let rest = &members[first..];
        // Equal bits at every width: the choice is one of speed only.
        first += match rest.len() {
            1 => chunk::<1, F>(fleet, rest, first, profile, visit)?,
            n if n <= NARROW => chunk::<NARROW, F>(fleet, rest, first, profile, visit)?,
            n if n <= MEDIUM => chunk::<MEDIUM, F>(fleet, rest, first, profile, visit)?,
            _ => chunk::<WIDE, F>(fleet, rest, first, profile, visit)?,
        };
    }
    Ok(())
}

/// Runs as many of `members` as fit in `L` lanes; returns how many.
fn chunk<const L: usize, F: Fleet>(
    fleet: &F,
    members: &[F::Member],
    first_member: usize,
    profile: &Profile<'_>,
    visit: &mut dyn FnMut(Block<'_>),
) -> Result<usize, F::Error> {
    let count = members.len().min(L);
    // Empty lanes repeat the last member.
    let lanes: [F::Member; L] = core::array::from_fn(|l| members[l.min(count - 1)]);
    let Started { plant, mut state } = fleet.start(&lanes)?;
    let mut displacement = [[0.0; L]; BLOCK];
    let mut temperature_degc = [[0.0; L]; BLOCK];
    for first_sample in (0..profile.len()).step_by(BLOCK) {
        let length = BLOCK.min(profile.len() - first_sample);
        widest_vectors(
            #[inline(always)]
            || {
                for row in 0..length {
                    let output = plant.output(&state);
                    displacement[row] = output.displacement;
                    temperature_degc[row] = output.temperature_degc;
                    advance(&plant, &mut state, profile, first_sample + row);
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

#[inline(always)]
fn advance<const L: usize, Q: Plant<L>>(
    plant: &Q,
    state: &mut Q::State,
    profile: &Profile<'_>,
    sample: usize,
) {
    let input = Input {
        drive: [profile.drive(sample); L],
        ambient_degc: profile.ambient_degc(sample),
    };
    plant.step(state, &input, profile.dt_s(sample));
}

/// Runs plain loops compiled for the widest vectors the machine has: chosen at run time, one binary
/// for all machines. Without fused multiply-add in the source the bits are equal on all of them.
///
/// Mark the closure and what it calls `#[inline(always)]`, or it stays compiled for the narrowest.
#[inline(always)]
pub fn widest_vectors<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
