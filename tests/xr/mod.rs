//! A real OpenXR runtime (Monado) in a root folder of its own, with a scripted head and scripted hands.
//!
//! `tests/xr/root` builds the root, and `tests/xr/inside` runs a command in it. Monado's "remote" driver receives the
//! poses of the head and the state of the controllers (Valve Index) over a TCP connection.

pub mod journal;
pub mod participant;
pub mod remote;
pub mod window;
pub mod witness;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

pub use remote::{Hands, Remote};

/// The repository's folder.
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Whether there is a root to run in. If not, prints why, or panics if `CYCLOPEAN_REQUIRE_XR` or `CI` forbids to
/// skip the test.
pub fn is_there() -> bool {
    let output = Command::new(repository().join("tests/xr/root")).arg("--check").output().expect("tests/xr/root runs");
    if output.status.success() {
        return true;
    }
    let why = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty() && v != "0");
    assert!(!["CYCLOPEAN_REQUIRE_XR", "CI"].into_iter().any(is_set), "{why}");
    eprintln!("skipped: {why}");
    false
}

/// What the compositor does with frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compositor {
    /// It shows nothing, but keeps the session's states and the pace of frames.
    Null,
    /// It shows both eyes in a window on this X display.
    Window(u32),
}

/// A running Monado service. Killed when dropped.
pub struct Service {
    pub folder: tempfile::TempDir,
    compositor: Compositor,
    child: Option<Child>,
}

impl Service {
    /// Starts the service and waits until it listens.
    pub fn start(compositor: Compositor) -> Service {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let run = folder.path().join("run");
        std::fs::create_dir_all(&run).unwrap();
        {
            use std::os::unix::fs::PermissionsExt as _;
            std::fs::set_permissions(&run, std::fs::Permissions::from_mode(0o700)).unwrap();
        }
        let config = folder.path().join("config/monado");
        std::fs::create_dir_all(&config).unwrap();
        let text = serde_json::json!({"active": "remote", "remote": {"version": 0, "port": 4242}});
        std::fs::write(config.join("config_v0.json"), text.to_string()).unwrap();
        let mut service = Service { folder, compositor, child: None };
        service.restart();
        service
    }

    /// Kills the service and starts a fresh one in its place.
    pub fn restart(&mut self) {
        self.kill();
        let socket = self.folder.path().join("run/monado_comp_ipc");
        let _ = std::fs::remove_file(&socket);
        let log = std::fs::File::options().create(true).append(true).open(self.log()).unwrap();
        let mut command = self.inside(&["monado-service"]);
        match self.compositor {
            Compositor::Null => command.env("XRT_COMPOSITOR_NULL", "1"),
            Compositor::Window(display) => {
                command.env("XRT_COMPOSITOR_FORCE_XCB", "1").env("DISPLAY", format!(":{display}"))
            }
        };
        command.env("XRT_LOG", "info").env("CYCLOPEAN_XR_NET", "own");
        // The service ends when its standard input ends.
        command.stdin(Stdio::piped()).stdout(log.try_clone().unwrap()).stderr(log);
        self.child = Some(command.spawn().expect("the service starts"));
        wait_for("the service", Duration::from_secs(20), || socket.exists().then_some(()));
    }

    /// Ends the service as a crash would.
    pub fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }

    pub fn log(&self) -> PathBuf {
        self.folder.path().join("service.log")
    }

    /// A connection that controls the head and the hands.
    pub fn remote(&self) -> Remote {
        Remote::connect(self.child.as_ref().expect("a running service").id())
    }

    /// A command that runs in the root and finds this runtime.
    pub fn inside(&self, args: &[&str]) -> Command {
        let mut command = Command::new(repository().join("tests/xr/inside"));
        let binary = Path::new(env!("CARGO_BIN_EXE_cyclopean")).parent().expect("a folder");
        command
            .args(args)
            .current_dir(self.folder.path())
            .env("CYCLOPEAN_XR_BIND", binary)
            .env("XDG_RUNTIME_DIR", self.folder.path().join("run"))
            .env("XDG_CONFIG_HOME", self.folder.path().join("config"))
            .env("XR_RUNTIME_JSON", "/usr/share/openxr/1/openxr_monado.json")
            .env("CYCLOPEAN_VALIDATION", "1")
            .env_remove("RUST_LOG");
        command
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        self.kill();
        if std::thread::panicking() {
            eprintln!("--- the service printed:\n{}", std::fs::read_to_string(self.log()).unwrap_or_default());
        }
    }
}

/// Asks until there is an answer, and panics with `what` if there is none in time.
pub fn wait_for<T>(what: &str, within: Duration, mut ask: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(begun.elapsed() < within, "this did not happen within {within:?}: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}
