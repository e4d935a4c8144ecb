//! Lobes without a peak: Lambert, Oren and Nayar, cloth, toon.
//!
//! All directions in the lobe's own frame, +z its normal.

use crate::Rgb;
use crate::sampler::warp;
use glam::Vec3A;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

/// Oren and Nayar's surface by Fujii's form ("A tiny improvement of Oren-Nayar reflectance model"), with the light that goes on
/// between its grooves (OpenPBR 1.1, section 3.2).
#[derive(Clone, Copy, Debug)]
pub(super) struct OrenNayar {
    a: f32,
    b: f32,
    /// The light between grooves, all but the factor of the other direction.
    multiple: Rgb,
}

impl OrenNayar {
    /// The roughness that it was made of.
    pub(super) fn roughness(&self) -> f32 {
        self.b / self.a
    }

    /// `cos_o` is that of the viewing direction.
    pub(super) fn new(albedo: Rgb, roughness: f32, cos_o: f32) -> Self {
        let sigma = roughness.clamp(0.0, 1.0);
        let a = 1.0 / (PI + sigma * (FRAC_PI_2 - 2.0 / 3.0));
        let b = sigma * a;
        let mut lobe = Self { a, b, multiple: Rgb::ZERO };
        let albedo = albedo.clamp(Rgb::ZERO, Rgb::ONE);
        let average = a * PI + (TAU - 5.6) / 3.0 * b;
        let lost = 1.0 - average;
        if lost > 1e-6 {
            let between = albedo * albedo * (FRAC_1_PI * average / lost) / (Rgb::ONE - albedo * lost);
            lobe.multiple = between * (1.0 - lobe.single_albedo(cos_o.max(0.0)));
        }
        lobe
    }

    /// Albedo of single scattering for white light at a cosine.
    fn single_albedo(&self, cos: f32) -> f32 {
        let g = if cos < 1e-6 {
            // The limit, where a tangent would be infinite.
            FRAC_PI_2 - 2.0 / 3.0 - cos
        } else {
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            sin * (cos.min(1.0).acos() - 2.0 / 3.0 - sin * cos) + 2.0 / 3.0 * (sin / cos) * (1.0 - sin * sin * sin)
        };
        self.a * PI + self.b * g
    }

    /// Value times cosine, to be tinted by the albedo.
    pub(super) fn evaluate(&self, wo: Vec3A, wi: Vec3A) -> Rgb {
        let (nl, nv) = (wi.z, wo.z.max(0.0));
        let mut t = wi.dot(wo) - nl * nv;
        if t > 0.0 {
            t /= nl.max(nv);
        }
        nl * (Rgb::splat(self.a + self.b * t) + self.multiple * (1.0 - self.single_albedo(nl)))
    }
}

/// Ashikhmin's velvet ("Distribution-based BRDFs", 2007).
#[derive(Clone, Copy, Debug)]
pub(super) struct Velvet {
    inverse_sigma2: f32,
}

impl Velvet {
    pub(super) fn new(sigma: f32) -> Self {
        Self { inverse_sigma2: 1.0 / sigma.clamp(0.01, 1.0).powi(2) }
    }

    /// Value of the lobe times the cosine of `wi` to the normal.
    pub(super) fn evaluate(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let h = (wo + wi).normalize_or(Vec3A::Z);
        let (cos_h, cos_oh) = (h.z, wo.dot(h).abs());
        if wo.z <= 0.0 || cos_h.abs() >= 1.0 - 1e-5 || cos_oh <= 1e-5 {
            return 0.0;
        }
        let ratio = (cos_h / cos_oh).max(1e-5);
        let sin2 = 1.0 - cos_h * cos_h;
        let density =
            (-cos_h * cos_h / sin2 * self.inverse_sigma2).exp() * self.inverse_sigma2 * FRAC_1_PI / (sin2 * sin2);
        let grooves = (2.0 * ratio * wo.z).abs().min((2.0 * ratio * wi.z).abs()).min(1.0);
        0.25 * density * grooves / wo.z
    }

    /// Any direction above the surface is as likely.
    pub(super) const PDF: f32 = 1.0 / TAU;

    pub(super) fn sample(u: [f32; 2]) -> Vec3A {
        let (sin, cos) = (TAU * u[0]).sin_cos();
        let r = (u[1] * (2.0 - u[1])).max(0.0).sqrt();
        Vec3A::new(r * cos, r * sin, 1.0 - u[1])
    }
}

/// Steps of the cosine and of the roughness in [`FIBRES`].
const FIBRE_STEPS: usize = 32;

/// The tables of [`Microfiber`] as 32-bit floats, little-endian, by cosine and roughness from 0 to 1: the transform's two coefficients and the
/// albedo. From `fitting/python/data/ltc_table_sheen_volume.npy` of github.com/tizian/ltc-sheen (T. Zeltner, Apache License 2.0), which
/// accompanies the paper; rounded to single precision.
const FIBRES: &[u8; FIBRE_STEPS * FIBRE_STEPS * 12] = include_bytes!("../../../data/sheen.bin");

/// Cloth of fibres as a transformed cosine, by tables (Zeltner, Burley and Chiang 2022, "Practical Multiple-Scattering Sheen Using Linearly
/// Transformed Cosines"). The frame's x axis lies on the viewer's side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Microfiber {
    a: f32,
    b: f32,
}

impl Microfiber {
    /// The lobe and its albedo.
    pub(super) fn new(roughness: f32, cos_o: f32) -> (Self, f32) {
        let last = (FIBRE_STEPS - 1) as f32;
        let place = |value: f32| {
            let at = value.clamp(0.0, 1.0) * last;
            let step = (at as usize).min(FIBRE_STEPS - 2);
            (step, at - step as f32)
        };
        let ((i, across), (j, along)) = (place(cos_o), place(roughness.max(1e-3)));
        let entry = |i: usize, j: usize| {
            let at = (i * FIBRE_STEPS + j) * 12;
            let number = |k: usize| f32::from_le_bytes(std::array::from_fn(|byte| FIBRES[at + 4 * k + byte]));
            Vec3A::new(number(0), number(1), number(2))
        };
        let row = |i: usize| entry(i, j).lerp(entry(i, j + 1), along);
        let [a, b, albedo] = row(i).lerp(row(i + 1), across).to_array();
        (Self { a, b }, albedo)
    }

    /// True if the lobe scatters a visible amount.
    pub(super) fn is_valid(&self) -> bool {
        self.a > 1e-5
    }

    /// The lobe's value times cosine, which is its density.
    pub(super) fn density(&self, wi: Vec3A) -> f32 {
        let (x, y) = (self.a * wi.x + self.b * wi.z, self.a * wi.y);
        let length2 = x * x + y * y + wi.z * wi.z;
        FRAC_1_PI * wi.z * (self.a / length2).powi(2)
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> Vec3A {
        let d = warp::sample_cosine_hemisphere(u);
        Vec3A::new((d.x - d.z * self.b) / self.a, d.y / self.a, d.z).normalize()
    }
}

/// A disk of light about the normal, or about the mirrored ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Toon {
    full_rad: f32,
    fade_rad: f32,
    is_glossy: bool,
}

impl Toon {
    pub(super) fn new(size: f32, smooth: f32, is_glossy: bool) -> Self {
        Self { full_rad: size.clamp(1e-5, 1.0) * FRAC_PI_2, fade_rad: smooth.clamp(0.0, 1.0) * FRAC_PI_2, is_glossy }
    }

    pub(super) fn is_glossy(&self) -> bool {
        self.is_glossy
    }

    fn axis(&self, wo: Vec3A) -> Vec3A {
        if self.is_glossy { Vec3A::new(-wo.x, -wo.y, wo.z) } else { Vec3A::Z }
    }

    fn one_minus_cos(&self) -> f32 {
        1.0 - (self.full_rad + self.fade_rad).min(FRAC_PI_2).cos()
    }

    /// Value times cosine, and density.
    pub(super) fn evaluate(&self, wo: Vec3A, wi: Vec3A) -> (f32, f32) {
        let angle = self.axis(wo).dot(wi).clamp(0.0, 1.0).acos();
        let within = if angle < self.full_rad {
            1.0
        } else if angle < self.full_rad + self.fade_rad {
            1.0 - (angle - self.full_rad) / self.fade_rad
        } else {
            return (0.0, 0.0);
        };
        let pdf = warp::cone_pdf(self.one_minus_cos());
        (within * pdf, pdf)
    }

    pub(super) fn sample(&self, wo: Vec3A, u: [f32; 2]) -> Vec3A {
        let d = warp::sample_cone(u, self.one_minus_cos());
        warp::to_world(&warp::frame(self.axis(wo)), d)
    }
}

/// Ashikhmin and Shirley's lobe (2000), without Fresnel's law; `exponents` along x and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct AshikhminShirley {
    exponents: [f32; 2],
}

impl AshikhminShirley {
    pub(super) fn new(alpha: [f32; 2]) -> Self {
        // Twice a Beckmann width's inverse square, less two, is as wide.
        Self { exponents: alpha.map(Self::exponent_of) }
    }

    fn exponent_of(alpha: f32) -> f32 {
        2.0 / alpha.clamp(1e-4, 1.0).powi(2) - 2.0
    }

    /// Makes the lobe at least so wide along both axes.
    pub(super) fn widen(&mut self, alpha: f32) {
        self.exponents = self.exponents.map(|own| own.min(Self::exponent_of(alpha)));
    }

    fn exponent(&self, h: Vec3A) -> f32 {
        let [nx, ny] = self.exponents;
        let across2 = h.x * h.x + h.y * h.y;
        if across2 > 0.0 { (nx * h.x * h.x + ny * h.y * h.y) / across2 } else { nx }
    }

    /// Value times cosine, and density.
    pub(super) fn evaluate(&self, wo: Vec3A, wi: Vec3A) -> (f32, f32) {
        let h = (wo + wi).normalize_or(Vec3A::Z);
        let cos = wo.dot(h).abs().max(1e-6);
        let [nx, ny] = self.exponents;
        let norm = ((nx + 1.0) * (ny + 1.0)).sqrt() / (8.0 * PI);
        let pdf = norm * h.z.max(1e-6).powf(self.exponent(h)) / cos;
        (wi.z * pdf / wi.z.max(wo.z), pdf)
    }

    pub(super) fn sample(&self, wo: Vec3A, u: [f32; 2]) -> Vec3A {
        let [nx, ny] = self.exponents;
        let turn = TAU * u[0];
        // The quadrant's own angle, stretched.
        let (sin, cos) = turn.sin_cos();
        let (x, y) = ((ny + 1.0).sqrt() * cos, (nx + 1.0).sqrt() * sin);
        let across = Vec3A::new(x, y, 0.0).normalize_or(Vec3A::X);
        let z = (1.0 - u[1]).max(1e-12).powf(1.0 / (self.exponent(across) + 1.0));
        let h = across * (1.0 - z * z).max(0.0).sqrt() + Vec3A::Z * z;
        2.0 * wo.dot(h) * h - wo
    }
}
