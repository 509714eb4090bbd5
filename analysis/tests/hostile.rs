//! Gives `mos` hostile input. It must refuse each within a time limit and a memory limit, with one line that names the
//! file. What it prints and writes must hold nothing that a terminal, a spreadsheet, a browser or LaTeX would execute.
//! Needs a Unix with `sh` and `mkfifo`.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use cyclopean_analysis::data::{Columns, Selection, load};
use cyclopean_analysis::journal::Kind;
use tempfile::TempDir;

#[path = "../examples/journals.rs"]
#[allow(dead_code, reason = "the example's own main is not run here")]
mod journals;

/// Limit of the program's address space in KiB.
const MOST_KIB: &str = "4000000";
/// Time limit of one run, well above what any refusal takes.
const LONGEST: Duration = Duration::from_secs(30);

fn run(folder: &Path, arguments: &[&str], input: Stdio) -> Output {
    let limited = format!("ulimit -v {MOST_KIB}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &limited, env!("CARGO_BIN_EXE_mos")]).args(arguments).current_dir(folder);
    let mut child = command.stdin(input).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (out, err) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let read = |mut from: Box<dyn std::io::Read + Send>| {
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            from.read_to_end(&mut bytes).map(|_| bytes).unwrap_or_default()
        })
    };
    let (out, err) = (read(Box::new(out)), read(Box::new(err)));
    let end = Instant::now() + LONGEST;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if Instant::now() > end {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{arguments:?}: did not end within the time limit");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    Output { status, stdout: out.join().unwrap(), stderr: err.join().unwrap() }
}

fn mos(folder: &Path, arguments: &[&str]) -> Output {
    run(folder, arguments, Stdio::null())
}

fn fifo(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// Says what is wrong with a refusal, or returns `None` if it is as it should be.
fn judge(done: &Output, named: &str) -> Option<String> {
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    let fails = [
        (!matches!(done.status.code(), Some(1 | 2)), "the exit status is neither 1 nor 2"),
        (said.contains("panicked") || said.contains("allocation of"), "it panicked or could not allocate"),
        (said.lines().count() != 1, "the message is not one line"),
        (!said.starts_with("mos: "), "the message does not begin with `mos: `"),
        (!said.contains(named), "the message does not name the file"),
        (said.chars().any(|c| c.is_control() && c != '\n'), "a control character is printed"),
        (said.chars().count() > 4000, "the message is too long"),
    ];
    let wrong = fails.iter().find(|f| f.0)?;
    Some(format!("{} ({:?}): {}", wrong.1, done.status.code(), said.chars().take(300).collect::<String>()))
}

#[test]
fn hostile_files_are_refused_by_one_sentence_at_once() {
    let folder = TempDir::new().unwrap();
    let mut wrong = Vec::new();
    let mut count = 0;
    let mut check = |what: &str, name: &str, arguments: &[&str], make: &dyn Fn(&Path)| {
        let own = folder.path().join(count.to_string());
        fs::create_dir(&own).unwrap();
        make(&own.join(name));
        let arguments: Vec<&str> = arguments.iter().map(|a| if *a == "{}" { name } else { *a }).collect();
        // Some commands need a second file. It is valid, so that only the hostile one can be refused.
        fs::write(own.join("good.csv"), "participant,scene,method,rating\np1,a,x,4\np2,a,x,5\np1,a,y,3\np2,a,y,2\n")
            .unwrap();
        if let Some(reason) = judge(&mos(&own, &arguments), name) {
            wrong.push(format!("{what}: {arguments:?}: {reason}"));
        }
        count += 1;
    };
    let readers: [(&str, &[&str]); 8] = [
        ("x.csv", &["table", "{}"]),
        ("x.csv", &["report", "{}", "--format", "md"]),
        ("x.jsonl", &["table", "{}"]),
        ("x.jsonl", &["export", "{}"]),
        ("x.csv", &["wilcoxon", "{}"]),
        ("x.json", &["report", "good.csv", "--format", "md", "--metrics", "{}"]),
        ("x.png", &["report", "good.csv", "--format", "md", "--figure", "{}"]),
        ("x.csv", &["screen", "{}"]),
    ];
    for (name, arguments) in readers {
        let none: &dyn Fn(&Path) = &|_| {};
        let zero: &dyn Fn(&Path) = &|p| symlink("/dev/zero", p).unwrap();
        let hole: &dyn Fn(&Path) = &|p| fs::File::create(p).and_then(|f| f.set_len(2 << 40)).unwrap();
        let socket: &dyn Fn(&Path) = &|p| drop(std::os::unix::net::UnixListener::bind(p).unwrap());
        for (what, make) in [
            ("no file", none),
            ("a named pipe", &fifo),
            ("an endless device", zero),
            ("a socket", socket),
            ("a sparse file of 2 TiB", hole),
            ("an empty file", &|p| fs::write(p, "").unwrap()),
            ("a byte-order mark alone", &|p| fs::write(p, "\u{feff}").unwrap()),
            ("zero bytes", &|p| fs::write(p, [0; 4096]).unwrap()),
            ("invalid UTF-8", &|p| fs::write(p, [0xff; 4096]).unwrap()),
            ("a terminal's control sequences", &|p| fs::write(p, "\u{1b}[2J\u{9b}2J\n\u{1b}]0;x\u{7}\n").unwrap()),
            ("100,000 open brackets", &|p| fs::write(p, "[".repeat(100_000)).unwrap()),
        ] {
            check(what, name, arguments, make);
        }
    }
    let csv = "participant,scene,method,rating\n";
    for (what, text) in [
        ("a rating that is no number", format!("{csv}p1,a,x,NaN\n")),
        ("a rating that overflows", format!("{csv}p1,a,x,1e999\n")),
        ("an infinite rating", format!("{csv}p1,a,x,inf\n")),
        ("ratings beyond 2·10⁹", format!("{csv}p1,a,x,9e12\np1,a,x,9e12\n")),
        ("too few fields", format!("{csv}p1,a\n")),
        ("too many fields", format!("{csv}p1,a,x,4,5\n")),
        ("an empty participant", format!("{csv},a,x,4\n")),
        ("no answers", csv.to_owned()),
        ("no column for ratings", "participant,scene\np1,a\n".to_owned()),
        ("a quote mark that stays open", format!("{csv}p1,\"{}", "a,\n".repeat(1 << 20))),
        ("a row of 3 MiB", format!("{csv}p1,{},x,4\n", "a".repeat(3 << 20))),
        ("a header of 3 MiB", "a".repeat(3 << 20)),
        ("an answer given twice", "participant,method,repetition,rating\np1,x,0,4\np1,x,0,4\n".to_owned()),
        ("an unknown kind with a control sequence", "participant,kind,rating\np1,\u{1b}[2J,4\n".to_owned()),
        ("a negative repetition", "participant,repetition,rating\np1,-1,4\n".to_owned()),
        (
            "60,000 participants in as many scenes",
            (0..60_000).fold(csv.to_owned(), |text, i| text + &format!("p{i},s{i},x,4\n")),
        ),
        (
            "5,000 studies",
            (0..5000).fold("study,participant,rating\n".to_owned(), |text, i| text + &format!("s{i},p1,4\n")),
        ),
    ] {
        check(what, "x.csv", &["table", "{}"], &|p| fs::write(p, &text).unwrap());
    }
    for (what, text) in [
        ("three columns", "1,2,3\n".to_owned()),
        ("words", "1\nfour\n".to_owned()),
        ("a number that is not finite", "1\nNaN\n".to_owned()),
        ("a number that overflows", "1\n1e999\n".to_owned()),
        ("65 MiB", "1\n".repeat(33 << 20)),
    ] {
        check(what, "x.csv", &["wilcoxon", "{}"], &|p| fs::write(p, &text).unwrap());
    }
    let journal = journals::lines(0, 3, 1, Kind::Real, false).unwrap();
    let text = String::from_utf8(journal).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let joined = |lines: Vec<&str>| lines.iter().map(|l| format!("{l}\n")).collect::<String>();
    for (what, text) in [
        ("a missing line", joined([&lines[..3], &lines[4..]].concat())),
        ("a repeated line", joined([&lines[..4], &lines[3..]].concat())),
        ("lines in another order", joined([&lines[..2], &[lines[3], lines[2]], &lines[4..]].concat())),
        ("no header", joined(lines[1..].to_vec())),
        ("a changed digit", text.replacen("\"t_ns\":0", "\"t_ns\":1", 1)),
        ("two journals in one", text.repeat(2)),
        ("a torn last line", text[..text.len() - 5].to_owned()),
        ("a line of 65 MiB", "x".repeat(65 << 20)),
    ] {
        check(what, "x.jsonl", &["table", "{}"], &|p| fs::write(p, &text).unwrap());
    }
    for (what, text) in [
        ("no scenes", "{}"),
        ("a scene that is a number", "{\"scenes\": [3]}"),
        ("scenes as an object", "{\"scenes\": {}}"),
    ] {
        let arguments = ["report", "good.csv", "--format", "md", "--metrics", "{}"];
        check(what, "x.json", &arguments, &|p| fs::write(p, text).unwrap());
    }
    println!("{count} hostile inputs refused or reported");
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn an_endless_standard_input_is_refused() {
    let folder = TempDir::new().unwrap();
    for arguments in [["wilcoxon", "-"], ["table", "-"], ["screen", "-"]] {
        let done = run(folder.path(), &arguments, fs::File::open("/dev/zero").unwrap().into());
        assert_eq!(judge(&done, "-"), None, "{arguments:?}");
    }
}

/// Names that a terminal, a spreadsheet, a browser or LaTeX would execute.
const NAMES: [&str; 8] = [
    "\u{1b}[2J\u{9b}2J",
    "=HYPERLINK(\"http://x\")",
    "+1",
    "-1+1",
    "@SUM(1)",
    "<script>alert(1)</script>",
    "\\input{/etc/passwd} & % $ # [x] ```",
    "a\r\nnote: all is well | b",
];

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// A table of answers in which participants, scenes and methods have such names.
fn answers() -> String {
    let mut text = "participant,scene,method,rating\n".to_owned();
    for (i, who) in NAMES.iter().enumerate() {
        for (k, scene) in NAMES.iter().enumerate() {
            for (m, method) in ["x", "=y", "\u{1b}z"].iter().enumerate() {
                text += &format!("{},{},{},{}\n", quoted(who), quoted(scene), quoted(method), 1 + (i + k + m * 2) % 5);
            }
        }
    }
    text
}

#[test]
fn names_from_journals_are_escaped_in_every_output() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.csv"), answers()).unwrap();
    let clean = |what: &str, text: &str| {
        let hidden = text.chars().find(|c| c.is_control() && *c != '\n');
        assert_eq!(hidden, None, "{what}");
        assert!(!text.lines().any(|l| l.starts_with("note: all is well")), "{what}: a name begins a line");
    };
    for arguments in [
        &["table", "a.csv"][..],
        &["test", "a.csv", "--contrast", "method=x,=y"],
        &["screen", "a.csv"],
        &["friedman", "a.csv"],
        &["check", "a.csv"],
        &["report", "a.csv", "--format", "md"],
        &["report", "a.csv", "--format", "latex"],
        &["report", "a.csv", "--format", "csv"],
        &["report", "a.csv", "--format", "html", "--out", "a.html"],
        &["table", "a.csv", "--json"],
    ] {
        let done = mos(folder.path(), arguments);
        let text = String::from_utf8(done.stdout).unwrap();
        assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
        clean(&format!("{arguments:?}"), &text);
        match arguments.last() {
            Some(&"csv") => {
                let starts = |c: &str| c.starts_with(['=', '+', '@']) || c.starts_with("-1+");
                let mut rows = csv::ReaderBuilder::new().from_reader(text.as_bytes());
                for row in rows.records() {
                    let row = row.unwrap();
                    assert!(!row.iter().any(starts), "{row:?}");
                }
            }
            Some(&"latex") => assert!(!text.contains("\\input{") && text.contains("textbackslash{}input")),
            Some(&"md") => assert!(!text.contains("<script>")),
            _ => {}
        }
    }
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap();
    clean("html", &page.replace("\u{a0}", ""));
    assert!(!page.contains("<script>alert"), "a script in the page");
}

#[test]
fn a_table_that_was_exported_is_read_as_it_was() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, answers()).unwrap();
    let read = |path: &PathBuf| {
        load(std::slice::from_ref(path), &Selection { columns: Columns::default(), ..Selection::default() })
    };
    let before = read(&path).unwrap().data;
    // The form in which exports write each cell of text.
    let escape = |text: &str| cyclopean_analysis::escape::csv(text).into_owned();
    let mut written = csv::Writer::from_writer(Vec::new());
    for row in csv::ReaderBuilder::new().has_headers(false).from_reader(answers().as_bytes()).records() {
        written.write_record(row.unwrap().iter().map(escape)).unwrap();
    }
    fs::write(&path, written.into_inner().unwrap()).unwrap();
    let after = read(&path).unwrap().data;
    let people =
        |d: &cyclopean_analysis::data::Dataset| d.participants.iter().map(|p| p.id.clone()).collect::<Vec<_>>();
    assert_eq!(people(&before), people(&after));
    assert_eq!(before.cells, after.cells);
    assert_eq!(after.participants.len(), NAMES.len());
}

#[test]
fn a_reader_that_goes_ends_the_program_quietly() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.csv"), answers()).unwrap();
    for arguments in
        [&["table", "a.csv"][..], &["report", "a.csv", "--format", "md"], &["completions", "zsh"], &["--help"]]
    {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mos"));
        command.args(arguments).current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        drop(child.stdout.take());
        let done = child.wait_with_output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{arguments:?}");
        assert!(done.stderr.is_empty(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    }
    let mut child =
        Command::new(env!("CARGO_BIN_EXE_mos")).args(["table", "none.csv"]).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(1));
}
