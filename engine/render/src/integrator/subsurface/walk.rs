//! A random walk through a body (Chiang, Kutz and Burley 2016), guided towards the surface (Dwivedi sampling): directions that lead out
//! of the body are taken more often, and stretches along them are longer, as in the diffusion of light in a half space (Křivánek and
//! d'Eon 2014, "A Zero-Variance-Based Sampling Scheme for Monte Carlo Subsurface Scattering"; Meng, Hanika and Dachsbacher 2016,
//! "Improving the Dwivedi Sampling Scheme"; d'Eon and Křivánek 2020, "Zero-Variance Theory for Efficient Subsurface Scattering").

use super::own_surface;
use crate::Rgb;
use crate::accel::{Ray, offset_origin};
use crate::integrator::PreparedScene;
use crate::sampler::phase::PhaseLobe;
use crate::sampler::{PathSampler, warp};
use crate::shading::subsurface::Medium;
use crate::surface::SurfacePoint;
use glam::Vec3A;
use std::f32::consts::TAU;

/// Scatterings after which a walk is given up.
const MOST_STEPS: u32 = 256;
/// Scatterings after which their direction no longer matters.
const EVEN_AFTER: u32 = 10;
/// Part of a walk's light below which Russian roulette may end it.
const FAINT: f32 = 0.5;
/// The other side of a body is looked for within so many of the longest free paths.
const FAR_SIDE_PATHS: f32 = 10.0;
/// A stretch of so many free paths lets nothing through that is seen.
const MOST_EXPONENT: f32 = 60.0;

/// The place where a walk that begins at `point` leaves the body, seen from outside, and the light that is left; `None` where the walk
/// ends within.
pub(super) fn walk(
    stage: &PreparedScene,
    point: &SurfacePoint,
    (direction, mut light, mut medium): (Vec3A, Rgb, Medium),
    sampler: &mut PathSampler,
    rays: &mut u32,
) -> Option<(SurfacePoint, Rgb)> {
    let outwards = point.geometric_normal;
    let mut ray = Ray::new(point.position, direction).at(point.moment);
    // The way from the entry, which rounding at the scale of the scene would swallow where free paths are short.
    let mut from_entry = Vec3A::ZERO;
    let mut guide = Guide::new(&medium, outwards, point.position);
    for step in 0..MOST_STEPS {
        if step == EVEN_AFTER {
            medium = medium.even();
            guide = Guide { far_side: guide.far_side, ..Guide::new(&medium, outwards, point.position) };
        }
        let [u_channel, u_distance, u0, u1] = sampler.next_4d();
        // A channel, by what it may still bring.
        let chances = light * medium.albedo;
        let total = chances.element_sum();
        if total <= 0.0 || !total.is_finite() {
            return None;
        }
        let chances = chances / total;
        let (channel, u_way) = chosen(chances.to_array(), u_channel);
        let ways = if step == 0 {
            Ways::STRAIGHT
        } else {
            let (direction, ways) = guide.turn(&medium, &ray, [u_way, u0, u1]);
            ray.direction = direction;
            ways
        };
        let distance = -(1.0 - u_distance).ln() / (medium.extinction[channel] * ways.stretches()[ways.taken]);
        let mut hit = match StretchStart::new(point, from_entry, ray.direction) {
            StretchStart::Out { t } => Some((*point, t)),
            StretchStart::Within { origin, ahead } => {
                // The first stretch also looks for the body's other side.
                let farthest = FAR_SIDE_PATHS / medium.extinction.min_element();
                let t_max = if step == 0 { distance.max(farthest) } else { distance } - ahead;
                let traced = Ray { origin, t_max, ..ray };
                let found = if t_max > 0.0 { own_surface(stage, point.instance, traced, rays) } else { None };
                found.map(|(exit, t)| (exit, ahead + t))
            }
        };
        if step == 0 {
            guide.far_side = hit.as_ref().map(|(_, t)| -outwards.dot(direction) * t);
        }
        hit = hit.filter(|(_, t)| *t < distance);
        let length = hit.as_ref().map_or(distance, |(_, t)| *t);
        let left = (medium.extinction * -length).exp();
        let density = chances.dot(ways.density(medium.extinction, length, hit.is_some(), left));
        if let Some((exit, _)) = hit {
            light *= left / density;
            return light.is_finite().then(|| (exit.seen_from(ray.direction), light));
        }
        light *= medium.extinction * medium.albedo * left / density;
        let go_on = light.max_element() / FAINT;
        if go_on < 1.0 {
            if sampler.next_4d()[0] >= go_on {
                return None;
            }
            light /= go_on;
        }
        from_entry += ray.direction * distance;
        ray.origin = point.position + from_entry;
    }
    None
}

/// The beginning of a stretch of a walk. The surface that light entered by is known up to rounding alone, within which no ray may start: there
/// it is taken for a plane. Rays that began so far within the body would lose the light that comes back from before them, which is most
/// where free paths are as short.
enum StretchStart {
    /// The stretch leaves the body where the walk entered it, at this distance.
    Out { t: f32 },
    /// A ray may start at this origin, a distance `ahead` along the stretch.
    Within { origin: Vec3A, ahead: f32 },
}

impl StretchStart {
    /// That of a stretch along a direction from a place so far from `point`, where the walk entered.
    fn new(point: &SurfacePoint, from_entry: Vec3A, direction: Vec3A) -> Self {
        /// Distance from the entry over its error up to which the surface is taken for a plane.
        const NEAR: f32 = 2.0;
        /// Least cosine to the normal at which a stretch is followed along the plane; others start below it.
        const LEAST_SLANT: f32 = 0.05;
        let (outwards, error) = (point.geometric_normal, point.position_error);
        let (depth, slant) = (-outwards.dot(from_entry), -outwards.dot(direction));
        let here = point.position + from_entry;
        if depth >= error || from_entry.length() > NEAR * error {
            Self::Within { origin: here, ahead: 0.0 }
        } else if slant < -LEAST_SLANT {
            Self::Out { t: depth.max(0.0) / -slant }
        } else if slant > LEAST_SLANT {
            let ahead = (error - depth) / slant;
            Self::Within { origin: here + direction * ahead, ahead }
        } else {
            Self::Within { origin: offset_origin(here, -outwards, error - depth), ahead: 0.0 }
        }
    }
}

/// The index of the probability that `u` falls into, and the place of `u` within it, 0 to 1.
fn chosen(chances: [f32; 3], mut u: f32) -> (usize, f32) {
    for (i, chance) in chances.into_iter().enumerate() {
        if u < chance {
            return (i, u / chance);
        }
        u -= chance;
    }
    // Rounding leaves a number beyond the last: the likeliest takes it.
    let most = (0..3).max_by(|&a, &b| chances[a].total_cmp(&chances[b])).unwrap_or(0);
    (most, 0.5)
}

/// The ways in which a stretch may have been sampled: by the medium, guided outwards, and guided to the far side.
struct Ways {
    /// Weight of each way: its probability, times the density of its direction over that of the phase function.
    weights: [f32; 3],
    /// The cosine to the way out over the diffusion length: guided outwards, distances are sampled by the extinction less this part, and
    /// to the far side by as much more.
    longer: f32,
    taken: usize,
}

impl Ways {
    /// The medium's own sampling alone.
    const STRAIGHT: Self = Self { weights: [1.0, 0.0, 0.0], longer: 0.0, taken: 0 };

    /// The extinctions by which they sample distances, over the medium's.
    fn stretches(&self) -> [f32; 3] {
        [1.0, 1.0 - self.longer, 1.0 + self.longer]
    }

    /// The probability density of a stretch by channel, over that of its direction by the phase function: per unit of length, or, where a
    /// surface ends the stretch, the probability of reaching it. The balance heuristic of all ways. `left` is the transmittance of the
    /// stretch.
    fn density(&self, extinction: Rgb, length: f32, is_hit: bool, left: Rgb) -> Rgb {
        let [a, b, c] = self.weights;
        let sum = if self.longer == 0.0 {
            Rgb::splat(a + b + c)
        } else {
            let [_, s, t] = if is_hit { [1.0; 3] } else { self.stretches() };
            // A channel that goes no distance has an extinction beyond all bounds: 0 times infinity would be NaN for all of them.
            let most = Rgb::splat(MOST_EXPONENT);
            let more = (extinction * (length * self.longer)).clamp(-most, most).exp();
            a + more * (b * s) + Rgb::splat(c * t) / more
        };
        sum * if is_hit { left } else { left * extinction }
    }
}

/// The guiding of a walk towards the surface.
struct Guide {
    outwards: Vec3A,
    start: Vec3A,
    /// Diffusion length of the medium, in free paths; above 1.
    diffusion_length: f32,
    /// ln((diffusion length + 1) / (diffusion length - 1)).
    log: f32,
    /// Extinction of the channel that guides, per Blender unit.
    extinction: f32,
    /// Probability of a guided direction.
    share: f32,
    /// The depth below the start in which a stretch straight on hits the body's other side, Blender units.
    far_side: Option<f32>,
}

impl Guide {
    fn new(medium: &Medium, outwards: Vec3A, start: Vec3A) -> Self {
        // Of the channel that is scattered most: the guide of a darker one would leave fireflies in the others.
        let channel = medium.albedo.max_position();
        let albedo = medium.albedo[channel];
        // d'Eon and Křivánek 2020, equation 67.
        let exponent = 2.442_94 - 0.021_581_3 * albedo + 0.578_637 / albedo;
        let diffusion_length = 1.0 / (1.0 - albedo.powf(exponent)).sqrt();
        // Light that goes mostly on or back is not known by the diffusion: it is guided less.
        let share = (1.0 - medium.anisotropy.abs().powf(0.125)).min(0.75);
        Self {
            outwards,
            start,
            diffusion_length,
            log: (2.0 / (diffusion_length - 1.0)).ln_1p(),
            extinction: medium.extinction[channel],
            share: if diffusion_length > 1.0 + 1e-5 { share } else { 0.0 },
            far_side: None,
        }
    }

    /// The probability density of a guided direction at that cosine to the way out, per steradian (Meng, Hanika and Dachsbacher 2016,
    /// equation 9).
    fn density(&self, cos: f32) -> f32 {
        1.0 / (TAU * (self.diffusion_length - cos) * self.log)
    }

    /// Probabilities of the ways to sample a direction at `place`: by the phase function, guided outwards, and guided to the far side.
    fn shares(&self, place: Vec3A) -> [f32; 3] {
        let to_far_side = self.far_side.map_or(0.0, |depth| {
            let here = self.outwards.dot(self.start - place).clamp(0.0, depth.max(0.0));
            1.0 / (1.0 + ((depth - 2.0 * here) * self.extinction / self.diffusion_length).exp())
        });
        [1.0 - self.share, self.share * (1.0 - to_far_side), self.share * to_far_side]
    }

    /// [`Ways::weights`] of a direction after that of `ray`, whose cosine to the way out is `out`.
    fn weights(&self, shares: [f32; 3], phase: PhaseLobe, ray: &Ray, direction: Vec3A, out: f32) -> [f32; 3] {
        let by_phase = phase.density(ray.direction.dot(direction).clamp(-1.0, 1.0));
        let [a, b, c] = shares;
        [a, b * self.density(out) / by_phase, c * self.density(-out) / by_phase]
    }

    /// A direction after a scattering at the origin of `ray`, and the ways in which it may have been sampled.
    fn turn(&self, medium: &Medium, ray: &Ray, [u_way, u0, u1]: [f32; 3]) -> (Vec3A, Ways) {
        let phase = PhaseLobe::henyey_greenstein(medium.anisotropy);
        let shares = self.shares(ray.origin);
        let (taken, _) = chosen(shares, u_way);
        // Meng, Hanika and Dachsbacher 2016, equation 10.
        let guided = || self.diffusion_length - (self.diffusion_length + 1.0) * (-u0 * self.log).exp();
        let (axis, cos) = match taken {
            0 => (ray.direction, phase.sample(u0)),
            1 => (self.outwards, guided().clamp(-1.0, 1.0)),
            _ => (-self.outwards, guided().clamp(-1.0, 1.0)),
        };
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (s, c) = (TAU * u1).sin_cos();
        let direction = warp::to_world(&warp::frame(axis), Vec3A::new(sin * c, sin * s, cos)).normalize();
        if self.share == 0.0 {
            return (direction, Ways::STRAIGHT);
        }
        let out = self.outwards.dot(direction).clamp(-1.0, 1.0);
        let weights = self.weights(shares, phase, ray, direction, out);
        (direction, Ways { weights, longer: out / self.diffusion_length, taken })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneBuilder;
    use crate::scene::material::Material;
    use crate::scene::mesh::MeshDescription;
    use crate::scene::visibility::Rays;
    use glam::{DMat4, DVec3, Vec3};
    use petzval_testkit::{half_space, sampling};

    fn medium(albedo: f32, anisotropy: f32) -> Medium {
        Medium { extinction: Rgb::new(2.0, 3.0, 5.0), albedo: Rgb::splat(albedo), anisotropy }
    }

    fn guide(medium: &Medium, far_side: Option<f32>) -> Guide {
        Guide { far_side, ..Guide::new(medium, Vec3A::Z, Vec3A::ZERO) }
    }

    /// Directions follow the density of the ways in which they may have been sampled.
    #[test]
    fn directions_follow_their_density() {
        for albedo in [0.2, 0.5, 0.8, 0.99, 0.999_999] {
            for (anisotropy, far_side) in [(0.0, None), (0.0, Some(0.7)), (0.6, Some(0.7)), (-0.3, None)] {
                let medium = medium(albedo, anisotropy);
                let guide = guide(&medium, far_side);
                let ray = Ray::new(Vec3A::new(0.0, 0.0, -0.5), Vec3A::new(0.6, 0.0, -0.8));
                let phase = PhaseLobe::henyey_greenstein(anisotropy);
                sampling::directions(
                    &format!("walk of albedo {albedo}, anisotropy {anisotropy}, far side {far_side:?}"),
                    1 << 17,
                    |random| Some(guide.turn(&medium, &ray, random.numbers()).0.to_array()),
                    |direction| {
                        let direction = Vec3A::from_array(direction);
                        let weights = guide.weights(guide.shares(ray.origin), phase, &ray, direction, direction.z);
                        (weights.iter().sum::<f32>() * phase.density(ray.direction.dot(direction))).into()
                    },
                );
            }
        }
    }

    /// A body gives back the same light however short its free paths are: also as short as places are known, and shorter.
    #[test]
    fn light_of_short_free_paths_comes_back() {
        const ALBEDO: f32 = 0.8;
        let mut builder = SceneBuilder::new();
        let material = builder.add_material(Material::diffuse("body", Rgb::ONE, Rgb::ZERO));
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let square = MeshDescription {
            name: "square".into(),
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        };
        let mesh = builder.add_mesh(square).unwrap();
        let matrix = DMat4::from_translation(DVec3::new(12.0, -7.0, 3.0)) * DMat4::from_rotation_x(0.3);
        builder.add_instance("square", mesh, matrix, &[material], true, true).unwrap();
        let stage = PreparedScene::new(builder.build(DVec3::ZERO));
        let normal = matrix.transform_vector3(DVec3::Z).as_vec3a();
        let middle = Vec3A::new(12.0, -7.0, 3.0) + matrix.transform_vector3(DVec3::new(0.1, 0.2, 0.0)).as_vec3a();
        let hit = stage.accel.closest(&Ray::new(middle + normal, -normal), Rays::CAMERA).expect("the square");
        let point = SurfacePoint::new(&stage.scene, &hit, -normal);
        let truth = half_space::reflectance(ALBEDO.into());
        for free_path in [1e-2, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6, 1e-8] {
            let medium =
                Medium { extinction: Rgb::splat(1.0 / free_path), albedo: Rgb::splat(ALBEDO), anisotropy: 0.0 };
            let mut number = 0;
            let back = |random: &mut sampling::Random| {
                let [seed, ..]: [f32; 3] = random.numbers();
                number += 1;
                let mut sampler = PathSampler::new(number, seed.to_bits(), 0, 1);
                let found = walk(&stage, &point, (-normal, Rgb::ONE, medium), &mut sampler, &mut 0);
                found.map_or(0.0, |(_, light)| f64::from(light.x))
            };
            // Where free paths are about as short as places are known, some stretches along the surface begin below it.
            sampling::mean_is(&format!("free path {free_path}"), 1 << 15, back, truth, 4e-3 * truth);
        }
    }

    /// A channel whose light does not go into the body leaves the others as they are.
    #[test]
    fn a_channel_of_no_depth_does_no_harm() {
        let medium = Medium { extinction: Rgb::new(2.0, 3.0, 1e16), ..medium(0.9, 0.0) };
        let guide = guide(&medium, None);
        let ray = Ray::new(Vec3A::new(0.0, 0.0, -0.2), Vec3A::new(0.0, 0.6, -0.8));
        for i in 0..100 {
            let u = i as f32 / 100.0;
            let (_, ways) = guide.turn(&medium, &ray, [u, 1.0 - u, 0.4]);
            for is_hit in [false, true] {
                let density = ways.density(medium.extinction, 0.5, is_hit, (medium.extinction * -0.5).exp());
                assert!(density.is_finite() && density.x > 0.0 && density.z == 0.0, "{density}");
            }
        }
    }

    /// Stretches that end in the medium before a surface, and those that reach it, are all of them.
    #[test]
    fn lengths_follow_their_density() {
        const STEPS: u32 = 4000;
        let medium = medium(0.9, 0.0);
        let guide = guide(&medium, Some(0.7));
        let ray = Ray::new(Vec3A::new(0.0, 0.0, -0.2), Vec3A::new(0.0, 0.6, -0.8));
        for u in [0.05, 0.3, 0.6, 0.95] {
            let (_, ways) = guide.turn(&medium, &ray, [u, u, 0.4]);
            let weight: f32 = ways.weights.iter().sum();
            let reach = 1.5;
            let left = |length: f32| (medium.extinction * -length).exp();
            let step = reach / STEPS as f32;
            let within: Rgb = (0..STEPS)
                .map(|i| (i as f32 + 0.5) * step)
                .map(|length| ways.density(medium.extinction, length, false, left(length)) * step)
                .fold(Rgb::ZERO, |sum, part| sum + part);
            let all = (within + ways.density(medium.extinction, reach, true, left(reach))) / weight;
            assert!((all - Rgb::ONE).abs().max_element() < 1e-3, "{u}: {all}");
        }
    }
}
