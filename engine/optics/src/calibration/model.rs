//! The models by name, with their parameters.

use crate::lensfun::Projection;

/// A camera model: which parameters a calibration has. Focal lengths and principal points are pixels of the picture, counted from its upper
/// left corner, so that the first pixel's middle is (0.5, 0.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// A pinhole with OpenCV's distortion: rational, decentring, thin prism, tilted sensor.
    OpenCv,
    /// OpenCV's fisheye (Kannala and Brandt 2006, eq. 6): a polynomial of the angle from the axis.
    Fisheye,
    /// COLMAP's `THIN_PRISM_FISHEYE`: the angle from the axis with Brown's distortion.
    ThinPrismFisheye,
    /// COLMAP's `RAD_TAN_THIN_PRISM_FISHEYE`, Project Aria's `Fisheye624`.
    RadTanThinPrismFisheye,
    /// The field-of-view model (Devernay and Faugeras 2001).
    Fov,
    /// The division model (Fitzgibbon 2001).
    Division,
    /// The whole sphere by longitude and latitude.
    Equirectangular,
    /// The double sphere (Usenko, Demmel and Cremers 2018).
    DoubleSphere,
    /// The enhanced unified model (Khomutenko, Garcia and Martinet 2016); the unified one with `beta` 1.
    Eucm,
    /// A unified sphere with radial and decentring distortion (Mei and Rives 2007).
    Omni,
    /// NVIDIA's f-theta by the polynomial from the distance in pixels to the angle.
    FThetaToAngle,
    /// NVIDIA's f-theta by the polynomial from the angle to the distance in pixels.
    FThetaToPixels,
    /// 3DEqualizer's "Radial - Standard, Degree 4".
    TdeRadial,
    /// 3DEqualizer's "Anamorphic - Standard, Degree 4".
    TdeAnamorphic,
    /// A photographic lens of lensfun's: a round projection with a polynomial of the radius, and two tangential terms.
    Lensfun(Projection),
    /// A table, on the pinhole of the parameters.
    StMap,
}

const F_THETA: [&str; 13] = ["cx", "cy", "c", "d", "e", "k1", "k2", "k3", "k4", "k5", "k6", "k7", "k8"];

impl Model {
    /// All models.
    pub const ALL: [Self; 21] = [
        Self::OpenCv,
        Self::Fisheye,
        Self::ThinPrismFisheye,
        Self::RadTanThinPrismFisheye,
        Self::Fov,
        Self::Division,
        Self::Equirectangular,
        Self::DoubleSphere,
        Self::Eucm,
        Self::Omni,
        Self::FThetaToAngle,
        Self::FThetaToPixels,
        Self::TdeRadial,
        Self::TdeAnamorphic,
        Self::Lensfun(Projection::Rectilinear),
        Self::Lensfun(Projection::Equidistant),
        Self::Lensfun(Projection::Orthographic),
        Self::Lensfun(Projection::Stereographic),
        Self::Lensfun(Projection::Equisolid),
        Self::Lensfun(Projection::Thoby),
        Self::StMap,
    ];

    /// The name in messages and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenCv => "opencv",
            Self::Fisheye => "fisheye",
            Self::ThinPrismFisheye => "thin-prism-fisheye",
            Self::RadTanThinPrismFisheye => "rad-tan-thin-prism-fisheye",
            Self::Fov => "fov",
            Self::Division => "division",
            Self::Equirectangular => "equirectangular",
            Self::DoubleSphere => "double-sphere",
            Self::Eucm => "eucm",
            Self::Omni => "omni",
            Self::FThetaToAngle => "f-theta",
            Self::FThetaToPixels => "f-theta-to-pixels",
            Self::TdeRadial => "3de-radial-4",
            Self::TdeAnamorphic => "3de-anamorphic-4",
            Self::Lensfun(Projection::Rectilinear) => "lensfun-rectilinear",
            Self::Lensfun(Projection::Equidistant) => "lensfun-fisheye",
            Self::Lensfun(Projection::Orthographic) => "lensfun-orthographic",
            Self::Lensfun(Projection::Stereographic) => "lensfun-stereographic",
            Self::Lensfun(Projection::Equisolid) => "lensfun-equisolid",
            Self::Lensfun(Projection::Thoby) => "lensfun-thoby",
            Self::StMap => "st-map",
        }
    }

    /// The names of the parameters in the order in which they are kept.
    ///
    /// OpenCV's and most others' distortion coefficients are those of their sources. `k1` to `k8` of an f-theta camera belong to powers 1 to
    /// 8, and `c`, `d`, `e` are NVIDIA's: `x = c x' + d y'`, `y = e x' + y'`. `c2` to `c7` of lensfun's lenses belong to powers of the radius
    /// in focal lengths, of which the first has 1. Lengths of 3DEqualizer are in cm, angles in degrees.
    pub fn parameter_names(self) -> &'static [&'static str] {
        match self {
            Self::OpenCv => &[
                "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4",
                "tau_x", "tau_y",
            ],
            Self::Fisheye => &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "alpha"],
            Self::ThinPrismFisheye => &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "sx1", "sy1"],
            Self::RadTanThinPrismFisheye => {
                &["fx", "fy", "cx", "cy", "k0", "k1", "k2", "k3", "k4", "k5", "p0", "p1", "s0", "s1", "s2", "s3"]
            }
            Self::Fov => &["fx", "fy", "cx", "cy", "omega"],
            Self::Division => &["fx", "fy", "cx", "cy", "k"],
            Self::Equirectangular => &[],
            Self::DoubleSphere => &["fx", "fy", "cx", "cy", "xi", "alpha"],
            Self::Eucm => &["fx", "fy", "cx", "cy", "alpha", "beta"],
            Self::Omni => &["fx", "fy", "cx", "cy", "xi", "k1", "k2", "p1", "p2"],
            Self::FThetaToAngle | Self::FThetaToPixels => &F_THETA,
            Self::TdeRadial => &[
                "focal_cm",
                "film_width_cm",
                "film_height_cm",
                "centre_x_cm",
                "centre_y_cm",
                "distortion_2",
                "u_2",
                "v_2",
                "distortion_4",
                "u_4",
                "v_4",
                "phi_deg",
                "bending",
            ],
            Self::TdeAnamorphic => &[
                "focal_cm",
                "film_width_cm",
                "film_height_cm",
                "centre_x_cm",
                "centre_y_cm",
                "pixel_aspect",
                "cx02",
                "cy02",
                "cx22",
                "cy22",
                "cx04",
                "cy04",
                "cx24",
                "cy24",
                "cx44",
                "cy44",
                "rotation_deg",
                "squeeze_x",
                "squeeze_y",
            ],
            Self::Lensfun(_) => &["fx", "fy", "cx", "cy", "c2", "c3", "c4", "c5", "c6", "c7", "p1", "p2"],
            Self::StMap => &["fx", "fy", "cx", "cy"],
        }
    }

    /// True if the model is a pinhole's but for its distortion, so that it sees a plane across its axis and nothing beside or behind it.
    pub fn is_flat(self) -> bool {
        use Model::{Division, Fov, OpenCv, StMap, TdeAnamorphic, TdeRadial};
        matches!(self, OpenCv | Fov | Division | TdeRadial | TdeAnamorphic | StMap)
    }

    /// A pinhole's parameters: no distortion; with the model's own radial projection where it has one. `None`: the model is no pinhole's.
    pub fn undistorted(self, focal_px: [f64; 2], centre_px: [f64; 2]) -> Option<Vec<f64>> {
        let names = self.parameter_names();
        if names.first() != Some(&"fx") || self == Self::StMap {
            return None;
        }
        let mut parameters = vec![0.0; names.len()];
        parameters[..4].copy_from_slice(&[focal_px[0], focal_px[1], centre_px[0], centre_px[1]]);
        if let Some(beta) = names.iter().position(|name| *name == "beta") {
            parameters[beta] = 1.0;
        }
        Some(parameters)
    }
}
