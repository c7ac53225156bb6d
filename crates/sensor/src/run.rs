//! A sensor at work: luminance in, events out.

use std::sync::Arc;

use evpose_core::{Event, EventStream, Micros, Plane, Polarity, SensorSize, StageNoise};

use crate::front::Front;
use crate::model::Chain;
use crate::stage::Tick;
use crate::{Request, SensorError, SensorModel, clock, request};

/// A sensor between two exposures, with all state and memory to work in.
#[derive(Debug)]
pub struct SensorRun {
    chain: Arc<Chain>,
    size: SensorSize,
    seed: u64,
    front: Front,
    readout_state: Vec<f64>,
    /// Number and time of the exposure before.
    last: Option<(u64, Micros)>,
    requests: Vec<Request>,
    /// Events stamped later than the exposure that caused them.
    pending: Vec<Stamped>,
    events: EventStream,
}

/// An event that waits for its turn.
#[derive(Debug, Clone, Copy)]
struct Stamped {
    t: Micros,
    pixel: u32,
    polarity: Polarity,
}

impl SensorRun {
    pub(crate) fn new(chain: Arc<Chain>, size: SensorSize, seed: u64, block_pixels: usize) -> Self {
        Self {
            front: Front::new(&chain, size, seed, block_pixels),
            readout_state: vec![0.0; chain.readout.stage.state_len()],
            chain,
            size,
            seed,
            last: None,
            requests: Vec::new(),
            pending: Vec::new(),
            events: EventStream::empty(size),
        }
    }

    /// Shows the sensor a luminance plane, linear and relative to white (1.0), at time `t`.
    ///
    /// Gives the events later than the exposure before and not later than this one, in order of
    /// time and at equal times row by row from the top left. At the first exposure the sensor
    /// settles. Luminance that is negative or not finite is taken as darkness and counted in
    /// [`SensorRun::repaired_pixels`].
    ///
    /// # Errors
    /// A plane that does not fit the sensor, or a time that is not later than the one before; the
    /// sensor is then as it was.
    pub fn expose(
        &mut self,
        luminance: &Plane<f32>,
        t: Micros,
    ) -> Result<&EventStream, SensorError> {
        let tick = self.next_tick(luminance, t)?;
        let chain = Arc::clone(&self.chain);
        self.requests.clear();
        self.front.step(&chain, &tick, luminance.data(), &mut self.requests);
        for link in &chain.background {
            let noise = StageNoise::new(self.seed, link.name, tick.index);
            link.stage.step(&tick, self.size, &mut self.requests, noise);
        }
        request::sort(&mut self.requests);
        for request in &mut self.requests {
            request.t_s = chain.readout.stage.acknowledge(request, &mut self.readout_state);
        }
        for link in &chain.clock {
            let noise = StageNoise::new(self.seed, link.name, tick.index);
            link.stage.step(&tick, &mut self.requests, noise);
        }
        // What happens at the very start of a step comes behind what was delivered up to there.
        let earliest = self.last.map_or(t, |(_, previous)| previous + Micros(1));
        self.last = Some((tick.index, t));
        self.stamp(earliest);
        self.deliver(t)?;
        Ok(&self.events)
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

    fn next_tick(&self, luminance: &Plane<f32>, t: Micros) -> Result<Tick, SensorError> {
        let (width, height) = (luminance.width(), luminance.height());
        if (width, height) != (usize::from(self.size.width), usize::from(self.size.height)) {
            return Err(SensorError::PlaneSize { width, height, sensor: self.size });
        }
        let end_s = t.as_seconds();
        match self.last {
            None => Ok(Tick { start_s: end_s, end_s, index: 0 }),
            Some((_, previous)) if t <= previous => Err(SensorError::NotLater { t, previous }),
            Some((index, previous)) => {
                Ok(Tick { start_s: previous.as_seconds(), end_s, index: index + 1 })
            }
        }
    }

    /// Puts what was served behind the events that wait, in order of timestamps.
    fn stamp(&mut self, earliest: Micros) {
        self.pending.extend(self.requests.iter().map(|request| Stamped {
            t: clock::stamp(request.t_s).max(earliest),
            pixel: request.pixel,
            polarity: request.polarity,
        }));
        // Requests came in order of time, which only a clock or a late event can have changed.
        if !self.pending.is_sorted_by_key(|event| event.t) {
            self.pending.sort_by_key(|event| event.t);
        }
        // Events of one pixel at one time keep their order.
        for same_time in self.pending.chunk_by_mut(|a, b| a.t == b.t) {
            if !same_time.is_sorted_by_key(|event| event.pixel) {
                same_time.sort_by_key(|event| event.pixel);
            }
        }
    }

    /// Hands out what is due by `now`.
    fn deliver(&mut self, now: Micros) -> Result<(), SensorError> {
        let due = self.pending.partition_point(|event| event.t <= now);
        let width = u32::from(self.size.width);
        self.events.clear();
        for Stamped { t, pixel, polarity } in self.pending.drain(..due) {
            let (x, y) = ((pixel % width) as u16, (pixel / width) as u16);
            self.events.push(Event { t, x, y, polarity })?;
        }
        Ok(())
    }
}
