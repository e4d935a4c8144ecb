//! A lens at all wavelengths of a film, laid out for rays that each have their own.

use crate::spectrum::{FilmSpectrum, FilmWavelength, SET_SIZE};
use glam::Vec4;
use petzval_optics::trace::{LINES, SpectralTracer, Tracer};

// A set goes through the lens in one packet.
const _: () = assert!(SET_SIZE == LINES);

/// The lens at all of the film's wavelengths.
pub(in crate::camera) struct FilmLines {
    /// A group of lines for each set.
    pub(in crate::camera) back: SpectralTracer,
    /// [`Self::back`] in single precision, for whole batches: a wavelength that did not lead lands within some 1e-6 of the lens's size of
    /// its place, far less than a pixel, in a third of the time.
    pub(in crate::camera) back_in_short: SpectralTracer<f32>,
    /// Number of wavelengths in a set.
    pub(in crate::camera) size: usize,
    /// Number of sets of wavelengths: [`FilmSpectrum::sets`].
    pub(in crate::camera) sets: usize,
    /// Columns of the response to a scene colour, by wavelength of the film; the fourth number of each is 0.
    pub(in crate::camera) responses: Vec<[Vec4; 3]>,
}

impl FilmLines {
    pub(in crate::camera) fn new(tracers: &[Tracer], spectrum: &FilmSpectrum) -> Self {
        let (sets, size) = (spectrum.sets(), spectrum.set_size());
        // A small set is filled up with its last wavelength.
        let line = |set: usize, i: usize| &tracers[set + i.min(size - 1) * sets];
        let by_set: Vec<&Tracer> = (0..sets).flat_map(|set| (0..LINES).map(move |i| line(set, i))).collect();
        let back = SpectralTracer::new(&by_set);
        let columns = |w: &FilmWavelength| [0, 1, 2].map(|i| w.response.col(i).extend(0.0));
        let responses = spectrum.wavelengths().iter().map(columns).collect();
        Self { back_in_short: back.cast(), back, size, sets, responses }
    }
}
