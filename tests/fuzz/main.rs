//! A short version of the fuzzing in `fuzz/`. Every target runs on its seeds, on the inputs that failed once, and on
//! mutants of both. The mutator is our own and is not guided by coverage. The targets themselves say which promises
//! they check. Needs no GPU.

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

/// The most mutants that are tried with each target.
const MUTANTS: usize = 2000;

/// No further mutants of a target are tried after this time, so that a busy machine tries fewer.
const LONGEST: Duration = Duration::from_secs(4);
/// This many mutants are tried however long they take.
const FEWEST: usize = 50;

/// The time limit of one input. It is well above what any input takes, even on a busy machine without optimisation.
const LONGEST_RUN: Duration = Duration::from_secs(20);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file of a folder with its path, or none if there is no folder.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read(&path).expect("a seed"))).collect()
}

/// The inputs that a target begins with: its own seeds, and the repository's own files of the same kind.
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

/// Runs a target in a thread of its own, so that the test can also name an input on which the target never ends.
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

    /// Waits for the thread to end. It removes its temporary files when it ends.
    fn finish(self) {
        drop(self.inputs);
        self.thread.join().expect("a thread that has passed everything");
    }

    fn run(&self, bytes: &[u8], what: &dyn Fn() -> String) {
        let name = self.target.name;
        self.inputs.send(bytes.to_vec()).expect("a thread that runs");
        match self.passed.recv_timeout(LONGEST_RUN) {
            Ok(passes) => assert!(passes, "target {name} fails for {}", what()),
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
            assert!(bytes.len() < 20_000, "{} has 20 kB or more", path.display());
            runner.run(bytes, &|| path.display().to_string());
        }
        runner.finish();
    }
    println!("{found} inputs that failed once pass");
}

/// A folder without a target has inputs that nothing runs.
#[test]
fn every_folder_belongs_to_a_target() {
    for kind in ["seeds", "regressions"] {
        for entry in std::fs::read_dir(root().join("fuzz").join(kind)).expect("a folder") {
            let name = entry.expect("an entry").file_name();
            assert!(targets::ALL.iter().any(|t| name == t.name), "fuzz/{kind}/{} belongs to no target", name.display());
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

/// Writes an input on which a target fails to a file, and returns where it is.
fn kept(target: &Target, bytes: &[u8]) -> String {
    let path = std::env::temp_dir().join(format!("cyclopean-fuzz-{}.broken", target.name));
    match std::fs::write(&path, bytes) {
        Ok(()) => format!("{}; put it into fuzz/regressions/{}/", path.display(), target.name),
        Err(error) => format!("an input that cannot be written: {error}"),
    }
}
