//! The path-traced reference of a view. It is made once, stored under a hash of everything that it follows from, and
//! verified when it is read. [`Subject::reference`](super::subject::Subject::reference) asks for it.
//!
//! Tracing goes on from the sums of an earlier run with fewer paths, even if Ctrl-C ended that run. It may also stop as
//! soon as the standard error is small enough. [`super::checkpoint`] has these sums.
//!
//! A second reference with another seed is stored with it. Half the mean squared difference between the two is the
//! variance of the reference, without any assumption about its samples. Measured like a method, the second one gives
//! the floor of the methods' figures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files;
use serde::{Deserialize, Serialize};

use super::checkpoint::Checkpoint;
use super::plan::Options;
use super::{CompareError, sha256};
use crate::console::{Console, Progress, check_interrupted};
use crate::gpu::Gpu;
use crate::metrics::Pairs;
use crate::metrics::pairs::{self, EyeSurfaces, Surfaces};
use crate::picture::{self, Part, PictureError, StereoPicture};
use crate::render::geometry::EyeGeometry;
use crate::render::{Geometry, Prepared, Renderer, Settings, identity};
use crate::scene::{Fallback, Scene, StereoCamera};

/// The seeds of the two references. They are far from the seeds of the rounds, which begin at 0, because equal seeds
/// would share random numbers.
const SEEDS: [u32; 2] = [1_000_001, 1_000_002];

/// The version of the meaning of the files, including how pairs are chosen. A stored reference of another version is
/// made again.
const VERSION: u32 = 1;

/// The most bytes of a file of a reference. Both eyes of the largest picture fit into it with all layers.
const MOST_KEPT: u64 = 16 << 30;

const PICTURE: &str = "reference.exr";
const AGAIN: &str = "again.exr";
const PAIRS: &str = "pairs.json";
const MANIFEST: &str = "manifest.json";

/// The reference of a view.
pub struct Reference {
    pub key: String,
    pub folder: PathBuf,
    /// Paths a pixel.
    pub spp: u32,
    /// The composite in linear radiance, then the outgoing reflection alone, then the standard error of the reflection.
    pub linear: StereoPicture,
    pub reflection: StereoPicture,
    pub error: StereoPicture,
    /// R is 1 where a reflection ray starts, G is 1 / hit distance, and B is raw depth.
    rays: StereoPicture,
    pub pairs: Pairs,
    /// The composite and the reflection with the second seed.
    pub again: [StereoPicture; 2],
}

/// The manifest of a stored reference. It is written last.
#[derive(Debug, Serialize, Deserialize)]
struct Manifest {
    version: u32,
    scene: String,
    spp: u32,
    /// The SHA-256 (hex) of each file.
    files: BTreeMap<String, String>,
}

impl Reference {
    /// Which pixels of an eye trace a reflection ray.
    pub fn mask(&self, eye: usize) -> Vec<bool> {
        self.rays.eyes[eye].iter().map(|t| t[0] > 0.0).collect()
    }

    /// The pairs of pixels that show the same reflection by geometry alone, whether or not their luminances match in
    /// the reference. `prepared` must have drawn a frame of this view. The indices are those in the left and in the
    /// right eye, row-major.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn geometric_pairs(&self, prepared: &Prepared) -> Result<Vec<[usize; 2]>, CompareError> {
        let mut geometry = prepared.geometry()?;
        for (eye, rays) in geometry.eyes.iter_mut().zip(&self.rays.eyes) {
            eye.inverse_hit_distance = rays.iter().map(|t| t[1]).collect();
        }
        let size = (self.linear.width as usize, self.linear.height as usize);
        Ok(surfaces_of(prepared, &geometry, size).pairs().collect())
    }

    /// The stored reference, or a new one that is then stored. A damaged one is made again, and a note says so.
    ///
    /// # Errors
    /// A failure of the device or of the disk.
    pub fn obtain(
        gpu: &Gpu,
        renderer: &mut Renderer,
        camera: &StereoCamera,
        options: &Options,
        console: &Console,
    ) -> Result<Reference, CompareError> {
        let (method, settings) = (&options.reference, settings(options));
        let of = |spp: u32| method.clone().with_exactly(spp);
        let kind = gpu.info().kind;
        let key = |renderer: &Renderer, spp: u32| identity(renderer.scene(), camera, &of(spp), &settings, kind);
        let any = any_number(renderer.scene(), camera, options, kind)?;
        let mut checkpoints = [0, 1].map(|number| Checkpoint::open(&options.cache, &any, number));
        let most = method.samples();
        let count = options.until.map_or(Some(most), |until| checkpoints[0].count_for(until, most));
        if let Some(spp) = count
            && let Some(found) = Reference::stored(&key(renderer, spp)?, options, console)
        {
            return Ok(found);
        }
        let mut prepared = renderer.prepare(camera, &of(count.unwrap_or(most)), &settings)?;
        prepared.set_until(options.until.filter(|_| count.is_none()));
        let mut bar = console.progress("reference", 2 * u64::from(prepared.method().samples()));
        trace(&prepared, &mut checkpoints[0], (&mut bar, 0))?;
        // Where nothing reflects, nothing is traced, so no number of samples is reached.
        let spp = Some(prepared.samples_reached()).filter(|spp| *spp > 0).unwrap_or(most);
        let key = key(renderer, spp)?;
        if count.is_none()
            && let Some(found) = Reference::stored(&key, options, console)
        {
            return Ok(found);
        }
        let (linear, reflection, geometry) = (prepared.linear()?, prepared.reflection()?, prepared.geometry()?);
        let error = prepared.standard_error(&reflection)?.unwrap_or_else(|| black(&linear));
        let pairs = choose_pairs(&prepared, &geometry, &linear, &error);
        let rays = rays(&geometry, &linear);
        prepared.set_until(None);
        prepared.set_samples(spp);
        prepared.set_seed(SEEDS[1], 0);
        trace(&prepared, &mut checkpoints[1], (&mut bar, spp))?;
        let again = [prepared.linear()?, prepared.reflection()?];
        // A reference is not stored if there was a validation message.
        gpu.check_validation()?;
        let folder = options.cache.join(&key);
        let made = Reference { key, folder, spp, linear, reflection, error, rays, pairs, again };
        made.write(&renderer.scene().name)?;
        Ok(made)
    }

    /// The stored reference with this key, if it is undamaged.
    fn stored(key: &str, options: &Options, console: &Console) -> Option<Reference> {
        let folder = options.cache.join(key);
        if !folder.join(MANIFEST).exists() {
            return None;
        }
        Reference::read(key, &folder)
            .map_err(|reason| console.note(format!("{}: {reason}; it is made again", folder.display())))
            .ok()
    }

    /// Stores the reference, unless another program has stored it in the meantime.
    fn write(&self, scene: &str) -> Result<(), CompareError> {
        let cache = self.folder.parent().unwrap_or(Path::new("."));
        super::make_folder(cache)?;
        let is_whole = || Reference::read(&self.key, &self.folder).is_ok();
        files::write_folder(&self.folder, is_whole, |folder| self.fill(scene, folder))
    }

    fn fill(&self, scene: &str, folder: &Path) -> Result<(), CompareError> {
        let parts = [
            Part { layer: "", picture: &self.linear },
            Part { layer: "reflection", picture: &self.reflection },
            Part { layer: "error", picture: &self.error },
            Part { layer: "rays", picture: &self.rays },
        ];
        picture::write_exr(&folder.join(PICTURE), &parts)?;
        let [linear, reflection] = &self.again;
        let parts = [Part { layer: "", picture: linear }, Part { layer: "reflection", picture: reflection }];
        picture::write_exr(&folder.join(AGAIN), &parts)?;
        files::write_bytes(&folder.join(PAIRS), &serde_json::to_vec(&self.pairs)?)?;
        let mut hashes = BTreeMap::new();
        for name in [PICTURE, AGAIN, PAIRS] {
            let path = folder.join(name);
            let bytes =
                files::read(&path, MOST_KEPT).map_err(|e| PictureError::Read { path, reason: e.to_string() })?;
            hashes.insert(name.to_owned(), sha256(&bytes));
        }
        let manifest = Manifest { version: VERSION, scene: scene.to_owned(), spp: self.spp, files: hashes };
        Ok(files::write_bytes(&folder.join(MANIFEST), &serde_json::to_vec_pretty(&manifest)?)?)
    }

    /// Reads the stored files.
    ///
    /// # Errors
    /// Why they cannot be used, as a clause for a message.
    fn read(key: &str, folder: &Path) -> Result<Reference, String> {
        let bytes =
            |name: &str| files::read(&folder.join(name), MOST_KEPT).map_err(|e| format!("{name} cannot be read ({e})"));
        let json = |e: serde_json::Error| format!("it is not JSON of this program ({e})");
        let manifest: Manifest = serde_json::from_slice(&bytes(MANIFEST)?).map_err(json)?;
        if manifest.version != VERSION {
            return Err(format!("its version is {}, and {VERSION} is needed", manifest.version));
        }
        for name in [PICTURE, AGAIN, PAIRS] {
            if manifest.files.get(name) != Some(&sha256(&bytes(name)?)) {
                return Err(format!("{name} does not match its digest"));
            }
        }
        let read = |name: &str, layer: &str| picture::read_exr(&folder.join(name), layer).map_err(|e| e.to_string());
        Ok(Reference {
            key: key.to_owned(),
            folder: folder.to_owned(),
            spp: manifest.spp,
            linear: read(PICTURE, "")?,
            reflection: read(PICTURE, "reflection")?,
            error: read(PICTURE, "error")?,
            rays: read(PICTURE, "rays")?,
            pairs: serde_json::from_slice(&bytes(PAIRS)?).map_err(json)?,
            again: [read(AGAIN, "")?, read(AGAIN, "reflection")?],
        })
    }
}

/// The settings of the reference. Its paths go through the geometry, so fade, fallback and filter do not change them.
/// These are set to fixed values here, so that they do not lead to another reference.
fn settings(options: &Options) -> Settings {
    let neutral = Settings::default();
    Settings {
        seed: SEEDS[0],
        fallback: Some(Fallback::Black),
        edge_fade: neutral.edge_fade,
        reuse_radius: neutral.reuse_radius,
        max_steps: neutral.max_steps,
        reuse: neutral.reuse,
        firefly: neutral.firefly,
        shading_reuse: neutral.shading_reuse,
        ..options.settings.clone()
    }
}

/// A hash of everything that the paths of a view follow from, except their number.
fn any_number(
    scene: &Scene,
    camera: &StereoCamera,
    options: &Options,
    device_kind: &str,
) -> Result<String, serde_json::Error> {
    identity(scene, camera, &options.reference.clone().with_exactly(1), &settings(options), device_kind)
}

/// Everything that the references of a view and its pairs follow from.
pub fn follows_from(
    scene: &Scene,
    camera: &StereoCamera,
    options: &Options,
    device_kind: &str,
) -> Result<serde_json::Value, serde_json::Error> {
    let paths = any_number(scene, camera, options, device_kind)?;
    let (spp, until) = (options.reference.samples(), options.until);
    Ok(serde_json::json!({ "version": VERSION, "seeds": SEEDS, "paths": paths, "spp": spp, "until": until }))
}

/// Renders a frame, which begins with the sums that are kept. Keeps its own sums, even if Ctrl-C ends it.
fn trace(
    prepared: &Prepared,
    checkpoint: &mut Checkpoint,
    (bar, before): (&mut Progress, u32),
) -> Result<(), CompareError> {
    checkpoint.resume(prepared);
    let done = prepared.frame(&mut |done, _| {
        bar.advance_to(u64::from(before) + u64::from(done), "");
        check_interrupted()
    });
    checkpoint.keep(prepared)?;
    Ok(done.map(|_| ())?)
}

fn choose_pairs(prepared: &Prepared, geometry: &Geometry, linear: &StereoPicture, error: &StereoPicture) -> Pairs {
    let surfaces = surfaces_of(prepared, geometry, (linear.width as usize, linear.height as usize));
    let reference = pairs::Reference { linear: linear.eyes(), error: error.eyes() };
    Pairs::choose(&surfaces, &reference)
}

/// The geometry of a prepared view in the form that the metrics take.
pub(super) fn surfaces_of<'a>(
    prepared: &'a Prepared,
    geometry: &'a Geometry,
    (width, height): (usize, usize),
) -> Surfaces<'a> {
    let delta_roughness = prepared.settings().delta_roughness;
    let eyes = [0, 1].map(|eye| surfaces(&geometry.eyes[eye]));
    Surfaces { camera: prepared.camera(), width, height, delta_roughness, eyes }
}

pub(super) fn surfaces(eye: &EyeGeometry) -> EyeSurfaces<'_> {
    EyeSurfaces {
        traced: &eye.traced,
        depth: &eye.depth,
        instance: &eye.instance,
        normal: &eye.normal,
        face_normal: &eye.face_normal,
        roughness: &eye.roughness,
        inverse_hit_distance: &eye.inverse_hit_distance,
    }
}

fn rays(geometry: &Geometry, like: &StereoPicture) -> StereoPicture {
    let eyes = [0, 1].map(|eye| {
        let g = &geometry.eyes[eye];
        let texel = |i: usize| [f32::from(u8::from(g.traced[i])), g.inverse_hit_distance[i], g.depth[i]];
        (0..g.depth.len()).map(texel).collect()
    });
    StereoPicture { width: like.width, height: like.height, eyes }
}

/// A black picture of the same size.
pub(super) fn black(like: &StereoPicture) -> StereoPicture {
    let eyes = [0, 1].map(|eye: usize| vec![[0.0; 3]; like.eyes[eye].len()]);
    StereoPicture { width: like.width, height: like.height, eyes }
}
