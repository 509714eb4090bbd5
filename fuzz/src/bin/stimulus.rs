#![no_main]

cyclopean_fuzz::target!("stimulus", 1 GiB);
