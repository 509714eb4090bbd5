//! `cyclopean study`: checks, previews and freezes studies, and maintains journals.

use std::path::{Path, PathBuf};

use clap::Subcommand;

use super::catalogue::catalogue;
use super::find_study::find_study;
use crate::console::Console;
use crate::study::disk::Disk;
use crate::study::preview::Preview;
use crate::study::sessions::Sessions;
use crate::study::store::Store;
use crate::study::validate::{self, Study, StudyError};
use crate::study::{freeze, recover, schema, session};

/// Check, preview and freeze studies; show, recover, replay and withdraw sessions.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Check a study file; print its conditions, an order, its length, and what must be rendered.
    Check {
        /// The study: a file, or the name of a study in `studies/`.
        study: PathBuf,
        /// The folder of prepared stimuli.
        #[arg(long, default_value = "store")]
        store: PathBuf,
        /// The row whose order is printed.
        #[arg(long, default_value_t = 0)]
        row: u64,
    },
    /// Write the pre-registration: definition, hashes, all orders, planned analysis, power, and a manifest.
    Freeze {
        /// The study: a file, or the name of a study in `studies/`.
        study: PathBuf,
        /// The folder of prepared stimuli.
        #[arg(long, default_value = "store")]
        store: PathBuf,
        /// The folder to write, which must not exist yet.
        #[arg(short, long)]
        output: PathBuf,
    },
    /// Print the JSON Schema of study files.
    Schema,
    /// Derive the order of a journal again from its study and row, and check that it is equal.
    Replay {
        /// The journal.
        journal: PathBuf,
    },
    Show(super::show::Args),
    /// Set the damaged end of a journal aside; all whole lines before it stay.
    Recover {
        /// The journal.
        journal: PathBuf,
    },
    /// Give up an unfinished session: its row becomes free, and its journal stays.
    Abandon {
        /// The study: a file, or the name of a study in `studies/`.
        study: PathBuf,
        /// The participant's pseudonym.
        #[arg(long)]
        participant: String,
        /// The folder of all sessions.
        #[arg(long, default_value = "sessions")]
        sessions: PathBuf,
    },
    /// Delete all data of a participant; only a tombstone without the pseudonym stays.
    Withdraw {
        /// The study: a file, or the name of a study in `studies/`.
        study: PathBuf,
        /// The participant's pseudonym.
        #[arg(long)]
        participant: String,
        /// The folder of all sessions.
        #[arg(long, default_value = "sessions")]
        sessions: PathBuf,
    },
}

/// See [`Args`].
///
/// # Errors
/// The errors of the chosen action.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    match args.action {
        Action::Check { study, store, row } => check(&study, &store, row, console),
        Action::Freeze { study, store, output } => {
            let study = find_study(&study)?;
            refuse_unknown(&study)?;
            let manifest_sha256 = freeze::freeze(&study, &Store::new(store), &output)?;
            console.object(&serde_json::json!({"folder": output, "manifest_sha256": manifest_sha256}))?;
            console.line(format!("{}: frozen, SHA-256 of its manifest {manifest_sha256}", output.display()));
            Ok(())
        }
        Action::Schema => {
            // The schema is itself the JSON result, with and without --json.
            let text = serde_json::to_string_pretty(&schema::generate())?;
            Console::new(false).page(text);
            Ok(())
        }
        Action::Replay { journal } => {
            let proof = session::prove_order(&journal)?;
            console.object(&serde_json::json!({
                "study": proof.study, "row": proof.row, "presentations": proof.presentations, "sha256": proof.sha256,
                "equal": true,
            }))?;
            console.line(format!(
                "study {}, row {}: all {} presentations follow from study and row (SHA-256 {})",
                proof.study, proof.row, proof.presentations, proof.sha256
            ));
            Ok(())
        }
        Action::Show(args) => super::show::run(&args, console),
        Action::Recover { journal } => {
            let found = recover::recover(&Disk::real(), &journal)?;
            console.object(&serde_json::json!({
                "journal": journal, "whole_lines": found.whole_lines, "cut_bytes": found.cut_bytes,
                "whole_lines_cut": found.whole_lines_cut, "why": found.why,
            }))?;
            found.lines().iter().for_each(|line| console.line(line));
            Ok(())
        }
        Action::Abandon { study, participant, sessions } => {
            let sessions = Sessions::new(Disk::real(), &sessions, &find_study(&study)?.definition.id);
            let place = sessions.unfinished(&participant)?;
            sessions.release(&place.participant, &place.session)?;
            console.object(&serde_json::json!({"journal": place.journal, "row": place.row}))?;
            console.line(format!("session {} given up; row {} is free, the journal stays", place.session, place.row));
            Ok(())
        }
        Action::Withdraw { study, participant, sessions } => {
            let sessions = Sessions::new(Disk::real(), &sessions, &find_study(&study)?.definition.id);
            let deleted = sessions.withdraw(&participant, &session::token())?;
            console.object(&serde_json::json!({"deleted": deleted}))?;
            deleted.iter().for_each(|path| console.line(format!("deleted {}", path.display())));
            console.line(
                "Copies that this program cannot reach must be deleted by hand: exports, frozen tables, backups.",
            );
            Ok(())
        }
    }
}

fn refuse_unknown(study: &Study) -> Result<(), StudyError> {
    let problems = validate::resolve(&study.definition, &catalogue());
    if problems.is_empty() { Ok(()) } else { Err(StudyError::Invalid { path: study.path.clone(), problems }) }
}

fn check(study: &Path, store: &Path, row: u64, console: &Console) -> anyhow::Result<()> {
    let study = find_study(study)?;
    refuse_unknown(&study)?;
    let preview = Preview::new(&study.definition, &Store::new(store), row);
    console.object(&preview)?;
    preview.lines().into_iter().for_each(|line| console.line(line));
    Ok(())
}
