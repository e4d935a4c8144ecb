//! Projections that lensfun's lenses are said to have: the distance from the middle by field angle, without distortion.

/// A projection by angle from the axis. Panoramic and equirectangular pictures have none, so they are read as unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Projection {
    /// Height by the tangent of the angle.
    #[default]
    Rectilinear,
    /// Height by the angle itself (lensfun's `fisheye`).
    Equidistant,
    /// Height by the sine of the angle.
    Orthographic,
    /// Height by twice the tangent of half the angle.
    Stereographic,
    /// Height by twice the sine of half the angle.
    Equisolid,
    /// Height by 1.47 sin(0.713 θ), as M. Thoby has measured a fisheye lens.
    Thoby,
}

/// The constants of [`Projection::Thoby`] (lensfun, `mod-coord.cpp`).
const THOBY: [f64; 2] = [1.47, 0.713];

impl Projection {
    /// The projection by its word in a database; `None`: no such word, or none that is round.
    pub fn by_word(word: &str) -> Option<Self> {
        Some(match word {
            "rectilinear" => Self::Rectilinear,
            "fisheye" => Self::Equidistant,
            "orthographic" => Self::Orthographic,
            "stereographic" => Self::Stereographic,
            "equisolid" => Self::Equisolid,
            "fisheye_thoby" => Self::Thoby,
            _ => return None,
        })
    }

    /// The largest height in the picture without distortion, in focal lengths; infinite where there is none.
    pub fn reach(self) -> f64 {
        match self {
            Self::Rectilinear | Self::Stereographic => f64::INFINITY,
            Self::Equidistant => std::f64::consts::PI,
            Self::Orthographic => 1.0,
            Self::Equisolid => 2.0,
            Self::Thoby => THOBY[0],
        }
    }

    /// Height in the picture without distortion, in focal lengths, of a field at this angle from the axis; `None`: the projection does not
    /// show it.
    pub fn height(self, angle_rad: f64) -> Option<f64> {
        use std::f64::consts::{FRAC_PI_2, PI};
        let (most, height) = match self {
            Self::Rectilinear => (FRAC_PI_2, angle_rad.tan()),
            Self::Equidistant => (PI, angle_rad),
            Self::Orthographic => (FRAC_PI_2, angle_rad.sin()),
            Self::Stereographic => (PI, 2.0 * (0.5 * angle_rad).tan()),
            Self::Equisolid => (PI, 2.0 * (0.5 * angle_rad).sin()),
            Self::Thoby => (FRAC_PI_2 / THOBY[1], THOBY[0] * (THOBY[1] * angle_rad).sin()),
        };
        (angle_rad.abs() < most).then_some(height)
    }

    /// Angle from the axis of a field at this height in the picture without distortion, in focal lengths; `None`: no field is there.
    pub fn angle_rad(self, height: f64) -> Option<f64> {
        let angle = match self {
            Self::Rectilinear => height.atan(),
            Self::Equidistant => height,
            Self::Orthographic => height.asin(),
            Self::Stereographic => 2.0 * (0.5 * height).atan(),
            Self::Equisolid => 2.0 * (0.5 * height).asin(),
            Self::Thoby => (height / THOBY[0]).asin() / THOBY[1],
        };
        (angle.abs() < std::f64::consts::PI).then_some(angle)
    }
}

#[cfg(test)]
mod tests {
    use super::Projection;

    #[test]
    fn angles_come_back() {
        for word in ["rectilinear", "fisheye", "orthographic", "stereographic", "equisolid", "fisheye_thoby"] {
            let projection = Projection::by_word(word).unwrap();
            for angle in [0.0, 0.3, 1.2] {
                let back = projection.angle_rad(projection.height(angle).unwrap()).unwrap();
                assert!((back - angle).abs() < 1e-14, "{word} {angle} {back}");
            }
            // Near the axis every projection has the same scale, but Thoby's, whose focal length is 1.048 times that.
            let scale = projection.height(1e-6).unwrap() / 1e-6;
            assert!((scale - if word == "fisheye_thoby" { 1.47 * 0.713 } else { 1.0 }).abs() < 1e-9, "{word} {scale}");
        }
        assert_eq!(Projection::Rectilinear.height(1.6), None);
        assert_eq!(Projection::Orthographic.angle_rad(1.1), None);
    }
}
