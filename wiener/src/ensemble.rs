use sma_hysteresis::Rule;

use crate::{
    Block, Drive, Fleet, Lanes, MEDIUM, NARROW, Profile, Start, Started, WIDE, Wiener, WienerError,
    WienerParams, lockstep,
};

/// One model of an ensemble, and where it starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// Its parameters.
    pub params: WienerParams,
    /// Its start.
    pub start: Start,
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
        lockstep(self, members, profile, visit)
    }

    fn started<const L: usize>(
        &self,
        members: &[Member; L],
    ) -> Result<Started<L, Wiener<L>>, WienerError> {
        let plant = Wiener::new(
            self.drive,
            self.rule,
            &members.each_ref().map(|member| member.params),
        )?;
        let state = plant.starting(&members.each_ref().map(|member| member.start));
        Ok(Started { plant, state })
    }
}

impl Fleet for Ensemble {
    type Member = Member;
    type Error = WienerError;

    fn narrow(
        &self,
        members: &[Member; NARROW],
    ) -> Result<Box<dyn Lanes<NARROW> + Send>, WienerError> {
        Ok(self.started(members)?.boxed())
    }

    fn alone(&self, member: &Member) -> Result<Option<Box<dyn Lanes + Send>>, WienerError> {
        Ok(Some(self.started(&[*member])?.boxed()))
    }

    fn medium(
        &self,
        members: &[Member; MEDIUM],
    ) -> Result<Option<Box<dyn Lanes<MEDIUM> + Send>>, WienerError> {
        Ok(Some(self.started(members)?.boxed()))
    }

    fn wide(&self, members: &[Member; WIDE]) -> Result<Box<dyn Lanes<WIDE> + Send>, WienerError> {
        Ok(self.started(members)?.boxed())
    }
}
