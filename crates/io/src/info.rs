//! What a recording is, in a few lines.

use std::fmt;
use std::path::{Path, PathBuf};

use evpose_core::{Micros, SensorSize};

use crate::{IoError, SensorOrigin, open_with};

/// A description of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Info {
    /// The file.
    pub path: PathBuf,
    /// Name of its format.
    pub format: &'static str,
    /// The sensor.
    pub sensor: SensorSize,
    /// How the sensor is known.
    pub sensor_origin: SensorOrigin,
    /// Length of the recording; where the format does not tell, from the first event to the last.
    pub duration: Micros,
    /// Number of events.
    pub events: u64,
    /// Number of ON events.
    pub on_events: u64,
    /// Time of the first event and of the last.
    pub span: Option<(Micros, Micros)>,
    /// Labels that lie beside the file.
    pub labels: Option<Labels>,
    /// What a user should know before trusting the file.
    pub warnings: Vec<String>,
}

/// A file of labels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    /// The file.
    pub path: PathBuf,
    /// Number of records.
    pub records: u64,
    /// Numbers in a record.
    pub values: usize,
}

impl Info {
    /// Events a second, if the recording lasts.
    pub fn rate_hz(&self) -> Option<f64> {
        (self.duration.0 > 0).then(|| self.events as f64 / self.duration.as_seconds())
    }

    /// Share of ON events, if there are events.
    pub fn on_share(&self) -> Option<f64> {
        (self.events > 0).then(|| self.on_events as f64 / self.events as f64)
    }
}

/// Describes a file that is read whole.
pub(crate) fn of_stream(path: &Path, sensor: Option<SensorSize>) -> Result<Info, IoError> {
    let recording = open_with(path, sensor)?;
    let stream = &recording.stream;
    let span = stream.t().first().copied().zip(stream.t().last().copied());
    let mut warnings = Vec::new();
    if recording.sensor_origin == SensorOrigin::Inferred {
        warnings.push(
            "the file does not state its sensor: this is the smallest that holds every event"
                .to_owned(),
        );
    }
    let rejected = recording.rejected;
    if recording.sorted > 0 {
        warnings.push(format!(
            "{} events stood behind later ones: all are put in the order of time",
            recording.sorted
        ));
    }
    for (count, why) in
        [(rejected.outside_sensor, "outside the sensor"), (rejected.out_of_order, "out of order")]
    {
        if count > 0 {
            warnings.push(format!("{count} events {why} are left out"));
        }
    }
    Ok(Info {
        path: path.to_owned(),
        format: recording.format,
        sensor: stream.sensor(),
        sensor_origin: recording.sensor_origin,
        duration: span.map_or(Micros(0), |(first, last)| Micros(last.0.saturating_sub(first.0))),
        events: stream.len() as u64,
        on_events: stream.polarity().iter().filter(|p| p.is_on()).count() as u64,
        span,
        labels: None,
        warnings,
    })
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.path.display())?;
        writeln!(f, "  format    {}", self.format)?;
        let origin = match self.sensor_origin {
            SensorOrigin::Stated => "stated by the file",
            SensorOrigin::Given => "as given",
            SensorOrigin::Assumed => "assumed, the file does not state it",
            SensorOrigin::Inferred => "inferred from the events",
        };
        writeln!(f, "  sensor    {} ({origin})", self.sensor)?;
        writeln!(f, "  duration  {:.6} s", self.duration.as_seconds())?;
        write!(f, "  events    {}", self.events)?;
        if let Some(share) = self.on_share() {
            write!(f, ", {:.1} % ON, {:.1} % OFF", 100.0 * share, 100.0 * (1.0 - share))?;
        }
        writeln!(f)?;
        if let Some(rate_hz) = self.rate_hz() {
            writeln!(f, "  rate      {:.1} thousand events per second", 1e-3 * rate_hz)?;
        }
        if let Some((first, last)) = self.span {
            let (first, last) = (first.as_seconds(), last.as_seconds());
            writeln!(f, "  events at {first:.6} s to {last:.6} s")?;
        }
        if let Some(Labels { path, records, values }) = &self.labels {
            writeln!(f, "  labels    {records} of {values} numbers in {}", path.display())?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning   {warning}")?;
        }
        Ok(())
    }
}
