//! Diffraction in a picture that already has aberrations and defocus: the transfer function of the pupil's shape.
//!
//! Rays make the geometric picture. Of its contrast at the frequency ν diffraction leaves, to good approximation, the part that it would
//! leave of a perfect lens with the same pupil: the overlap of the pupil with itself, shifted by λν in direction cosines, over its area
//! (Goodman, Introduction to Fourier Optics, 4th ed., section 7.4). That part depends on the wavelength by its scale alone.
//! The pupil is an [`outline`] as exact rays find it from a place of the film, with blades, rims, obstructions and masks; the [`overlap`]
//! is that of polygons, so that light which goes far aside, the spikes of straight edges, is as exact as light that stays near.

pub mod outline;
pub mod overlap;
