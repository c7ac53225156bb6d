//! The second half of a step behind a readout that makes pixels wait.
//!
//! # Model
//! A pixel that has crossed a threshold asks the readout and is blind until it is served, at
//! `t_served`; its memory is then `V(t_served)`, so that what has changed while it waited is lost,
//! or the level it asked at, so that nothing is. A pixel that is free goes on at once instead. All
//! pixels share the readout, so that all their requests are taken in order of time. A bus that
//! reads rows has its turn in the same order: it selects one when it is due, behind all requests of
//! that time, and what it reads is served in this step or in a later one.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::band::Band;
use super::resolve::{PendingEvent, PixelState, Step, for_each_pixel};
use super::term::NoiseEvent;
use crate::Request;
use crate::readout::{ServeAction, Service, Turn, Waiting};
use crate::request::time_order;

/// Pending events, the earliest first.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    due: BinaryHeap<Reverse<Due>>,
    entries: Vec<Entry>,
    /// Served in a later step.
    waiting: Vec<Served>,
}

/// A time, the pixel at equal times, and the entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Due {
    time: u64,
    pixel: u32,
    entry: u32,
}

#[derive(Debug, Clone, Copy)]
enum Entry {
    /// A pixel reaches a threshold, unless it has had another event since it had `count`.
    Change {
        pending: PendingEvent,
        count: u32,
    },
    NoiseEvent(NoiseEvent),
    /// A request that no pixel knows of.
    Background(Request),
    /// The readout comes to a request.
    Served(Served),
    /// It came too late to a request, which is lost.
    Lost(Served),
    /// A bus selects a row.
    Selection,
}

/// A request at the time at which it is served, and what becomes of its pixel.
#[derive(Debug, Clone, Copy)]
struct Served {
    request: Request,
    then: ServeAction,
}

/// Takes its turn behind all pixels.
const NO_PIXEL: u32 = u32::MAX;

impl Queue {
    fn push(&mut self, t_s: f64, pixel: u32, entry: Entry) {
        let due = Due { time: time_order(t_s), pixel, entry: self.entries.len() as u32 };
        self.entries.push(entry);
        self.due.push(Reverse(due));
    }
}

/// Pixels that wait for each other, and the queue in which they do.
#[derive(Debug)]
struct Queued<'a, 'b> {
    band: &'a mut Band<'b>,
    queue: &'a mut Queue,
}

impl Band<'_> {
    /// Takes every pixel that woke through the step and appends events in the order in which they
    /// are served, `background` among them.
    pub(crate) fn resolve_served(
        &mut self,
        step: Step<'_>,
        queue: &mut Queue,
        background: &[Request],
        service: &mut Service<'_>,
        out: &mut Vec<Request>,
    ) {
        // Taken out: the band is borrowed while they are gone through.
        let awake = std::mem::take(&mut self.scanned.awake);
        let accepted = std::mem::take(&mut self.scanned.accepted);
        let mut queued = Queued { band: self, queue };
        // The row selection is queued behind the pixels, so that requests of its time are read by
        // it.
        queued.begin(step, &awake, &accepted);
        queued.expect_selection(step, service);
        for request in background {
            queued.queue.push(request.t_s, request.pixel, Entry::Background(*request));
        }
        // In order of time, over all pixels: an entry that is served may bring a further one.
        while let Some(Reverse(due)) = queued.queue.due.pop() {
            let entry = queued.queue.entries[due.entry as usize];
            if let Entry::Selection = entry {
                queued.select_row(step, service);
            } else {
                queued.take(step, due.pixel as usize, entry, service, out);
            }
        }
        let noisy = accepted.iter().map(|noise_event| noise_event.pixel);
        // A pixel that began to wait has the levels of before: `wait` changes its state alone.
        for pixel in awake.iter().copied().chain(noisy) {
            self.set_wake_levels(
                pixel as usize,
                step.tick.end_s,
                step.chain.plan.steps_while_refractory,
            );
        }
        self.scanned.awake = awake;
        self.scanned.accepted = accepted;
    }
}

impl Queued<'_, '_> {
    fn begin(&mut self, step: Step<'_>, awake: &[u32], accepted: &[NoiseEvent]) {
        self.queue.due.clear();
        self.queue.entries.clear();
        // First what was left by the last step: those pixels wait and must not be asked for a
        // change.
        for served in std::mem::take(&mut self.queue.waiting) {
            self.serve_or_wait(step, served);
        }
        for_each_pixel(awake, accepted, |pixel, noise_events| {
            for noise_event in noise_events {
                self.queue.push(
                    noise_event.t_s,
                    noise_event.pixel,
                    Entry::NoiseEvent(*noise_event),
                );
            }
            if !self.waits(pixel) {
                let mut pixel_state = self.band.load_pixel(step, pixel);
                self.expect_change(step, &mut pixel_state, step.tick.start_s);
            }
        });
    }

    fn take(
        &mut self,
        step: Step<'_>,
        pixel: usize,
        entry: Entry,
        service: &mut Service<'_>,
        out: &mut Vec<Request>,
    ) {
        let mut pixel_state = self.band.load_pixel(step, pixel);
        let (count_now, waits) = (pixel_state.pixel_step.count, self.waits(pixel));
        let pending = match entry {
            // Another count means an event since: the change was foreseen from an older memory.
            Entry::Change { pending, count } if count == count_now && !waits => pending,
            Entry::NoiseEvent(NoiseEvent { t_s, polarity, origin, .. })
                if t_s >= pixel_state.refractory.free_s =>
            {
                PendingEvent { t_s, polarity, origin, memory: pixel_state.pixel_step.at(t_s) }
            }
            Entry::Background(request) => {
                if service.reads_rows() {
                    self.enqueue(step, service, request, ServeAction::Nothing);
                } else if let Some(t_s) = service.acknowledge(&request) {
                    out.push(Request { t_s, ..request });
                }
                return;
            }
            Entry::Served(Served { request, then }) | Entry::Lost(Served { request, then }) => {
                // A lost request is acknowledged, too: only its event does not come out.
                if let Entry::Served(_) = entry {
                    out.push(request);
                }
                let Request { t_s, polarity, origin, .. } = request;
                let memory = match then {
                    ServeAction::Reset => pixel_state.pixel_step.at(t_s),
                    ServeAction::Keep => pixel_state.pixel_step.memory,
                    ServeAction::Nothing => return,
                };
                // It waits no longer; the reset below sets a refractory period of its own.
                pixel_state.refractory.free_s = f64::NEG_INFINITY;
                let pending = PendingEvent { t_s, polarity, origin, memory };
                self.reset_and_continue(step, &mut pixel_state, &pending);
                return;
            }
            Entry::Change { .. } | Entry::NoiseEvent(_) | Entry::Selection => return,
        };
        if pending.t_s < pixel_state.refractory.free_s {
            // Refractory, with the reference level still stepping: the event is lost.
            pixel_state.pixel_step.memory = pending.memory;
            self.expect_change(step, &mut pixel_state, pending.t_s);
            return;
        }
        let request = pending.request(pixel as u32);
        // A row bus serves at its own time: the request joins its row.
        if service.reads_rows() {
            let then = self.wait(step, service.waiting(), &mut pixel_state, &pending);
            self.enqueue(step, service, request, then);
            return;
        }
        match service.acknowledge(&request) {
            // Served in the very moment, or dropped behind the pixel, which does not know.
            None => self.reset_and_continue(step, &mut pixel_state, &pending),
            Some(t_s) if t_s <= pending.t_s => {
                out.push(request);
                self.reset_and_continue(step, &mut pixel_state, &pending);
            }
            Some(t_s) => {
                let then = self.wait(step, service.waiting(), &mut pixel_state, &pending);
                self.serve_or_wait(step, Served { request: Request { t_s, ..request }, then });
            }
        }
    }

    /// A pixel waits from now on, or goes on at once.
    fn wait(
        &mut self,
        step: Step<'_>,
        waiting: Waiting,
        pixel_state: &mut PixelState,
        pending: &PendingEvent,
    ) -> ServeAction {
        let pixel = pixel_state.pixel_step.pixel as usize;
        match waiting {
            Waiting::Reset => {
                // When served, it memorises the voltage of that time: earlier changes are lost.
                self.band.refractory_states[pixel].free_s = f64::INFINITY;
                ServeAction::Reset
            }
            Waiting::Kept => {
                // With the array it leaks like any other, however long it waits.
                self.band.cells[pixel].memory = pending.memory as f32;
                self.band.refractory_states[pixel].free_s = f64::INFINITY;
                ServeAction::Keep
            }
            Waiting::Free | Waiting::Latched => {
                // The readout holds the request: the pixel goes on at once.
                self.reset_and_continue(step, pixel_state, pending);
                ServeAction::Nothing
            }
        }
    }

    /// Lets a request wait for the turn of its row.
    fn enqueue(
        &mut self,
        step: Step<'_>,
        service: &mut Service<'_>,
        request: Request,
        then: ServeAction,
    ) {
        let was_free = service.bus().selects_s().is_none();
        service.enqueue(request, then);
        // A bus at work has its next selection in the queue already.
        if was_free {
            self.expect_selection(step, service);
        }
    }

    /// The bus selects a row in this step or in a later one.
    fn expect_selection(&mut self, step: Step<'_>, service: &mut Service<'_>) {
        if let Some(t_s) = service.bus().selects_s().filter(|t_s| *t_s <= step.tick.end_s) {
            self.queue.push(t_s, NO_PIXEL, Entry::Selection);
        }
    }

    fn select_row(&mut self, step: Step<'_>, service: &mut Service<'_>) {
        service.bus().select(|request, then, turn| {
            let served = Served { request, then };
            match turn {
                Turn::Read => self.serve_or_wait(step, served),
                Turn::Lost => self.queue.push(request.t_s, request.pixel, Entry::Lost(served)),
            }
        });
        self.expect_selection(step, service);
    }

    fn waits(&self, pixel: usize) -> bool {
        self.band.refractory_states[pixel].free_s == f64::INFINITY
    }

    fn serve_or_wait(&mut self, step: Step<'_>, served: Served) {
        let Request { t_s, pixel, .. } = served.request;
        if t_s <= step.tick.end_s {
            self.queue.push(t_s, pixel, Entry::Served(served));
        } else {
            self.queue.waiting.push(served);
        }
    }

    /// Resets a pixel and looks for its next change.
    fn reset_and_continue(
        &mut self,
        step: Step<'_>,
        pixel_state: &mut PixelState,
        pending: &PendingEvent,
    ) {
        self.band.reset(step, pixel_state, pending);
        self.expect_change(step, pixel_state, pending.t_s);
    }

    fn expect_change(&mut self, step: Step<'_>, pixel_state: &mut PixelState, now_s: f64) {
        if let Some(from_s) = pixel_state.ready_from(step, now_s)
            && let Some(pending) = pixel_state.next_pending(step, from_s, &mut &[][..])
        {
            let (pixel, count) = (pixel_state.pixel_step.pixel, pixel_state.pixel_step.count);
            self.queue.push(pending.t_s, pixel, Entry::Change { pending, count });
        }
        self.band.store_pixel(step, pixel_state);
    }
}
