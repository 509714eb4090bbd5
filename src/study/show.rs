//! Finds out what a participant saw, from the journal alone: the stimuli of a presentation as requests to a renderer,
//! and whether a renderer makes the same bytes of them again. `study show` calls it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cyclopean_analysis::journal::record::{Header, Planned, Presentation, Record, Stimulus};
use cyclopean_analysis::journal::{Entry, JournalError};

use super::plan::Plan;
use super::session::{SessionError, prove_order};
use super::stimulus::{StimulusRenderer, StimulusRequest};
use super::store::file_sha256;
use super::writer::WriterError;

/// A journal, with everything that determines its stimuli.
#[derive(Debug)]
pub struct RecordedSession {
    pub header: Box<Header>,
    /// The stimuli as the journal records them, each with the request that it was rendered by.
    pub stimuli: Vec<(Stimulus, StimulusRequest)>,
    pub planned: Vec<Planned>,
    /// Every attempt that was shown.
    pub presentations: Vec<Presentation>,
    /// All entries of the journal.
    pub entries: Vec<Entry>,
}

/// Why a journal or a presentation cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum ShowError {
    #[error(transparent)]
    Session(#[from] SessionError),
    #[error("{}: {what}", journal.display())]
    Journal { journal: PathBuf, what: String },
    #[error(
        "{}: there is no presentation {asked}; its {} presentations are numbered from 0 to {}",
        journal.display(), of, of.saturating_sub(1)
    )]
    NoPresentation { journal: PathBuf, asked: u32, of: usize },
}

impl RecordedSession {
    /// Reads a journal whose order is proven to follow from its study and row.
    ///
    /// # Errors
    /// It cannot be read, is not whole up to its first trial, or its stimuli are not those of its study.
    pub fn read(journal: &Path) -> Result<RecordedSession, ShowError> {
        prove_order(journal)?;
        let damaged = |e: JournalError| SessionError::Writer(WriterError::Journal(e));
        let wrong = |what: &str| ShowError::Journal { journal: journal.to_owned(), what: what.to_owned() };
        let mut entries = Vec::new();
        for entry in cyclopean_analysis::journal::read(journal).map_err(damaged)? {
            entries.push(entry.map_err(damaged)?);
        }
        let (mut header, mut stimuli, mut planned, mut presentations) = (None, Vec::new(), Vec::new(), Vec::new());
        for entry in &entries {
            match &entry.record {
                Record::Header(h) => header = Some(h.clone()),
                Record::Stimulus(s) => stimuli.push(s.clone()),
                Record::Planned(p) => planned.push(p.clone()),
                Record::Presentation(p) => presentations.push(p.clone()),
                _ => {}
            }
        }
        let header = header.ok_or_else(|| wrong("it has no header"))?;
        let study = super::validate::parse(journal, header.study.text.clone()).map_err(SessionError::Study)?;
        let requests = Plan::draw(&study.definition, header.row).stimuli;
        let is_same = |(s, r): (&Stimulus, &StimulusRequest)| s.scene == r.scene && s.method == r.method;
        if requests.len() != stimuli.len() || !stimuli.iter().zip(&requests).all(is_same) {
            return Err(wrong(
                "its stimuli are not those that its study asks for: another version of this program wrote it",
            ));
        }
        let stimuli = stimuli.into_iter().zip(requests).collect();
        Ok(RecordedSession { header, stimuli, planned, presentations, entries })
    }

    /// The stimuli of a presentation, each with its role and its index: one stimulus; A and B; or reference, A and B.
    ///
    /// # Errors
    /// [`ShowError::NoPresentation`].
    pub fn of(&self, journal: &Path, presentation: u32) -> Result<Vec<(&'static str, u32)>, ShowError> {
        let planned = self.planned.iter().find(|p| p.presentation == presentation);
        let Some(planned) = planned else {
            let (journal, of) = (journal.to_owned(), self.planned.len());
            return Err(ShowError::NoPresentation { journal, asked: presentation, of });
        };
        let names: &[&str] = match planned.stimuli.len() {
            1 => &["stimulus"],
            2 => &["a", "b"],
            _ => &["reference", "a", "b"],
        };
        Ok(names.iter().copied().zip(planned.stimuli.iter().copied()).collect())
    }
}

/// A stimulus rendered again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RenderedAgain {
    /// The folder of its files.
    pub folder: PathBuf,
    /// Whether this renderer gives it the address that the journal has: the same scene, shaders, settings and kind of
    /// device.
    pub same_key: bool,
    /// Files whose bytes differ from what the participant was shown, or that are missing.
    pub differing: Vec<String>,
}

/// Renders a stimulus into `folder`, which must not exist, and compares each file's hash with the journal's.
///
/// # Errors
/// The renderer failed, or the folder cannot be written.
pub fn render_again(
    renderer: &mut dyn StimulusRenderer,
    (stimulus, request): &(Stimulus, StimulusRequest),
    folder: &Path,
) -> anyhow::Result<RenderedAgain> {
    let same_key = renderer.identity(request)? == stimulus.key;
    std::fs::create_dir_all(folder)?;
    renderer.render(request, folder)?;
    let differs = |(name, sum): &(&String, &String)| file_sha256(&folder.join(name)).ok().as_ref() != Some(*sum);
    let files: &BTreeMap<String, String> = &stimulus.files;
    let differing = files.iter().filter(differs).map(|(name, _)| name.clone()).collect();
    Ok(RenderedAgain { folder: folder.to_owned(), same_key, differing })
}
