//! The kernels of training and inference on the CPU, on plain slices.
//!
//! * [`training`]: convolution, depthwise convolution, batch normalisation, max-pooling and
//!   upsampling of batches, with their gradients.
//! * [`blocked`]: the layers of inference, for one image at a time.
//! * [`Level`]: the vector instructions that both are compiled for.
//! * [`keep_freed_memory`]: the setting of the allocator that training needs.
//!
//! Images are `f32` in the layout that oneDNN calls nChw16c:
//! `[batch][channels / 16][height][width][16]`. Work is cut into pieces that depend on the shapes
//! alone and partial sums are added in a fixed order, so that results are equal to the bit whatever
//! the number of threads. Shapes are the caller's responsibility: a slice of the wrong length
//! panics.
//!
//! ```
//! use evpose_kernels::Level;
//! use evpose_kernels::training::{Blocks, Conv};
//!
//! let input = Blocks { batch: 1, channels: 2, height: 4, width: 5 };
//! let conv = Conv { input, channels_out: 3, kernel: 3, stride: 1, level: Level::best() };
//! // All inputs and weights are one: an output is the number of taps inside of the image.
//! let image = input.from_planes(&[1.0; 2 * 4 * 5]);
//! let weight = [1.0; 3 * 2 * 3 * 3];
//! let output = conv.output().to_planes(&conv.forward(image[..].into(), &weight, None));
//! assert_eq!(output.len(), 3 * 4 * 5);
//! assert_eq!([output[0], output[1], output[6]], [8.0, 12.0, 18.0]);
//! ```
//!
//! # Unsafe code
//! Threads write disjoint tiles of one output through raw pointers, because slices cannot express tiles
//! of rows. Every such function states the elements that it reads and writes; vector instructions
//! themselves are in `evpose-cpu`.

mod activation;
pub mod blocked;
mod cache;
mod memory;
mod simd;
pub mod training;

pub use evpose_cpu::Level;
pub use memory::keep_freed_memory;
