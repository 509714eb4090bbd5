//! The target for the side-cars of stored stimuli. If the store accepts a stimulus, it must be complete and the one
//! that was asked for.

use cyclopean::study::sha256_hex;
use cyclopean::study::store::Store;

const KEY: &str = "aa00000000000000000000000000000000000000000000000000000000000000";

/// The content of the stimulus's two files. The store checks their sums and does not open them as pictures.
const PICTURE: &[u8] = b"picture";

pub fn run(bytes: &[u8]) {
    let store = Store::new(super::path("store"));
    let folder = super::path("store/objects/aa").join(KEY);
    if !folder.is_dir() {
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        for name in ["sbs.png", "stereo.exr"] {
            std::fs::write(folder.join(name), PICTURE).expect("a temporary file");
        }
    }
    std::fs::write(folder.join("stimulus.json"), bytes).expect("a temporary file");
    std::fs::write(folder.join("timing.json"), bytes).expect("a temporary file");
    let _ = store.seconds(KEY);
    match store.check(KEY) {
        Ok(None) => panic!("the store did not find the stimulus"),
        Ok(Some(stored)) => {
            assert_eq!(stored.side_car.key, KEY, "the store gave a stimulus of another address");
            let frames = stored.frame_paths();
            assert!(frames.iter().all(|frame| frame.is_file()), "a frame is missing");
            let sum = sha256_hex(PICTURE);
            assert!(stored.side_car.files.values().all(|found| *found == sum), "a file has another sum");
            let text = serde_json::to_vec(&stored.side_car).expect("plain data");
            let again: cyclopean::study::store::SideCar = serde_json::from_slice(&text).expect("read again");
            assert_eq!(again, stored.side_car, "the side-car changed when it was written and read again");
        }
        Err(error) => super::said(&error),
    }
}
