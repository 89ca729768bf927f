//! Work over numbered items on several threads, with the results in the items' order.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, mpsc};

/// Stack of a worker: a workspace may pass over it on its way to the heap.
const STACK: usize = 32 << 20;

/// Computes `work(state, i)` for `i` in `0..count` and returns the results in order; each thread has a state of its own.
///
/// # Errors
/// The first error in the items' order among those met before the work stopped.
pub fn map_ordered<S, T: Send, E: Send>(
    count: usize,
    threads: usize,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let mut out = Vec::with_capacity(count);
    for_each_ordered(
        0..count,
        threads,
        state,
        |state, i, _| work(state, i),
        |_, result| {
            out.push(result?);
            Ok(true)
        },
    )?;
    Ok(out)
}

/// Computes `work(state, i, item)` for the items, numbered from 0, on several threads and hands the results to `sink` in
/// order, on the calling thread. The work is never more than a few items ahead of the sink, so memory stays constant. `sink`
/// ends the work early by returning `Ok(false)`; an item that is being waited for is then still waited for.
///
/// # Errors
/// What `sink` returns.
pub fn for_each_ordered<I: Send, S, T: Send, E>(
    items: impl IntoIterator<Item = I, IntoIter: Send>,
    threads: usize,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize, I) -> T + Sync,
    mut sink: impl FnMut(usize, T) -> Result<bool, E>,
) -> Result<(), E> {
    let items = items.into_iter();
    let threads = threads.clamp(1, items.size_hint().1.unwrap_or(usize::MAX).max(1));
    let items = Mutex::new(items.enumerate());
    let stop = AtomicBool::new(false);
    // One token per item that may be under way or waiting.
    let (give, take) = mpsc::sync_channel::<()>(4 * threads);
    for _ in 0..4 * threads {
        let _ = give.try_send(());
    }
    let take = Mutex::new(take);
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads {
            let (send, items, stop, take, state, work) = (send.clone(), &items, &stop, &take, &state, &work);
            let worker = move || {
                let mut state = state();
                loop {
                    let token = take.lock().map_or(Err(()), |take| take.recv().map_err(|_| ()));
                    if token.is_err() || stop.load(Ordering::Relaxed) {
                        return;
                    }
                    let Some((i, item)) = items.lock().ok().and_then(|mut items| items.next()) else { return };
                    if send.send((i, work(&mut state, i, item))).is_err() {
                        return;
                    }
                }
            };
            if let Err(error) = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, worker) {
                tracing::warn!("fewer threads than asked for: {error}");
            }
        }
        drop(send);
        // Dropping it wakes the workers that wait for a token.
        let give = give;
        let mut waiting = std::collections::BTreeMap::new();
        let mut due = 0;
        let mut outcome = Ok(());
        'receive: for (i, result) in receive {
            waiting.insert(i, result);
            while let Some(result) = waiting.remove(&due) {
                match sink(due, result) {
                    Ok(true) => {}
                    Ok(false) => break 'receive,
                    Err(error) => {
                        outcome = Err(error);
                        break 'receive;
                    }
                }
                due += 1;
                let _ = give.try_send(());
            }
        }
        stop.store(true, Ordering::Relaxed);
        drop(give);
        outcome
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    #[test]
    fn results_come_in_order_for_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let slow_first = |(): &mut (), i: usize| {
                std::thread::sleep(std::time::Duration::from_micros(if i.is_multiple_of(5) { 900 } else { 10 }));
                Ok::<_, ()>(i * i)
            };
            let squares = map_ordered(100, threads, || (), slow_first).unwrap();
            assert!(squares.iter().enumerate().all(|(i, s)| *s == i * i));
        }
        assert_eq!(map_ordered(0, 3, || (), |(), i| Ok::<_, ()>(i)), Ok(vec![]));
    }

    #[test]
    fn the_first_error_in_order_is_returned_and_the_work_stops() {
        let seen = AtomicUsize::new(0);
        let result = map_ordered(
            10_000,
            3,
            || (),
            |(), i| {
                seen.fetch_add(1, Ordering::Relaxed);
                if i >= 20 { Err(i) } else { Ok(i) }
            },
        );
        assert_eq!(result, Err(20));
        assert!(seen.load(Ordering::Relaxed) < 100);
    }

    #[test]
    fn the_sink_can_end_the_work_and_bounds_how_far_ahead_it_is() {
        let (started, sunk) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let ahead = AtomicUsize::new(0);
        let work = |(): &mut (), _: usize, _: usize| {
            let far = started.fetch_add(1, Ordering::SeqCst) + 1 - sunk.load(Ordering::SeqCst);
            ahead.fetch_max(far, Ordering::SeqCst);
        };
        for_each_ordered(
            0..500,
            2,
            || (),
            work,
            |i, ()| {
                sunk.fetch_add(1, Ordering::SeqCst);
                Ok::<_, ()>(i < 300)
            },
        )
        .unwrap();
        assert_eq!(sunk.load(Ordering::SeqCst), 301);
        assert!(ahead.load(Ordering::SeqCst) <= 10);
    }
}
