//! Options of every command that shows something in a window.

use clap::{Args, ValueEnum};

use crate::display::desktop::{DesktopOptions, Mode};

/// How a window shows two pictures to two eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ModeName {
    /// Each eye's picture in one half of the window: for mirror stereoscopes, or free viewing with parallel eyes.
    Sbs,
    /// Each eye's picture in one half of the window, squeezed to half its width: for 3D televisions.
    HalfSbs,
    /// As sbs with the halves exchanged: for free viewing with crossed eyes.
    Crossed,
    /// Red and cyan in one picture: for red-cyan glasses.
    Anaglyph,
    /// The left eye's picture for both eyes.
    Left,
    /// The right eye's picture for both eyes.
    Right,
}

/// Options of `--display desktop`.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Desktop")]
pub struct DeskArgs {
    /// How each eye gets its own picture.
    #[arg(long, value_enum, default_value_t = ModeName::Sbs)]
    mode: ModeName,
    /// Part of the monitor's name, or its number from 1 (`cyclopean doctor` lists them); by default the primary
    /// monitor.
    #[arg(long)]
    monitor: Option<String>,
    /// Size of the window in pixels, `WIDTHxHEIGHT`; by default it fills the monitor.
    #[arg(long, value_name = "WxH", value_parser = size)]
    window: Option<(u32, u32)>,
    /// Pixels per degree of visual angle: π/180 × viewing distance ÷ width of a pixel (40 for 0.26 mm at 60 cm).
    #[arg(long, default_value_t = 40.0, value_parser = px_per_degree)]
    px_per_degree: f32,
    /// Move both eyes' pictures apart by this many pixels, until infinity is seen far away.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    apart: i32,
    /// Show a square for a photodiode in the lower left corner: white while a stimulus is shown.
    #[arg(long)]
    patch: bool,
    /// Part of the graphics device's name; by default the best device.
    #[arg(long)]
    device: Option<String>,
}

impl DeskArgs {
    /// The options in the form that the display takes.
    pub fn options(&self) -> DesktopOptions {
        let mode = match self.mode {
            ModeName::Sbs => Mode::SideBySide,
            ModeName::HalfSbs => Mode::HalfSideBySide,
            ModeName::Crossed => Mode::Crossed,
            ModeName::Anaglyph => Mode::Anaglyph,
            ModeName::Left => Mode::LeftEye,
            ModeName::Right => Mode::RightEye,
        };
        DesktopOptions {
            mode,
            monitor: self.monitor.clone(),
            window: self.window,
            px_per_degree: self.px_per_degree,
            apart_px: self.apart,
            patch: self.patch,
            device: self.device.clone(),
            ..DesktopOptions::default()
        }
    }
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parse = |t: &str| t.parse::<u32>().ok().filter(|n| (64..=16384).contains(n));
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((parse(w)?, parse(h)?)));
    sides.ok_or_else(|| "two numbers from 64 to 16384, such as 1280x720".to_owned())
}

fn px_per_degree(text: &str) -> Result<f32, String> {
    let given = text.parse::<f32>().ok().filter(|n| (5.0..=500.0).contains(n));
    given.ok_or_else(|| "a number from 5 to 500".to_owned())
}
