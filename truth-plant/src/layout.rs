use crate::TruthPlant;

/// Where the parts of the state stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Rods.
    pub(crate) strands: usize,
    /// Cells of a rod. The state begins with the enthalpies of all, over C_p, K.
    pub(crate) cells: usize,
    /// First of the fittings' temperatures, two a rod.
    pub(crate) fittings: Option<usize>,
    /// Temperature of the bead.
    pub(crate) bead: Option<usize>,
    /// Slipped distance.
    pub(crate) slip: Option<usize>,
    pub(crate) n_states: usize,
}

impl Layout {
    pub(crate) fn new(plant: &TruthPlant) -> Self {
        let strands = if plant.second_rod.is_some() { 2 } else { 1 };
        let cells = plant.rod.cells;
        let mut n_states = strands * cells;
        let mut take = |wanted: bool, n: usize| {
            wanted.then(|| {
                n_states += n;
                n_states - n
            })
        };
        let fittings = take(plant.end_fittings.is_some(), 2 * strands);
        let bead = take(plant.thermocouple.is_some(), 1);
        let slip = take(plant.mount_slip.is_some(), 1);
        Self {
            strands,
            cells,
            fittings,
            bead,
            slip,
            n_states,
        }
    }

    pub(crate) fn elements(&self) -> usize {
        self.strands * self.cells
    }
}
