//! Size of the sensor of a recording, before its events are read.

use std::path::Path;

use evpose_core::SensorSize;

use super::SensorOrigin;
use super::extent::Extent;
use super::outside::OutsideCount;
use super::whole::{read_past, sensor_of};
use crate::{IoError, OpenOptions};

/// The size of the sensor of a recording and its origin. A file that does not state it is read
/// once, without holding it.
///
/// # Errors
/// As [`crate::open`]; if `options` give another size than the file states, or one outside which more
/// than a tenth of the events are, unless it is salvaged.
pub fn find_sensor(
    path: impl AsRef<Path>,
    options: &OpenOptions,
) -> Result<(SensorSize, SensorOrigin), IoError> {
    let input = super::input(path.as_ref())?;
    let path = input.path.clone();
    let (_, mut source) = super::source(input, options)?;
    // Most files state it: the events need not be read then.
    if let Some(stated) = source.header().sensor {
        return match options.sensor.filter(|given| *given != stated) {
            None => Ok((stated, SensorOrigin::Stated)),
            Some(given) => Err(IoError::OtherSensor { path, given, stated }),
        };
    }
    let (mut extent, mut outside) = (Extent::default(), OutsideCount::default());
    read_past(source.as_mut(), options, |columns| {
        extent.add(columns);
        if let Some(given) = options.sensor {
            outside.add(columns, 0, given);
        }
    })?;
    if let Some(given) = options.sensor
        && !options.salvage
        && outside.is_more_than_a_tenth()
    {
        return Err(IoError::SmallerSensor { path, given, extent: extent.size() });
    }
    sensor_of(&path, source.header(), options, || extent.size())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_event_counts_and_sizes_that_cannot_be_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rec.txt");
        let mut text: String =
            (0..100_000).map(|k| format!("{:.6} 3 4 1\n", 1e-6 * f64::from(k))).collect();
        text += &"1.0 99 49 0\n".repeat(20_000);
        std::fs::write(&path, text).unwrap();
        let size = |width, height| SensorSize { width, height };
        let found = |sensor, salvage| {
            find_sensor(&path, &OpenOptions { sensor, salvage, ..OpenOptions::default() })
        };
        assert_eq!(found(None, false).unwrap(), (size(100, 50), SensorOrigin::Inferred));
        let given = Some(size(128, 64));
        assert_eq!(found(given, false).unwrap(), (size(128, 64), SensorOrigin::Given));
        let small = Some(size(60, 45));
        let error = found(small, false).unwrap_err().to_string();
        assert!(error.contains("60x45") && error.contains("100x50"), "{error}");
        assert_eq!(found(small, true).unwrap(), (size(60, 45), SensorOrigin::Given));
    }
}
