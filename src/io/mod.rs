//! Files in and out: scenes, models, textures, images. Nothing else in the crate knows a file format.
