//! Phase functions: how light that a medium scatters is spread over directions. Each is a density per steradian of the
//! cosine between the directions before and after, and is sampled exactly.

use std::f32::consts::PI;

/// A phase function with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseLobe {
    /// Henyey and Greenstein 1941, by its mean cosine.
    HenyeyGreenstein(f32),
    /// Draine 2003, "Scattering by interstellar dust grains", equation 4: Henyey and Greenstein's times 1 + alpha
    /// cos^2.
    Draine {
        /// The parameter g, as in Henyey and Greenstein's.
        anisotropy: f32,
        /// The parameter alpha, at least 0.
        alpha: f32,
    },
    /// Fournier and Forand 1994, in the form of Fournier and Jonasz 1999.
    FournierForand {
        /// 4 / (3 (n - 1)^2): their delta over the square of the half angle's sine.
        delta: f32,
        /// Fournier and Forand's nu.
        nu: f32,
        /// (1 - delta_180^nu) / ((delta_180 - 1) delta_180^nu).
        back: f32,
    },
}

/// Anisotropies are kept this far from 1.
const LEAST_BLUR: f32 = 1e-3;
/// Halvings that find a cosine by its share of the light.
const HALVINGS: u32 = 26;

impl PhaseLobe {
    /// Isotropic scattering, as Henyey and Greenstein's with a mean cosine of 0.
    pub const EVEN: Self = Self::HenyeyGreenstein(0.0);
    /// Rayleigh scattering, as Draine's with g = 0 and alpha = 1.
    pub const RAYLEIGH: Self = Self::Draine { anisotropy: 0.0, alpha: 1.0 };

    /// Henyey and Greenstein's, its anisotropy kept within reach.
    pub fn henyey_greenstein(anisotropy: f32) -> Self {
        Self::HenyeyGreenstein(within(anisotropy))
    }

    /// Draine's phase function, its parameters kept within reach.
    pub fn draine(anisotropy: f32, alpha: f32) -> Self {
        Self::Draine { anisotropy: within(anisotropy), alpha: alpha.clamp(0.0, 1e4) }
    }

    /// Fournier and Forand's, by the particles' index of refraction and the part of the light that goes back.
    pub fn fournier_forand(ior: f32, backscatter: f32) -> Self {
        // At an index of 1 nothing would be scattered; at a half and more the function is none.
        let n = (ior - 1.0).abs().clamp(1e-3, 2.0);
        let b = backscatter.clamp(1e-5, 0.5 - 1e-5);
        let delta = 4.0 / (3.0 * n * n);
        let (at_90, at_180) = (0.5 * delta, delta);
        let nu = if (at_90 - 1.0).abs() < 1e-4 {
            -2.0 * b
        } else {
            -(2.0 * b * (at_90 - 1.0) + 1.0).max(1e-6).ln() / at_90.ln()
        };
        let back = if (at_180 - 1.0).abs() < 1e-4 { nu } else { (at_180.powf(-nu) - 1.0) / (at_180 - 1.0) };
        Self::FournierForand { delta, nu, back }
    }

    /// Fog of droplets of that diameter: a share of the first, the rest of the second (Jendersie and d'Eon 2023, "An
    /// Approximate Mie Scattering Function for Fog and Cloud Rendering", equations 4 to 7).
    pub fn mie(diameter_um: f32) -> [(f32, Self); 2] {
        let d = diameter_um.clamp(1e-3, 50.0);
        let l = d.ln();
        let (g_hg, g_d, alpha, share) = if d <= 0.1 {
            (13.8 * d * d, 1.1456 * d * (9.29044 * d).sin(), 250.0, 0.252_977 - 312.983 * d.powf(4.3))
        } else if d <= 1.5 {
            let inner = ((l - 0.238_604) * (l + 1.00667) / (0.507_522 - 0.156_77 * l)).cos();
            (
                0.862 - 0.143 * l * l,
                0.379_685 * (1.19692 * inner + 1.37932 * l + 0.062_583_5).cos() + 0.344_213,
                250.0,
                0.146_209 * (3.38707 * l + 2.11193).cos() + 0.316_072 + 0.077_891_7 * l,
            )
        } else if d <= 5.0 {
            let ll = l.ln();
            (
                0.060_493_1 * ll + 0.940_256,
                0.500_411 - 0.081_287 / (-2.0 * l + l.tan() + 1.27551),
                7.30354 * l + 6.31675,
                0.026_914 * (l - (5.68947 * (ll - 0.029_214_9)).cos()) + 0.376_475,
            )
        } else {
            (
                (-0.099_056_7 / (d - 1.67154)).exp(),
                (-2.20679 / (d + 3.91029) - 0.428_934).exp(),
                (3.62489 - 8.29288 / (d + 5.52825)).exp(),
                (-0.599_085 / (d - 0.641_583) - 0.665_888).exp(),
            )
        };
        let share = share.clamp(0.0, 1.0);
        [(share, Self::draine(g_d, alpha)), (1.0 - share, Self::henyey_greenstein(g_hg))]
    }

    /// Density per steradian at that cosine: the phase function itself.
    pub fn density(self, cos: f32) -> f32 {
        match self {
            Self::HenyeyGreenstein(g) => henyey_greenstein(g, cos),
            Self::Draine { anisotropy: g, alpha } => {
                let whole = 1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0;
                henyey_greenstein(g, cos) * (1.0 + alpha * cos * cos) / whole
            }
            Self::FournierForand { delta, nu, back } => {
                // Double: differences of what is nearly the same.
                let [delta, nu, back, cos] = [delta, nu, back, cos].map(f64::from);
                let s = (0.5 * (1.0 - cos)).max(1e-9);
                let d = delta * s;
                let e = 1.0 - d;
                let forward = if e.abs() < 1e-5 {
                    // The limit at delta = 1, by the first terms of the series.
                    0.5 * nu * (nu - 1.0) - 0.5 * nu * (nu + 1.0) / s
                } else {
                    let p = d.powf(nu);
                    (nu * e - (1.0 - p) + (d * (1.0 - p) - nu * e) / s) / (e * e * p)
                };
                let value = (forward + 0.25 * back * (3.0 * cos * cos - 1.0)) / (4.0 * std::f64::consts::PI);
                value.max(0.0) as f32
            }
        }
    }

    /// The cosine below which a share `u` of the light goes, 0 to 1.
    pub fn sample(self, u: f32) -> f32 {
        match self {
            Self::HenyeyGreenstein(g) => {
                if g.abs() < 1e-3 {
                    return 1.0 - 2.0 * u;
                }
                let k = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
                ((1.0 + g * g - k * k) / (2.0 * g)).clamp(-1.0, 1.0)
            }
            Self::Draine { .. } => self.found(u),
            Self::FournierForand { .. } => {
                // By the half angle's sine squared, in the scale of which the peak is wide.
                let (mut low, mut high) = (-24.0f32, 0.0f32);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    if self.within_angle(middle.exp()) < u { low = middle } else { high = middle }
                }
                (1.0 - 2.0 * (0.5 * (low + high)).exp()).clamp(-1.0, 1.0)
            }
        }
    }

    fn found(self, u: f32) -> f32 {
        let (mut low, mut high) = (-1.0f64, 1.0f64);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.below(middle) < f64::from(u) { low = middle } else { high = middle }
        }
        (0.5 * (low + high)) as f32
    }

    /// Draine's share of the light below a cosine.
    fn below(self, cos: f64) -> f64 {
        let Self::Draine { anisotropy, alpha } = self else { return 0.0 };
        let (g, alpha) = (f64::from(anisotropy), f64::from(alpha));
        if g.abs() < 1e-3 {
            let part = |c: f64| c + alpha * c * c * c / 3.0;
            return (part(cos) - part(-1.0)) / (part(1.0) - part(-1.0));
        }
        // With s^2 = 1 + g^2 - 2 g cos the integrand is a sum of powers of s.
        let k = 1.0 + g * g;
        let part = |c: f64| {
            let s = (k - 2.0 * g * c).max(0.0).sqrt();
            (1.0 / s + alpha / (4.0 * g * g) * (k * k / s + 2.0 * k * s - s * s * s / 3.0)) / g
        };
        (part(cos) - part(-1.0)) / (part(1.0) - part(-1.0))
    }

    /// Fournier and Forand's share of the light within an angle, by the square of the sine of its half.
    fn within_angle(self, s: f32) -> f32 {
        let Self::FournierForand { delta, nu, back } = self else { return 0.0 };
        let [delta, nu, back, s] = [delta, nu, back, s].map(f64::from);
        let d = delta * s;
        let cos = 1.0 - 2.0 * s;
        let forward = if (d - 1.0).abs() < 1e-5 {
            (1.0 + nu) - nu * s
        } else {
            let p = d.powf(nu);
            ((1.0 - p * d) - (1.0 - p) * s) / ((1.0 - d) * p)
        };
        (forward + 0.125 * back * cos * (1.0 - cos * cos)) as f32
    }
}

fn within(anisotropy: f32) -> f32 {
    anisotropy.clamp(LEAST_BLUR - 1.0, 1.0 - LEAST_BLUR)
}

fn henyey_greenstein(g: f32, cos: f32) -> f32 {
    let square = 1.0 + g * g - 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * square * square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    fn lobes() -> Vec<PhaseLobe> {
        let mut all = vec![
            PhaseLobe::EVEN,
            PhaseLobe::henyey_greenstein(0.7),
            PhaseLobe::henyey_greenstein(-0.5),
            PhaseLobe::RAYLEIGH,
            PhaseLobe::draine(0.6, 0.5),
            PhaseLobe::draine(-0.3, 20.0),
            PhaseLobe::fournier_forand(1.33, 0.1),
            PhaseLobe::fournier_forand(1.05, 0.02),
            PhaseLobe::fournier_forand(1.5, 0.3),
            // Where the half angle's delta is 1.
            PhaseLobe::fournier_forand(1.0 + (2.0f32 / 3.0).sqrt(), 0.35),
        ];
        for diameter in [0.05, 0.5, 3.0, 20.0] {
            all.extend(PhaseLobe::mie(diameter).map(|(_, lobe)| lobe));
        }
        all
    }

    /// Integrates over cosines with most points near the forward peak.
    fn integral(lobe: PhaseLobe, from: f64, weight: impl Fn(f64) -> f64) -> f64 {
        const STEPS: usize = 200_000;
        // (1 - cos) / 2 = t^4.
        let most = ((1.0 - from) / 2.0).powf(0.25);
        let at = |i: usize| {
            let t = (i as f64 + 0.5) / STEPS as f64 * most;
            let cos = 1.0 - 2.0 * t.powi(4);
            f64::from(lobe.density(cos as f32)) * weight(cos) * 8.0 * t.powi(3)
        };
        2.0 * std::f64::consts::PI * (0..STEPS).map(at).sum::<f64>() * most / STEPS as f64
    }

    #[test]
    fn they_integrate_to_one() {
        for lobe in lobes() {
            let whole = integral(lobe, -1.0, |_| 1.0);
            // A cosine in single precision does not tell apart the last half a hundredth of the narrowest peak.
            assert!((whole - 1.0).abs() < 7e-3, "{lobe:?}: {whole}");
        }
    }

    /// Cosines of samples follow the density.
    #[test]
    fn samples_follow_the_density() {
        for lobe in lobes() {
            // (1 - cos) / 2 = t^4: more cells at a forward peak. Below the least t cosines in single precision are too few.
            let (cos, least) = (|t: f64| 1.0 - 2.0 * t.powi(4), 0.05);
            sampling::values(
                &format!("{lobe:?}"),
                1 << 18,
                [least, 1.0],
                |random| {
                    let [u] = random.numbers();
                    let t = (0.5 - 0.5 * f64::from(lobe.sample(u))).powf(0.25);
                    (t >= least).then_some(t)
                },
                |t| f64::from(lobe.density(cos(t) as f32)) * 16.0 * std::f64::consts::PI * t.powi(3),
            );
        }
    }

    /// The properties of phase functions as published: the mean cosine, the part that goes back.
    #[test]
    fn their_parameters_mean_what_they_say() {
        for g in [-0.5, 0.0, 0.3, 0.8] {
            let mean = integral(PhaseLobe::henyey_greenstein(g), -1.0, |cos| cos);
            assert!((mean - f64::from(g)).abs() < 2e-3, "{g}: {mean}");
        }
        for b in [0.02, 0.1, 0.3] {
            let lobe = PhaseLobe::fournier_forand(1.2, b);
            let back = integral(lobe, -1.0, |cos| if cos < 0.0 { 1.0 } else { 0.0 });
            assert!((back - f64::from(b)).abs() < 1e-3, "{b}: {back}");
        }
        // 3 / (16 pi) (1 + cos^2).
        let (found, rayleigh) = (PhaseLobe::RAYLEIGH.density(0.4), 3.0 / (16.0 * PI) * 1.16);
        assert!((found - rayleigh).abs() < 1e-6, "{found}, not {rayleigh}");
    }
}
