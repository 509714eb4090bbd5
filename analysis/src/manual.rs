//! Shell completions and manual pages, made from a program's own definition of its command line.

use std::path::{Path, PathBuf};

use clap::Command;
pub use clap_complete::Shell;

use crate::files::{WriteError, write_whole};
use crate::terminal;

/// Options of the command `completions`.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Completions {
    /// The shell that the script is for
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Prints the script that completes `command`'s subcommands and options.
    ///
    /// # Errors
    /// What the system says of standard output.
    pub fn print(self, mut command: Command) -> std::io::Result<()> {
        let (name, mut script) = (command.get_name().to_owned(), Vec::new());
        clap_complete::generate(self.shell, &mut command, name, &mut script);
        terminal::print(&String::from_utf8_lossy(&script))
    }
}

/// Options of the command `man`.
#[derive(Clone, Debug, clap::Args)]
pub struct Manual {
    /// Folder for the pages; made when missing
    #[arg(long, short, value_name = "DIR", default_value = "man")]
    out: PathBuf,
}

impl Manual {
    /// Writes `NAME.1`, and `NAME-SUBCOMMAND.1` for each subcommand, and returns their paths.
    ///
    /// # Errors
    /// [`WriteError`] with the page that could not be written.
    pub fn write(&self, mut command: Command) -> Result<Vec<PathBuf>, WriteError> {
        std::fs::create_dir_all(&self.out).map_err(|source| WriteError { path: self.out.clone(), source })?;
        command.build();
        let mut written = Vec::new();
        let source = format!("{} {}", command.get_name(), command.get_version().unwrap_or_default());
        page(&self.out, &command, command.get_name(), &source, &mut written)?;
        Ok(written)
    }
}

fn page(
    folder: &Path,
    command: &Command,
    name: &str,
    source: &str,
    written: &mut Vec<PathBuf>,
) -> Result<(), WriteError> {
    let path = folder.join(format!("{name}.1"));
    write_whole(&path, |mut out| clap_mangen::Man::new(command.clone()).source(source).render(&mut out))?;
    written.push(path);
    let mut subcommands = command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set());
    subcommands.try_for_each(|c| page(folder, c, &format!("{name}-{}", c.get_name()), source, written))
}
