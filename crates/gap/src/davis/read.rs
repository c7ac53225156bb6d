//! Frames and events of a recording that holds both: AEDAT4, or a bag of ROS with images.

use std::path::Path;

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_io::aedat4::{Aedat4Packet, Content, Depth, Frame, Packets, StreamKind};
use evpose_io::{IoError, OpenOptions, Windows, ros};

use super::{Response, Shot, Shots};
use crate::GapError;
use crate::input::{LoadedRecording, units};

/// Minimum frames: a twin uses every second one, and a part of a recording has to be held out.
const MIN_SHOTS: usize = 6;
/// Interval, relative to the usual one, from which frames are missing in between.
const LATE: f64 = 2.5;
/// Relative difference of exposures, and fraction of excluded pixels, that is noted.
const EVEN: f64 = 0.01;
/// First origin code of computed frames in AEDAT4, and the one of simulated light among them.
const FIRST_COMPUTED: i8 = 2;
const SIMULATED: i8 = 4;

/// A recording with its frames.
#[derive(Debug, Clone)]
pub struct LoadedShots {
    /// Frames with their times of exposure.
    pub shots: Shots,
    /// Events between the first and the last frame.
    pub recording: LoadedRecording,
}

struct FileFrames {
    frames: Vec<Frame>,
    /// Number of frames that were computed from events.
    computed: usize,
    /// Whether the file declares a stream of frames.
    has_stream: bool,
    end: Micros,
}

/// Reads the frames of a recording and the events that they bracket, `seconds` of it at most, from
/// its first event on. The middle of the exposure of the first frame becomes time zero.
///
/// # Errors
/// A file that is neither an AEDAT4 recording nor one of ROS, or without enough frames of light on this sensor.
pub fn load_shots(
    path: impl AsRef<Path>,
    response: Response,
    seconds: f64,
    options: &OpenOptions,
) -> Result<LoadedShots, GapError> {
    let path = path.as_ref();
    let format = evpose_io::detect_format(path)?.name;
    if format != "aedat4" && !ros::NAMES.contains(&format) {
        let problem = format!(
            "frames beside events are in AEDAT4 files and in bags of ROS, and this one is {format}"
        );
        return Err(GapError::NoFrames { path: path.to_owned(), problem });
    }
    // Frames are on the clock of the file, and time zero is that of the first.
    let options = &OpenOptions { zero_time: false, ..options.clone() };
    let mut windows = Windows::open(path, options)?;
    let size = windows.sensor();
    let Some(first) = windows.start() else {
        return Err(GapError::Recording(format!("{}: no events", path.display())));
    };
    let (frames, has_stream) = match format {
        "aedat4" => frames_of_aedat4(path)?,
        _ => (Box::new(ros::images(path, options)?) as Frames, true),
    };
    let read = FileFrames::read(frames, has_stream, first, seconds)?;
    let fault = |problem: String| GapError::Frames { path: path.to_owned(), problem };
    if read.frames.is_empty() {
        let problem = match (read.has_stream, read.computed) {
            (_, 1..) => {
                "it holds only frames that were computed from events, which are no reference"
            }
            (true, 0) => "it declares a stream of frames, and holds none",
            (false, 0) => "it holds no frames",
        };
        return Err(GapError::NoFrames { path: path.to_owned(), problem: problem.to_owned() });
    }
    let mut notes = Vec::new();
    if read.computed > 0 {
        notes.push(format!("{} frames that were computed from events are left out", read.computed));
    }
    let shots = read.frames.iter().map(|frame| shot(frame, size, fault));
    let mut all = shots.collect::<Result<Vec<_>, _>>()?;
    all.sort_by_key(|shot| (shot.start, shot.end));
    // Some recorders write a frame twice; light at one time must be one.
    all.dedup_by(|b, a| b.middle_us() <= a.middle_us());
    let whole = all.len();
    let mut chosen = bracketing(&all, first, read.end);
    if chosen.len() < MIN_SHOTS {
        return Err(fault(format!(
            "{} of its {whole} frames lie one after the other beside events, and at least \
             {MIN_SHOTS} are needed",
            chosen.len()
        )));
    }
    if chosen.len() < whole {
        notes.push(format!("{} of the {whole} frames read are compared", chosen.len()));
    }
    let zero = Micros(chosen[0].middle_us().round() as i64);
    for shot in &mut chosen {
        (shot.start, shot.end) = (shot.start - zero, shot.end - zero);
    }
    let white = max_code(read.frames[0].format.depth);
    let shots = Shots::new(size, response, white, chosen)?;
    notes.extend(notes_on(&shots));
    let last = shots.duration();
    let window = TimeWindow { start: zero, end: zero + last + Micros(1) };
    let mut events = EventStream::empty(size);
    windows.read(window, &mut events)?;
    notes.extend(windows.remarks());
    if events.is_empty() {
        return Err(GapError::Recording(format!("{}: no events between frames", path.display())));
    }
    let provenance = vec![
        format!(
            "{}: {} events of a sensor of {size} in {:.6} s between frames ({format})",
            path.display(),
            events.len(),
            last.as_seconds()
        ),
        described(path, &shots),
    ];
    let events = units::shifted(&events, Micros(-zero.0));
    let outside = windows.outside();
    let recording = LoadedRecording { events, outside, tick: Micros(1), provenance, notes };
    Ok(LoadedShots { shots, recording })
}

type Frames = Box<dyn Iterator<Item = Result<Frame, IoError>>>;

/// The frames of the first camera, and whether the file declares them.
fn frames_of_aedat4(path: &Path) -> Result<(Frames, bool), GapError> {
    let packets = Packets::open(path)?;
    let stream = packets.streams().iter().find(|stream| stream.kind == StreamKind::Frames);
    let mut chosen = stream.map(|stream| stream.id);
    let has_stream = chosen.is_some();
    let frames = packets.filter_map(move |packet| match packet {
        Ok(Aedat4Packet { stream, content: Content::Frame(frame) }) => {
            // A file that declares no stream of frames may hold one all the same: the first that comes.
            (stream == *chosen.get_or_insert(stream)).then_some(Ok(frame))
        }
        Ok(_) => None,
        Err(fault) => Some(Err(fault)),
    });
    Ok((Box::new(frames), has_stream))
}

impl FileFrames {
    /// Reads frames up to `seconds` behind the first event, and one more.
    fn read(
        frames: Frames,
        has_stream: bool,
        first: Micros,
        seconds: f64,
    ) -> Result<Self, GapError> {
        let mut read = Self { frames: Vec::new(), computed: 0, has_stream, end: Micros(i64::MAX) };
        for frame in frames {
            let frame = frame?;
            if read.end == Micros(i64::MAX) {
                let from = first.max(frame.exposure_start);
                read.end = Micros(from.0.saturating_add(Micros::from_seconds(seconds).0));
            }
            let is_behind = frame.exposure_start > read.end;
            if frame.origin >= FIRST_COMPUTED && frame.origin != SIMULATED {
                read.computed += 1;
            } else {
                read.frames.push(frame);
            }
            // The frame behind the end as well: light is known up to it.
            if is_behind {
                break;
            }
        }
        Ok(read)
    }
}

/// Code of white at a bit depth, clipped to 16 bits.
fn max_code(depth: Depth) -> u16 {
    if depth == Depth::U8 { u16::from(u8::MAX) } else { u16::MAX }
}

fn shot(
    frame: &Frame,
    size: SensorSize,
    fault: impl Fn(String) -> GapError,
) -> Result<Shot, GapError> {
    let of_frame = SensorSize { width: frame.width, height: frame.height };
    // A part of the image would have to be placed, which no camera of this kind writes.
    if of_frame != size || frame.position != (0, 0) {
        return Err(fault(format!("a frame of {of_frame} beside events of a sensor of {size}")));
    }
    let codes = match (frame.format.depth, frame.format.channels) {
        (Depth::U8, 1) => frame.pixels.iter().copied().map(u16::from).collect(),
        (Depth::U16, 1) => {
            let (codes, _) = frame.pixels.as_chunks::<2>();
            codes.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect()
        }
        _ => {
            let problem = "its frames are not grey of 8 or 16 bits: pixels behind filters of \
                           colours see other light than their neighbours";
            return Err(fault(problem.to_owned()));
        }
    };
    // Files without exposure times: the frame is of an instant.
    let (start, end) = if frame.exposure_end > frame.exposure_start {
        (frame.exposure_start, frame.exposure_end)
    } else {
        (frame.t, frame.t)
    };
    Ok(Shot { start, end, codes })
}

/// Longest run of frames without a gap, from the last frame before the first event on.
fn bracketing(all: &[Shot], first: Micros, end: Micros) -> Vec<Shot> {
    let middle = |shot: &Shot| shot.middle_us();
    let from = all.partition_point(|shot| middle(shot) <= first.0 as f64).saturating_sub(1);
    let to = all.partition_point(|shot| middle(shot) <= end.0 as f64);
    let all = all.get(from..to.max(from)).unwrap_or_default();
    let mut steps: Vec<f64> = all.windows(2).map(|two| middle(&two[1]) - middle(&two[0])).collect();
    let between = steps.clone();
    steps.sort_by(f64::total_cmp);
    // The median: a gap lengthens the mean.
    let Some(usual) = steps.get(steps.len() / 2) else { return all.to_vec() };
    let mut best = 0..0;
    let mut start = 0;
    for k in 0..all.len() {
        if k > 0 && between[k - 1] > LATE * usual {
            start = k;
        }
        if k + 1 - start > best.len() {
            best = start..k + 1;
        }
    }
    all[best].to_vec()
}

fn described(path: &Path, shots: &Shots) -> String {
    format!(
        "{}: {} frames, {:.1} a second, exposed for {:.2} ms, response {}, white {}",
        path.display(),
        shots.shots.len(),
        (shots.shots.len() - 1) as f64 / shots.duration().as_seconds(),
        1e-3 * shots.usual_exposure_us(),
        shots.response,
        shots.white
    )
}

fn notes_on(shots: &Shots) -> Vec<String> {
    let mut notes = Vec::new();
    let usual = shots.usual_exposure_us();
    if usual <= 0.0 {
        notes.push(
            "the file has no exposure times: frames are taken to be instantaneous".to_owned(),
        );
    } else if shots.exposures().iter().any(|share| (share - 1.0).abs() > EVEN) {
        notes.push("exposures differ: codes are divided by their lengths".to_owned());
    }
    let masked = shots.masked_fraction();
    if masked > EVEN {
        notes.push(format!(
            "{:.0} % of the pixels are black, white or too dark in some frame: their events are not \
             compared",
            100.0 * masked
        ));
    }
    notes
}
