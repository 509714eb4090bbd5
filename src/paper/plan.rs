//! The plan of the page: which comparisons are made over which scenes, and how large they are. A [`Request`] goes in.
//! The options of each comparison come out, and the call of `cyclopean compare` that makes it alone. `run` and `cost`
//! call it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::compare::ao::AoOptions;
use crate::compare::{Fallbacks, Options};
use crate::metrics::{Networks, flip};
use crate::render::method::UnknownMethod;
use crate::render::{Ao, AoSettings, Method, Reuse, Settings};
use crate::scene::{Fallback, SceneCache};

/// Everything that the page is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// The folder of the page. What is kept between runs goes into its folder `work`.
    pub out: PathBuf,
    /// The folder in which references are kept.
    pub cache: PathBuf,
    /// The scenes in the order of the tables.
    pub scenes: Vec<String>,
    pub scale: Scale,
    /// The parts that are made. The cells of the other parts say that they were left out.
    pub parts: Vec<Part>,
    /// Folders or journals of sessions.
    pub sessions: Vec<PathBuf>,
    pub scene_cache: SceneCache,
    /// The networks of LPIPS and DISTS, then the options that name them in a command (`--lpips FILE`).
    pub networks: Arc<Networks>,
    pub network_options: Vec<(&'static str, PathBuf)>,
}

/// A part of the page that can be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// Tables 1 to 3, figures 1 and 9 to 14, the ablation of modules, and error against time.
    Methods,
    /// The tables and figures of ambient occlusion.
    Ao,
    /// Figures 18 and 19, and the statistics of the studies.
    Sessions,
}

/// The sizes and counts of everything that is made.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Scale {
    /// `quick` or `full`.
    pub name: &'static str,
    /// Pixels of one eye.
    pub size: [u32; 2],
    /// The paths a pixel of the reference.
    pub reference_paths: u32,
    /// The rounds of Table 2, of Table 3 and of the modules.
    pub seeds: [u32; 3],
    /// The sizes and counts of ambient occlusion.
    pub ao_size: [u32; 2],
    pub ao_seeds: u32,
    pub ao_poses: u32,
    pub ao_rays: u32,
    /// The size of the studies' pictures, then the paths a pixel of their reference.
    pub study_size: [u32; 2],
    pub study_paths: u32,
}

impl Scale {
    /// The sizes and counts of the publications.
    pub const FULL: Scale = Scale {
        name: "full",
        size: [1920, 1080],
        reference_paths: 1024,
        seeds: [64, 100, 64],
        ao_size: [1254, 1254],
        ao_seeds: 16,
        ao_poses: 100,
        ao_rays: 256,
        study_size: [1920, 1080],
        study_paths: 1024,
    };

    /// Small enough for two processor cores and ten minutes, but large enough that every cell is filled.
    pub const QUICK: Scale = Scale {
        name: "quick",
        size: [192, 108],
        reference_paths: 64,
        seeds: [4, 4, 4],
        ao_size: [128, 128],
        ao_seeds: 2,
        ao_poses: 10,
        ao_rays: 32,
        study_size: [240, 135],
        study_paths: 16,
    };
}

/// One call of `cyclopean compare`.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Its name, which is also that of its folder.
    pub id: &'static str,
    pub scenes: Vec<String>,
    /// The first is the baseline.
    pub methods: &'static [&'static str],
    pub spp: &'static [u32],
    pub seeds: u32,
    pub edge_fade: f32,
    pub sheets: bool,
}

/// The rounds of comparisons that are made only for their sheets: as few as a comparison allows.
const SHEET_SEEDS: u32 = 2;

/// The comparison from which Table 2 is made.
pub const TABLE_2: &str = "table2";

/// The width of the fade at the border of a view, unless the fade itself is studied.
const EDGE_FADE: f32 = 0.1;

impl Request {
    /// The comparisons of reflections, in the order in which they run.
    pub fn comparisons(&self) -> Vec<Comparison> {
        if !self.parts.contains(&Part::Methods) {
            return Vec::new();
        }
        let [table2, table3, modules] = self.scale.seeds;
        let all = |id, methods, spp, seeds, sheets| Comparison {
            id,
            scenes: self.scenes.clone(),
            methods,
            spp,
            seeds,
            edge_fade: EDGE_FADE,
            sheets,
        };
        let figure = |id, scenes: &[&str], methods| Comparison {
            scenes: self.of(scenes),
            ..all(id, methods, &[1], SHEET_SEEDS, true)
        };
        vec![
            all(TABLE_2, &["sssr", "stereo"], &[1], table2, true),
            all("table3", &["sssr", "stereo", "path-traced@2"], &[1, 2, 4], table3, false),
            all(
                "modules",
                &["stereo", "stereo-no-traversal", "stereo-no-fade", "stereo-no-reprojection", "stereo-no-back-check"],
                &[1],
                modules,
                false,
            ),
            figure("figure10", &["room", "wine", "pica"], &["sssr@1", "sssr@2", "stereo@1"]),
            // These two methods differ in the fade and the traversal. Without any fade only the traversal is left.
            Comparison { edge_fade: 0.0, ..figure("figure11", &["pica"], &["sssr", "stereo-no-reprojection"]) },
            figure("figure12", &["wine"], &["stereo-no-fade", "stereo"]),
            figure("figure13", &["pica"], &["stereo-no-reprojection", "stereo"]),
            figure("figure14", &["room"], &["stereo-no-back-check", "stereo"]),
        ]
    }

    /// Those of the wanted scenes that were asked for. If none of them was, the first scene that was.
    fn of(&self, wanted: &[&str]) -> Vec<String> {
        let found: Vec<String> =
            wanted.iter().filter(|w| self.scenes.iter().any(|s| s == *w)).map(|w| (*w).to_owned()).collect();
        if found.is_empty() { self.scenes.iter().take(1).cloned().collect() } else { found }
    }

    /// The folder for what is kept between runs.
    pub fn work(&self) -> PathBuf {
        self.out.join("work")
    }

    /// The folder in which results are kept.
    pub fn kept(&self) -> PathBuf {
        self.work().join("kept")
    }

    /// The options of a comparison.
    ///
    /// # Errors
    /// A name that belongs to no method.
    pub fn options(&self, of: &Comparison) -> Result<Options, UnknownMethod> {
        let [width, height] = self.scale.size;
        let (edge_fade, reuse) = (of.edge_fade, Reuse::Ratio);
        Ok(Options {
            methods: of.methods.iter().map(|m| Method::parse(m)).collect::<Result<_, _>>()?,
            spp: of.spp.to_vec(),
            seeds: of.seeds,
            reference: Method::parse("path-traced")?.with_samples(Some(self.scale.reference_paths)),
            until: None,
            settings: Settings { width, height, edge_fade, reuse, shadows: false, seed: 0, ..Settings::default() },
            fallback: Fallbacks::One(Fallback::Black),
            view: None,
            pixels_per_degree: flip::PIXELS_PER_DEGREE,
            // Only Table 2 shows LPIPS and DISTS.
            networks: if of.id == TABLE_2 { Arc::clone(&self.networks) } else { Arc::default() },
            cache: self.cache.clone(),
            keep: Some(self.kept()),
            out: self.out.join(of.id),
            sheets: of.sheets,
            scenes: self.scene_cache.clone(),
        })
    }

    /// The options of the comparison of ambient occlusion.
    pub fn ao_options(&self) -> AoOptions {
        let [width, height] = self.scale.ao_size;
        let ao = AoSettings { method: Ao::None, rays: self.scale.ao_rays, ..AoSettings::default() };
        AoOptions {
            settings: Settings { width, height, ao, seed: 0, ..Settings::default() },
            seeds: self.scale.ao_seeds,
            poses: self.scale.ao_poses,
            view: None,
            keep: Some(self.kept()),
            out: self.out.join("ao"),
            scenes: self.scene_cache.clone(),
        }
    }

    /// The command that makes a comparison alone, or takes its results from those that are kept.
    pub fn call(&self, of: &Comparison) -> String {
        let [width, height] = self.scale.size;
        let spp: Vec<String> = of.spp.iter().map(u32::to_string).collect();
        let named = self.network_options.iter().filter(|_| of.id == TABLE_2);
        let networks: String = named.map(|(option, file)| format!(" {option} {}", path(file))).collect();
        format!(
            "cyclopean compare {} --size {width}x{height} --spp {} --seeds {} --reference-spp {} --reuse ratio \
             --no-shadows --methods {}{}{}{networks} --keep {} -o {}",
            words(&of.scenes),
            spp.join(","),
            of.seeds,
            self.scale.reference_paths,
            of.methods.join(","),
            if of.edge_fade == EDGE_FADE { String::new() } else { format!(" --edge-fade {}", of.edge_fade) },
            if of.sheets { " --sheets" } else { "" },
            path(&self.kept()),
            path(&self.out.join(of.id)),
        )
    }

    /// The command that only analyses the sessions.
    pub fn sessions_call(&self) -> Option<String> {
        let folders: Vec<String> = self.sessions.iter().map(|p| path(p)).collect();
        (!folders.is_empty()).then(|| format!("mos report {}", folders.join(" ")))
    }

    /// The command that makes the comparison of ambient occlusion alone.
    pub fn ao_call(&self) -> String {
        let [width, height] = self.scale.ao_size;
        let Scale { ao_seeds, ao_poses, ao_rays, .. } = self.scale;
        format!(
            "cyclopean compare {} --effect ao --size {width}x{height} --seeds {ao_seeds} --poses {ao_poses} --ao-rays \
             {ao_rays} --keep {} -o {}",
            words(&self.scenes),
            path(&self.kept()),
            path(&self.out.join("ao")),
        )
    }
}

fn path(path: &Path) -> String {
    word(&path.display().to_string())
}

fn words(all: &[String]) -> String {
    all.iter().map(|w| word(w)).collect::<Vec<_>>().join(" ")
}

/// A word as a shell takes it, in quotes where that is needed.
fn word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "._-/@+=:,".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(scenes: &[&str]) -> Request {
        Request {
            out: "out".into(),
            cache: "cache".into(),
            scenes: scenes.iter().map(|s| (*s).to_owned()).collect(),
            scale: Scale::QUICK,
            parts: vec![Part::Methods, Part::Ao, Part::Sessions],
            sessions: Vec::new(),
            scene_cache: SceneCache::default(),
            networks: Arc::default(),
            network_options: Vec::new(),
        }
    }

    #[test]
    fn every_method_is_one_and_every_figure_has_a_scene() {
        for scenes in [&["pica", "room", "wine", "pink", "temple"][..], &["room"], &["mine.gltf", "wine"]] {
            let request = request(scenes);
            let all = request.comparisons();
            for comparison in &all {
                request.options(comparison).expect("known methods");
                assert!(!comparison.scenes.is_empty(), "{}", comparison.id);
                assert!(comparison.scenes.iter().all(|s| scenes.contains(&s.as_str())), "{}", comparison.id);
            }
            let mut ids: Vec<_> = all.iter().map(|c| c.id).collect();
            ids.sort_unstable();
            ids.dedup();
            assert_eq!(ids.len(), all.len(), "two comparisons would write into one folder");
        }
        assert_eq!(request(&["room"]).comparisons()[5].scenes, ["room"], "there is no wine");
        let figure10 = request(&["pica", "room", "wine"]).comparisons();
        assert_eq!(figure10.iter().find(|c| c.id == "figure10").expect("it").scenes, ["room", "wine", "pica"]);
    }

    #[test]
    fn a_call_is_what_a_shell_takes() {
        let mut request = request(&["a room.gltf"]);
        request.network_options = vec![("--lpips", "a network.onnx".into())];
        let call = request.call(&request.comparisons()[4]);
        assert_eq!(
            call,
            "cyclopean compare 'a room.gltf' --size 192x108 --spp 1 --seeds 2 --reference-spp 64 --reuse ratio \
             --no-shadows --methods sssr,stereo-no-reprojection --edge-fade 0 --sheets --keep out/work/kept -o \
             out/figure11"
        );
        let table2 = request.call(&request.comparisons()[0]);
        assert!(table2.contains(" --sheets --lpips 'a network.onnx' --keep "), "{table2}");
        assert_eq!(word("it's"), "'it'\\''s'");
    }
}
