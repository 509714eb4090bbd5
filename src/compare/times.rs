//! Sums the times of a frame's passes into the groups that are reported. The comparisons call it for every frame.

use std::collections::BTreeMap;

use crate::gpu::PassTime;

/// The passes that do not belong to reflections and are the same for every method.
const SHARED: [&str; 7] = ["gbuffer", "lights", "shadows", "indirect", "shading_reuse", "lighting", "composite"];

/// The beginning of the names of the passes of ambient occlusion. They do not belong to reflections either.
const AMBIENT: &str = "ao_";

/// Milliseconds by group. `total` is everything for reflections. `trace` and `resolve` are all passes of that stage,
/// and `trace_resolve` is both together. Every other pass is under its own name.
pub type Groups = BTreeMap<String, f64>;

/// Sums the passes of a frame by group.
pub fn groups(passes: &[PassTime]) -> Groups {
    let mut sums: Groups = ["total", "trace", "resolve", "trace_resolve"].map(|g| (g.to_owned(), 0.0)).into();
    let shared = |pass: &&PassTime| SHARED.contains(&pass.name.as_str()) || pass.name.starts_with(AMBIENT);
    for pass in passes.iter().filter(|p| !shared(p)) {
        let group = match pass.name.as_str() {
            name if name.starts_with("trace") || name.starts_with("path_") => "trace",
            name if name.starts_with("resolve") || ["accumulate", "reproject"].contains(&name) => "resolve",
            name => name,
        };
        let mut add = |group: &str| *sums.entry(group.to_owned()).or_default() += pass.ms;
        add("total");
        add(group);
        if ["trace", "resolve"].contains(&group) {
            add("trace_resolve");
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_summed_and_shared_passes_left_out() {
        let passes = [
            ("gbuffer", 100.0),
            ("backface", 1.0),
            ("shadows", 100.0),
            ("ao_filter", 100.0),
            ("lighting", 100.0),
            ("classify", 2.0),
            ("depth_pyramid", 4.0),
            ("trace", 8.0),
            ("trace_other_eye", 16.0),
            ("resolve", 32.0),
            ("reproject", 64.0),
            ("composite", 100.0),
        ];
        let found = groups(&passes.map(|(name, ms)| PassTime { name: name.to_owned(), ms }));
        assert_eq!(found["total"], 127.0);
        assert_eq!((found["trace"], found["resolve"], found["trace_resolve"]), (24.0, 96.0, 120.0));
        assert_eq!((found["backface"], found["depth_pyramid"], found["classify"]), (1.0, 4.0, 2.0));
        assert!(!found.contains_key("trace_other_eye") && !found.contains_key("gbuffer"));
    }
}
