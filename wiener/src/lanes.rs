use crate::{Input, Output, Plant};

/// Samples that plants side by side go through: what drives them, and how long each lasts.
///
/// The three series have one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch<'a, const L: usize = 1> {
    /// Drive of each sample.
    pub drive: Drives<'a, L>,
    /// Temperature of the surroundings in each sample, °C.
    pub ambient_degc: &'a [f64],
    /// Length of each sample, s; ≥ 0.
    pub dt_s: &'a [f64],
}

/// Drives of the samples of a [`Stretch`], in the unit of the plants' [`Drive`](crate::Drive).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drives<'a, const L: usize = 1> {
    /// One for all plants: a profile.
    Common(&'a [f64]),
    /// One a plant: controllers.
    Each(&'a [[f64; L]]),
}

/// `L` plants on their way: what a simulation or a controller needs of them, whatever they are.
///
/// Used as a trait object, so that equations are compiled once, in the crate that owns them, and not again for
/// each caller.
pub trait Lanes<const L: usize = 1> {
    /// Present outputs of the plants.
    fn output(&self) -> Output<L>;

    /// Moves the plants on through all samples of a stretch. Row k of `shown` receives what they show *before* sample
    /// k acts.
    ///
    /// # Panics
    ///
    /// If a series of the stretch or `shown` is shorter than another.
    fn run(&mut self, stretch: &Stretch<'_, L>, shown: &mut Shown<'_, L>);

    /// Moves the plants on by one sample.
    fn step(&mut self, input: &Input<L>, dt_s: f64) {
        let stretch = Stretch {
            drive: Drives::Each(&[input.drive]),
            ambient_degc: &[input.ambient_degc],
            dt_s: &[dt_s],
        };
        let mut shown = Shown {
            displacement: &mut [[0.0; L]],
            temperature_degc: &mut [[0.0; L]],
        };
        self.run(&stretch, &mut shown);
    }
}

/// Room for the outputs of a [`Stretch`]: a row a sample, a column a plant.
#[derive(Debug, PartialEq)]
pub struct Shown<'a, const L: usize = 1> {
    /// Displacement, in the unit of the plants' gain.
    pub displacement: &'a mut [[f64; L]],
    /// Temperature of the rod, °C.
    pub temperature_degc: &'a mut [[f64; L]],
}

/// `L` plants side by side and the state that they are in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Started<const L: usize, Q: Plant<L>> {
    /// The plants.
    pub plant: Q,
    /// Their state.
    pub state: Q::State,
}

impl<const L: usize, Q: Plant<L>> Lanes<L> for Started<L, Q> {
    #[inline(always)]
    fn output(&self) -> Output<L> {
        self.plant.output(&self.state)
    }

    #[inline(always)]
    fn run(&mut self, stretch: &Stretch<'_, L>, shown: &mut Shown<'_, L>) {
        for k in 0..stretch.dt_s.len() {
            let Output {
                displacement,
                temperature_degc,
            } = self.plant.output(&self.state);
            shown.displacement[k] = displacement;
            shown.temperature_degc[k] = temperature_degc;
            let input = Input {
                drive: match stretch.drive {
                    Drives::Common(drive) => [drive[k]; L],
                    Drives::Each(drives) => drives[k],
                },
                ambient_degc: stretch.ambient_degc[k],
            };
            self.plant.step(&mut self.state, &input, stretch.dt_s[k]);
        }
    }

    #[inline(always)]
    fn step(&mut self, input: &Input<L>, dt_s: f64) {
        self.plant.step(&mut self.state, input, dt_s);
    }
}

#[cfg(feature = "std")]
impl<const L: usize, Q> Started<L, Q>
where
    Q: Plant<L, State: Send> + Send + 'static,
{
    /// The plants as a trait object, compiled for the widest vectors that the machine has.
    ///
    /// Call it in a function that is not generic, or every caller compiles the plants again.
    #[must_use]
    pub fn boxed(self) -> Box<dyn Lanes<L> + Send> {
        Box::new(OnWidestVectors(self))
    }
}

/// Plants whose equations are compiled for each instruction set.
#[cfg(feature = "std")]
struct OnWidestVectors<T>(T);

#[cfg(feature = "std")]
impl<const L: usize, T: Lanes<L>> Lanes<L> for OnWidestVectors<T> {
    fn output(&self) -> Output<L> {
        self.0.output()
    }

    fn run(&mut self, stretch: &Stretch<'_, L>, shown: &mut Shown<'_, L>) {
        crate::widest_vectors(
            #[inline(always)]
            || self.0.run(stretch, shown),
        );
    }
}
