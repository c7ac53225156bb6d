//! A sensor at work: luminance in, events out.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use evpose_core::{EventStream, Micros, Plane, SensorSize, StageNoise, seed_for};
use evpose_cpu::ThreadPool;

use crate::chain::Chain;
use crate::changes::STRIP;
use crate::delivery::Delivery;
use crate::detector::queue::Queue;
use crate::detector::resolve::{Step, Voltages};
use crate::detector::{Band, PixelArray};
use crate::formula;
use crate::formula::events::EventMemory;
use crate::front::Front;
use crate::front_band::{FrontBand, Observers, Resolution};
use crate::model::Layout;
use crate::optics::divider::Divider;
use crate::plan::Division;
use crate::readout::{ReadoutMemory, Service};
use crate::stamped::{RowDivision, StampedEvents};
use crate::tap::Tap;
use crate::tick::Tick;
use crate::{Origin, Request, SensorError, SensorModel, request};

/// Movement is in one part of the image: bands of all its parts make threads even.
const BANDS_PER_THREAD: usize = 2;

/// A sensor between two exposures, with all state and memory to work in.
#[derive(Debug)]
pub struct SensorRun {
    chain: Arc<Chain>,
    size: SensorSize,
    seed: u64,
    detector_key: u64,
    divider: Divider,
    front: Front,
    array: PixelArray,
    queue: Queue,
    readout_memory: ReadoutMemory,
    event_memory: Option<EventMemory>,
    clock_states: Vec<Vec<f64>>,
    /// Number and time of the exposure before.
    last: Option<(u64, Micros)>,
    requests: Vec<Request>,
    thread_pool: ThreadPool,
    band_requests: Vec<Vec<Request>>,
    /// Events of bands, or of all pixels at the first place.
    stamped: Vec<StampedEvents>,
    rows: RowDivision,
    background: Vec<Request>,
    taps: Vec<Tap>,
    delivery: Delivery,
}

impl SensorRun {
    pub(crate) fn new(chain: Arc<Chain>, size: SensorSize, seed: u64, layout: Layout) -> Self {
        let clocks = chain.clock.iter().map(|link| vec![0.0; link.stage.state_len()]);
        Self {
            // By name, as in the front: the noise of the detector does not depend on other stages.
            detector_key: seed_for(seed, chain.detector.name, 0),
            divider: Divider::new(&chain),
            front: Front::new(&chain, size, seed, layout.block_pixels),
            array: PixelArray::new(&chain, size, seed),
            queue: Queue::default(),
            readout_memory: ReadoutMemory::new(&*chain.readout.stage, size),
            event_memory: event_memory(&chain, size, seed),
            clock_states: clocks.collect(),
            chain,
            size,
            seed,
            last: None,
            requests: Vec::new(),
            thread_pool: ThreadPool::new(layout.threads),
            band_requests: Vec::new(),
            stamped: vec![StampedEvents::new()],
            rows: RowDivision::new(size.width),
            background: Vec::new(),
            taps: Vec::new(),
            delivery: Delivery::new(size),
        }
    }

    /// Shows the sensor a luminance plane, linear and relative to white (1.0), at time `t`.
    ///
    /// Gives the events later than the exposure before and not later than this one, in order of
    /// time and at equal times row by row from the top left; on a clock that is behind or scatters,
    /// those that nothing can come before any more. At the first exposure the sensor settles.
    /// Luminance that is negative or not finite is taken as darkness and counted in
    /// [`SensorRun::repaired_pixels`].
    ///
    /// # Errors
    /// A plane that does not fit the sensor, a stage made for another sensor, or a time that is not
    /// later than the one before; the sensor is then as it was.
    pub fn expose(
        &mut self,
        luminance: &Plane<f32>,
        t: Micros,
    ) -> Result<&EventStream, SensorError> {
        let tick = self.next_tick(luminance, t)?;
        let chain = Arc::clone(&self.chain);
        // What happens at the very start of a step comes behind what was delivered up to there.
        let earliest = self.last.map_or(t, |(_, previous)| earliest_stamp(&chain, previous));
        self.requests.clear();
        self.stamped.iter_mut().for_each(StampedEvents::clear);
        self.array.keep_anchor(self.front.before_mut(), tick.start_s);
        self.array.draw_noise_events(&chain, &tick, &self.thread_pool);
        let feeds_back = chain.plan.is_queued;
        self.background.clear();
        if feeds_back {
            // Noise takes its place in the queue.
            self.add_background(&chain, &tick, true);
        }
        let parts = self.divider.parts(&chain, &tick, luminance.data());
        let stamps_from = (parts == 1 && chain.delivers_requests()).then_some(earliest);
        for part in 0..parts {
            let step = tick.part(part, parts);
            if parts == 1 {
                self.step(&chain, &step, luminance.data(), stamps_from);
            } else {
                let light = self.divider.light(&chain, luminance.data(), part + 1, parts);
                self.step(&chain, &step, &light, None);
                self.divider.give_back(light);
            }
        }
        self.divider.keep(luminance.data());
        if !feeds_back {
            self.add_background(&chain, &tick, false);
            self.serve(&chain, &tick);
        }
        self.apply_formula(&chain, &tick, luminance.data());
        self.run_clocks(&chain, &tick);
        if !self.requests.is_empty() {
            self.stamped[0].stamp(&self.requests, earliest, self.rows);
        }
        self.last = Some((tick.index, t));
        // On a clock that is behind, the next step may yet have events stamped up to here.
        let due = earliest_stamp(&chain, t) - Micros(1);
        self.delivery.deliver(&self.stamped, due)?;
        Ok(self.delivery.events())
    }

    /// Goes on with the parameters of `model`: the same chain, its state kept. EventHands draws new
    /// thresholds in this way in the midst of a recording.
    ///
    /// # Errors
    /// If the stages of `model` are not those of this run; the run is then as it was.
    pub fn retune(&mut self, model: &SensorModel) -> Result<(), SensorError> {
        let (running, given) = (self.chain.names(), model.chain().names());
        if running != given {
            let (running, given) = (running.join(" > "), given.join(" > "));
            return Err(SensorError::OtherChain { running, given });
        }
        self.chain = Arc::clone(model.chain());
        self.divider.retune(&self.chain);
        // Patterns stay, the variables in use may be others.
        self.event_memory = event_memory(&self.chain, self.size, self.seed);
        // Voltages of skipped pixels would be those of the old parameters.
        self.front.mark_all_unknown();
        if let Some((_, t)) = self.last {
            self.array.retune(&self.chain, self.front.before_mut(), t.as_seconds());
        } else {
            self.array = PixelArray::new(&self.chain, self.size, self.seed);
        }
        Ok(())
    }

    /// The size of the sensor.
    pub fn size(&self) -> SensorSize {
        self.size
    }

    /// Luminance values so far that were negative or not finite, and were taken as darkness.
    pub fn repaired_pixels(&self) -> u64 {
        self.front.repaired()
    }

    /// From now on keeps why each event happened, or no longer does. Events are the same.
    pub fn label_origins(&mut self, is_labelled: bool) {
        self.delivery.label(is_labelled);
    }

    /// Why each event of the last exposure happened, if that is kept.
    pub fn origins(&self) -> Option<&[Origin]> {
        self.delivery.origins()
    }

    /// From now on records the signal of pixel (x, y) behind a stage of the chain, step by step.
    ///
    /// # Errors
    /// If the chain has no such stage with a signal, or the sensor no such pixel.
    pub fn tap(&mut self, stage: &str, (x, y): (u16, u16)) -> Result<(), SensorError> {
        let front = self.chain.front.iter().map(|link| link.name);
        let known: Vec<&'static str> = front.chain([self.chain.detector.name]).collect();
        let Some(&name) = known.iter().find(|name| **name == stage) else {
            return Err(SensorError::NoSignal { stage: stage.to_owned(), known });
        };
        if !self.size.contains(x, y) {
            return Err(SensorError::OutsideSensor { x, y, sensor: self.size });
        }
        let pixel = usize::from(y) * usize::from(self.size.width) + usize::from(x);
        self.taps.push(Tap::new(name, pixel));
        Ok(())
    }

    /// Recordings of the taps, in the order in which they were set.
    pub fn taps(&self) -> &[Tap] {
        &self.taps
    }

    #[cfg(test)]
    pub(crate) fn array_mut(&mut self) -> &mut PixelArray {
        &mut self.array
    }

    #[cfg(test)]
    pub(crate) fn front_mut(&mut self) -> &mut Front {
        &mut self.front
    }

    fn next_tick(&self, luminance: &Plane<f32>, t: Micros) -> Result<Tick, SensorError> {
        let (width, height) = (luminance.width(), luminance.height());
        if (width, height) != (usize::from(self.size.width), usize::from(self.size.height)) {
            return Err(SensorError::PlaneSize { width, height, sensor: self.size });
        }
        // Checked before anything changes: an error leaves the run as it was.
        for link in &self.chain.terms {
            if let Some(made_for) = link.traits.made_for.filter(|size| *size != self.size) {
                let (effect, sensor) = (link.name, self.size);
                return Err(SensorError::MadeForOther { effect, made_for, sensor });
            }
        }
        let end_s = t.as_seconds();
        match self.last {
            // The first exposure has no length: memories start at it.
            None => Ok(Tick { start_s: end_s, end_s, index: 0 }),
            Some((_, previous)) if t <= previous => Err(SensorError::NotLater { t, previous }),
            Some((index, previous)) => {
                Ok(Tick { start_s: previous.as_seconds(), end_s, index: index + 1 })
            }
        }
    }

    /// From light to requests, or to events where the readout makes pixels wait. Bands stamp their
    /// own events, none before `stamps_from`, if nothing behind them needs requests.
    fn step(&mut self, chain: &Chain, tick: &Tick, light: &[f32], stamps_from: Option<Micros>) {
        self.array.begin_scan(chain, tick);
        if !chain.plan.is_queued && self.taps.is_empty() && chain.plan.division != Division::Whole {
            self.step_by_blocks(chain, tick, light, stamps_from);
        } else {
            self.step_whole(chain, tick, light);
        }
    }

    /// Every block of pixels goes through the whole step before the next one, in bands at the same
    /// time.
    fn step_by_blocks(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        light: &[f32],
        stamps_from: Option<Micros>,
    ) {
        let noise = StageNoise::at_tick(self.detector_key, tick.index);
        let per_s = 1.0 / tick.dt_s();
        let skips_unchanged = self.front.skips_unchanged(chain);
        let rows = self.rows;
        let threads = self.thread_pool.threads();
        let in_bands = threads > 1 && chain.plan.division == Division::Bands;
        // More bands than threads, since those with many events take longer.
        let bands = if in_bands { BANDS_PER_THREAD * threads } else { 1 };
        let ranges = band_ranges(self.size.pixels(), bands);
        let fronts = self.front.bands(&ranges);
        let arrays = self.array.bands(&ranges);
        let step = |front: &mut FrontBand<'_>,
                    array: &mut Band<'_>,
                    requests: &mut Vec<Request>| {
            let resolution = Resolution { per_s, noise, requests };
            if skips_unchanged {
                front.step_changes(chain, tick, light, array, resolution);
            } else {
                let resolution = Some(resolution);
                front.step(chain, tick, light, &mut Observers { array, taps: &mut [], resolution });
            }
        };
        // A single band writes straight into the buffer of the step.
        if ranges.len() == 1 {
            for (mut front, mut array) in fronts.into_iter().zip(arrays) {
                step(&mut front, &mut array, &mut self.requests);
            }
        } else {
            self.band_requests.resize_with(ranges.len(), Vec::new);
            self.stamped.resize_with(ranges.len(), StampedEvents::new);
            let room = self.band_requests.iter_mut().zip(&mut self.stamped);
            let bands = fronts.into_iter().zip(arrays).zip(room);
            let bands: Vec<_> = bands.map(Mutex::new).collect();
            self.thread_pool.run(&|part| {
                // In turns: neighbouring bands have about as many events.
                for band in bands.iter().skip(part.index).step_by(part.count) {
                    // No other thread has this band.
                    let ((front, array), (requests, stamped)) =
                        &mut *band.lock().unwrap_or_else(PoisonError::into_inner);
                    // Taken out: lengths of lists side by side, in one cache line, would go to and
                    // fro between threads with every request.
                    let mut own_requests = std::mem::take(*requests);
                    own_requests.clear();
                    step(front, array, &mut own_requests);
                    if let Some(earliest) = stamps_from {
                        stamped.stamp(&own_requests, earliest, rows);
                    }
                    **requests = own_requests;
                }
            });
            drop(bands);
            // In the order of bands, whichever thread ran them.
            if stamps_from.is_none() {
                for requests in &self.band_requests {
                    self.requests.extend_from_slice(requests);
                }
            }
        }
        if skips_unchanged {
            self.front.swap_steps();
        }
    }

    /// All pixels go through every stage before the first is resolved.
    fn step_whole(&mut self, chain: &Chain, tick: &Tick, light: &[f32]) {
        let all = 0..self.size.pixels();
        let mut array = self.array.whole();
        for mut front in self.front.bands(std::slice::from_ref(&all)) {
            let (array, taps) = (&mut array, &mut *self.taps);
            front.step(chain, tick, light, &mut Observers { array, taps, resolution: None });
        }
        let (before, after) = self.front.voltages();
        let [before, after] = [before, after].map(|values| Voltages { first: 0, values });
        let noise = StageNoise::at_tick(self.detector_key, tick.index);
        let step = Step { chain, tick, before, after, per_s: 1.0 / tick.dt_s(), noise };
        if chain.plan.is_queued {
            // Background is drawn per exposure; a divided step has the requests of its part.
            let now = |r: &&Request| r.t_s > tick.start_s && r.t_s <= tick.end_s;
            let background: Vec<Request> = self.background.iter().filter(now).copied().collect();
            let readout = &*chain.readout.stage;
            let mut service = Service::new(readout, self.size, &mut self.readout_memory);
            let queue = &mut self.queue;
            array.resolve_served(step, queue, &background, &mut service, &mut self.requests);
        } else {
            array.resolve(step, &mut self.requests);
        }
        // Behind all pixels: the residual is what their events left.
        for tap in self.taps.iter_mut().filter(|tap| tap.stage() == chain.detector.name) {
            tap.push(tick.end_s, array.residual(step, tap.pixel()));
        }
        self.front.swap_steps();
    }

    /// Lets the background act on the requests, or makes requests of its own to be queued.
    fn add_background(&mut self, chain: &Chain, tick: &Tick, is_queued: bool) {
        let requests = if is_queued { &mut self.background } else { &mut self.requests };
        for link in &chain.background {
            let noise = StageNoise::new(self.seed, link.name, tick.index);
            link.stage.step(tick, self.size, requests, noise);
        }
        // Background stages know nothing of pixels: dead ones are silenced here.
        if !chain.background.is_empty() {
            requests.retain(|request| !self.array.is_dead(request.pixel));
        }
    }

    /// A readout that pixels do not wait for delays events, or loses them.
    fn serve(&mut self, chain: &Chain, tick: &Tick) {
        let readout = &*chain.readout.stage;
        if chain.readout.traits.is_static {
            return;
        }
        request::sort(&mut self.requests);
        let mut service = Service::new(readout, self.size, &mut self.readout_memory);
        service.serve(tick.end_s, &mut self.requests);
    }

    /// Lets the formula of events act on those that are read out.
    fn apply_formula(&mut self, chain: &Chain, tick: &Tick, light: &[f32]) {
        if let (Some(formula), Some(memory)) = (&chain.event_formula, &mut self.event_memory) {
            let noise = StageNoise::new(self.seed, formula::SPEC.name, tick.index);
            formula.step(tick, light, &mut self.requests, memory, noise);
        }
    }

    fn run_clocks(&mut self, chain: &Chain, tick: &Tick) {
        for (link, state) in chain.clock.iter().zip(&mut self.clock_states) {
            if link.traits.needs_order {
                request::sort(&mut self.requests);
            }
            let noise = StageNoise::new(self.seed, link.name, tick.index);
            link.stage.step(tick, &mut self.requests, state, noise);
        }
    }
}

/// Memory of the formula of events. Its patterns are those of tick zero, at which there are no events.
fn event_memory(chain: &Chain, size: SensorSize, seed: u64) -> Option<EventMemory> {
    let noise = StageNoise::new(seed, formula::SPEC.name, 0);
    chain.event_formula.as_ref().map(|formula| formula.memory(size, noise))
}

/// Up to `bands` bands of whole strips, as even as these allow.
fn band_ranges(pixels: usize, bands: usize) -> Vec<Range<usize>> {
    let each = pixels.div_ceil(bands).next_multiple_of(STRIP).max(STRIP);
    let starts = (0..pixels.max(1)).step_by(each);
    starts.map(|start| start..(start + each).min(pixels)).collect()
}

/// The first stamp that an event behind an exposure at `previous` can have: the microsecond after
/// it, or less on a clock that is behind.
fn earliest_stamp(chain: &Chain, previous: Micros) -> Micros {
    let mut shown_s = previous.as_seconds();
    for link in &chain.clock {
        shown_s = link.stage.earliest_shown(shown_s);
    }
    previous.min(crate::clock::stamp(shown_s)) + Micros(1)
}
