//! `mos export`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::data::Columns;
use cyclopean_analysis::export::export;
use serde_json::json;

use super::input::{Input, print, print_json};

/// `mos export PATH… -o DIR`
#[derive(Args)]
pub struct Export {
    #[command(flatten)]
    input: Input,
    /// The folder to write into
    #[arg(short, long, value_name = "DIR", default_value = "export")]
    out: PathBuf,
}

impl Export {
    /// Reads journals and writes the folder.
    pub fn run(self) -> Result<()> {
        let written = export(&self.input.paths, &self.input.selection(Columns::default()), &self.out)?;
        if self.input.json {
            print_json(&json!({ "folder": self.out, "rows": written.rows, "files": written.files }))
        } else {
            print(&format!("{}: {} answers in {} files\n", self.out.display(), written.rows, written.files.len()))
        }
    }
}
