//! What the operator can choose about a desktop display.

/// How each eye gets its own picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Each eye's picture fills one half of the window, with square pixels: for mirror stereoscopes, two-panel
    /// displays, and free viewing with parallel eyes.
    #[default]
    SideBySide,
    /// As side by side, but each picture is squeezed to half its width: for 3D televisions.
    HalfSideBySide,
    /// As side by side with the halves exchanged: for free viewing with crossed eyes.
    Crossed,
    /// Red and cyan in one picture: for red-cyan glasses.
    Anaglyph,
    /// One eye's picture for both eyes.
    LeftEye,
    RightEye,
}

impl Mode {
    pub const ALL: [Mode; 6] =
        [Mode::SideBySide, Mode::HalfSideBySide, Mode::Crossed, Mode::Anaglyph, Mode::LeftEye, Mode::RightEye];

    pub fn name(self) -> &'static str {
        match self {
            Mode::SideBySide => "sbs",
            Mode::HalfSideBySide => "half-sbs",
            Mode::Crossed => "crossed",
            Mode::Anaglyph => "anaglyph",
            Mode::LeftEye => "left",
            Mode::RightEye => "right",
        }
    }

    /// Size of an eye's view in a window of this size, pixels.
    pub fn view(self, (width, height): (u32, u32)) -> (u32, u32) {
        match self {
            Mode::SideBySide | Mode::Crossed => ((width / 2).max(1), height.max(1)),
            // An eye sees the whole width, at half the resolution.
            Mode::HalfSideBySide => (width.max(2) & !1, height.max(1)),
            Mode::Anaglyph | Mode::LeftEye | Mode::RightEye => (width.max(1), height.max(1)),
        }
    }

    /// Turns a place in the window into a place in an eye's view.
    pub fn place(self, [x, y]: [f32; 2], (width, _): (u32, u32)) -> [f32; 2] {
        let half = (width / 2) as f32;
        match self {
            Mode::SideBySide | Mode::Crossed => [if x >= half { x - half } else { x }, y],
            Mode::HalfSideBySide => [2.0 * if x >= half { x - half } else { x }, y],
            Mode::Anaglyph | Mode::LeftEye | Mode::RightEye => [x, y],
        }
    }

    /// Whether the eyes see different pictures.
    pub fn is_stereo(self) -> bool {
        !matches!(self, Mode::LeftEye | Mode::RightEye)
    }
}

/// The operator's choices.
#[derive(Debug, Clone, PartialEq)]
pub struct DesktopOptions {
    pub mode: Mode,
    /// Part of the monitor's name, or its number from 1; none: the primary one.
    pub monitor: Option<String>,
    /// Size of the window, pixels; none: the whole monitor.
    pub window: Option<(u32, u32)>,
    /// Pixels per degree at the viewer's distance.
    pub px_per_degree: f32,
    /// Pixels by which both eyes' pictures are moved apart.
    pub apart_px: i32,
    /// Refresh rate, Hz; none: the one that the monitor states.
    pub hz: Option<f64>,
    /// Whether a square for a photodiode is in the lower left corner: white while a stimulus is shown, else black.
    pub patch: bool,
    /// Part of the graphics device's name.
    pub device: Option<String>,
    pub title: String,
    /// Whether the window runs on a thread of its own beside a session; Linux only.
    pub is_beside: bool,
}

impl Default for DesktopOptions {
    fn default() -> DesktopOptions {
        DesktopOptions {
            mode: Mode::default(),
            monitor: None,
            window: None,
            // This fits pixels of 0.27 mm at 60 cm.
            px_per_degree: 40.0,
            apart_px: 0,
            hz: None,
            patch: false,
            device: None,
            title: "cyclopean".to_owned(),
            is_beside: false,
        }
    }
}
