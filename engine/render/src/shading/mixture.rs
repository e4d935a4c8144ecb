//! The closures of a point of a surface together: one is chosen to go on by, in proportion to about the light that it scatters, and
//! all that could have chosen the same direction share the weight (the balance heuristic), as in Cycles.

use super::albedo::give_back;
use super::energy;
use super::fresnel::{self, F82Tint};
use super::lobe::{Fresnel, Lobe, LobeDirection, Slopes};
use super::parted::MeanSums;
use super::subsurface::{Body, Entry};
use super::thin_film::RelativeFilm;
use super::{BsdfSample, Caustics, Features, LobeDecomposition, LobeShares, Past, Scattering, SurfaceMeans};
use crate::Rgb;
use crate::scene::closure::{Closure, Distribution, MetalKind, ThinFilm};
use crate::scene::visibility::Rays;
use crate::surface::{Strand, SurfacePoint};
use arrayvec::ArrayVec;
use glam::{Quat, Vec3A};

/// Lobes that a mixture may have; further ones are left out.
const MOST_LOBES: usize = 32;
/// Closures that count less are left out.
const LEAST: f32 = 1e-5;

/// The BSDF of one point seen from one direction.
pub struct Mixture {
    lobes: ArrayVec<Lobe, MOST_LOBES>,
    /// True if light may go into bodies; else they are diffuse.
    pub(super) walks: bool,
    /// True if a diffuse scattering lies between the camera and here: profiles of bodies are not told from diffuse then.
    is_blurred: bool,
    pub(super) here: Here,
    strand: Option<(Strand, Option<Vec3A>)>,
    /// Width of the pixel at a point that the camera sees, Blender units; else 0.
    pub(super) pixel_width: f32,
    /// True if a lobe does not know the density of its directions.
    has_estimates: bool,
}

/// The point of a mixture, and its view.
#[derive(Clone, Copy)]
pub(super) struct Here {
    pub(super) wo: Vec3A,
    /// The triangle's normal, on the side of `wo`.
    pub(super) geometric_normal: Vec3A,
    /// The interpolated normal, on the triangle's side.
    pub(super) smooth_normal: Vec3A,
    pub(super) backfacing: bool,
    /// The direction along which facets are stretched.
    tangent: Vec3A,
    /// The normal of coats.
    pub(super) coat_normal: Vec3A,
    pub(super) caustics: Caustics,
    /// Bent normals are corrected.
    corrects_bumps: bool,
}

impl Mixture {
    /// Memory for mixtures, one after the other, each made by [`begin`](Self::begin): some 7 KB, too much to be moved for each place.
    pub fn empty() -> Self {
        let here = Here {
            wo: Vec3A::Z,
            geometric_normal: Vec3A::Z,
            smooth_normal: Vec3A::Z,
            backfacing: false,
            tangent: Vec3A::ZERO,
            coat_normal: Vec3A::Z,
            caustics: Caustics::ALL,
            corrects_bumps: true,
        };
        let (lobes, strand) = (ArrayVec::new(), None);
        Self { lobes, walks: false, is_blurred: false, here, strand, pixel_width: 0.0, has_estimates: false }
    }

    /// Begins a mixture without closures at a point; `wo` is the unit direction back along the path, stretched facets lie along
    /// `tangent`, and light `walks` through bodies or leaves them where it enters.
    pub fn begin(&mut self, point: &SurfacePoint, wo: Vec3A, tangent: Vec3A, walks: bool) {
        self.lobes.clear();
        self.here = Here {
            wo,
            geometric_normal: point.geometric_normal,
            smooth_normal: point.shading_normal,
            backfacing: point.backfacing,
            tangent,
            coat_normal: point.shading_normal,
            caustics: Caustics::ALL,
            corrects_bumps: true,
        };
        (self.walks, self.is_blurred, self.strand) = (walks, false, None);
        (self.pixel_width, self.has_estimates) = (0.0, false);
    }

    /// A mixture without closures at a point, as [`begin`](Self::begin) makes it.
    pub fn new(point: &SurfacePoint, wo: Vec3A, tangent: Vec3A, walks: bool) -> Self {
        let mut mixture = Self::empty();
        mixture.begin(point, wo, tangent, walks);
        mixture
    }

    /// Sets the path's past, for closures that are added from now on.
    pub fn set_past(&mut self, past: Past) {
        (self.here.caustics, self.is_blurred) = (past.caustics, past.is_blurred);
        self.pixel_width = past.pixel_width;
    }

    /// Sets whether bent normals are corrected, for closures that are added from now on.
    pub fn correct_bumps(&mut self, corrects_bumps: bool) {
        self.here.corrects_bumps = corrects_bumps;
    }

    /// Sets the normal of coats, and the direction of stretched facets, for closures that are added from now on.
    pub fn set_directions(&mut self, coat_normal: Vec3A, tangent: Vec3A) {
        (self.here.coat_normal, self.here.tangent) = (coat_normal, tangent);
    }

    /// Sets the strand, for closures of hair that are added from now on, and their own tangent if they have one.
    pub fn set_strand(&mut self, strand: Strand, tangent: Option<Vec3A>) {
        self.strand = Some((strand, tangent));
    }

    /// The strand and its tangent, as [`Self::set_strand`] has set them.
    pub(super) fn strand(&self) -> Option<(Strand, Option<Vec3A>)> {
        self.strand
    }

    /// Adds a closure about a normal. Transparency and emission are not scattering: they add nothing.
    #[expect(clippy::too_many_lines, reason = "an arm for each closure")]
    pub fn add(&mut self, weight: f32, closure: &Closure<Rgb, f32>, normal: Vec3A) {
        let (here, wo) = (self.here, self.here.wo);
        let tinted = |color: &Rgb| color.max(Rgb::ZERO) * weight;
        let Caustics { reflective, refractive } = here.caustics;
        match closure {
            Closure::Glossy { .. } | Closure::Metal { .. } | Closure::Toon { glossy: true, .. } if !reflective => {}
            Closure::Refraction { .. } if !refractive => {}
            Closure::Glass { .. } if !reflective && !refractive => {}
            Closure::Diffuse { color, roughness } => {
                self.push(Lobe::oren_nayar(tinted(color), *color, *roughness, normal, wo));
            }
            Closure::Translucent { color } => {
                self.push(Lobe::translucent(tinted(color), here.reflecting(normal), wo));
            }
            Closure::Glossy { color, roughness, anisotropy, rotation, distribution } => {
                let alpha = stretched_either_way(*roughness, *anisotropy);
                let normal = here.reflecting(normal);
                let frame = here.frame(normal, *rotation);
                let weight = tinted(color);
                match distribution {
                    Distribution::AshikhminShirley => {
                        self.push(Lobe::ashikhmin_shirley(weight, alpha, frame, wo));
                    }
                    _ => {
                        let restored = here.restored(alpha, normal, *distribution, || *color);
                        self.push(here.facets(
                            weight * restored,
                            Rgb::ONE,
                            alpha,
                            *distribution,
                            Fresnel::Mirror,
                            frame,
                        ));
                    }
                }
            }
            Closure::Metal { base, edge, kind, roughness, anisotropy, rotation, distribution, film } => {
                let (fresnel, average) = metal(*kind, *base, *edge, film);
                let alpha = stretched(*roughness, *anisotropy);
                let normal = here.reflecting(normal);
                let restored = here.restored(alpha, normal, *distribution, || average);
                let albedo = fresnel.at(normal.dot(wo), 1.0).0;
                let frame = here.frame(normal, *rotation);
                self.push(here.facets(restored * weight, albedo, alpha, *distribution, fresnel, frame));
            }
            Closure::Glass { color, roughness, ior, distribution, film } => {
                let color = color.max(Rgb::ZERO);
                let f0 = Rgb::splat(fresnel::f0_from_ior(*ior));
                let boundary =
                    Boundary { f0, ior: *ior, roughness: *roughness, distribution: *distribution, film: *film };
                self.push(here.glass(weight, here.caustic([color; 2]), &boundary, normal));
            }
            Closure::Refraction { color, roughness, ior, distribution } => {
                let alpha = [roughness * roughness; 2];
                let frame = here.frame(here.reflecting(normal), 0.0);
                let eta = here.relative_index(*ior);
                let slopes = slopes(alpha, *distribution);
                self.push(Lobe::facets(tinted(color), Rgb::ONE, slopes, Fresnel::Through, eta, frame, wo));
            }
            Closure::Microfiber { color, roughness } => {
                if let Some(lobe) = Lobe::microfiber(tinted(color), *roughness, normal, wo) {
                    self.push(lobe);
                }
            }
            Closure::Velvet { color, sigma } => self.push(Lobe::velvet(tinted(color), *sigma, normal, wo)),
            Closure::Toon { color, size, smooth, glossy } => {
                self.push(Lobe::toon(tinted(color), *size, *smooth, *glossy, normal, wo));
            }
            Closure::Subsurface { color, radius, scale, ior, roughness, anisotropy, method } => {
                let color = color.clamp(Rgb::ZERO, Rgb::ONE);
                let radius = radius.max(Rgb::ZERO) * *scale;
                let body = Body::new(color, radius, *ior, roughness.clamp(0.0, 1.0), *anisotropy, *method);
                self.add_body(color * weight, body, normal);
            }
            Closure::Hair { color, roughness_along, roughness_about, offset, through } => {
                let roughness = [*roughness_along, *roughness_about];
                self.add_hair(tinted(color), roughness, *offset, *through);
            }
            Closure::PrincipledHair(hair) => self.add_principled_hair(weight, hair),
            Closure::Principled(principled) => self.add_principled(weight, principled, normal),
            Closure::Transparent { .. } | Closure::Holdout | Closure::Emission { .. } => {}
        }
    }

    /// A lobe of light that comes out elsewhere; where it has no way to go it is diffuse.
    pub(super) fn add_body(&mut self, weight: Rgb, body: Option<Body>, normal: Vec3A) {
        let wo = self.here.wo;
        let body = body.filter(|body| self.walks && !(body.is_profile() && self.is_blurred));
        let inside = body.map_or(Rgb::ZERO, |body| body.channels);
        if let Some(body) = body {
            self.push(Lobe::body(weight * inside, body, self.here.reflecting(normal), wo));
        }
        let rest = weight * (Rgb::ONE - inside);
        if rest != Rgb::ZERO {
            self.push(Lobe::lambert(rest, normal, wo));
        }
    }

    /// The BSDF at a point where light comes out of a body.
    pub fn exit(point: &SurfacePoint) -> Self {
        let mut mixture = Self::new(point, point.geometric_normal, Vec3A::ZERO, false);
        mixture.push(Lobe::lambert(Rgb::ONE, point.shading_normal, point.geometric_normal));
        mixture
    }

    /// Value and density on one side of the lobes that some kinds of ray reach.
    fn evaluate_on(&self, above: bool, wi: Vec3A, rays: Rays) -> (Rgb, f32) {
        self.lobes.iter().filter(|lobe| rays.any_of(lobe.rays())).fold((Rgb::ZERO, 0.0), |(value, pdf), lobe| {
            let (of_lobe, own) = lobe.evaluate(wi, above, self.here.smooth());
            (value + of_lobe, pdf + lobe.chance * own)
        })
    }

    /// The lobe that the first of two uniform numbers chooses, and the numbers with the rest of the first.
    fn chosen(&self, [u_lobe, u]: [f32; 2]) -> Option<(&Lobe, [f32; 2])> {
        let left = |lobe: &Lobe, below: f32| [((u_lobe - below) / lobe.chance).clamp(0.0, 1.0 - f32::EPSILON), u];
        let mut below = 0.0;
        let last = self.lobes.len().checked_sub(1)?;
        for lobe in &self.lobes[..last] {
            if u_lobe < below + lobe.chance {
                return Some((lobe, left(lobe, below)));
            }
            below += lobe.chance;
        }
        let lobe = &self.lobes[last];
        Some((lobe, left(lobe, below)))
    }

    /// Normalizes the probabilities of the lobes and multiplies their weights by `kept`, once all closures are added.
    pub fn finish(&mut self, kept: f32) {
        let total: f32 = self.lobes.iter().map(|lobe| lobe.chance).sum();
        for lobe in &mut self.lobes {
            lobe.chance /= total;
            lobe.weight *= kept;
        }
    }

    /// Makes lobes with a peak at least so wide, once all are there. Their albedos, and the probabilities of their choice, stay those of
    /// their own width, as in Cycles (`bsdf_blur` in bsdf.h).
    #[cold]
    #[inline(never)]
    pub fn widen(&mut self, alpha: f32) {
        self.lobes.iter_mut().for_each(|lobe| lobe.widen(alpha));
    }

    /// A sampled direction of a lobe among others of which some do not know the densities of their directions: it counts for its lobe alone.
    #[cold]
    #[inline(never)]
    fn sampled_alone(&self, lobe: &Lobe, local: &LobeDirection, wi: Vec3A, above: bool) -> Option<BsdfSample> {
        let smooth = self.here.smooth();
        let weight = match local.estimate {
            Some(estimate) => lobe.weight * estimate / lobe.chance,
            None => {
                let (value, own) = lobe.evaluate(wi, above, smooth);
                value / (lobe.chance * own)
            }
        };
        let pdf = self.lobes.iter().map(|lobe| lobe.chance * lobe.density(wi, above, smooth)).sum();
        let (transmitted, matte) = (local.transmitted, lobe.scatters_evenly());
        weight.is_finite().then_some(BsdfSample { wi, weight, pdf, mirror: false, transmitted, matte })
    }

    pub(super) fn push(&mut self, lobe: Lobe) {
        if lobe.weight.max_element() > LEAST && lobe.chance > 0.0 && lobe.weight.is_finite() {
            self.has_estimates |= lobe.is_estimated();
            // A surface of more lobes than that loses the last.
            let _ = self.lobes.try_push(lobe);
        }
    }
}

impl Here {
    /// The tints of reflection and transmission, black for a kind of caustic that is not wanted.
    pub(super) fn caustic(&self, [reflection, transmission]: [Rgb; 2]) -> [Rgb; 2] {
        let Caustics { reflective, refractive } = self.caustics;
        let of = |tint: Rgb, wanted: bool| if wanted { tint } else { Rgb::ZERO };
        [of(reflection, reflective), of(transmission, refractive)]
    }

    /// A normal under which a mirror does not send light into the surface: raised towards the triangle's own as far as
    /// it must be, where bent normals are corrected.
    pub(super) fn reflecting(&self, normal: Vec3A) -> Vec3A {
        if !self.corrects_bumps {
            return normal;
        }
        super::normal::reflecting(self.geometric_normal, normal, self.wo)
    }

    /// The smooth normal, and whether bumps on it dim the light that grazes it.
    #[inline]
    fn smooth(&self) -> (Vec3A, bool) {
        (self.smooth_normal, self.corrects_bumps)
    }

    /// Axes about a normal, the first along the tangent, turned.
    pub(super) fn frame(&self, normal: Vec3A, turns: f32) -> [Vec3A; 3] {
        let mut tangent = self.tangent;
        if turns != 0.0 {
            let turn = Quat::from_axis_angle(normal.into(), turns * std::f32::consts::TAU);
            tangent = turn * tangent;
        }
        match normal.cross(tangent).try_normalize() {
            Some(y) => [y.cross(normal), y, normal],
            None => crate::sampler::warp::frame(normal),
        }
    }

    /// Index of refraction beyond the surface over that before it.
    pub(super) fn relative_index(&self, ior: f32) -> f32 {
        let ior = ior.max(1e-5);
        if self.backfacing { 1.0 / ior } else { ior }
    }

    /// Factor on single scattering that adds the light that goes on from facet to facet; `average` is the mean reflectance.
    pub(super) fn restored(
        &self,
        alpha: [f32; 2],
        normal: Vec3A,
        distribution: Distribution,
        average: impl FnOnce() -> Rgb,
    ) -> Rgb {
        if distribution != Distribution::MultiscatterGgx {
            return Rgb::ONE;
        }
        restored_seen(&energy::Seen::new(mean_roughness(alpha), normal.dot(self.wo)), average())
    }

    /// Facets that reflect by a law.
    pub(super) fn facets(
        &self,
        weight: Rgb,
        albedo: Rgb,
        alpha: [f32; 2],
        distribution: Distribution,
        fresnel: Fresnel,
        frame: [Vec3A; 3],
    ) -> Lobe {
        Lobe::facets(weight, albedo, slopes(alpha, distribution), fresnel, 1.0, frame, self.wo)
    }

    /// Facets that reflect and refract, tinted by one colour each.
    pub(super) fn glass(
        &self,
        weight: f32,
        [reflection, transmission]: [Rgb; 2],
        boundary: &Boundary,
        normal: Vec3A,
    ) -> Lobe {
        let roughness = boundary.roughness.clamp(0.0, 1.0);
        let normal = self.reflecting(normal);
        let eta = self.relative_index(boundary.ior);
        let mut restored = Rgb::ONE;
        if boundary.distribution == Distribution::MultiscatterGgx && roughness > 0.0 {
            let (kept, average) = energy::boundary(eta, roughness, normal.dot(self.wo));
            // What passes is most of it.
            restored = give_back(transmission, kept, average);
        }
        let index = if self.backfacing { boundary.film.ior / boundary.ior.max(1e-5) } else { boundary.film.ior };
        let film = ThinFilm { ior: index, ..boundary.film };
        let fresnel = dielectric(boundary.f0, [reflection, transmission], eta, &film);
        let (reflected, through) = fresnel.at(normal.dot(self.wo), eta);
        let slopes = slopes([roughness * roughness; 2], boundary.distribution);
        let frame = self.frame(normal, 0.0);
        Lobe::facets(restored * weight, reflected + through, slopes, fresnel, eta, frame, self.wo)
    }
}

/// A rough dielectric that lets light through.
pub(super) struct Boundary {
    /// Reflectance at normal incidence, tinted.
    pub(super) f0: Rgb,
    pub(super) ior: f32,
    pub(super) roughness: f32,
    pub(super) distribution: Distribution,
    pub(super) film: ThinFilm<f32>,
}

/// A dielectric's law; the film's index is relative to the medium above it.
pub(super) fn dielectric(f0: Rgb, [reflection, transmission]: [Rgb; 2], eta: f32, film: &ThinFilm<f32>) -> Fresnel {
    let f0 = f0.min(Rgb::ONE);
    if film.thickness_nm <= RelativeFilm::LEAST_NM {
        return Fresnel::Dielectric { f0, reflection, transmission };
    }
    let film = RelativeFilm::over_dielectric(film.thickness_nm, film.ior, eta);
    Fresnel::FilmedDielectric { film, f0, reflection, transmission }
}

/// A metal's law, and its mean reflectance.
pub(super) fn metal(kind: MetalKind, base: Rgb, edge: Rgb, film: &ThinFilm<f32>) -> (Fresnel, Rgb) {
    let ThinFilm { thickness_nm, ior } = *film;
    let is_filmed = thickness_nm > RelativeFilm::LEAST_NM;
    match kind {
        MetalKind::Tinted => {
            let f0 = base.clamp(Rgb::ZERO, Rgb::ONE);
            let tinted = F82Tint::new(f0, edge);
            let film = || Fresnel::Film(RelativeFilm::over_tinted(thickness_nm, ior, f0, tinted));
            (if is_filmed { film() } else { Fresnel::Tinted(tinted) }, tinted.average())
        }
        MetalKind::Conductor => {
            let film = || Fresnel::Film(RelativeFilm::over_conductor(thickness_nm, ior, base, edge));
            let fresnel = if is_filmed { film() } else { Fresnel::Conductor([base, edge]) };
            (fresnel, fresnel::conductor_average(base, edge))
        }
    }
}

/// The perceptual roughness of round facets that are as wide on the whole.
pub(super) fn mean_roughness(alpha: [f32; 2]) -> f32 {
    (alpha[0].min(1.0) * alpha[1].min(1.0)).sqrt().sqrt()
}

/// [`Here::restored`] of facets with multiple scattering, seen as they are.
pub(super) fn restored_seen(seen: &energy::Seen, average: Rgb) -> Rgb {
    give_back(average, seen.kept, seen.average())
}

/// Widths of Principled's facets and metal's.
pub(super) fn stretched(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let alpha = roughness.clamp(0.0, 1.0).powi(2);
    let aspect = (1.0 - 0.9 * anisotropy.clamp(0.0, 1.0)).sqrt();
    [alpha / aspect, alpha * aspect]
}

/// Widths of the Glossy node's facets.
fn stretched_either_way(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let alpha = roughness.clamp(0.0, 1.0).powi(2);
    let anisotropy = anisotropy.clamp(-0.99, 0.99);
    let narrow = 1.0 - anisotropy.abs();
    if anisotropy < 0.0 { [alpha / narrow, alpha * narrow] } else { [alpha * narrow, alpha / narrow] }
}

pub(super) fn slopes(alpha: [f32; 2], distribution: Distribution) -> Slopes {
    Slopes::new(alpha, distribution)
}

impl LobeDecomposition for Mixture {
    #[cold]
    #[inline(never)]
    fn shares(&self, wi: Vec3A, reaches: Rays, is_beyond: bool) -> LobeShares {
        let Here { geometric_normal, smooth_normal, .. } = self.here;
        let above = if is_beyond { smooth_normal } else { geometric_normal }.dot(wi) > 0.0;
        let mut shares = LobeShares::default();
        for lobe in self.lobes.iter().filter(|lobe| reaches.any_of(lobe.rays())) {
            shares.add(lobe.evaluate(wi, above, self.here.smooth()).0, lobe.rays(), lobe.normal().dot(wi) > 0.0);
        }
        shares
    }

    #[cold]
    #[inline(never)]
    fn albedos(&self) -> [Rgb; 3] {
        let mut sum = LobeShares::default();
        for lobe in &self.lobes {
            let [above, below] = lobe.albedos();
            sum.add(above, lobe.rays(), true);
            sum.add(below, lobe.rays(), false);
        }
        [sum.diffuse, sum.glossy, sum.transmission]
    }

    fn mean_alpha_squared(&self, wi: Vec3A) -> f32 {
        if self.lobes.iter().all(|lobe| lobe.width_squared() == 1.0) {
            return 1.0;
        }
        let Here { geometric_normal, .. } = self.here;
        let above = geometric_normal.dot(wi) > 0.0;
        let (sum, pdf) = self.lobes.iter().fold((0.0, 0.0), |(sum, pdf), lobe| {
            let own = lobe.chance * lobe.evaluate(wi, above, self.here.smooth()).1;
            (sum + own * lobe.width_squared(), pdf + own)
        });
        if pdf > 0.0 { sum / pdf } else { 1.0 }
    }

    #[cold]
    #[inline(never)]
    fn features(&self) -> Features {
        let (mut found, mut broad, mut all) = (Features::default(), 0.0, 0.0);
        for lobe in &self.lobes {
            let albedo = lobe.albedos().into_iter().sum();
            found.add(albedo, lobe.chance, lobe.normal(), lobe.width_squared(), &mut broad);
            all += lobe.chance;
        }
        found.finished(broad, all)
    }

    #[cold]
    #[inline(never)]
    fn means(&self) -> SurfaceMeans {
        let mut sums = MeanSums::default();
        for lobe in &self.lobes {
            sums.add(crate::average(lobe.weight).abs(), lobe.normal(), lobe.roughness());
        }
        sums.means(self.here.smooth_normal)
    }

    #[cold]
    #[inline(never)]
    fn diffuse(&self) -> (Rgb, Vec3A) {
        let is_diffuse = |lobe: &&Lobe| lobe.rays() == Rays::DIFFUSE && !lobe.is_body();
        let (colour, normal) = self.lobes.iter().filter(is_diffuse).fold((Rgb::ZERO, Vec3A::ZERO), |(c, n), lobe| {
            (c + lobe.weight, n + lobe.normal() * lobe.weight.element_sum().abs())
        });
        (colour, normal.normalize_or(self.here.smooth_normal))
    }
}

impl Scattering for Mixture {
    fn receiving_normal(&self) -> Option<Vec3A> {
        let normal = self.lobes.first()?.normal();
        let one = self.lobes.iter().all(|lobe| !lobe.transmits() && lobe.normal() == normal);
        one.then_some(normal)
    }

    fn is_mirror(&self) -> bool {
        self.lobes.iter().all(Lobe::is_mirror)
    }

    fn evaluate(&self, wi: Vec3A) -> (Rgb, f32) {
        let Here { geometric_normal, .. } = self.here;
        let above = geometric_normal.dot(wi) > 0.0;
        let (mut value, mut pdf) = (Rgb::ZERO, 0.0);
        for lobe in &self.lobes {
            let (of_lobe, own) = lobe.evaluate(wi, above, self.here.smooth());
            value += of_lobe;
            pdf += lobe.chance * own;
        }
        (value, pdf)
    }

    #[cold]
    #[inline(never)]
    fn evaluate_some(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32) {
        self.evaluate_on(self.here.geometric_normal.dot(wi) > 0.0, wi, rays)
    }

    #[cold]
    #[inline(never)]
    fn evaluate_smooth(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32) {
        self.evaluate_on(self.here.smooth_normal.dot(wi) > 0.0, wi, rays)
    }

    fn sample(&self, u_split: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let (lobe, u) = self.chosen(u)?;
        let local = lobe.sample(u_split, u)?;
        let transmitted = local.transmitted;
        let wi = lobe.in_world(local.wi);
        let above = self.here.geometric_normal.dot(wi) > 0.0;
        if !lobe.is_hair() && (above == transmitted || (local.wi.z > 0.0) == transmitted) {
            return None;
        }
        if let Some((value, chance)) = local.single {
            let weight = lobe.weight * value / (chance * lobe.chance);
            return weight.is_finite().then_some(BsdfSample {
                wi,
                weight,
                pdf: 0.0,
                mirror: true,
                transmitted,
                matte: false,
            });
        }
        if self.has_estimates {
            return self.sampled_alone(lobe, &local, wi, above);
        }
        let (value, pdf) = self.evaluate(wi);
        let matte = lobe.scatters_evenly();
        let usable = pdf > 0.0 && value.is_finite() && pdf.is_finite();
        usable.then(|| BsdfSample { wi, weight: value / pdf, pdf, mirror: false, transmitted, matte })
    }

    fn enter(&self, u: [f32; 2]) -> Option<Entry> {
        let (lobe, u) = self.chosen(u)?;
        lobe.enter(u)
    }

    fn mirror(&self, transmitted: bool, wi: Vec3A) -> (Rgb, f32) {
        let (mut value, mut chance) = (Rgb::ZERO, 0.0);
        for lobe in &self.lobes {
            if let Some((of_lobe, own)) = lobe.single(transmitted, wi) {
                value += lobe.weight * of_lobe;
                chance += lobe.chance * own;
            }
        }
        (value, chance)
    }

    fn relative_index(&self) -> f32 {
        self.lobes.iter().find_map(Lobe::relative_index).unwrap_or(1.0)
    }

    fn cosine(&self, d: Vec3A) -> f32 {
        self.here.smooth_normal.dot(d).abs()
    }
}

#[cfg(test)]
mod tests;
