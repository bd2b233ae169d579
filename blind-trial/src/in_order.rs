use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Does the jobs on some threads and hands on what comes out in the order of the jobs, each as soon as all
/// before it are done.
///
/// `take` may end it: jobs that are under way are finished, and dropped.
pub fn in_order<J: Sync, T: Send>(
    jobs: &[J],
    n_threads: usize,
    work: impl Fn(&J) -> T + Sync,
    mut take: impl FnMut(T) -> ControlFlow<()>,
) {
    let (next, is_over) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..n_threads.clamp(1, jobs.len().max(1)) {
            let sender = sender.clone();
            let (next, is_over, work) = (&next, &is_over, &work);
            scope.spawn(move || {
                while !is_over.load(Ordering::Relaxed) {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(number) else { break };
                    if sender.send((number, work(job))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let mut early = BTreeMap::new();
        let mut wanted = 0;
        for (number, done) in receiver {
            early.insert(number, done);
            while let Some(done) = early.remove(&wanted) {
                wanted += 1;
                if take(done).is_break() {
                    is_over.store(true, Ordering::Relaxed);
                    return;
                }
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_on_any_number_of_threads() {
        let jobs: Vec<u64> = (0..50).collect();
        for n_threads in [1, 2, 7] {
            let mut taken = Vec::new();
            in_order(
                &jobs,
                n_threads,
                |job| (0..(50 - job) * 1000).fold(*job, |a, b| a ^ b ^ b),
                |done| {
                    taken.push(done);
                    ControlFlow::Continue(())
                },
            );
            assert_eq!(taken, jobs);
        }
    }

    #[test]
    fn the_taker_may_end_it() {
        let jobs: Vec<u64> = (0..50).collect();
        let mut n_taken = 0;
        in_order(
            &jobs,
            2,
            |job| *job,
            |job| {
                n_taken += 1;
                if job == 3 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            },
        );
        assert_eq!(n_taken, 4);
    }
}
