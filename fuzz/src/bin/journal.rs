#![no_main]

cyclopean_fuzz::target!("journal", 1 GiB);
