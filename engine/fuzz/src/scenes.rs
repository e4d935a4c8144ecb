//! Scenes of arrays of any numbers, as the wall hands them to the engine once it has copied them out of Python's.

use std::sync::Arc;
use std::time::Duration;

use glam::{Affine3A, DMat4, DVec2, DVec3, Vec2, Vec3, Vec3A, Vec4};
use petzval_nodes::Graph as Shaders;
use petzval_render::Rgb;
use petzval_render::accel::Ray;
use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::integrator::PreparedScene;
use petzval_render::job::{Job, Settings};
use petzval_render::nodes::OF_MATERIALS;
use petzval_render::scene::corners::{Corners, Named};
use petzval_render::scene::curves::{CurveShape, CurvesDescription, StrandValues};
use petzval_render::scene::graph::{Displacement, Graph};
use petzval_render::scene::grid::Grid;
use petzval_render::scene::lamp::{Lamp, LampKind};
use petzval_render::scene::material::Material;
use petzval_render::scene::mesh::{Dicing, EdgeLength, MeshDescription};
use petzval_render::scene::motion::Poses;
use petzval_render::scene::points::PointsDescription;
use petzval_render::scene::texture::{Extension, Interpolation, Texture};
use petzval_render::scene::viewport::{ViewportDescription, ViewportProjection};
use petzval_render::scene::visibility::Rays;
use petzval_render::scene::world::World;
use petzval_render::scene::{SceneBuilder, SceneError};
use serde_json::{Value, json};

use super::bytes::Bytes;
use super::one_line;

fn three(bytes: &mut Bytes<'_>) -> Vec3 {
    Vec3::new(bytes.any_f32(), bytes.any_f32(), bytes.any_f32())
}

fn four(bytes: &mut Bytes<'_>) -> Vec4 {
    three(bytes).extend(bytes.any_f32())
}

/// So many values, now and then another number of them.
fn list<T>(bytes: &mut Bytes<'_>, count: usize, mut of: impl FnMut(&mut Bytes<'_>) -> T) -> Vec<T> {
    let count = if bytes.once_in(6) { bytes.below(20) } else { count };
    (0..count).map(|_| of(bytes)).collect()
}

fn matrix(bytes: &mut Bytes<'_>) -> DMat4 {
    if bytes.once_in(10) {
        return DMat4::from_cols_array(&std::array::from_fn(|_| bytes.any_f64()));
    }
    if bytes.once_in(60) {
        return DMat4::from_cols_array(&std::array::from_fn(|_| f64::from(bytes.any_f32())));
    }
    let place = DVec3::new(bytes.part(), bytes.part(), bytes.part() - 3.0);
    let scale = DVec3::new(1.0 + bytes.part(), 1.0 + bytes.part(), 1.0 + bytes.part());
    DMat4::from_translation(place) * DMat4::from_rotation_y(3.0 * bytes.part()) * DMat4::from_scale(scale)
}

/// Values by vertex, corner of a face or triangle, most often as many as there are.
fn corners<T>(bytes: &mut Bytes<'_>, counts: [usize; 3], of: impl FnMut(&mut Bytes<'_>) -> T) -> Corners<T> {
    match bytes.below(3) {
        0 => Corners::Vertices(list(bytes, counts[0], of)),
        1 => Corners::Loops(list(bytes, counts[1], of)),
        _ => Corners::Triangles(list(bytes, counts[2], of)),
    }
}

fn grid(bytes: &mut Bytes<'_>) -> Grid {
    let size: [usize; 3] = std::array::from_fn(|_| bytes.below(4));
    let channels = [1, 3, 4, 2][bytes.below(4)];
    let count = size[0] * size[1] * size[2] * channels;
    let size = if bytes.once_in(4) { [usize::MAX, 3, 7] } else { size };
    let to_voxels = Affine3A::from_mat4(matrix(bytes).as_mat4());
    Grid { name: "density".to_owned(), size, channels, values: list(bytes, count, |bytes| bytes.any_f32()), to_voxels }
}

fn mesh(bytes: &mut Bytes<'_>) -> MeshDescription {
    let (vertices, triangles) = (bytes.below(12), bytes.below(10));
    let index = |bytes: &mut Bytes<'_>, most: usize| {
        if bytes.once_in(3) { bytes.word() } else { bytes.below(most.max(1)) as u32 }
    };
    let loop_count = 3 * triangles;
    let counts = [vertices, loop_count, triangles];
    let has_loops = bytes.once_in(100);
    let named_pairs = |bytes: &mut Bytes<'_>| -> Vec<Named<Vec2>> {
        let uv = |bytes: &mut Bytes<'_>| Vec2::new(bytes.any_f32(), bytes.any_f32());
        (0..bytes.below(3)).map(|_| ("UVMap".to_owned(), corners(bytes, counts, uv))).collect()
    };
    MeshDescription {
        name: "mesh".to_owned(),
        positions: list(bytes, vertices, three),
        triangles: list(bytes, triangles, |bytes| std::array::from_fn(|_| index(bytes, vertices))),
        loops: if has_loops {
            list(bytes, triangles, |bytes| std::array::from_fn(|_| index(bytes, loop_count)))
        } else {
            Vec::new()
        },
        corner_normals: bytes.once_in(100).then(|| corners(bytes, counts, three)),
        uv_maps: named_pairs(bytes),
        attributes: (0..bytes.below(2)).map(|_| ("colour".to_owned(), corners(bytes, counts, four))).collect(),
        material_slots: bytes.once_in(100).then(|| list(bytes, triangles, |bytes| u32::from(bytes.byte()))),
        moved_positions: bytes.once_in(40).then(|| [list(bytes, vertices, three), list(bytes, vertices, three)]),
        poses: bytes.once_in(60).then(|| Poses {
            positions: (0..bytes.below(5)).map(|_| list(bytes, vertices, three)).collect(),
            corner_normals: bytes
                .once_in(60)
                .then(|| (0..bytes.below(5)).map(|_| corners(bytes, counts, three)).collect()),
        }),
        grids: if bytes.once_in(40) { vec![grid(bytes)] } else { Vec::new() },
        keeps_opacity: bytes.once_in(40),
        dicing: bytes.once_in(40).then(|| Dicing {
            edge: if bytes.once_in(128) {
                EdgeLength::Pixels(bytes.any_f32())
            } else {
                EdgeLength::Units(bytes.any_f32())
            },
            off_screen: bytes.any_f32(),
            halvings: u32::from(bytes.byte()),
            room: 2000,
        }),
    }
}

fn curves(bytes: &mut Bytes<'_>) -> CurvesDescription {
    let (strands, by_strand) = (bytes.below(4), 1 + bytes.below(5));
    let keys = strands * by_strand;
    let first_keys = list(bytes, strands + 1, |bytes| if bytes.once_in(6) { bytes.word() } else { u32::MAX });
    let first_keys = (0u32..).zip(first_keys).map(|(i, key)| if key == u32::MAX { i * by_strand as u32 } else { key });
    CurvesDescription {
        name: "hair".to_owned(),
        keys: list(bytes, keys, four),
        first_keys: first_keys.collect(),
        shape: match bytes.below(3) {
            0 => CurveShape::Ribbon { pieces: u16::from(bytes.byte() % 9) },
            1 => CurveShape::Thick,
            _ => CurveShape::ThickLinear,
        },
        first_number: bytes.word(),
        uv_maps: (0..bytes.below(2))
            .map(|_| ("UVMap".to_owned(), list(bytes, strands, |bytes| Vec2::new(bytes.any_f32(), bytes.any_f32()))))
            .collect(),
        attributes: (0..bytes.below(2))
            .map(|_| {
                let values = match bytes.once_in(128) {
                    true => StrandValues::ByKey(list(bytes, keys, four)),
                    false => StrandValues::ByStrand(list(bytes, strands, four)),
                };
                ("colour".to_owned(), values)
            })
            .collect(),
        moved_keys: bytes.once_in(40).then(|| [list(bytes, keys, three), list(bytes, keys, three)]),
        poses: if bytes.once_in(60) {
            (0..bytes.below(5)).map(|_| list(bytes, keys, four)).collect()
        } else {
            Vec::new()
        },
    }
}

fn points(bytes: &mut Bytes<'_>) -> PointsDescription {
    let count = bytes.below(8);
    PointsDescription {
        name: "cloud".to_owned(),
        points: list(bytes, count, four),
        attributes: (0..bytes.below(2)).map(|_| ("colour".to_owned(), list(bytes, count, four))).collect(),
        moved_points: bytes.once_in(40).then(|| [list(bytes, count, three), list(bytes, count, three)]),
        poses: if bytes.once_in(60) {
            (0..bytes.below(5)).map(|_| list(bytes, count, four)).collect()
        } else {
            Vec::new()
        },
    }
}

fn lamp(bytes: &mut Bytes<'_>) -> Lamp {
    let kind = match bytes.below(4) {
        0 => LampKind::Point { radius: bytes.any_f32(), soft: bytes.once_in(128) },
        1 => LampKind::Spot {
            radius: bytes.any_f32(),
            half_angle_rad: bytes.any_f32(),
            blend: bytes.any_f32(),
            soft: bytes.once_in(128),
        },
        2 => LampKind::Sun { half_angle_rad: bytes.any_f32() },
        _ => LampKind::Area {
            size: [bytes.any_f32(), bytes.any_f32()],
            ellipse: bytes.once_in(128),
            half_spread_rad: bytes.any_f32(),
        },
    };
    Lamp { object_name: "lamp".to_owned(), kind, color: Rgb::from(three(bytes)).abs(), ..Lamp::default() }
}

/// A material that moves vertices, and one of mist in the grids of its mesh.
fn materials() -> [Material; 2] {
    let made = |name: &str, description: Value, displacement: Displacement| {
        let shaders = Shaders::from_json(&description.to_string()).unwrap_or_else(|error| panic!("{error}"));
        let (graph, _) = Graph::of(&shaders, 0, OF_MATERIALS);
        Material::new(name, Arc::new(Graph { displacement, ..graph }))
    };
    let node = |kind: &str, inputs: Value| json!({"type": kind, "name": kind, "options": {}, "inputs": inputs});
    let moved = json!({
        "nodes": [node("ShaderNodeDisplacement", json!({"Height": 0.2, "Midlevel": 0.0, "Scale": 1.0}))],
        "displacement": {"node": 0, "socket": "Displacement"},
    });
    let mist = json!({
        "nodes": [node("ShaderNodeVolumePrincipled", json!({"Density": 1.0, "Color": [0.8, 0.8, 0.8]}))],
        "volume": {"node": 0, "socket": "Volume"},
    });
    [made("moved", moved, Displacement::Vertices), made("mist", mist, Displacement::Bump)]
}

/// The scene of an input, as far as its pieces are taken.
fn built(bytes: &mut Bytes<'_>) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    builder.add_material(Material::diffuse("glow", Rgb::splat(0.5), Rgb::splat(0.3)));
    builder.add_material(Material::default_grey());
    for material in materials() {
        builder.add_material(material);
    }
    let mut refused = |error: SceneError| one_line(&error);
    for _ in 0..1 + bytes.below(3) {
        let added = match bytes.below(4) {
            0 => builder.add_curves(curves(bytes)),
            1 => builder.add_points(points(bytes)),
            _ => builder.add_mesh(mesh(bytes)),
        };
        let Ok(piece) = added.map_err(&mut refused) else { continue };
        let materials = list(bytes, 1, |bytes| bytes.below(5));
        let placed = builder.add_instance("object", piece, matrix(bytes), &materials, true, true).map_err(&mut refused);
        if let Ok(Some(instance)) = placed {
            if bytes.once_in(40)
                && let Err(error) = builder.set_moved(instance, [matrix(bytes), matrix(bytes)])
            {
                refused(error);
            }
            if bytes.once_in(60) {
                let keys: Vec<DMat4> = (0..bytes.below(5)).map(|_| matrix(bytes)).collect();
                builder.set_keys(instance, &keys);
            }
        }
    }
    for _ in 0..bytes.below(3) {
        let (lamp, place) = (lamp(bytes), matrix(bytes));
        if let Err(error) = builder.add_lamp(lamp, place) {
            refused(error);
        }
    }
    if bytes.once_in(128) {
        let viewport = ViewportDescription {
            matrix: matrix(bytes),
            focal: DVec2::new(f64::from(bytes.any_f32()), f64::from(bytes.any_f32())),
            center: DVec2::new(f64::from(bytes.any_f32()), f64::from(bytes.any_f32())),
            pixels: [1 + bytes.below(200) as u32, 1 + bytes.below(200) as u32],
            projection: if bytes.once_in(128) {
                ViewportProjection::Orthographic
            } else {
                ViewportProjection::Perspective
            },
        };
        if let Err(error) = builder.set_viewport("camera", viewport) {
            refused(error);
        }
    }
    let world = World { color: Rgb::from(three(bytes)).abs(), ..World::default() };
    if let Err(error) = builder.set_world(world) {
        refused(error);
    }
    builder
}

/// Pieces of a scene are taken or refused in one line; what is taken can be hit, and photographed: its picture is finite.
pub fn scene(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let mut builder = built(&mut bytes);
    for warning in builder.warnings() {
        one_line(warning);
    }
    let stage = PreparedScene::new(builder.build_keeping(DVec3::ZERO));
    for warning in &stage.warnings {
        one_line(warning);
    }
    for i in 0..12u16 {
        let angle = f32::from(i);
        let direction = Vec3A::new(0.3 * angle.sin(), 0.3 * angle.cos(), -1.0).normalize();
        let ray = Ray::new(Vec3A::new(0.1 * angle, 0.0, 1.0), direction).at(i * 5000);
        if let Some(hit) = stage.accel.closest(&ray, Rays::CAMERA) {
            assert!(hit.t.is_finite() && hit.u.is_finite() && hit.v.is_finite(), "{hit:?}");
            assert!((hit.instance as usize) < stage.scene.instances.len(), "{hit:?}");
        }
        let light = stage.accel.transmittance(&ray, |_| 0.5);
        assert!((0.0..=1.0).contains(&light), "{light}");
    }
    photograph(stage);
}

/// Asserts that the picture of a scene ends, and is finite.
fn photograph(stage: PreparedScene) {
    let settings = Settings { width: 6, height: 4, samples: 2, threads: 1, max_bounces: 2, ..Settings::default() };
    let description = CameraDescription { model: Model::Pinhole, ..CameraDescription::default() };
    let camera = Camera::new(&description, 6, 4).unwrap_or_else(|error| panic!("{error}"));
    let job = Job::start(Arc::new(stage), camera, settings).unwrap_or_else(|error| panic!("{error}"));
    assert!(job.wait(Duration::from_secs(20)), "the render does not end");
    assert_eq!(job.statistics().failure, None);
    assert!(job.film().picture().iter().flatten().all(|value| !value.is_nan()), "{:?}", job.film().picture());
}

/// An image of any numbers is taken or refused in one line; its values anywhere are finite.
pub fn texture(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let (width, height) = (bytes.below(5), bytes.below(5));
    let width = if bytes.once_in(4) { usize::MAX } else { width };
    let srgb = bytes.once_in(128);
    let count = width.saturating_mul(height).saturating_mul(4).min(64);
    let made = match bytes.once_in(128) {
        true => Texture::from_floats("image", width, height, &list(&mut bytes, count, |bytes| bytes.any_f32()), srgb),
        false => Texture::from_bytes("image", width, height, &list(&mut bytes, count, |bytes| bytes.byte()), srgb),
    };
    let texture = match made {
        Ok(texture) => Arc::new(texture),
        Err(error) => return one_line(&error),
    };
    let tiles: Vec<(u32, Arc<Texture>)> =
        (0..bytes.below(4)).map(|_| (1000 + u32::from(bytes.byte()), texture.clone())).collect();
    let tiled = match Texture::from_tiles("tiles", tiles) {
        Ok(tiled) => Arc::new(tiled),
        Err(error) => {
            one_line(&error);
            texture.clone()
        }
    };
    for _ in 0..6 {
        let uv = Vec2::new(bytes.any_f32(), bytes.any_f32());
        for texture in [&texture, &tiled] {
            for interpolation in [Interpolation::Linear, Interpolation::Closest] {
                for extension in [Extension::Repeat, Extension::Clip, Extension::Extend, Extension::Mirror] {
                    let value = texture.lookup(uv, interpolation, extension);
                    assert!(!value.is_nan(), "{uv} {interpolation:?} {extension:?}: {value}");
                    let _ = texture.unassociated(uv, interpolation, extension);
                }
            }
        }
    }
}
