//! Decodes streams of meshoptimizer's own encoder and compares them with the results of its own decoder.

use proptest::prelude::*;
use serde::Deserialize;

use super::{Budget, MeshoptExtension, decode};

#[derive(Deserialize)]
struct Stream {
    what: String,
    mode: String,
    filter: String,
    count: usize,
    stride: usize,
    packed: String,
    unpacked: String,
}

fn streams() -> Vec<Stream> {
    let files = [
        include_str!("../../../../tests/data/meshopt-attributes.json"),
        include_str!("../../../../tests/data/meshopt-filters.json"),
        include_str!("../../../../tests/data/meshopt-indices.json"),
    ];
    files
        .iter()
        .flat_map(|text| serde_json::from_str::<Vec<Stream>>(text).expect("tests/data/meshopt-*.json"))
        .collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).expect("hexadecimal")).collect()
}

fn unpack(stream: &Stream, source: Vec<u8>, count: usize) -> Result<Vec<u8>, String> {
    let packed = MeshoptExtension {
        buffer: 0,
        byte_offset: 0,
        byte_length: source.len() as u64,
        byte_stride: stream.stride,
        count,
        mode: stream.mode.clone(),
        filter: Some(stream.filter.clone()),
    };
    decode(&packed, &[source], &Budget::default())
}

#[test]
fn every_codec_and_filter_gives_what_the_reference_gives() {
    for stream in streams() {
        let found = unpack(&stream, bytes(&stream.packed), stream.count);
        let found = found.unwrap_or_else(|reason| panic!("{}: {reason}", stream.what));
        let expected = bytes(&stream.unpacked);
        if stream.filter == "NONE" || stream.filter == "EXPONENTIAL" {
            assert!(found == expected, "{}: {} of stride {}", stream.what, stream.count, stream.stride);
            continue;
        }
        // The filters round: the vector code of meshoptimizer and this decoder may differ by one step.
        let wide = stream.stride == 8;
        let value = |b: &[u8]| if wide { i32::from(i16::from_le_bytes([b[0], b[1]])) } else { i32::from(b[0] as i8) };
        let size = if wide { 2 } else { 1 };
        for (a, b) in found.chunks_exact(size).zip(expected.chunks_exact(size)) {
            let apart = (value(a) - value(b)).abs();
            assert!(apart <= 1, "{}: {} instead of {}", stream.what, value(a), value(b));
        }
    }
}

#[test]
fn what_is_wrong_is_said_before_anything_is_allocated() {
    let streams = streams();
    let first = |mode: &str| streams.iter().find(|s| s.mode == mode).expect("one of each mode");
    for (mode, words) in
        [("ATTRIBUTES", "vertex codec"), ("TRIANGLES", "triangle codec"), ("INDICES", "sequence codec")]
    {
        let stream = first(mode);
        let mut source = bytes(&stream.packed);
        source[0] = 0;
        assert!(unpack(stream, source.clone(), stream.count).is_err_and(|e| e.contains(words)));
        let huge = unpack(stream, source, 1 << 40);
        assert!(huge.is_err_and(|e| e.contains("count is 1099511627776")));
        let mut source = bytes(&stream.packed);
        source.truncate(source.len() / 2);
        assert!(unpack(stream, source, stream.count).is_err(), "{mode} cut in half");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn hostile_streams_never_panic(seed: u64, cut: bool, count in 0usize..1000) {
        for (i, stream) in streams().into_iter().enumerate() {
            let mut source = bytes(&stream.packed);
            let mut state = seed ^ (i as u64) << 32 | 1;
            for _ in 0..4 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let at = (state >> 33) as usize % source.len();
                source[at] = state as u8 ^ (state >> 8) as u8;
            }
            if cut {
                source.truncate((state >> 20) as usize % source.len());
            }
            let _ = unpack(&stream, source.clone(), stream.count);
            let _ = unpack(&stream, source, count);
        }
    }
}
