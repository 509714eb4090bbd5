//! The tests of the whole program, as one program of their own: it is linked once, and all tests share the processor's cores.
//!
//! Each module tests one subject and is the beginning of its tests' names: `./x test shadows::` runs those of `shadows`.

// What several of them use.
#[cfg(feature = "gpu")]
mod desk;
mod lab;
#[cfg(feature = "gpu")]
mod pictures;
mod program;
mod screen;
mod xr;

#[path = "architecture/main.rs"]
mod architecture;
#[path = "fuzz/main.rs"]
mod fuzz;
#[path = "networks/main.rs"]
mod networks;

mod ambient;
mod antialias;
mod builtin_scenes;
mod chain;
mod commands;
mod compare;
mod compose;
mod cpu;
mod crashes;
mod desktop;
mod documents;
mod full_disk;
mod geometry;
mod hostile;
mod hybrid;
mod indirect;
mod methods;
mod metrics;
mod moving_stimuli;
mod openxr;
mod operator;
mod panel;
mod paper;
mod people;
mod poses;
mod ray_query;
mod rendering;
mod scene_formats;
mod scene_hazards;
mod scenes_render;
mod sequences;
mod sessions;
mod shader_layout;
mod shading_reuse;
mod shadow_maps;
mod shadows;
mod shards;
mod shared_scenes;
mod slurm;
mod speed;
mod stereo;
mod stress;
mod studies;
mod temporal;
mod tutorial;
