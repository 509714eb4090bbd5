//! Pictures of the screen of an X server without a monitor (Xvfb).

use std::path::Path;

use image::RgbImage;

/// What the first screen of a server shows that was started with `-fbdir FOLDER`.
pub fn picture(folder: &Path) -> RgbImage {
    let bytes = std::fs::read(folder.join("Xvfb_screen0")).expect("the frame buffer");
    read_xwd(&bytes)
}

/// Reads an X window dump of version 7. It has a header of big-endian words, a colour table with 12 bytes for each
/// entry, and then the rows of pixels.
fn read_xwd(bytes: &[u8]) -> RgbImage {
    let word = |i: usize| u32::from_be_bytes(bytes[4 * i..4 * i + 4].try_into().unwrap()) as usize;
    let (header, width, height, is_big, bits, row, colors) =
        (word(0), word(4), word(5), word(7), word(11), word(12), word(19));
    assert_eq!(
        (word(1), bits),
        (7, 32),
        "the frame buffer is not an X window dump of version 7 with 32 bits per pixel"
    );
    let data = &bytes[header + 12 * colors..];
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        let at = y as usize * row + 4 * x as usize;
        let p = &data[at..at + 4];
        image::Rgb(if is_big == 1 { [p[1], p[2], p[3]] } else { [p[2], p[1], p[0]] })
    })
}
