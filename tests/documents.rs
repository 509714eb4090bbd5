//! Checks the documentation: links must lead somewhere, the files that it names must be there, and the commands and
//! options must exist. The oracles are the repository's files and the programs' own manual pages. Needs no GPU;
//! checking commands needs a build that renders.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
#[cfg(feature = "gpu")]
use std::process::Command;

#[cfg(feature = "gpu")]
use crate::lab;

/// Options of other programs that the pages name, each with its program.
#[cfg(feature = "gpu")]
const OF_OTHERS: &[(&str, &str)] = &[
    ("--array", "sbatch"),
    ("--constraint", "sbatch"),
    ("--cpus-per-task", "sbatch"),
    ("--exclusive", "sbatch"),
    ("--gres", "sbatch"),
    ("--nv", "apptainer"),
    ("--partition", "sbatch"),
    ("--signal", "sbatch"),
    ("--time", "sbatch"),
    ("--example", "cargo"),
    ("--features", "cargo"),
    ("--ignored", "cargo's test programs"),
    ("--join", "gltf-transform"),
    ("--locked", "cargo"),
    ("--no-default-features", "cargo"),
    ("--no-deps", "cargo"),
    ("--nocapture", "cargo's test programs"),
    ("--open", "cargo"),
    ("--profile", "cargo"),
    ("--release", "cargo"),
    ("--test", "cargo"),
    ("--workspace", "cargo"),
];

/// Folders whose files the pages name from the repository's root.
const FOLDERS: &[&str] =
    &["analysis/", "docs/", "examples/", "languages/", "scenes/", "shaders/", "src/", "studies/", "tests/"];

/// The README should fit on two screens.
const MOST_LINES_OF_README: usize = 112;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every page, by its path from the root.
fn pages() -> BTreeMap<String, String> {
    let markdown = |folder: &str| -> Vec<String> {
        let entries = std::fs::read_dir(root().join(folder)).expect("a folder of pages").flatten();
        let names = entries.map(|e| e.file_name().to_string_lossy().into_owned());
        names.filter(|name| name.ends_with(".md")).map(|name| format!("{folder}{name}")).collect()
    };
    let found: Vec<String> = [markdown(""), markdown("docs/")].concat();
    assert!(found.len() > 8, "most pages were not found: {found:?}");
    let read = |page: &String| std::fs::read_to_string(root().join(page)).expect("UTF-8");
    found.iter().map(|page| (page.clone(), read(page))).collect()
}

#[track_caller]
fn none(found: Vec<String>) {
    assert!(found.is_empty(), "the documentation has errors:\n  {}", found.join("\n  "));
}

// ---- Reading Markdown ------------------------------------------------------------------------------------------

/// The targets of `[text](target)` and `![text](target)` outside of code.
fn links(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in prose(page) {
        let mut rest = line.as_str();
        while let Some(at) = rest.find("](") {
            rest = &rest[at + 2..];
            found.extend(rest.split_once(')').map(|(target, _)| target.to_owned()));
        }
    }
    found
}

/// The lines outside blocks of code, without their `inline code`.
fn prose(page: &str) -> Vec<String> {
    let mut is_fenced = false;
    let mut lines = Vec::new();
    for line in page.lines() {
        if line.starts_with("```") {
            is_fenced = !is_fenced;
        } else if !is_fenced && !line.starts_with("    ") {
            lines.push(line.split('`').step_by(2).collect());
        }
    }
    lines
}

/// The `inline code` outside blocks of code. It may go over the end of a line.
fn inline_code(page: &str) -> Vec<String> {
    let mut is_fenced = false;
    let is_kept = |line: &&str| {
        let is_fence = line.starts_with("```");
        is_fenced ^= is_fence;
        !is_fenced && !is_fence && !line.starts_with("    ")
    };
    let text = page.lines().filter(is_kept).collect::<Vec<_>>().join("\n");
    // Each paragraph is split alone. Otherwise a missing mark in one would exchange code and text in all that follow.
    text.split("\n\n").flat_map(|part| part.split('`').skip(1).step_by(2)).map(|c| c.replace('\n', " ")).collect()
}

/// The lines of indented and fenced blocks, with continued lines joined.
fn block_lines(page: &str) -> Vec<String> {
    let (mut is_fenced, mut lines, mut open) = (false, Vec::new(), None::<String>);
    for line in page.lines() {
        if line.starts_with("```") {
            is_fenced = !is_fenced;
            continue;
        }
        if !is_fenced && !line.starts_with("    ") {
            continue;
        }
        let line = format!("{}{}", open.take().unwrap_or_default(), line.trim());
        match line.strip_suffix('\\') {
            Some(begun) => open = Some(begun.to_owned()),
            None => lines.push(line),
        }
    }
    lines
}

/// The anchor that GitHub gives a heading.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    heading.to_lowercase().chars().filter(kept).map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(page: &str) -> BTreeSet<String> {
    let mut is_fenced = false;
    let headings = page.lines().filter(|line| {
        is_fenced ^= line.starts_with("```");
        !is_fenced && line.starts_with('#')
    });
    headings.map(|line| anchor(line.trim_start_matches('#').trim())).collect()
}

/// `a/{b,c}.rs` → `a/b.rs`, `a/c.rs`.
fn expanded(path: &str) -> Vec<String> {
    match path.split_once('{').and_then(|(start, rest)| Some((start, rest.split_once('}')?))) {
        None => vec![path.to_owned()],
        Some((start, (words, end))) => words.split(',').flat_map(|w| expanded(&format!("{start}{w}{end}"))).collect(),
    }
}

/// Whether there is this file or folder, or any that matches if the last part of the path has a `*`.
fn is_there(path: &str) -> bool {
    let Some((folder, name)) = path.rsplit_once('/').filter(|(_, name)| name.contains('*')) else {
        return root().join(path).exists();
    };
    let (start, end) = name.split_once('*').expect("a star");
    let entries = std::fs::read_dir(root().join(folder)).into_iter().flatten().flatten();
    let mut names = entries.map(|e| e.file_name().to_string_lossy().into_owned());
    names.any(|n| n.starts_with(start) && n.ends_with(end))
}

// ---- The programs' own words -----------------------------------------------------------------------------------

/// Each command (such as `cyclopean scene check`) with its options, from the manual pages that the programs write.
#[cfg(feature = "gpu")]
fn commands() -> BTreeMap<String, BTreeSet<String>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut programs = vec![PathBuf::from(env!("CARGO_BIN_EXE_cyclopean"))];
    programs.extend(lab::mos());
    for program in programs {
        let done = Command::new(&program).args(["man", "-o"]).arg(folder.path()).output().expect("the program starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder.path()).expect("manual pages").flatten() {
        let name = entry.file_name().to_string_lossy().trim_end_matches(".1").replace('-', " ");
        let text = std::fs::read_to_string(entry.path()).expect("a manual page").replace("\\-", "-");
        // The marks for fonts have no blank between them and the text.
        let text = ["\\fB", "\\fI", "\\fR"].iter().fold(text, |text, font| text.replace(font, " "));
        found.insert(name, options(&text));
    }
    found
}

/// The words that begin with two dashes and a letter.
fn options(text: &str) -> BTreeSet<String> {
    let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let mut found = BTreeSet::new();
    for (at, _) in text.match_indices("--") {
        let stands_alone = at == 0 || !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '-');
        let word: String = text[at..].chars().take_while(|c| is_part(*c)).collect();
        if stands_alone && word.len() > 3 && word.as_bytes()[2].is_ascii_lowercase() {
            found.insert(word.trim_end_matches('-').to_owned());
        }
    }
    found
}

/// The longest command that a line begins with, and what follows it.
#[cfg(feature = "gpu")]
fn command_of<'a>(line: &'a str, known: &BTreeMap<String, BTreeSet<String>>) -> Option<(String, &'a str)> {
    let begins = |name: &&String| line == name.as_str() || line.starts_with(&format!("{name} "));
    let name = known.keys().filter(begins).max_by_key(|name| name.len())?;
    // Text after two blanks is a remark.
    let rest = line[name.len()..].split("  ").next().unwrap_or_default();
    Some((name.clone(), rest))
}

// ---- The checks ------------------------------------------------------------------------------------------------

#[test]
fn every_link_leads_somewhere() {
    let pages = pages();
    let mut wrong = Vec::new();
    let mut checked = 0;
    for (page, text) in &pages {
        let folder = Path::new(page).parent().expect("a folder").to_owned();
        for link in links(text).into_iter().filter(|l| !l.contains("://") && !l.starts_with("mailto:")) {
            checked += 1;
            let (file, place) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { page.clone() } else { folder.join(file).to_string_lossy().into_owned() };
            let is_place = |of: &String| place.is_empty() || anchors(of).contains(place);
            if !root().join(&target).exists() || !pages.get(&target).is_none_or(is_place) {
                wrong.push(format!("{page}: ({link})"));
            }
        }
    }
    assert!(checked > 30, "only {checked} links were found on the pages, so the check misses most of them");
    none(wrong);
}

#[test]
fn every_file_that_is_named_is_there() {
    let mut wrong = Vec::new();
    let mut checked = 0;
    for (page, text) in pages() {
        for code in inline_code(&text) {
            let is_path = FOLDERS.iter().any(|f| code.starts_with(f)) && !code.contains([' ', '…']);
            for path in expanded(&code).into_iter().filter(|_| is_path) {
                checked += 1;
                if !is_there(&path) {
                    wrong.push(format!("{page}: `{path}`"));
                }
            }
        }
        // Pages may also be named without a link.
        for word in text.split(|c: char| c.is_whitespace() || "()[],;:`".contains(c)) {
            let word = word.trim_end_matches('.').split('#').next().unwrap_or_default();
            if word.starts_with("docs/") && word.ends_with(".md") && !is_there(word) {
                wrong.push(format!("{page}: {word}"));
            }
        }
    }
    assert!(checked > 80, "only {checked} named files were found on the pages, so the check misses most of them");
    none(wrong);
}

#[test]
#[cfg(feature = "gpu")]
fn every_command_and_option_exists() {
    let known = commands();
    let has_mos = known.contains_key("mos");
    let all: BTreeSet<&str> = known.values().flatten().map(String::as_str).collect();
    let mut wrong = Vec::new();
    let mut checked = 0;
    for (page, text) in pages() {
        let inline = inline_code(&text);
        for line in block_lines(&text).iter().chain(&inline) {
            let line = line.trim();
            let program = line.split(' ').next().unwrap_or_default();
            // The text that names a random stream has `\n` in it and is no command.
            let is_command = line.contains(' ') && !line.contains("\\n");
            if !is_command || !(program == "cyclopean" || program == "mos" && has_mos) {
                continue;
            }
            let second = line.split(' ').nth(1).unwrap_or_default();
            // Code of a single word, as in "`mos` reads", is no command line and was skipped above.
            let (name, rest) = command_of(line, &known).expect("the program itself is known");
            checked += 1;
            let is_global = second.starts_with("--") || second.starts_with('…');
            if name == program && !is_global {
                wrong.push(format!("{page}: `{line}`: {program} has no `{second}`"));
            }
            // `cyclopean … --shard i/n` stands for several commands.
            let is_any = second.starts_with('…');
            let has = |o: &String| if is_any { all.contains(o.as_str()) } else { known[&name].contains(o) };
            for option in options(rest).iter().filter(|o| !has(o)) {
                wrong.push(format!("{page}: `{line}`: {name} has no `{option}`"));
            }
        }
        for option in inline.iter().flat_map(|code| options(code)) {
            let is_of_another = OF_OTHERS.iter().any(|(name, _)| *name == option);
            if has_mos && !all.contains(option.as_str()) && !is_of_another {
                wrong.push(format!("{page}: no program has `{option}`"));
            }
        }
    }
    assert!(checked > 80, "only {checked} command lines were found on the pages, so the check misses most of them");
    none(wrong);
}

#[test]
fn the_readme_is_short_and_lists_every_page() {
    let pages = pages();
    let readme = &pages["README.md"];
    let lines = readme.lines().count();
    assert!(lines <= MOST_LINES_OF_README, "README.md has {lines} lines; move something to its page");
    let listed = links(readme);
    none(
        pages
            .keys()
            .filter(|p| *p != "README.md" && !listed.contains(p))
            .map(|p| format!("{p} is not listed"))
            .collect(),
    );
}

/// The code of a block `rust,ignore FILE` must be found in that file. Indentation does not matter.
#[test]
fn code_that_a_page_quotes_stands_in_its_file() {
    let lines = |text: &str| text.lines().map(|line| line.trim().to_owned()).collect::<Vec<_>>();
    let (mut wrong, mut checked) = (Vec::new(), 0);
    for (page, text) in pages() {
        for part in text.split("\n```rust,ignore ").skip(1) {
            let (file, rest) = part.split_once('\n').expect("a block");
            let quoted = lines(rest.split("\n```").next().unwrap_or_default());
            let whole = lines(&std::fs::read_to_string(root().join(file)).unwrap_or_default());
            checked += 1;
            if !whole.windows(quoted.len()).any(|window| window == quoted) {
                wrong.push(format!("{page}: {file} has no such lines: {}", quoted.join(" ")));
            }
        }
    }
    assert!(checked >= 6, "only {checked} blocks were found");
    none(wrong);
}

/// The table of methods must be the one that is made from the methods' descriptions.
#[test]
fn the_page_lists_the_methods() {
    let path = root().join("docs/rendering.md");
    let page = std::fs::read_to_string(&path).expect("a page");
    let (before, rest) = page.split_once("methods -->\n").expect("the table's beginning");
    let (_, after) = rest.split_once("<!-- end -->").expect("the table's end");
    let rows: String =
        cyclopean::method::Method::described().map(|(name, about)| format!("| `{name}` | {about} |\n")).collect();
    let renewed = format!("{before}methods -->\n\n| method | is |\n|---|---|\n{rows}\n<!-- end -->{after}");
    if std::env::var_os("CYCLOPEAN_RENEW").is_some() {
        std::fs::write(&path, &renewed).expect("the page is written");
    }
    assert!(page == renewed, "the table of methods is outdated; run this test once with CYCLOPEAN_RENEW=1");
}

// ---- The checker itself ----------------------------------------------------------------------------------------

#[test]
fn what_a_page_says_is_read() {
    let page = "# Two Words: *x*\na [b](c.md) `[no](d)` ![e](f.png)\n\n    mos table \\\n        --ci t    a remark with --dashes\n\
                ```sh\ncyclopean run --yes\n# no heading\n```\n`two\nlines` and `three`\n";
    assert_eq!(links(page), ["c.md", "f.png"]);
    assert_eq!(inline_code(page), ["[no](d)", "two lines", "three"]);
    assert_eq!(block_lines(page)[..2], ["mos table --ci t    a remark with --dashes", "cyclopean run --yes"]);
    assert_eq!(anchors(page).into_iter().collect::<Vec<_>>(), ["two-words-x"]);
    assert_eq!(expanded("a/{b,c}.{d,e}"), ["a/b.d", "a/b.e", "a/c.d", "a/c.e"]);
    assert!(is_there("src/main.rs") && is_there("docs/*.md") && !is_there("src/nothing.rs") && !is_there("src/*.x"));
    let found: Vec<String> = options("--ao-radius=2 x--no `--a` | --sheets, --").into_iter().collect();
    assert_eq!(found, ["--ao-radius", "--sheets"]);
}
