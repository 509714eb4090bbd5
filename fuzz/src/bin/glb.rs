#![no_main]

// A scene may take half of the memory that the program may use: `fuzz/run` allows 2.5 GiB.
cyclopean_fuzz::target!("glb", 2 GiB);
