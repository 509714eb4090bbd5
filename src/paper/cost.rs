//! Estimates how long the work takes on this device. The amount of work in each piece is multiplied by speeds that a
//! short probe has measured. A [`Request`] goes in; the command `paper` calls it and prints the result.

use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::PaperError;
use super::plan::{Comparison, Request};
use crate::compare::ao::{self, AoOptions};
use crate::compare::{self, Options};
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::{AoSettings, Method, Settings};

/// An amount of work. Pixels, rays and paths are those of both eyes together, in millions.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Workload {
    /// The number of scenes that are loaded and prepared.
    pub scenes: f64,
    /// The pixels that are drawn, resolved and measured.
    pub frames: f64,
    /// The rays through the views.
    pub rays: f64,
    /// The paths or rays through the geometry.
    pub paths: f64,
}

/// A piece of work that is made and kept as a whole: one scene of one comparison, or one study.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Its name, such as `table2 room`.
    pub name: String,
    pub kind: Kind,
    pub load: Workload,
    /// The command that makes it.
    pub call: String,
}

/// The kind of work, which says by which speeds a load is multiplied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Reflections,
    Ambient,
}

/// The seconds for one unit of each part of a [`Workload`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    scene: f64,
    frames: f64,
    rays: f64,
    paths: f64,
}

/// The speeds of both kinds of work, with the scene and the device that they were measured with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Speeds {
    pub scene: String,
    pub device: String,
    reflections: Speed,
    ambient: Speed,
}

impl Speed {
    fn seconds(&self, of: &Workload) -> f64 {
        of.scenes * self.scene + of.frames * self.frames + of.rays * self.rays + of.paths * self.paths
    }
}

impl Speeds {
    /// The expected seconds of a piece.
    pub fn of(&self, piece: &Piece) -> f64 {
        match piece.kind {
            Kind::Reflections => self.reflections.seconds(&piece.load),
            Kind::Ambient => self.ambient.seconds(&piece.load),
        }
    }
}

/// The pixels of both eyes, in millions.
pub fn pixels([width, height]: [u32; 2]) -> f64 {
    2.0 * f64::from(width) * f64::from(height) / 1e6
}

/// The pieces of the comparisons and of ambient occlusion, in the order in which they are made.
///
/// # Errors
/// A name that belongs to no method.
pub fn pieces(request: &Request) -> Result<Vec<Piece>, PaperError> {
    let mut all: Vec<Piece> = Vec::new();
    let mut referenced: Vec<String> = Vec::new();
    for comparison in request.comparisons() {
        for scene in &comparison.scenes {
            // All comparisons of a scene share its two references.
            let is_new = !referenced.contains(scene);
            let reference = if is_new { 2.0 * f64::from(request.scale.reference_paths) } else { 0.0 };
            let load = reflections(&comparison, request.scale.size, reference)?;
            all.push(Piece {
                name: format!("{} {scene}", comparison.id),
                kind: Kind::Reflections,
                load,
                call: request.call(&comparison),
            });
            referenced.push(scene.clone());
        }
    }
    if request.parts.contains(&super::plan::Part::Ao) {
        let load = ambient(&request.ao_options());
        let piece =
            |scene: &String| Piece { name: format!("ao {scene}"), kind: Kind::Ambient, load, call: request.ao_call() };
        all.extend(request.scenes.iter().map(piece));
    }
    Ok(all)
}

/// The load of one scene of a comparison. `reference` is the number of paths a pixel that must be traced for
/// references.
fn reflections(of: &Comparison, size: [u32; 2], reference: f64) -> Result<Workload, PaperError> {
    let pixels = pixels(size);
    // One round before the first warms up, and a sheet takes one more frame.
    let rounds = f64::from(of.seeds + 1 + u32::from(of.sheets));
    let mut load =
        Workload { scenes: if of.sheets { 2.0 } else { 1.0 }, paths: reference * pixels, ..Workload::default() };
    let mut seen: Vec<Method> = Vec::new();
    for (name, spp) in of.methods.iter().flat_map(|m| of.spp.iter().map(move |spp| (m, *spp))) {
        let method = Method::parse(name)?.with_samples(Some(spp));
        if seen.contains(&method) {
            continue;
        }
        let samples = f64::from(method.samples());
        load.frames += rounds * pixels;
        if name.starts_with("path-traced") {
            load.paths += rounds * pixels * samples;
        } else {
            load.rays += rounds * pixels * samples;
        }
        seen.push(method);
    }
    Ok(load)
}

fn ambient(options: &AoOptions) -> Workload {
    let pixels = pixels([options.settings.width, options.settings.height]);
    let configurations = ao::configuration_count(options.settings.ao) as f64;
    let along = 4.0 * f64::from(options.poses);
    let frames = f64::from(options.seeds + 1) * configurations + along;
    Workload { scenes: 1.0, frames: frames * pixels, rays: 0.0, paths: f64::from(options.settings.ao.rays) * pixels }
}

/// The load of the studies' pictures: `stills` pictures by methods of the views and `references` path-traced pictures,
/// in `scenes` scenes.
pub fn stills(request: &Request, stills: usize, references: usize, scenes: usize) -> Workload {
    let pixels = pixels(request.scale.study_size);
    let paths = f64::from(request.scale.study_paths);
    Workload {
        scenes: scenes as f64,
        frames: (stills + references) as f64 * pixels,
        rays: stills as f64 * pixels,
        paths: references as f64 * paths * pixels,
    }
}

/// The speeds that were measured on this device before. If there are none, a probe of a minute or two measures them,
/// and they are kept.
///
/// # Errors
/// The first scene cannot be compared, or a file cannot be written.
pub fn speeds(gpu: &Rc<Gpu>, request: &Request, console: &Console) -> Result<Speeds, PaperError> {
    let file = request.work().join("probe.json");
    let device = format!("{} ({})", gpu.info().name, gpu.info().driver);
    let scene = request.scenes.first().cloned().unwrap_or_default();
    let known = cyclopean_analysis::files::read(&file, 1 << 16).ok();
    let known = known.and_then(|bytes| serde_json::from_slice::<Speeds>(&bytes).ok());
    if let Some(known) = known.filter(|k| k.device == device && k.scene == scene) {
        return Ok(known);
    }
    console.note(format!("measuring how long the work takes on {device}, in {scene}"));
    let folder = request.work().join("probe");
    let found = probe(gpu, request, &scene, &folder, console);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|source| PaperError::Folder { path: folder.clone(), source })?;
    }
    let (reflections, ambient) = found?;
    let found = Speeds { scene, device, reflections, ambient };
    super::make_folder(&request.work())?;
    cyclopean_analysis::files::write_bytes(&file, &serde_json::to_vec_pretty(&found)?)?;
    Ok(found)
}

/// Measures the speeds by small comparisons, which differ from each other in their pixels, paths or rays alone.
fn probe(
    gpu: &Rc<Gpu>,
    request: &Request,
    scene: &str,
    folder: &Path,
    console: &Console,
) -> Result<(Speed, Speed), PaperError> {
    let (small, large) = ([96, 54], [240, 135]);
    let reflections_of = |size: [u32; 2], spp: &'static [u32], paths: u32| -> Result<(Workload, f64), PaperError> {
        let (id, scenes, methods) = ("probe", vec![scene.to_owned()], &["sssr", "stereo"][..]);
        let comparison = Comparison { id, scenes, methods, spp, seeds: 2, edge_fade: 0.1, sheets: false };
        let asked = request.options(&comparison)?;
        let settings = Settings { width: size[0], height: size[1], ..asked.settings };
        let reference = asked.reference.with_exactly(paths);
        // Each comparison has a cache of its own, so that it finds no reference of an earlier one.
        let cache = folder.join(format!("{}-{}-{paths}", size[0], spp[0]));
        let options = Options { settings, reference, cache, keep: None, networks: Default::default(), ..asked };
        let started = Instant::now();
        compare::scene(gpu, scene, &options, console)?;
        Ok((reflections(&comparison, size, 2.0 * f64::from(paths))?, started.elapsed().as_secs_f64()))
    };
    let ambient_of = |size: [u32; 2], rays: u32| -> Result<(Workload, f64), PaperError> {
        let asked = request.ao_options();
        let settings = Settings {
            width: size[0],
            height: size[1],
            ao: AoSettings { rays, ..asked.settings.ao },
            ..asked.settings
        };
        let options = AoOptions { settings, seeds: 1, poses: 0, keep: None, ..asked };
        let started = Instant::now();
        ao::scene(gpu, scene, &options, console)?;
        Ok((ambient(&options), started.elapsed().as_secs_f64()))
    };
    // The first comparison also compiles the pipelines, so its time is not used.
    reflections_of(small, &[2], 4)?;
    let reflections = solve([
        reflections_of(small, &[1], 4)?,
        reflections_of(large, &[1], 4)?,
        reflections_of(large, &[4], 4)?,
        reflections_of(large, &[1], 24)?,
    ]);
    ambient_of(small, 2)?;
    let (one, two, three) = (ambient_of(small, 4)?, ambient_of(large, 4)?, ambient_of(large, 32)?);
    Ok((reflections, solve([one, two, two, three])))
}

/// The speed that explains four measurements: a small one, one with more pixels, and two that differ from the second in
/// their rays and in their paths. A value that noise makes negative is set to 0.
fn solve([small, large, rays, paths]: [(Workload, f64); 4]) -> Speed {
    let slope = |of: fn(&Workload) -> f64, more: (Workload, f64)| {
        let units = of(&more.0) - of(&large.0);
        if units > 0.0 { ((more.1 - large.1) / units).max(0.0) } else { 0.0 }
    };
    let (per_ray, per_path) = (slope(|l| l.rays, rays), slope(|l| l.paths, paths));
    let rest = |(load, seconds): (Workload, f64)| seconds - load.rays * per_ray - load.paths * per_path;
    let units = large.0.frames - small.0.frames;
    let per_frame = if units > 0.0 { ((rest(large) - rest(small)) / units).max(0.0) } else { 0.0 };
    let scenes = small.0.scenes.max(1.0);
    let scene = ((rest(small) - small.0.frames * per_frame) / scenes).max(0.0);
    Speed { scene, frames: per_frame, rays: per_ray, paths: per_path }
}

/// A time in words, such as `about 3 minutes`.
pub fn in_words(seconds: f64) -> String {
    let rounded = |n: f64| if n < 9.5 { format!("{n:.1}") } else { format!("{n:.0}") };
    match seconds {
        s if s < 90.0 => format!("about {s:.0} seconds"),
        s if s < 5400.0 => format!("about {:.0} minutes", s / 60.0),
        s if s < 172_800.0 => format!("about {} hours", rounded(s / 3600.0)),
        s => format!("about {} days", rounded(s / 86_400.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_is_found_from_four_measurements() {
        let truth = Speed { scene: 2.0, frames: 0.5, rays: 0.25, paths: 0.125 };
        let load = |frames, rays, paths| Workload { scenes: 1.0, frames, rays, paths };
        let loads = [load(1.0, 1.0, 2.0), load(9.0, 9.0, 18.0), load(9.0, 36.0, 18.0), load(9.0, 9.0, 288.0)];
        let found = solve(loads.map(|l| (l, truth.seconds(&l))));
        for (a, b) in [(found.scene, 2.0), (found.frames, 0.5), (found.rays, 0.25), (found.paths, 0.125)] {
            assert!((a - b).abs() < 1e-9, "{found:?}");
        }
        // No speed is negative, even if the noise of the machine is larger than the differences.
        let noisy = solve(loads.map(|l| (l, 5.0 - 0.01 * l.frames)));
        assert!([noisy.scene, noisy.frames, noisy.rays, noisy.paths].iter().all(|s| *s >= 0.0), "{noisy:?}");
    }

    #[test]
    fn times_are_said_in_their_unit() {
        let said: Vec<String> = [40.0, 200.0, 7200.0, 100_000.0, 900_000.0].map(in_words).to_vec();
        assert_eq!(said, ["about 40 seconds", "about 3 minutes", "about 2.0 hours", "about 28 hours", "about 10 days"]);
    }

    #[test]
    fn a_load_counts_every_frame_once() {
        let of = |methods, spp| Comparison {
            id: "x",
            scenes: vec!["room".to_owned()],
            methods,
            spp,
            seeds: 3,
            edge_fade: 0.1,
            sheets: false,
        };
        // There are a million pixels in both eyes together, and three rounds after one that warms up.
        let load = reflections(&of(&["sssr", "stereo", "path-traced@2"], &[1, 4]), [1000, 500], 64.0).expect("methods");
        assert_eq!(load, Workload { scenes: 1.0, frames: 20.0, rays: 40.0, paths: 64.0 + 8.0 });
    }
}
