//! Movements that others have cut out of movies with the published programs, as MAT-files.

use std::path::Path;

use evpose_core::{Event, EventStream, EventStreamBuilder, Micros, Polarity, TimeWindow};

use super::{CAMERAS, Movement, SENSOR, Span, SpanOrigin};
use crate::DatasetError;
use crate::open::open_mat;

/// Reads a movement that was cut and filtered by hpe-core's `preprocess.m`: a structure `out` with
/// `data.cam0.dvs.x` and so on, `extra.startTime` and `extra.stopTime`.
///
/// Columns count all cameras from 1 on there, rows from 1 on; times are of the clock of the
/// cameras.
///
/// # Errors
/// If the file cannot be read or holds something else.
pub fn read_extracted(path: &Path) -> Result<Movement, DatasetError> {
    let file = open_mat(path)?;
    let mat = DatasetError::mat(path);
    let (window, cameras) = (|| {
        let out = file.variable("out")?;
        let extra = out.field("extra")?;
        let time = |name| Ok(Micros(extra.field(name)?.integer()?));
        let window = TimeWindow { start: time("startTime")?, end: time("stopTime")? };
        let data = out.field("data")?;
        let camera = |number: usize| data.field(&format!("cam{number}"))?.field("dvs");
        Ok((window, [camera(0)?, camera(1)?, camera(2)?, camera(3)?]))
    })()
    .map_err(&mat)?;
    let mut remarks = Vec::new();
    let mut streams = [(); CAMERAS].map(|()| EventStream::empty(SENSOR));
    for (number, dvs) in cameras.into_iter().enumerate() {
        let column = |name| dvs.field(name).and_then(|column| column.integers()).map_err(&mat);
        let (x, y, t, polarity) = (column("x")?, column("y")?, column("ts")?, column("pol")?);
        if [&y, &t, &polarity].iter().any(|column| column.len() != x.len()) {
            let reason = "x, y, ts and pol are not of the same length";
            return Err(DatasetError::malformed(path, dvs.path(), reason));
        }
        let mut builder = EventStreamBuilder::new(SENSOR);
        let first = 1 + i64::from(SENSOR.width) * number as i64;
        // What no sensor reaches is rejected by the builder.
        let pixel = |value: i64| u16::try_from(value).unwrap_or(u16::MAX);
        for (i, &x) in x.iter().enumerate() {
            builder.push(Event {
                t: Micros(t[i].saturating_sub(window.start.0)),
                x: pixel(x.saturating_sub(first)),
                y: pixel(y[i].saturating_sub(1)),
                polarity: Polarity::from_on(polarity[i] != 0),
            });
        }
        let (stream, rejected) = builder.finish();
        let rejected = rejected.total();
        if rejected > 0 {
            remarks.push(format!(
                "camera {number}: {rejected} events are outside the sensor or out of order and left out"
            ));
        }
        streams[number] = stream;
    }
    let span = Span { window, origin: SpanOrigin::Stated };
    Ok(Movement { cameras: streams, span, removed: None, remarks })
}
