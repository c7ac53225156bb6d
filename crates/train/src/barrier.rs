//! A barrier at which the devices of a training wait for each other before each step.
//!
//! With gradients that are reduced among devices, a device that stops a step before the others
//! leaves them waiting forever for its part. Burn's workers poll the interrupter independently, so
//! one may notice a stop (a loss that is not finite, a file that cannot be read, a key) a step
//! earlier than another. After this barrier either all devices take the next step, or none.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use burn_train::Interrupter;

/// Interval at which a waiting device polls the interrupter: short beside a training step, long
/// beside the cost of a wake-up.
const POLL: Duration = Duration::from_millis(20);

/// A reusable barrier for a fixed number of devices that gives up when the training is stopped.
pub(crate) struct StepBarrier {
    devices: usize,
    interrupter: Interrupter,
    state: Mutex<State>,
    complete: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// Devices that wait at the barrier.
    waiting: usize,
    /// Times that the barrier was passed.
    generation: u64,
}

impl StepBarrier {
    pub(crate) fn new(devices: usize, interrupter: Interrupter) -> Self {
        Self { devices, interrupter, state: Mutex::default(), complete: Condvar::new() }
    }

    /// Waits for all devices. False if the training is stopped before all have arrived.
    pub(crate) fn wait(&self) -> bool {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.waiting += 1;
        if state.waiting == self.devices {
            state.waiting = 0;
            state.generation += 1;
            self.complete.notify_all();
            return true;
        }
        // `std::sync::Barrier` cannot be left, so a stop would be a deadlock: hence the
        // generations.
        let generation = state.generation;
        while state.generation == generation {
            if self.interrupter.should_stop() {
                state.waiting -= 1;
                return false;
            }
            let woken = self.complete.wait_timeout(state, POLL);
            (state, _) = woken.unwrap_or_else(PoisonError::into_inner);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_devices_take_as_many_steps_whichever_stops_the_training() {
        for stopper in 0..3 {
            let interrupter = Interrupter::new();
            let barrier = StepBarrier::new(3, interrupter.clone());
            let steps: Vec<u32> = std::thread::scope(|scope| {
                let workers: Vec<_> = (0..3)
                    .map(|device| {
                        let (barrier, interrupter) = (&barrier, &interrupter);
                        // As Burn's worker does: the next batch, a step, a poll of the interrupter.
                        scope.spawn(move || {
                            let mut steps = 0;
                            while barrier.wait() {
                                steps += 1;
                                if device == stopper && steps == 50 {
                                    interrupter.stop(None);
                                }
                                if interrupter.should_stop() {
                                    break;
                                }
                            }
                            steps
                        })
                    })
                    .collect();
                workers.into_iter().map(|worker| worker.join().unwrap()).collect()
            });
            assert_eq!(steps, [50; 3], "stopped by device {stopper}");
        }
    }

    #[test]
    fn a_device_that_never_arrives_does_not_block_the_others() {
        let interrupter = Interrupter::new();
        let barrier = StepBarrier::new(2, interrupter.clone());
        std::thread::scope(|scope| {
            let other = scope.spawn(|| barrier.wait());
            // The batch of this device could not be read.
            interrupter.stop(None);
            assert!(!other.join().unwrap());
        });
    }
}
