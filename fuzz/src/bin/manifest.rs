#![no_main]

// A scene may take half of the program's address space, which `fuzz/run` limits to 2.5 GiB.
cyclopean_fuzz::target!("manifest", 2 GiB);
