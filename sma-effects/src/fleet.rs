use wiener::{Block, Fleet, Plant, Profile, Start, Started, WienerParams, lockstep};

use crate::{EffectValues, ExtendedPlant, PhysicsError, Setting};

/// One model of an [`Extended`] fleet, and where it starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// Parameters of the baseline.
    pub params: WienerParams,
    /// Values of the effects; the default is the baseline.
    pub effects: EffectValues,
    /// Its start.
    pub start: Start,
}

/// Many extended plants with one setting, driven by one profile, in lockstep on the widest vectors the
/// machine has.
///
/// Each member's outputs are the same bits as from [`run`](wiener::run) on that plant alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extended {
    /// What all members have in common.
    pub setting: Setting,
}

impl Extended {
    /// Runs all members through the profile; see [`lockstep`].
    ///
    /// # Errors
    ///
    /// [`PhysicsError`] naming the value of a member that is out of range; `visit` may have seen blocks
    /// of the members before it.
    pub fn run(
        &self,
        members: &[Member],
        profile: &Profile<'_>,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), PhysicsError> {
        lockstep(self, members, profile, visit)
    }
}

impl Fleet for Extended {
    type Member = Member;
    type Error = PhysicsError;

    fn start<const L: usize>(
        &self,
        members: &[Member; L],
    ) -> Result<Started<L, impl Plant<L>>, PhysicsError> {
        let plant = ExtendedPlant::new(
            &self.setting,
            &members.map(|member| member.params),
            &members.map(|member| member.effects),
        )?;
        let state = plant.between_limiting_curves(
            members.map(|member| member.start.temperature_degc),
            members.map(|member| member.start.share),
        );
        Ok(Started { plant, state })
    }
}
