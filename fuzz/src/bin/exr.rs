#![no_main]

// A picture may have 2²⁹ samples, for which memory is claimed before they are there: packed, unpacked, and by eye. How much is
// used, libFuzzer watches.
cyclopean_fuzz::target!("exr", 8 GiB);
