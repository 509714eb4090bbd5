//! The built-in scenes. They are made by code and handed to the loader as ordinary glTF.
//!
//! Each scene has a file of its own, and so has each family of shapes. The manifests in `scenes/` add the views, the
//! lights and the motion.

mod builder;
mod cellar;
mod figures;
mod finish;
mod furniture;
mod glasses;
mod noise;
mod pattern;
mod pica;
mod pink;
mod playthings;
mod room;
mod shape;
mod solids;
mod surface;
mod sweep;
mod tableware;
mod temple;
mod texture;
mod wine;
mod writer;

pub use builder::Generated;

/// The built-in scenes, in the order of the paper's Table 1.
pub const NAMES: [&str; 5] = ["pica", "room", "wine", "pink", "temple"];

/// The manifest of a built-in scene: the text of `scenes/NAME.json`.
pub fn manifest(name: &str) -> Option<&'static str> {
    match name {
        "pica" => Some(include_str!("../../../scenes/pica.json")),
        "room" => Some(include_str!("../../../scenes/room.json")),
        "wine" => Some(include_str!("../../../scenes/wine.json")),
        "pink" => Some(include_str!("../../../scenes/pink.json")),
        "temple" => Some(include_str!("../../../scenes/temple.json")),
        _ => None,
    }
}

/// Makes the glTF of a built-in scene. `detail` (0.01–4) scales its triangle count.
///
/// # Errors
/// One sentence when the name is unknown or the detail is out of range.
pub fn generate(name: &str, detail: f64) -> Result<Generated, String> {
    build(name, detail)?.finish()
}

/// The numbers of triangles and of materials of a built-in scene, without making its textures.
///
/// # Errors
/// As [`generate`].
pub fn count(name: &str, detail: f64) -> Result<(usize, usize), String> {
    build(name, detail).map(|b| (b.triangle_count(), b.material_count()))
}

fn build(name: &str, detail: f64) -> Result<builder::Builder, String> {
    if !(0.01..=4.0).contains(&detail) {
        return Err(format!("detail is {detail}; it must be 0.01 to 4"));
    }
    Ok(match name {
        "pica" => pica::build(detail),
        "room" => room::build(detail),
        "wine" => wine::build(detail),
        "pink" => pink::build(detail),
        "temple" => temple::build(detail),
        _ => return Err(format!("there is no built-in scene `{name}`; known: {}", NAMES.join(", "))),
    })
}
