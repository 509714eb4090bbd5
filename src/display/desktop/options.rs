//! What the operator can choose of a desktop display.

/// How each eye is given its own picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Left and right half of the window, every pixel square: mirror stereoscopes, two-panel displays, free viewing
    /// with parallel eyes.
    #[default]
    SideBySide,
    /// Each eye's picture squeezed to half its width: 3D televisions.
    HalfSideBySide,
    /// Halves exchanged: free viewing with crossed eyes.
    Crossed,
    /// Red-cyan glasses.
    Anaglyph,
    /// One eye's picture for both.
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

    /// Pixels of an eye's view in a window of this size.
    pub fn view(self, (width, height): (u32, u32)) -> (u32, u32) {
        match self {
            Mode::SideBySide | Mode::Crossed => ((width / 2).max(1), height.max(1)),
            // An eye sees the whole width, at half the resolution.
            Mode::HalfSideBySide => (width.max(2) & !1, height.max(1)),
            Mode::Anaglyph | Mode::LeftEye | Mode::RightEye => (width.max(1), height.max(1)),
        }
    }

    /// Where in an eye's view a place of the window is.
    pub fn place(self, [x, y]: [f32; 2], (width, _): (u32, u32)) -> [f32; 2] {
        let half = (width / 2) as f32;
        match self {
            Mode::SideBySide | Mode::Crossed => [if x >= half { x - half } else { x }, y],
            Mode::HalfSideBySide => [2.0 * if x >= half { x - half } else { x }, y],
            Mode::Anaglyph | Mode::LeftEye | Mode::RightEye => [x, y],
        }
    }

    /// Eyes see different pictures.
    pub fn is_stereo(self) -> bool {
        !matches!(self, Mode::LeftEye | Mode::RightEye)
    }
}

/// What the operator chose.
#[derive(Debug, Clone, PartialEq)]
pub struct DesktopOptions {
    pub mode: Mode,
    /// Part of the monitor's name, or its number from 1; none: the primary one.
    pub monitor: Option<String>,
    /// Pixels; none: the whole monitor.
    pub window: Option<(u32, u32)>,
    /// Pixels in a degree at the viewer's distance.
    pub px_per_degree: f32,
    /// Both eyes' pictures stand so many pixels further apart.
    pub apart_px: i32,
    /// Refresh rate, Hz; none: what the monitor says.
    pub hz: Option<f64>,
    /// A square in the lower left corner for a photodiode: white while a stimulus stands, else black.
    pub patch: bool,
    /// Part of the graphics device's name.
    pub device: Option<String>,
    pub title: String,
    /// The window lives on a thread of its own, beside a session; Linux only.
    pub is_beside: bool,
}

impl Default for DesktopOptions {
    fn default() -> DesktopOptions {
        DesktopOptions {
            mode: Mode::default(),
            monitor: None,
            window: None,
            // 0.27 mm pixels at 60 cm.
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
