//! How camera and integrator are brought together: which rays are drawn for which pixels, and where what they
//! find is added.

pub mod film_first;
