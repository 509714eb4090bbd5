#![no_main]

cyclopean_fuzz::target!("csv", 1 GiB);
