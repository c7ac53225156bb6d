//! Velocities of joints from triplets: three pixels in a row that fired one after the other.

use evpose_core::{EventStream, SensorSize};
use glam::{DVec2, Vec2};

use super::active_events::{ActiveSurface, NEVER};
use super::average::{FlowMean, PixelTriplets};
use super::{FlowAverage, TripletVelocityConfig};
use crate::PoseError;
use crate::body::{BODY_JOINTS, BodyPoints};

/// Pixels from the middle of a patch to its sides: a triplet is three pixels long.
const REACH: usize = 2;

/// Rows of times about a pixel.
type Patch<'a> = [&'a [i64]; 2 * REACH + 1];

/// Velocity of a joint in the image.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JointVelocity {
    /// Columns and rows per second; 0 where no edge moved.
    pub px_per_s: Vec2,
    /// Fitted pixels, or triplets, that it is the mean of.
    pub samples: u32,
}

/// Velocities of the regions about joints, from the events of a stream.
///
/// # Model
/// Where an edge came past three pixels in a row, the times `t2`, `t1`, `t0` at which they fired
/// are evenly spaced, and in `(t0 - t2) / 2` it makes one step in this direction. Such triplets are
/// searched for from every pixel of a region that fired since the last query, in eight directions,
/// and averaged by [`FlowAverage`] into the velocity of the region.
///
/// Triplets end at least two pixels from the sides of the region and of the sensor. A joint whose
/// region, cut by the sensor, is narrower than five pixels has velocity zero.
///
/// # Source
/// hpe-core's `pwtripletvelocity`. Published times are seconds, of which 0 stands for no event;
/// here an event of time 0 is one like all others.
#[derive(Debug, Clone)]
pub struct TripletVelocity {
    config: TripletVelocityConfig,
    active_events: ActiveSurface,
    /// Time of the newest event at the last query, microseconds.
    seen_us: i64,
}

impl TripletVelocity {
    /// An estimator for the events of a sensor, without events yet.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(sensor: SensorSize, config: TripletVelocityConfig) -> Result<Self, PoseError> {
        config.validate()?;
        Ok(Self { config, active_events: ActiveSurface::new(sensor), seen_us: NEVER })
    }

    /// Takes further events. Events earlier than the last start another stream, and the state is
    /// reset.
    ///
    /// # Panics
    /// If they are from a sensor of another size.
    pub fn push(&mut self, events: &EventStream) {
        if self.active_events.is_before(events) {
            self.reset();
        }
        self.active_events.push(events);
    }

    /// Velocities around joints, given in pixels, from the pixels that fired since the last query;
    /// zero for unknown joints.
    ///
    /// Pixels count as new if they fired later than the latest event that the last query knew.
    pub fn query(&mut self, joints: &BodyPoints) -> [JointVelocity; BODY_JOINTS] {
        let velocities = joints.map(|joint| joint.map_or_else(Default::default, |at| self.at(at)));
        self.seen_us = self.active_events.newest_us();
        velocities
    }

    /// Forgets every event.
    pub fn reset(&mut self) {
        self.active_events.reset();
        self.seen_us = NEVER;
    }

    /// The velocity around a position. Not a query: the same pixels remain new.
    pub fn at(&self, place_px: Vec2) -> JointVelocity {
        let tolerance = self.config.tolerance;
        match self.config.average {
            FlowAverage::NormalFlow => {
                self.mean(place_px, |sum, pixel| sum.extend(pixel.normal_flow(tolerance)))
            }
            FlowAverage::Triplets => {
                self.mean(place_px, |sum, pixel| sum.extend(pixel.velocities()))
            }
        }
    }

    /// The mean over the new pixels of a region, each of which adds what it has to.
    fn mean(&self, place_px: Vec2, add: impl Fn(&mut FlowMean, &PixelTriplets)) -> JointVelocity {
        let SensorSize { width, height } = self.active_events.sensor();
        let (columns, rows) = (self.middles(place_px.x, width), self.middles(place_px.y, height));
        let mut sum = FlowMean::default();
        for y in rows {
            let patch: Patch<'_> = std::array::from_fn(|dy| self.active_events.row(y + dy - REACH));
            for x in columns.clone() {
                // Pixels without an event since the last call add nothing new.
                if patch[REACH][x] > self.seen_us {
                    add(&mut sum, &self.triplets(&patch, x));
                }
            }
        }
        let (px_per_us, samples) = sum.finish();
        JointVelocity { px_per_s: (px_per_us * (1e6 * self.config.gain)).as_vec2(), samples }
    }

    /// Along one side of a region, the pixels that are the middles of whole patches; none if the
    /// region is too narrow, or its position NaN.
    fn middles(&self, place_px: f32, side: u16) -> std::ops::Range<usize> {
        // A float that is too large for an integer becomes the largest.
        let (middle, radius) = (place_px.floor() as i64, i64::from(self.config.radius_px));
        let first = middle.saturating_sub(radius).max(0);
        let last = middle.saturating_add(radius).min(i64::from(side) - 1);
        let reach = REACH as i64;
        if place_px.is_nan() || last - first < 2 * reach {
            return 0..0;
        }
        (first + reach) as usize..(last - reach + 1) as usize
    }

    /// The valid triplets that end at the middle of a patch.
    #[inline]
    fn triplets(&self, patch: &Patch<'_>, x: usize) -> PixelTriplets {
        let newest = patch[REACH][x];
        let mut triplets = PixelTriplets::default();
        for (k, direction) in DIRECTIONS.iter().enumerate() {
            let fired = |steps: isize| {
                // An edge comes from against its direction, where the pixels fired earlier.
                let row = REACH as isize - steps * direction[1];
                patch[row as usize][(x as isize - steps * direction[0]) as usize]
            };
            let (near, far) = (fired(1), fired(2));
            let (late_us, early_us) = (newest - near, near - far);
            // Events at one time give no speed, and pixels without events no time.
            if late_us <= 0 || early_us <= 0 || far == NEVER {
                continue;
            }
            let (late_us, early_us) = (late_us as f64, early_us as f64);
            // An edge of constant speed takes as long for either step.
            if (late_us - early_us).abs() <= self.config.tolerance * late_us {
                triplets.push(k, 0.5 * (late_us + early_us));
            }
        }
        triplets
    }
}

/// Directions from a pixel to its eight neighbours, `[dx, dy]`.
const DIRECTIONS: [[isize; 2]; 8] =
    [[1, 1], [1, 0], [1, -1], [0, -1], [-1, -1], [-1, 0], [-1, 1], [0, 1]];

/// A direction as a vector.
pub(super) fn step(direction: usize) -> DVec2 {
    let [x, y] = DIRECTIONS[direction];
    DVec2::new(x as f64, y as f64)
}
