//! Whoever watches a diagnosis, and may end it.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use identify::{FitProgress, ForwardModel, IdentifyError, ParameterInfo};
use recording::Recording;
use wiener::Block;

use crate::config::{DiagnoseConfig, Effort, Part};

/// How far a diagnosis is.
#[derive(Debug, Clone, PartialEq)]
pub enum DiagnoseProgress {
    /// The baseline is being fitted.
    Baseline(FitProgress),
    /// Models are being searched; told several times a second.
    Search {
        /// Step of the search.
        step: SearchStep,
        /// Points that were simulated so far, the baseline's not counted.
        simulations: u64,
    },
    /// The chosen model is being refitted from many starts.
    Refit,
    /// The mismatch is being located.
    Locate,
}

/// Step of a search, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SearchStep {
    /// Single effects beside the baseline model's loop.
    Effects,
    /// Loops of other families.
    OtherLoops,
    /// More effects than one, and effects beside other loops.
    MoreEffects,
    /// The models that could lead, on all the samples that judge.
    Judged,
}

/// Callback that is told how far a diagnosis is, and says whether it goes on. Any thread may call it, one at a time.
pub(crate) type Progress<'p> = dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p;

/// Time between two calls while effects are tried: as often as an eye can follow.
const APART: Duration = Duration::from_millis(50);

/// Observer that is asked before each simulation of a search.
pub(crate) trait Watch: fmt::Debug + Sync {
    /// Says whether the search goes on; `points` points are about to be simulated.
    fn goes_on(&self, points: usize) -> ControlFlow<()>;

    /// True if a part of the search is to be left out, which is remembered.
    fn leaves_out(&self, _: Part) -> bool {
        false
    }
}

/// Nobody watches.
#[derive(Debug)]
pub(crate) struct Unwatched;

impl Watch for Unwatched {
    fn goes_on(&self, _: usize) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The caller of a diagnosis watches.
pub(crate) struct Caller<'p> {
    told: Mutex<Told<'p>>,
    has_ended: AtomicBool,
    /// True while models are searched: other stages tell themselves how far they are.
    is_searching: AtomicBool,
    simulations: AtomicU64,
    effort: Effort,
    /// End of the time in which parts are begun that may be left out; `None` for no limit.
    deadline: Option<Instant>,
    /// Parts that were left out, as bits by their place in [`Part::ALL`].
    left_out: AtomicU64,
}

struct Told<'p> {
    progress: &'p mut Progress<'p>,
    last: Instant,
    /// Step of the search that is under way.
    step: SearchStep,
}

impl<'p> Caller<'p> {
    pub(crate) fn new(progress: &'p mut Progress<'p>, config: &DiagnoseConfig) -> Self {
        Self {
            effort: config.effort,
            deadline: config
                .time_limit
                .and_then(|limit| Instant::now().checked_add(limit)),
            left_out: AtomicU64::new(0),
            told: Mutex::new(Told {
                progress,
                last: Instant::now(),
                step: SearchStep::Effects,
            }),
            has_ended: AtomicBool::new(false),
            is_searching: AtomicBool::new(false),
            simulations: AtomicU64::new(0),
        }
    }

    /// Tells the caller, who may end the diagnosis.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Stopped`] if the caller does, or did.
    pub(crate) fn tell(&self, progress: DiagnoseProgress) -> Result<(), IdentifyError> {
        // A caller that panicked has no wish to go on.
        let goes_on = match self.told.lock() {
            Ok(mut told) => self.ask(&mut told, progress),
            Err(_) => ControlFlow::Break(()),
        };
        stopped(goes_on)
    }

    /// Tells the caller that a step of the search begins.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Stopped`] if the caller ends it, or did.
    pub(crate) fn begin(&self, step: SearchStep) -> Result<(), IdentifyError> {
        let simulations = self.simulations.load(Ordering::Relaxed);
        self.tell(DiagnoseProgress::Search { step, simulations })
    }

    /// Parts that were left out so far.
    pub(crate) fn left_out(&self) -> Vec<Part> {
        let bits = self.left_out.load(Ordering::Relaxed);
        let is_left_out = |part: &Part| bits >> *part as u64 & 1 == 1;
        Part::ALL.into_iter().filter(is_left_out).collect()
    }

    fn ask(&self, told: &mut Told<'_>, progress: DiagnoseProgress) -> ControlFlow<()> {
        if let DiagnoseProgress::Search { step, .. } = progress {
            told.step = step;
        }
        let is_search = matches!(progress, DiagnoseProgress::Search { .. });
        self.is_searching.store(is_search, Ordering::Relaxed);
        let goes_on = (told.progress)(progress);
        told.last = Instant::now();
        if goes_on.is_break() {
            self.has_ended.store(true, Ordering::Relaxed);
        }
        goes_on
    }
}

impl Watch for Caller<'_> {
    fn goes_on(&self, points: usize) -> ControlFlow<()> {
        if self.has_ended.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        if !self.is_searching.load(Ordering::Relaxed) {
            return ControlFlow::Continue(());
        }
        let before = self.simulations.fetch_add(points as u64, Ordering::Relaxed);
        // Where another thread tells, this one need not.
        match self.told.try_lock() {
            Ok(mut told) if told.last.elapsed() >= APART => {
                let step = told.step;
                let simulations = before + points as u64;
                self.ask(&mut told, DiagnoseProgress::Search { step, simulations })
            }
            _ => ControlFlow::Continue(()),
        }
    }

    fn leaves_out(&self, part: Part) -> bool {
        let is_narrow =
            self.effort == Effort::Quick && matches!(part, Part::OtherLoops | Part::OtherStarts);
        let mut deadline = self.deadline.into_iter();
        let is_late = deadline.any(|deadline| Instant::now() >= deadline);
        if is_narrow || is_late {
            self.left_out.fetch_or(1 << part as u64, Ordering::Relaxed);
        }
        is_narrow || is_late
    }
}

impl fmt::Debug for Caller<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Caller")
            .field("has_ended", &self.has_ended)
            .field("simulations", &self.simulations)
            .finish_non_exhaustive()
    }
}

/// A model whose simulations are watched.
#[derive(Debug)]
pub(crate) struct Watched<'a> {
    pub(crate) model: &'a dyn ForwardModel,
    pub(crate) watch: &'a dyn Watch,
}

impl ForwardModel for Watched<'_> {
    fn parameters(&self) -> &[ParameterInfo] {
        self.model.parameters()
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        stopped(self.watch.goes_on(points.len()))?;
        self.model.simulate(points, recording, visit)
    }
}

fn stopped(goes_on: ControlFlow<()>) -> Result<(), IdentifyError> {
    match goes_on {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(IdentifyError::Stopped),
    }
}
