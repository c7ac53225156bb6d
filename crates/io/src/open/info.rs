//! Description of a recording in a few lines.

use std::fmt;
use std::path::{Path, PathBuf};

use evpose_core::{Micros, SensorSize};

use super::extent::Extent;
use super::outside::OutsideCount;
use super::whole::{read_past, sensor_of};
use super::{Labels, SensorOrigin};
use crate::{Columns, IoError, OpenOptions};

/// A description of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Info {
    /// Path of the recording.
    pub path: PathBuf,
    /// Name of its format.
    pub format: &'static str,
    /// Facts of the header beside the sensor: name and value.
    pub facts: Vec<(&'static str, String)>,
    /// The sensor.
    pub sensor: SensorSize,
    /// Origin of the size of the sensor.
    pub sensor_origin: SensorOrigin,
    /// Length of the recording; if the format does not state it, from the first event to the last.
    pub duration: Micros,
    /// Count of events.
    pub events: u64,
    /// Count of ON events.
    pub on_events: u64,
    /// Times of the earliest event and of the latest.
    pub span: Option<(Micros, Micros)>,
    /// Labels that lie beside the file.
    pub labels: Option<Labels>,
    /// Warnings about the file.
    pub warnings: Vec<String>,
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

/// Describes a recording of any format, without holding it.
///
/// # Errors
/// As [`crate::open`].
pub fn info(path: impl AsRef<Path>, options: &OpenOptions) -> Result<Info, IoError> {
    let input = super::input(path.as_ref())?;
    let path = input.path.clone();
    let (format, mut source) = super::source(input, options)?;
    let sensor = source.header().sensor.or(options.sensor);
    let mut survey = Survey { sensor, ..Survey::default() };
    let lost = read_past(source.as_mut(), options, |columns| survey.add(columns))?;
    // The extent of the events is known only now.
    let (sensor, sensor_origin) =
        sensor_of(&path, source.header(), options, || survey.extent.size())?;
    let mut warnings = source.remarks();
    warnings.extend(lost.map(|damage| format!("the rest is lost: {damage}")));
    warnings.extend(sensor_warning(
        sensor_origin,
        survey.extent.size(),
        source.header().usual_sensor,
    ));
    survey.outside.check(&path, sensor, true)?;
    let outside = survey.outside.outside();
    if outside > 0 {
        warnings.push(format!("{outside} events lie outside the sensor: they are left out"));
    }
    let labels = (format.labels)(&path, source.as_ref(), &mut warnings);
    let span = survey.first.map(|first| (first, survey.latest));
    let lasts = span.map_or(Micros(0), |(first, last)| Micros(last.0.saturating_sub(first.0)));
    Ok(Info {
        path,
        format: format.name,
        facts: source.header().facts.clone(),
        sensor,
        sensor_origin,
        duration: source.duration().unwrap_or(lasts),
        events: survey.events,
        on_events: survey.on,
        span,
        labels,
        warnings,
    })
}

fn sensor_warning(
    origin: SensorOrigin,
    extent: SensorSize,
    usual: Option<SensorSize>,
) -> Option<String> {
    match (origin, usual) {
        (SensorOrigin::Inferred, Some(usual)) => Some(format!(
            "events lie outside {usual}: the sensor is taken to be the smallest that holds them"
        )),
        (SensorOrigin::Inferred, None) => Some(
            "the file does not state its sensor: this is the smallest that holds every event"
                .to_owned(),
        ),
        // Half of the columns without any event are unlikely on the sensor that is assumed.
        (SensorOrigin::Assumed, Some(usual)) if 2 * extent.width <= usual.width => Some(format!(
            "events fill no more than {extent}: the sensor may be smaller than assumed"
        )),
        _ => None,
    }
}

/// Statistics over all events.
#[derive(Debug, Default)]
struct Survey {
    /// The sensor, where it is known beforehand.
    sensor: Option<SensorSize>,
    events: u64,
    on: u64,
    latest: Micros,
    first: Option<Micros>,
    outside: OutsideCount,
    extent: Extent,
}

impl Survey {
    fn add(&mut self, columns: &Columns) {
        self.events += columns.len() as u64;
        self.on += columns.polarity.iter().filter(|p| p.is_on()).count() as u64;
        self.first = self.first.or(columns.t.first().copied());
        self.latest = columns.t.last().copied().unwrap_or(self.latest);
        self.extent.add(columns);
        // A coordinate that no sensor has is outside an unknown one, too.
        let sensor = self.sensor.unwrap_or(SensorSize { width: u16::MAX, height: u16::MAX });
        self.outside.add(columns, 0, sensor);
    }
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.path.display())?;
        writeln!(f, "  format    {}", self.format)?;
        for (name, value) in &self.facts {
            writeln!(f, "  {name:9} {value}")?;
        }
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
            writeln!(f, "  labels    {records} of {values} values in {}", path.display())?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning   {warning}")?;
        }
        Ok(())
    }
}
