//! All that the crate promises, in one program: what is generic in the tracer is compiled once.

mod analysis;
mod common;
mod drawing;
mod elements;
mod eyes;
mod flood;
mod focus_scale;
mod focusing;
mod formats;
mod gradients;
mod hard_cases;
mod hinge;
mod hostile_files;
mod lens_file;
mod library;
mod moving_groups;
mod numerics;
mod properties;
mod pupil;
mod reference_paraxial;
mod reference_rays;
mod scaling;
mod seidel;
mod single_precision;
mod stops;
mod vignetting;
