//! Many plants in lockstep: chunking, no equations.

use crate::{Drives, Lanes, Profile, Shown, Stretch};

/// Lanes of a full chunk: four vectors of eight, enough to hide the latency of one another.
pub const WIDE: usize = 32;
/// Lanes of a chunk between: three vectors of eight, for what is left of a swarm of fifty beside a full one.
pub const MEDIUM: usize = 24;
/// Lanes of a small chunk: two vectors of eight. With eight lanes alone compilers unroll loops before they see that they
/// are vectors, and a chunk takes nearly as long.
pub const NARROW: usize = 16;
/// Samples simulated before the visitor sees them: its rows stay in the first-level cache.
const BLOCK: usize = 32;

/// Plants of one kind that [`lockstep`] runs side by side: how to make chunks of them.
///
/// [`Ensemble`](crate::Ensemble) is the fleet of Wiener models; an extended plant has its own. Implementors make the
/// plants with one function that is generic over the number of lanes, and return
/// [`Started::boxed`](crate::Started::boxed). Lanes must not influence each other. Mark
/// [`Plant::output`](crate::Plant::output) and [`Plant::step`](crate::Plant::step) and what they call
/// `#[inline(always)]`, or they stay compiled for the narrowest vectors.
pub trait Fleet {
    /// Parameters of one plant, and its start.
    type Member: Copy;
    /// Error in a member.
    type Error;

    /// Makes a small chunk of plants, in the state that they start from.
    ///
    /// # Errors
    ///
    /// The error in a member.
    fn narrow(
        &self,
        members: &[Self::Member; NARROW],
    ) -> Result<Box<dyn Lanes<NARROW> + Send>, Self::Error>;

    /// Makes one plant, in the state that it starts from; `None`, as by default, if a small chunk takes no longer.
    ///
    /// # Errors
    ///
    /// The error in the member.
    fn alone(&self, _member: &Self::Member) -> Result<Option<Box<dyn Lanes + Send>>, Self::Error> {
        Ok(None)
    }

    /// Makes a chunk between, in the state that its plants start from; `None`, as by default, if a full one stands for it.
    ///
    /// # Errors
    ///
    /// The error in a member.
    fn medium(
        &self,
        _members: &[Self::Member; MEDIUM],
    ) -> Result<Option<Box<dyn Lanes<MEDIUM> + Send>>, Self::Error> {
        Ok(None)
    }

    /// Makes a full chunk of plants, in the state that they start from.
    ///
    /// # Errors
    ///
    /// The error in a member.
    fn wide(
        &self,
        members: &[Self::Member; WIDE],
    ) -> Result<Box<dyn Lanes<WIDE> + Send>, Self::Error>;
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
/// That of [`Fleet::alone`], [`Fleet::narrow`], [`Fleet::medium`] or [`Fleet::wide`] for the first chunk that it refuses; `visit` may have seen blocks of the
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
        if let [member] = rest
            && let Some(mut lane) = fleet.alone(member)?
        {
            show(&mut *lane, 1, first, profile, visit);
            first += 1;
        } else if rest.len() <= NARROW {
            let mut lanes = fleet.narrow(&padded(rest))?;
            show(&mut *lanes, rest.len().min(NARROW), first, profile, visit);
            first += NARROW;
        } else if rest.len() <= MEDIUM
            && let Some(mut lanes) = fleet.medium(&padded(rest))?
        {
            show(&mut *lanes, rest.len(), first, profile, visit);
            first += MEDIUM;
        } else {
            let mut lanes = fleet.wide(&padded(rest))?;
            show(&mut *lanes, rest.len().min(WIDE), first, profile, visit);
            first += WIDE;
        }
    }
    Ok(())
}

/// The first `L` of the members; empty lanes repeat the last one.
///
/// # Panics
///
/// If there are no members.
#[must_use]
pub fn padded<T: Copy, const L: usize>(members: &[T]) -> [T; L] {
    core::array::from_fn(|l| members[l.min(members.len() - 1)])
}

/// Runs a chunk whose first `members` lanes count.
fn show<const L: usize>(
    lanes: &mut dyn Lanes<L>,
    members: usize,
    first_member: usize,
    profile: &Profile<'_>,
    visit: &mut dyn FnMut(Block<'_>),
) {
    let mut displacement = [[0.0; L]; BLOCK];
    let mut temperature_degc = [[0.0; L]; BLOCK];
    let [mut drive, mut ambient_degc, mut dt_s] = [[0.0; BLOCK]; 3];
    let mut before_s = f64::NAN;
    for first_sample in (0..profile.len()).step_by(BLOCK) {
        let length = BLOCK.min(profile.len() - first_sample);
        for row in 0..length {
            drive[row] = profile.drive(first_sample + row);
            ambient_degc[row] = profile.ambient_degc(first_sample + row);
            before_s = profile.dt_s(first_sample + row, before_s);
            dt_s[row] = before_s;
        }
        let stretch = Stretch {
            drive: Drives::Common(&drive[..length]),
            ambient_degc: &ambient_degc[..length],
            dt_s: &dt_s[..length],
        };
        let mut shown = Shown {
            displacement: &mut displacement[..length],
            temperature_degc: &mut temperature_degc[..length],
        };
        lanes.run(&stretch, &mut shown);
        visit(Block {
            first_member,
            members,
            first_sample,
            stride: L,
            displacement: displacement[..length].as_flattened(),
            temperature_degc: temperature_degc[..length].as_flattened(),
        });
    }
}
