//! The folder of sessions, `STUDY/PARTICIPANT/SESSION.jsonl`, and the row of the order that each session has.
//!
//! A row is reserved under a lock when a session starts, and freed when the session is withdrawn or abandoned. Real,
//! pilot and simulated sessions have rows of their own. Seed and row prove an order; the state of this folder does not.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, MOST_TEXT};
use cyclopean_analysis::journal;
use cyclopean_analysis::journal::record::{Kind, Outcome, Record};
use serde::{Deserialize, Serialize};

use super::disk::Disk;
use super::poses;
use super::writer::{self, Durability, JournalWriter, WriterError};

/// What is known of a row. After a withdrawal the participant's id is removed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Reservation {
    row: u64,
    kind: Kind,
    state: RowState,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    participant: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    session: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RowState {
    /// An unfinished session has the row, whether or not it is running now.
    Reserved,
    /// The session ran to its end.
    Completed,
    /// Free for the next session.
    Released,
}

#[derive(Debug, Default, Serialize, Deserialize)]
struct Rows {
    rows: Vec<Reservation>,
}

/// The folder of sessions does not allow the request.
#[derive(Debug, thiserror::Error)]
pub enum SessionsError {
    #[error(
        "participant id `{0}` is not 1 to 32 letters, digits, `-` and `_`, beginning with a letter or digit; use a pseudonym such as p01"
    )]
    ParticipantId(String),
    #[error(
        "participant `{participant}` has an unfinished session {session} of this study; go on with --resume, or give it up with `cyclopean study abandon`"
    )]
    Unfinished { participant: String, session: String },
    #[error("participant `{participant}` has completed this study in session {session}; use another id")]
    Completed { participant: String, session: String },
    #[error("participant `{participant}` has no unfinished session of this study under {}", folder.display())]
    NothingToResume { participant: String, folder: PathBuf },
    #[error("no data of participant `{participant}` under {}", folder.display())]
    NoData { participant: String, folder: PathBuf },
    #[error("{} is damaged ({what}); restore it from a copy, or remove it: the rows are then taken from the journals themselves", path.display())]
    Damaged { path: PathBuf, what: String },
    #[error("cannot use the sessions folder at {}: {source}", path.display())]
    Io {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error(transparent)]
    Writer(#[from] WriterError),
}

/// Where a session is kept, and its row.
#[derive(Debug)]
pub struct SessionPlace {
    pub participant: String,
    pub session: String,
    pub row: u64,
    pub journal: PathBuf,
}

/// All sessions of one study.
#[derive(Debug, Clone)]
pub struct Sessions {
    disk: Disk,
    folder: PathBuf,
}

impl Sessions {
    /// `root`: the folder of all studies.
    pub fn new(disk: Disk, root: &Path, study: &str) -> Sessions {
        Sessions { disk, folder: root.join(study) }
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn io(&self) -> impl Fn(io::Error) -> SessionsError + '_ {
        |source| SessionsError::Io { path: self.folder.clone(), source }
    }

    fn locked(&self) -> Result<File, SessionsError> {
        self.disk.create_folder(&self.folder).map_err(self.io())?;
        let mut options = OpenOptions::new();
        options.create(true).append(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let file = files::open_with(&mut options, &self.folder.join(".lock")).map_err(self.io())?;
        file.lock().map_err(self.io())?;
        Ok(file)
    }

    fn rows_path(&self) -> PathBuf {
        self.folder.join("rows.json")
    }

    fn read_rows(&self) -> Result<Rows, SessionsError> {
        let path = self.rows_path();
        match files::read(&path, MOST_TEXT) {
            Ok(bytes) => {
                serde_json::from_slice(&bytes).map_err(|e| SessionsError::Damaged { path, what: e.to_string() })
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => self.rows_of_journals(),
            Err(e) => Err(self.io()(e)),
        }
    }

    /// The rows as the journals state them, for when the list is lost. A journal without a header has no row.
    fn rows_of_journals(&self) -> Result<Rows, SessionsError> {
        let mut rows = Vec::new();
        let folders = match fs::read_dir(&self.folder) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Rows::default()),
            folders => folders.map_err(self.io())?,
        };
        let mut journals = Vec::new();
        for folder in folders {
            let folder = folder.map_err(self.io())?.path();
            if folder.is_dir() {
                for file in fs::read_dir(&folder).map_err(self.io())? {
                    journals.push(file.map_err(self.io())?.path());
                }
            }
        }
        journals.retain(|p| p.extension().is_some_and(|e| e == "jsonl") && !poses::is_poses(p));
        journals.sort();
        for path in journals {
            let mut found: Option<Reservation> = None;
            for entry in journal::read(&path).map_err(WriterError::from)?.map_while(Result::ok) {
                match (entry.record, &mut found) {
                    (Record::Header(header), None) => {
                        found = Some(Reservation {
                            row: header.row,
                            kind: entry.kind,
                            state: RowState::Reserved,
                            participant: Some(header.participant),
                            session: Some(header.session),
                        });
                    }
                    (Record::End(end), Some(row)) if end.outcome == Outcome::Completed => {
                        row.state = RowState::Completed;
                    }
                    (Record::End(_), Some(row)) => row.state = RowState::Released,
                    _ => {}
                }
            }
            rows.extend(found);
        }
        Ok(Rows { rows })
    }

    fn write_rows(&self, rows: &Rows) -> Result<(), SessionsError> {
        // A list of plain structs always has a JSON text.
        let mut bytes = serde_json::to_vec_pretty(rows).unwrap_or_default();
        bytes.push(b'\n');
        self.disk.replace(&self.rows_path(), &bytes).map_err(self.io())
    }

    fn journal_path(&self, participant: &str, session: &str) -> PathBuf {
        self.folder.join(participant).join(format!("{session}.jsonl"))
    }

    /// Reserves the first free row for a new session and creates its journal, both under the lock.
    ///
    /// # Errors
    /// The id has a wrong form, the participant is known already, or the folder cannot be written.
    pub fn begin(
        &self,
        participant: &str,
        kind: Kind,
        durability: Durability,
    ) -> Result<(SessionPlace, JournalWriter), SessionsError> {
        if !super::validate::is_participant_id(participant) {
            return Err(SessionsError::ParticipantId(participant.to_owned()));
        }
        let _lock = self.locked()?;
        let mut rows = self.read_rows()?;
        // The row was reserved, but the program ended before the journal had its name.
        for row in &mut rows.rows {
            if let (RowState::Reserved, Some(p), Some(s)) = (row.state, &row.participant, &row.session)
                && !self.journal_path(p, s).exists()
            {
                (row.state, row.participant, row.session) = (RowState::Released, None, None);
            }
        }
        for row in &rows.rows {
            let (Some(p), Some(session)) = (&row.participant, &row.session) else { continue };
            if p == participant && row.state != RowState::Released {
                let (participant, session) = (p.clone(), session.clone());
                return Err(match row.state {
                    RowState::Completed => SessionsError::Completed { participant, session },
                    _ => SessionsError::Unfinished { participant, session },
                });
            }
        }
        let session = (1u32..)
            .map(|i| format!("{i:03}"))
            .find(|s| {
                let journal = self.journal_path(participant, s);
                !journal.exists() && !poses::path_beside(&journal).exists()
            })
            .unwrap_or_default();
        let taken =
            |row: u64| rows.rows.iter().any(|r| r.kind == kind && r.row == row && r.state != RowState::Released);
        let row = (0u64..).find(|&row| !taken(row)).unwrap_or(0);
        rows.rows.push(Reservation {
            row,
            kind,
            state: RowState::Reserved,
            participant: Some(participant.to_owned()),
            session: Some(session.clone()),
        });
        self.write_rows(&rows)?;
        let journal = self.journal_path(participant, &session);
        self.disk.create_folder(&self.folder.join(participant)).map_err(self.io())?;
        let writer = JournalWriter::create(self.disk.clone(), &journal, kind, durability)?;
        Ok((SessionPlace { participant: participant.to_owned(), session, row, journal }, writer))
    }

    /// The unfinished session of a participant.
    ///
    /// # Errors
    /// There is none.
    pub fn unfinished(&self, participant: &str) -> Result<SessionPlace, SessionsError> {
        let rows = self.read_rows()?;
        let of = |r: &&Reservation| r.participant.as_deref() == Some(participant) && r.state == RowState::Reserved;
        rows.rows
            .iter()
            .rev()
            .find(of)
            .and_then(|r| {
                let session = r.session.clone()?;
                let journal = self.journal_path(participant, &session);
                journal.exists().then(|| SessionPlace {
                    participant: participant.to_owned(),
                    session,
                    row: r.row,
                    journal,
                })
            })
            .ok_or_else(|| SessionsError::NothingToResume {
                participant: participant.to_owned(),
                folder: self.folder.clone(),
            })
    }

    /// Marks the session as run to its end.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn complete(&self, participant: &str, session: &str) -> Result<(), SessionsError> {
        self.mark(participant, session, RowState::Completed)
    }

    /// Frees the row of a session; the journal stays.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn release(&self, participant: &str, session: &str) -> Result<(), SessionsError> {
        self.mark(participant, session, RowState::Released)
    }

    fn mark(&self, participant: &str, session: &str, state: RowState) -> Result<(), SessionsError> {
        let _lock = self.locked()?;
        let mut rows = self.read_rows()?;
        for row in &mut rows.rows {
            if row.participant.as_deref() == Some(participant) && row.session.as_deref() == Some(session) {
                row.state = state;
            }
        }
        self.write_rows(&rows)
    }

    /// Deletes everything of a participant and leaves a tombstone without the id. Returns the deleted files.
    ///
    /// The tombstone is written first: if the program is killed in between, a second call finishes the deletion.
    ///
    /// # Errors
    /// There is no data, a session is under way, or the folder cannot be written.
    pub fn withdraw(&self, participant: &str, token: &str) -> Result<Vec<PathBuf>, SessionsError> {
        let folder = self.folder.join(participant);
        let no_data = || SessionsError::NoData { participant: participant.to_owned(), folder: self.folder.clone() };
        if !super::validate::is_participant_id(participant) || !self.folder.is_dir() {
            return Err(no_data());
        }
        let _lock = self.locked()?;
        let mut rows = self.read_rows()?;
        let is_known = rows.rows.iter().any(|r| r.participant.as_deref() == Some(participant));
        if !is_known && !folder.is_dir() {
            return Err(no_data());
        }
        let mut files: Vec<PathBuf> = Vec::new();
        if folder.is_dir() {
            for entry in fs::read_dir(&folder).map_err(self.io())? {
                files.push(entry.map_err(self.io())?.path());
            }
        }
        files.sort();
        for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "jsonl")) {
            writer::lock(&files::open(path).map_err(self.io())?, path)?;
        }
        let mut stones = Vec::new();
        for row in rows.rows.iter_mut().filter(|r| r.participant.as_deref() == Some(participant)) {
            stones.push(serde_json::json!({
                "token": token, "row": row.row, "kind": row.kind.name(),
                "withdrawn": chrono::Utc::now().to_rfc3339_opts(chrono::SecondsFormat::Secs, true),
            }));
            (row.state, row.participant, row.session) = (RowState::Released, None, None);
        }
        if !stones.is_empty() {
            let mut bytes = serde_json::to_vec_pretty(&stones).unwrap_or_default();
            bytes.push(b'\n');
            self.disk.create_folder(&self.folder.join(".withdrawn")).map_err(self.io())?;
            self.disk
                .replace(&self.folder.join(".withdrawn").join(format!("{token}.json")), &bytes)
                .map_err(self.io())?;
        }
        for file in &files {
            self.disk.remove(file).map_err(self.io())?;
        }
        if folder.is_dir() {
            fs::remove_dir(&folder).map_err(self.io())?;
        }
        self.disk.sync_folder(&self.folder).map_err(self.io())?;
        self.write_rows(&rows)?;
        Ok(files)
    }
}
