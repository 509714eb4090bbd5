//! What is made: comparisons over scenes, each one call of `cyclopean compare`, and how large they are.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::compare::ao::AoOptions;
use crate::compare::{Fallbacks, Options};
use crate::metrics::{Networks, flip};
use crate::render::method::UnknownMethod;
use crate::render::{Ao, AoSettings, Method, Reuse, Settings};
use crate::scene::{Fallback, Shelf};

/// Everything asked of the paper.
#[derive(Debug, Clone)]
pub struct Request {
    /// What is made goes here, and what is kept into its folder `work`.
    pub out: PathBuf,
    /// Where references are kept.
    pub cache: PathBuf,
    /// In the order of the tables.
    pub scenes: Vec<String>,
    pub scale: Scale,
    /// What is made; what is not says so in its place.
    pub parts: Vec<Part>,
    /// Where the sessions lie.
    pub sessions: Vec<PathBuf>,
    pub shelf: Shelf,
    /// Of LPIPS and DISTS, and how a command names them (`--lpips FILE`).
    pub networks: Arc<Networks>,
    pub network_options: Vec<(&'static str, PathBuf)>,
}

/// What can be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// Tables 1 to 3, figures 1 and 9 to 14, ablations, error against time.
    Methods,
    /// The tables and figures of ambient occlusion.
    Ao,
    /// Figures 18 and 19 and the statistics.
    Sessions,
}

/// Sizes and counts.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Scale {
    /// `quick`, `full`.
    pub name: &'static str,
    /// Pixels of one eye.
    pub size: [u32; 2],
    /// Paths a pixel of the reference.
    pub reference_paths: u32,
    /// Rounds of Table 2, of Table 3 and of the modules.
    pub seeds: [u32; 3],
    /// Of ambient occlusion.
    pub ao_size: [u32; 2],
    pub ao_seeds: u32,
    pub ao_poses: u32,
    pub ao_rays: u32,
    /// Of the studies' pictures, and their reference's paths a pixel.
    pub study_size: [u32; 2],
    pub study_paths: u32,
}

impl Scale {
    /// The publications' own.
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

    /// Small enough for two processor cores and ten minutes, large enough that every cell is filled.
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
    /// Its folder.
    pub id: &'static str,
    pub scenes: Vec<String>,
    /// The first is the baseline.
    pub methods: &'static [&'static str],
    pub spp: &'static [u32],
    pub seeds: u32,
    pub edge_fade: f32,
    pub sheets: bool,
}

/// Of frames that only a sheet is made of: the fewest that a comparison takes.
const SHEET_SEEDS: u32 = 2;

/// The comparison that Table 2 is made of.
pub const TABLE_2: &str = "table2";

/// Width of the fade at a view's border, where it is not what is studied.
const EDGE_FADE: f32 = 0.1;

impl Request {
    /// Every comparison of reflections, in the order in which they run.
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
            // Without any fade only the traversal is left of what the two differ in.
            Comparison { edge_fade: 0.0, ..figure("figure11", &["pica"], &["sssr", "stereo-no-reprojection"]) },
            figure("figure12", &["wine"], &["stereo-no-fade", "stereo"]),
            figure("figure13", &["pica"], &["stereo-no-reprojection", "stereo"]),
            figure("figure14", &["room"], &["stereo-no-back-check", "stereo"]),
        ]
    }

    /// Those of the wanted scenes that were asked for; where none was, the first that was.
    fn of(&self, wanted: &[&str]) -> Vec<String> {
        let found: Vec<String> =
            wanted.iter().filter(|w| self.scenes.iter().any(|s| s == *w)).map(|w| (*w).to_owned()).collect();
        if found.is_empty() { self.scenes.iter().take(1).cloned().collect() } else { found }
    }

    /// Where what is made on the way is kept.
    pub fn work(&self) -> PathBuf {
        self.out.join("work")
    }

    /// Where results are kept.
    pub fn kept(&self) -> PathBuf {
        self.work().join("kept")
    }

    /// # Errors
    /// A method's name that is none.
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
            // Only Table 2 has them.
            networks: if of.id == TABLE_2 { Arc::clone(&self.networks) } else { Arc::default() },
            cache: self.cache.clone(),
            keep: Some(self.kept()),
            out: self.out.join(of.id),
            sheets: of.sheets,
            scenes: self.shelf.clone(),
        })
    }

    /// Of ambient occlusion.
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
            scenes: self.shelf.clone(),
        }
    }

    /// The command that makes a comparison alone, or takes it from what is kept.
    pub fn call(&self, of: &Comparison) -> String {
        let [width, height] = self.scale.size;
        let spp: Vec<String> = of.spp.iter().map(u32::to_string).collect();
        let named = self.network_options.iter().filter(|_| of.id == TABLE_2);
        let networks: String = named.map(|(option, file)| format!(" {option} {}", path(file))).collect();
        format!(
            "cyclopean compare {} --size {width}x{height} --spp {} --seeds {} --reference-spp {} --reuse ratio --no-shadows \
             --methods {}{}{}{networks} --keep {} -o {}",
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

    /// The command that analyses the sessions alone.
    pub fn sessions_call(&self) -> Option<String> {
        let folders: Vec<String> = self.sessions.iter().map(|p| path(p)).collect();
        (!folders.is_empty()).then(|| format!("mos report {}", folders.join(" ")))
    }

    /// The same of ambient occlusion.
    pub fn ao_call(&self) -> String {
        let [width, height] = self.scale.ao_size;
        let Scale { ao_seeds, ao_poses, ao_rays, .. } = self.scale;
        format!(
            "cyclopean compare {} --effect ao --size {width}x{height} --seeds {ao_seeds} --poses {ao_poses} --ao-rays {ao_rays} \
             --keep {} -o {}",
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

/// As a shell takes it.
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
            shelf: Shelf::default(),
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
            "cyclopean compare 'a room.gltf' --size 192x108 --spp 1 --seeds 2 --reference-spp 64 --reuse ratio --no-shadows \
             --methods sssr,stereo-no-reprojection --edge-fade 0 --sheets --keep out/work/kept -o out/figure11"
        );
        let table2 = request.call(&request.comparisons()[0]);
        assert!(table2.contains(" --sheets --lpips 'a network.onnx' --keep "), "{table2}");
        assert_eq!(word("it's"), "'it'\\''s'");
    }
}
