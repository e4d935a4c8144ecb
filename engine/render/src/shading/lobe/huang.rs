//! Hair of Huang, Hullin and Hanika 2022 ("A Microfacet-based Hair Scattering Model", Computer Graphics Forum 41(4)): a fibre of glass, round
//! or elliptical, whose scales are facets of GGX. Light is mirrored, passes straight through, or is mirrored once inside; all longer ways are taken
//! together, as Chiang et al. 2016 do. Numbers and limits are those of Cycles (`bsdf_principled_hair_huang.h`).
//!
//! No sum in closed form says how much light goes from one direction to another: it is integrated across the fibre by Simpson's rule, with a
//! random facet at each place for the ways through. So a direction has no density either. Samples carry their weight, and count in multiple
//! importance sampling with [`Huang::PDF`], as in Cycles.
//!
//! Directions here are (along the major axis, along the fibre, along the minor axis); of a round fibre the last is towards the viewer. Angles
//! about the fibre are from the minor axis. Places of the cross-section are by their eccentric angle g: (sin g, aspect cos g) in major
//! semi-axes.

use super::hair::{across, along_fibre, exp};
use crate::sampler::hashed::HashedNumbers;
use crate::sampler::warp;
use crate::shading::microfacet::{Ggx, reflect, refract};
use crate::shading::{energy, fresnel};
use crate::{Rgb, average};
use glam::{Vec2, Vec3A};
use std::f32::consts::{PI, TAU};

/// The properties of a fibre with rough scales.
#[derive(Clone, Copy, Debug)]
pub(in crate::shading) struct RoughFibre {
    /// Absorption along a radius, by channel.
    pub(in crate::shading) sigma: Rgb,
    /// Width of the facets' distribution, GGX's alpha.
    pub(in crate::shading) alpha: f32,
    pub(in crate::shading) ior: f32,
    /// Tilt of the scales, radians.
    pub(in crate::shading) tilt: f32,
    /// Factors on light that is mirrored, that passes straight through, and that is mirrored once inside.
    pub(in crate::shading) parts: [f32; 3],
    /// The place across the width where the fibre is hit, -1 to 1 in major semi-axes.
    pub(in crate::shading) offset: f32,
    /// Half the width of a pixel over the major semi-axis; where that is not less than the half width seen, the whole width is seen at once.
    pub(in crate::shading) coverage: f32,
    /// Minor axis over major axis.
    pub(in crate::shading) aspect: f32,
}

/// A fibre seen from one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Huang {
    fibre: RoughFibre,
    wo: Vec3A,
    /// Half of the width that is seen, major semi-axes.
    radius: f32,
}

/// Places across a fibre for Simpson's rule.
struct Places {
    first: f32,
    step: f32,
    intervals: u32,
}

impl Places {
    /// Places between two angles, no farther apart than `most`.
    fn between([low, high]: [f32; 2], most: f32) -> Self {
        let intervals = 2 * (0.5 * (high - low) / most).ceil().max(1.0) as u32;
        Self { first: low, step: (high - low) / intervals as f32, intervals }
    }

    /// Angles, and their weights in the integral.
    fn weighted(&self) -> impl Iterator<Item = (f32, f32)> + '_ {
        (0..=self.intervals).map(|i| {
            let is_end = i == 0 || i == self.intervals;
            let weight = if is_end { 0.5 } else { (1 + i % 2) as f32 };
            (self.first + i as f32 * self.step, weight * self.step * (2.0 / 3.0))
        })
    }
}

/// The way of light into a fibre and to the far side.
struct Inside {
    /// The direction of the refracted ray.
    way: Vec3A,
    /// The angle of its direction about the fibre, and the eccentric angle of the scale that it meets, less half a turn.
    turn: f32,
    far: f32,
    /// The normal of that scale, on the side of the ray.
    scale: Vec3A,
    /// The part of light that is not absorbed on the way.
    left: Rgb,
}

impl Huang {
    /// The density that directions count with in multiple importance sampling.
    pub(super) const PDF: f32 = 1.0;
    /// Angle about the fibre that is left out at either end of what is seen.
    const MARGIN_RAD: f32 = 1e-3;
    /// The smallest rest of a geometric series' ratio.
    const LEAST: f32 = 1e-5;

    /// `wo` in the fibre's frame: z along it, y along the major axis; of a round one x is across it on the viewer's side.
    pub(super) fn new(fibre: &RoughFibre, wo: Vec3A) -> Self {
        let (alpha, wo) = (fibre.alpha.clamp(1e-3, 1.0), to_section(wo));
        let across2 = (wo.x * wo.x + wo.z * wo.z).max(f32::MIN_POSITIVE);
        let is_round = fibre.aspect == 1.0;
        let radius =
            if is_round { 1.0 } else { (1.0 - squared_eccentricity(fibre.aspect) * wo.x * wo.x / across2).sqrt() };
        let offset = fibre.offset.clamp(-radius, radius);
        Self { fibre: RoughFibre { alpha, offset, tilt: -fibre.tilt, ..*fibre }, wo, radius }
    }

    fn is_round(&self) -> bool {
        self.fibre.aspect == 1.0
    }

    /// The eccentric angle of what is seen at a place across the half width, -1 to 1.
    fn eccentric(&self, place: f32) -> f32 {
        let aspect = self.fibre.aspect;
        if self.is_round() { -place.asin() } else { self.wo.z.atan2(-aspect * self.wo.x) - (-place).acos() }
    }

    /// The normal of the smooth fibre at an eccentric angle.
    fn normal(&self, angle: f32) -> Vec3A {
        tilted(squeezed(angle, self.fibre.aspect), 0.0)
    }

    /// The length of the outline by eccentric angle, major semi-axes.
    fn arc(&self, angle: f32) -> f32 {
        if self.is_round() {
            return 1.0;
        }
        let sin = angle.sin();
        (1.0 - squared_eccentricity(self.fibre.aspect) * sin * sin).max(0.0).sqrt()
    }

    /// The distance of two places of the outline, major semi-axes.
    fn chord(&self, from: f32, to: f32) -> f32 {
        let place = |angle: f32| Vec2::new(angle.sin(), self.fibre.aspect * angle.cos());
        place(from).distance(place(to))
    }

    /// Makes the facets' distribution at least so wide.
    pub(super) fn widen(&mut self, alpha: f32) {
        self.fibre.alpha = self.fibre.alpha.max(alpha);
    }

    /// Albedo of the fibre, about: that of smooth scales.
    pub(super) fn albedo(&self) -> Rgb {
        let RoughFibre { sigma, ior, offset, aspect, .. } = self.fibre;
        let angle = self.eccentric((offset / self.radius).clamp(-1.0, 1.0));
        let normal = self.normal(angle);
        let Some(way) = refract(self.wo, normal, ior) else { return Rgb::ONE };
        let mirrored = fresnel::dielectric(normal.dot(self.wo).abs(), ior);
        let far = 2.0 * squeezed(way.x.atan2(way.z), aspect) - angle;
        let left = exp(-sigma * (self.chord(angle, far + PI) / cosine(way).max(1e-6)));
        (left - 2.0 * mirrored * left + mirrored) / (Rgb::ONE - mirrored * left).max(Rgb::splat(Self::LEAST))
    }

    /// True if a pixel sees a part of the fibre's width alone.
    fn is_near(&self) -> bool {
        self.fibre.coverage < self.radius
    }

    /// Value times cosine; `wi` in the frame of [`Self::new`].
    pub(super) fn evaluate(&self, wi: Vec3A) -> Rgb {
        let (wo, wi) = (self.wo, to_section(wi));
        let slope = self.fibre.tilt.tan();
        if slope * tangent(wi) < -1.0 {
            return Rgb::ZERO;
        }
        let edge = (-slope * tangent(wo)).max(0.0);
        if edge > 1.0 {
            return Rgb::ZERO;
        }
        let mut seen = self.seen(edge.acos());
        let mut width = 2.0 * self.radius;
        if self.is_near() {
            // Of the scales those that the pixel sees (Yan, Jensen and Ramamoorthi 2017, "An Efficient and Practical Near and Far Field
            // Fur Reflectance Model").
            let RoughFibre { offset, coverage, .. } = self.fibre;
            let [low, high] = [(offset - coverage).max(-self.radius), (offset + coverage).min(self.radius)];
            width = high - low;
            let near = rising([high, low].map(|place| self.eccentric(place / self.radius)));
            // Both ranges in one turn.
            let turns = ((seen[0] + seen[1] - near[0] - near[1]) / (2.0 * TAU)).round() * TAU;
            seen = [seen[0].max(near[0] + turns), seen[1].min(near[1] + turns)];
        }
        if seen[1] <= seen[0] || width <= 0.0 {
            return Rgb::ZERO;
        }
        let light = Rgb::splat(self.mirrored(wi, seen)) + self.through(wi, seen);
        let value = light / (cosine(wo) * width);
        if value.is_finite() { value } else { Rgb::ZERO }
    }

    /// The eccentric angles of the scales whose normals are within an angle of the view, but for a margin.
    fn seen(&self, half: f32) -> [f32; 2] {
        let aspect = self.fibre.aspect;
        let view = if self.is_round() { 0.0 } else { self.wo.x.atan2(self.wo.z) };
        let [low, high] = rising([view - half, view + half].map(|angle| stretched(angle, aspect)));
        [low + Self::MARGIN_RAD, high - Self::MARGIN_RAD]
    }

    /// The integral of light that scales mirror.
    fn mirrored(&self, wi: Vec3A, seen: [f32; 2]) -> f32 {
        let RoughFibre { alpha, ior, parts, .. } = self.fibre;
        let wo = self.wo;
        let Some(facet) = (wo + wi).try_normalize() else { return 0.0 };
        if parts[0] <= 0.0 {
            return 0.0;
        }
        let light = |(angle, weight): (f32, f32)| {
            let scale = self.scale(angle);
            let is_seen = see([wo, wi], self.normal(angle), facet);
            let [from, to] = [wo, wi].map(|w| w.dot(scale));
            if !is_seen {
                return 0.0;
            }
            let masking = 1.0 / (1.0 + lambda(alpha, from) + lambda(alpha, to));
            weight * density(alpha, facet.dot(scale)) * masking * self.restored(from, ior) * self.arc(angle)
        };
        let sum: f32 = Places::between(seen, 0.7 * alpha).weighted().map(light).sum();
        0.25 * parts[0] * fresnel::dielectric(wo.dot(facet), ior) * sum
    }

    /// The integral of light that goes through the fibre, mirrored inside or not.
    fn through(&self, wi: Vec3A, seen: [f32; 2]) -> Rgb {
        let RoughFibre { alpha, ior, parts, .. } = self.fibre;
        let wo = self.wo;
        let [_, straight, inner] = parts;
        if straight <= 0.0 && inner <= 0.0 {
            return Rgb::ZERO;
        }
        let mut numbers = HashedNumbers::new(wi.to_array());
        let index = 1.0 / ior;
        let (mut bent, mut rest) = (Rgb::ZERO, Rgb::ZERO);
        for (angle, weight) in Places::between(seen, 0.8 * alpha).weighted() {
            let scale = self.scale(angle);
            let facet = self.facet(wo, scale, [numbers.next(), numbers.next()]);
            let from = wo.dot(scale);
            if wo.dot(facet) <= 0.0 {
                continue;
            }
            let mirrored = fresnel::dielectric(wo.dot(facet), ior);
            let Some(inside) = self.inside(facet, angle) else { continue };
            let back = -inside.way;
            // The facet is one of its scale's, and of the fibre's own side.
            if !(see([wo, back], scale, facet) && see([wo, back], self.normal(angle), facet)) {
                continue;
            }
            let below = back.dot(scale);
            let entered = weight * (1.0 - mirrored) * self.restored(from, ior) * gone(alpha, from, below);
            let there = back.dot(inside.scale);
            let into = from / below;
            let restored = self.restored(there, index);
            if straight > 0.0
                && let Some(out) = self.out(back, inside.scale, wi, None)
            {
                bent += inside.left * (straight * entered * into * restored * out * self.arc(inside.far));
            }
            if inner <= 0.0 {
                continue;
            }
            let (once, longer) = self.turned_back(&inside, angle, wi, entered * restored, &mut numbers);
            bent += once * (inner * into);
            rest += longer;
        }
        let about = along_fibre(wo.y * wi.y, cosine(wo) * cosine(wi), 4.0 * alpha) / TAU;
        bent * (index * index) + rest * about
    }

    /// The light towards `wi` that is mirrored once inside, and that of all longer ways, of the light `entered` with which a ray arrives inside.
    fn turned_back(
        &self,
        inside: &Inside,
        angle: f32,
        wi: Vec3A,
        entered: f32,
        numbers: &mut HashedNumbers,
    ) -> (Rgb, Rgb) {
        let RoughFibre { alpha, ior, .. } = self.fibre;
        let (index, back) = (1.0 / ior, -inside.way);
        let there = back.dot(inside.scale);
        let mirror = self.facet(back, inside.scale, [numbers.next(), numbers.next()]);
        if back.dot(mirror) <= 0.0 {
            return (Rgb::ZERO, Rgb::ZERO);
        }
        let mirrored = fresnel::dielectric(back.dot(mirror), index);
        let again = reflect(inside.way, mirror);
        let (last, last_angle, left_again) = self.last_scale(inside, again, angle);
        let left = inside.left * left_again;
        let carried = left * (entered * mirrored * self.restored(again.dot(last), index));
        let to = -again.dot(inside.scale);
        let mut longer = Rgb::ZERO;
        if there > 0.0 && again.dot(last) > 0.0 && back.dot(self.normal(inside.far)) > 0.0 {
            let facet = self.facet(again, last, [numbers.next(), numbers.next()]);
            // By its place across the width.
            let share = self.wo.dot(self.normal(angle)) * self.arc(angle) * gone(alpha, there, to);
            longer = self.longer(carried, left, (again, last, facet), mirrored) * share;
        }
        let is_seen = see([back, -again], inside.scale, mirror) && see([back, -again], self.normal(inside.far), mirror);
        let out = is_seen.then(|| self.out(again, last, wi, Some(last_angle))).flatten().unwrap_or(0.0);
        // Where nothing comes out the cosine may be 0.
        let passed = gone(alpha, there, to) * there / to * self.arc(last_angle);
        let once = if out > 0.0 { carried * (passed * out) } else { Rgb::ZERO };
        (once, longer)
    }

    /// The light of the ways with more than one mirroring inside, a geometric series of about the same losses each, of light `carried` to the last
    /// scale, which it reaches from the direction `again`. `left`: what is not absorbed on both ways across the fibre.
    fn longer(&self, carried: Rgb, left: Rgb, (again, last, facet): (Vec3A, Vec3A, Vec3A), mirrored: f32) -> Rgb {
        let RoughFibre { alpha, ior, .. } = self.fibre;
        let kept = fresnel::dielectric(again.dot(facet), 1.0 / ior);
        let mean = Rgb::from(left.to_array().map(f32::sqrt));
        let passed = (0.5 * (2.0 - mirrored - kept)).max(Self::LEAST);
        let others = mean * passed / (Rgb::ONE - mean * (1.0 - passed));
        let turned = reflect(again, facet).dot(last);
        carried * others * (kept * gone(alpha, again.dot(last), turned))
    }

    /// A sampled direction, and value over density; `None` where light ends. `u_choice` chooses the way, `u` the place across the fibre and
    /// the facet.
    pub(super) fn sample(&self, u_choice: f32, u: [f32; 2]) -> Option<(Vec3A, Rgb)> {
        let RoughFibre { alpha, ior, parts, offset, .. } = self.fibre;
        let wo = self.wo;
        let mut numbers = HashedNumbers::new([u_choice, u[0], u[1]]);
        let angle = self.eccentric(if self.is_near() { offset / self.radius } else { 2.0 * u[0] - 1.0 });
        let (scale, normal) = (self.scale(angle), self.normal(angle));
        let from = wo.dot(scale);
        if from < 0.0 || wo.dot(normal) < 0.0 {
            return None;
        }
        let facet = self.facet(wo, scale, [u[1], numbers.next()]);
        if !(wo.dot(facet) > 0.0 && wo.dot(normal) > 0.0) {
            return None;
        }
        let restored = self.restored(from, ior);
        let mirrored = fresnel::dielectric(wo.dot(facet), ior);
        let first = reflect(wo, facet);
        let is_seen = first.dot(facet) > 0.0 && first.dot(normal) > 0.0;
        let amount = if is_seen { parts[0] * mirrored * restored * gone(alpha, from, first.dot(scale)) } else { 0.0 };
        let mut ways = [(Vec3A::ZERO, Rgb::ZERO); 4];
        ways[0] = (first, Rgb::splat(amount));
        if let Some(inside) = self.inside(facet, angle) {
            let entered = (1.0 - mirrored) * restored * gone(alpha, from, inside.way.dot(scale));
            let back = -inside.way;
            if back.dot(facet) > 0.0 && back.dot(normal) > 0.0 {
                self.sample_inside(&inside, angle, entered, &mut numbers, &mut ways);
            }
        }
        let amounts = ways.map(|(_, amount)| if amount.is_finite() { average(amount) } else { 0.0 });
        let total: f32 = amounts.iter().sum();
        if total <= 0.0 {
            return None;
        }
        let (mut way, mut left) = (0, u_choice * total);
        while way + 1 < ways.len() && left >= amounts[way] {
            left -= amounts[way];
            way += 1;
        }
        let (direction, amount) = ways[way];
        (amounts[way] > 0.0).then(|| (from_section(direction), amount / amounts[way] * total))
    }

    /// Samples the ways through the fibre, of the light `entered` with which a ray arrives inside: straight, mirrored once, and longer.
    fn sample_inside(
        &self,
        inside: &Inside,
        angle: f32,
        entered: f32,
        numbers: &mut HashedNumbers,
        ways: &mut [(Vec3A, Rgb); 4],
    ) {
        let RoughFibre { alpha, ior, parts, .. } = self.fibre;
        let (index, back) = (1.0 / ior, -inside.way);
        let there = back.dot(inside.scale);
        let mirror = self.facet(back, inside.scale, [numbers.next(), numbers.next()]);
        if !(there > 0.0 && see([back], self.normal(inside.far), mirror)) {
            return;
        }
        let mirrored = fresnel::dielectric(back.dot(mirror), index);
        let entered = entered * self.restored(there, index);
        if let Some(out) = refract(back, mirror, index)
            && -out.dot(inside.scale) > 0.0
            && see([-out], self.normal(inside.far), mirror)
        {
            let amount = parts[1] * entered * (1.0 - mirrored) * gone(alpha, there, out.dot(inside.scale));
            ways[1] = (out, inside.left * amount);
        }
        let again = reflect(inside.way, mirror);
        let (last, last_angle, left_again) = self.last_scale(inside, again, angle);
        let at_last = again.dot(last);
        if at_last <= 0.0 {
            return;
        }
        let left = inside.left * left_again;
        let passed = gone(alpha, there, -again.dot(inside.scale));
        let carried = left * (entered * mirrored * self.restored(at_last, index) * passed);
        let facet = self.facet(again, last, [numbers.next(), numbers.next()]);
        if let Some(out) = refract(again, facet, index)
            && see([again, -out], self.normal(last_angle), facet)
        {
            let through = 1.0 - fresnel::dielectric(again.dot(facet), index);
            ways[2] = (out, carried * (parts[2] * through * gone(alpha, at_last, out.dot(last))));
        }
        let along = [numbers.next(), numbers.next(), numbers.next()];
        ways[3] = (self.anywhere(along), self.longer(carried, left, (again, last, facet), mirrored));
    }

    /// A direction of the ways that are taken together: spread along the fibre, even about it.
    fn anywhere(&self, [u0, u1, u2]: [f32; 3]) -> Vec3A {
        let RoughFibre { alpha, .. } = self.fibre;
        let u = u0.max(1e-5);
        let toward = 1.0 + 4.0 * alpha * (u + (1.0 - u) * (-0.5 / alpha).exp()).ln();
        let sin = -toward * self.wo.y + across(toward) * (TAU * u1).cos() * cosine(self.wo);
        let (s, c) = (TAU * u2).sin_cos();
        Vec3A::new(s * across(sin), sin, c * across(sin))
    }

    /// The normal of the scale at an eccentric angle, on which light falls from without.
    fn scale(&self, angle: f32) -> Vec3A {
        tilted(squeezed(angle, self.fibre.aspect), self.fibre.tilt)
    }

    /// The normal of the scale opposite an eccentric angle, on which light falls from within.
    fn inner_scale(&self, angle: f32) -> Vec3A {
        tilted(squeezed(angle, self.fibre.aspect), -self.fibre.tilt)
    }

    /// A facet that is seen from a direction, of those about a scale.
    fn facet(&self, seen_from: Vec3A, scale: Vec3A, u: [f32; 2]) -> Vec3A {
        let frame = warp::frame(scale);
        warp::to_world(&frame, Ggx::of_width(self.fibre.alpha).sample_visible(warp::to_local(&frame, seen_from), u))
    }

    /// Light through a facet to the far side; `None` where it is all mirrored.
    fn inside(&self, facet: Vec3A, angle: f32) -> Option<Inside> {
        let RoughFibre { sigma, ior, aspect, .. } = self.fibre;
        let way = refract(self.wo, facet, ior)?;
        let turn = way.x.atan2(way.z);
        // An ellipse is a circle that was squeezed, and a ray in it with it.
        let far = 2.0 * squeezed(turn, aspect) - angle;
        let length = if self.is_round() { -2.0 * (angle - turn).cos() } else { self.chord(angle, far + PI) };
        let left = exp(-sigma * (length / cosine(way).max(1e-6)));
        Some(Inside { way, turn, far, scale: self.inner_scale(far), left })
    }

    /// The scale at which a ray arrives that was mirrored inside, the scale's angle, and the part of light that is not absorbed on the way.
    fn last_scale(&self, inside: &Inside, again: Vec3A, angle: f32) -> (Vec3A, f32, Rgb) {
        let RoughFibre { sigma, aspect, .. } = self.fibre;
        let turn = again.x.atan2(again.z);
        let last = angle - 2.0 * (squeezed(inside.turn, aspect) - squeezed(turn, aspect)) + PI;
        let length = if self.is_round() { 2.0 * (turn - inside.far).cos().abs() } else { self.chord(last, inside.far) };
        let left = exp(-sigma * (length / cosine(again).max(1e-6)));
        (self.inner_scale(last), last, left)
    }

    /// The factor on light out of the fibre along `wi` by facets of a scale that it hits from within, from the direction `back`. With `angle`, that
    /// of the scale, facets must be seen from both sides; `None` where no facet bends light there.
    fn out(&self, back: Vec3A, scale: Vec3A, wi: Vec3A, angle: Option<f32>) -> Option<f32> {
        let RoughFibre { alpha, ior, .. } = self.fibre;
        let index = 1.0 / ior;
        // Beyond that no facet bends it there.
        if wi.dot(-back) < index - 1e-5 {
            return None;
        }
        let half = back + index * wi;
        let length = half.length();
        let facet = half / length;
        let normal = facet.dot(scale);
        let is_seen = normal >= 0.0
            && angle.is_none_or(|angle| see([back, -wi], scale, facet) && see([back, -wi], self.normal(angle), facet));
        if !is_seen {
            return None;
        }
        let [from, to] = [back.dot(facet), -wi.dot(facet)];
        let masking = 1.0 / (1.0 + lambda(alpha, back.dot(scale)) + lambda(alpha, -wi.dot(scale)));
        let passed = 1.0 - fresnel::dielectric(from, index);
        let light = passed * density(alpha, normal) * masking * from * to / (length * length);
        light.is_finite().then_some(light)
    }

    /// Factor on single scattering at a boundary that adds the light that goes on from facet to facet.
    fn restored(&self, cos: f32, index: f32) -> f32 {
        1.0 / energy::boundary(index, self.fibre.alpha.sqrt(), cos.max(0.0)).0.max(1e-3)
    }
}

/// A direction of the fibre's frame as this file has it.
fn to_section(w: Vec3A) -> Vec3A {
    Vec3A::new(w.y, w.z, w.x)
}

fn from_section(w: Vec3A) -> Vec3A {
    Vec3A::new(w.z, w.x, w.y)
}

/// The cosine of the angle to the plane across the fibre.
fn cosine(w: Vec3A) -> f32 {
    (w.x * w.x + w.z * w.z).sqrt()
}

/// The tangent of the angle to the plane across the fibre.
fn tangent(w: Vec3A) -> f32 {
    w.y / cosine(w)
}

/// 1 less the square of the aspect.
fn squared_eccentricity(aspect: f32) -> f32 {
    1.0 - aspect * aspect
}

/// The angle of a direction when the plane is squeezed along the major axis; of an ellipse's eccentric angle that of its normal.
fn squeezed(angle: f32, aspect: f32) -> f32 {
    if aspect == 1.0 {
        return angle;
    }
    let (sin, cos) = angle.sin_cos();
    (aspect * sin).atan2(cos)
}

/// The inverse of [`squeezed`].
fn stretched(angle: f32, aspect: f32) -> f32 {
    if aspect == 1.0 {
        return angle;
    }
    let (sin, cos) = angle.sin_cos();
    sin.atan2(aspect * cos)
}

/// A range of angles, of which the last is not below the first.
fn rising([first, last]: [f32; 2]) -> [f32; 2] {
    [first, if last < first { last + TAU } else { last }]
}

/// The direction at an angle about the fibre, tilted along it.
fn tilted(angle: f32, tilt: f32) -> Vec3A {
    let ((s, c), (along, across)) = (angle.sin_cos(), tilt.sin_cos());
    Vec3A::new(s * across, along, c * across)
}

/// True if a facet and the normal that it is about are seen from all directions.
fn see<const N: usize>(from: [Vec3A; N], normal: Vec3A, facet: Vec3A) -> bool {
    from.iter().all(|w| w.dot(facet) > 0.0 && w.dot(normal) > 0.0)
}

/// Density of GGX's facets at that cosine to the normal that they are about.
fn density(alpha: f32, cos: f32) -> f32 {
    let (a2, cos2) = (alpha * alpha, cos * cos);
    let t = (1.0 - cos2) + a2 * cos2;
    a2 / (PI * t * t)
}

/// Smith's lambda at that cosine.
fn lambda(alpha: f32, cos: f32) -> f32 {
    let cos2 = cos * cos;
    0.5 * ((1.0 + alpha * alpha * (1.0 - cos2).max(0.0) / cos2).sqrt() - 1.0)
}

/// The part of light seen from one direction that facets do not hide towards another.
fn gone(alpha: f32, from: f32, to: f32) -> f32 {
    let (from, to) = (lambda(alpha, from), lambda(alpha, to));
    (1.0 + from) / (1.0 + from + to)
}

#[cfg(test)]
mod tests;
