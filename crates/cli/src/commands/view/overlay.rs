//! People and hands drawn over a recording.

use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_core::Micros;
use evpose_io::poses::{PoseKind, PoseSequence, TimedPose, read_poses};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_task::Experiment as _;
use evpose_task::hand::{HandConfig, HandView};
use evpose_train::HandLabelTrack;
use glam::Vec2;
use image::{Rgb, RgbImage};

use super::ViewArgs;
use super::key::{Key, keys};
use evpose_report::canvas::{Canvas, PREDICTION, TRUTH};

/// Joints over time, each in a colour.
#[derive(Default)]
pub(super) struct Overlay {
    tracks: Vec<(Rgb<u8>, Track)>,
}

type ScoredPoints = (BodyPoints, [Option<f32>; BODY_JOINTS]);

/// Joints over time.
enum Track {
    /// With their scores, where there are any.
    Bodies(Vec<(Micros, ScoredPoints)>),
    Hands(Vec<(Micros, Option<[Vec2; 21]>)>),
    /// A hand that was simulated: its points follow from its pose when they are looked at.
    Simulated(Box<SimulatedHand>),
}

struct SimulatedHand {
    labels: HandLabelTrack,
    stage: HandView,
}

impl Overlay {
    /// Those of the files that were named.
    pub(super) fn open(args: &ViewArgs) -> Result<Self> {
        let mut tracks = Vec::new();
        if let Some(path) = &args.truth {
            let is_hand = path.extension().is_some_and(|extension| extension == "meta");
            let track = if is_hand {
                Track::Simulated(Box::new(SimulatedHand::open(path)?))
            } else {
                poses(path)?
            };
            tracks.push((TRUTH, track));
        }
        if let Some(path) = &args.joints {
            tracks.push((PREDICTION, poses(path)?));
        }
        Ok(Self { tracks })
    }

    /// Whether joints are drawn.
    pub(super) fn has_joints(&self) -> bool {
        !self.tracks.is_empty()
    }

    /// Keys of the colours of a frame, which may have polarities.
    pub(super) fn keys(&self, has_polarities: bool) -> Vec<Key> {
        let has = |colour| self.tracks.iter().any(|(of, _)| *of == colour);
        keys(has_polarities, has(TRUTH), has(PREDICTION))
    }

    /// Draws where they were last seen at `t`, as the file counts.
    pub(super) fn draw(&self, image: RgbImage, scale: u32, t: Micros) -> Result<RgbImage> {
        if self.tracks.is_empty() {
            return Ok(image);
        }
        let mut canvas = Canvas::over(image, scale);
        for (colour, track) in &self.tracks {
            match track {
                Track::Bodies(bodies) => {
                    if let Some((joints_px, scores)) = last(bodies, t) {
                        canvas.body(joints_px, *colour);
                        canvas.scores(joints_px, scores, *colour);
                    }
                }
                Track::Hands(hands) => {
                    last(hands, t)
                        .and_then(Option::as_ref)
                        .inspect(|points_px| canvas.hand(points_px, *colour));
                }
                Track::Simulated(hand) => {
                    hand.at(t)?.inspect(|points_px| canvas.hand(points_px, *colour));
                }
            }
        }
        Ok(canvas.into_image())
    }
}

fn last<T>(track: &[(Micros, T)], t: Micros) -> Option<&T> {
    let seen = track.partition_point(|(at, _)| *at <= t);
    seen.checked_sub(1).and_then(|last| track.get(last)).map(|(_, joints)| joints)
}

/// Poses in any format, of a person or of a hand.
fn poses(path: &Path) -> Result<Track> {
    let PoseSequence { kind, mut poses, .. } = read_poses(path)?;
    // Files need not be in order, and poses are found by bisection.
    poses.sort_by_key(|pose| pose.t);
    Ok(match kind {
        PoseKind::Body => {
            let body = |pose: &TimedPose| (pose.t, (pose.body_px(), scores(pose)));
            Track::Bodies(poses.iter().map(body).collect())
        }
        PoseKind::Hand => Track::Hands(poses.iter().map(|pose| (pose.t, pose.hand_px())).collect()),
        PoseKind::Values(layout) => {
            bail!("{}: poses of `{}`, which has no joints to draw", path.display(), layout.name)
        }
    })
}

/// Scores of the joints of a person, in the order of networks.
fn scores(pose: &TimedPose) -> [Option<f32>; BODY_JOINTS] {
    std::array::from_fn(|k| pose.joints.get(k).and_then(|joint| joint.score))
}

impl SimulatedHand {
    /// The hand of a `.meta` file, in the directory of whose config it is.
    fn open(meta: &Path) -> Result<Self> {
        let directory = match meta.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let config = directory.join("config.toml");
        let config = HandConfig::read(&config)
            .with_context(|| format!("{}: which hand and camera it is of", config.display()))?;
        Ok(Self { labels: HandLabelTrack::open(meta)?, stage: HandView::new(&config)? })
    }

    /// Its points in pixels, where all of them are before the camera.
    fn at(&self, t: Micros) -> Result<Option<[Vec2; 21]>> {
        let last = self.labels.frames().saturating_sub(1);
        // Record `k` is the pose at the end of frame `k`.
        let frame = u64::try_from(t.0.div_euclid(1_000) - 1).unwrap_or(0).min(last);
        let (pose, betas) = (self.labels.pose(frame)?, self.labels.betas_at(frame));
        let points = self.stage.points(self.labels.hand(), &pose, betas);
        Ok(points.in_front())
    }
}
