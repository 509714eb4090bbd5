//! The built-in scenes: made by code, handed to the loader as ordinary glTF.
//!
//! One file a scene, one a family of shapes; the manifests in `scenes/` place eyes, lights and motion.

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

/// The manifest of a built-in scene, as in `scenes/NAME.json`.
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

/// Makes a built-in scene's glTF; `detail` (0.01–4) scales its triangle count.
///
/// # Errors
/// One sentence when the name is unknown or the detail out of range.
pub fn generate(name: &str, detail: f64) -> Result<Generated, String> {
    build(name, detail)?.finish()
}

/// (triangles, materials) of a built-in scene, without making its textures.
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
