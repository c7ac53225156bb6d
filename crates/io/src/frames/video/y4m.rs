//! Y4M: a line of text, then frames of planes that are not packed, luma first.
//!
//! | `C` | planes |
//! |---|---|
//! | `420`, `420jpeg`, `420mpeg2`, `420paldv`, or none | luma, and two of a quarter of its pixels |
//! | `422`, `444` | luma, and two of half of its pixels, or of all |
//! | `mono` | luma of 0 to 255 |
//!
//! Samples are of 8 bits; videos of more are left to `ffmpeg`. Luma is 16 to 235 unless `XCOLORRANGE=FULL` says 0 to 255;
//! a pixel has the chroma that is stored for it, without interpolation.
//!
//! # Source
//! yuv4mpeg(5) of mjpegtools; ITU-R BT.601 for colours.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _, Seek as _};

use evpose_core::SensorSize;

use super::{OpenedVideo, VideoDecoder, undecodable};
use crate::frames::fault::sensor_size;
use crate::frames::light::Light;
use crate::frames::{FrameFault, folder};

/// How its first line begins.
pub(super) const MAGIC: &[u8] = b"YUV4MPEG2 ";
/// Bytes of a line, at most.
const MAX_LINE: u64 = 4_096;

/// The frames of a video that are still to come.
struct Y4m {
    file: BufReader<File>,
    size: SensorSize,
    chroma: Chroma,
    is_full_range: bool,
    /// The planes of one frame.
    planes: Vec<u8>,
    /// Its red, green and blue.
    codes: Vec<u8>,
}

/// Pixels in a row and in a column that share a chroma sample.
#[derive(Debug, Clone, Copy)]
enum Chroma {
    None,
    Shared(usize, usize),
}

/// Opens a video; none if its samples are others than those above.
pub(super) fn open(mut file: BufReader<File>) -> Result<Option<OpenedVideo>, FrameFault> {
    let length = file.get_ref().metadata().map_err(undecodable)?.len();
    let header = line(&mut file)?.ok_or_else(|| undecodable("it ends in its first line"))?;
    let field = |key: char| header.split(' ').skip(1).find_map(|field| field.strip_prefix(key));
    let number = |key| {
        let value = field(key).and_then(|value| value.parse::<u64>().ok()).filter(|n| *n > 0);
        value.ok_or_else(|| undecodable(format!("its first line states no `{key}`")))
    };
    let size = sensor_size(number('W')?, number('H')?)?;
    let chroma = match field('C') {
        None | Some("420" | "420jpeg" | "420mpeg2" | "420paldv") => Chroma::Shared(2, 2),
        Some("422") => Chroma::Shared(2, 1),
        Some("444") => Chroma::Shared(1, 1),
        Some("mono") => Chroma::None,
        Some(_) => return Ok(None),
    };
    let rate = field('F').and_then(|rate| rate.split_once(':'));
    let rate = rate.and_then(|(n, d)| Some(n.parse::<f64>().ok()? / d.parse::<f64>().ok()?));
    let rate = rate.filter(|rate| *rate > 0.0 && rate.is_finite());
    let rate = rate.ok_or_else(|| undecodable("its first line states no rate, such as `F30:1`"))?;
    let is_full_range = header.contains(" XCOLORRANGE=FULL") || matches!(chroma, Chroma::None);
    let frame = frame_bytes(size, chroma);
    let begin = file.stream_position().map_err(undecodable)?;
    // All times are known before the first frame is decoded, and a cut shows at once.
    let mut frames = 0_u32;
    while line(&mut file)?.is_some() {
        let at = file.stream_position().map_err(undecodable)?;
        if length.saturating_sub(at) < frame as u64 {
            return Err(undecodable(format!("cut at byte {length}, in frame {frames}")));
        }
        // A relative seek keeps what is buffered, which a seek from the start would read again.
        file.seek_relative(frame as i64).map_err(undecodable)?;
        frames += 1;
    }
    if frames == 0 {
        return Err(undecodable("there is no frame behind its first line"));
    }
    file.seek(std::io::SeekFrom::Start(begin)).map_err(undecodable)?;
    let times_s = (0..frames).map(|frame| f64::from(frame) / rate).collect();
    let (planes, codes) = (vec![0; frame], vec![0; 3 * size.pixels()]);
    let video = Y4m { file, size, chroma, is_full_range, planes, codes };
    Ok(Some((Box::new(video), size, times_s)))
}

impl VideoDecoder for Y4m {
    fn decode(&mut self, _: usize, light: &Light, out: &mut [f32]) -> Result<(), FrameFault> {
        line(&mut self.file)?;
        self.file.read_exact(&mut self.planes).map_err(undecodable)?;
        self.fill_rgb();
        folder::colour::<_, 3>(&self.codes, light, out);
        Ok(())
    }
}

impl Y4m {
    fn fill_rgb(&mut self) {
        let width = usize::from(self.size.width);
        let (luma, chroma) = self.planes.split_at(self.size.pixels());
        let (blue, red) = chroma.split_at(chroma.len() / 2);
        // Of 0 to 255: 219 and 224 codes of the usual range are stretched.
        let (zero, of_luma, of_chroma) =
            if self.is_full_range { (0.0, 1.0, 1.0) } else { (16.0, 255.0 / 219.0, 255.0 / 224.0) };
        for (pixel, (rgb, y)) in self.codes.as_chunks_mut::<3>().0.iter_mut().zip(luma).enumerate()
        {
            let y = of_luma * (f32::from(*y) - zero);
            let (cb, cr) = match self.chroma {
                Chroma::None => (0.0, 0.0),
                Chroma::Shared(across, down) => {
                    // Where the width is odd, the last column has chroma of its own.
                    let place =
                        pixel / width / down * width.div_ceil(across) + pixel % width / across;
                    let sample = |plane: &[u8]| of_chroma * (f32::from(plane[place]) - 128.0);
                    (sample(blue), sample(red))
                }
            };
            // The conversion to bytes ends at 0 and 255.
            *rgb = [y + 1.402 * cr, y - 0.344_136 * cb - 0.714_136 * cr, y + 1.772 * cb]
                .map(|value| value.round() as u8);
        }
    }
}

fn frame_bytes(size: SensorSize, chroma: Chroma) -> usize {
    let (width, height) = (usize::from(size.width), usize::from(size.height));
    let of_chroma = match chroma {
        Chroma::None => 0,
        Chroma::Shared(across, down) => width.div_ceil(across) * height.div_ceil(down),
    };
    width * height + 2 * of_chroma
}

/// The next line without its end; none at the end of the file.
fn line(file: &mut BufReader<File>) -> Result<Option<String>, FrameFault> {
    let mut line = Vec::new();
    file.by_ref().take(MAX_LINE).read_until(b'\n', &mut line).map_err(undecodable)?;
    match line.split_last() {
        None => Ok(None),
        Some((b'\n', line)) => Ok(Some(String::from_utf8_lossy(line).into_owned())),
        Some(_) => Err(undecodable("a line of it has no end")),
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Plane;

    use crate::{Encoding, FrameSource, IoError};

    fn read(bytes: &[u8]) -> Result<(Vec<f64>, Vec<Vec<f32>>), IoError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.y4m");
        std::fs::write(&path, bytes).unwrap();
        let mut source = FrameSource::open(&path, Encoding::Linear, None)?;
        let times_s = source.times_s().unwrap().to_vec();
        let (mut frame, mut frames) = (Plane::for_sensor(source.size(), 0.0), Vec::new());
        while source.next_into(&mut frame)? {
            frames.push(frame.data().to_vec());
        }
        Ok((times_s, frames))
    }

    #[track_caller]
    fn near(light: &[f32], wanted: &[f32]) {
        assert_eq!(light.len(), wanted.len());
        assert!(
            light.iter().zip(wanted).all(|(y, wanted)| (y - wanted).abs() < 0.004),
            "{light:?}"
        );
    }

    #[test]
    fn grey_videos_have_their_light_and_times() {
        let mono = b"YUV4MPEG2 W3 H1 F25:2 Cmono\nFRAME\n\x00\x33\xffFRAME Ip\n\xff\x33\x00";
        let (times_s, frames) = read(mono).unwrap();
        assert_eq!(times_s, [0.0, 0.08]);
        near(&frames[0], &[0.0, 0.2, 1.0]);
        near(&frames[1], &[1.0, 0.2, 0.0]);
        // Of the usual range black is 16 and white is 235; 3 x 1 pixels have 2 x 1 samples of chroma.
        let usual = b"YUV4MPEG2 W3 H1 F30:1 C420jpeg\nFRAME\n\x10\x3c\xeb\x80\x80\x80\x80";
        near(&read(usual).unwrap().1[0], &[0.0, 44.0 / 219.0, 1.0]);
        let full = b"YUV4MPEG2 W3 H1 F30:1 C420jpeg XYSCSS=420JPEG XCOLORRANGE=FULL\nFRAME\n\x10\x3c\xeb\x80\x80\x80\x80";
        near(&read(full).unwrap().1[0], &[16.0 / 255.0, 60.0 / 255.0, 235.0 / 255.0]);
    }

    #[test]
    fn colours_are_those_of_their_own_pixels() {
        // Red, green, blue and white of BT.601, as tables of test patterns have them.
        let planes = b"\x51\x91\x29\xeb\x5a\x36\xf0\x80\xf0\x22\x6e\x80";
        let video = [b"YUV4MPEG2 W4 H1 F30:1 C444\nFRAME\n", &planes[..]].concat();
        near(&read(&video).unwrap().1[0], &[0.2126, 0.7152, 0.0722, 1.0]);
        // Of 4:2:0, four pixels share a sample: all are as red as their luma allows.
        let shared = b"YUV4MPEG2 W2 H2 F30:1\nFRAME\n\x51\x51\x51\x51\x5a\xf0";
        near(&read(shared).unwrap().1[0], &[0.2126; 4]);
    }

    #[test]
    fn what_is_cut_or_says_nothing_is_an_error() {
        for (video, reason) in [
            (
                &b"YUV4MPEG2 W2 H1 F30:1 Cmono\nFRAME\n\x00\x01FRAME\n\x00"[..],
                "cut at byte 43, in frame 1",
            ),
            (b"YUV4MPEG2 W2 H1 F30:1 Cmono\nFRAME\n\x00\x01FRA", "a line of it has no end"),
            (b"YUV4MPEG2 W65535 H65535 F30:1\nFRAME\n\x00", "cut at byte 37, in frame 0"),
            (b"YUV4MPEG2 W2 H1 F30:1 Cmono\n", "no frame"),
            (b"YUV4MPEG2 H1 F30:1 Cmono\nFRAME\n\x00", "states no `W`"),
            (b"YUV4MPEG2 W2 H1 F0:0 Cmono\nFRAME\n\x00\x00", "states no rate"),
            (b"YUV4MPEG2 W2", "a line of it has no end"),
        ] {
            let message = read(video).unwrap_err().to_string();
            assert!(message.contains(reason), "{message}");
        }
    }
}
