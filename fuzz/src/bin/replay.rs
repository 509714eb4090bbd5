#![no_main]

cyclopean_fuzz::target!("replay", 1 GiB);
