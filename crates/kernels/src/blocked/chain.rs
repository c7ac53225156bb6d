//! Layers done together, some rows at a time, so that what lies between them stays in the second
//! cache.
//!
//! Images between the first layers of a network are larger than caches: to write them and to read
//! them again takes as long as their products. A chain makes a few rows of its last layer, and
//! before them the rows of the others that these need: a stem with its pooling, an inverted
//! residual, a head. Rows that the next few need too are kept.

use std::ops::Range;

use super::conv::{Conv, Output};
use super::depthwise::Depthwise;
use super::image::{BEYOND, Image, Input, Line};
use super::planes::{PlaneConv, Planes};
use super::pool::{MaxPool, maxima};
use super::thread_pool::ThreadPool;
use super::tile::Activation;
use super::winograd::Scratch;
use crate::simd::{LANES, Level};

/// Bytes between the layers of a thread, of a second cache of 1 MiB.
const BETWEEN: usize = 400 << 10;
/// Rows of the last layer that are made at once, at most.
const ROWS: usize = 8;

/// A layer of a chain.
#[derive(Debug, Clone)]
pub enum Link {
    /// Of an image in planes; only the first.
    Planes(PlaneConv, Activation),
    /// A convolution.
    Conv(Conv, Activation),
    /// A convolution of every channel by itself.
    Depthwise(Depthwise, Activation),
    /// Maxima of windows.
    MaxPool(MaxPool),
}

/// What the first layer takes.
#[derive(Debug, Clone, Copy)]
pub enum Source<'a> {
    /// An image in blocks of channels.
    Image(&'a Image),
    /// An image in planes.
    Planes(&'a Planes),
}

/// Layers that are done together.
#[derive(Debug, Clone)]
pub struct Chain {
    level: Level,
    links: Vec<Link>,
    /// Channels, rows and columns of what the first takes, and of what each makes.
    sizes: Vec<[usize; 3]>,
    /// Windows of columns where maxima are made.
    columns: Vec<Vec<Range<usize>>>,
    /// Rows between the links, for each but the last.
    bands: Vec<Band>,
    /// Rows of the last that are made at once.
    at_once: usize,
}

/// Memory for some rows of all channels.
#[derive(Debug, Clone, Copy)]
struct Band {
    /// Of zeros, on each side.
    border: usize,
    /// Lines from a row to the next, and from a block of channels to the next.
    row_pitch: usize,
    block_pitch: usize,
    /// Of channels, or planes.
    blocks: usize,
    is_planes: bool,
    /// Where it begins, in lines.
    first: usize,
}

impl Link {
    /// Rows and columns of a window, pixels between windows, and by which the first begins outside.
    fn window(&self) -> [usize; 3] {
        let of = |kernel: usize, stride: usize| [kernel, stride, kernel / 2];
        match self {
            Self::Planes(conv, _) => of(conv.shape().kernel, conv.shape().stride),
            Self::Conv(conv, _) => of(conv.shape().kernel, conv.shape().stride),
            Self::Depthwise(conv, _) => of(conv.shape().kernel, conv.shape().stride),
            Self::MaxPool(pool) => [pool.window, pool.stride, pool.padding],
        }
    }

    /// Zeros that it needs around its input.
    fn border(&self) -> usize {
        match self {
            Self::MaxPool(_) => 0,
            _ => self.window()[2],
        }
    }

    /// Channels, rows and columns of what it makes of so many.
    fn output(&self, [channels, height, width]: [usize; 3]) -> [usize; 3] {
        match self {
            Self::Planes(conv, _) => [conv.shape().channels_out, height, width],
            Self::Conv(conv, _) => {
                let shape = conv.shape();
                [shape.channels_out, shape.output(height), shape.output(width)]
            }
            Self::Depthwise(conv, _) => {
                let sides = [height, width].map(|side| side.div_ceil(conv.shape().stride));
                [channels, sides[0], sides[1]]
            }
            Self::MaxPool(pool) => [channels, pool.output(height), pool.output(width)],
        }
    }

    /// Rows that some of its own are made of; those outside of the image too.
    fn needed(&self, rows: &Range<isize>) -> Range<isize> {
        let [window, stride, padding] = self.window().map(|side| side as isize);
        rows.start * stride - padding..(rows.end - 1) * stride - padding + window
    }
}

impl Chain {
    /// Of layers, each of which takes what the one before it makes, the first of them `input`
    /// channels, rows and columns.
    ///
    /// # Panics
    /// If a layer cannot take what the one before it makes, or one that is not the first takes
    /// planes.
    pub fn new(links: Vec<Link>, input: [usize; 3], level: Level) -> Self {
        assert!(!links.is_empty(), "layers");
        let mut sizes = vec![input];
        for (at, link) in links.iter().enumerate() {
            let channels = match link {
                Link::Planes(conv, _) => conv.shape().channels_in,
                Link::Conv(conv, _) => conv.shape().channels_in,
                Link::Depthwise(conv, _) => conv.shape().channels,
                Link::MaxPool(_) => sizes[at][0],
            };
            assert_eq!(channels, sizes[at][0], "channels of layer {at}");
            let is_planes = matches!(link, Link::Planes(..));
            assert!(!is_planes || at == 0, "only the first takes planes");
            let next = links.get(at + 1);
            assert!(!is_planes || matches!(next, Some(Link::Conv(..))), "a convolution of planes");
            sizes.push(link.output(sizes[at]));
        }
        let columns = |(link, size): (&Link, &[usize; 3])| match link {
            Link::MaxPool(pool) => pool.windows([size[1], size[2]])[1].clone(),
            _ => Vec::new(),
        };
        let columns = links.iter().zip(&sizes).map(columns).collect();
        let mut chain = Self { level, links, sizes, columns, bands: Vec::new(), at_once: ROWS };
        loop {
            chain.bands = chain.bands_of(chain.at_once);
            if chain.at_once == 1 || chain.lines() * size_of::<Line>() <= BETWEEN {
                return chain;
            }
            chain.at_once -= 1;
        }
    }

    /// Channels, rows and columns of what it makes.
    pub fn output(&self) -> [usize; 3] {
        self.sizes[self.links.len()]
    }

    /// Zeros that it needs around its input.
    pub fn border(&self) -> usize {
        self.links[0].border()
    }

    /// Memory for the rows that so many of the last layer are made of.
    fn bands_of(&self, rows: usize) -> Vec<Band> {
        let mut bands = Vec::new();
        let mut needed = 0..rows as isize;
        for (at, link) in self.links.iter().enumerate().skip(1).rev() {
            needed = link.needed(&needed);
            let [channels, _, width] = self.sizes[at];
            let border = link.border();
            let is_planes = matches!(self.links[at - 1], Link::Planes(..));
            let (row_pitch, blocks) = if is_planes {
                // What a register reads beyond the last pixel is inside.
                ((width + 2 * border + LANES).div_ceil(LANES), channels)
            } else {
                (width + 2 * border + BEYOND, channels.div_ceil(LANES))
            };
            let block_pitch = needed.len() * row_pitch;
            bands.push(Band { border, row_pitch, block_pitch, blocks, is_planes, first: 0 });
        }
        bands.reverse();
        let mut first = 0;
        for band in &mut bands {
            band.first = first;
            first += band.lines();
        }
        bands
    }

    /// Lines of a thread.
    fn lines(&self) -> usize {
        self.bands.iter().map(Band::lines).sum()
    }

    /// Writes what the last layer makes to `output`; to its sums `residual` is added, which only a
    /// convolution takes.
    ///
    /// # Panics
    /// If an image has another size, or the border of the input is less than that of the first
    /// layer, or there is a residual and no convolution for it, or there are more than sixteen
    /// planes.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: Source<'_>,
        residual: Option<&Image>,
        output: &mut Image,
        scratch: &mut Scratch,
    ) {
        let size = |image: &Image| [image.channels(), image.height(), image.width()];
        match (input, &self.links[0]) {
            (Source::Image(image), Link::Conv(..) | Link::Depthwise(..) | Link::MaxPool(_)) => {
                assert_eq!(size(image), self.sizes[0], "size of the input");
                assert!(image.border() >= self.border(), "a border as wide as the padding");
            }
            (Source::Planes(planes), Link::Planes(..) | Link::Conv(..)) => {
                assert_eq!(planes.size(), self.sizes[0], "size of the input");
                assert!(self.sizes[0][0] <= LANES, "at most sixteen planes");
                assert!(planes.border() >= self.border(), "a border as wide as the padding");
            }
            _ => panic!("an input that the first layer takes"),
        }
        assert_eq!(size(output), self.output(), "size of the output");
        let takes_residual = matches!(self.links.last(), Some(Link::Conv(..)));
        assert!(residual.is_none_or(|image| takes_residual && size(image) == self.output()));
        let of_thread = self.lines();
        let memory = Memory(scratch.lines(of_thread * thread_pool.threads()));
        let rows = self.output()[1];
        let (residual, output) = (residual.map(Input::of), Output::of(output));
        thread_pool.run(&|part| {
            let memory = memory.from(part.index * of_thread);
            let job = Job { of: self, input, residual, output, memory };
            // SAFETY: sizes were compared, rows of the parts are disjoint, each has memory of its
            // own, and the level is one of this processor's.
            unsafe { job.run(part.chunk(rows)) };
        });
    }
}

impl Band {
    fn lines(&self) -> usize {
        self.blocks * self.block_pitch
    }
}

/// Where bands are.
#[derive(Clone, Copy)]
struct Memory(*mut Line);

// SAFETY: threads write what is theirs.
unsafe impl Send for Memory {}
// SAFETY: as above.
unsafe impl Sync for Memory {}

impl Memory {
    /// What begins at a line.
    fn from(self, line: usize) -> Self {
        Self(self.0.wrapping_add(line))
    }
}

/// Some rows of a chain.
struct Job<'a> {
    of: &'a Chain,
    input: Source<'a>,
    residual: Option<Input>,
    output: Output,
    memory: Memory,
}

impl Job<'_> {
    /// # Safety
    /// Rows are of the output, and nobody else writes them; the memory is this thread's.
    unsafe fn run(&self, rows: Range<usize>) {
        let links = self.of.links.len();
        // What each band holds.
        let mut held: Vec<Range<isize>> = vec![0..0; links - 1];
        for first in rows.clone().step_by(self.of.at_once) {
            let last = (first + self.of.at_once).min(rows.end);
            let mut needed = vec![first as isize..last as isize; links];
            for at in (1..links).rev() {
                needed[at - 1] = self.of.links[at].needed(&needed[at]);
            }
            for at in 0..links {
                // SAFETY: the caller's; bands have room for what is needed at once.
                unsafe {
                    let new = if at + 1 < links {
                        let new = self.kept(at, &held[at], &needed[at]);
                        held[at] = needed[at].clone();
                        new
                    } else {
                        needed[at].start as usize..needed[at].end as usize
                    };
                    if !new.is_empty() {
                        self.link(at, new, &needed);
                    }
                }
            }
        }
    }

    /// Moves rows of a band that are needed again to its beginning, and puts zeros outside of the
    /// image. Returns the rows that are missing.
    ///
    /// # Safety
    /// As [`run`](Self::run).
    unsafe fn kept(&self, at: usize, held: &Range<isize>, needed: &Range<isize>) -> Range<usize> {
        let band = &self.of.bands[at];
        let height = self.of.sizes[at + 1][1] as isize;
        let kept = needed.start.max(held.start)..needed.end.min(held.end);
        let is_kept = !kept.is_empty();
        let missing = if is_kept { kept.end } else { needed.start }..needed.end;
        let memory = self.memory.from(band.first);
        // SAFETY: the caller's; rows that are kept are inside the band, before and after.
        unsafe {
            for block in 0..band.blocks {
                let first = memory.from(block * band.block_pitch).0;
                let row = |row: isize, of: &Range<isize>| {
                    first.add((row - of.start) as usize * band.row_pitch)
                };
                if is_kept && held.start != needed.start {
                    let (from, to) = (row(kept.start, held), row(kept.start, needed));
                    std::ptr::copy(from, to, kept.len() * band.row_pitch);
                }
                for y in missing.clone() {
                    let row = row(y, needed);
                    if (0..height).contains(&y) && !band.is_planes {
                        row.write_bytes(0, band.border);
                        row.add(band.row_pitch - BEYOND - band.border).write_bytes(0, band.border);
                    } else {
                        row.write_bytes(0, band.row_pitch);
                    }
                }
            }
        }
        missing.start.clamp(0, height) as usize..missing.end.clamp(0, height) as usize
    }

    /// Makes rows of a link.
    ///
    /// # Safety
    /// As [`run`](Self::run); rows that they are made of are there.
    unsafe fn link(&self, at: usize, rows: Range<usize>, needed: &[Range<isize>]) {
        let link = &self.of.links[at];
        let first = rows.start as isize;
        let (output, residual) = if at + 1 == needed.len() {
            (self.output, self.residual.map(|image| image.beginning_at(first)))
        } else {
            (self.band(at).beginning_at(-needed[at].start), None)
        };
        let input = match self.input {
            Source::Image(image) if at == 0 => Input::of(image),
            Source::Planes(planes) if at == 0 => {
                if let Link::Planes(conv, activation) = link {
                    // SAFETY: the caller's.
                    return unsafe { conv.rows(planes, *activation, output, rows) };
                }
                Input::of_planes(planes)
            }
            _ => {
                let is_planes = self.of.bands[at - 1].is_planes;
                Input::at(self.band(at - 1), is_planes).beginning_at(-needed[at - 1].start)
            }
        };
        let of_rows = input.beginning_at(first * link.window()[1] as isize);
        // SAFETY: the caller's.
        unsafe {
            match link {
                Link::Planes(..) => unreachable!("the first takes planes"),
                Link::Conv(conv, activation) => {
                    conv.rows(
                        of_rows,
                        residual,
                        *activation,
                        output.beginning_at(first),
                        rows.len(),
                    );
                }
                Link::Depthwise(conv, activation) => {
                    conv.rows(of_rows, *activation, output.beginning_at(first), rows.len());
                }
                Link::MaxPool(pool) => {
                    let [channels, height, _] = self.of.sizes[at];
                    let windows: Vec<Range<usize>> =
                        rows.map(|row| pool.window_of(row, height)).collect();
                    let windows = [windows.as_slice(), &self.of.columns[at]];
                    let blocks = channels.div_ceil(LANES);
                    maxima(self.of.level, input, windows, output.beginning_at(first), blocks);
                }
            }
        }
    }

    /// Rows between a link and the next, from the first that the band holds on.
    fn band(&self, at: usize) -> Output {
        let band = &self.of.bands[at];
        let pixel = if band.is_planes { 1 } else { LANES };
        let first: *mut f32 = self.memory.from(band.first).0.cast();
        let pixels = first.wrapping_add(band.border * pixel);
        let [row_pitch, block_pitch] =
            [band.row_pitch, band.block_pitch].map(|lines| lines * LANES);
        Output { pixels, row_pitch, block_pitch, width: self.of.sizes[at + 1][2] }
    }
}
