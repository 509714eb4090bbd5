//! `cyclopean live`: renders a scene in real time while somebody looks around in it.

mod desktop;
mod fly_camera;
mod openxr;

use std::sync::Arc;

use clap::ValueEnum;

use super::WrongUsage;
use super::device::{self, Size};
use super::outside::OutsideArgs;
use crate::console::Console;
use crate::render::Method;
use crate::scene;

/// Explore a scene in stereo, and switch between methods.
#[derive(Debug, clap::Args)]
#[command(after_help = KEYS)]
pub struct Args {
    /// A built-in name, a manifest (.json), or a .gltf or .glb file.
    scene: String,
    #[command(flatten)]
    outside: OutsideArgs,
    /// The method to begin with, or NAME@N for N rays per pixel.
    #[arg(long, short, default_value = "stereo-temporal")]
    method: String,
    /// The view to begin at; by default the scene's first.
    #[arg(long)]
    view: Option<String>,
    /// The display that shows the scene.
    #[arg(long, value_enum, default_value_t = DisplayKind::Desktop)]
    display: DisplayKind,
    /// Pixels of one eye, WIDTHxHEIGHT; by default as many as are shown, or fewer on a software device.
    #[arg(long)]
    size: Option<Size>,
    /// End after this many frames.
    #[arg(long)]
    frames: Option<u64>,
    #[command(flatten)]
    desk: super::desk::DeskArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DisplayKind {
    Desktop,
    Openxr,
}

/// The methods that can be shown, in the order of the keys: the requested one, the same without or with the frames
/// before, and every other method.
fn methods(asked: &Method) -> Vec<Method> {
    let others = Method::names().into_iter().filter_map(|name| Method::parse(name).ok());
    let mut methods = vec![asked.clone()];
    for method in asked.without_or_with_history().into_iter().chain(others) {
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    methods
}

const KEYS: &str = "In a headset: the stick switches the method, pressed it centres the view, menu or B ends; or, typed with \
                    Enter: 1 to 9, c, r, q.\n\nAt a desk: W A S D and E Q move, Shift is faster, the mouse turns while its button is down, arrows turn; \
                    1 to 9 and Tab switch the method (2 is the first one without the frames before, or with them), V the view, R returns to it, P stops what moves, H hides the words, Esc ends.";

/// See [`Args`].
///
/// # Errors
/// Wrong usage, an unreadable scene, no desktop, no device.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let method = Method::parse(&args.method).map_err(|e| WrongUsage(e.to_string()))?;
    let scene = Arc::new(scene::load_with(&args.scene, args.outside.loading())?);
    let view = device::view(&scene, args.view.as_deref())?.clone();
    let request = desktop::LiveRequest { scene, view, method, size: args.size, frames: args.frames };
    match args.display {
        DisplayKind::Desktop => desktop::run(request, args.desk.options(), console),
        DisplayKind::Openxr => openxr::run(&request, console),
    }
}
