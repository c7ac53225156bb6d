//! Where the devices of a training wait for each other before each step.
//!
//! With gradients that are reduced among devices, a device that stops a step before the others leaves
//! them waiting forever for its share. Burn's workers look at the interrupter each for itself, so one
//! may see a stop (a loss that is no number, a file that cannot be read, a key) a step earlier than
//! another. Behind this meeting either all devices take the next step, or none.

use std::fmt;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use burn_train::Interrupter;

/// How often a waiting device looks whether the training has been stopped.
const POLL: Duration = Duration::from_millis(20);

/// A meeting of a fixed number of devices, over and over.
pub(crate) struct Meeting {
    devices: usize,
    interrupter: Interrupter,
    state: Mutex<State>,
    complete: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// Devices that wait.
    here: usize,
    /// Meetings that took place.
    held: u64,
}

impl fmt::Debug for Meeting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Meeting").field("devices", &self.devices).finish_non_exhaustive()
    }
}

impl Meeting {
    pub(crate) fn new(devices: usize, interrupter: Interrupter) -> Self {
        Self { devices, interrupter, state: Mutex::default(), complete: Condvar::new() }
    }

    /// Waits for all devices. False if the training is stopped and someone will not come.
    pub(crate) fn wait(&self) -> bool {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.here += 1;
        if state.here == self.devices {
            state.here = 0;
            state.held += 1;
            self.complete.notify_all();
            return true;
        }
        let meeting = state.held;
        while state.held == meeting {
            if self.interrupter.should_stop() {
                state.here -= 1;
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
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn all_devices_take_the_same_number_of_steps_whoever_stops_the_training() {
        for stopper in 0..3 {
            let interrupter = Interrupter::new();
            let meeting = Meeting::new(3, interrupter.clone());
            let steps: Vec<u32> = std::thread::scope(|scope| {
                let workers: Vec<_> = (0..3)
                    .map(|device| {
                        let (meeting, interrupter) = (&meeting, &interrupter);
                        // As Burn's worker does: the next batch, a step, a look whether to stop.
                        scope.spawn(move || {
                            let mut steps = 0;
                            while meeting.wait() {
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
    fn a_device_that_leaves_before_a_meeting_does_not_keep_the_others() {
        let interrupter = Interrupter::new();
        let meeting = Meeting::new(2, interrupter.clone());
        std::thread::scope(|scope| {
            let other = scope.spawn(|| meeting.wait());
            // The batch of this device could not be read.
            interrupter.stop(None);
            assert!(!other.join().unwrap());
        });
    }
}
