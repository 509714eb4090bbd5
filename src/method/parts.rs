//! What a method is made of, each part a choice.

/// What the percentage at the end of a method's name sets (`stereo-hybrid-25`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knob {
    /// Share of the rays that the views lose which may ask the scene's geometry; 100 by default. At 0 the method is the
    /// same without geometry.
    LostRays,
    /// Weber contrast between the eyes, relative to the pixel's composite luminance, below which no work is done in
    /// the other eye; 2 by default (seed 001: Walter et al. 2005).
    Weber,
}

impl Knob {
    /// Thousandths of a per cent.
    pub(super) fn default_value(self) -> u32 {
        match self {
            Knob::LostRays => 100_000,
            Knob::Weber => 2_000,
        }
    }
}

/// How the taps of the spatial reuse are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Reuse {
    /// Multiple-importance weights: the balance heuristic between the pixel's own density and each tap's (pairwise, as
    /// in Bitterli 2022), bright outliers bounded, and the eyes blended by their variances.
    #[default]
    Balance,
    /// The published ratio estimator (Stachowiak 2015): each tap over its own density, nothing bounded, and the eyes
    /// blended by fixed weights.
    Ratio,
}

/// How the light of a pair of pixels is blended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blend {
    /// By squared bias and both variances (seed 003, equation 4). Needs the moments that [`Reuse::Balance`] keeps.
    Variance,
    /// By fixed weights.
    Fixed,
}

/// How a new frame is weighed against the frames before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Temporal {
    /// By squared bias and both variances, pixel by pixel (seed 003, equation 4).
    #[default]
    Variance,
    /// A tenth of each new frame.
    Constant,
    /// A tenth of each new frame, and the history is clamped to what the pixel's neighbourhood shows (Salvi 2016).
    Clamp,
}

/// Where the reflection of a pixel is looked for in the last frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HistorySource {
    /// At both places below; the one that agrees better is taken.
    Better,
    /// Where the surface was.
    Surface,
    /// Where the last frame's eye saw the virtual image of what is reflected (seed 002).
    Image,
}

/// Accumulation of reflections over frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Accumulation {
    /// `None`: as the settings say.
    pub weights: Option<Temporal>,
    pub source: HistorySource,
}

/// How reflection rays are answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HitSource {
    /// From the depth of the views.
    ScreenSpace,
    /// From the scene's geometry.
    PathTraced,
}

/// How a screen-space ray uses the two views.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Traversal {
    /// It stays in its own eye's.
    OwnEye,
    /// Its own eye's first, then, where that loses it, the other one's: two compacted stages.
    TwoStages,
    /// Both eyes asked at every pixel on the way, without a hierarchy: the oracle.
    OneLoop,
}

/// Reuse between the eyes (paper §4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reprojection {
    /// A pixel that knows nothing may take what the other eye knows.
    pub filling: bool,
    /// A pair must lead back to its pixel.
    pub back_check: bool,
    /// What the two reflect may differ by the lobe's footprint; otherwise by a thousandth of its distance.
    pub lobe_tolerance: bool,
    pub blend: Blend,
}

/// What a method is made of.
#[derive(Debug, PartialEq, Eq)]
pub struct Parts {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    pub answer: HitSource,
    /// Closed meshes are as thick as their back faces say.
    pub back_faces: bool,
    /// Rays that come back towards the eye are marched too.
    pub camera_rays: bool,
    /// Rays that leave their eye's view go on in the other one's (paper §4.1).
    pub traversal: Traversal,
    /// Both eyes fade alike (paper §4.2).
    pub stereo_fade: bool,
    /// Samples are shared between the eyes (paper §4.3).
    pub reprojection: Option<Reprojection>,
    /// What the frames before knew is used.
    pub accumulation: Option<Accumulation>,
    /// Only the left eye traces; the right one has what is reprojected.
    pub one_eye: bool,
    /// The reference's rays go through the screen-space methods' filter.
    pub resolved: bool,
    /// Pixels beyond each border that are drawn and never shown, in thousandths of the view.
    pub guard_band: u32,
    /// Both eyes draw the same random numbers.
    pub shared_noise: bool,
    /// Squared radius of the spatial reuse, pixels; `None`: the settings'.
    pub reuse_radius_squared: Option<u32>,
    /// How taps are weighted; `None`: as the settings say.
    pub reuse: Option<Reuse>,
    /// What a percentage at the end of the name sets.
    pub knob: Option<Knob>,
    /// Stands for another method, which the device chooses: see [`super::Method::on`].
    pub chosen_by_device: bool,
    /// The right eye's reflections are exchanged left and right.
    pub unrelated: bool,
    pub(super) samples: u32,
}
