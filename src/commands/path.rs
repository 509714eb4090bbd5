//! The path of the head that a command follows: one of the scene's, or a recorded one.

use std::io::BufReader;
use std::path::Path;

use anyhow::Context as _;
use cyclopean_analysis::files::{self, MOST_DATA};
use glam::{DQuat, DVec3};

use super::WrongUsage;
use crate::scene::{HeadKey, HeadPath, Scene, View};
use crate::study::poses::{self, LONGEST_LINE, PoseLine};

/// Frames per second of a recorded path, as in a headset.
const RECORDED_RATE_HZ: f64 = 90.0;

/// The path of this name; or the recorded path in the file of this name (`SESSION.poses.jsonl`), which then begins in
/// `view`.
///
/// # Errors
/// No such path, an unreadable file, or one with fewer than two poses.
pub fn head_path(scene: &Scene, view: &View, name: &str) -> anyhow::Result<HeadPath> {
    let file = Path::new(name);
    if poses::is_poses(file) {
        return recorded(file, view).with_context(|| format!("cannot follow the head poses in {name}"));
    }
    scene.path(name, view).map_err(|e| {
        WrongUsage(format!("{e}; or give a file of recorded head poses, which ends in .poses.jsonl")).into()
    })
}

/// Reads a recorded path. Moves and turns from the recorded head's first pose become moves and turns from the view; up
/// stays up.
fn recorded(file: &Path, view: &View) -> anyhow::Result<HeadPath> {
    let source = files::open(file)?;
    let length = source.metadata()?.len();
    anyhow::ensure!(length <= MOST_DATA, "it has {length} bytes, and at most {MOST_DATA} are read");
    let lines = files::lines(BufReader::new(source), LONGEST_LINE);
    let mut keys: Vec<HeadKey> = Vec::new();
    let mut start: Option<(DVec3, DQuat)> = None;
    for (number, line) in lines.enumerate() {
        let line = line.with_context(|| format!("line {}", number + 1))?;
        let parsed: PoseLine = serde_json::from_str(&line).with_context(|| format!("line {}", number + 1))?;
        let PoseLine::Pose(pose) = parsed else { continue };
        let position = DVec3::from_array(pose.position.map(f64::from));
        let turned = DQuat::from_array(pose.orientation.map(f64::from)).normalize();
        let (first, level) =
            *start.get_or_insert_with(|| (position, heading(view.world_from_view) * heading(turned).inverse()));
        let time_s = pose.t_ns as f64 * 1e-9;
        // After a resumed session a pose may occur twice, or earlier poses once more.
        if keys.last().is_none_or(|k| time_s > k.time_s) {
            let position = view.position + level * (position - first);
            keys.push(HeadKey { time_s, position, world_from_view: level * turned, cut: false });
        }
    }
    let name = file.file_name().map_or_else(String::new, |n| n.to_string_lossy().replace(".poses.jsonl", ""));
    Ok(HeadPath::new(&name, RECORDED_RATE_HZ, keys)?)
}

/// The part of a turn that is about the vertical axis.
fn heading(world_from_view: DQuat) -> DQuat {
    let ahead = world_from_view * DVec3::NEG_Z;
    DQuat::from_rotation_y((-ahead.x).atan2(-ahead.z))
}
