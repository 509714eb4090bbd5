//! The materials of glasses and bottles: of the table and of the cellar around it.

use super::builder::{Builder, Finish, MaterialId};
use super::pattern::rgb;

/// See the module's documentation.
pub struct Glasses {
    pub tints: Vec<MaterialId>,
    pub bottle: Vec<MaterialId>,
    pub labels: Vec<MaterialId>,
    pub foil: Vec<MaterialId>,
}

impl Glasses {
    /// Adds them to the scene.
    pub fn new(b: &mut Builder) -> Glasses {
        let tint = |name: &str, color: [u8; 3], roughness: f32| {
            Finish::dielectric(name, rgb(color[0], color[1], color[2]), roughness).ior(1.7)
        };
        let tints = [
            ("smoked glass", [44, 48, 54], 0.0),
            ("ruby wine", [110, 12, 28], 0.22),
            ("amber glass", [150, 88, 22], 0.3),
            ("blue glass", [24, 52, 120], 0.35),
            ("silvered glass", [150, 152, 156], 0.25),
        ];
        let bottles = [
            ("green bottle", [24, 56, 30], 0.3),
            ("brown bottle", [70, 38, 18], 0.4),
            ("black bottle", [22, 22, 26], 0.45),
            ("pale bottle", [120, 124, 76], 0.5),
        ];
        Glasses {
            tints: tints.into_iter().map(|(n, c, r)| b.material(tint(n, c, r))).collect(),
            bottle: bottles.into_iter().map(|(n, c, r)| b.material(tint(n, c, r))).collect(),
            labels: b.palette(
                "label",
                &[([226, 214, 184], 0.58), ([196, 40, 40], 0.56), ([230, 230, 224], 0.59), ([40, 52, 72], 0.57)],
            ),
            foil: vec![
                b.material(Finish::metal("gold foil", [0.86, 0.66, 0.28], 0.5)),
                b.material(Finish::metal("red foil", [0.5, 0.08, 0.08], 0.55)),
                b.material(Finish::dielectric("cork", rgb(190, 150, 104), 0.597)),
            ],
        }
    }
}
