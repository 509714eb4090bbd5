//! The numbers that the two publications print, digit by digit. Seed 000 is Wu, Xu and Wang's *Stereo-consistent Screen
//! Space Reflection*, and seed 001 is Wu's *Efficient Stereo-Aware Screen-Space Ambient Occlusion with Adaptive
//! Computation*. The tables and figures of `paper` show these numbers.

/// One of the two publications.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Publication {
    #[default]
    Reflection,
    AmbientOcclusion,
}

impl Publication {
    pub fn cite(self) -> &'static str {
        match self {
            Publication::Reflection => "Wu, Xu and Wang, Stereo-consistent Screen Space Reflection",
            Publication::AmbientOcclusion => {
                "Wu, Efficient Stereo-Aware Screen-Space Ambient Occlusion with Adaptive Computation"
            }
        }
    }
}

impl serde::Serialize for Publication {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.cite())
    }
}

/// The devices and settings of the measurements (§5). An image of both eyes together has 3840×1080 pixels.
pub const SETTING: &str = "an Intel i9-12900K and an NVIDIA GeForce RTX 3090, Vulkan, 1920×1080 pixels an eye, one ray \
                           a pixel, a filter of radius 2, a hardware-traced reference of 1024 paths a pixel and two \
                           bounces, no shadows";

/// The devices and settings of seed 001 (section *Experiments*).
pub const AO_SETTING: &str = "Unity on an Intel i7-10700 and an NVIDIA RTX A4000, 1254×1254 pixels an eye";

/// A line of Table 1 (§5), the parameters of a test scene.
pub struct Parameters {
    pub scene: &'static str,
    pub triangles: u32,
    pub moving: u32,
    /// The number of reflective materials, whose roughness is below 0.8.
    pub reflective: u32,
    pub roughness: [f64; 2],
    pub mean_roughness: f64,
}

pub const TABLE_1: [Parameters; 5] = [
    parameters("Pica", [383_434, 0, 35], [0.069, 0.600, 0.421]),
    parameters("Room", [3_388_689, 0, 71], [0.0, 0.634, 0.390]),
    parameters("Wine", [1_270_923, 0, 75], [0.0, 0.597, 0.517]),
    parameters("Pink", [282_260, 2, 46], [0.054, 0.679, 0.488]),
    parameters("Temple", [448_935, 1, 54], [0.036, 0.624, 0.416]),
];

const fn parameters(
    scene: &'static str,
    [triangles, moving, reflective]: [u32; 3],
    [low, high, mean_roughness]: [f64; 3],
) -> Parameters {
    Parameters { scene, triangles, moving, reflective, roughness: [low, high], mean_roughness }
}

/// A line of Table 2 (§5.1), one eye of a scene. Each pair is SSSR, then Ours.
pub struct Quality {
    pub scene: &'static str,
    pub eye: &'static str,
    pub ssim: [f64; 2],
    pub lpips: [f64; 2],
    pub dists: [f64; 2],
}

pub const TABLE_2: [Quality; 10] = [
    quality("Pica", "left", [0.373, 0.423], [0.259, 0.233], [0.194, 0.194]),
    quality("Pica", "right", [0.393, 0.447], [0.267, 0.242], [0.201, 0.202]),
    quality("Room", "left", [0.364, 0.393], [0.249, 0.228], [0.154, 0.149]),
    quality("Room", "right", [0.353, 0.382], [0.251, 0.229], [0.158, 0.150]),
    quality("Wine", "left", [0.274, 0.295], [0.455, 0.440], [0.283, 0.261]),
    quality("Wine", "right", [0.268, 0.296], [0.461, 0.441], [0.293, 0.262]),
    quality("Pink", "left", [0.455, 0.477], [0.412, 0.409], [0.233, 0.231]),
    quality("Pink", "right", [0.433, 0.454], [0.425, 0.421], [0.235, 0.235]),
    quality("Temple", "left", [0.476, 0.498], [0.362, 0.348], [0.166, 0.165]),
    quality("Temple", "right", [0.481, 0.505], [0.356, 0.345], [0.171, 0.167]),
];

const fn quality(scene: &'static str, eye: &'static str, ssim: [f64; 2], lpips: [f64; 2], dists: [f64; 2]) -> Quality {
    Quality { scene, eye, ssim, lpips, dists }
}

/// A line of Table 3 (§5.2), in milliseconds. Each pair is SSSR, then Ours.
pub struct Times {
    pub scene: &'static str,
    pub path_tracing: f64,
    pub traversal: [f64; 2],
    pub filter: [f64; 2],
    pub total: [f64; 2],
    /// The overhead that is printed in brackets, per cent.
    pub overhead: f64,
}

pub const TABLE_3: [Times; 5] = [
    times("Pica", 3.94, [2.06, 2.72], [0.75, 1.03], [2.81, 3.75], 33.0),
    times("Room", 4.92, [1.92, 2.65], [0.94, 1.04], [2.86, 3.69], 29.0),
    times("Wine", 8.52, [3.61, 5.24], [0.85, 1.22], [4.46, 6.46], 44.0),
    times("Pink", 3.34, [2.26, 3.48], [0.86, 1.03], [3.12, 4.51], 45.0),
    times("Temple", 3.65, [2.09, 3.16], [0.89, 1.09], [2.98, 4.25], 42.0),
];

const fn times(
    scene: &'static str,
    path_tracing: f64,
    traversal: [f64; 2],
    filter: [f64; 2],
    total: [f64; 2],
    overhead: f64,
) -> Times {
    Times { scene, path_tracing, traversal, filter, total, overhead }
}

/// The signed-rank test of the first study, and its number of participants (§6.2).
pub struct Study {
    pub participants: u32,
    pub z: f64,
    pub p: f64,
    /// Every mean opinion score of the second and of the third study is above this.
    pub preference_above: f64,
}

pub const STUDY: Study = Study { participants: 10, z: -2.870, p: 0.004, preference_above: 2.0 };

/// A view in Figures 1 and 8 of seed 001: the share of inconsistent pixels (per cent), and milliseconds. The methods
/// are mono, FSA, variant 1 and variant 2, in this order.
pub struct AoScene {
    pub scene: &'static str,
    pub figure: &'static str,
    pub inconsistent: [Option<f64>; 4],
    pub ms: [Option<f64>; 4],
}

pub const AO_FIGURE_8: [AoScene; 5] = [
    ao_scene("Market", [2.47, 0.45, 0.44, 0.35], [1.99, 4.07, 2.54, 3.16]),
    ao_scene("Sponza 2", [5.27, 0.84, 0.88, 0.67], [3.30, 7.11, 4.32, 5.41]),
    ao_scene("Sibenik", [6.37, 1.69, 1.48, 1.43], [3.41, 6.75, 4.62, 5.44]),
    ao_scene("Bistro 1", [12.66, 3.22, 3.02, 2.96], [3.10, 6.71, 4.33, 5.06]),
    ao_scene("Bistro 2", [10.26, 2.63, 2.59, 2.22], [2.91, 5.94, 3.96, 4.62]),
];

/// The text of Figure 1 gives only the shares of mono and FSA. The times are those of Table 3.
pub const AO_FIGURE_1: AoScene = AoScene {
    scene: "Sponza",
    figure: "Figure 1",
    inconsistent: [Some(7.09), Some(1.34), None, None],
    ms: [Some(3.44), Some(7.04), Some(4.42), Some(5.58)],
};

const fn ao_scene(scene: &'static str, inconsistent: [f64; 4], ms: [f64; 4]) -> AoScene {
    let [a, b, c, d] = inconsistent;
    let [e, f, g, h] = ms;
    AoScene {
        scene,
        figure: "Figure 8",
        inconsistent: [Some(a), Some(b), Some(c), Some(d)],
        ms: [Some(e), Some(f), Some(g), Some(h)],
    }
}

/// Table 1 of seed 001: the per cent of inconsistent pixels along a path. The methods are mono, FSA, variant 1 and
/// variant 2, in this order.
pub const AO_TABLE_1: [(&str, [f64; 4]); 2] =
    [("Sponza", [5.82, 1.13, 1.07, 0.90]), ("Bistro", [7.29, 1.99, 1.92, 1.76])];

/// Table 2 of seed 001: the mean absolute error against FSA along a path. The methods are mono, variant 1 and variant
/// 2, in this order.
pub const AO_TABLE_2: [(&str, [f64; 3]); 2] =
    [("Sponza", [0.0049, 0.0025, 0.0002]), ("Bistro", [0.0057, 0.0025, 0.0002])];

/// A line of Table 3 of seed 001, in milliseconds. A pass that the method does not have is `None`.
pub struct AoTimes {
    pub scene: &'static str,
    pub method: &'static str,
    /// The estimate and the filter of the first pass, the map of the differing pixels, then the estimate and the filter
    /// of the adaptive pass.
    pub passes: [Option<f64>; 5],
    pub total: f64,
}

pub const AO_TABLE_3: [AoTimes; 8] = [
    ao_times("Market", "mono", [Some(0.85), Some(1.14), None, None, None], 1.99),
    ao_times("Market", "fsa", [Some(1.81), Some(2.26), None, None, None], 4.07),
    ao_times("Market", "variant1", [Some(0.85), Some(1.14), Some(0.12), Some(0.18), Some(0.25)], 2.54),
    ao_times("Market", "variant2", [Some(1.81), Some(1.14), Some(0.12), None, Some(0.09)], 3.16),
    ao_times("Sponza", "mono", [Some(1.38), Some(2.06), None, None, None], 3.44),
    ao_times("Sponza", "fsa", [Some(3.22), Some(3.82), None, None, None], 7.04),
    ao_times("Sponza", "variant1", [Some(1.38), Some(2.06), Some(0.19), Some(0.33), Some(0.46)], 4.42),
    ao_times("Sponza", "variant2", [Some(3.22), Some(2.06), Some(0.19), None, Some(0.11)], 5.58),
];

const fn ao_times(scene: &'static str, method: &'static str, passes: [Option<f64>; 5], total: f64) -> AoTimes {
    AoTimes { scene, method, passes, total }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_are_the_sums_that_they_are_printed_as() {
        for t in &TABLE_3 {
            for i in [0, 1] {
                assert!((t.traversal[i] + t.filter[i] - t.total[i]).abs() < 0.005, "{} {i}", t.scene);
            }
            // Some of the printed overheads are rounded up and some down.
            let overhead = 100.0 * (t.total[1] / t.total[0] - 1.0);
            assert!((overhead - t.overhead).abs() < 1.0, "{}: {overhead} and {}", t.scene, t.overhead);
            // §5.2 says that 0.9 to 2.0 ms are added, but for Room it is 0.83.
            let added = t.total[1] - t.total[0];
            assert!((0.83 - 1e-9..=2.0 + 1e-9).contains(&added), "{}: {added}", t.scene);
        }
        for t in &AO_TABLE_3 {
            let sum: f64 = t.passes.iter().flatten().sum();
            assert!((sum - t.total).abs() < 0.005, "{} {}: {sum}", t.scene, t.method);
        }
    }

    #[test]
    fn words_and_numbers_of_the_publications_agree() {
        // §5.1 says that Ours is better than SSSR by SSIM and LPIPS in every eye, and by DISTS in all but three.
        for q in &TABLE_2 {
            assert!(q.ssim[1] > q.ssim[0] && q.lpips[1] < q.lpips[0], "{} {}", q.scene, q.eye);
        }
        let no_better: Vec<_> = TABLE_2.iter().filter(|q| q.dists[1] >= q.dists[0]).map(|q| (q.scene, q.eye)).collect();
        assert_eq!(no_better, [("Pica", "left"), ("Pica", "right"), ("Pink", "right")]);
        for (one, other) in TABLE_1.iter().zip(&TABLE_3) {
            assert_eq!(one.scene, other.scene);
            assert!(one.roughness[0] <= one.mean_roughness && one.mean_roughness <= one.roughness[1], "{}", one.scene);
        }
        // The printed p is the two-sided normal p of the printed z, rounded.
        let p = cyclopean_analysis::special::normal_two_sided(STUDY.z);
        assert_eq!(format!("{p:.3}"), format!("{:.3}", STUDY.p));
        // Seed 001 prints "2.05×" and "1.28×" in Figure 1, which follow from its Table 3.
        let ratio = |i: usize| AO_FIGURE_1.ms[i].expect("printed") / AO_FIGURE_1.ms[0].expect("printed");
        assert_eq!((format!("{:.2}", ratio(1)), format!("{:.2}", ratio(2))), ("2.05".to_owned(), "1.28".to_owned()));
        let of = |scene: &str| {
            AO_TABLE_3.iter().filter(move |t| t.scene == scene).map(|t| Some(t.total)).collect::<Vec<_>>()
        };
        assert_eq!(of("Sponza"), AO_FIGURE_1.ms);
        assert_eq!(of("Market"), AO_FIGURE_8[0].ms);
        // Seed 001 says "Additional overhead ranges from approximately 25% to 40%", and variant 2 is "15% to 25%
        // slower".
        for s in AO_FIGURE_8.iter().chain([&AO_FIGURE_1]) {
            let ms = |i: usize| s.ms[i].expect("printed");
            assert!((1.25..1.42).contains(&(ms(2) / ms(0))), "{}: {}", s.scene, ms(2) / ms(0));
            assert!((1.15..1.27).contains(&(ms(3) / ms(2))), "{}: {}", s.scene, ms(3) / ms(2));
        }
    }
}
