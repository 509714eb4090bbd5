//! The OpenXR calls that reached the runtime, as two API layers between it and the program recorded them.

use std::path::{Path, PathBuf};

/// The layers core validation and API dump, which write into a folder.
pub struct Witness {
    folder: PathBuf,
}

/// One call of `xrEndFrame`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ended {
    /// The frame's display time, an `XrTime`.
    pub display_ns: i64,
    pub layers: usize,
}

impl Witness {
    pub fn in_folder(folder: &Path) -> Witness {
        Witness { folder: folder.to_owned() }
    }

    /// The environment variables that make the loader use the layers.
    pub fn environment(&self) -> Vec<(&'static str, String)> {
        let file = |name: &str| self.folder.join(name).display().to_string();
        vec![
            ("XR_ENABLE_API_LAYERS", "XR_APILAYER_LUNARG_core_validation:XR_APILAYER_LUNARG_api_dump".to_owned()),
            ("XR_CORE_VALIDATION_EXPORT_TYPE", "text".to_owned()),
            ("XR_CORE_VALIDATION_FILE_NAME", file("validation.txt")),
            ("XR_API_DUMP_EXPORT_TYPE", "text".to_owned()),
            ("XR_API_DUMP_FILE_NAME", file("calls.txt")),
        ]
    }

    /// The errors and warnings of the validation layer.
    pub fn complaints(&self) -> Vec<String> {
        let text = std::fs::read_to_string(self.folder.join("validation.txt")).expect("the validation layer ran");
        assert!(text.contains("Core Validation Layer is initialized"), "{text}");
        text.lines().filter(|l| l.contains("VALID_") && !l.contains("VALID_DEBUG")).map(str::to_owned).collect()
    }

    /// Every frame that the program ended, in order.
    pub fn frames(&self) -> Vec<Ended> {
        let text = std::fs::read_to_string(self.folder.join("calls.txt")).expect("the dump layer ran");
        let (mut out, mut display_ns) = (Vec::new(), None);
        for line in text.lines() {
            if let Some((_, value)) = line.split_once("frameEndInfo->displayTime = ") {
                display_ns = Some(value.trim().parse().expect("a time"));
            }
            if let Some((_, value)) = line.split_once("frameEndInfo->layerCount = 0x") {
                let layers = usize::from_str_radix(value.trim(), 16).expect("a number");
                out.push(Ended { display_ns: display_ns.take().expect("a display time before it"), layers });
            }
        }
        out
    }

    /// The runs of successive frames with this number of layers. Each has its number of frames, its first and its last
    /// time.
    pub fn runs(&self, layers: usize) -> Vec<(u64, i64, i64)> {
        let frames = self.frames();
        let runs = frames.chunk_by(|a, b| a.layers == b.layers).filter(|run| run[0].layers == layers);
        runs.map(|run| (run.len() as u64, run[0].display_ns, run[run.len() - 1].display_ns)).collect()
    }
}
