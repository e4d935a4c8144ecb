//! Material, lamp and world descriptions, read by attribute.

use crate::camera::Matrix4;
use crate::compiled::Graphs;
use crate::error::{Error, bad_scene};
use glam::{Affine3A, DMat4, Mat3, Mat3A};
use petzval_render::Rgb;
use petzval_render::nodes::lamp;
use petzval_render::scene::graph::Displacement;
use petzval_render::scene::lamp::{Lamp, LampKind};
use petzval_render::scene::material::{Aovs, EmissionSampling, Material};
use petzval_render::scene::visibility::{LightSets, Rays};
use petzval_render::scene::world::World;
use pyo3::prelude::*;

type Colour = (f32, f32, f32);

fn rgb(c: Colour) -> Rgb {
    Rgb::new(c.0, c.1, c.2)
}

/// The kinds of ray that are left where some are named.
pub(crate) fn visible(hidden_from: &[String], owner: &str) -> Result<Rays, Error> {
    let mut left = Rays::ALL;
    for name in hidden_from {
        let kind = Rays::named(name).ok_or_else(|| bad_scene(format!("{owner}: there is no kind of ray '{name}'")))?;
        left = left.without(kind);
    }
    Ok(left)
}

#[derive(FromPyObject)]
pub(crate) struct PyMaterial {
    name: String,
    graph: String,
    pass_index: i32,
    displacement_method: String,
    aovs: Option<(String, Vec<u16>)>,
    transparent_shadows: bool,
    corrects_bumps: bool,
    emission_sampling: String,
}

impl PyMaterial {
    /// The material, and warnings of nodes that the engine does otherwise than Blender.
    pub(crate) fn material(self, graphs: &mut Graphs) -> Result<(Material, Vec<String>), Error> {
        let m = self;
        let owner = format!("Material '{}'", m.name);
        let displacement = match m.displacement_method.as_str() {
            "DISPLACEMENT" => Displacement::Vertices,
            "BOTH" => Displacement::Both,
            _ => Displacement::Bump,
        };
        let (graph, mut reports) = graphs.read(m.graph, m.pass_index, displacement, &owner)?;
        let aovs = match m.aovs {
            None => None,
            Some((json, numbers)) => {
                let (graph, told) = graphs.read(json, m.pass_index, Displacement::default(), &owner)?;
                add_new(&mut reports, told);
                Some(Aovs { graph, numbers })
            }
        };
        let emission_sampling = EmissionSampling::named(&m.emission_sampling)
            .ok_or_else(|| bad_scene(format!("{owner}: there is no emission sampling '{}'", m.emission_sampling)))?;
        let (shades_fully, corrects_bumps, pass_index) = (!m.transparent_shadows, m.corrects_bumps, m.pass_index);
        let made = Material::new(m.name, graph);
        let material = Material { pass_index, aovs, shades_fully, corrects_bumps, emission_sampling, ..made };
        Ok((material, reports))
    }
}

/// Adds the reports that are not there yet.
fn add_new(reports: &mut Vec<String>, told: Vec<String>) {
    for what in told {
        if !reports.contains(&what) {
            reports.push(what);
        }
    }
}

#[derive(FromPyObject)]
pub(crate) struct PyLight {
    object_name: String,
    kind: String,
    matrix_world: Matrix4,
    color: Colour,
    radius: f32,
    soft_falloff: bool,
    angle_rad: f32,
    shape: String,
    size: (f32, f32),
    spread_rad: f32,
    spot_angle_rad: f32,
    spot_blend: f32,
    graph: Option<String>,
    hidden_from: Vec<String>,
    sets: (u8, u8),
    light_group: u16,
    max_bounces: u32,
    cast_shadow: bool,
}

impl PyLight {
    /// The lamp, its matrix, and warnings of nodes that the engine does otherwise than Blender.
    pub(crate) fn lamp(self, graphs: &mut Graphs) -> Result<(Lamp, DMat4, Vec<String>), Error> {
        let unknown = |what: &str, value: &str| bad_scene(format!("light '{}': no {what} '{value}'", self.object_name));
        let reaches = visible(&self.hidden_from, &self.object_name)?;
        let kind = match self.kind.as_str() {
            "POINT" => LampKind::Point { radius: self.radius, soft: self.soft_falloff },
            "SPOT" => LampKind::Spot {
                radius: self.radius,
                half_angle_rad: 0.5 * self.spot_angle_rad,
                blend: self.spot_blend,
                soft: self.soft_falloff,
            },
            "SUN" => LampKind::Sun { half_angle_rad: 0.5 * self.angle_rad },
            "AREA" => LampKind::Area {
                size: [self.size.0, self.size.1],
                ellipse: match self.shape.as_str() {
                    "RECTANGLE" => false,
                    "ELLIPSE" => true,
                    other => return Err(unknown("shape", other)),
                },
                half_spread_rad: 0.5 * self.spread_rad,
            },
            other => return Err(unknown("kind of light", other)),
        };
        let owner = format!("Light '{}'", self.object_name);
        let (graph, mut reports) = graphs.of_lamp(self.graph, &owner)?;
        for field in graph.iter().flat_map(|graph| lamp::unknown(graph)) {
            reports.push(format!("{owner}: {field:?} is not supported in a light yet, it is 0"));
        }
        let lamp = Lamp {
            object_name: self.object_name,
            kind,
            color: rgb(self.color),
            graph,
            reaches,
            sets: LightSets { receivers: self.sets.0 & 63, blockers: self.sets.1 & 63 },
            light_group: self.light_group,
            max_bounces: self.max_bounces,
            cast_shadow: self.cast_shadow,
            to_render: Affine3A::IDENTITY,
        };
        Ok((lamp, self.matrix_world.into(), reports))
    }
}

#[derive(FromPyObject)]
pub(crate) struct PyWorld {
    color: Colour,
    image: Option<u32>,
    rotation: [[f32; 3]; 3],
    hidden_from: Vec<String>,
    light_group: u16,
    max_bounces: u32,
    cast_shadow: bool,
    has_image: bool,
    graph: Option<String>,
    aovs: Option<(String, Vec<u16>)>,
}

impl PyWorld {
    /// The world, and warnings of nodes that the engine does otherwise than Blender.
    pub(crate) fn world(self, graphs: &mut Graphs) -> Result<(World, Vec<String>), Error> {
        let w = self;
        let (graph, mut reports) = graphs.of_world(w.graph)?;
        let (json, numbers) = w.aovs.unzip();
        let (aov_graph, told) = graphs.of_world(json)?;
        add_new(&mut reports, told);
        let aovs = aov_graph.zip(numbers).map(|(graph, numbers)| Aovs { graph, numbers });
        let world = World {
            color: rgb(w.color),
            texture: w.image,
            rotation: Mat3A::from(Mat3::from_cols_array_2d(&w.rotation).transpose()),
            visible: visible(&w.hidden_from, "World")?,
            light_group: w.light_group,
            max_bounces: w.max_bounces,
            cast_shadow: w.cast_shadow,
            has_image: w.has_image,
            graph,
            aovs,
        };
        Ok((world, reports))
    }
}
