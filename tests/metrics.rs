//! Compares SSIM with numbers of scikit-image, and FLIP with NVIDIA's own code (the crate `nv_flip`). Needs no GPU.

use cyclopean::metrics::{Flip, Ssim};

/// A smooth pattern with values in [0, 1]. `k` chooses the pattern.
fn pattern(width: usize, height: usize, k: f64) -> Vec<[f32; 3]> {
    texels(width, height, |x, y, c| {
        let wave = ((0.31 * k + 0.7) * x + 0.23 * (c + 1.0) * y + 0.011 * k * x * y).sin();
        0.5 + 0.5 * wave * (0.05 * y * k + c).cos()
    })
}

/// The same pattern with a fine disturbance.
fn disturbed(width: usize, height: usize, k: f64) -> Vec<[f32; 3]> {
    let base = pattern(width, height, k);
    texels(width, height, |x, y, c| {
        let value = f64::from(base[y as usize * width + x as usize][c as usize]);
        (value + 0.1 * (1.7 * x + 2.3 * y + c + k).sin()).clamp(0.0, 1.0)
    })
}

fn texels(width: usize, height: usize, f: impl Fn(f64, f64, f64) -> f64) -> Vec<[f32; 3]> {
    let at = |i: usize| ((i % width) as f64, (i / width) as f64);
    (0..width * height).map(|i| [0.0, 1.0, 2.0].map(|c| f(at(i).0, at(i).1, c) as f32)).collect()
}

#[test]
fn ssim_is_scikit_images() {
    // The numbers are those of scikit-image 0.26.0 with numpy 2.4.6 for these patterns as float64:
    // structural_similarity(a, b, channel_axis=2, gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
    //                       data_range=1) with b = disturbed(k), then pattern(k + 1)
    for (width, height, k, disturbed_by, another) in [
        (64, 36, 1.0, 0.8764565669955356, 0.001609301585518405),
        (33, 47, 2.0, 0.9040192567633619, -0.019209599175246582),
        (11, 11, 3.0, 0.9133654004435371, -0.1911497645735505),
        (40, 12, 0.0, 0.9270322435463306, -0.039812208788937764),
    ] {
        let ssim = Ssim::new(width, height, &pattern(width, height, k)).expect("large enough");
        let found = ssim.of(&disturbed(width, height, k));
        assert!((found - disturbed_by).abs() < 1e-6, "{width}x{height}: {found} is not {disturbed_by}");
        let found = ssim.of(&pattern(width, height, k + 1.0));
        assert!((found - another).abs() < 1e-6, "{width}x{height}: {found} is not {another}");
        assert!((ssim.of(&pattern(width, height, k)) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn masked_ssim_looks_at_centres() {
    let (width, height) = (30, 20);
    let reference = pattern(width, height, 1.0);
    let ssim = Ssim::new(width, height, &reference).expect("large enough");
    // Only the right part is disturbed. Windows whose centre is more than five pixels left of it do not reach it.
    let other = disturbed(width, height, 1.0);
    let half = |i: usize| i % width >= 18;
    let picture: Vec<[f32; 3]> = (0..width * height).map(|i| if half(i) { other[i] } else { reference[i] }).collect();
    let left: Vec<bool> = (0..width * height).map(|i| i % width < 12).collect();
    assert!((ssim.over(&picture, &left).expect("centres") - 1.0).abs() < 1e-12);
    let right: Vec<bool> = left.iter().map(|l| !l).collect();
    assert!(ssim.over(&picture, &right).expect("centres") < 0.99);
    assert_eq!(ssim.over(&picture, &vec![false; width * height]), None);
    assert!(Ssim::new(10, 20, &reference[..200]).is_none(), "a picture smaller than the window was accepted");
}

#[test]
fn flip_is_nvidias() {
    let pairs: [(usize, usize, f64, f64); 4] =
        [(64, 36, 1.0, 67.0), (33, 47, 2.0, 67.0), (50, 40, 0.0, 20.0), (7, 5, 3.0, 40.0)];
    for (width, height, k, pixels_per_degree) in pairs {
        let bytes = |p: &[[f32; 3]]| -> Vec<u8> { p.iter().flatten().map(|v| (v * 255.0 + 0.5) as u8).collect() };
        let values = |b: &[u8]| -> Vec<[f32; 3]> {
            b.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| f32::from(v) / 255.0)).collect()
        };
        let reference = bytes(&pattern(width, height, k));
        for test in [disturbed(width, height, k), pattern(width, height, k + 1.0), pattern(width, height, k)] {
            let test = bytes(&test);
            let image = |b: &[u8]| nv_flip::FlipImageRgb8::with_data(width as u32, height as u32, b);
            let theirs = nv_flip::flip(image(&reference), image(&test), pixels_per_degree as f32).to_vec();
            let ours = Flip::new(width, height, &values(&reference), pixels_per_degree as f32).map(&values(&test));
            let worst = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // Powers of numbers near 0 amplify differences in the last bits.
            assert!(worst < 2e-4, "{width}x{height} at {pixels_per_degree}: {worst}");
            let mean = |m: &[f32]| m.iter().map(|e| f64::from(*e)).sum::<f64>() / m.len() as f64;
            assert!((mean(&ours) - mean(&theirs)).abs() < 1e-5, "{} is not {}", mean(&ours), mean(&theirs));
        }
    }
}
