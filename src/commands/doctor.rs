//! `cyclopean doctor`: reports what this machine has, what is missing, and the command that installs it.

use std::rc::Rc;

use clap::Args as ClapArgs;
use serde::Serialize;

use crate::console::Console;
use crate::display::desktop::{ShellError, monitors};
use crate::display::openxr::Runtime;
use crate::gpu::{Gpu, GpuError, list_devices};

use super::device;

/// Report what this machine has, what is missing, and the command that installs it.
#[derive(Debug, ClapArgs)]
pub struct Args {
    /// Part of the device's name; by default the best device.
    #[arg(long)]
    device: Option<String>,
    /// Fail if only a software device renders, as on a computer or a cluster's node without a graphics card.
    #[arg(long)]
    hardware: bool,
}

/// One thing that was looked for.
#[derive(Debug, Serialize)]
struct Finding {
    what: &'static str,
    ok: bool,
    /// Whether `render`, `prepare` and `demo` need it; the rest is for displays and tests.
    needed: bool,
    found: String,
    /// The command that installs or repairs it.
    #[serde(skip_serializing_if = "Option::is_none")]
    mend: Option<&'static str>,
}

/// See [`Args`].
///
/// # Errors
/// When something that rendering needs is missing, or a graphics card that was asked for.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let gpu = device::open(args.device.as_deref());
    let card = card(gpu.as_deref().ok(), args.hardware);
    let findings = [devices(), opened(&gpu), card, validation(), openxr(), display()];
    for f in &findings {
        let word = match (f.ok, f.needed) {
            (true, _) => "ok     ",
            (false, true) => "MISSING",
            (false, false) => "absent ",
        };
        console.line(format!("{word}  {:<18} {}", f.what, f.found));
        if let Some(mend) = f.mend.filter(|_| !f.ok) {
            console.line(format!("         {:<18} {mend}", ""));
        }
    }
    // For scripts: the device that renders here, if there is one.
    let device = gpu.as_ref().ok().map(|gpu| gpu.info());
    let software = gpu.as_ref().ok().map(|gpu| gpu.is_cpu());
    console.object(&serde_json::json!({ "findings": findings, "device": device, "software": software }))?;
    match findings.iter().find(|f| f.needed && !f.ok) {
        None => Ok(()),
        Some(f) => anyhow::bail!("{}: {}; {}", f.what, f.found, f.mend.unwrap_or("see the documentation")),
    }
}

const MEND_VULKAN: &str = "apt-get install libvulkan1 mesa-vulkan-drivers (or your graphics card's own driver); without the right to install: docs/cluster.md";
const MEND_CARD: &str =
    "install the card's Vulkan driver; on a cluster ask for a card (Slurm: --gres=gpu:1) and see docs/cluster.md";

fn devices() -> Finding {
    let (ok, found) = match list_devices() {
        Ok(devices) if devices.is_empty() => (false, "a loader, but no device".to_owned()),
        Ok(devices) => {
            let names: Vec<_> = devices.iter().map(|(n, k, v)| format!("{n} ({k}, Vulkan {v})")).collect();
            (true, names.join("; "))
        }
        Err(error) => (false, error.to_string()),
    };
    Finding { what: "Vulkan devices", ok, needed: true, found, mend: Some(MEND_VULKAN) }
}

fn opened(gpu: &Result<Rc<Gpu>, GpuError>) -> Finding {
    let describe = |gpu: &Rc<Gpu>| {
        let info = gpu.info();
        let speed = if gpu.is_cpu() { ", software: pictures are kept small" } else { "" };
        let rays = if gpu.has_ray_query() { ", ray queries" } else { "" };
        format!("{} · {} · Vulkan {}{rays}{speed}", info.name, info.driver, info.vulkan)
    };
    let (ok, found) = match gpu.as_ref().map(describe) {
        Ok(found) => (true, found),
        Err(error) => (false, error.to_string()),
    };
    Finding { what: "device in use", ok, needed: true, found, mend: Some(MEND_VULKAN) }
}

/// Whether hardware renders. Software renders the same kind of pictures more slowly, and its stimuli have addresses of
/// their own.
fn card(gpu: Option<&Gpu>, needed: bool) -> Finding {
    let (ok, found) = match gpu {
        Some(gpu) if gpu.is_cpu() => {
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            let addresses = "stimuli and references are kept apart from those of graphics cards (kind `cpu`)";
            (false, format!("none in use: the processor renders, on {cores} cores; {addresses}"))
        }
        Some(gpu) => (true, format!("{} ({})", gpu.info().name, gpu.info().kind)),
        None => (false, "none, and nothing else that renders".to_owned()),
    };
    Finding { what: "graphics card", ok, needed, found, mend: Some(MEND_CARD) }
}

fn validation() -> Finding {
    let layer = [
        "/usr/share/vulkan/explicit_layer.d",
        "/etc/vulkan/explicit_layer.d",
        "/usr/local/share/vulkan/explicit_layer.d",
    ]
    .iter()
    .map(|folder| std::path::Path::new(folder).join("VkLayer_khronos_validation.json"))
    .find(|file| file.is_file());
    Finding {
        what: "validation layer",
        ok: layer.is_some(),
        needed: false,
        found: layer.map_or("only the tests need it".to_owned(), |f| f.display().to_string()),
        mend: Some("apt-get install vulkan-validationlayers"),
    }
}

fn openxr() -> Finding {
    let (ok, found, mend) = match Runtime::open() {
        Ok(runtime) => (true, format!("{} through {}", runtime.headset, runtime.name), MEND_HEADSET),
        Err(error) if error.what.contains("no OpenXR loader") => (false, error.what, MEND_LOADER),
        Err(error) => (false, error.what, MEND_HEADSET),
    };
    Finding { what: "headset (OpenXR)", ok, needed: false, found, mend: Some(mend) }
}

const MEND_LOADER: &str = "apt-get install libopenxr-loader1 (Windows: your headset's software brings it)";
const MEND_HEADSET: &str = "start your headset's software and make it the active OpenXR runtime, or set XR_RUNTIME_JSON; then connect the headset";

fn display() -> Finding {
    let mut mend = "run inside a desktop session; only the window needs it";
    let (ok, found) = match monitors() {
        Ok(monitors) if monitors.is_empty() => (false, "a desktop without a monitor".to_owned()),
        Ok(monitors) => {
            let names = (1..).zip(&monitors).map(|(i, m)| {
                let hz = m.hz.map_or("rate unknown: give --hz".to_owned(), |hz| format!("{hz:.2} Hz"));
                format!("{i}: {} {}×{}, {hz}", m.name, m.width_px, m.height_px)
            });
            (true, names.collect::<Vec<_>>().join("; "))
        }
        Err(error) => {
            if matches!(error, ShellError::NoKeyboardLibrary) {
                mend = "apt-get install libxkbcommon-x11-0 (Fedora, Arch: libxkbcommon-x11)";
            }
            let words = error.to_string();
            (false, words.split("; `cyclopean doctor`").next().unwrap_or(&words).to_owned())
        }
    };
    Finding { what: "monitors", ok, needed: false, found, mend: Some(mend) }
}
