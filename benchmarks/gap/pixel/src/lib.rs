//! Blind benchmark of event-camera recordings with hidden effects.
//!
//! A program that identifies the differences of a real camera from its simulation must be evaluated
//! on cameras it was not built on. This crate is such a camera: a pixel written from circuit
//! equations (photocurrents, capacitances, junctions, comparators, an arbiter with rows), event by
//! event in continuous time, in front of analytic scenes. It was written independently of the
//! sensor crate of this workspace and depends on no other crate of it, which is checked in CI; its
//! formulas and parameters are its own.
//!
//! # The chain
//!
//! [`scene`] (analytic luminance) -> [`light`] (lamp, lens) -> [`pixel`] (photocurrent and dark
//! current, logarithm, pole of the photodiode node, source follower, slow feedback, noise of the
//! node, change amplifier with leak and reset, comparators with offsets and noise, time in reset)
//! -> [`background`] -> [`readout`] (arbiter or scan) -> [`clock`] -> [`event::Recording`].
//!
//! [`circuit`] holds every value in circuit units; [`catalogue`] converts them to the units
//! of a catalogue of effects and makes the labels from that.
//!
//! # The benchmark
//!
//! [`plan::Plan`] makes all cases of a seed, each with conventions ([`convention`]) beside what is
//! hidden, and no two things in one [`slot`]; a [`case::Case`] gives the data of a measurement (two
//! recordings, frames, a description) and, apart from them, its [`case::Label`]. [`evidence`]
//! decides from recordings with and without an effect whether it is visible at all.
//!
//! # Conventions
//!
//! Luminance is linear and 1 at white; thresholds and voltages inside the pixel are in natural-log
//! units of light. The amplifier is balanced at t = 0 (the reset of the whole array at the start of
//! a recording). Random numbers are addressed by seed, purpose, pixel and index ([`draw`]), so the
//! same draws serve recordings with and without an effect, on any number of threads.
//!
//! # Example
//!
//! A pixel with hidden junction leakage fires ON events in constant light:
//!
//! ```
//! use gapbench_pixel::draw::{Purpose, Sequence};
//! use gapbench_pixel::pixel::pixel_spikes;
//! use gapbench_pixel::{Circuit, Effect, Seeds};
//!
//! let seeds = Seeds { camera: 1, run: 2 };
//! let constant = |_t_s: f64| -3.0;
//! let ideal = Circuit::ideal();
//! let mut leaky = ideal.clone();
//! Effect::LeakOn.install(3, &mut leaky, &mut Sequence::new(1, Purpose::Plan, 0));
//! let count = |circuit: &Circuit| pixel_spikes(circuit, seeds, 0, 1.0, constant).len();
//! assert!(count(&leaky) > count(&ideal));
//! ```
//!
//! # Sources
//!
//! Lichtsteiner, Posch & Delbruck, IEEE JSSC 43 (2008): the pixel. Nozaki & Delbruck, IEEE TED 64
//! (2017): leakage of the reset switch and its temperature. Graca, McReynolds & Delbruck (2023):
//! noise of the photoreceptor. Suh et al., ISCAS (2020): readout by columns.

pub mod background;
pub mod camera;
pub mod case;
pub mod catalogue;
pub mod circuit;
pub mod clock;
pub mod convention;
pub mod draw;
pub mod effect;
pub mod event;
pub mod evidence;
pub mod light;
pub mod oddity;
pub mod physics;
pub mod pixel;
pub mod plan;
pub mod readout;
pub mod scene;
pub mod slot;
pub mod tier;

pub use case::{Case, CaseKind, FPS, FRAMES, Label, RecordingSetup, Truth, Which};
pub use catalogue::{Nominal, Parameter, Term, TermKind};
pub use circuit::Circuit;
pub use convention::{Convention, ConventionKind};
pub use effect::{CameraStage, EFFECTS, Effect, STRENGTHS};
pub use event::{Event, Recording};
pub use pixel::Seeds;
pub use plan::Plan;
pub use scene::{SCENE_KINDS, Scene, SceneKind};
pub use slot::Slot;
pub use tier::Tier;
