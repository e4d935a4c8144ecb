//! Normals that mirrors can be about.

use glam::Vec3A;

/// A unit normal about which `wo` is mirrored to above the triangle: `normal` itself wherever that is
/// so, else turned towards the triangle's own just as far as it must be. Without this the rims of coarse smooth surfaces
/// mirror into themselves, and their light is lost.
#[inline]
pub fn reflecting(geometric: Vec3A, normal: Vec3A, wo: Vec3A) -> Vec3A {
    let along = geometric.dot(wo);
    // A mirrored ray may be as flat as the one that came.
    let least = (0.9 * along).min(0.01);
    if 2.0 * normal.dot(wo) * geometric.dot(normal) - along >= least {
        return normal;
    }
    raised(geometric, normal, wo, along, least)
}

/// The normal raised in the plane of both normals: with the triangle's as z and the angle a of the normal to it, the mirrored ray's height
/// is wo.x sin 2a + wo.z cos 2a.
#[cold]
fn raised(geometric: Vec3A, normal: Vec3A, wo: Vec3A, along: f32, least: f32) -> Vec3A {
    let Some(x) = (normal - geometric * geometric.dot(normal)).try_normalize() else { return geometric };
    let across = x.dot(wo);
    // 2a is the angle of `wo` to z and that whose cosine is the height over the length, together: between -90 and 180 degrees.
    let length = (across * across + along * along).sqrt().max(1e-12);
    let (sin_wo, cos_wo, cos) = (across / length, along / length, (least / length).clamp(-1.0, 1.0));
    let sin = (1.0 - cos * cos).sqrt();
    let (sin_twice, cos_twice) = (sin_wo * cos + cos_wo * sin, cos_wo * cos - sin_wo * sin);
    // Of both halves, the larger by its square: the other has no digits left near 0.
    let larger = (0.5 * (1.0 + cos_twice.abs())).min(1.0).sqrt();
    let smaller = 0.5 * sin_twice.abs() / larger;
    let (sin, cos) = if cos_twice < 0.0 { (larger, smaller) } else { (smaller, larger) };
    x * sin.copysign(sin_twice) + geometric * cos
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::warp::{sample_cosine_hemisphere, sample_sphere};

    /// With any normal, the mirrored ray leaves the triangle on the viewer's side, and a normal that does so stays.
    #[test]
    fn mirrors_send_light_upwards() {
        let (mut kept, mut bent) = (0, 0);
        for i in 0..4096 {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let wo = sample_cosine_hemisphere([u[0], u[1]]);
            let mut normal = sample_sphere([u[2], u[3]]);
            normal.z = normal.z.abs() + 0.01;
            let normal = normal.normalize();
            let found = reflecting(Vec3A::Z, normal, wo);
            assert!((found.length() - 1.0).abs() < 1e-5);
            let mirrored = 2.0 * found.dot(wo) * found - wo;
            // Rounding of the angle.
            assert!(mirrored.z >= (0.9 * wo.z).min(0.01) - 1e-5 && found.dot(wo) > 0.0, "{wo} {normal}: {mirrored}");
            if (2.0 * normal.dot(wo) * normal - wo).z > 0.01 {
                assert_eq!(found, normal);
                kept += 1;
            } else {
                bent += 1;
            }
        }
        assert!(kept > 1000 && bent > 100, "{kept} {bent}");
    }
}
