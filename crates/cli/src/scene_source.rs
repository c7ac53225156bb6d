//! Scenes by directory, by config, or by the poses of what was seen.
//!
//! | given | light |
//! |---|---|
//! | a directory with `scene.json` | its frames |
//! | a config as `evpose simulate` takes it, `#N` behind it for sequence N | that of the sequence |
//! | a directory that `evpose simulate` wrote, with `#N` | that of its sequence N |
//! | the latter two with poses | a hand in these poses, with light and texture drawn at random |
//! | `frames` | that of the frames beside the events of a recording, see `evpose gap` |

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use evpose_core::{Plane, SensorSize};
use evpose_gap::davis::Response;
use evpose_gap::input::{LoadedScene, load_scene};
use evpose_gap::{GapError, LightSequence};
use evpose_io::MetaReader;
use evpose_pose::{HandParams, HandSide};
use evpose_sim::{SequenceInfo, Simulation};
use evpose_task::hand::HandConfig;

use crate::configs;

/// A recording without a scene.
pub(crate) const NONE: &str = "none";
/// The frames that a recording holds itself.
pub(crate) const FRAMES: &str = "frames";
/// Seconds that are rendered if the user does not say.
pub(crate) const USUAL_S: f64 = 2.0;
/// Pixels of all frames together: four seconds of a DAVIS240C at a thousand frames a second.
pub(crate) const MAX_PIXELS: f64 = 180e6;

/// A scene as it was typed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SceneSource {
    /// The directory, or the config with `#N`.
    pub(crate) path: PathBuf,
    /// Labels of what was seen; then light and texture are not those of the recording.
    pub(crate) poses: Option<PathBuf>,
    pub(crate) seconds: Option<f64>,
    /// How the frames of a recording are read.
    pub(crate) response: Option<Response>,
}

struct Sequence {
    simulation: Simulation,
    index: u64,
    /// Frames of the whole sequence, and those that are rendered.
    frames: u64,
    rendered: u64,
}

impl SceneSource {
    /// Whether it is the recording's own frames.
    pub(crate) fn is_frames(&self) -> bool {
        self.path == Path::new(FRAMES)
    }

    /// Reads or renders it.
    pub(crate) fn load(&self) -> Result<LoadedScene> {
        if self.is_frames() {
            bail!("--scene frames goes with a recording that holds frames: there is none here");
        }
        if self.response.is_some() {
            bail!("--response goes with --scene frames; light of other scenes is linear");
        }
        let Some(sequence) = self.sequence()? else {
            if self.poses.is_some() || self.seconds.is_some() {
                let what = if self.poses.is_some() { "--poses" } else { "--seconds" };
                bail!(
                    "{}: {what} goes with the config of a scene, this is a scene directory",
                    self.path.display()
                );
            }
            return Ok(load_scene(&self.path)?);
        };
        let config = sequence.simulation.config();
        let (size, fps) = (config.image_size(), f64::from(config.step_hz));
        let (planes, whole, what) = match &self.poses {
            // Poses are those of the real hand; a sequence of the config knows its own.
            Some(path) => {
                let hands = Hands::read(path, sequence.rendered)?;
                let planes = hands.light(&sequence.simulation, 0)?;
                (planes, hands.all, format!("poses of {}", path.display()))
            }
            None => {
                let planes = sequence.simulation.light(sequence.index, sequence.rendered)?;
                (planes, sequence.frames, format!("sequence {}", sequence.index))
            }
        };
        let scene = LightSequence::new(fps, planes)?;
        let mut notes = Vec::new();
        let last = scene.planes().len() as u64;
        let duration_s = whole as f64 / fps;
        // The verdict says it: an effect may not show in a part of the motion.
        if last < whole {
            notes.push(format!(
                "only the first {} s of {duration_s} s are rendered and compared (--seconds)",
                scene.duration().as_seconds()
            ));
        }
        let provenance = vec![format!(
            "{}: {what} rendered, {size}, {fps} frames per second, {last} frames",
            self.path.display()
        )];
        let frames_path = self.path.clone();
        Ok(LoadedScene { scene, nominal: None, duration_s, frames_path, provenance, notes })
    }

    /// The scene with another draw of light and texture; see [`Simulation::light_of`].
    pub(crate) fn nuisance_sample(&self, sample: u64) -> Result<LightSequence> {
        let (Some(path), Some(sequence)) = (&self.poses, self.sequence()?) else {
            bail!("{}: light and texture of a known scene do not vary", self.path.display());
        };
        let hands = Hands::read(path, sequence.rendered)?;
        // Sample 0 is the one that is compared.
        let planes = hands.light(&sequence.simulation, sample + 1)?;
        Ok(LightSequence::new(f64::from(sequence.simulation.config().step_hz), planes)?)
    }

    /// Whether what is rendered is shorter than the recording may be.
    pub(crate) fn is_rendered(&self) -> bool {
        self.config().is_some()
    }

    /// The config and the number of the sequence, unless this is a scene directory.
    fn config(&self) -> Option<(String, u64)> {
        if self.path.join("scene.json").is_file() {
            return None;
        }
        let text = self.path.to_string_lossy().into_owned();
        // A config may have many sequences: `config#3` is the fourth.
        let (name, index) = match text.rsplit_once('#') {
            Some((name, index)) => (name.to_owned(), index.parse().ok()?),
            None => (text, 0),
        };
        let path = Path::new(&name);
        // A directory of `evpose simulate` holds the config that made it.
        let written = path.join("config.toml");
        if path.is_dir() {
            return written.is_file().then(|| (written.to_string_lossy().into_owned(), index));
        }
        (path.is_file() || configs::CONFIGS.find(&name).is_some()).then_some((name, index))
    }

    fn sequence(&self) -> Result<Option<Sequence>> {
        // No config: a scene directory, unless nothing is there.
        let Some((name, index)) = self.config() else {
            if self.path == Path::new(NONE) {
                bail!("--scene none goes with `evpose gap run` alone: steps need a scene");
            }
            if !self.path.exists() {
                bail!(
                    "{}: no directory with scene.json and frames, no config of a scene, and not \
                     one of the embedded configs",
                    self.path.display()
                );
            }
            return Ok(None);
        };
        let config: HandConfig = configs::load(&name, &[])?;
        let simulation = Simulation::new(&config.simulation, config.seed)?;
        let (frames, count) = (config.simulation.frames(), config.simulation.sequences as u64);
        if index >= count {
            bail!("{name}#{index}: there are sequences 0 to {}", count - 1);
        }
        let size = config.simulation.image_size();
        let rendered = self.frames(&config.simulation, frames, size)?;
        Ok(Some(Sequence { simulation, index, frames, rendered }))
    }

    fn frames(
        &self,
        config: &evpose_sim::SimulationConfig,
        frames: u64,
        size: SensorSize,
    ) -> Result<u64> {
        let fps = f64::from(config.step_hz);
        let most = (MAX_PIXELS / size.pixels() as f64).floor();
        let wanted = match self.seconds {
            // Both ends count.
            Some(seconds) => (seconds * fps).round() + 1.0,
            None => (USUAL_S * fps).round() + 1.0,
        };
        if self.seconds.is_some() && wanted > most {
            bail!(
                "--seconds {}: no more than {:.1} s of {size} at {fps} frames per second are \
                 rendered; with a smaller simulation.image_scale they are more",
                (wanted - 1.0) / fps,
                most / fps
            );
        }
        // Light is interpolated from frame to frame, for which there have to be two.
        Ok((wanted.min(most) as u64).clamp(2, frames.max(2)))
    }
}

/// Poses of a file, and the shape that lies beside it.
struct Hands {
    side: HandSide,
    poses: Vec<HandParams>,
    betas: Vec<f32>,
    /// Poses of the whole file.
    all: u64,
}

impl Hands {
    /// The first poses, up to a change of the person.
    fn read(path: &Path, most: u64) -> Result<Self> {
        let reader = MetaReader::open(path)?;
        // Without a second episode all poses are of one person.
        let info = SequenceInfo::beside(&path.with_extension(""))?;
        let of_one_person = info.as_ref().and_then(|info| info.episodes.get(1));
        let one = of_one_person.map_or(u64::MAX, |episode| episode.first_frame);
        let count = reader.records().min(most).min(one);
        // Light between poses is interpolated, for which there have to be two.
        if count < 2 {
            return Err(anyhow!("{}: {count} poses, at least two are needed", path.display()));
        }
        let hands = reader.read_hands(0..count)?;
        let poses = hands.into_iter().map(HandParams::from_f64).collect();
        let side = info.as_ref().map_or(HandSide::Right, |info| info.hand);
        let betas = info.map_or_else(Vec::new, |info| info.betas(0).to_vec());
        Ok(Self { side, poses, betas, all: reader.records() })
    }

    fn light(&self, simulation: &Simulation, sample: u64) -> Result<Vec<Plane<f32>>> {
        Ok(simulation.light_of(self.side, &self.poses, &self.betas, sample)?)
    }
}

/// An error of a sample as one of the workflow.
pub(crate) fn as_gap_error(error: &anyhow::Error) -> GapError {
    GapError::Scene(format!("{error:#}"))
}

/// The path from the root; names of embedded configs and of what is no file stay as they are.
pub(crate) fn whole(path: &Path) -> Result<PathBuf> {
    if path == Path::new(FRAMES) {
        return Ok(path.to_owned());
    }
    let name = path.to_string_lossy();
    // The index of a sequence is no part of the name of its config.
    let name = name.split('#').next().unwrap_or_default();
    if configs::CONFIGS.find(name).is_some() && !Path::new(name).exists() {
        return Ok(path.to_owned());
    }
    std::path::absolute(path).with_context(|| path.display().to_string())
}
