//! What glass without coatings lets through.
//!
//! Along the axis, where reflection does not depend on polarisation: each surface between the indices n and n' reflects
//! ((n - n') / (n + n'))² (Fresnel; Born and Wolf, *Principles of Optics*, §1.5.3). Light reflected twice is not counted, nor
//! what glasses absorb.

use crate::system::{Element, System};

/// The ends between which a tint is measured: the middles of what is seen as blue and as red, nm.
const BLUE_NM: f64 = 450.0;
const RED_NM: f64 = 650.0;

/// The part of the light of a wavelength that passes all surfaces along the axis, if none is coated; mirrors count as perfect.
pub fn uncoated(system: &System, wavelength_nm: f64) -> f64 {
    let passed = |element: &Element| match element {
        Element::Refract { from, to } => {
            let [a, b] = [from.index(wavelength_nm), to.index(wavelength_nm)];
            1.0 - ((a - b) / (a + b)).powi(2)
        }
        Element::Reflect { .. } => 1.0,
    };
    system.surfaces().iter().map(|surface| passed(&surface.element)).product()
}

/// How much more uncoated glass takes of blue than of red light, stops; negative if less.
pub fn tint_stops(system: &System) -> f64 {
    (uncoated(system, RED_NM) / uncoated(system, BLUE_NM)).log2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::SystemSettings;

    fn system(text: &str) -> System {
        System::new(&lens::parse(text, "test.lens", Catalogue::shipped()).unwrap(), &SystemSettings::default()).unwrap()
    }

    /// Two surfaces of index 1.5 pass 0.96 each; cement between like glasses takes nothing.
    #[test]
    fn surfaces_multiply() {
        let singlet = system("60 6 1.5 30 0 1\n-60 55 air 30 0 0");
        assert!((uncoated(&singlet, 500.0) - 0.96 * 0.96).abs() < 1e-12);
        let cemented = system("60 6 1.5 30 0 1\n100 6 1.5 30 0 0\n-60 55 air 30 0 0");
        assert!((uncoated(&cemented, 500.0) - 0.96 * 0.96).abs() < 1e-12);
        assert_eq!(tint_stops(&singlet), 0.0);
    }

    /// Indices rise towards blue, and so does what is reflected.
    #[test]
    fn glass_is_yellowish() {
        let tint = tint_stops(&system("60 6 N-SF11 30 0 1\n-60 55 air 30 0 0"));
        assert!(tint > 0.005 && tint < 0.1, "{tint}");
    }
}
