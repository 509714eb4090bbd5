#![no_main]

cyclopean_fuzz::target!("order", 1 GiB);
