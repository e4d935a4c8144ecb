//! Films on surfaces, thin enough for the light from their two faces to interfere (Belcour and Barla 2017).
//!
//! The sum over the light that goes to and fro in the film is taken in the first few of its orders, as in Cycles; each
//! order's interference is the Fourier transform of the three channels' sensitivities at its optical path.

use super::fresnel::F82Tint;
use crate::Rgb;
use crate::spectrum;
use glam::Vec3;
use std::sync::LazyLock;

/// Steps of the optical path, nm: a fortieth of the shortest wave.
const STEP_NM: f32 = 10.0;
/// Beyond so many steps nothing is left of any interference.
const STEPS: usize = 4096;
/// Orders that can be seen.
const ORDERS: usize = 3;

/// A complex number in single precision.
#[derive(Clone, Copy, Debug)]
struct Complex {
    re: f32,
    im: f32,
}

impl Complex {
    fn times(self, o: Self) -> Self {
        Self { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }

    fn over(self, o: Self) -> Self {
        let size2 = (o.re * o.re + o.im * o.im).max(1e-30);
        self.times(Self { re: o.re / size2, im: -o.im / size2 })
    }

    /// Squared length, and the direction.
    fn polar(self) -> (f32, Self) {
        let size2 = self.re * self.re + self.im * self.im;
        let length = size2.sqrt();
        let direction =
            if length > 0.0 { Self { re: self.re / length, im: self.im / length } } else { Self { re: 1.0, im: 0.0 } };
        (size2, direction)
    }
}

/// The material below a film.
#[derive(Clone, Copy, Debug)]
enum Below {
    /// A dielectric of that relative index.
    Dielectric(f32),
    /// A metal of that index and extinction coefficient; its reflectance may be that of a tinted metal.
    Metal { n: Rgb, k: Rgb, near_grazing: Option<Rgb> },
}

/// A film, in units of the medium above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct RelativeFilm {
    thickness_nm: f32,
    index: f32,
    below: Below,
}

impl RelativeFilm {
    /// Films thinner than this, nm, are none.
    pub(super) const LEAST_NM: f32 = 0.1;

    /// A film over a dielectric; both indices are relative to the medium above.
    pub(super) fn over_dielectric(thickness_nm: f32, index: f32, eta: f32) -> Self {
        Self::new(thickness_nm, index, Below::Dielectric(eta))
    }

    /// A film over a metal of known index.
    pub(super) fn over_conductor(thickness_nm: f32, index: f32, n: Rgb, k: Rgb) -> Self {
        Self::new(thickness_nm, index, Below::Metal { n, k, near_grazing: None })
    }

    /// A film over a metal of which two reflectances are known: its index is guessed from them (Gulbrandsen 2014).
    pub(super) fn over_tinted(thickness_nm: f32, index: f32, f0: Rgb, metal: F82Tint) -> Self {
        let g = metal.at(1.0 / 7.0);
        let r = f0.min(Rgb::splat(0.999));
        let root = Rgb::from(r.to_array().map(f32::sqrt));
        let (most, least) = ((1.0 + root) / (1.0 - root), (1.0 - r) / (1.0 + r));
        let n = most + (least - most) * g;
        let k2 = (r * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - r);
        let k = Rgb::from(k2.max(Rgb::ZERO).to_array().map(f32::sqrt));
        Self::new(thickness_nm, index, Below::Metal { n, k, near_grazing: Some(g) })
    }

    fn new(thickness_nm: f32, index: f32, below: Below) -> Self {
        // Of less than a nanometre a film has less and less of its own.
        let t = thickness_nm.clamp(0.0, 1.0);
        let index = 1.0 + (index.max(1e-5) - 1.0) * (t * t * (3.0 - 2.0 * t));
        Self { thickness_nm, index, below }
    }

    /// Reflectance at the cosine `cos` to the normal.
    pub(super) fn at(&self, cos: f32) -> Rgb {
        let Some(inner) = inner_cosine(cos, self.index) else { return Rgb::ONE };
        let above =
            polarised(1.0, cos, Complex { re: self.index * inner, im: 0.0 }, Complex { re: self.index, im: 0.0 });
        let path_nm = 2.0 * self.index * self.thickness_nm * inner;
        match self.below {
            Below::Dielectric(eta) => {
                let Some(last) = inner_cosine(inner, eta / self.index) else { return Rgb::ONE };
                let normal = Complex { re: eta * last, im: 0.0 };
                let below = polarised(self.index, inner, normal, Complex { re: eta, im: 0.0 });
                self.sum(above, [below; 3], path_nm)
            }
            Below::Metal { n, k, near_grazing } => {
                let channel = |c: usize| {
                    let (n, k) = (n[c], k[c]);
                    // The index times the complex cosine beyond.
                    let t = n * n - k * k - self.index * self.index * (1.0 - inner * inner);
                    let size = t.hypot(2.0 * n * k);
                    let normal =
                        Complex { re: (0.5 * (size + t)).max(0.0).sqrt(), im: (0.5 * (size - t)).max(0.0).sqrt() };
                    let mut below = polarised(self.index, inner, normal, Complex { re: n, im: k });
                    if let Some(g) = near_grazing {
                        let (n, k2) = (n / self.index, (k / self.index).powi(2));
                        let f0 = ((n - 1.0).powi(2) + k2) / ((n + 1.0).powi(2) + k2);
                        let plain = F82Tint::new(Rgb::splat(f0), Rgb::ONE).at(1.0 / 7.0).x;
                        let tint = Rgb::splat(g[c] / plain);
                        let reflectance = F82Tint::new_unbounded(Rgb::splat(f0), tint).at(inner).x;
                        below[0].0 = reflectance;
                        below[1].0 = reflectance;
                    }
                    below
                };
                self.sum(above, [channel(0), channel(1), channel(2)], path_nm)
            }
        }
    }

    /// Reflectance at the cosine `cos` over a dielectric whose reflectance at normal incidence, `real_f0`, is tinted to
    /// `f0`.
    pub(super) fn tinted(&self, cos: f32, real_f0: f32, f0: Rgb) -> Rgb {
        let f = self.at(cos);
        if real_f0 <= 1e-5 || f == Rgb::ONE {
            return f;
        }
        let near = ((Rgb::ONE - f) / (1.0 - real_f0)).clamp(Rgb::ZERO, Rgb::ONE);
        f * (Rgb::ONE + (f0 / real_f0 - 1.0) * near)
    }

    /// Reflectance, the mean of both polarisations.
    fn sum(&self, above: [(f32, Complex); 2], below: [[(f32, Complex); 2]; 3], path_nm: f32) -> Rgb {
        let transforms: [[Vec3; 2]; ORDERS] = std::array::from_fn(|order| sensitivity((order + 1) as f32 * path_nm));
        let mut total = Rgb::ZERO;
        for (polarisation, &(r12, phase12)) in above.iter().enumerate() {
            for channel in 0..3 {
                let (r23, phase23) = below[channel][polarisation];
                let through = 1.0 - r12;
                let both = r12 * r23;
                let repeated = through * through * r23 / (1.0 - both).max(1e-6);
                // From below, the upper face turns the phase the other way.
                let turn = phase23.times(Complex { re: -phase12.re, im: phase12.im });
                let (mut phase, mut part, mut sum) = (turn, repeated - through, r12 + repeated);
                for [re, im] in &transforms {
                    part *= both.sqrt();
                    sum += 2.0 * part * (phase.re * re[channel] - phase.im * im[channel]);
                    phase = phase.times(turn);
                }
                total[channel] += 0.5 * sum;
            }
        }
        total.clamp(Rgb::ZERO, Rgb::ONE)
    }
}

/// Cosine of the angle beyond a boundary into relative index `eta`; `None` at total reflection.
fn inner_cosine(cos: f32, eta: f32) -> Option<f32> {
    let cos2 = 1.0 - (1.0 - cos * cos) / (eta * eta);
    (cos2 > 0.0).then(|| cos2.sqrt())
}

/// Reflectances and directions of the amplitude, perpendicular and parallel, from index `n1` at cosine `c1` into index
/// `n2`, whose product with the cosine beyond is `normal`.
fn polarised(n1: f32, c1: f32, normal: Complex, n2: Complex) -> [(f32, Complex); 2] {
    let ratio = |a: Complex, b: Complex| {
        let difference = Complex { re: a.re - b.re, im: a.im - b.im };
        difference.over(Complex { re: a.re + b.re, im: a.im + b.im }).polar()
    };
    let squared = n2.times(n2);
    let perpendicular = ratio(Complex { re: n1 * c1, im: 0.0 }, normal);
    let parallel =
        ratio(Complex { re: squared.re * c1, im: squared.im * c1 }, Complex { re: n1 * normal.re, im: n1 * normal.im });
    [perpendicular, parallel]
}

/// The response of the three channels to a wave that is shifted by an optical path: cosine and sine parts.
fn sensitivity(path_nm: f32) -> [Vec3; 2] {
    static TABLE: LazyLock<Vec<[Vec3; 2]>> = LazyLock::new(|| {
        let mut table = vec![[Vec3::ZERO; 2]; STEPS];
        let waves: Vec<(f64, glam::DVec3)> =
            (380..780).map(|nm| (f64::from(nm), spectrum::film(f64::from(nm)))).collect();
        let white: glam::DVec3 = waves.iter().map(|(_, film)| *film).sum();
        for (i, entry) in table.iter_mut().enumerate() {
            let mut sums = [glam::DVec3::ZERO; 2];
            for (nm, film) in &waves {
                let (sin, cos) = (std::f64::consts::TAU * i as f64 * f64::from(STEP_NM) / nm).sin_cos();
                sums[0] += *film * cos;
                sums[1] += *film * sin;
            }
            *entry = sums.map(|sum| (sum / white).as_vec3());
        }
        table
    });
    let place = (path_nm / STEP_NM).max(0.0);
    let i = place as usize;
    if i + 1 >= STEPS {
        return [Vec3::ZERO; 2];
    }
    let part = place - i as f32;
    [0, 1].map(|c| TABLE[i][c].lerp(TABLE[i + 1][c], part))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::fresnel;

    /// A film of no thickness, or of the index of the medium below, is not there; one of air neither.
    #[test]
    fn some_films_change_nothing() {
        for cos in [0.1f32, 0.5, 1.0] {
            let bare = Rgb::splat(fresnel::dielectric(cos, 1.5));
            for film in [
                RelativeFilm::over_dielectric(0.0, 1.33, 1.5),
                RelativeFilm::over_dielectric(500.0, 1.5, 1.5),
                RelativeFilm::over_dielectric(500.0, 1.0, 1.5),
            ] {
                assert!((film.at(cos) - bare).abs().max_element() < 1e-4, "{cos} {film:?}: {} {bare}", film.at(cos));
            }
            let (n, k) = (Rgb::new(0.2, 0.9, 1.4), Rgb::new(3.9, 2.4, 1.6));
            let gold = fresnel::conductor(cos, n, k);
            let film = RelativeFilm::over_conductor(300.0, 1.0, n, k);
            assert!((film.at(cos) - gold).abs().max_element() < 1e-4, "{cos}: {} {gold}", film.at(cos));
        }
    }

    /// The classic case: a quarter of a wave of magnesium fluoride on glass takes from the reflection of the green
    /// the value of the product of the indices, and more of it than of red and blue.
    #[test]
    fn a_quarter_of_a_wave_dims_the_reflection() {
        let (film, glass) = (1.38f32, 1.52f32);
        let coated = RelativeFilm::over_dielectric(550.0 / (4.0 * film), film, glass).at(1.0);
        let least = ((glass - film * film) / (glass + film * film)).powi(2);
        // Green is not of one wavelength, and the sum of the orders ends.
        assert!((coated.y - least).abs() < 1e-3, "{coated} {least}");
        assert!(coated.x > coated.y && coated.z > coated.y && coated.max_element() < fresnel::f0_from_ior(glass));
    }
}
