#![no_main]

cyclopean_fuzz::target!("study", 1 GiB);
