//! A sensor to simulate with, from what is known of a camera, and the rows of its table.

use evpose_core::stats::interval::Interval;
use evpose_core::stats::quantile::median_high;
use evpose_sensor::{EffectConfig, SensorConfig};

use super::{CameraReport, Quantity};

/// Geometric mean of both thresholds, which events alone do not show, and offset of the logarithm: as in the preset
/// `ideal`.
const ASSUMED_THRESHOLD: f64 = 0.2;
const DARK_OFFSET: f64 = 1e-3;

impl Quantity {
    /// Known values with their recordings: the one of the camera, or one of each recording.
    pub fn known(&self) -> Vec<(Interval, String)> {
        let of_each =
            self.readings.iter().filter_map(|one| Some((one.value?, one.recording.clone())));
        let names = || of_each.clone().map(|(_, name)| name).collect::<Vec<_>>().join(", ");
        match (self.value, &self.why) {
            (Some(value), _) => vec![(value, names())],
            (None, Some(_)) => Vec::new(),
            (None, None) => of_each.collect(),
        }
    }

    /// Variant of a known value, as words; none of most quantities.
    fn variant(&self) -> Option<&'static str> {
        self.readings.iter().find_map(|one| one.variant)
    }
}

impl CameraReport {
    /// A sensor with the values that are known, of the recording in the middle where each has one; what is not known is
    /// ideal.
    pub fn sensor(&self) -> SensorConfig {
        let get = |name: &str| {
            let known = self.quantity(name)?.known();
            median_high(&mut known.iter().map(|(value, _)| value.estimate).collect::<Vec<_>>())
        };
        let effect = |name: &str, key: &str, value: f64| EffectConfig::new(name).with(key, value);
        let root = get("threshold_ratio").unwrap_or(1.0).sqrt();
        let mut effects = vec![
            effect("logarithmic", "dark_offset", DARK_OFFSET),
            effect("level_crossing", "threshold_on", ASSUMED_THRESHOLD * root)
                .with("threshold_off", ASSUMED_THRESHOLD / root),
        ];
        effects.extend(get("leak_hz").map(|hz| effect("leak_on", "rate_hz", hz)));
        effects.extend(get("refractory_us").map(|us| effect("refractory", "period_us", us)));
        if let (Some(fraction), Some(hz)) = (get("hot_fraction"), get("hot_hz")) {
            let hot = effect("hot_pixels", "fraction", fraction.clamp(1e-6, 0.5));
            let share = get("hot_on_share").unwrap_or(0.5).min(1.0);
            effects.push(hot.with("median_hz", hz.clamp(0.1, 1e4)).with("on_share", share));
        }
        if let (Some(on), Some(off)) = (get("background_on_hz"), get("background_off_hz")) {
            // What is left of ON events beside a leak is noise, as many as OFF events.
            let on = if get("leak_hz").is_some() { off } else { on };
            effects.push(effect("uniform_noise", "on_hz", on).with("off_hz", off));
        }
        let variant = self.quantity("scan_period_us").and_then(Quantity::variant);
        let variant = variant.and_then(|words| words.split_once(", "));
        effects.push(match get("scan_period_us").zip(variant) {
            Some((us, (axis, direction))) => {
                let scan = effect("scanned_readout", "period_us", us);
                scan.with("axis", axis).with("direction", direction)
            }
            None => EffectConfig::new("ideal_readout"),
        });
        let clock = get("clock_period_us");
        effects.extend(clock.map(|us| effect("timestamp_quantisation", "period_us", us)));
        SensorConfig { effects }
    }

    /// The sensor as TOML; comments say where values are from.
    pub fn preset(&self) -> String {
        let rows: String = self.rows().iter().map(|row| format!("# {}\n", row.join(" "))).collect();
        let assumed = "# assumed: a geometric mean of both thresholds of 0.2, and dark_offset";
        format!(
            "# A camera by `evpose gap camera`.\n{rows}{assumed}\n\n{}",
            self.sensor().to_toml()
        )
    }

    /// The table: state, name, value or reason, and its recordings or those that would show it.
    pub fn rows(&self) -> Vec<[String; 4]> {
        let mut rows = Vec::new();
        for quantity in &self.quantities {
            for (value, from) in quantity.known() {
                let state = if quantity.is_of_camera { "known" } else { "light" };
                let [low, high] = [value.low, value.high].map(|end| short(end.unwrap_or_default()));
                let text = format!("{} [{low}, {high}] ", short(value.estimate));
                let text = (text + quantity.variant().unwrap_or_default()).trim_end().to_owned();
                let (state, name) = (state.to_owned(), quantity.name.to_owned());
                rows.push([state, name, text, format!("from {from}")]);
            }
            if let Some(why) = quantity.why.clone() {
                let shows = format!("would show: {}", quantity.would_show);
                rows.push(["unknown".to_owned(), quantity.name.to_owned(), why, shows]);
            }
        }
        rows
    }
}

/// A value with four digits.
fn short(value: f64) -> String {
    let decimals = (3 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.decimals$}")
}
