/// Inputs that act on `L` plants during one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input<const L: usize = 1> {
    /// Drive, in the unit of the plant's [`Drive`](crate::Drive).
    pub drive: [f64; L],
    /// Temperature of the surroundings, °C.
    pub ambient_degc: f64,
}

/// Outputs of `L` plants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output<const L: usize = 1> {
    /// Displacement, in the unit of the plant's gain (mm, deg, N).
    pub displacement: [f64; L],
    /// Temperature of the rod, °C.
    pub temperature_degc: [f64; L],
}

/// An actuator as a controller or a fit sees it: `L` of them side by side.
///
/// Sample convention: the drive of sample k acts from t_k to t_(k+1); the output of sample k is that
/// of the state at t_k, before it.
pub trait Plant<const L: usize = 1> {
    /// All that the plant remembers. It belongs to the plant that made it: coefficients of that
    /// plant may be kept in it.
    type State: Clone;
    /// Cold and still: cooled to ambient along the limiting curve.
    fn rest(&self, ambient_degc: f64) -> Self::State;
    /// Outputs of the plant in a state.
    fn output(&self, state: &Self::State) -> Output<L>;
    /// Moves the state on by one sample of `dt_s` ≥ 0 seconds.
    ///
    /// Drive, ambient temperature and time must be finite, as [`Profile`](crate::Profile) checks: one
    /// `NaN` or ±∞ in them spoils the temperature, and with it all later outputs. A controller that
    /// decides the drive checks it itself.
    fn step(&self, state: &mut Self::State, input: &Input<L>, dt_s: f64);
}

impl<const L: usize, Q: Plant<L>> Plant<L> for &Q {
    type State = Q::State;

    fn rest(&self, ambient_degc: f64) -> Q::State {
        (**self).rest(ambient_degc)
    }

    #[inline(always)]
    fn output(&self, state: &Q::State) -> Output<L> {
        (**self).output(state)
    }

    #[inline(always)]
    fn step(&self, state: &mut Q::State, input: &Input<L>, dt_s: f64) {
        (**self).step(state, input, dt_s);
    }
}
