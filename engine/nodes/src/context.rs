//! The data of surfaces and images that a program reads. The renderer implements both traits.

use crate::choice::choices;
use crate::lanes::{LANES, Vectors};
use glam::{Vec2, Vec3A, Vec4};
use wide::f32x8;

/// The place at which a program is evaluated: the point, or a place beside it by a share of the footprint along its two axes. Bump runs the
/// program of its height at three such places.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// Share of the footprint along dP/dx.
    pub x: f32,
    /// Share of the footprint along dP/dy.
    pub y: f32,
}

impl Shift {
    /// No shift: the point itself.
    pub const NONE: Self = Self { x: 0.0, y: 0.0 };
}

choices! {
    /// A field of a point. A number stands in all three parts; a truth is 1 or 0.
    #[expect(missing_docs, reason = "named after Blender's outputs")]
    pub Field {
        Position = "position",
        /// The shading normal, towards the viewer.
        Normal = "normal",
        /// The flat normal, towards the viewer.
        TrueNormal = "true_normal",
        /// The normal as the mesh has it, in object space: not turned to the viewer, between vertices not of length 1.
        MeshNormal = "mesh_normal",
        /// The direction from the point to the viewer.
        Incoming = "incoming",
        Parametric = "parametric",
        Backfacing = "backfacing",
        Pointiness = "pointiness",
        RandomPerIsland = "random_per_island",
        /// 0 to 1 through the undeformed mesh's bounds; for a world, the direction, as are position and object.
        Generated = "generated",
        Object = "object",
        /// The place in the camera's space; z grows away from the camera.
        Camera = "camera",
        /// The place on the picture, from 0 to 1 both ways.
        Window = "window",
        /// The mirrored direction to the viewer.
        Reflection = "reflection",
        InstancerGenerated = "instancer_generated",
        InstancerUv = "instancer_uv",
        /// Distance of the nearest side of the triangle, world units.
        EdgeDistance = "edge_distance",
        /// Width of a pixel there as the camera sees the surface, world units.
        PixelWidth = "pixel_width",
        /// The footprint's axes, world units.
        FootprintX = "footprint_x",
        FootprintY = "footprint_y",
        ObjectLocation = "object_location",
        ObjectColour = "object_colour",
        ObjectAlpha = "object_alpha",
        ObjectIndex = "object_index",
        MaterialIndex = "material_index",
        ObjectRandom = "object_random",
        ParticleIndex = "particle_index",
        ParticleRandom = "particle_random",
        ParticleAge = "particle_age",
        ParticleLifetime = "particle_lifetime",
        ParticleLocation = "particle_location",
        ParticleSize = "particle_size",
        ParticleVelocity = "particle_velocity",
        ParticleAngularVelocity = "particle_angular_velocity",
        IsStrand = "is_strand",
        StrandIntercept = "strand_intercept",
        StrandLength = "strand_length",
        StrandThickness = "strand_thickness",
        StrandNormal = "strand_normal",
        StrandRandom = "strand_random",
        /// The axis of a strand's cross-section, of length 1; a strand is oriented by attributes that Blender makes.
        StrandAxis = "strand_axis",
        /// The place of the hit across the strand's width, -1 to 1.
        StrandOffset = "strand_offset",
        PointPosition = "point_position",
        PointRadius = "point_radius",
        PointRandom = "point_random",
        IsCameraRay = "is_camera_ray",
        IsShadowRay = "is_shadow_ray",
        IsDiffuseRay = "is_diffuse_ray",
        IsGlossyRay = "is_glossy_ray",
        IsSingularRay = "is_singular_ray",
        IsReflectionRay = "is_reflection_ray",
        IsTransmissionRay = "is_transmission_ray",
        IsVolumeScatterRay = "is_volume_scatter_ray",
        /// The distance from the ray's origin; for a camera, from its clip start.
        RayLength = "ray_length",
        RayDepth = "ray_depth",
        DiffuseDepth = "diffuse_depth",
        GlossyDepth = "glossy_depth",
        TransparentDepth = "transparent_depth",
        TransmissionDepth = "transmission_depth",
        PortalDepth = "portal_depth",
        /// The direction from the camera to the point in the camera's space, of length 1; z grows away from the camera.
        ViewVector = "view_vector",
        ViewDepth = "view_depth",
        ViewDistance = "view_distance",
        VolumeColour = "volume_colour",
        VolumeDensity = "volume_density",
        VolumeFlame = "volume_flame",
        VolumeTemperature = "volume_temperature",
    }
}

choices! {
    /// A space that vectors are given in. In the camera's, z grows away from the camera.
    #[expect(missing_docs, reason = "named after Blender's")]
    pub Space { World = "WORLD", Object = "OBJECT", Camera = "CAMERA" }
}

choices! {
    /// The kind of a vector that changes space.
    #[expect(missing_docs, reason = "named after Blender's")]
    pub Direction { Point = "POINT", Vector = "VECTOR", Normal = "NORMAL" }
}

/// The kind of an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttributeKind {
    /// A UV map; without a name, the one for rendering.
    Uv,
    /// A colour attribute; without a name, the one for rendering.
    Colour,
    /// The tangent of a UV map, in object space; the fourth part is the sign of the third axis.
    Tangent,
    /// Anything of the mesh.
    Geometry,
    /// A property of the object.
    Object,
    /// A property of the instancer of the object.
    Instancer,
    /// A property of the view layer or scene.
    ViewLayer,
}

/// An attribute that a program reads. The renderer looks it up once for each mesh, by its place in the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// The kind of the attribute.
    pub kind: AttributeKind,
    /// Name of the attribute in Blender.
    pub name: String,
}

/// The settings of Ambient Occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occlusion {
    /// Number of rays that look for occluders.
    pub samples: u8,
    /// True if the occlusion looks into the surface, not away from it.
    pub inside: bool,
    /// True if only the object itself occludes.
    pub only_local: bool,
}

/// The settings of Raycast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raycast {
    /// True if only the object itself is hit.
    pub only_local: bool,
    /// The attribute that is asked for of the hit surface, by its index in [`Program::attributes`](crate::Program::attributes).
    pub attribute: Option<u16>,
}

/// The answer to a [`Raycast`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// True if something is hit.
    pub is_hit: bool,
    /// True if that is the object itself.
    pub is_self: bool,
    /// Distance of the hit, in lengths of the ray's direction.
    pub distance: f32,
    /// Place of the hit, world space.
    pub position: Vec3A,
    /// Shading normal there, on the side of the ray.
    pub normal: Vec3A,
    /// The attribute that was asked for.
    pub attribute: Vec4,
}

/// Declares the fields that a kind of point answers, each beside its answer, as the arms of a `match`: it writes `answer`, and `knows`, which
/// is true of the fields that stand here. The last arm names further kinds of points, which are asked for the rest.
///
/// ```
/// use glam::Vec3A;
/// use petzval_nodes::{Field, answers};
///
/// struct Ray(f32);
///
/// impl Ray {
///     answers! {
///         fn answer(&self, field: Field) -> Vec3A {
///             match field {
///                 RayLength => Vec3A::splat(self.0),
///                 IsCameraRay | IsShadowRay => Vec3A::ZERO,
///                 _ => [],
///             }
///         }
///     }
/// }
///
/// assert!(Ray::knows(Field::RayLength) && !Ray::knows(Field::Position));
/// assert_eq!(Ray(2.0).answer(Field::RayLength), Some(Vec3A::splat(2.0)));
/// ```
#[macro_export]
macro_rules! answers {
    (
        $(#[$about:meta])*
        $visibility:vis fn answer($($argument:tt)*) -> $value:ty {
            $(let $local:pat = $given:expr;)*
            match $field:ident {
                $($($name:ident)|+ => $answer:expr,)*
                _ => [$($other:ty: $point:expr),* $(,)?] $(,)?
            }
        }
    ) => {
        $(#[$about])*
        #[inline]
        $visibility fn answer($($argument)*) -> Option<$value> {
            $(let $local = $given;)*
            Some(match $field {
                $($($crate::Field::$name)|+ => $answer,)*
                _ => {
                    $(
                        let other: $other = $point;
                        if let Some(value) = other.answer($field) {
                            return Some(value);
                        }
                    )*
                    return None;
                }
            })
        }

        /// True if points of this kind answer a field.
        $visibility fn knows(field: $crate::Field) -> bool {
            match field {
                $($($crate::Field::$name)|+ => true,)*
                _ => false $(|| <$other>::knows(field))*,
            }
        }
    };
}

/// The point that is shaded. [`answers!`] declares the answers of a kind of point.
pub trait Context {
    /// True if skies show the discs of their suns.
    fn shows_sun(&self) -> bool {
        true
    }

    /// The share of rays about a normal, in proportion to the cosine, that hit nothing as far as a distance. Who cannot
    /// follow rays sees nothing.
    fn open(&self, _: Occlusion, _normal: Vec3A, _distance: f32) -> f32 {
        1.0
    }

    /// The mean normal of the object's surface around the point as far as a radius, world units, towards the viewer. Who cannot follow rays
    /// gives the shading normal.
    fn bevelled(&self, _samples: u8, _radius: f32) -> Vec3A {
        self.read(Field::Normal, Shift::NONE)
    }

    /// The nearest hit along a ray, world space; `None` where nothing is. One from a place beside the point, from which a bump looks, passes
    /// surfaces as near. A context that cannot follow rays hits nothing.
    fn raycast(&self, _: Raycast, _position: Vec3A, _direction: Vec3A, _length: f32, _: Shift) -> Option<Found> {
        None
    }

    /// True if points of this kind answer a field.
    fn knows(field: Field) -> bool
    where
        Self: Sized;
    /// A field, at the point or beside it; `None` of one that points of this kind do not know.
    fn answer(&self, field: Field, shift: Shift) -> Option<Vec3A>;
    /// A field, at the point or beside it; zero of one that points of this kind do not know.
    #[inline(always)]
    fn read(&self, field: Field, shift: Shift) -> Vec3A {
        self.answer(field, shift).unwrap_or(Vec3A::ZERO)
    }
    /// An attribute by its index in [`Program::attributes`](crate::Program::attributes); a missing one is zero.
    fn attribute(&self, index: usize, shift: Shift) -> Vec4;
    /// A vector from one space to another; a normal comes at length 1.
    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vec3A) -> Vec3A;
}

/// Up to eight points that are shaded at once by one program. A field that is not answered for all together is asked of each.
pub trait Places {
    /// A point by itself.
    type Point: Context;

    /// Number of points, 1 to [`LANES`].
    fn count(&self) -> usize;
    /// The point of a lane.
    fn point(&self, lane: usize) -> &Self::Point;

    /// [`Context::read`] of all points.
    #[inline]
    fn read(&self, field: Field, shift: Shift) -> Vectors {
        let mut all = Vectors::ZERO;
        (0..self.count()).for_each(|lane| all.put(lane, self.point(lane).read(field, shift)));
        all
    }

    /// [`Context::attribute`] of all points: the first three parts, and the fourth.
    #[inline]
    fn attribute(&self, index: usize, shift: Shift) -> (Vectors, f32x8) {
        let (mut all, mut fourth) = (Vectors::ZERO, [0.0; LANES]);
        for (lane, fourth) in fourth.iter_mut().enumerate().take(self.count()) {
            let value = self.point(lane).attribute(index, shift);
            all.put(lane, Vec3A::from_vec4(value));
            *fourth = value.w;
        }
        (all, fourth.into())
    }

    /// [`Context::transform`] of all points.
    #[inline]
    fn transform(&self, direction: Direction, from: Space, to: Space, vectors: Vectors) -> Vectors {
        let mut all = Vectors::ZERO;
        for lane in 0..self.count() {
            all.put(lane, self.point(lane).transform(direction, from, to, vectors.at(lane)));
        }
        all
    }
}

impl<C: Context> Places for [C] {
    type Point = C;

    fn count(&self) -> usize {
        self.len()
    }
    fn point(&self, lane: usize) -> &C {
        &self[lane]
    }
}

choices! {
    /// The interpolation of an image between its pixels.
    #[expect(missing_docs, reason = "named after Blender's")]
    pub Interpolation { Linear = "Linear", Closest = "Closest", Cubic = "Cubic" | "Smart" }
}

choices! {
    /// The values beyond an image's edges.
    #[expect(missing_docs, reason = "named after Blender's")]
    pub Extension { Repeat = "REPEAT", Extend = "EXTEND", Clip = "CLIP", Mirror = "MIRROR" }
}

/// The way in which an image is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageReading {
    /// Interpolation between pixels.
    pub interpolation: Interpolation,
    /// Continuation outside of the image.
    pub extension: Extension,
    /// True to divide colours by alpha.
    pub unassociate: bool,
}

/// The images that programs read.
pub trait Textures {
    /// Linear RGBA at a place of the image: (0, 0) is its lower left corner. Alpha is multiplied in, or, to `unassociate`, divided out again after
    /// interpolation and before decoding, where it is neither 0 nor 1.
    fn lookup(&self, image: usize, uv: Vec2, read: ImageReading) -> Vec4;
}

/// No surface and no images: for folding of constants, which depend on neither.
pub(crate) struct Nowhere;

impl Context for Nowhere {
    fn knows(_: Field) -> bool {
        false
    }
    fn answer(&self, _: Field, _: Shift) -> Option<Vec3A> {
        None
    }
    fn attribute(&self, _: usize, _: Shift) -> Vec4 {
        Vec4::ZERO
    }
    fn transform(&self, _: Direction, _: Space, _: Space, vector: Vec3A) -> Vec3A {
        vector
    }
}

impl Textures for Nowhere {
    fn lookup(&self, _: usize, _: Vec2, _: ImageReading) -> Vec4 {
        Vec4::ZERO
    }
}
