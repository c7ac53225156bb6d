//! Effects whose parameters the whole recording and both of its halves agree on.

use evpose_core::stats::quantile::median_high;

use super::agreement::{Agreement, effect, exact};
use super::background::Background;
use super::clock::{self, Axis};
use super::findings::SceneFreeEffect;
use super::pixel_counts::Counts;
use super::train::Train;
use super::{interval, line, load};
use crate::goodness::MIN_HOT_HZ;
use crate::goodness::signature::HOT_PIXELS;
use crate::recording_mark::RecordingMark;
use crate::verdict::SignatureTest;

/// Minimum contrast of the spectral line of a lamp.
const MIN_LINE: f64 = 12.0;
/// Minimum regularity of a leak: its shortest intervals relative to those of Poisson events.
const MIN_REGULARITY: f64 = 1.5;
/// Regularity of Poisson noise.
const POISSON: std::ops::Range<f64> = 0.8..1.25;
const MIN_BACKGROUND: usize = 50;
/// Ratio of ON to OFF rates from which on a background is one of ON events.
const ONE_SIDED: f64 = 2.0;
/// Minimum fraction of successive events of opposite polarity in photoreceptor noise.
const MIN_ALTERNATION: f64 = 0.6;

/// A recording with its halves, outlier pixels and backgrounds.
pub(super) struct Parts {
    pub(super) whole: Train,
    halves: [Train; 2],
    /// Pixels that are hot in the whole and in both halves.
    pub(super) hot: Vec<u32>,
    dead: Vec<u32>,
    pub(super) background: Option<Background>,
    half_backgrounds: [Option<Background>; 2],
}

impl Parts {
    pub(super) fn from_train(whole: Train) -> Self {
        let halves = whole.halves();
        let outliers = Counts::from_train(&whole).outliers();
        let counts = halves.each_ref().map(Counts::from_train);
        // A pixel in front of something bright for a while is hot in one half only.
        let stays_hot = |pixel: &u32| {
            counts.iter().all(|counts| {
                let (n, mean) = counts.at(*pixel);
                n >= 3.0 && n >= 2.0 * mean
            })
        };
        // Silence counts only where the neighbours have events in both halves.
        let was_alive = |pixel: &u32| counts.iter().all(|counts| counts.quartile(*pixel) >= 3.0);
        let hot: Vec<u32> = outliers.hot.into_iter().filter(stays_hot).collect();
        let dead = outliers.dead.into_iter().filter(was_alive).collect();
        // A few hot pixels would otherwise set the rates of all.
        let background = Background::estimate(&whole.without(&hot));
        let half_backgrounds =
            halves.each_ref().map(|half| Background::estimate(&half.without(&hot)));
        Self { whole, halves, hot, dead, background, half_backgrounds }
    }

    /// All effects that the parts agree on, and marks that these hide, with the reason.
    pub(super) fn effects(&self) -> (Vec<SceneFreeEffect>, Vec<(RecordingMark, &'static str)>) {
        let (mut agreed, mut masked) = (Vec::new(), Vec::new());
        let scan = self.scan();
        let count = if scan.is_none() { self.count() } else { None };
        let clock_us =
            [&scan, &count].into_iter().flatten().map(|effect| effect.parameters[0].value).next();
        // A clock has spectral lines as well, at multiples of its frequency.
        let is_clock = |frequency_hz: f64| {
            let apart =
                |turns: i32, us: f64| line::alias_hz(f64::from(turns) * 1e6 / us) - frequency_hz;
            clock_us.is_some_and(|us| (1..=20).any(|turns| apart(turns, us).abs() < 3.0))
        };
        let lamp = self.lamp().filter(|lamp| !is_clock(lamp.parameters[0].value));
        match clock_us {
            None => agreed.extend(self.bus()),
            Some(_) => masked.push((RecordingMark::Bus, "the clock sets the gaps between events")),
        }
        match clock_us {
            Some(us) if us >= 100.0 => {
                masked.push((RecordingMark::RateCeiling, "the clock gathers events"));
            }
            _ => agreed.extend(self.ceiling()),
        }
        if lamp.is_some() {
            masked.push((RecordingMark::DeadTime, "the lamp sets the intervals of pixels"));
            masked.push((RecordingMark::Alternation, "events alternate with the lamp"));
        } else {
            // Passes of a scan and ticks of a clock bound intervals from below as well.
            let is_own = |us: f64| clock_us.is_none_or(|clock_us| us > 1.5 * clock_us);
            let refractory = self.refractory().filter(|effect| is_own(effect.parameters[0].value));
            if refractory.is_none() && clock_us.is_some_and(|us| us >= 50.0) {
                masked.push((RecordingMark::DeadTime, "the clock sets the intervals of pixels"));
            }
            agreed.extend(refractory);
        }
        agreed.extend(self.hot_pixels());
        agreed.extend(self.dead_pixels());
        let is_lit = |effect: &SceneFreeEffect| {
            lamp.is_none() || effect.name != RecordingMark::Alternation.effect().name
        };
        agreed.extend(self.background_effect().filter(is_lit));
        agreed.extend([scan, count, lamp].into_iter().flatten());
        (agreed, masked)
    }

    /// A value that the whole and both halves have.
    fn each<T>(&self, find: impl Fn(&Train) -> Option<T>) -> Option<(T, [T; 2])> {
        let [early, late] = &self.halves;
        Some((find(&self.whole)?, [find(early)?, find(late)?]))
    }

    fn scan(&self) -> Option<SceneFreeEffect> {
        let (whole, halves) = self.each(clock::scan)?;
        let same =
            |half: &clock::Scan| (half.axis, half.is_backward) == (whole.axis, whole.is_backward);
        if !halves.iter().all(same) {
            return None;
        }
        // Frequencies are known to a turn in the whole recording: halves of one clock agree
        // closely.
        let period = Agreement { tolerance: 0.01, resolution: 0.01 };
        let halves = halves.map(|scan| scan.period_us);
        let period = period.parameter("period_us", "us", whole.period_us, halves)?;
        let variant = match (whole.axis, whole.is_backward) {
            (Axis::Rows, false) => "rows, forward",
            (Axis::Rows, true) => "rows, backward",
            (_, false) => "columns, forward",
            (_, true) => "columns, backward",
        };
        let scan = effect(RecordingMark::Scan, vec![period]);
        Some(SceneFreeEffect { variant: Some(variant), ..scan })
    }

    fn count(&self) -> Option<SceneFreeEffect> {
        let (whole, halves) = self.each(clock::count_us)?;
        let agreement = Agreement { tolerance: 0.01, resolution: 0.01 };
        let period = agreement.parameter("period_us", "us", whole, halves)?;
        Some(effect(RecordingMark::TimeGrid, vec![period]))
    }

    fn lamp(&self) -> Option<SceneFreeEffect> {
        let clear = |train: &Train| {
            let line = line::strongest(train)?;
            // Lines beside the harmonics of one are a periodic motion, not a lamp.
            (line.contrast >= MIN_LINE && line.is_alone).then_some(line.frequency_hz)
        };
        let (whole, halves) = self.each(clear)?;
        let resolution = 1.0 / self.whole.seconds();
        let agreement = Agreement { tolerance: 0.01, resolution };
        let frequency = agreement.parameter("frequency_hz", "Hz", whole, halves)?;
        Some(effect(RecordingMark::Lamp, vec![frequency]))
    }

    fn bus(&self) -> Option<SceneFreeEffect> {
        let (whole, halves) = self.each(load::bus_rate_hz)?;
        let agreement = Agreement { tolerance: 0.1, resolution: 0.0 };
        let rate = agreement.parameter("rate_hz", "Hz", whole, halves)?;
        Some(effect(RecordingMark::Bus, vec![rate]))
    }

    fn ceiling(&self) -> Option<SceneFreeEffect> {
        let (whole, halves) = self.each(load::ceiling_hz)?;
        let agreement = Agreement { tolerance: 0.05, resolution: 0.0 };
        let rate = agreement.parameter("rate_hz", "Hz", whole, halves)?;
        Some(effect(RecordingMark::RateCeiling, vec![rate]))
    }

    fn refractory(&self) -> Option<SceneFreeEffect> {
        let (whole, halves) = self.each(interval::refractory_us)?;
        let agreement = Agreement { tolerance: 0.1, resolution: 1.0 };
        let period = agreement.parameter("period_us", "us", whole, halves)?;
        Some(effect(RecordingMark::DeadTime, vec![period]))
    }

    fn hot_pixels(&self) -> Option<SceneFreeEffect> {
        if self.hot.is_empty() {
            return None;
        }
        // What stands out a little among pixels without events is not hot: those that are decide.
        let is_hot = |pixel: &u32| hot_rates(&self.whole, &[*pixel]).0 >= MIN_HOT_HZ;
        let fast: Vec<u32> = self.hot.iter().copied().filter(is_hot).collect();
        let hot = if fast.is_empty() { self.hot.clone() } else { fast };
        let fraction = hot.len() as f64 / self.whole.size.pixels() as f64;
        let known = |train: &Train| hot_rates(train, &hot);
        let (whole, [early, late]) = self.each(|train| Some(known(train)))?;
        let agreement = Agreement { tolerance: 0.5, resolution: 0.0 };
        let share = Agreement { tolerance: 0.5, resolution: 0.2 };
        let mut on_share = share.parameter("on_share", "", whole.1, [early.1, late.1])?;
        // The tolerance is relative and may lead beyond a whole.
        on_share.hi90 = on_share.hi90.min(1.0);
        let parameters = vec![
            exact("fraction", "", fraction),
            agreement.parameter("median_hz", "Hz", whole.0, [early.0, late.0])?,
            on_share,
        ];
        let effect = effect(RecordingMark::HotPixels, parameters).with_pixels(&self.whole, &hot);
        Some(SceneFreeEffect { test: Some(heat_test(whole.0)), ..effect })
    }

    fn dead_pixels(&self) -> Option<SceneFreeEffect> {
        if self.dead.is_empty() {
            return None;
        }
        let fraction = self.dead.len() as f64 / self.whole.size.pixels() as f64;
        let fraction = exact("fraction", "", fraction);
        Some(
            effect(RecordingMark::SilentPixels, vec![fraction])
                .with_pixels(&self.whole, &self.dead),
        )
    }

    fn background_effect(&self) -> Option<SceneFreeEffect> {
        let [early, late] = &self.half_backgrounds;
        let (whole, halves) = (self.background.as_ref()?, [early.as_ref()?, late.as_ref()?]);
        if whole.len() < MIN_BACKGROUND {
            return None;
        }
        // In this order: noise that alternates looks regular as well, and regular events are no
        // Poisson noise.
        let rates = Agreement { tolerance: 0.3, resolution: 0.01 };
        let (on_hz, off_hz) = whole.rates_hz();
        let half_rates = halves.map(Background::rates_hz);
        let alternates =
            |part: &Background| part.alternation().is_some_and(|part| part >= MIN_ALTERNATION);
        if alternates(whole) && halves.iter().all(|half| alternates(half)) {
            let agreement = Agreement { tolerance: 0.5, resolution: 1.0 };
            let halves = [halves[0].return_us()?, halves[1].return_us()?];
            let back = agreement.parameter("return_us", "us", whole.return_us()?, halves)?;
            return Some(effect(RecordingMark::Alternation, vec![back]));
        }
        let is_regular = |part: &Background| {
            part.regularity(true).is_some_and(|regularity| regularity >= MIN_REGULARITY)
        };
        if is_regular(whole) && on_hz >= ONE_SIDED * off_hz {
            if !halves.iter().all(|half| is_regular(half)) {
                return None;
            }
            let leaks = [halves[0].leak()?, halves[1].leak()?];
            let (rate_hz, jitter) = whole.leak()?;
            let rate = rates.parameter("rate_hz", "Hz", rate_hz, leaks.map(|leak| leak.0))?;
            let mut parameters = vec![rate];
            if let (Some(jitter), [Some(early), Some(late)]) = (jitter, leaks.map(|leak| leak.1)) {
                let agreement = Agreement { tolerance: 0.5, resolution: 0.02 };
                parameters.extend(agreement.parameter("jitter", "", jitter, [early, late]));
            }
            return Some(effect(RecordingMark::RegularOn, parameters));
        }
        let is_poisson = |is_on: bool| {
            whole.regularity(is_on).is_none_or(|regularity| POISSON.contains(&regularity))
        };
        let known = whole.regularity(true).or(whole.regularity(false));
        if known.is_none() || !is_poisson(true) || !is_poisson(false) {
            return None;
        }
        let parameters = vec![
            rates.parameter("on_hz", "Hz", on_hz, half_rates.map(|rates| rates.0))?,
            rates.parameter("off_hz", "Hz", off_hz, half_rates.map(|rates| rates.1))?,
        ];
        Some(effect(RecordingMark::RandomRest, parameters))
    }
}

/// Whether pixels of this median rate are hot.
fn heat_test(median_hz: f64) -> SignatureTest {
    SignatureTest {
        passes: median_hz >= MIN_HOT_HZ,
        p: if median_hz >= MIN_HOT_HZ { 0.0 } else { 1.0 },
        must: HOT_PIXELS.must.to_owned(),
        shows: format!("pixels that stand out have {median_hz:.2} Hz in the median"),
        recording: HOT_PIXELS.recording.to_owned(),
    }
}

/// Median rate of some pixels, and the fraction of their events that are ON.
fn hot_rates(train: &Train, pixels: &[u32]) -> (f64, f64) {
    let (mut counts, mut on) = (vec![0.0; pixels.len()], 0.0);
    for mark in &train.marks {
        if let Ok(i) = pixels.binary_search(&mark.pixel) {
            counts[i] += 1.0;
            on += f64::from(u8::from(mark.is_on));
        }
    }
    let all: f64 = counts.iter().sum();
    let median = median_high(&mut counts).unwrap_or(0.0);
    (median / train.seconds(), on / all.max(1.0))
}
