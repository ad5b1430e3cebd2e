//! Lights that are infinitely far away.

mod sun;
