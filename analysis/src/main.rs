//! The `mos` command.

fn main() {}
