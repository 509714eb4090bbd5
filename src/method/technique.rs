//! The choices that a method is made of. Each field of [`Technique`] is one choice; `table` fills them in for every method,
//! and the renderer's passes read them.

/// What the percentage at the end of a method's name sets, as in `stereo-hybrid-25`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NamePercentage {
    /// The share of the lost rays that may ask the scene's geometry; 100 by default. At 0 no ray asks it.
    LostRays,
    /// The Weber contrast between the eyes below which a pixel does no work in the other eye; 2 by default (seed 001,
    /// after Walter et al. 2005). It is relative to the pixel's composite luminance.
    Weber,
}

impl NamePercentage {
    /// The percentage of a name without one, in thousandths of a per cent.
    pub(super) fn default_value(self) -> u32 {
        match self {
            NamePercentage::LostRays => 100_000,
            NamePercentage::Weber => 2_000,
        }
    }
}

/// How the filter weighs the taps of the spatial reuse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Reuse {
    /// Multiple-importance weights: the balance heuristic between the pixel's own density and each tap's (pairwise, as
    /// in Bitterli 2022). Bright outliers are bounded, and the eyes are blended by their variances.
    #[default]
    Balance,
    /// The published ratio estimator (Stachowiak 2015): each tap is divided by its own density. Nothing is bounded, and
    /// the eyes are blended by fixed weights.
    Ratio,
}

/// How the reflected light of the two pixels of a pair is blended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Blend {
    /// By the squared bias and both variances (seed 003, equation 4). This needs the moments that [`Reuse::Balance`]
    /// keeps.
    Variance,
    /// By fixed weights.
    Fixed,
}

/// How much a new frame counts against the frames before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Temporal {
    /// By the squared bias and both variances, pixel by pixel (seed 003, equation 4).
    #[default]
    Variance,
    /// Each new frame counts a tenth.
    Constant,
    /// Each new frame counts a tenth, and the history is clamped to the colours in the pixel's neighbourhood (Salvi
    /// 2016).
    Clamp,
}

/// Where in the last frame the history looks for the reflection that a pixel shows now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum HistorySource {
    /// At both places below. The one that agrees better with the new frame is taken.
    Better,
    /// Where the reflecting surface was.
    Surface,
    /// Where the last frame showed the virtual image of what is reflected (seed 002).
    Image,
}

/// How reflections are accumulated over frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Accumulation {
    /// How much a new frame counts. `None`: as the settings say.
    pub weights: Option<Temporal>,
    pub source: HistorySource,
}

/// What answers reflection rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum HitSource {
    /// The depth of the views.
    ScreenSpace,
    /// The scene's geometry.
    PathTraced,
}

/// How a screen-space ray uses the two views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Traversal {
    /// It stays in its own eye's view.
    OwnEye,
    /// It goes through its own eye's view first, and where it is lost, through the other eye's. These are two stages,
    /// and the second one runs over a list of the rays that were lost.
    TwoStages,
    /// It asks both views at every pixel on its way, without a hierarchy of depth. This is slow, and `TwoStages` is
    /// checked against it.
    OneLoop,
}

/// Reuse between the eyes (paper §4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Reprojection {
    /// A pixel whose rays are unknown may take the reflection that the other eye has.
    pub filling: bool,
    /// A pixel uses its partner only where the partner leads back to it.
    pub back_check: bool,
    /// Whether what the two pixels reflect may lie apart by the lobe's footprint. Otherwise it may lie apart by a
    /// thousandth of its distance.
    pub lobe_tolerance: bool,
    pub blend: Blend,
}

/// The choices that make up a method. As JSON they are part of the hash of every picture (`render::identity`), without the
/// description.
#[derive(Debug, PartialEq, Eq, serde::Serialize)]
pub struct Technique {
    pub(super) name: &'static str,
    #[serde(skip)]
    pub(super) about: &'static str,
    pub hit_source: HitSource,
    /// Whether the thickness of closed meshes is read from their back faces.
    pub back_faces: bool,
    /// Whether rays that come back towards the eye are followed too.
    pub camera_rays: bool,
    /// How a ray uses the two views (paper §4.1).
    pub traversal: Traversal,
    /// Whether both eyes fade alike (paper §4.2).
    pub stereo_fade: bool,
    /// How samples are shared between the eyes (paper §4.3). `None`: they are not shared.
    pub reprojection: Option<Reprojection>,
    /// How the results of earlier frames are used. `None`: they are not used.
    pub accumulation: Option<Accumulation>,
    /// Whether only the left eye traces. The right eye then has only what is reprojected from the left one.
    pub one_eye: bool,
    /// Whether rays through the geometry go through the filter of the screen-space methods.
    pub resolved: bool,
    /// The guard band: how far beyond each border the view is drawn, in thousandths of the view.
    pub guard_band: u32,
    /// Whether both eyes draw the same random numbers.
    pub shared_noise: bool,
    /// The squared radius of the spatial reuse, in pixels. `None`: as the settings say.
    pub reuse_radius_squared: Option<u32>,
    /// How taps are weighed. `None`: as the settings say.
    pub reuse: Option<Reuse>,
    /// What a percentage at the end of the name sets. `None`: the name has no percentage.
    pub percentage: Option<NamePercentage>,
    /// Whether this method stands for another one that the kind of device decides; see [`super::Method::on`].
    pub chosen_by_device: bool,
    /// Whether the reflections of the right eye are mirrored left to right, so that they do not fit those of the left
    /// eye.
    pub unrelated: bool,
    pub(super) samples: u32,
}
