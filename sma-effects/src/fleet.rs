use wiener::{
    Block, Drives, Fleet, Input, Lanes, NARROW, Output, Profile, Shown, Start, Stretch, WIDE,
    WienerParams, lockstep,
};

use crate::plant::Plants;
use crate::state::PlantsState;
use crate::{EffectId, EffectValues, PhysicsError, Setting};

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
    /// Setting common to all members.
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

    fn started<const L: usize>(&self, members: &[Member; L]) -> Result<Running<L>, PhysicsError> {
        let plants = Box::new(Plants::new(
            &self.setting,
            &members.each_ref().map(|member| member.params),
            &members.each_ref().map(|member| member.effects),
        )?);
        let state = Box::new(plants.starting(&members.each_ref().map(|member| member.start)));
        Ok(Running { plants, state })
    }

    fn side_by_side(&self, members: &[Member; WIDE]) -> Result<SideBySide, PhysicsError> {
        let small = |chunk: usize| -> Result<_, PhysicsError> {
            self.started::<NARROW>(&core::array::from_fn(|l| members[NARROW * chunk + l]))
        };
        Ok(SideBySide {
            chunks: [small(0)?, small(1)?],
        })
    }
}

impl Fleet for Extended {
    type Member = Member;
    type Error = PhysicsError;

    fn narrow(
        &self,
        members: &[Member; NARROW],
    ) -> Result<Box<dyn Lanes<NARROW> + Send>, PhysicsError> {
        Ok(Box::new(self.started(members)?))
    }

    fn alone(&self, member: &Member) -> Result<Option<Box<dyn Lanes + Send>>, PhysicsError> {
        Ok(Some(Box::new(self.started(&[*member])?)))
    }

    fn wide(&self, members: &[Member; WIDE]) -> Result<Box<dyn Lanes<WIDE> + Send>, PhysicsError> {
        if self.setting.active.contains(EffectId::EndConduction) {
            return Ok(Box::new(self.side_by_side(members)?));
        }
        Ok(Box::new(self.started(members)?))
    }
}

/// Plants on their way. Boxed: they are large, and would be copied each time that they change hands.
#[derive(Debug)]
struct Running<const L: usize> {
    plants: Box<Plants<L>>,
    state: Box<PlantsState<L>>,
}

impl<const L: usize> Lanes<L> for Running<L> {
    fn output(&self) -> Output<L> {
        self.plants.output(&self.state)
    }

    fn run(&mut self, stretch: &Stretch<'_, L>, shown: &mut Shown<'_, L>) {
        self.plants.run(&mut self.state, stretch, shown);
    }
}

/// A full chunk of rods with ends: small ones. Their zones are more than the caches hold of a full one, which takes longer.
#[derive(Debug)]
struct SideBySide {
    chunks: [Running<NARROW>; WIDE / NARROW],
}

impl Lanes<WIDE> for SideBySide {
    fn output(&self) -> Output<WIDE> {
        let of_chunks = self.chunks.each_ref().map(Lanes::output);
        let lane = |of_chunk: &dyn Fn(&Output<NARROW>) -> [f64; NARROW]| {
            core::array::from_fn(|l| of_chunk(&of_chunks[l / NARROW])[l % NARROW])
        };
        Output {
            displacement: lane(&|chunk| chunk.displacement),
            temperature_degc: lane(&|chunk| chunk.temperature_degc),
        }
    }

    fn run(&mut self, stretch: &Stretch<'_, WIDE>, shown: &mut Shown<'_, WIDE>) {
        for (c, chunk) in self.chunks.iter_mut().enumerate() {
            let lanes = NARROW * c..NARROW * (c + 1);
            for k in 0..stretch.dt_s.len() {
                let mut drive = [0.0; NARROW];
                match stretch.drive {
                    Drives::Common(common) => drive = [common[k]; NARROW],
                    Drives::Each(drives) => drive.copy_from_slice(&drives[k][lanes.clone()]),
                }
                let Output {
                    displacement,
                    temperature_degc,
                } = chunk.output();
                shown.displacement[k][lanes.clone()].copy_from_slice(&displacement);
                shown.temperature_degc[k][lanes.clone()].copy_from_slice(&temperature_degc);
                let input = Input {
                    drive,
                    ambient_degc: stretch.ambient_degc[k],
                };
                chunk.step(&input, stretch.dt_s[k]);
            }
        }
    }
}
