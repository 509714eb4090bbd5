//! Runs the commands of docs/tutorial.md in a fresh folder and compares their output with the page, which is the
//! oracle. Needs a Vulkan device. The test is skipped where the program `mos` is missing and cannot be built.
#![cfg(feature = "gpu")]

use std::path::Path;
use std::process::{Command, Output};

use crate::lab::{mos, stderr};

/// A fenced block of a page: the text behind its opening fence, and its lines.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    info: String,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let (mut found, mut open) = (Vec::new(), None::<Block>);
    for line in page.lines() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(info), None) => open = Some(Block { info: info.trim().to_owned(), text: String::new() }),
            (Some(_), Some(_)) => found.extend(open.take()),
            (None, Some(block)) => block.text += &format!("{line}\n"),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block of the page has no end");
    found
}

/// The first line of the page's output that was not printed, if there is one. The lines must come in order, and `…`
/// stands for any text.
fn missing(page: &str, printed: &str) -> Option<String> {
    let fits = |said: &str, line: &str| {
        let mut rest = line;
        said.split('…').all(|part| match rest.find(part) {
            Some(at) => {
                rest = &rest[at + part.len()..];
                true
            }
            None => false,
        })
    };
    let mut lines = printed.lines();
    let is_missing = |said: &&str| !lines.any(|line| fits(said, line));
    page.lines().filter(|said| said.trim() != "…").find(is_missing).map(str::to_owned)
}

struct Desk<'a> {
    folder: &'a Path,
    path: std::ffi::OsString,
}

impl Desk<'_> {
    fn run(&self, commands: &str) -> Output {
        Command::new("sh")
            .args(["-e", "-c", commands])
            .current_dir(self.folder)
            .env("PATH", &self.path)
            .env("XDG_CACHE_HOME", self.folder.join("cache"))
            .env("CYCLOPEAN_VALIDATION", "1")
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .expect("a shell")
    }

    /// Runs a command that needs a monitor. Its options must be understood. A session is then run with a simulated
    /// observer instead of a participant.
    fn at_a_monitor(&self, command: &str) {
        let refused = self.run(command);
        let said = stderr(&refused);
        assert!(refused.status.code() == Some(1) && said.contains("no desktop"), "{command}: {said}");
        if command.contains("--pilot") || !command.contains(" run ") {
            return;
        }
        let instead = command.replace("--display desktop --mode anaglyph", "--simulate");
        assert_ne!(instead, command, "the page's session is not written as this test expects");
        let done = self.run(&instead);
        assert!(done.status.success(), "{instead}: {}", stderr(&done));
    }
}

#[test]
fn the_tutorial_does_what_it_says() {
    let Some(mos) = mos() else { return };
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tutorial.md")).expect("a page");
    let blocks = blocks(&page);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let programs = mos.parent().expect("a folder").as_os_str().to_owned();
    let path = [programs, ":".into(), std::env::var_os("PATH").unwrap_or_default()].into_iter().collect();
    let desk = Desk { folder: folder.path(), path };

    let study = blocks.iter().find(|b| b.info == "json").expect("the study file");
    let small = study.text.replace("\"width_px\": 480, \"height_px\": 270", "\"width_px\": 32, \"height_px\": 18");
    assert_ne!(small, study.text, "the page no longer gives the stimuli's size in this form");
    std::fs::write(folder.path().join("glossy.json"), small).expect("the study file");

    let mut compared = 0;
    for (i, block) in blocks.iter().enumerate() {
        match block.info.as_str() {
            "sh" => {
                let done = desk.run(&block.text);
                let printed = String::from_utf8_lossy(&done.stdout);
                assert!(done.status.success(), "{}{printed}{}", block.text, stderr(&done));
                if let Some(said) = blocks.get(i + 1).filter(|b| b.info == "text") {
                    let missing = missing(&said.text, &printed);
                    assert!(missing.is_none(), "{}\ndoes not print\n{}\nbut\n{printed}", block.text, missing.unwrap());
                    compared += 1;
                }
            }
            "sh monitor" => block.text.lines().for_each(|command| desk.at_a_monitor(command)),
            // These are not run: commands that install something, the scripts of examples/ (which
            // analysis/tests/scripts.rs tests), and the output of real sessions.
            "sh install" | "json" | "text" | "text real" => {}
            other => panic!("this test does not know blocks of `{other}`"),
        }
    }
    assert!(compared >= 6, "only {compared} outputs were compared");
    assert!(folder.path().join("report.html").is_file() && folder.path().join("export/responses.csv").is_file());
}

#[test]
fn an_output_that_differs_is_found() {
    assert_eq!(missing("a\n…\nb … d\n", "a\nx\nb c d\n"), None);
    assert_eq!(missing("a\nb\n", "b\na\n").as_deref(), Some("b"));
    assert_eq!(missing("b … d", "b c\n").as_deref(), Some("b … d"));
    assert_eq!(blocks("x\n```sh\na\n```\n```text real\nb\n```\n").len(), 2);
}
