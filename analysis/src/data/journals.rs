//! Reads sessions from their journals: verifies them, reduces them, and adds them in the order of their paths.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use serde::Serialize;

use super::{Builder, LoadedData, Response, Score, Selection, Study};
use crate::error::{Error, Result};
use crate::journal::record::{Header, Outcome, Purpose, Question};
use crate::journal::{Kind, SessionVotes, collect};

/// What a reader of a table may ask about a session. It is small, so that ten thousand fit in memory.
#[derive(Clone, Debug, Serialize)]
pub struct SessionSummary {
    /// The journal.
    pub path: PathBuf,
    /// Study id.
    pub study: String,
    /// SHA-256 of the study file it ran.
    pub study_sha256: String,
    /// Pseudonym.
    pub participant: String,
    /// Session id.
    pub session: String,
    /// Real, pilot or simulated.
    pub kind: Kind,
    /// How it ended; `None`: it has not.
    pub outcome: Option<Outcome>,
    /// Trials with an answer that counts.
    pub answers: usize,
    /// Trials that will stay without such an answer.
    pub missing: usize,
    /// Catch trials answered, and failed.
    pub catch: (u32, u32),
    /// Program, version and commit.
    pub program: String,
    /// Display kind, system and runtime.
    pub display: String,
    /// Graphics device and driver; empty without one.
    pub device: String,
}

/// A whole session, from one journal.
pub type Session = SessionVotes;

/// Reads journals on all cores and hands each session to `take` in the order of `files`.
///
/// # Errors
/// The first error in the order of the files: which file, which line, what to do; or `take`'s own.
pub fn sessions(files: &[PathBuf], mut take: impl FnMut(Session) -> Result<()>) -> Result<()> {
    sessions_in_parallel(files, read, |session| take(session?))
}

/// Runs `work` on every file on all cores and hands the results to `take` in the order of `files`.
///
/// Decoding and check sums are nine tenths of the work and run in parallel. A bounded queue keeps at most a few
/// sessions in memory.
pub(crate) fn sessions_in_parallel<T: Send, E>(
    files: &[PathBuf],
    work: impl Fn(&Path) -> T + Sync,
    mut take: impl FnMut(T) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let workers = thread::available_parallelism().map_or(1, usize::from).min(8).min(files.len());
    if workers <= 1 {
        return files.iter().try_for_each(|f| take(work(f)));
    }
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        let (send, receive) = mpsc::sync_channel(4 * workers);
        for _ in 0..workers {
            let (send, next, work) = (send.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(file) = files.get(i) else { break };
                    // The receiver is gone after an error: there is nothing left to do.
                    if send.send((i, work(file))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut waiting = BTreeMap::new();
        let mut due = 0;
        for (i, done) in receive {
            waiting.insert(i, done);
            while let Some(done) = waiting.remove(&due) {
                take(done)?;
                due += 1;
            }
        }
        Ok(())
    })
}

fn read(path: &Path) -> Result<Session> {
    collect(path).map_err(|e| Error::data(e.to_string()))
}

/// Adds the sessions of `files` to `builder` and their summaries to `loaded`.
pub(super) fn load(
    files: &[PathBuf],
    selection: &Selection,
    builder: &mut Builder,
    loaded: &mut LoadedData,
) -> Result<()> {
    sessions(files, |session| add(&session, selection, builder, loaded))
}

fn add(session: &Session, selection: &Selection, builder: &mut Builder, loaded: &mut LoadedData) -> Result<()> {
    let header = &session.header;
    if !builder.wants(&header.study.id, &header.participant, Some(session.kind)) {
        return Ok(());
    }
    let summary = summary(session);
    if session.outcome == Some(Outcome::Withdrawn) {
        builder.note(format!("participant {} withdrew: their answers are not used", header.participant));
        loaded.sessions.push(summary);
        return Ok(());
    }
    builder.study(study(header));
    for vote in session.votes.iter().filter(|v| v.purpose == Purpose::Trial) {
        let rating = Score::whole(vote.rating);
        let Some(levels) = session.factors(vote) else { continue };
        let texts = (vote.repetition.to_string(), rating.to_string());
        let mut factors: Vec<(&str, &str)> = levels.iter().map(|(n, l)| (n.as_str(), l.as_str())).collect();
        if selection.columns.by_repetition {
            factors.push(("repetition", &texts.0));
        }
        if selection.columns.by_rating {
            factors.push(("rating", &texts.1));
        }
        let response = Response {
            participant: &header.participant,
            study: &header.study.id,
            kind: Some(session.kind),
            factors: &factors,
            repetition: Some(vote.repetition),
            rating,
        };
        builder.add(&response).map_err(|what| Error::data(format!("{}: {what}", session.path.display())))?;
    }
    if session.outcome != Some(Outcome::Completed) {
        let how = session.outcome.map_or("not ended", outcome_name);
        builder.note(format!(
            "session {} of participant {} is {how} after {} answers; rows use the votes there are",
            header.session, header.participant, summary.answers
        ));
    }
    if let Some(rule) = header.analysis.exclusion
        && summary.catch.1 >= rule.failed_catch_trials
    {
        let reason = format!(
            "failed {} of {} catch trials (rule: {} or more)",
            summary.catch.1, summary.catch.0, rule.failed_catch_trials
        );
        loaded.excluded.push((header.participant.clone(), reason));
    }
    if let Some(other) =
        loaded.sessions.iter().rfind(|s| s.study == summary.study).filter(|s| s.study_sha256 != summary.study_sha256)
    {
        builder.note(format!(
            "study {} has several versions: {} ran another file than {}",
            summary.study,
            summary.path.display(),
            other.path.display()
        ));
    }
    loaded.sessions.push(summary);
    Ok(())
}

fn summary(session: &Session) -> SessionSummary {
    let header = &session.header;
    let catch = session.votes.iter().filter_map(|v| v.passed);
    SessionSummary {
        path: session.path.clone(),
        study: header.study.id.clone(),
        study_sha256: header.study.sha256.clone(),
        participant: header.participant.clone(),
        session: header.session.clone(),
        kind: session.kind,
        outcome: session.outcome,
        answers: session.votes.iter().filter(|v| v.purpose == Purpose::Trial).count(),
        missing: session.missing.len(),
        catch: (catch.clone().count() as u32, catch.filter(|p| !p).count() as u32),
        program: format!("{} {} ({})", header.program.name, header.program.version, header.program.commit),
        display: format!("{}: {}, {}", header.display.kind, header.display.system, header.display.runtime),
        device: header
            .device
            .as_ref()
            .map(|d| format!("{}, {}, Vulkan {}", d.gpu, d.driver, d.vulkan))
            .unwrap_or_default(),
    }
}

fn study(header: &Header) -> Study {
    let (scale, forced_choice) = match &header.question {
        Question::Rate { options } => (options.iter().map(|o| (o.value, o.label.clone())).collect(), false),
        Question::Compare { values } => {
            let words = |s: &str| s.to_owned();
            let mut scale = vec![
                (values.other, words("other better")),
                (values.same, words("imperceptible")),
                (values.method, words("method better")),
            ];
            scale.sort_unstable();
            (scale, true)
        }
    };
    Study {
        id: header.study.id.clone(),
        title: Some(header.study.title.clone()),
        sha256: Some(header.study.sha256.clone()),
        text: Some(header.study.text.clone()),
        scale,
        forced_choice,
        plan: Some(header.analysis.clone()),
    }
}

/// The outcome's word.
pub(crate) fn outcome_name(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::Declined => "declined",
        Outcome::Screened => "screened out",
        Outcome::Withdrawn => "withdrawn",
        Outcome::Abandoned => "abandoned",
    }
}
