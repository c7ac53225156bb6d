//! Typed content of packets, to and from their bytes.

use evpose_core::Micros;

use super::build::{Builder, Field};
use super::events;
use super::flat::{Broken, Table, identifier};
use super::header::StreamKind;
use crate::Columns;

/// A packet of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Aedat4Packet {
    /// The stream it belongs to.
    pub stream: i32,
    /// Typed content.
    pub content: Content,
}

/// Content of a packet.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Events.
    Events(Columns),
    /// One frame.
    Frame(Frame),
    /// Samples of an inertial unit.
    Imu(Vec<ImuSample>),
    /// Triggers.
    Triggers(Vec<Trigger>),
    /// A FlatBuffer of another kind, behind its size.
    Other([u8; 4], Vec<u8>),
}

/// A frame of a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Its time: DV gives the middle of the exposure, dv-processing and frames that were computed
    /// the beginning.
    pub t: Micros,
    /// Begin of its readout, where the file states it, else 0.
    pub readout_start: Micros,
    /// End of its readout, where the file states it, else 0.
    pub readout_end: Micros,
    /// When its exposure began.
    pub exposure_start: Micros,
    /// When its exposure ended.
    pub exposure_end: Micros,
    /// Format of a pixel.
    pub format: PixelFormat,
    /// Columns.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// Position of its upper left corner on the sensor, column and row.
    pub position: (i16, i16),
    /// Source: 0 unknown, 1 the sensor, 2 and more computed.
    pub origin: i8,
    /// Row by row; channels of a pixel side by side; samples of several bytes little-endian.
    pub pixels: Vec<u8>,
}

/// Format of the pixels of a frame. Three channels are blue, green, red; four have opacity behind
/// them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelFormat {
    /// Type of a sample.
    pub depth: Depth,
    /// Samples of a pixel, 1 to 4.
    pub channels: u8,
}

/// Type of a sample of a pixel, in OpenCV's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits without sign.
    U8,
    /// 8 bits with sign.
    I8,
    /// 16 bits without sign.
    U16,
    /// 16 bits with sign.
    I16,
    /// 32 bits with sign.
    I32,
    /// 32 bits, floating.
    F32,
    /// 64 bits, floating.
    F64,
}

impl Depth {
    /// All variants, in the order of their codes.
    pub const ALL: [Self; 7] =
        [Self::U8, Self::I8, Self::U16, Self::I16, Self::I32, Self::F32, Self::F64];

    /// Bytes of a sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl PixelFormat {
    /// One channel of 8 bits, what DAVIS cameras give.
    pub const GREY: Self = Self { depth: Depth::U8, channels: 1 };

    /// Bytes of a pixel.
    pub fn bytes(self) -> usize {
        self.depth.bytes() * usize::from(self.channels)
    }

    /// OpenCV's number: depth in the low three bits, channels less one above.
    fn from_code(code: i8) -> Option<Self> {
        let code = u8::try_from(code).ok()?;
        let depth = *Depth::ALL.get(usize::from(code & 7))?;
        let channels = (code >> 3) + 1;
        (channels <= 4).then_some(Self { depth, channels })
    }

    fn code(self) -> Option<i8> {
        let depth = Depth::ALL.iter().position(|&depth| depth == self.depth)? as u8;
        (1..=4).contains(&self.channels).then(|| (depth | (self.channels - 1) << 3) as i8)
    }
}

/// A sample of an inertial unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImuSample {
    /// When.
    pub t: Micros,
    /// Temperature in degrees Celsius.
    pub temperature_c: f32,
    /// Acceleration along x, y and z, in multiples of 9.81 m/s².
    pub acceleration_g: [f32; 3],
    /// Rotation about x, y and z, in degrees per second.
    pub rotation_deg_per_s: [f32; 3],
    /// Magnetic field along x, y and z, in microteslas.
    pub field_ut: [f32; 3],
}

/// A trigger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trigger {
    /// When.
    pub t: Micros,
    /// Kind of the trigger.
    pub kind: TriggerKind,
}

/// Kind of a trigger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TriggerKind {
    /// The camera's clock was set to zero.
    TimestampReset,
    /// The external input rose.
    ExternalRising,
    /// The external input fell.
    ExternalFalling,
    /// A pulse at the external input.
    ExternalPulse,
    /// The camera's own generator rose.
    GeneratorRising,
    /// The camera's own generator fell.
    GeneratorFalling,
    /// The readout of a frame began.
    FrameStart,
    /// The readout of a frame ended.
    FrameEnd,
    /// The exposure of a frame began.
    ExposureStart,
    /// The exposure of a frame ended.
    ExposureEnd,
    /// Of a number that has no name.
    Other(i8),
}

impl TriggerKind {
    /// All variants, in the order of their codes.
    const NAMED: [Self; 10] = [
        Self::TimestampReset,
        Self::ExternalRising,
        Self::ExternalFalling,
        Self::ExternalPulse,
        Self::GeneratorRising,
        Self::GeneratorFalling,
        Self::FrameStart,
        Self::FrameEnd,
        Self::ExposureStart,
        Self::ExposureEnd,
    ];

    /// The trigger of the format's code.
    pub fn from_code(code: i8) -> Self {
        let named = usize::try_from(code).ok().and_then(|k| Self::NAMED.get(k));
        named.copied().unwrap_or(Self::Other(code))
    }

    /// The format's code.
    pub fn number(self) -> i8 {
        match self {
            Self::Other(number) => number,
            named => Self::NAMED.iter().position(|&other| other == named).map_or(-1, |k| k as i8),
        }
    }
}

impl Content {
    /// The content of a FlatBuffer behind its size.
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, Broken> {
        let letters = identifier(bytes)?;
        let table = Table::root(bytes)?;
        Ok(match StreamKind::from_identifier(letters) {
            StreamKind::Events => {
                let mut columns = Columns::new();
                events::decode(bytes, &mut columns)?;
                // Again, for the fault where some are missing.
                table.vector(0)?.whole(16)?;
                Self::Events(columns)
            }
            StreamKind::Frames => Self::Frame(frame(&table)?),
            StreamKind::Imu => {
                let samples = table.vector(0)?.tables()?;
                Self::Imu(samples.map(|sample| imu(&sample?)).collect::<Result<_, _>>()?)
            }
            StreamKind::Triggers => {
                let triggers = table.vector(0)?.tables()?;
                Self::Triggers(triggers.map(|found| trigger(&found?)).collect::<Result<_, _>>()?)
            }
            StreamKind::Other(letters) => Self::Other(letters, bytes.to_vec()),
        })
    }

    /// Content of the packet.
    pub fn kind(&self) -> StreamKind {
        match self {
            Self::Events(_) => StreamKind::Events,
            Self::Frame(_) => StreamKind::Frames,
            Self::Imu(_) => StreamKind::Imu,
            Self::Triggers(_) => StreamKind::Triggers,
            Self::Other(letters, _) => StreamKind::Other(*letters),
        }
    }

    /// How many elements there are, and the times of the first and the last.
    pub(super) fn extent(&self) -> (usize, Micros, Micros) {
        fn extent_by<T>(elements: &[T], t: impl Fn(&T) -> Micros) -> (usize, Micros, Micros) {
            let at = |element: Option<&T>| element.map_or(Micros(0), &t);
            (elements.len(), at(elements.first()), at(elements.last()))
        }
        match self {
            Self::Events(columns) => extent_by(&columns.t, |&t| t),
            Self::Frame(frame) => (1, frame.t, frame.t),
            Self::Imu(samples) => extent_by(samples, |sample| sample.t),
            Self::Triggers(triggers) => extent_by(triggers, |trigger| trigger.t),
            Self::Other(..) => (1, Micros(0), Micros(0)),
        }
    }

    /// Its FlatBuffer, behind its size.
    ///
    /// # Errors
    /// If it is a frame that the format cannot hold.
    pub(super) fn encode<'a>(
        &'a self,
        builder: &'a mut Builder,
    ) -> Result<&'a [u8], FrameFieldError> {
        match self {
            Self::Events(Columns { t, x, y, polarity }) => {
                Ok(events::encode(builder, (t, x, y, polarity)))
            }
            Self::Frame(frame) => frame.encode(builder),
            Self::Imu(samples) => {
                builder.begin(*b"IMUS");
                let place = builder.root(&[Field::Next]);
                builder.tables(place, samples.iter().map(imu_fields));
                Ok(builder.finish())
            }
            Self::Triggers(triggers) => {
                builder.begin(*b"TRIG");
                let place = builder.root(&[Field::Next]);
                let fields = |trigger: &Trigger| {
                    [Field::Long(trigger.t.0), Field::Byte(trigger.kind.number())]
                };
                builder.tables(place, triggers.iter().map(fields));
                Ok(builder.finish())
            }
            Self::Other(_, bytes) => Ok(bytes),
        }
    }
}

/// A frame that the format cannot hold.
#[derive(Debug, Clone, Copy, thiserror::Error)]
pub(super) enum FrameFieldError {
    #[error("a frame of {0} columns or rows")]
    Size(u16),
    #[error("a pixel of more than 4 channels, or of none")]
    Channels,
    #[error("a frame of {0}x{1} pixels with {2} bytes")]
    Bytes(u16, u16, usize),
}

fn frame(table: &Table<'_>) -> Result<Frame, Broken> {
    let broken = |reason| Broken { at: 0, reason };
    let size =
        |slot| u16::try_from(table.i16(slot)?).map_err(|_| broken("a frame has a size below zero"));
    let time = |slot| table.i64(slot);
    let t = Micros(time(0)?.unwrap_or(0));
    let lasts = time(11)?.unwrap_or(0);
    let format = PixelFormat::from_code(table.i8(5)?);
    let format = format.ok_or(broken("the pixel format of a frame is not known"))?;
    let (width, height) = (size(6)?, size(7)?);
    let pixels = table.vector(10)?.whole(1)?;
    if pixels.len() != usize::from(width) * usize::from(height) * format.bytes() {
        return Err(broken("a frame has not as many pixels as its size says"));
    }
    Ok(Frame {
        t,
        readout_start: Micros(time(1)?.unwrap_or(0)),
        readout_end: Micros(time(2)?.unwrap_or(0)),
        // Without times of exposure, the time of the frame and its duration stand in.
        exposure_start: Micros(time(3)?.unwrap_or(t.0)),
        exposure_end: Micros(time(4)?.unwrap_or(t.0.saturating_add(lasts))),
        format,
        width,
        height,
        position: (table.i16(8)?, table.i16(9)?),
        origin: table.i8(12)?,
        pixels: pixels.to_vec(),
    })
}

impl Frame {
    fn encode<'a>(&self, builder: &'a mut Builder) -> Result<&'a [u8], FrameFieldError> {
        // Sizes are signed 16 bits in the schema.
        let size = |pixels: u16| i16::try_from(pixels).map_err(|_| FrameFieldError::Size(pixels));
        let (width, height) = (size(self.width)?, size(self.height)?);
        let code = self.format.code().ok_or(FrameFieldError::Channels)?;
        let (bytes, pixels) =
            (self.pixels.len(), usize::from(self.width) * usize::from(self.height));
        if bytes != pixels * self.format.bytes() {
            return Err(FrameFieldError::Bytes(self.width, self.height, bytes));
        }
        // The schema has the duration of the exposure besides its two ends.
        let lasts = self.exposure_end.0.saturating_sub(self.exposure_start.0);
        // In the order of the schema, whose slots are counted.
        builder.begin(*b"FRME");
        let place = builder.root(&[
            Field::Long(self.t.0),
            Field::Long(self.readout_start.0),
            Field::Long(self.readout_end.0),
            Field::Long(self.exposure_start.0),
            Field::Long(self.exposure_end.0),
            Field::Byte(code),
            Field::Short(width),
            Field::Short(height),
            Field::Short(self.position.0),
            Field::Short(self.position.1),
            Field::Next,
            Field::Long(lasts),
            Field::Byte(self.origin),
        ]);
        builder.vector(place, self.pixels.len(), 4).extend_from_slice(&self.pixels);
        Ok(builder.finish())
    }
}

fn imu(table: &Table<'_>) -> Result<ImuSample, Broken> {
    let three = |slot| Ok([table.f32(slot)?, table.f32(slot + 1)?, table.f32(slot + 2)?]);
    Ok(ImuSample {
        t: Micros(table.i64(0)?.unwrap_or(0)),
        temperature_c: table.f32(1)?,
        acceleration_g: three(2)?,
        rotation_deg_per_s: three(5)?,
        field_ut: three(8)?,
    })
}

fn imu_fields(sample: &ImuSample) -> [Field; 11] {
    let [ax, ay, az] = sample.acceleration_g.map(Field::Float);
    let [gx, gy, gz] = sample.rotation_deg_per_s.map(Field::Float);
    let [mx, my, mz] = sample.field_ut.map(Field::Float);
    let t = Field::Long(sample.t.0);
    [t, Field::Float(sample.temperature_c), ax, ay, az, gx, gy, gz, mx, my, mz]
}

fn trigger(table: &Table<'_>) -> Result<Trigger, Broken> {
    Ok(Trigger {
        t: Micros(table.i64(0)?.unwrap_or(0)),
        kind: TriggerKind::from_code(table.i8(1)?),
    })
}
