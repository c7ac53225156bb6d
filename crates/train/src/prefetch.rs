//! Prefetching: items computed on a thread of their own, a few before the consumer needs them.

use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Items that wait in the queue, at most; one more is being computed. As `prefetch_factor` of
/// PyTorch's `DataLoader`.
const QUEUED: usize = 2;

/// The items of an iterator in their order, computed on another thread.
pub(crate) struct Prefetch<T> {
    /// None after the last item.
    queue: Option<Receiver<T>>,
    producer: Option<JoinHandle<()>>,
    waited: Duration,
}

impl<T: Send + 'static> Prefetch<T> {
    /// Starts the thread, which begins at once.
    pub(crate) fn new(items: impl Iterator<Item = T> + Send + 'static) -> Self {
        let (sender, queue) = sync_channel(QUEUED);
        let producer = thread::spawn(move || {
            for item in items {
                // The consumer was dropped.
                if sender.send(item).is_err() {
                    return;
                }
            }
        });
        Self { queue: Some(queue), producer: Some(producer), waited: Duration::ZERO }
    }
}

impl<T> Prefetch<T> {
    /// Time for which [`next`](Iterator::next) has blocked so far, summed over its calls.
    pub(crate) fn waited(&self) -> Duration {
        self.waited
    }
}

impl<T> Iterator for Prefetch<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        let started = Instant::now();
        let item = self.queue.as_ref()?.recv().ok();
        self.waited += started.elapsed();
        if item.is_none() {
            self.queue = None;
            // A panic of the producer closes the queue too: it must not pass for the end of the
            // data.
            if let Some(Err(panic)) = self.producer.take().map(JoinHandle::join) {
                resume_unwind(panic);
            }
        }
        item
    }
}

impl<T> Drop for Prefetch<T> {
    fn drop(&mut self) {
        self.queue = None;
        if let Some(producer) = self.producer.take() {
            // Dropped early, the remaining items and their panics are of no interest.
            let _ = producer.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn all_items_come_in_their_order() {
        assert!(Prefetch::new(0..1000).eq(0..1000));
    }

    #[test]
    fn waiting_is_measured_for_a_slow_producer_only() {
        let pause = Duration::from_millis(20);
        let slow = |items: i32| (0..items).inspect(move |_| thread::sleep(pause));
        let mut items = Prefetch::new(slow(5));
        assert_eq!(items.by_ref().count(), 5);
        assert!(items.waited() >= 4 * pause, "{:?}", items.waited());

        let mut items = Prefetch::new(slow(2));
        // Both are queued by the time they are needed.
        thread::sleep(20 * pause);
        assert_eq!((items.next(), items.next()), (Some(0), Some(1)));
        assert!(items.waited() < pause, "{:?}", items.waited());
    }

    #[test]
    fn the_queue_is_bounded_and_the_thread_ends_with_the_consumer() {
        let made = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&made);
        let mut prefetch = Prefetch::new((0..100).inspect(move |_| {
            counter.fetch_add(1, Ordering::SeqCst);
        }));
        assert_eq!(prefetch.next(), Some(0));
        drop(prefetch);
        assert!(made.load(Ordering::SeqCst) <= 1 + QUEUED + 1);
        // The thread has ended and dropped its counter.
        assert_eq!(Arc::strong_count(&made), 1);
    }

    #[test]
    #[should_panic(expected = "no third item")]
    fn a_panic_of_the_producer_reaches_the_consumer() {
        let items = (0..3).inspect(|&item| assert!(item < 2, "no third item"));
        Prefetch::new(items).for_each(drop);
    }
}
