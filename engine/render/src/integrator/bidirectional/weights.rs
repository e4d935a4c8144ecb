//! MIS weights of bidirectional paths: the power heuristic over all techniques, from sums that grow with the path.
//!
//! A path has the scattering places v1 (seen by the camera) to vk (lit by the source), a direction from v1 to the lens
//! and one from vk to the source. The camera's side makes v1 ... vj, the light's side the rest. Let a_i be the density,
//! per unit of area, with which the camera's side chooses v_i, b_i that of the light's side; a_1 and b_k include the
//! direction at the path's end. Making v1 ... vj from the camera has the density a_1 ... a_j b_(j+1) ... b_k, and the sum
//! over all others, in units of the technique in hand, falls apart into a part for either side. A side keeps two numbers
//! ([`Partial`]), so that its part is
//!
//!   b_j² (ends + p_j² before)
//!
//! once the density b_j of its last place, and p_j, the density with which the other side would go on from there, are
//! known (Georgiev 2012, "Implementing Vertex Connection and Merging", where they are called dVCM and dVC). A mirror
//! cannot be connected to: its terms drop out, its densities cancel. The chances of ending a path early, and of passing
//! a transparent surface, are left out of all densities alike.

/// One side's sums over the techniques that end in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Partial {
    /// The sum of the technique that connects just before the last place.
    pub(super) ends: f64,
    /// The sum of all techniques before that.
    pub(super) before: f64,
}

impl Partial {
    /// The sums at the first place of a side: `density` is its own, `other` that with which the end is chosen when the other side makes
    /// this place; `again` is 1 where the end may also be hit by chance, else 0.
    pub(super) fn first(density: f64, other: f64, again: f64) -> Self {
        let inverse2 = (1.0 / density).powi(2);
        Self { ends: inverse2 * other * other, before: inverse2 * again }
    }

    /// The sums on a ray that leaves the last place, chosen with `pdf` per steradian, at `cos_out` to the triangle's normal; back along the
    /// path the other side would go with `back_pdf`.
    pub(super) fn scattered(self, pdf: f32, cos_out: f32, back_pdf: f32) -> Self {
        let inverse = 1.0 / f64::from(pdf);
        let ratio = f64::from(cos_out) * inverse;
        Self { ends: inverse * inverse, before: ratio * ratio * (self.ends + squared(back_pdf) * self.before) }
    }

    /// The sums on a ray that was mirrored or refracted at the last place.
    pub(super) fn mirrored(self, cos_out: f32) -> Self {
        Self { ends: 0.0, before: squared(cos_out) * self.before }
    }

    /// The sums at the place where a ray arrives after `distance`, at `cos_in` to the triangle's normal.
    pub(super) fn arrived(self, distance: f32, cos_in: f32) -> Self {
        let per_cos2 = 1.0 / squared(cos_in);
        Self { ends: self.ends * per_cos2 * squared(distance).powi(2), before: self.before * per_cos2 }
    }

    /// The sum over this side's techniques, where the other side reaches the last place with `density` per unit of area
    /// and goes on with `back_pdf`.
    pub(super) fn others(self, density: f64, back_pdf: f32) -> f64 {
        density * density * (self.ends + squared(back_pdf) * self.before)
    }
}

/// The weight of a technique beside which the sum of all others is `others`.
pub(super) fn weight(others: f64) -> f32 {
    (1.0 / (1.0 + others)) as f32
}

#[inline]
pub(super) fn squared(x: f32) -> f64 {
    f64::from(x) * f64::from(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The geometry and densities of a path of four places, and from them the weights of all techniques, by the sums and
    /// by their definition: they are the same, and add to one.
    #[test]
    fn weights_are_those_of_the_definition() {
        // By place: distance to the next, cosines towards camera and light, densities per steradian towards both.
        let distance = [1.3f32, 0.7, 2.1];
        let (to_eye, to_light) = ([0.9f32, 0.3, 0.6, 0.8], [0.5f32, 0.7, 0.2, 0.4]);
        let (eye_pdf, light_pdf) = ([0.4f32, 2.5, 0.3, 0.8], [0.2f32, 1.5, 0.6, 0.9]);
        // Density of the first place with its direction, of aiming there, of a light sample, of the last place.
        let (a1, aim, sample, bk) = (0.7f64, 3.0f64, 1.9f64, 0.35f64);
        // Per area: a[i] from place i-1, b[i] from place i+1.
        let area = |pdf: f32, cos: f32, d: f32| f64::from(pdf * cos / (d * d));
        let a = [
            a1,
            area(light_pdf[0], to_eye[1], distance[0]),
            area(light_pdf[1], to_eye[2], distance[1]),
            area(light_pdf[2], to_eye[3], distance[2]),
        ];
        let b = [
            area(eye_pdf[1], to_light[0], distance[0]),
            area(eye_pdf[2], to_light[1], distance[1]),
            area(eye_pdf[3], to_light[2], distance[2]),
            bk,
        ];
        // Technique j makes j places from the camera; the last two all four, with a light sample or by chance.
        let made = |j: usize| a[..j].iter().product::<f64>() * b[j..].iter().product::<f64>();
        let densities = [made(0) * aim, made(1), made(2), made(3), made(4) * sample, made(4) * f64::from(light_pdf[3])];
        let total: f64 = densities.iter().map(|p| p * p).sum();

        let mut eye = vec![Partial::first(a1, aim, 0.0)];
        let mut light = vec![Partial::first(bk, sample, 1.0)];
        for i in 0..3 {
            eye.push(eye[i].scattered(light_pdf[i], to_light[i], eye_pdf[i]).arrived(distance[i], to_eye[i + 1]));
            let k = 3 - i;
            light.push(
                light[i].scattered(eye_pdf[k], to_eye[k], light_pdf[k]).arrived(distance[k - 1], to_light[k - 1]),
            );
        }
        light.reverse();
        let last = eye[3];
        let by_chance = last.scattered(light_pdf[3], to_light[3], eye_pdf[3]);
        let density = bk / f64::from(to_light[3]);
        let others = [
            light[0].others(a1, light_pdf[0]) / (aim * aim),
            eye[0].others(b[0], eye_pdf[0]) + light[1].others(a[1], light_pdf[1]),
            eye[1].others(b[1], eye_pdf[1]) + light[2].others(a[2], light_pdf[2]),
            eye[2].others(b[2], eye_pdf[2]) + light[3].others(a[3], light_pdf[3]),
            (squared(light_pdf[3]) + last.others(bk, eye_pdf[3])) / (sample * sample),
            sample * sample * by_chance.ends + density * density * by_chance.before,
        ];
        for (j, (p, others)) in densities.iter().zip(others).enumerate() {
            let (expected, found) = (p * p / total, weight(others));
            assert!((f64::from(found) - expected).abs() < 1e-5, "{j}: {found} {expected}");
        }
    }
}
