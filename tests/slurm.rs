//! Tests the job script on a real Slurm with one node, whose daemons the test starts itself. One task is killed and
//! requeued, and one runs twice. The oracle is the store of a single run. Needs a Vulkan device and Slurm (Debian:
//! slurmctld, slurmd, slurm-client, munge). Where Slurm is missing the test is skipped, with a message, unless
//! `CYCLOPEAN_REQUIRE_SLURM` is set.
#![cfg(all(feature = "gpu", target_os = "linux"))]

use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::program::{self, stderr, tree, unfinished};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cluster/cyclopean.sbatch");

/// The longest time to wait for any state, on a machine that is busy with other work.
const PATIENCE: Duration = Duration::from_secs(180);

/// A study with eight stimuli of one scene. The first takes longest to render.
const STUDY: &str = r#"{
  "format": 1, "id": "parts", "title": "Parts", "seed": 7, "participants": 4, "task": "rate",
  "instructions": "Look.", "question": "How natural?", "labels": ["not", "rather", "very"], "scale": [1, 2, 3],
  "protocol": [{ "show": "stimulus", "seconds": 2 }],
  "stimuli": { "width_px": 64, "height_px": 36, "samples": { "path-traced": 128 } },
  "conditions": { "cross": { "scene": ["room"], "method": ["path-traced", "sssr", "stereo", "stereo-no-fade",
    "stereo-no-traversal", "stereo-no-reprojection", "sssr-thickness", "one-eye"] } },
  "repetitions": 1,
  "simulation": { "latent": { "path-traced": 2, "sssr": 1, "stereo": 1, "stereo-no-fade": 1, "stereo-no-traversal": 1,
    "stereo-no-reprojection": 1, "sssr-thickness": 1, "one-eye": 1 }, "noise_sd": 0.8 }
}"#;

/// Asks until there is an answer, and panics with `what` if there is none in time.
fn wait_for<T>(what: &str, mut answer: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(answer) = answer() {
            return answer;
        }
        assert!(start.elapsed() < PATIENCE, "this did not happen in {} s: {what}", PATIENCE.as_secs());
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Finds a program on the path or in the folders for administrators' programs.
fn find(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain(["/usr/sbin", "/sbin"].map(PathBuf::from));
    folders.map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// The output of a command that tells something about this machine or user.
fn ask(name: &str, argument: &str) -> String {
    let output = Command::new(name).arg(argument).output().expect("a word");
    String::from_utf8(output.stdout).expect("UTF-8").trim().to_owned()
}

/// A Slurm with one node in a folder of its own. Its daemons are killed when this is dropped.
struct Cluster {
    folder: tempfile::TempDir,
    /// Munge, the controller and the node, in this order.
    daemons: Vec<Child>,
}

impl Cluster {
    /// Starts the cluster. Prints why and returns `None` where Slurm is not installed.
    fn start() -> Option<Cluster> {
        let programs = ["munged", "slurmctld", "slurmd"].map(|name| find(name).ok_or(name));
        if let Some(name) = programs.iter().find_map(|p| p.as_ref().err()) {
            assert!(
                std::env::var_os("CYCLOPEAN_REQUIRE_SLURM").is_none(),
                "{name} is missing, and this test is required"
            );
            println!("skipped: there is no {name} here (Debian: slurmctld, slurmd, slurm-client and munge)");
            return None;
        }
        let [munged, controller, node] = programs.map(|p| p.expect("found"));
        let folder = tempfile::tempdir().expect("a temporary folder");
        let at = |name: &str| folder.path().join(name).display().to_string();
        // Munge's socket lies in this folder, so that others must be able to enter it.
        std::fs::set_permissions(folder.path(), PermissionsExt::from_mode(0o755)).expect("permissions");
        ["state", "spool"].iter().for_each(|name| std::fs::create_dir(at(name)).expect("a folder"));
        // The key lives as long as the test and is known only in this folder.
        let key: Vec<u8> = (0..64u32).map(|i| (i.wrapping_mul(2_654_435_761) ^ std::process::id()) as u8).collect();
        std::fs::write(at("key"), key).expect("written");
        std::fs::set_permissions(at("key"), PermissionsExt::from_mode(0o400)).expect("permissions");
        // Finds two free ports.
        let listeners = [0, 1].map(|_| TcpListener::bind("127.0.0.1:0").expect("a port"));
        let [first, second] = listeners.map(|l| l.local_addr().expect("an address").port());
        let (host, user, root) = (ask("uname", "-n"), ask("id", "-un"), folder.path().display().to_string());
        let host = host.split('.').next().unwrap_or_default();
        // A requeued task waits until its credential expires, which takes at least 5 seconds.
        let configuration = format!(
            "ClusterName=trial\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser={user}\nSlurmdUser={user}\n\
             AuthType=auth/munge\nAuthInfo=socket={root}/munge.socket,cred_expire=5\n\
             SlurmctldPort={first}\nSlurmdPort={second}\n\
             StateSaveLocation={root}/state\nSlurmdSpoolDir={root}/spool\n\
             SlurmctldPidFile={root}/controller.pid\nSlurmdPidFile={root}/node.pid\n\
             SlurmctldLogFile={root}/controller.log\nSlurmdLogFile={root}/node.log\n\
             ProctrackType=proctrack/pgid\nTaskPlugin=task/none\nSelectType=select/cons_tres\n\
             SelectTypeParameters=CR_CPU\nSlurmdParameters=config_overrides\nMailProg=/bin/true\n\
             SchedulerParameters=sched_interval=1,sched_min_interval=0,batch_sched_delay=0\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=3 State=UNKNOWN\n\
             PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP\n"
        );
        std::fs::write(at("slurm.conf"), configuration).expect("written");
        let mut cluster = Cluster { folder, daemons: Vec::new() };
        let options =
            ["key-file=key", "socket=munge.socket", "pid-file=munge.pid", "log-file=munge.log", "seed-file=seed"];
        let options = options.map(|o| o.split_once('=').expect("a pair")).map(|(o, f)| format!("--{o}={root}/{f}"));
        cluster.daemon(Command::new(munged).arg("--foreground").args(options));
        wait_for("munge's socket", || cluster.path("munge.socket").exists().then_some(()));
        cluster.daemon(Command::new(controller).args(["-D", "-c", "-f"]).arg(cluster.path("slurm.conf")));
        cluster.daemon(Command::new(node).args(["-D", "-f"]).arg(cluster.path("slurm.conf")));
        wait_for("the node to be idle", || {
            (cluster.slurm("sinfo", &["-h", "-o", "%T"])?.trim() == "idle").then_some(())
        });
        Some(cluster)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn daemon(&mut self, command: &mut Command) {
        let command = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        self.daemons.push(command.spawn().expect("a daemon starts"));
    }

    /// One of Slurm's commands, to be run in the cluster's folder.
    fn command(&self, name: &str) -> Command {
        let mut command = Command::new(name);
        command.current_dir(self.folder.path()).env("SLURM_CONF", self.path("slurm.conf"));
        command.env("CYCLOPEAN", env!("CARGO_BIN_EXE_cyclopean")).env("XDG_CACHE_HOME", self.path("cache"));
        // Vulkan validation is off, because other tests render the same pictures with it.
        command.env_remove("CYCLOPEAN_VALIDATION");
        command
    }

    /// The output of one of Slurm's commands, or `None` if it fails.
    fn slurm(&self, name: &str, arguments: &[&str]) -> Option<String> {
        let output = self.command(name).args(arguments).output().expect("it starts");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// Submits the script and returns the job's number. `variables` are given as `NAME=VALUE`.
    fn submit(&self, options: &[&str], variables: &[&str]) -> String {
        let mut command = self.command("sbatch");
        command.envs(variables.iter().filter_map(|v| v.split_once('=')));
        command.arg("--parsable").args(options).arg(SCRIPT).args(["prepare", "study.json", "--store", "store"]);
        let output = command.output().expect("it starts");
        assert!(output.status.success(), "sbatch: {}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).trim().split(';').next().unwrap_or_default().to_owned()
    }

    /// The value of `key`, such as `JobState`, for each task of a job.
    fn words(&self, job: &str, key: &str) -> Vec<String> {
        let lines = self.slurm("scontrol", &["-o", "show", "job", job]).unwrap_or_default();
        let word = |line: &str| {
            line.split_whitespace().find_map(|w| w.strip_prefix(key)?.strip_prefix('=').map(str::to_owned))
        };
        lines.lines().filter_map(word).collect()
    }

    /// Kills a task of the array while it works on a stimulus, and returns its job's number.
    fn kill_one(&self, array: &str) -> String {
        wait_for("a task at work that can be killed", || {
            unfinished(&self.path("store")).iter().find_map(|part| {
                // The name is `.KEY.PID.N.part`.
                let name = part.file_name()?.to_str()?;
                let pid = name.rsplit('.').nth(2)?;
                let environment = std::fs::read(format!("/proc/{pid}/environ")).ok()?;
                let variable = |name: &str| {
                    let words = environment.split(|b| *b == 0).map(String::from_utf8_lossy);
                    words.into_iter().find_map(|w| w.strip_prefix(name).map(str::to_owned))
                };
                if variable("SLURM_ARRAY_JOB_ID=")? != array {
                    return None;
                }
                let job = variable("SLURM_JOB_ID=")?;
                Command::new("kill").args(["-KILL", pid]).status().ok().filter(|status| status.success())?;
                let state = wait_for("the killed task to end", || {
                    self.words(&job, "JobState").pop().filter(|s| !["RUNNING", "COMPLETING"].contains(&s.as_str()))
                });
                // A task that had already finished its stimulus when the signal came does not count.
                (state == "FAILED" && part.exists()).then_some(job)
            })
        })
    }

    /// The logs of the tasks and daemons, to be printed with a failure.
    fn logs(&self) -> String {
        let names = std::fs::read_dir(self.folder.path()).expect("the folder").flatten().map(|e| e.path());
        let logs = names.filter(|p| p.extension().is_some_and(|e| e == "log"));
        logs.map(|p| format!("--- {}\n{}", p.display(), String::from_utf8_lossy(&bytes(&p)))).collect()
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let _ = self.slurm("scancel", &["--me"]);
        // The node must end first and Munge last.
        for daemon in self.daemons.iter_mut().rev() {
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_default()
}

#[test]
fn an_array_with_a_killed_and_a_doubled_task_leaves_the_store_of_one_run() {
    let Some(cluster) = Cluster::start() else { return };
    let started = Instant::now();
    std::fs::write(cluster.path("study.json"), STUDY).expect("written");
    let mut alone = program::command(cluster.folder.path(), &["prepare", "study.json", "--store", "alone"]);
    let alone = alone.env_remove("CYCLOPEAN_VALIDATION").output().expect("the program starts");
    assert!(alone.status.success(), "{}", stderr(&alone));
    let single = started.elapsed();

    // The task that takes longest runs twice at the same time.
    let twice = cluster.submit(&["--array=0"], &["CYCLOPEAN_TASKS=8"]);
    let array = cluster.submit(&["--array=0-7"], &[]);
    let killed = cluster.kill_one(&array);
    assert!(cluster.slurm("scontrol", &["requeue", &killed]).is_some(), "task {killed} is not requeued");
    let merge = cluster.submit(&[&format!("--dependency=afterany:{array}:{twice}")], &[]);
    let state = wait_for("the merge to end", || {
        let ended = |s: &String| !["PENDING", "RUNNING", "COMPLETING", "CONFIGURING"].contains(&s.as_str());
        cluster.words(&merge, "JobState").pop().filter(ended)
    });
    assert_eq!(state, "COMPLETED", "{}", cluster.logs());
    let took = started.elapsed() - single;

    assert_eq!(cluster.words(&array, "JobState"), ["COMPLETED"; 8], "{}", cluster.logs());
    assert_eq!(cluster.words(&twice, "JobState"), ["COMPLETED"]);
    assert_eq!(cluster.words(&killed, "Restarts"), ["1"], "the killed task was not started again exactly once");
    let log = |job: &str| String::from_utf8_lossy(&bytes(&cluster.path(&format!("cyclopean-{job}.log")))).into_owned();
    assert!(log(&killed).contains(", try 2\n"), "{}", log(&killed));
    assert!(log(&merge).contains("8 whole, 0 rendered"), "{}", log(&merge));
    let (one, many) = (tree(&cluster.path("alone")), tree(&cluster.path("store")));
    assert_eq!(one.len(), 8 * 4, "not three files and a request for each stimulus");
    assert_eq!(one.keys().collect::<Vec<_>>(), many.keys().collect::<Vec<_>>(), "other files");
    assert!(one == many, "the store differs from that of a single run");
    println!(
        "the task that ran twice rendered something: {}; a single run took {:.1} s, and the array with its killed and \
         doubled tasks and the merge {:.1} s; {} files are equal",
        log(&twice).contains("1 rendered"),
        single.as_secs_f64(),
        took.as_secs_f64(),
        one.len()
    );
}

/// Runs the script as a task of an array, without Slurm.
fn task(variables: &[(&str, &str)], arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command.arg(SCRIPT).args(arguments).env("CYCLOPEAN", "echo").envs(variables.iter().copied());
    command.output().expect("a shell")
}

#[test]
fn the_script_says_which_part_a_task_does_or_refuses() {
    let array = |id, count, max| {
        [("SLURM_ARRAY_TASK_ID", id), ("SLURM_ARRAY_TASK_COUNT", count), ("SLURM_ARRAY_TASK_MAX", max)]
    };
    let stdout = |output: &Output| String::from_utf8_lossy(&output.stdout).into_owned();
    let done = task(&array("3", "8", "7"), &["prepare", "a study.json"]);
    assert_eq!((done.status.code(), stdout(&done).as_str()), (Some(0), "prepare a study.json --shard 3/8\n"));
    let again = [&array("3", "1", "3")[..], &[("CYCLOPEAN_TASKS", "8")]].concat();
    assert_eq!(stdout(&task(&again, &["compare", "room"])), "compare room --shard 3/8\n");
    assert_eq!(stdout(&task(&[], &["compare", "room"])), "compare room\n");
    for (variables, arguments, said) in [
        (&array("3", "1", "3")[..], &["prepare", "s"][..], "number them from 0 (--array=0-0)"),
        (&array("8", "8", "8"), &["prepare", "s"], "say in CYCLOPEAN_TASKS"),
        (&[], &["render", "room"], "the first argument is prepare or compare"),
        (&[], &[], "got ``"),
    ] {
        let refused = task(variables, arguments);
        assert_eq!((refused.status.code(), stdout(&refused).as_str()), (Some(2), ""), "{arguments:?}");
        assert!(stderr(&refused).contains(said), "{arguments:?}: {}", stderr(&refused));
    }
}
