//! Files that are no recordings, named by how they begin, with what to do.

use evpose_core::bytes_without_bom;

use crate::first_line;

/// A kind of file: place and bytes of its mark, what it is, and what to do with it.
type Kind = (usize, &'static [u8], &'static str, &'static str);

const FRAMES: &str = "frames are made events by `evpose events --frames`";
const OTHER_FRAMES: &str = "save it as PNG: frames of a folder of .png or .jpg are made events by `evpose events --frames`";
const VIDEO: &str = "its frames are made events by `evpose events --frames VIDEO`";
const UNPACK: &str = "unpack it first";
const DOWNLOAD: &str = "the download brought something else: fetch the file again";
const NONE: &str = "it holds no events that are known";
const PICKLE: &str = "save its arrays with numpy.savez";

/// The kinds; of several that fit, the first.
const KINDS: &[Kind] = &[
    (
        0,
        b"version https://git-lfs",
        "a pointer of git-lfs, not the file",
        "fetch it by `git lfs pull`",
    ),
    (0, b"/annex/objects", "a pointer of git-annex, not the file", "fetch it by `git annex get`"),
    (0, b"#ROSBAG V", "a ROS 1 bag of an old format", "make it a new one by `rosbag fix`"),
    (0, b"BZh", "packed by bzip2", UNPACK),
    (0, b"\xfd7zXZ\0", "packed by xz", UNPACK),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive", UNPACK),
    (0, b"Rar!\x1a\x07", "a RAR archive", UNPACK),
    (0, b"\x04\x22\x4d\x18", "packed by LZ4", UNPACK),
    (257, b"ustar", "a tar archive", UNPACK),
    (0, b"PK\x07\x08", "a part of a ZIP archive", UNPACK),
    (0, b"<!doctype html", "a web page", DOWNLOAD),
    (0, b"<!--", "a web page or an XML document", DOWNLOAD),
    (0, b"<html", "a web page", DOWNLOAD),
    (0, b"<head", "a web page", DOWNLOAD),
    (0, b"<?xml", "an XML document", "a calibration is given as --camera"),
    (0, b"<opencv_storage", "an XML document", "a calibration is given as --camera"),
    (0, b"%PDF-", "a PDF document", NONE),
    (0, b"\x89PNG\r\n", "a PNG image", FRAMES),
    (0, b"\xff\xd8\xff", "a JPEG image", FRAMES),
    (0, b"GIF8", "a GIF animation", VIDEO),
    (0, b"BM", "a BMP image", OTHER_FRAMES),
    (0, b"II*\0", "a TIFF image", OTHER_FRAMES),
    (0, b"MM\0*", "a TIFF image", OTHER_FRAMES),
    (8, b"WEBP", "a WebP image", OTHER_FRAMES),
    (4, b"ftyphei", "a HEIC image", OTHER_FRAMES),
    (4, b"ftypmif1", "a HEIC image", OTHER_FRAMES),
    (4, b"ftypavi", "an AVIF image", OTHER_FRAMES),
    (4, b"ftypqt", "a QuickTime video", VIDEO),
    (4, b"ftyp", "an MP4 video", VIDEO),
    (0, b"\x1a\x45\xdf\xa3", "a Matroska or WebM video", VIDEO),
    (8, b"AVI ", "an AVI video", VIDEO),
    (0, b"YUV4MPEG2", "a Y4M video", VIDEO),
    (8, b"WAVE", "a WAVE sound", NONE),
    (0, b"ID3", "an MP3 sound", NONE),
    (0, b"OggS", "an Ogg file", NONE),
    (
        0,
        b"MATLAB 5.0 MAT-file",
        "a MATLAB file",
        "save its events as columns of a .csv or of a .npz",
    ),
    (0, b"\x80\x05\x95", "a pickle of Python", PICKLE),
    (0, b"\x80\x04\x95", "a pickle of Python", PICKLE),
    (0, b"\x80\x03", "a pickle of Python", PICKLE),
    (0, b"\x80\x02", "a pickle of Python", PICKLE),
    (0, b"PAR1", "a Parquet table", "save it as .csv"),
    (0, b"ARROW1", "an Arrow table", "save it as .csv"),
    (0, b"\xcd\xf2\xff\x30", "a CDF file", "give it to `evpose prepare`"),
    (0, b"CDF\x01", "a NetCDF file", NONE),
    (0, b"EVPB", "a checkpoint of evpose", "give it as --checkpoint"),
    (0, b"glTF", "a glTF model", "give it as a model of a hand or a body"),
    (0, b"ply\n", "a PLY mesh", NONE),
    (0, b"BVH", "a motion", "give it as `motion`"),
    (0, b"HIERARCHY", "a BVH motion", "give it as `motion`"),
    (0, b"\x7fELF", "a program", NONE),
    (0, b"MZ", "a program of Windows", NONE),
    (0, b"#!", "a script", NONE),
    (0, b"RRF", "a recording of Rerun", "give the recording that it was made of"),
    (0, b"\xfe\xff", "a text of UTF-16", "save it as UTF-8"),
    (0, b"\xff\xfe", "a text of UTF-16", "save it as UTF-8"),
];

/// The kind of a file that begins so and is of no format of recordings, and advice.
pub(super) fn describe(head: &[u8]) -> Option<(&'static str, &'static str)> {
    if head.is_empty() {
        return Some(("empty", "record or fetch it again"));
    }
    let text = bytes_without_bom(head).trim_ascii_start();
    let fits = |(at, mark, ..): &&Kind| {
        head.get(*at..).is_some_and(|rest| rest.starts_with(mark))
            || (*at == 0 && mark.is_ascii() && begins_with(text, mark))
    };
    // Special marks stand before those that they begin with.
    if let Some((_, _, what, advice)) = KINDS.iter().find(fits) {
        return Some((what, advice));
    }
    if let Some(named) = first_line::describe(head) {
        return Some(named);
    }
    let zeros = head.iter().all(|byte| *byte == 0);
    zeros.then_some(("filled with zeros", "the disk was full or the copy was cut: fetch it again"))
}

/// Whether a text begins with a mark; tags of web pages are written in either case.
fn begins_with(text: &[u8], mark: &[u8]) -> bool {
    text.get(..mark.len()).is_some_and(|begin| match mark {
        [b'<', ..] => begin.eq_ignore_ascii_case(mark),
        _ => begin == mark,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Input, OpenOptions, read_as};

    #[test]
    fn whatever_is_no_recording_is_named_with_what_to_do() {
        assert!(KINDS.len() >= 40);
        for (at, mark, what, advice) in KINDS {
            let bytes = [&vec![b'x'; *at][..], mark, b" and what else is in it\x01\x02"].concat();
            let input = Input::memory("events.raw", bytes);
            let message = read_as(input, &OpenOptions::default()).unwrap_err().to_string();
            assert!(message.contains(what) && message.contains(advice), "{what}: {message}");
        }
        for (bytes, what) in [
            (&b""[..], "is empty"),
            (&[0; 64], "zeros"),
            // As servers and programs write them.
            (b"<!DOCTYPE HTML PUBLIC \"-//IETF//DTD HTML 2.0//EN\">\n<html><head>\n", "a web page"),
            (b"<!Doctype html>\n", "a web page"),
            (b"\n<!-- Not found -->\n<html>\n", "a web page"),
            (b"\xef\xbb\xbf<HTML>\n", "a web page"),
            (b"\xef\xbb\xbf<?xml version=\"1.0\"?>\n", "an XML document"),
            (b"\xef\xbb\xbf{\"images\": []}", "a JSON document"),
            (b"[[1, 2], [3, 4]]\n", "a JSON or TOML document"),
            (b"\0\0\0\x1cftypheic\0\0\0\0mif1heic", "a HEIC image: save it as PNG"),
            (b"\0\0\0\x1cftypavif\0\0\0\0avifmif1", "an AVIF image: save it as PNG"),
            (b"\0\0\0\x18ftypmp42\0\0\0\0isommp42", "an MP4 video: its frames are made events"),
            (b"\x80\x05\x95\x10\0\0\0\0\0\0\0\x8c", "a pickle of Python"),
            (b"\x80\x03cnumpy.core.multiarray\n", "a pickle of Python"),
        ] {
            let input = Input::memory("events.aedat4", bytes.to_vec());
            let message = read_as(input, &OpenOptions::default()).unwrap_err().to_string();
            assert!(message.contains(what), "{message}");
        }
    }
}
