//! The reversals that a path has not wiped out, by Madelung's rules.

/// Smallest movement back that counts as a reversal, K: what rounding moves at rest is none.
const DEAD_BAND_K: f64 = 1e-8;

/// A point of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn {
    pub(crate) temperature_degc: f64,
    pub(crate) fraction: f64,
}

/// Starts of the branches that enclose the present one, outermost first; they rise and fall in turn. With no
/// start, the path falls from far above.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reversals {
    /// True if all reversals count; false if only the last one does.
    nested: bool,
    rising: bool,
    starts: Vec<Turn>,
    /// The farthest point of the present branch.
    furthest: Turn,
}

/// The branch on which a path ends: how many starts are kept, and which is added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Recall {
    pub(crate) rising: bool,
    kept: usize,
    added: Option<Turn>,
}

impl Reversals {
    /// Fallen to `furthest` from far above.
    pub(crate) fn fallen_to(furthest: Turn, nested: bool) -> Self {
        Self {
            nested,
            rising: false,
            starts: Vec::new(),
            furthest,
        }
    }

    /// The branch on which the path is.
    pub(crate) fn present(&self) -> Recall {
        Recall {
            rising: self.rising,
            kept: self.starts.len(),
            added: None,
        }
    }

    /// The branch on which a straight path ends at `temperature_degc`.
    pub(crate) fn recall(&self, temperature_degc: f64) -> Recall {
        let mut recall = self.present();
        let back_k = self.furthest.temperature_degc - temperature_degc;
        if (if self.rising { back_k } else { -back_k }) > DEAD_BAND_K {
            recall.rising = !self.rising;
            recall.added = Some(self.furthest);
        }
        while let Some(target) = self.target(&recall) {
            let left_k = target.temperature_degc - temperature_degc;
            if (if recall.rising { left_k } else { -left_k }) >= 0.0 {
                break;
            }
            // The loop has closed: it and its two reversals count no more.
            recall.kept -= if recall.added.is_some() { 1 } else { 2 };
            recall.added = None;
        }
        recall
    }

    /// Where the branch starts.
    pub(crate) fn start(&self, recall: &Recall) -> Option<Turn> {
        recall
            .added
            .or_else(|| self.starts[..recall.kept].last().copied())
    }

    /// Where the branch ends, if it starts within another: there it goes on as the one before.
    pub(crate) fn target(&self, recall: &Recall) -> Option<Turn> {
        if !self.nested {
            return None;
        }
        let starts = &self.starts[..recall.kept];
        match recall.added {
            Some(_) => starts.last().copied(),
            None => starts.len().checked_sub(2).map(|k| starts[k]),
        }
    }

    /// Goes to `end` along the branch.
    pub(crate) fn follow(&mut self, recall: &Recall, end: Turn) {
        let turned = recall.rising != self.rising || recall.kept != self.starts.len();
        self.starts.truncate(recall.kept);
        if let Some(turn) = recall.added {
            if !self.nested {
                self.starts.clear();
            }
            self.starts.push(turn);
        }
        self.rising = recall.rising;
        let gain_k = end.temperature_degc - self.furthest.temperature_degc;
        if turned || (if self.rising { gain_k } else { -gain_k }) >= 0.0 {
            self.furthest = end;
        }
    }

    /// How many reversals are remembered.
    pub(crate) fn depth(&self) -> usize {
        self.starts.len()
    }
}
