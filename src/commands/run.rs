//! `cyclopean run`: runs one session of a study.

use std::io::{BufRead, IsTerminal, Read};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::ValueEnum;
use cyclopean_analysis::journal::record::{Kind, Outcome};
use cyclopean_analysis::terminal;

use super::WrongUsage;
use super::find_study::find_study;
use crate::console::Console;
use crate::display::DisplayInfo;
use crate::display::headless::Headless;
#[cfg(feature = "gpu")]
use crate::display::{
    Display,
    desktop::{Desktop, DesktopOptions},
    openxr::{self, OpenXr},
    operator::WithOperatorWindow,
};
#[cfg(feature = "gpu")]
use crate::study::content::content;
use crate::study::disk::Disk;
use crate::study::freeze;
use crate::study::session::{Options, Session, SessionEnd};
use crate::study::sessions::Sessions;
use crate::study::store::Store;
use crate::study::validate::{Study, is_participant_id};
use crate::study::writer::Durability;

/// Run one session of a study.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The study: a file, or the name of a study in `studies/`.
    study: PathBuf,
    /// The participant's pseudonym: 1 to 32 letters, digits, `-` and `_`.
    #[arg(long)]
    participant: String,
    /// The display that shows the session.
    #[arg(long, value_enum, default_value_t = DisplayKind::Headless)]
    display: DisplayKind,
    /// The folder of all sessions.
    #[arg(long, default_value = "sessions")]
    sessions: PathBuf,
    /// The folder of prepared stimuli.
    #[arg(long, default_value = "store")]
    store: PathBuf,
    /// Somebody tries the study out; the session is kept apart from real data.
    #[arg(long, conflicts_with = "simulate")]
    pilot: bool,
    /// A seeded simulated observer answers; the session is kept apart from real data.
    #[arg(long)]
    simulate: bool,
    /// Resume the participant's unfinished session.
    #[arg(long)]
    resume: bool,
    /// Answer the operator's questions with yes.
    #[arg(long)]
    yes: bool,
    /// Refuse to run if anything differs from this frozen study.
    #[arg(long, value_name = "FOLDER")]
    frozen: Option<PathBuf>,
    /// Refresh rate, Hz: for a headless display the rate that it pretends to have (90 by default), or the rate of a
    /// monitor that states none or a wrong one.
    #[arg(long)]
    hz: Option<f64>,
    /// Do not wait for the disk; simulated observers only.
    #[arg(long, requires = "simulate")]
    no_sync: bool,
    #[cfg(feature = "gpu")]
    #[command(flatten)]
    desk: super::desk::DeskArgs,
}

/// A headless display's rate, Hz.
const HEADLESS_HZ: f64 = 90.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DisplayKind {
    Headless,
    Desktop,
    Openxr,
}

/// See [`Args`].
///
/// # Errors
/// Wrong usage, a study or stimulus that cannot be used, or a session that can be resumed.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    check_usage(&args)?;
    let study = find_study(&args.study)?;
    let store = Store::new(&args.store);
    let kind = match (args.simulate, args.pilot) {
        (true, _) => Kind::Simulated,
        (_, true) => Kind::Pilot,
        _ => Kind::Real,
    };
    let frozen_sha256 = match &args.frozen {
        Some(folder) => Some(freeze::verify(folder, &study, &store)?),
        None => None,
    };
    let durability = if args.no_sync { Durability::Relaxed } else { Durability::Synced };
    let options = Options { kind, durability, frozen_sha256, disk: Disk::real() };
    if args.resume {
        ask_to_resume(&args, &study, console)?;
    }
    let begin = |info: &DisplayInfo| -> anyhow::Result<Session> {
        let start = if args.resume { Session::resume } else { Session::begin };
        Ok(start(&study, &store, &args.sessions, &args.participant, info, &options)?)
    };
    let ended = match args.display {
        DisplayKind::Headless => {
            let hz = args.hz.unwrap_or(HEADLESS_HZ);
            let session = begin(&Headless::information(hz))?;
            let observer = session.simulated_observer(&study)?;
            let mut display = Headless::new(hz, session.start_ns(), Box::new(observer));
            session.run(&mut display)?
        }
        #[cfg(feature = "gpu")]
        DisplayKind::Desktop => {
            let mut display = Desktop::open(DesktopOptions { hz: args.hz, ..args.desk.options() })?;
            let session = begin(display.info())?;
            let content = content(&study, session.plan(), session.setup(), kind)?;
            display.begin(content, session.start_ns())?;
            session.run(&mut display)?
        }
        #[cfg(feature = "gpu")]
        DisplayKind::Openxr => {
            let mut display = OpenXr::open()?;
            let session = begin(display.info())?;
            let content = content(&study, session.plan(), session.setup(), kind)?;
            display.begin(content.clone(), session.setup(), session.start_ns());
            console.note(openxr::KEYS);
            let mut display = WithOperatorWindow::new(display, &content);
            let ended = session.run(&mut display);
            console.note(display.display().frame_statistics().sentence());
            display.display().gpu().check_validation()?;
            ended?
        }
        #[cfg(not(feature = "gpu"))]
        other => return Err(WrongUsage(format!("--display {other:?}: this build has no such display")).into()),
    };
    report(ended, kind, console)
}

fn check_usage(args: &Args) -> anyhow::Result<()> {
    if !is_participant_id(&args.participant) {
        let id = &args.participant;
        return Err(WrongUsage(format!(
            "--participant: `{id}` is not 1 to 32 letters, digits, `-` and `_`, beginning with a letter or digit"
        ))
        .into());
    }
    if let Some(hz) = args.hz.filter(|hz| !(1.0..=1000.0).contains(hz)) {
        return Err(WrongUsage(format!("--hz: {hz} is not within 1 to 1000")).into());
    }
    match args.display {
        DisplayKind::Headless if !args.simulate => {
            Err(WrongUsage("--display headless shows nothing: add --simulate for a simulated observer".to_owned())
                .into())
        }
        DisplayKind::Headless => Ok(()),
        _ if args.simulate => {
            Err(WrongUsage("--simulate: a simulated observer answers only with `--display headless`".to_owned()).into())
        }
        _ => Ok(()),
    }
}

/// The most bytes of an answer, more than anybody types for yes or no.
const MOST_ANSWER: u64 = 4096;

/// States how long the session was interrupted, and asks whether to go on.
fn ask_to_resume(args: &Args, study: &Study, console: &Console) -> anyhow::Result<()> {
    let place = Sessions::new(Disk::real(), &args.sessions, &study.definition.id).unfinished(&args.participant)?;
    let said = match last_words(&place.journal)? {
        Some((line, minutes)) if minutes >= 0.0 => format!("its journal ends at line {line}, {minutes:.1} minutes ago"),
        Some((line, minutes)) => format!(
            "its journal ends at line {line}, {:.1} minutes in the future: the clock of this machine was set back",
            -minutes
        ),
        None => "nothing was shown yet".to_owned(),
    };
    console.note(format!("session {} of {}: {said}", place.session, place.participant));
    if args.yes {
        return Ok(());
    }
    if !std::io::stdin().is_terminal() {
        return Err(WrongUsage("--resume asks the operator; add --yes where nobody can answer".to_owned()).into());
    }
    terminal::say("Go on with it? [y/N] ");
    let mut answer = String::new();
    std::io::stdin().lock().take(MOST_ANSWER).read_line(&mut answer)?;
    anyhow::ensure!(matches!(answer.trim(), "y" | "Y" | "yes"), "not resumed; nothing was changed");
    Ok(())
}

/// The number of whole lines of a journal, and the minutes since the last one.
fn last_words(journal: &Path) -> anyhow::Result<Option<(u64, f64)>> {
    if std::fs::metadata(journal).with_context(|| format!("cannot read {}", journal.display()))?.len() == 0 {
        return Ok(None);
    }
    let mut last = None;
    for entry in cyclopean_analysis::journal::read(journal)? {
        match entry {
            Ok(entry) => last = Some((entry.seq + 1, entry.wall)),
            Err(cyclopean_analysis::journal::JournalError::Torn { .. }) => break,
            Err(error) => return Err(error.into()),
        }
    }
    Ok(last.map(|(line, wall)| (line, (chrono::Utc::now() - wall).num_milliseconds() as f64 / 60e3)))
}

fn report(ended: SessionEnd, kind: Kind, console: &Console) -> anyhow::Result<()> {
    let outcome = match ended.outcome {
        Some(Outcome::Completed) => "completed",
        Some(Outcome::Declined) => "declined",
        Some(Outcome::Screened) => "screened",
        Some(Outcome::Withdrawn) => "withdrawn",
        Some(Outcome::Abandoned) => "abandoned",
        None => "closed",
    };
    console.object(&serde_json::json!({
        "kind": kind.name(), "participant": ended.participant, "session": ended.session, "row": ended.row,
        "outcome": outcome, "journal": ended.journal, "deleted": ended.deleted,
    }))?;
    let (participant, session) = (&ended.participant, &ended.session);
    console.line(format!("{} session {session} of {participant}: {outcome}", kind.name()));
    match ended.outcome {
        None => console.line("go on with --resume"),
        Some(Outcome::Withdrawn) => console.line(format!("{} files deleted", ended.deleted.len())),
        Some(_) => console.line(format!("journal {}", ended.journal.display())),
    }
    Ok(())
}
