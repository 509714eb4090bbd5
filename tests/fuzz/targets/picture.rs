//! The target for pictures: OpenEXR files as stereo pictures and as environments, PNG files as stimuli, and Radiance
//! HDR files as environments. A stereo picture that can be read must have the same bits after it is written and read
//! again.

use cyclopean::picture::{self, Part};
use cyclopean::scene::environment::file;

pub fn run(bytes: &[u8]) {
    let path = super::file("p.exr", bytes);
    match picture::has_layer(&path, "reflection") {
        Ok(_) => {}
        Err(error) => super::said(&error),
    }
    match picture::read_exr(&path, "") {
        Ok(read) => {
            let texels = u64::from(read.width) * u64::from(read.height);
            assert!(read.eyes().iter().all(|eye| eye.len() as u64 == texels), "there is not one texel for each pixel");
            // Writing the picture and reading it again must not change a bit.
            let again = super::path("again.exr");
            picture::write_exr(&again, &[Part { layer: "", picture: &read }]).expect("written");
            let again = picture::read_exr(&again, "").expect("read again");
            assert_eq!((again.width, again.height), (read.width, read.height));
            let bits = |p: &picture::StereoPicture| {
                p.eyes.concat().into_iter().flatten().map(f32::to_bits).collect::<Vec<_>>()
            };
            assert_eq!(bits(&again), bits(&read), "the bits changed");
        }
        Err(error) => super::said(&error),
    }
    match picture::read_png(&path) {
        Ok(read) => assert_eq!(picture::png_size(&path).expect("the header of a PNG"), read.dimensions()),
        Err(error) => super::said(&error),
    }
    match file::decode(bytes) {
        Ok(map) => assert_eq!(map.texels.len() as u64, u64::from(map.width) * u64::from(map.height), "texels missing"),
        Err(error) => super::said(&error),
    }
}
