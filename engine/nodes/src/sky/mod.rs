//! The sky as a Sky Texture paints it.
//!
//! Dependencies of the modules: [`panorama`] → [`single_scattering`], [`multiple_scattering`] → [`atmosphere`];
//! [`preetham`] and [`hosek`] stand alone.

pub(crate) mod atmosphere;
pub(crate) mod hosek;
mod multiple_scattering;
mod panorama;
pub(crate) mod preetham;
mod single_scattering;

use atmosphere::Atmosphere;
use glam::Vec3A;
use hosek::Hosek;
use preetham::Preetham;

/// A sky for one place of the sun.
#[derive(Clone, Debug)]
pub(crate) enum Sky {
    /// The formula of Preetham, Shirley and Smits 1999.
    Preetham(Preetham),
    /// Hosek's formula with fitted numbers.
    Hosek(Box<Hosek>),
    /// Light scattered in air, computed.
    Atmosphere(Box<Atmosphere>),
}

/// A sun that a sky shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunDisc {
    /// Direction towards the sun, unit, in the coordinates of the Sky Texture.
    pub direction: Vec3A,
    /// Angular diameter of the sun.
    pub diameter_rad: f32,
}

impl Sky {
    /// The colour of a direction, linear Rec.709; with the sun's disc if there is one and it is asked for.
    pub(crate) fn at(&self, direction: Vec3A, with_sun: bool) -> Vec3A {
        match self {
            Self::Preetham(sky) => sky.at(direction),
            Self::Hosek(sky) => sky.at(direction),
            Self::Atmosphere(sky) => sky.at(direction, with_sun),
        }
    }

    /// The sun that the sky shows.
    pub(crate) fn sun(&self) -> Option<SunDisc> {
        match self {
            Self::Atmosphere(sky) => sky.sun(),
            _ => None,
        }
    }
}
