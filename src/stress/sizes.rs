//! Cases of pictures of odd sizes and of wide views: the padding of the depth pyramid, workgroups that reach beyond the
//! picture, and rays next to its border.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use crate::render::{RenderError, Settings};
use crate::scene::{Fallback, LightSource};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::{farthest_from, most, relative_squared_error};
use super::shapes::{furnace, hall, look, material, plane, scene, settings, stripes};

pub const CASES: &[Case] = &[
    Case {
        name: "odd-sizes",
        hazard: "a picture is smaller than a cell of the pyramid, or not a whole number of cells",
        checks: "a mirror floor in a white world, sizes from 1×1 to 127×65: distance from white",
        unit: "radiance, where 1 is white",
        bound: Bound::AtMost(2e-3),
        run: mirror,
    },
    Case {
        name: "odd-sizes-against-reference",
        hazard: "the pyramid loses its last row or column",
        checks: "63×47, 65×64 and 127×83 with 16 rays: squared error against the reference over that at an even size",
        unit: "ratio",
        bound: Bound::AtMost(1.3),
        run: against_reference,
    },
    Case {
        name: "one-pixel-lines",
        hazard: "pixels have no neighbours in a picture that is one pixel wide or high",
        checks: "a hall in 1×64, 64×1 and 1×1 pixels: the most light in a pixel",
        unit: "radiance",
        bound: Bound::AtMost(2.0),
        run: lines,
    },
    Case {
        name: "wide-view",
        hazard: "the tangent of half the view grows without bound",
        checks: "views of 170° and of 0.01°: the most that a polished ball reflects of a white world",
        unit: "radiance, where 1 is white",
        bound: Bound::AtMost(1.02),
        run: wide,
    },
];

fn mirror(bench: &mut Bench) -> Result<Worst, RenderError> {
    let view = look(DVec3::new(0.0, 1.0, 1.0), DVec3::ZERO);
    let floor = Arc::new(scene(vec![(plane(4), material(0.0), DAffine3::IDENTITY)], 1.0, view));
    let mut worst = Worst::largest();
    for (width, height) in [(1, 1), (1, 2), (3, 5), (7, 1), (1, 65), (63, 64), (127, 65)] {
        for method in ["sssr", "stereo", "path-traced@1"] {
            let white = Settings { fallback: Some(Fallback::Environment), ..settings(width, height) };
            let label = format!("{width}x{height}");
            let rendered = bench.render(&label, &floor, method, &white)?;
            worst.include(farthest_from(&rendered.linear, 1.0), format!("{label}, {method}"));
        }
    }
    Ok(worst)
}

fn against_reference(bench: &mut Bench) -> Result<Worst, RenderError> {
    let stripes = Arc::new(stripes(0.35, 1.0));
    let mut worst = Worst::largest();
    let mut error = |(width, height): (u32, u32), method: &str| -> Result<f64, RenderError> {
        let (label, settings) = (format!("{width}x{height}"), settings(width, height));
        let reference = bench.render(&label, &stripes, "path-traced@256", &settings)?;
        let rendered = bench.render(&label, &stripes, method, &settings)?;
        Ok(relative_squared_error(&rendered.reflection, &reference.reflection))
    };
    for (odd, even) in [((63, 47), (64, 48)), ((65, 64), (64, 64)), ((127, 83), (128, 84))] {
        // The published estimator has about the same error at all sizes. The error of the default one is so small that
        // it depends on a few pixels at the border, whose rays leave the view.
        for method in ["sssr-ratio@16", "stereo-ratio@16"] {
            let (a, b) = (error(odd, method)?, error(even, method)?);
            worst.include(a / b, format!("{}x{}, {method}: {a:.4} and {b:.4}", odd.0, odd.1));
        }
    }
    Ok(worst)
}

fn lines(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut hall = hall(0.3, 0.064);
    hall.lights.push(LightSource::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(0.1) }.into());
    let hall = Arc::new(hall);
    let mut worst = Worst::largest();
    for (width, height) in [(1, 64), (64, 1), (1, 1)] {
        for method in ["sssr@2", "stereo", "path-traced@4"] {
            let label = format!("{width}x{height}");
            let rendered = bench.render(&label, &hall, method, &settings(width, height))?;
            worst.include(most(&rendered.linear), format!("{label}, {method}"));
        }
    }
    Ok(worst)
}

fn wide(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for degrees in [170.0f64, 0.01] {
        let mut ball = furnace(0.1);
        ball.views[0] = look(DVec3::new(0.3, 0.2, 1.2), DVec3::ZERO);
        ball.views[0].vertical_fov_rad = degrees.to_radians();
        let ball = Arc::new(ball);
        for method in ["sssr", "stereo", "path-traced@16"] {
            let white = Settings { fallback: Some(Fallback::Environment), ..settings(65, 65) };
            let rendered = bench.render(&format!("{degrees}°"), &ball, method, &white)?;
            worst.include(most(&rendered.linear), format!("{degrees}°, {method}"));
        }
    }
    Ok(worst)
}
