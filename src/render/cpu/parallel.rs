//! Distributes chunks of work over all cores.

use std::sync::Mutex;
use std::thread;

/// Gives each chunk to a thread that is idle, and returns the final state of every thread. `start` makes a thread's state; `each`
/// works on a chunk.
pub fn on_all_cores<C: Send, T: Send>(
    chunks: impl Iterator<Item = C> + Send,
    start: impl Fn() -> T + Sync,
    each: impl Fn(&mut T, C) + Sync,
) -> Vec<T> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let chunks = Mutex::new(chunks);
    let work = || {
        let mut held = start();
        loop {
            // Poisoned only by a panic of another thread, which the scope raises again.
            let next = chunks.lock().ok().and_then(|mut chunks| chunks.next());
            let Some(chunk) = next else { return held };
            each(&mut held, chunk);
        }
    };
    thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut all = vec![work()];
        for other in others {
            match other.join() {
                Ok(held) => all.push(held),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chunk_is_worked_on_once() {
        let mut numbers: Vec<u32> = (0..1000).collect();
        let sums = on_all_cores(
            numbers.chunks_mut(7),
            || 0u32,
            |sum, chunk| {
                chunk.iter_mut().for_each(|n| *n += 1);
                *sum += chunk.len() as u32;
            },
        );
        assert_eq!(sums.iter().sum::<u32>(), 1000);
        assert!(numbers.iter().enumerate().all(|(i, n)| *n == i as u32 + 1));
    }
}
