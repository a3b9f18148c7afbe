//! Offscreen pictures.
