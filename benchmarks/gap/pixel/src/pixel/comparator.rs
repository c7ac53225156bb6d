//! Change amplifier and comparators of one pixel: memory, thresholds, leak and reset.
//!
//! Everything is referred to the amplifier's input in e-folds of light: volts at its output divided
//! by `(C1 / C2) U_T / kappa`. The memory is the level the amplifier was last balanced at; an ON
//! event comes when the input is one ON threshold above it, an OFF event when one OFF threshold
//! below.

use crate::circuit::{CellCounter, Circuit, DetectorOddity, Junction, NoiseAddress, Timer};
use crate::draw::{Purpose, Stream};
use crate::event::WIDTH;
use crate::physics::{FEMTO, REFERENCE_TEMPERATURE_K};

/// A noisy threshold never falls below this share of its mean.
const SMALLEST_SHARE: f64 = 0.05;

#[derive(Debug, Clone)]
pub(crate) struct Comparators {
    base_on: f64,
    base_off: f64,
    noise: f64,
    noise_on: Stream,
    noise_off: Stream,
    dark_offsets: Option<[f64; 2]>,
    extra: f64,
    injected: f64,
    unsettled: f64,
    leak_per_s: f64,
    hold_on_s: f64,
    hold_off_s: f64,
    memory: f64,
    since_s: f64,
    on: f64,
    off: f64,
    fired: u64,
    cells: Option<CellCounter>,
    last: Option<bool>,
    /// End of the reset, if the pixel is in reset.
    release_s: Option<f64>,
}

impl Comparators {
    pub(crate) fn new(circuit: &Circuit, camera_seed: u64, run_seed: u64, pixel: u32) -> Self {
        let detector = &circuit.detector;
        let efold_v = circuit.output_volts_per_efold_v();
        let draw = |seed, purpose| Stream::new(seed, purpose, u64::from(pixel));
        let xi_on = draw(camera_seed, Purpose::OffsetOn).normal(0);
        let xi_off = draw(camera_seed, Purpose::OffsetOff).normal(0);
        let mut smooth = 0.0;
        let mut dark_offsets = None;
        let mut extra = 0.0;
        let mut injected = 0.0;
        // One timer serves both polarities, unless the oddity is a timer of ON events alone.
        let timer_s = detector.refractory.map_or(0.0, |timer| timer.seconds());
        let (mut hold_on_s, mut hold_off_s) = (timer_s, timer_s);
        match detector.oddity {
            Some(DetectorOddity::OneSidedTimer(timer)) => {
                hold_on_s = timer.seconds();
                hold_off_s = 0.0;
            }
            Some(DetectorOddity::SmoothOffsets { sigma_ln, length_px }) => {
                smooth = sigma_ln * smooth_field(camera_seed, length_px, pixel);
            }
            Some(DetectorOddity::DarkOffsets { sigma_ln }) => {
                dark_offsets = Some([sigma_ln * xi_on, sigma_ln * xi_off]);
            }
            Some(DetectorOddity::Hysteresis { extra_mv }) => extra = extra_mv * 1e-3 / efold_v,
            Some(DetectorOddity::ChargeInjection { charge_ac }) => {
                injected = charge_ac * 1e-18 / (detector.feedback_ff * FEMTO) / efold_v;
            }
            None => {}
        }
        // Log-normal, so that no threshold is negative.
        let spread = |xi: f64| (detector.offset_sigma_ln * xi + smooth).exp();
        let leak_per_s = detector.leak.map_or(0.0, |junction| {
            let xi = draw(camera_seed, Purpose::Leakage).normal(0);
            let amperes = junction.amperes(circuit.temperature_k) * (junction.spread_ln * xi).exp();
            amperes / (detector.feedback_ff * FEMTO) / efold_v
        });
        Self {
            base_on: detector.threshold_on_mv * 1e-3 / efold_v * spread(xi_on),
            base_off: detector.threshold_off_mv * 1e-3 / efold_v * spread(xi_off),
            noise: detector.comparator_noise_mv * 1e-3 / efold_v,
            // Noise differs from run to run, offsets are the camera's.
            noise_on: draw(run_seed, Purpose::ComparatorOn),
            noise_off: draw(run_seed, Purpose::ComparatorOff),
            dark_offsets,
            extra,
            injected,
            unsettled: detector.unsettled_share,
            leak_per_s,
            hold_on_s,
            hold_off_s,
            memory: 0.0,
            since_s: 0.0,
            on: 0.0,
            off: 0.0,
            fired: 0,
            cells: (circuit.noise_address == NoiseAddress::Time).then(CellCounter::default),
            last: None,
            release_s: None,
        }
    }

    /// Balances the amplifier at `level`.
    pub(crate) fn balance(&mut self, level: f64, t_s: f64) {
        // The first balance is no reset and injects no charge.
        self.memory = level - self.injected * f64::from(u8::from(self.last.is_some()));
        self.since_s = t_s;
        self.release_s = None;
        let mut thresholds = [self.base_on, self.base_off];
        if let Some(offsets) = self.dark_offsets {
            // Offsets count fully in darkness and fade as light grows beyond a tenth of white.
            let darkness = (0.1 / (level.exp() + 0.1)).sqrt();
            thresholds[0] *= (offsets[0] * darkness).exp();
            thresholds[1] *= (offsets[1] * darkness).exp();
        }
        match self.last {
            Some(true) => thresholds[1] += self.extra,
            Some(false) => thresholds[0] += self.extra,
            None => {}
        }
        if self.noise > 0.0 {
            // Drawn anew for each event: by its number, or by the cell of time that it falls in.
            let index = self.cells.as_mut().map_or(self.fired, |cells| cells.index(t_s));
            let noisy = |mean: f64, stream: Stream| {
                // Not near zero, where a pixel would fire without an end.
                (mean + self.noise * stream.normal(index)).max(SMALLEST_SHARE * mean)
            };
            thresholds =
                [noisy(thresholds[0], self.noise_on), noisy(thresholds[1], self.noise_off)];
        }
        [self.on, self.off] = thresholds;
    }

    /// End of the reset, if the pixel is in reset.
    pub(crate) fn release_s(&self) -> Option<f64> {
        self.release_s
    }

    /// Distances below the ON threshold and above the OFF threshold; an event comes at 0.
    #[inline]
    pub(crate) fn distances(&self, input: f64, t_s: f64) -> [f64; 2] {
        let change = input - self.memory + self.leak_per_s * (t_s - self.since_s);
        [self.on - change, self.off + change]
    }

    /// The event that `input` causes at `t_s`, if any.
    pub(crate) fn crossing(&self, input: f64, t_s: f64) -> Option<bool> {
        let [below, above] = self.distances(input, t_s);
        if below <= 0.0 {
            Some(true)
        } else if above <= 0.0 {
            Some(false)
        } else {
            None
        }
    }

    /// An event of the comparators: the memory moves by one threshold, or the reset begins.
    pub(crate) fn fire(&mut self, on: bool, t_s: f64) {
        let moved = if on { self.on } else { -self.off };
        let level = self.memory - self.leak_per_s * (t_s - self.since_s) + moved;
        self.reset(on, level, t_s);
    }

    pub(crate) fn reset(&mut self, on: bool, level: f64, t_s: f64) {
        self.fired += 1;
        self.last = Some(on);
        let hold_s = if on { self.hold_on_s } else { self.hold_off_s };
        let before = self.memory - self.leak_per_s * (t_s - self.since_s);
        let level =
            if self.unsettled == 0.0 { level } else { level - self.unsettled * (level - before) };
        self.balance(level, t_s);
        if hold_s > 0.0 {
            self.release_s = Some(t_s + hold_s);
        }
    }
}

impl Timer {
    /// Time in reset: `C dV / I`.
    pub fn seconds(&self) -> f64 {
        self.capacitance_ff * FEMTO * self.swing_v / (self.current_pa * 1e-12)
    }
}

impl Junction {
    /// Median current over the pixels at a temperature, A.
    pub fn amperes(&self, temperature_k: f64) -> f64 {
        let doublings = (temperature_k - REFERENCE_TEMPERATURE_K) / self.doubling_k;
        self.current_fa * FEMTO * doublings.exp2()
    }
}

/// A smooth random field with variance 1 and correlation `exp(-d^2 / (2 length^2))`: waves with
/// normal wave vectors and random phases.
fn smooth_field(camera_seed: u64, length_px: f64, pixel: u32) -> f64 {
    const WAVES: u64 = 64;
    let stream = Stream::new(camera_seed, Purpose::OffsetOn, u64::MAX);
    let (x, y) = ((pixel as usize % WIDTH) as f64, (pixel as usize / WIDTH) as f64);
    let sum: f64 = (0..WAVES)
        .map(|i| {
            let phase = std::f64::consts::TAU * stream.uniform(3 * i);
            let (kx, ky) = (stream.normal(3 * i + 1), stream.normal(3 * i + 2));
            ((kx * x + ky * y) / length_px + phase).cos()
        })
        .sum();
    // A cosine of random phase has a variance of one half.
    sum * (2.0 / WAVES as f64).sqrt()
}
