//! Movements that others have cut out of movies with the published programs, as MAT-files.

use std::path::Path;

use evpose_containers::mat::{MatError, MatValue};
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
        let columns = Columns::read(dvs).map_err(&mat)?;
        if !columns.are_as_long() {
            let reason = "x, y, ts and pol are not of the same length";
            return Err(DatasetError::malformed(path, dvs.path(), reason));
        }
        let (stream, rejected) = columns.stream(number, window.start);
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

/// Events of a camera as the file has them.
struct Columns {
    x: Vec<i64>,
    y: Vec<i64>,
    t: Vec<i64>,
    polarity: Vec<i64>,
}

impl Columns {
    fn read(dvs: MatValue<'_>) -> Result<Self, MatError> {
        let column = |name| dvs.field(name)?.integers();
        Ok(Self { x: column("x")?, y: column("y")?, t: column("ts")?, polarity: column("pol")? })
    }

    fn are_as_long(&self) -> bool {
        [&self.y, &self.t, &self.polarity].iter().all(|column| column.len() == self.x.len())
    }

    /// The events, their times from `start` on, and how many could not be taken.
    fn stream(&self, camera: usize, start: Micros) -> (EventStream, usize) {
        let mut builder = EventStreamBuilder::new(SENSOR);
        let first = 1 + i64::from(SENSOR.width) * camera as i64;
        // What no sensor reaches is rejected by the builder.
        let pixel = |value: i64| u16::try_from(value).unwrap_or(u16::MAX);
        for (i, &x) in self.x.iter().enumerate() {
            builder.push(Event {
                t: Micros(self.t[i].saturating_sub(start.0)),
                x: pixel(x.saturating_sub(first)),
                y: pixel(self.y[i].saturating_sub(1)),
                polarity: Polarity::from_on(self.polarity[i] != 0),
            });
        }
        let (stream, rejected) = builder.finish();
        (stream, rejected.total())
    }
}
