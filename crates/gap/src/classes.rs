//! Classes of pixels and times by brightness, speed, age and contrast: the strata of the
//! comparison.
//!
//! They are computed from the known luminance alone, never from events, so that a class cannot leak
//! the answer.

use evpose_core::stats::quantile::upper_index;

use crate::LightSequence;

/// Added to luminance before the logarithm, so that perfect darkness has a finite class.
const FLOOR: f32 = 1e-5;
/// Rate of change of log luminance, per second, below which a pixel is at rest.
const REST_PER_S: f32 = 0.4;
/// Half the window over which the rate of change is taken, seconds.
const HALF_WINDOW_S: f64 = 0.002;
/// Edges of the age classes: time since the last change, seconds.
const AGES_S: [f64; 6] = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2];
/// Edges of the contrast classes: change of log luminance over a monotone stretch.
const CONTRASTS: [f32; 3] = [0.3, 0.8, 1.5];

/// Strides of the samples of luminance, speed and curvature; primes, so that they do not follow
/// rows.
const SAMPLE_STRIDES: [usize; 3] = [97, 101, 103];

/// Classes of one pixel between two planes, packed in 12 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cell(u16);

impl Cell {
    /// Number of brightness classes.
    pub const BRIGHTNESSES: usize = 5;
    /// Number of speed classes: rest, slow, middle and fast.
    pub const SPEEDS: usize = 4;
    /// Number of age classes: moving, six ages, and at rest for long.
    pub const AGES: usize = 8;
    /// Number of contrast classes.
    pub const CONTRASTS: usize = 4;

    fn new(
        bright: usize,
        speed: usize,
        age: usize,
        contrast: usize,
        rises: bool,
        fine: bool,
    ) -> Self {
        let bits = bright | speed << 3 | age << 5 | contrast << 8;
        Self(bits as u16 | u16::from(rises) << 10 | u16::from(fine) << 11)
    }

    /// Brightness class: fifths of all pixels and times by luminance, the darkest first.
    pub fn brightness(self) -> usize {
        usize::from(self.0 & 7)
    }

    /// Speed class: zero at rest, then thirds of all moving pixels and times by rate of change.
    pub fn speed(self) -> usize {
        usize::from(self.0 >> 3 & 3)
    }

    /// Age class: zero while luminance changes, then by the time since it did; seven after 200 ms.
    pub fn age(self) -> usize {
        usize::from(self.0 >> 5 & 7)
    }

    /// Contrast class: change of log luminance over the current or last monotone stretch.
    pub fn contrast(self) -> usize {
        usize::from(self.0 >> 8 & 3)
    }

    /// Whether luminance rises in the current or last monotone stretch.
    pub fn rises(self) -> bool {
        self.0 >> 10 & 1 == 1
    }

    /// Whether luminance has fine structure here: a Laplacian in the upper quarter.
    pub fn is_fine(self) -> bool {
        self.0 >> 11 & 1 == 1
    }

    /// Whether luminance has been at rest for at least 50 ms.
    pub fn is_quiet(self) -> bool {
        self.age() >= 5
    }
}

/// Log luminance and classes of all pixels and times of a scene.
#[derive(Debug)]
pub struct Classes {
    pixels: usize,
    steps: usize,
    fps: f64,
    /// Log luminance, plane after plane.
    log: Vec<f32>,
    cells: Vec<Cell>,
    /// Time at rest by brightness class, in pixel seconds.
    quiet_pixel_s: [f64; Cell::BRIGHTNESSES],
}

impl Classes {
    /// Computes the classes of a scene.
    pub fn from_scene(scene: &LightSequence) -> Self {
        let pixels = scene.size().pixels();
        let steps = scene.planes().len() - 1;
        let mut log = Vec::with_capacity(pixels * (steps + 1));
        for plane in scene.planes() {
            log.extend(plane.data().iter().map(|y| (y.max(0.0) + FLOOR).ln()));
        }
        let levels = levels(&log);
        // Over a window of fixed time: between two frames of a fast scene, codes jump or stand
        // still.
        let half = (HALF_WINDOW_S * scene.fps()).round().max(1.0) as usize;
        let change = |k: usize, p: usize| {
            let (a, b) = (k.saturating_sub(half - 1), (k + half).min(steps));
            (log[b * pixels + p] - log[a * pixels + p]) / ((b - a) as f64 / scene.fps()) as f32
        };
        let speeds = speed_limits(steps, pixels, &change);
        let ages = AGES_S.map(|s| (s * scene.fps()).round() as usize);
        let mut cells = vec![Cell::default(); pixels * steps];
        let width = usize::from(scene.size().width);
        let curved = Curvature::new(&log, width, pixels, steps);
        for p in 0..pixels {
            let (mut since, mut contrast, mut rises) = (usize::MAX, 0, true);
            let mut end = 0;
            for k in 0..steps {
                let rate = change(k, p);
                if rate.abs() >= REST_PER_S {
                    since = 0;
                    // A new edge: its whole height is looked ahead for once, and holds until the
                    // light turns.
                    if k >= end || (rate > 0.0) != rises {
                        rises = rate > 0.0;
                        end = (k + 1..steps).find(|&j| change(j, p) * rate <= 0.0).unwrap_or(steps);
                        let whole = (log[end * pixels + p] - log[k * pixels + p]).abs();
                        contrast = CONTRASTS.iter().filter(|limit| whole >= **limit).count();
                    }
                } else {
                    since = since.saturating_add(1);
                }
                let speed = match since {
                    0 => 1 + speeds.iter().filter(|limit| rate.abs() >= **limit).count(),
                    _ => 0,
                };
                let age = match since {
                    0 => 0,
                    _ => 1 + ages.iter().filter(|limit| since > **limit).count(),
                };
                let light = log[k * pixels + p];
                let bright = levels.iter().filter(|level| light >= **level).count();
                let is_fine = curved.is_fine(k, p);
                cells[k * pixels + p] = Cell::new(bright, speed, age, contrast, rises, is_fine);
            }
        }
        let mut quiet_pixel_s = [0.0; Cell::BRIGHTNESSES];
        for cell in cells.iter().filter(|cell| cell.is_quiet()) {
            quiet_pixel_s[cell.brightness()] += scene.step_s();
        }
        Self { pixels, steps, fps: scene.fps(), log, cells, quiet_pixel_s }
    }

    fn step_of(&self, t_s: f64) -> usize {
        ((t_s * self.fps) as usize).min(self.steps - 1)
    }

    /// Classes of a pixel at a time in seconds.
    pub fn cell(&self, pixel: usize, t_s: f64) -> Cell {
        // An event at the time of a plane belongs to the step before it.
        self.cells[self.step_of(t_s - 1e-9) * self.pixels + pixel]
    }

    /// Log luminance of a pixel, interpolated linearly between planes.
    pub fn log_at(&self, pixel: usize, t_s: f64) -> f32 {
        let k = self.step_of(t_s);
        let share = (t_s * self.fps - k as f64).clamp(0.0, 1.0) as f32;
        let (a, b) = (self.log[k * self.pixels + pixel], self.log[(k + 1) * self.pixels + pixel]);
        a + (b - a) * share
    }

    /// Rate of change of log luminance, per second.
    pub fn slope_at(&self, pixel: usize, t_s: f64) -> f32 {
        let k = self.step_of(t_s - 1e-9);
        let (a, b) = (self.log[k * self.pixels + pixel], self.log[(k + 1) * self.pixels + pixel]);
        (b - a) * self.fps as f32
    }

    /// Time at rest by brightness class, in pixel seconds.
    pub fn quiet_pixel_s(&self) -> [f64; Cell::BRIGHTNESSES] {
        self.quiet_pixel_s
    }
}

/// Edges of the fifths of log luminance, from a sample.
fn levels(log: &[f32]) -> [f32; 4] {
    let mut sample: Vec<f32> = log.iter().step_by(SAMPLE_STRIDES[0]).copied().collect();
    sample.sort_by(f32::total_cmp);
    [1, 2, 3, 4].map(|i| sample[upper_index(sample.len(), i, 5).min(sample.len() - 1)])
}

/// Edges of the thirds of the rates of change of moving pixels, from a sample.
fn speed_limits(steps: usize, pixels: usize, change: &impl Fn(usize, usize) -> f32) -> [f32; 2] {
    let mut sample: Vec<f32> = (0..steps * pixels)
        .step_by(SAMPLE_STRIDES[1])
        .map(|i| change(i / pixels, i % pixels).abs())
        // Thirds of what moves: in most scenes nearly everything is at rest.
        .filter(|rate| *rate >= REST_PER_S)
        .collect();
    sample.sort_by(f32::total_cmp);
    let at =
        |i: usize| sample.get(upper_index(sample.len(), i, 3)).copied().unwrap_or(f32::INFINITY);
    [at(1), at(2)]
}

/// Smallest Laplacian that counts as fine structure.
const MIN_CURVATURE: f32 = 0.02;

/// Laplacian of log luminance, and the edge of its upper quarter.
struct Curvature<'a> {
    log: &'a [f32],
    width: usize,
    pixels: usize,
    limit: f32,
}

impl<'a> Curvature<'a> {
    fn new(log: &'a [f32], width: usize, pixels: usize, steps: usize) -> Self {
        let mut curvature = Self { log, width, pixels, limit: 0.0 };
        let mut sample: Vec<f32> = (0..steps * pixels)
            .step_by(SAMPLE_STRIDES[2])
            .map(|i| curvature.at(i / pixels, i % pixels))
            .collect();
        sample.sort_by(f32::total_cmp);
        curvature.limit = sample[upper_index(sample.len(), 3, 4)].max(MIN_CURVATURE);
        curvature
    }

    fn at(&self, k: usize, p: usize) -> f32 {
        let (x, y, height) = (p % self.width, p / self.width, self.pixels / self.width);
        let value = |x: usize, y: usize| self.log[k * self.pixels + y * self.width + x];
        let (left, right) = (x.saturating_sub(1), (x + 1).min(self.width - 1));
        let (up, down) = (y.saturating_sub(1), (y + 1).min(height - 1));
        let around = value(left, y) + value(right, y) + value(x, up) + value(x, down);
        (around - 4.0 * value(x, y)).abs()
    }

    fn is_fine(&self, k: usize, p: usize) -> bool {
        self.at(k, p) >= self.limit
    }
}
