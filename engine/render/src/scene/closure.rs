//! Closures: the ways in which a surface scatters or emits light, as Blender's shader nodes name them.
//!
//! A closure is generic over how its inputs are given: `C` colours, `N` numbers.

use crate::Rgb;

/// The distribution of the microfacets of a rough surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Distribution {
    /// GGX, each ray meeting one facet.
    Ggx,
    /// GGX with the light that goes on from facet to facet.
    #[default]
    MultiscatterGgx,
    /// Beckmann's, each ray meeting one facet.
    Beckmann,
    /// Ashikhmin and Shirley's. Reflects alone.
    AshikhminShirley,
}

/// The meaning of a metal's two colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MetalKind {
    /// Reflectance at normal incidence, and its tint at 82 degrees.
    #[default]
    Tinted,
    /// Index of refraction and extinction coefficient.
    Conductor,
}

/// The method of subsurface scattering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SubsurfaceMethod {
    /// A random walk whose free path the radius gives.
    #[default]
    RandomWalk,
    /// A random walk whose free path is the radius over 4 π: Blender's up to 5.0, and its *Legacy* since.
    LegacyWalk,
    /// A random walk whose free path depends on the albedo, too.
    Skin,
    /// Light comes out beside the place where it goes in, by Christensen and Burley's profile.
    Burley,
}

impl SubsurfaceMethod {
    /// The method by Blender's name of since 5.1; `None` for others.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "RANDOM_WALK" => Self::RandomWalk,
            "RANDOM_WALK_LEGACY" => Self::LegacyWalk,
            "RANDOM_WALK_SKIN" => Self::Skin,
            "BURLEY" => Self::Burley,
            _ => return None,
        })
    }
}

/// Scattering, emission or transparency.
#[derive(Clone, Copy, Debug, PartialEq)]
// Most layers of a busy material are Principled, and no layer is moved once it stands.
#[allow(clippy::large_enum_variant)]
pub enum Closure<C, N> {
    /// Oren and Nayar's, Lambert's where `roughness` is 0.
    Diffuse {
        /// Albedo by channel.
        color: C,
        /// Roughness, 0 to 1.
        roughness: N,
    },
    /// Lambert's on the far side.
    Translucent {
        /// Albedo by channel.
        color: C,
    },
    /// A mirror of facets without Fresnel's law.
    Glossy {
        /// Colour of the reflection.
        color: C,
        /// Perceptual roughness, 0 to 1: alpha is its square.
        roughness: N,
        /// Anisotropy, -1 to 1, as the Glossy node has it.
        anisotropy: N,
        /// Turns of the tangent.
        rotation: N,
        /// Distribution of the facets.
        distribution: Distribution,
    },
    /// Reflects as a metal does.
    Metal {
        /// Reflectance at normal incidence, or the index of refraction.
        base: C,
        /// Tint near grazing, or the extinction coefficient.
        edge: C,
        /// The meaning of the two colours.
        kind: MetalKind,
        /// Perceptual roughness, 0 to 1: alpha is its square.
        roughness: N,
        /// Anisotropy, 0 to 1, as Principled has it.
        anisotropy: N,
        /// Turns of the tangent.
        rotation: N,
        /// Distribution of the facets.
        distribution: Distribution,
        /// Thin film over the metal.
        film: ThinFilm<N>,
    },
    /// Reflects and refracts by Fresnel's law.
    Glass {
        /// Tint of reflected and of refracted light.
        color: C,
        /// Perceptual roughness, 0 to 1: alpha is its square.
        roughness: N,
        /// Index of refraction of the inside, relative to the outside.
        ior: N,
        /// Distribution of the facets.
        distribution: Distribution,
        /// Thin film over the glass.
        film: ThinFilm<N>,
    },
    /// Refracts all that is not totally reflected, and reflects nothing.
    Refraction {
        /// Tint of the refracted light.
        color: C,
        /// Perceptual roughness, 0 to 1: alpha is its square.
        roughness: N,
        /// Index of refraction of the inside, relative to the outside.
        ior: N,
        /// Distribution of the facets.
        distribution: Distribution,
    },
    /// Lets light through unbent.
    Transparent {
        /// Transmittance by channel.
        color: C,
    },
    /// A hole in the picture.
    Holdout,
    /// Light that the surface gives out.
    Emission {
        /// Colour of the emission, by channel.
        color: C,
        /// Radiance is colour times this.
        strength: N,
    },
    /// Cloth, by transformed cosines (Zeltner, Burley and Chiang 2022).
    Microfiber {
        /// Tint of the cloth.
        color: C,
        /// Roughness, 0 to 1.
        roughness: N,
    },
    /// Cloth, by Ashikhmin's distribution.
    Velvet {
        /// Tint of the cloth.
        color: C,
        /// Spread of the fibres.
        sigma: N,
    },
    /// A disk of light as in drawings, about the normal or about the mirrored ray.
    Toon {
        /// Tint of the disk.
        color: C,
        /// Size, 0 to 1: of a right angle.
        size: N,
        /// Width of the smooth transition behind `size`.
        smooth: N,
        /// True if the disk is about the mirrored ray.
        glossy: bool,
    },
    /// Light that goes into the body and comes out elsewhere.
    Subsurface {
        /// Albedo by channel, 0 to 1.
        color: C,
        /// Distance that the light goes, by channel, times `scale`.
        radius: C,
        /// Factor of `radius`, Blender units.
        scale: N,
        /// Index of refraction where the light enters.
        ior: N,
        /// Perceptual roughness where the light enters.
        roughness: N,
        /// Anisotropy of the scattering: backwards at -1, forwards at 1.
        anisotropy: N,
        /// Method of the walk.
        method: SubsurfaceMethod,
    },
    /// Mirrored by a fibre, or come through it.
    Hair {
        /// Tint.
        color: C,
        /// Roughness along the fibre, 0 to 1.
        roughness_along: N,
        /// Roughness about the fibre, 0 to 1.
        roughness_about: N,
        /// Radians by which the mirrored cone is tilted.
        offset: N,
        /// True for light that comes through, false for mirrored light.
        through: bool,
    },
    /// Blender's Principled Hair BSDF.
    PrincipledHair(PrincipledHair<C, N>),
    /// Blender's Principled BSDF with all its sockets.
    Principled(Principled<C, N>),
}

/// The source of hair's colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pigment {
    /// Absorption by channel along a radius.
    Absorption,
    /// Melanin, and a dye.
    Melanin,
    /// The colour that a lot of such hair has.
    #[default]
    Color,
}

/// The model of Principled Hair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HairModel {
    /// Chiang et al. 2016: lobes about the fibre.
    #[default]
    Chiang,
    /// Huang et al. 2022: facets on a fibre, round or elliptical.
    Huang,
}

/// Blender's Principled Hair BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledHair<C, N> {
    /// The model of scattering.
    pub model: HairModel,
    /// The source of the colour.
    pub pigment: Pigment,
    /// The colour, the dye or the absorption.
    pub color: C,
    /// Amount of melanin, 0 to 1.
    pub melanin: N,
    /// The share of red, 0 to 1.
    pub melanin_redness: N,
    /// Roughness along the fibre, 0 to 1.
    pub roughness: N,
    /// Roughness about the fibre, 0 to 1; Chiang's.
    pub radial_roughness: N,
    /// The part of the roughness that mirrored light is spared, 0 to 1; Chiang's.
    pub coat: N,
    /// Factor on light that is mirrored; Huang's.
    pub reflection: N,
    /// Factor on light that passes straight through; Huang's.
    pub transmission: N,
    /// Factor on light that is mirrored inside; Huang's.
    pub secondary_reflection: N,
    /// The minor axis of the cross-section over the major one, or the other way round; Huang's.
    pub aspect: N,
    /// Index of refraction of the fibre.
    pub ior: N,
    /// Radians by which the fibre's scales are tilted.
    pub offset: N,
    /// Variation of melanin from strand to strand.
    pub random_color: N,
    /// Variation of roughness from strand to strand.
    pub random_roughness: N,
    /// The strand's number, 0 to 1.
    pub random: N,
}

/// A film on a surface, so thin that it colours the reflected light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm<N> {
    /// Thickness, nanometres; no film at 0.
    pub thickness_nm: N,
    /// Index of refraction of the film.
    pub ior: N,
}

/// Blender's Principled BSDF (4.x and 5.x).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled<C, N> {
    /// Albedo of the diffuse base and of metal; its square root tints transmission.
    pub base_color: C,
    /// 0 dielectric to 1 metal.
    pub metallic: N,
    /// Perceptual roughness, 0 to 1: alpha is its square.
    pub roughness: N,
    /// Index of refraction of the dielectric.
    pub ior: N,
    /// 0 lets everything through unbent.
    pub alpha: N,
    /// Roughness of the diffuse base.
    pub diffuse_roughness: N,
    /// The part of the base whose light goes into the body.
    pub subsurface_weight: N,
    /// Distance of subsurface scattering by channel, times the scale.
    pub subsurface_radius: C,
    /// Factor of `subsurface_radius`, Blender units.
    pub subsurface_scale: N,
    /// Index of refraction where it enters skin; else it is Principled's own.
    pub subsurface_ior: N,
    /// Anisotropy of the scattering: backwards at -1, forwards at 1.
    pub subsurface_anisotropy: N,
    /// Method of the subsurface walk.
    pub subsurface_method: SubsurfaceMethod,
    /// 0.5 leaves the reflection that the index gives.
    pub specular_ior_level: N,
    /// Tint of reflections at normal incidence (dielectric), near grazing (metal).
    pub specular_tint: C,
    /// Anisotropy, 0 to 1.
    pub anisotropic: N,
    /// Turns of the tangent.
    pub anisotropic_rotation: N,
    /// 0 opaque to 1 glass.
    pub transmission: N,
    /// Weight of the clear coat.
    pub coat_weight: N,
    /// Perceptual roughness of the coat.
    pub coat_roughness: N,
    /// Index of refraction of the coat.
    pub coat_ior: N,
    /// Transmittance of the coat.
    pub coat_tint: C,
    /// Weight of the cloth over all.
    pub sheen_weight: N,
    /// Roughness of the cloth, 0 to 1.
    pub sheen_roughness: N,
    /// Tint of the cloth.
    pub sheen_tint: C,
    /// Colour of the emission, by channel.
    pub emission_color: C,
    /// Emitted radiance is colour times this.
    pub emission_strength: N,
    /// Thin film over metal, glass and the dielectric.
    pub film: ThinFilm<N>,
    /// True if light goes on from facet to facet.
    pub multiscatter: bool,
}

impl Default for Principled<Rgb, f32> {
    /// Blender's Principled BSDF as a new node has it.
    fn default() -> Self {
        Self {
            base_color: Rgb::splat(0.8),
            metallic: 0.0,
            roughness: 0.5,
            ior: 1.5,
            alpha: 1.0,
            diffuse_roughness: 0.0,
            subsurface_weight: 0.0,
            subsurface_radius: Rgb::new(1.0, 0.2, 0.1),
            subsurface_scale: 0.05,
            subsurface_ior: 1.4,
            subsurface_anisotropy: 0.0,
            subsurface_method: SubsurfaceMethod::RandomWalk,
            specular_ior_level: 0.5,
            specular_tint: Rgb::ONE,
            anisotropic: 0.0,
            anisotropic_rotation: 0.0,
            transmission: 0.0,
            coat_weight: 0.0,
            coat_roughness: 0.03,
            coat_ior: 1.5,
            coat_tint: Rgb::ONE,
            sheen_weight: 0.0,
            sheen_roughness: 0.5,
            sheen_tint: Rgb::ONE,
            emission_color: Rgb::ONE,
            emission_strength: 0.0,
            film: ThinFilm { thickness_nm: 0.0, ior: 1.33 },
            multiscatter: true,
        }
    }
}

impl<N> ThinFilm<N> {
    fn map<M>(&self, n: &mut impl FnMut(&N) -> M) -> ThinFilm<M> {
        ThinFilm { thickness_nm: n(&self.thickness_nm), ior: n(&self.ior) }
    }
}

impl<C, N> Closure<C, N> {
    /// The colour of the closure, about its albedo; `None` where it has none.
    pub fn tint(&self) -> Option<&C> {
        match self {
            Self::Principled(p) => Some(&p.base_color),
            Self::Diffuse { color, .. }
            | Self::Translucent { color }
            | Self::Glossy { color, .. }
            | Self::Glass { color, .. }
            | Self::Refraction { color, .. }
            | Self::Microfiber { color, .. }
            | Self::Velvet { color, .. }
            | Self::Toon { color, .. }
            | Self::Subsurface { color, .. }
            | Self::Hair { color, .. } => Some(color),
            Self::Metal { .. }
            | Self::PrincipledHair(_)
            | Self::Holdout
            | Self::Transparent { .. }
            | Self::Emission { .. } => None,
        }
    }

    /// This closure with its inputs converted: colours by `c`, numbers by `n`.
    #[expect(clippy::too_many_lines, reason = "an arm for each closure")]
    pub fn map<D, M>(&self, mut c: impl FnMut(&C) -> D, mut n: impl FnMut(&N) -> M) -> Closure<D, M> {
        match self {
            Self::Diffuse { color, roughness } => Closure::Diffuse { color: c(color), roughness: n(roughness) },
            Self::Translucent { color } => Closure::Translucent { color: c(color) },
            Self::Glossy { color, roughness, anisotropy, rotation, distribution } => Closure::Glossy {
                color: c(color),
                roughness: n(roughness),
                anisotropy: n(anisotropy),
                rotation: n(rotation),
                distribution: *distribution,
            },
            Self::Metal { base, edge, kind, roughness, anisotropy, rotation, distribution, film } => Closure::Metal {
                base: c(base),
                edge: c(edge),
                kind: *kind,
                roughness: n(roughness),
                anisotropy: n(anisotropy),
                rotation: n(rotation),
                distribution: *distribution,
                film: film.map(&mut n),
            },
            Self::Glass { color, roughness, ior, distribution, film } => Closure::Glass {
                color: c(color),
                roughness: n(roughness),
                ior: n(ior),
                distribution: *distribution,
                film: film.map(&mut n),
            },
            Self::Refraction { color, roughness, ior, distribution } => Closure::Refraction {
                color: c(color),
                roughness: n(roughness),
                ior: n(ior),
                distribution: *distribution,
            },
            Self::Transparent { color } => Closure::Transparent { color: c(color) },
            Self::Holdout => Closure::Holdout,
            Self::Emission { color, strength } => Closure::Emission { color: c(color), strength: n(strength) },
            Self::Microfiber { color, roughness } => Closure::Microfiber { color: c(color), roughness: n(roughness) },
            Self::Velvet { color, sigma } => Closure::Velvet { color: c(color), sigma: n(sigma) },
            Self::Toon { color, size, smooth, glossy } => {
                Closure::Toon { color: c(color), size: n(size), smooth: n(smooth), glossy: *glossy }
            }
            Self::Subsurface { color, radius, scale, ior, roughness, anisotropy, method } => Closure::Subsurface {
                color: c(color),
                radius: c(radius),
                scale: n(scale),
                ior: n(ior),
                roughness: n(roughness),
                anisotropy: n(anisotropy),
                method: *method,
            },
            Self::Hair { color, roughness_along, roughness_about, offset, through } => Closure::Hair {
                color: c(color),
                roughness_along: n(roughness_along),
                roughness_about: n(roughness_about),
                offset: n(offset),
                through: *through,
            },
            Self::PrincipledHair(hair) => Closure::PrincipledHair(PrincipledHair {
                model: hair.model,
                pigment: hair.pigment,
                color: c(&hair.color),
                melanin: n(&hair.melanin),
                melanin_redness: n(&hair.melanin_redness),
                roughness: n(&hair.roughness),
                radial_roughness: n(&hair.radial_roughness),
                coat: n(&hair.coat),
                reflection: n(&hair.reflection),
                transmission: n(&hair.transmission),
                secondary_reflection: n(&hair.secondary_reflection),
                aspect: n(&hair.aspect),
                ior: n(&hair.ior),
                offset: n(&hair.offset),
                random_color: n(&hair.random_color),
                random_roughness: n(&hair.random_roughness),
                random: n(&hair.random),
            }),
            Self::Principled(p) => Closure::Principled(p.map(&mut c, &mut n)),
        }
    }
}

impl<C> Closure<C, f32> {
    /// True if the closure is one of hair, which needs the strand.
    pub fn is_hair(&self) -> bool {
        matches!(self, Self::Hair { .. } | Self::PrincipledHair(_))
    }

    /// True if the closure's facets are stretched along the surface's tangent.
    pub fn is_brushed(&self) -> bool {
        match self {
            Self::Glossy { anisotropy, .. } | Self::Metal { anisotropy, .. } => *anisotropy != 0.0,
            Self::Principled(p) => p.anisotropic != 0.0,
            _ => false,
        }
    }
}

impl<C, N> Principled<C, N> {
    fn map<D, M>(&self, c: &mut impl FnMut(&C) -> D, n: &mut impl FnMut(&N) -> M) -> Principled<D, M> {
        Principled {
            base_color: c(&self.base_color),
            metallic: n(&self.metallic),
            roughness: n(&self.roughness),
            ior: n(&self.ior),
            alpha: n(&self.alpha),
            diffuse_roughness: n(&self.diffuse_roughness),
            subsurface_weight: n(&self.subsurface_weight),
            subsurface_radius: c(&self.subsurface_radius),
            subsurface_scale: n(&self.subsurface_scale),
            subsurface_ior: n(&self.subsurface_ior),
            subsurface_anisotropy: n(&self.subsurface_anisotropy),
            subsurface_method: self.subsurface_method,
            specular_ior_level: n(&self.specular_ior_level),
            specular_tint: c(&self.specular_tint),
            anisotropic: n(&self.anisotropic),
            anisotropic_rotation: n(&self.anisotropic_rotation),
            transmission: n(&self.transmission),
            coat_weight: n(&self.coat_weight),
            coat_roughness: n(&self.coat_roughness),
            coat_ior: n(&self.coat_ior),
            coat_tint: c(&self.coat_tint),
            sheen_weight: n(&self.sheen_weight),
            sheen_roughness: n(&self.sheen_roughness),
            sheen_tint: c(&self.sheen_tint),
            emission_color: c(&self.emission_color),
            emission_strength: n(&self.emission_strength),
            film: self.film.map(n),
            multiscatter: self.multiscatter,
        }
    }
}
