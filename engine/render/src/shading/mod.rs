//! How a surface scatters light: Fresnel terms, microfacets, and Blender's Principled BSDF made of them.
//!
//! Each scattering model comes in three: sample, density, evaluate. Directions point away from the surface: `wo`
//! to where the path came from, `wi` to where it goes (pbrt's words).

pub mod albedo;
pub mod fresnel;
pub mod microfacet;
pub mod principled;
