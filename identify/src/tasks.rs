//! Independent tasks on all threads.

use std::cmp::Reverse;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::IdentifyError;

/// Results of a task for each item, in the order of the items.
///
/// A thread takes an item whenever it is free, so that long tasks leave none idle. A task may itself have tasks.
pub fn in_parallel<T: Sync, R: Send>(items: &[T], task: impl Fn(&T) -> R + Sync) -> Vec<R> {
    in_order_of(items, |_| 0, task)
}

/// [`in_parallel`], but tasks of a higher rank begin first, so that no long task begins when the others have ended.
pub fn in_order_of<T: Sync, R: Send>(
    items: &[T],
    rank: impl Fn(&T) -> usize,
    task: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let results: Vec<Mutex<Option<R>>> = items.iter().map(|_| Mutex::new(None)).collect();
    for_each_number(items.iter().map(rank).collect(), &|k| {
        let result = task(&items[k]);
        *results[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    let results = results.into_iter();
    results
        .map(|result| {
            let result = result.into_inner();
            match result.unwrap_or_else(PoisonError::into_inner) {
                Some(result) => result,
                None => unreachable!("every number had its turn"),
            }
        })
        .collect()
}

/// [`in_parallel`] of tasks that may fail. All of them run, even after one failed, so that the error is the same on any number of threads.
///
/// # Errors
///
/// The error of the first item whose task failed.
pub fn try_in_parallel<T: Sync, R: Send>(
    items: &[T],
    task: impl Fn(&T) -> Result<R, IdentifyError> + Sync,
) -> Result<Vec<R>, IdentifyError> {
    in_parallel(items, task).into_iter().collect()
}

/// Results of two tasks, which run side by side where a thread is free.
pub fn both<A: Send, B: Send>(
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    rayon::join(one, other)
}

/// A task for the number of each rank, the highest first. Compiled once, not once for each task: what shares out the work is much
/// code.
fn for_each_number(ranks: Vec<usize>, task: &(dyn Fn(usize) + Sync)) {
    let mut order: Vec<usize> = (0..ranks.len()).collect();
    order.sort_by_key(|&k| Reverse(ranks[k]));
    // Threads begin with parts of a range; the counter hands out the order instead.
    let next = AtomicUsize::new(0);
    let numbers = (0..order.len()).into_par_iter().with_max_len(1);
    numbers.for_each(|_| task(order[next.fetch_add(1, Ordering::Relaxed)]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_their_items() {
        let items: Vec<usize> = (0..100).collect();
        let within = |k: &usize| in_parallel(&items[..*k], |j| j * k).iter().sum::<usize>();
        let expected: Vec<usize> = items.iter().map(|k| (0..*k).sum::<usize>() * k).collect();
        assert_eq!(in_parallel(&items, within), expected);
        assert!(in_parallel(&items[..0], |k| *k).is_empty());
        let squares = in_parallel(&items, |k| k * k);
        assert_eq!(in_order_of(&items, |k| k % 7, |k| k * k), squares);
    }

    #[test]
    fn tasks_of_a_higher_rank_begin_first() {
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let begun = Mutex::new(Vec::new());
        let items: Vec<usize> = (0..20).collect();
        one.unwrap().install(|| {
            in_order_of(&items, |k| k % 3, |&k| begun.lock().unwrap().push(k));
        });
        let mut expected = items;
        expected.sort_by_key(|k| Reverse(k % 3));
        assert_eq!(*begun.lock().unwrap(), expected);
    }
}
