//! Things made on a thread of their own, a few ahead of whoever uses them.

use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How many wait ready, at most. One more is being made.
const READY: usize = 2;

/// The items of an iterator in their order, made ahead.
pub(crate) struct Ahead<T> {
    /// None behind the last item.
    ready: Option<Receiver<T>>,
    maker: Option<JoinHandle<()>>,
    waited: Duration,
}

impl<T: Send + 'static> Ahead<T> {
    /// Begins to make them at once.
    pub(crate) fn new(items: impl Iterator<Item = T> + Send + 'static) -> Self {
        let (sender, ready) = sync_channel(READY);
        let maker = thread::spawn(move || {
            for item in items {
                // Nobody wants it any more.
                if sender.send(item).is_err() {
                    return;
                }
            }
        });
        Self { ready: Some(ready), maker: Some(maker), waited: Duration::ZERO }
    }
}

impl<T> Ahead<T> {
    /// How long [`next`](Iterator::next) has blocked so far, all calls together.
    pub(crate) fn waited(&self) -> Duration {
        self.waited
    }
}

impl<T> Iterator for Ahead<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        let asked = Instant::now();
        let item = self.ready.as_ref()?.recv().ok();
        self.waited += asked.elapsed();
        if item.is_none() {
            self.ready = None;
            // A maker that panicked must not look like one that is done.
            if let Some(Err(panic)) = self.maker.take().map(JoinHandle::join) {
                resume_unwind(panic);
            }
        }
        item
    }
}

impl<T> Drop for Ahead<T> {
    fn drop(&mut self) {
        self.ready = None;
        if let Some(maker) = self.maker.take() {
            // Whoever drops it early does not want to hear what became of the rest.
            let _ = maker.join();
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
        assert!(Ahead::new(0..1000).eq(0..1000));
    }

    #[test]
    fn a_slow_maker_is_waited_for_and_a_quick_one_is_not() {
        let pause = Duration::from_millis(20);
        let slow = |items: i32| (0..items).inspect(move |_| thread::sleep(pause));
        let mut made = Ahead::new(slow(5));
        assert_eq!(made.by_ref().count(), 5);
        assert!(made.waited() >= 4 * pause, "{:?}", made.waited());

        let mut made = Ahead::new(slow(2));
        // Both are ready by the time they are asked for.
        thread::sleep(20 * pause);
        assert_eq!((made.next(), made.next()), (Some(0), Some(1)));
        assert!(made.waited() < pause, "{:?}", made.waited());
    }

    #[test]
    fn no_more_is_made_than_a_few_ahead_and_nothing_after_it_is_dropped() {
        let made = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&made);
        let mut ahead = Ahead::new((0..100).inspect(move |_| {
            counter.fetch_add(1, Ordering::SeqCst);
        }));
        assert_eq!(ahead.next(), Some(0));
        drop(ahead);
        assert!(made.load(Ordering::SeqCst) <= 1 + READY + 1);
        // The maker is gone, and its counter with it.
        assert_eq!(Arc::strong_count(&made), 1);
    }

    #[test]
    #[should_panic(expected = "no third item")]
    fn a_panic_of_the_maker_is_one_of_the_user() {
        let items = (0..3).inspect(|&item| assert!(item < 2, "no third item"));
        Ahead::new(items).for_each(drop);
    }
}
