//! What `fuzz/` looks for at length, for a moment: every seed and everything that was ever found goes through its target, then
//! mutants of both, by a mutator of our own that is not guided by coverage. Needs no GPU.

mod mutate;
mod seeds;
mod targets;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mutate::Mutator;
use targets::Target;

/// Mutants of each target.
const MUTANTS: usize = 2000;

/// Of one target's mutants: a busy machine runs fewer, and at least so many.
const LONGEST: Duration = Duration::from_secs(4);
const FEWEST: usize = 50;

/// Well above what any input takes, for a busy machine and a build without optimisation.
const LONGEST_RUN: Duration = Duration::from_secs(20);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file of a folder, with its path; none where there is no folder.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read(&path).expect("a seed"))).collect()
}

/// Where a target begins: its own seeds, and files of this repository that are of its kind.
fn seeds_of(target: &Target) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = files(&root().join("fuzz/seeds").join(target.name));
    let (folder, extension) = match target.name {
        "study" => ("studies", "json"),
        "manifest" => ("scenes", "json"),
        "glb" => ("tests/data", "glb"),
        _ => return found,
    };
    let is_kind = |path: &Path| path.extension().is_some_and(|e| e == extension) && !path.ends_with("schema.json");
    found.extend(files(&root().join(folder)).into_iter().filter(|(path, _)| is_kind(path)));
    found
}

/// A thread that runs a target, so that an input which never ends is named too.
struct Runner<'a> {
    target: &'a Target,
    inputs: Sender<Vec<u8>>,
    passed: Receiver<bool>,
    thread: JoinHandle<()>,
}

impl Runner<'_> {
    fn new(target: &Target) -> Runner<'_> {
        let (inputs, next) = channel::<Vec<u8>>();
        let (done, passed) = channel();
        let run = target.run;
        let thread = std::thread::spawn(move || {
            for bytes in next {
                let passes = catch_unwind(AssertUnwindSafe(|| run(&bytes))).is_ok();
                if done.send(passes).is_err() {
                    break;
                }
            }
        });
        Runner { target, inputs, passed, thread }
    }

    /// Waits for the thread, which then removes its files.
    fn finish(self) {
        drop(self.inputs);
        self.thread.join().expect("a thread that has passed everything");
    }

    fn run(&self, bytes: &[u8], what: &dyn Fn() -> String) {
        let name = self.target.name;
        self.inputs.send(bytes.to_vec()).expect("a thread that runs");
        match self.passed.recv_timeout(LONGEST_RUN) {
            Ok(passes) => assert!(passes, "target {name} breaks at {}", what()),
            Err(_) => panic!("target {name} takes more than {LONGEST_RUN:?} for {}", what()),
        }
    }
}

#[test]
fn seeds_and_what_was_found_pass() {
    let mut found = 0;
    for target in &targets::ALL {
        let seeds = seeds_of(target);
        assert!(!seeds.is_empty(), "target {} has no seed", target.name);
        let regressions = files(&root().join("fuzz/regressions").join(target.name));
        found += regressions.len();
        let runner = Runner::new(target);
        for (path, bytes) in seeds.iter().chain(&regressions) {
            assert!(bytes.len() < 20_000, "{} is not small", path.display());
            runner.run(bytes, &|| path.display().to_string());
        }
        runner.finish();
    }
    println!("{found} inputs that were found pass");
}

/// A name in one of the folders that is no target's is a file that nothing runs.
#[test]
fn every_folder_belongs_to_a_target() {
    for kind in ["seeds", "regressions"] {
        for entry in std::fs::read_dir(root().join("fuzz").join(kind)).expect("a folder") {
            let name = entry.expect("an entry").file_name();
            assert!(targets::ALL.iter().any(|t| name == t.name), "fuzz/{kind}/{} is no target's", name.display());
        }
    }
}

#[test]
fn mutants_pass() {
    std::thread::scope(|scope| {
        for (number, target) in (0u64..).zip(&targets::ALL) {
            scope.spawn(move || mutants_of(target, number));
        }
    });
}

fn mutants_of(target: &Target, seed: u64) {
    let mut from: Vec<Vec<u8>> = seeds_of(target).into_iter().map(|(_, bytes)| bytes).collect();
    from.extend(files(&root().join("fuzz/regressions").join(target.name)).into_iter().map(|(_, bytes)| bytes));
    let (mut mutator, runner) = (Mutator::new(seed), Runner::new(target));
    let started = Instant::now();
    let mut done = 0;
    while done < MUTANTS && (done < FEWEST || started.elapsed() < LONGEST) {
        let bytes = mutator.mutant(&from);
        runner.run(&bytes, &|| kept(target, &bytes));
        done += 1;
    }
    runner.finish();
    println!("{:8} {done} mutants of {} inputs in {:.1} s", target.name, from.len(), started.elapsed().as_secs_f64());
}

/// Writes an input that breaks a target where it can be looked at, and gives its path.
fn kept(target: &Target, bytes: &[u8]) -> String {
    let path = std::env::temp_dir().join(format!("cyclopean-fuzz-{}.broken", target.name));
    match std::fs::write(&path, bytes) {
        Ok(()) => format!("{}; put it into fuzz/regressions/{}/", path.display(), target.name),
        Err(error) => format!("an input that cannot be written: {error}"),
    }
}
