//! Head poses, in a file of their own beside the journal. Motion identifies people, so poses are not kept by default,
//! never enter the journal, and are deleted with it when a participant withdraws.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use cyclopean_analysis::files;
use serde::{Deserialize, Serialize};

use super::disk::Disk;
use crate::display::HeadPose;

/// Version of the file's format, on its first line.
pub const POSES_FORMAT: u32 = 1;

/// Bytes of poses that are held back until the next sync of the journal; more are written at once.
const BUFFER: usize = 1 << 20;

/// The most bytes of a line.
pub const LONGEST_LINE: u64 = 4096;

/// A line of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseLine {
    /// The first line.
    HeadPoses { format: u32, study: String, session: String },
    /// A pose.
    Pose(HeadPose),
    /// The session was resumed, and its clock goes on from here. Poses before this line may have later times.
    Resume { t_ns: u64 },
}

/// Poses cannot be written; the session stops and can be resumed.
#[derive(Debug, thiserror::Error)]
#[error("cannot {what} head poses {}: {source}; the journal is whole. Mend the cause (space, rights), then `cyclopean run … --resume`", path.display())]
pub struct PosesError {
    what: &'static str,
    path: PathBuf,
    #[source]
    source: io::Error,
}

/// The file beside a journal: `SESSION.poses.jsonl`.
pub fn path_beside(journal: &Path) -> PathBuf {
    journal.with_extension("poses.jsonl")
}

/// Whether a path's name ends as [`path_beside`] makes it.
pub fn is_poses(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.to_string_lossy().ends_with(".poses.jsonl"))
}

/// Appends poses. A power loss can take the poses of the last few seconds, never an answer.
#[derive(Debug)]
pub struct PoseWriter {
    disk: Disk,
    file: File,
    path: PathBuf,
    buffer: Vec<u8>,
}

impl PoseWriter {
    /// Makes a new file, readable by its owner alone, with its first line.
    ///
    /// # Errors
    /// It exists already, or the folder cannot be written.
    pub fn create(disk: &Disk, journal: &Path, study: &str, session: &str) -> Result<PoseWriter, PosesError> {
        let path = path_beside(journal);
        let fail = |source| PosesError { what: "create", path: path.clone(), source };
        let file = disk.create_new(&path).map_err(fail)?;
        if let Some(parent) = path.parent() {
            disk.sync_folder(parent).map_err(fail)?;
        }
        let mut poses = PoseWriter { disk: disk.clone(), file, path, buffer: Vec::new() };
        let (study, session) = (study.to_owned(), session.to_owned());
        poses.push(&PoseLine::HeadPoses { format: POSES_FORMAT, study, session });
        poses.write_out()?;
        Ok(poses)
    }

    /// Opens the file of an earlier run to append to it. A torn last line is cut off; a missing file is made anew.
    ///
    /// # Errors
    /// It cannot be opened or repaired.
    pub fn reopen(
        disk: &Disk,
        journal: &Path,
        study: &str,
        session: &str,
        t_ns: u64,
    ) -> Result<PoseWriter, PosesError> {
        let path = path_beside(journal);
        let fail = |source| PosesError { what: "open", path: path.clone(), source };
        let mut file = match files::open_with(OpenOptions::new().read(true).append(true), &path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                return PoseWriter::create(disk, journal, study, session);
            }
            file => file.map_err(fail)?,
        };
        let length = file.metadata().map_err(fail)?.len();
        let from = length.saturating_sub(LONGEST_LINE);
        let mut tail = Vec::new();
        file.seek(SeekFrom::Start(from)).and_then(|_| file.read_to_end(&mut tail)).map_err(fail)?;
        let whole = tail.iter().rposition(|b| *b == b'\n').map_or(0, |at| from + at as u64 + 1);
        if whole < length {
            disk.truncate(&file, whole).map_err(fail)?;
        }
        let mut poses = PoseWriter { disk: disk.clone(), file, path, buffer: Vec::new() };
        if whole == 0 {
            let (study, session) = (study.to_owned(), session.to_owned());
            poses.push(&PoseLine::HeadPoses { format: POSES_FORMAT, study, session });
        }
        poses.push(&PoseLine::Resume { t_ns });
        poses.write_out()?;
        Ok(poses)
    }

    fn push(&mut self, line: &PoseLine) {
        // A line of numbers and words always has a JSON form, and a vector takes it.
        if serde_json::to_writer(&mut self.buffer, line).is_ok() {
            self.buffer.push(b'\n');
        }
    }

    /// Takes poses; those with numbers that are not finite are left out.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn take(&mut self, poses: impl IntoIterator<Item = HeadPose>) -> Result<(), PosesError> {
        poses.into_iter().filter(is_finite).for_each(|pose| self.push(&PoseLine::Pose(pose)));
        if self.buffer.len() > BUFFER { self.write_out() } else { Ok(()) }
    }

    /// Writes the poses that were held back. It is called where the journal is synced, while no stimulus is shown.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn write_out(&mut self) -> Result<(), PosesError> {
        let written = self.disk.append(&mut self.file, &self.buffer);
        self.buffer.clear();
        written.map_err(|source| PosesError { what: "write", path: self.path.clone(), source })
    }
}

fn is_finite(pose: &HeadPose) -> bool {
    pose.position.iter().chain(&pose.orientation).all(|x| x.is_finite())
}
