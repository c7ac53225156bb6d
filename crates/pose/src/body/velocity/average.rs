//! Averages of the velocities of pixel triplets.

use glam::{DMat2, DVec2};

use super::triplet::step;

/// The valid triplets that end at one pixel.
#[derive(Default)]
pub(super) struct PixelTriplets {
    /// Direction of motion and time for one step in it, microseconds.
    triplets: [(usize, f64); 8],
    count: usize,
}

impl PixelTriplets {
    pub(super) fn push(&mut self, direction: usize, us_per_step: f64) {
        self.triplets[self.count] = (direction, us_per_step);
        self.count += 1;
    }

    fn iter(&self) -> impl Iterator<Item = (DVec2, f64)> + '_ {
        self.triplets[..self.count].iter().map(|&(direction, us)| (step(direction), us))
    }

    /// Velocity of each triplet, px/µs.
    pub(super) fn velocities(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.iter().map(|(d, us)| d / us)
    }

    /// Velocity of the edge across itself, px/µs, if the triplets are those of one straight edge.
    ///
    /// Times about an edge are a plane of slope `g = n / speed`: a step `d` takes `g · d`. It is
    /// fitted to the triplets, each of which it must explain as well as two steps must agree.
    pub(super) fn normal_flow(&self, tolerance: f64) -> Option<DVec2> {
        let mut normal = DMat2::ZERO;
        let mut right = DVec2::ZERO;
        for (d, us) in self.iter() {
            normal += DMat2::from_cols(d * d.x, d * d.y);
            right += d * us;
        }
        // Sums of small integers are exact: 0 means that all triplets lie on one line.
        let determinant = normal.determinant();
        let slope = if determinant > 0.0 {
            normal.inverse() * right
        } else {
            // One line gives the slope along it alone; the trace yields the shortest such slope.
            right / (normal.x_axis.x + normal.y_axis.y)
        };
        let fits = |(d, us): (DVec2, f64)| (slope.dot(d) - us).abs() <= tolerance * us;
        (self.count > 0 && self.iter().all(fits)).then(|| slope / slope.length_squared())
    }
}

/// Running mean of velocities.
#[derive(Default)]
pub(super) struct FlowMean {
    sum: DVec2,
    count: u32,
}

impl FlowMean {
    pub(super) fn extend(&mut self, velocities: impl IntoIterator<Item = DVec2>) {
        for velocity in velocities {
            self.sum += velocity;
            self.count += 1;
        }
    }

    /// The mean, 0 of none, and the count.
    pub(super) fn finish(&self) -> (DVec2, u32) {
        (self.sum / f64::from(self.count.max(1)), self.count)
    }
}
