#![no_main]

// A picture may have 2²⁹ samples. The reader allocates memory for them in advance three times: compressed,
// decompressed, and for each eye. libFuzzer limits how much of it is really used.
cyclopean_fuzz::target!("exr", 8 GiB);
