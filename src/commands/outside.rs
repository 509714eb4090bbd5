//! The option of every command that loads scenes from other people.

use crate::scene::Loading;

/// Where a scene's files may lie.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct OutsideArgs {
    /// Let a glTF file, and the side-car beside it, name files outside its folder, by `..` or through a symbolic link.
    #[arg(long)]
    allow_outside: bool,
}

impl OutsideArgs {
    pub fn loading(self) -> Loading {
        Loading { allow_outside: self.allow_outside, ..Loading::default() }
    }
}
