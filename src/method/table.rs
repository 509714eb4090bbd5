//! The table of all methods, one row each. `super` looks names up in it. docs/contributing.md says how to add a method.
//! The renderer's hash of a picture covers every field of a row but the description.

use super::technique::{
    Accumulation, Blend, HistorySource, HitSource, NamePercentage, Reprojection, Reuse, Technique, Temporal, Traversal,
};

/// The baseline. The rows of the other methods say where they differ from another row.
pub(super) const SSSR: Technique = Technique {
    name: "sssr",
    about: "stochastic screen-space reflections, each eye for itself (the baseline)",
    hit_source: HitSource::ScreenSpace,
    back_faces: true,
    camera_rays: true,
    traversal: Traversal::OwnEye,
    stereo_fade: false,
    reprojection: None,
    accumulation: None,
    one_eye: false,
    resolved: false,
    guard_band: 0,
    shared_noise: false,
    reuse_radius_squared: None,
    reuse: None,
    percentage: None,
    chosen_by_device: false,
    unrelated: false,
    samples: 1,
};

const OURS: Reprojection =
    Reprojection { filling: true, back_check: true, lobe_tolerance: true, blend: Blend::Variance };
const PAPER: Reprojection =
    Reprojection { filling: false, back_check: false, lobe_tolerance: false, blend: Blend::Fixed };

/// The paper's method: all three parts of its §4.
const STEREO: Technique = Technique {
    name: "stereo",
    about: "stereo-consistent: traversal, fade and reprojection use both eyes (the paper's method)",
    traversal: Traversal::TwoStages,
    stereo_fade: true,
    reprojection: Some(OURS),
    ..SSSR
};

const OVER_TIME: Accumulation = Accumulation { weights: None, source: HistorySource::Better };

/// The reference. `path-traced-resolved` differs from it in what is done with the rays.
const PATH_TRACED: Technique = Technique {
    name: "path-traced",
    about: "the reference: rays through the scene's geometry",
    hit_source: HitSource::PathTraced,
    back_faces: false,
    samples: 1024,
    ..SSSR
};

pub(super) const METHODS: &[Technique] = &[
    SSSR,
    STEREO,
    Technique {
        name: "stereo-no-traversal",
        about: "stereo without the other eye's traversal",
        traversal: Traversal::OwnEye,
        ..STEREO
    },
    Technique { name: "stereo-no-fade", about: "stereo with each eye's own fade", stereo_fade: false, ..STEREO },
    Technique {
        name: "stereo-no-reprojection",
        about: "stereo without reuse between the eyes",
        reprojection: None,
        ..STEREO
    },
    Technique {
        name: "stereo-one-loop",
        about: "stereo whose rays ask both eyes at every pixel: the oracle of its traversal, slow",
        traversal: Traversal::OneLoop,
        ..STEREO
    },
    Technique {
        name: "stereo-paper",
        about: "stereo with the publication's settings: the five that follow here, together",
        camera_rays: false,
        reprojection: Some(PAPER),
        ..STEREO
    },
    Technique {
        name: "stereo-fixed-tolerance",
        about: "stereo whose pairs may reflect points a thousandth of their distance apart, whatever the roughness",
        reprojection: Some(Reprojection { lobe_tolerance: false, ..OURS }),
        ..STEREO
    },
    Technique {
        name: "stereo-no-filling",
        about: "stereo whose pixels without a known ray take nothing from the other eye",
        reprojection: Some(Reprojection { filling: false, ..OURS }),
        ..STEREO
    },
    Technique {
        name: "stereo-no-back-check",
        about: "stereo that does not check whether the partner leads back to the pixel",
        reprojection: Some(Reprojection { back_check: false, ..OURS }),
        ..STEREO
    },
    Technique {
        name: "stereo-no-camera-rays",
        about: "stereo without rays that come back towards the eye",
        camera_rays: false,
        ..STEREO
    },
    Technique {
        name: "stereo-fixed-blend",
        about: "stereo whose eyes are blended by fixed weights instead of their variances",
        reprojection: Some(Reprojection { blend: Blend::Fixed, ..OURS }),
        ..STEREO
    },
    Technique {
        name: "stereo-ratio",
        about: "stereo with the published ratio estimator, whatever --reuse says",
        reuse: Some(Reuse::Ratio),
        ..STEREO
    },
    Technique {
        name: "sssr-ratio",
        about: "the baseline with the published ratio estimator, whatever --reuse says",
        reuse: Some(Reuse::Ratio),
        ..SSSR
    },
    Technique {
        name: "stereo-hybrid",
        about: "stereo whose lost rays ask the scene's geometry; in stereo-hybrid-25 only 25 % of them do",
        percentage: Some(NamePercentage::LostRays),
        ..STEREO
    },
    Technique {
        name: "sssr-hybrid",
        about: "the baseline whose lost rays ask the scene's geometry; in sssr-hybrid-25 only 25 % of them do",
        percentage: Some(NamePercentage::LostRays),
        ..SSSR
    },
    Technique {
        name: "stereo-adaptive",
        about: "each eye for itself, then stereo work only where the eyes may differ visibly; in stereo-adaptive-5 that is by 5 %",
        traversal: Traversal::OwnEye,
        percentage: Some(NamePercentage::Weber),
        ..STEREO
    },
    Technique {
        name: "sssr-temporal",
        about: "the baseline, accumulated over frames",
        accumulation: Some(OVER_TIME),
        ..SSSR
    },
    Technique {
        name: "stereo-temporal",
        about: "stereo, each eye accumulated over frames before the eyes are blended",
        accumulation: Some(OVER_TIME),
        ..STEREO
    },
    Technique {
        name: "stereo-hybrid-temporal",
        about: "stereo-hybrid, accumulated likewise; in stereo-hybrid-temporal-25 only 25 % of the lost rays ask",
        accumulation: Some(OVER_TIME),
        percentage: Some(NamePercentage::LostRays),
        ..STEREO
    },
    Technique {
        name: "stereo-temporal-surface",
        about: "stereo-temporal whose history follows the surfaces alone",
        accumulation: Some(Accumulation { source: HistorySource::Surface, ..OVER_TIME }),
        ..STEREO
    },
    Technique {
        name: "stereo-temporal-image",
        about: "stereo-temporal whose history follows the virtual images alone",
        accumulation: Some(Accumulation { source: HistorySource::Image, ..OVER_TIME }),
        ..STEREO
    },
    Technique {
        name: "stereo-temporal-constant",
        about: "stereo-temporal that takes a tenth of each new frame, whatever --temporal says",
        accumulation: Some(Accumulation { weights: Some(Temporal::Constant), ..OVER_TIME }),
        ..STEREO
    },
    Technique {
        name: "stereo-temporal-clamp",
        about: "stereo-temporal-constant whose history is clamped to the colours in the neighbourhood",
        accumulation: Some(Accumulation { weights: Some(Temporal::Clamp), ..OVER_TIME }),
        ..STEREO
    },
    Technique {
        name: "recommended",
        about: "the method that measures best on this kind of device; --explain names it",
        chosen_by_device: true,
        ..STEREO
    },
    Technique {
        name: "sssr-thickness",
        about: "the baseline without back faces: every mesh is as thick as an open one",
        back_faces: false,
        ..SSSR
    },
    Technique {
        name: "sssr-guardband",
        about: "the baseline with a tenth of the view drawn beyond each border",
        guard_band: 100,
        ..SSSR
    },
    Technique {
        name: "stereo-guardband",
        about: "stereo with a tenth of the view drawn beyond each border",
        guard_band: 100,
        ..STEREO
    },
    Technique {
        name: "sssr-shared-noise",
        about: "the baseline with one random stream for both eyes",
        shared_noise: true,
        ..SSSR
    },
    Technique {
        name: "sssr-wide",
        about: "the baseline with 37 pixels of spatial reuse instead of 25",
        reuse_radius_squared: Some(10),
        ..SSSR
    },
    Technique {
        name: "one-eye",
        about: "the left eye as in the baseline, the right one reprojected from it",
        reprojection: Some(OURS),
        one_eye: true,
        ..SSSR
    },
    Technique {
        name: "unrelated",
        about: "for catch trials: the right eye's reflections mirrored left to right, which fit nothing in the left eye",
        unrelated: true,
        ..SSSR
    },
    PATH_TRACED,
    Technique {
        name: "path-traced-resolved",
        about: "a few of the reference's rays through the baseline's filter (also path-traced@N-resolved)",
        resolved: true,
        samples: 2,
        ..PATH_TRACED
    },
];

/// What `recommended` is on a device that is slow to trace rays through the geometry: the method with the lowest error
/// among those whose tracing and resolving take at most about 1.3 times as long as the baseline's.
pub(super) const RECOMMENDED_WITHOUT_RAY_QUERIES: &str = "stereo-guardband";
/// What `recommended` is where a ray through the geometry takes about as long as a march through a view.
pub(super) const RECOMMENDED_WITH_RAY_QUERIES: &str = "stereo-hybrid";
