//! Ratios over all scenes: geometric means, and which scenes they leave out. The results of the scenes go in and the
//! report's [`Summary`] comes out. `super::compare` calls it after each scene.

use super::ratios::geometric;
use super::report::{SceneReport, SceneWithoutRatio, Summary};

/// The ratio of a measure in one scene, or why it has none.
type Vote<'a> = Result<f64, &'a str>;

/// The geometric means over the scenes. Each scene counts once.
pub fn over_scenes(scenes: &[SceneReport]) -> Vec<Summary> {
    let mut groups: Vec<(Summary, Vec<f64>)> = Vec::new();
    for scene in scenes {
        let mut add = |(method, spp, fallback): (&str, u32, &str), measure: String, vote: Vote<'_>| {
            let same = |s: &Summary| {
                (s.method.as_str(), s.spp, s.fallback.as_str()) == (method, spp, fallback) && s.measure == measure
            };
            let at = groups.iter().position(|(s, _)| same(s)).unwrap_or_else(|| {
                groups.push((Summary::empty(method, spp, fallback, measure), Vec::new()));
                groups.len() - 1
            });
            let (summary, ratios) = &mut groups[at];
            match vote {
                Ok(ratio) => ratios.push(ratio),
                Err(why) => {
                    summary.left_out.push(SceneWithoutRatio { scene: scene.scene.clone(), why: why.to_owned() })
                }
            }
        };
        for r in &scene.overhead {
            add((&r.method, r.spp, &r.fallback), format!("ms_{}", r.group), Ok(r.median));
        }
        for r in &scene.equal_sample {
            add((&r.method, r.spp, &r.fallback), r.measure.to_owned(), Ok(r.ratio));
        }
        for r in &scene.equal_time {
            let own = (r.method.as_str(), r.spp, r.fallback.as_str());
            add(own, "equal_time_mse".to_owned(), Ok(r.ratio));
            let others = [("relmse", r.relmse_ratio), ("tonemapped_mse", r.tonemapped_mse_ratio)];
            for (measure, ratio) in others.into_iter().filter_map(|(m, r)| Some((m, r?))) {
                add(own, format!("equal_time_{measure}"), Ok(ratio));
            }
        }
        for l in &scene.left_out {
            add((&l.method, l.spp, &l.fallback), l.measure.clone(), Err(&l.why));
        }
    }
    groups.into_iter().map(|(summary, ratios)| summary.of(&ratios)).collect()
}

impl Summary {
    fn empty(method: &str, spp: u32, fallback: &str, measure: String) -> Summary {
        Summary {
            method: method.to_owned(),
            spp,
            fallback: fallback.to_owned(),
            measure,
            geomean: None,
            interval: None,
            worst: None,
            scenes: 0,
            left_out: Vec::new(),
        }
    }

    fn of(self, ratios: &[f64]) -> Summary {
        let logs: Vec<f64> = ratios.iter().map(|r| r.ln()).collect();
        let (geomean, interval) = geometric(&logs);
        let worst = ratios.iter().copied().max_by(f64::total_cmp);
        Summary { geomean, interval, worst, scenes: ratios.len(), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::super::report::MissingRatio;
    use super::super::sample::{ratio, row, scene};
    use super::*;

    #[test]
    fn a_scene_without_a_ratio_is_named() {
        let stereo = row("stereo", 1, 1.0, &[]);
        let mut scenes = ["pica", "room", "wine"].map(|name| scene(name, vec![stereo.clone()]));
        scenes[0].equal_sample.push(ratio(&stereo, "noise_variance", 0.5));
        scenes[1].equal_sample.push(ratio(&stereo, "noise_variance", 2.0));
        scenes[2].left_out.push(MissingRatio::of(&stereo, "noise_variance".to_owned(), "nothing to divide by"));
        scenes.iter_mut().for_each(|s| s.left_out.push(MissingRatio::of(&stereo, "mse".to_owned(), "undefined")));
        let found = over_scenes(&scenes);
        let of = |measure: &str| found.iter().find(|s| s.measure == measure).expect("a summary");
        let noise = of("noise_variance");
        assert!((noise.geomean.expect("two scenes") - 1.0).abs() < 1e-12);
        assert_eq!((noise.scenes, noise.worst), (2, Some(2.0)));
        assert_eq!(
            noise.left_out,
            [SceneWithoutRatio { scene: "wine".to_owned(), why: "nothing to divide by".to_owned() }]
        );
        let mse = of("mse");
        assert_eq!((mse.geomean, mse.worst, mse.scenes, mse.left_out.len()), (None, None, 0, 3));
    }
}
