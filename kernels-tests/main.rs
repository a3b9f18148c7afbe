//! Tests of kernels against their twins, of the command, and of the repository's own rules: one process, one device,
//! one test on it at a time.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod bulge;
mod checkpoint;
mod cli;
mod doors;
mod dynamics_fixtures;
mod field_sample;
mod fields;
mod frame;
mod joint_step;
mod layout;
mod motion;
mod muscle_fixtures;
mod muscle_predict;
mod muscle_project;
mod muscle_sample;
mod muscle_shape;
mod normals;
mod operator_sample;
mod render;
mod repo;
mod skin;
mod skin_dual_quaternion;
mod skin_linear;
mod skin_weighted;
mod support;
mod track_carry;
mod track_fixtures;
mod track_fold;
mod track_march;
mod track_place;
mod track_slide;
mod track_spread;
mod track_turn;
mod wrap_fixtures;
