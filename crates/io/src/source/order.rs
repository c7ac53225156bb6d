//! Events of a file in the order of time, by one rule for all formats.
//!
//! | in the file | what is done |
//! |---|---|
//! | an event up to 10 ms behind a later one | sorted, counted |
//! | at most ten events in a row whose clock is not that of the others | left out, counted |
//! | 32 bits of microseconds that begin again | unwrapped, counted |
//! | a clock that starts again | a fault, unless a part or all parts are asked for |
//! | more than one event in a thousand far from the others | a fault |
//!
//! A silence of any length is no fault, but that between a few events at the beginning or the end and
//! all others: it is longer than a minute and than a thousand of the others' intervals. Among a hundred
//! events or fewer, none is a fault: all are sorted.

use evpose_core::{Event, Micros};

use super::Restarts;
use crate::Columns;

/// Delay of an event behind a later one up to which it is sorted.
pub(crate) const MAX_DELAY: Micros = Micros(10_000);
/// Count of events in a row up to which a clock of their own is a fault of them.
const FEW: usize = 10;
/// Count of events with one clock beside which a few others are faults.
const MANY: usize = 100;
/// One event in so many may be far from the others.
const ONE_IN: u64 = 1_000;
/// Time ahead of the latest event beyond which a few events may be faults, and the same in intervals
/// of the others.
const FAR: i64 = 60_000_000;
const FAR_INTERVALS: i64 = 1_000;
/// Period of a counter of 32 bits.
const WRAP: i64 = 1 << 32;
/// Events that wait for earlier ones, at most: all of them may be of one time stamp.
const MAX_WAITING: usize = 1 << 22;

/// Counts of events that are not in order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Disorder {
    /// Events that were sorted, and the longest delay of one.
    pub(crate) sorted: u64,
    pub(crate) delay: Micros,
    /// Events that were left out; number in the file and time stamp of the first.
    pub(crate) strays: u64,
    pub(crate) first_stray: Option<(u64, Micros)>,
    /// Wraparounds of a counter of 32 bits.
    pub(crate) wraparounds: u64,
    /// Starts of the clock that were passed over.
    pub(crate) restarts: u64,
}

impl Disorder {
    /// In sentences without a full stop.
    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> {
        let sorted = (self.sorted > 0).then(|| {
            let delay_ms = self.delay.as_seconds() * 1e3;
            format!("{} events stood up to {delay_ms:.3} ms behind later ones: sorted", self.sorted)
        });
        let strays = self.first_stray.map(|(number, t)| {
            format!(
                "{} events have time stamps far from all others (the first is event {number}, at \
                 {:.6} s): left out",
                self.strays,
                t.as_seconds()
            )
        });
        let wraparounds = (self.wraparounds > 0).then(|| {
            format!("time stamps of 32 bits began again {} times: unwrapped", self.wraparounds)
        });
        let restarts = (self.restarts > 0).then(|| {
            format!("the clock started again {} times: the parts are joined", self.restarts)
        });
        [sorted, strays, wraparounds, restarts].into_iter().flatten()
    }
}

/// A clock that cannot be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ClockFault {
    /// It starts again at an event, counted from 0.
    Restart { event: u64, from: Micros, to: Micros },
    /// So many of the events read are far from the others.
    None { strays: u64, events: u64 },
}

/// Puts events in order, batch by batch.
#[derive(Debug)]
pub(crate) struct Order {
    restarts: Restarts,
    /// The first events of a file, until there are enough to distinguish faults from the rest.
    head: Option<Columns>,
    /// Whether reading began within the file: what is early there is none of a few.
    is_behind_seek: bool,
    /// Events of the file so far.
    read: u64,
    /// Events that wait for earlier ones, in order if `is_sorted`.
    waiting: Columns,
    is_sorted: bool,
    /// The latest event of the present run, and how many the run has.
    newest: Option<Micros>,
    oldest: Micros,
    of_run: usize,
    /// A few events before the run, whose clock is not its own, and how far it is from theirs.
    early: Columns,
    silence: Micros,
    /// Events whose clock is not that of the run, and the latest of them.
    other: Columns,
    other_newest: Micros,
    other_begin: u64,
    /// Everything before this time was given away.
    given_to: Micros,
    /// Added to the stamps of the file: wraparounds, and parts that were joined.
    shift: Micros,
    part: usize,
    disorder: Disorder,
}

impl Order {
    pub(crate) fn new(restarts: Restarts) -> Self {
        Self {
            restarts,
            head: Some(Columns::new()),
            is_behind_seek: false,
            read: 0,
            waiting: Columns::new(),
            is_sorted: true,
            newest: None,
            oldest: Micros(i64::MAX),
            of_run: 0,
            early: Columns::new(),
            silence: Micros(0),
            other: Columns::new(),
            other_newest: Micros(i64::MIN),
            other_begin: 0,
            given_to: Micros(i64::MIN),
            shift: Micros(0),
            part: 1,
            disorder: Disorder::default(),
        }
    }

    /// As [`Self::new`], of events from a place within the file on.
    pub(crate) fn behind_seek(restarts: Restarts) -> Self {
        Self { head: None, is_behind_seek: true, ..Self::new(restarts) }
    }

    /// Whether there was any event.
    pub(crate) fn is_untouched(&self) -> bool {
        self.read == 0 && self.head.as_ref().is_none_or(Columns::is_empty)
    }

    pub(crate) fn disorder(&self) -> Disorder {
        self.disorder
    }

    /// Parts so far, by starts of the clock.
    pub(crate) fn parts(&self) -> usize {
        self.part
    }

    /// Whether the part that was asked for is over.
    pub(crate) fn is_over(&self) -> bool {
        matches!(self.restarts, Restarts::Part(part) if self.part > part)
    }

    /// Whether stamps are as the file has them, so that its index leads to them.
    pub(crate) fn is_of_file(&self) -> bool {
        self.shift == Micros(0) && matches!(self.restarts, Restarts::Refuse)
    }

    /// Takes the next events of the file.
    pub(crate) fn push(&mut self, columns: &Columns) -> Result<(), ClockFault> {
        if let Some(mut head) = self.head.take() {
            // So few events do not show which clock is that of the recording.
            if head.len() + columns.len() <= MANY {
                head.append(columns);
                self.head = Some(head);
                return Ok(());
            }
            head.iter().try_for_each(|event| self.push_event(event))?;
        }
        if self.is_plain(columns) {
            // The usual case: no event is looked at alone.
            let newest = self.newest.unwrap_or(Micros(i64::MIN));
            let late = columns.t.partition_point(|t| *t < newest);
            self.disorder.sorted += late as u64;
            if late > 0 {
                self.is_sorted = false;
                self.disorder.delay = self.disorder.delay.max(span(columns.t[0], newest));
            }
            self.newest = columns.t.last().copied().max(self.newest);
            self.of_run += columns.len();
            self.read += columns.len() as u64;
            self.waiting.append(columns);
            return Ok(());
        }
        columns.iter().try_for_each(|event| self.push_event(event))
    }

    /// Whether events are in order and go on where the run has come to.
    fn is_plain(&self, columns: &Columns) -> bool {
        let (Some(first), Some(last), Some(newest)) =
            (columns.t.first(), columns.t.last(), self.newest)
        else {
            return false;
        };
        self.of_run > MANY
            && self.other.is_empty()
            && self.is_of_file()
            && first.0 >= self.given_to.0
            && goes_on(*first, newest)
            && goes_on(*last, newest)
            && columns.t.is_sorted()
    }

    fn push_event(&mut self, mut event: Event) -> Result<(), ClockFault> {
        if self.is_over() {
            return Ok(());
        }
        self.read += 1;
        event.t = Micros(event.t.0.saturating_add(self.shift.0));
        let Some(newest) = self.newest else {
            self.accept(event);
            return Ok(());
        };
        event.t = self.unwrapped(event.t, newest);
        if goes_on(event.t, newest) {
            self.leave_out_other()?;
            self.accept(event);
            return Ok(());
        }
        // Ahead of the run, time may go on in steps of any length.
        let may_leap = self.other_newest > newest && event.t > self.other_newest;
        if !(self.other.is_empty() || may_leap || goes_on(event.t, self.other_newest)) {
            self.leave_out_other()?;
        }
        if self.other.is_empty() {
            (self.other_newest, self.other_begin) = (event.t, self.read - 1);
        }
        self.other_newest = self.other_newest.max(event.t);
        self.other.push(event);
        if self.other.len() > FEW { self.follow_other() } else { Ok(()) }
    }

    /// A stamp with the wraparounds that bring it next to the newest.
    fn unwrapped(&mut self, t: Micros, newest: Micros) -> Micros {
        let wrapped = Micros(t.0.saturating_add(WRAP));
        if goes_on(wrapped, newest) && newest.0.saturating_sub(self.shift.0) < WRAP + FAR {
            self.shift = Micros(self.shift.0.saturating_add(WRAP));
            self.disorder.wraparounds += 1;
            return wrapped;
        }
        // Behind a wraparound, a late event still has a stamp of the period before.
        let before = Micros(t.0.saturating_sub(WRAP));
        if self.disorder.wraparounds > 0 && goes_on(before, newest) { before } else { t }
    }

    fn accept(&mut self, event: Event) {
        self.of_run += 1;
        self.oldest = self.oldest.min(event.t);
        if self.is_skipped() {
            self.newest = self.newest.max(Some(event.t));
            return;
        }
        // What is given away cannot be put in order any more.
        if event.t < self.given_to {
            self.count_strays(&[event.t], self.read - 1);
            return;
        }
        if let Some(newest) = self.newest.filter(|newest| event.t < *newest) {
            self.is_sorted = false;
            self.disorder.sorted += 1;
            self.disorder.delay = self.disorder.delay.max(span(event.t, newest));
        }
        self.newest = self.newest.max(Some(event.t));
        self.waiting.push(event);
    }

    /// Whether the present part was not asked for.
    fn is_skipped(&self) -> bool {
        matches!(self.restarts, Restarts::Part(part) if self.part != part)
    }

    /// The run goes on: what stood between had faulty stamps.
    fn leave_out_other(&mut self) -> Result<(), ClockFault> {
        if self.other.is_empty() {
            return Ok(());
        }
        let times = std::mem::take(&mut self.other).t;
        self.count_strays(&times, self.other_begin);
        // Some strays may come together: few of all, but many so far.
        self.check_strays(MANY)
    }

    /// Refuses a file of which more than one event in a thousand is a stray, from so many on.
    fn check_strays(&self, from: usize) -> Result<(), ClockFault> {
        let Disorder { strays, .. } = self.disorder;
        match strays > from as u64 && strays * ONE_IN > self.read {
            true => Err(ClockFault::None { strays, events: self.read }),
            false => Ok(()),
        }
    }

    fn count_strays(&mut self, times: &[Micros], number: u64) {
        self.disorder.strays += times.len() as u64;
        let first = times.first().map(|first| (number, *first));
        self.disorder.first_stray = self.disorder.first_stray.or(first);
    }

    /// More than a few events have the other clock: it is the one of the recording from now on.
    fn follow_other(&mut self) -> Result<(), ClockFault> {
        let other = std::mem::take(&mut self.other);
        let newest = self.newest.unwrap_or(self.other_newest);
        let first = other.t.iter().copied().min().unwrap_or(newest);
        // A few events at the beginning do not decide which clock is that of the recording.
        if self.of_run <= FEW && self.part == 1 {
            self.early.append(&std::mem::take(&mut self.waiting));
            self.silence = span(newest.min(first), newest.max(first));
            (self.newest, self.oldest) = (None, Micros(i64::MAX));
            (self.of_run, self.is_sorted) = (0, true);
        } else if first < newest {
            match self.restarts {
                Restarts::Refuse | Restarts::Sort => {
                    let event = self.other_begin;
                    return Err(ClockFault::Restart { event, from: newest, to: first });
                }
                Restarts::Part(_) => self.begin_part(),
                Restarts::Join => {
                    self.begin_part();
                    self.disorder.restarts += 1;
                    let later = span(first, newest);
                    self.shift = Micros(self.shift.0.saturating_add(later.0));
                    self.newest = Some(newest);
                    for mut event in other.iter() {
                        event.t = Micros(event.t.0.saturating_add(later.0));
                        self.accept(event);
                    }
                    return Ok(());
                }
            }
        }
        other.iter().for_each(|event| self.accept(event));
        Ok(())
    }

    fn begin_part(&mut self) {
        self.part += 1;
        (self.newest, self.oldest, self.of_run) = (None, Micros(i64::MAX), 0);
    }

    /// Count of events that wait.
    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Count of the first events that can be given away.
    pub(crate) fn ready(&mut self) -> usize {
        // A few events at the beginning may turn out to be faults.
        if self.head.is_some() || self.of_run <= MANY && self.part == 1 && !self.is_behind_seek {
            return 0;
        }
        self.decide_early();
        self.sort();
        if self.waiting.len() > MAX_WAITING {
            return self.waiting.len();
        }
        let newest = self.newest.unwrap_or(Micros(i64::MAX));
        let safe = Micros(newest.0.saturating_sub(MAX_DELAY.0));
        self.waiting.t.partition_point(|t| *t < safe)
    }

    /// Decides on the few events before the run.
    fn decide_early(&mut self) {
        let early = std::mem::take(&mut self.early);
        let newest = self.newest.unwrap_or(self.oldest);
        let is_before = early.t.iter().all(|t| *t < self.oldest);
        let is_fault = is_far(self.silence, span(self.oldest, newest), self.of_run);
        if is_fault && !(is_before && self.is_behind_seek) {
            self.count_strays(&early.t, 0);
        } else if !early.is_empty() {
            self.waiting.append(&early);
            self.is_sorted = false;
        }
    }

    /// Moves the first `count` waiting events to `columns`.
    pub(crate) fn give(&mut self, count: usize, columns: &mut Columns) {
        if let Some(last) = self.waiting.t[..count].last() {
            self.given_to = *last;
        }
        self.waiting.move_first(count, columns);
    }

    /// The file is over: everything is given away.
    pub(crate) fn finish(&mut self, columns: &mut Columns) -> Result<(), ClockFault> {
        if let Some(head) = self.head.take() {
            self.finish_small(&head, columns);
            return Ok(());
        }
        self.decide_early();
        if let Some(newest) = self.newest.filter(|newest| self.other_newest > *newest) {
            let silence = span(newest, self.other.t.iter().copied().min().unwrap_or(newest));
            // The last events of a file have none behind them that could show their clock.
            if !is_far(silence, span(self.oldest, newest), self.of_run) {
                self.waiting.append(&std::mem::take(&mut self.other));
                self.is_sorted = false;
            }
        }
        self.leave_out_other()?;
        self.give_all(columns);
        if self.is_behind_seek { Ok(()) } else { self.check_strays(FEW) }
    }

    /// Gives everything away that waits.
    pub(crate) fn give_all(&mut self, columns: &mut Columns) {
        self.sort();
        self.give(self.waiting.len(), columns);
    }

    /// Of so few events, none is known to be a fault: all are sorted.
    fn finish_small(&mut self, head: &Columns, columns: &mut Columns) {
        let mut newest = Micros(i64::MIN);
        for t in &head.t {
            if *t < newest {
                self.disorder.sorted += 1;
                self.disorder.delay = self.disorder.delay.max(span(*t, newest));
            }
            newest = newest.max(*t);
        }
        self.waiting.append(head);
        self.is_sorted = false;
        self.give_all(columns);
    }

    /// Stable: events of one time keep their order.
    fn sort(&mut self) {
        if !self.is_sorted {
            self.waiting.sort();
            self.is_sorted = true;
        }
    }
}

/// Whether a whole recording has one clock that never goes back.
pub(crate) fn is_in_order(times: &[Micros]) -> bool {
    // Without a branch for each pair, which is several times faster. Steps are less than 64 bits
    // without a sign, of any two times.
    times.windows(2).fold(true, |is_so, pair| {
        let step = pair[1].0.wrapping_sub(pair[0].0) as u64;
        is_so & (pair[0] <= pair[1]) & (step <= FAR as u64)
    })
}

/// Time from one stamp to another; stamps may be any numbers.
fn span(from: Micros, to: Micros) -> Micros {
    Micros(to.0.saturating_sub(from.0))
}

/// Whether a silence beside `events` events over `span` shows that stamps are faults.
fn is_far(silence: Micros, span: Micros, events: usize) -> bool {
    let interval = span.0 / events.max(1) as i64;
    silence.0 > FAR.max(interval.saturating_mul(FAR_INTERVALS))
}

/// Whether a stamp is one that the clock may have next.
fn goes_on(t: Micros, newest: Micros) -> bool {
    newest.0.saturating_sub(MAX_DELAY.0) <= t.0 && t.0 <= newest.0.saturating_add(FAR)
}

#[cfg(test)]
mod tests;
