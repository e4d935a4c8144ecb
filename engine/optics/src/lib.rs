//! Exact and paraxial optics of real lenses: the paths of rays, the places of planes and pupils, and directions to aim rays in.
//!
//! # Axes, signs, units
//!
//! Lens space, in millimetres: z runs along the optical axis in the direction of the light, scene side first, and is 0
//! at the vertex of the first surface; x is right and y is up as seen from behind the film, looking at the scene. A
//! radius is positive if its centre lies on the +z side. Thicknesses follow z, so they turn negative after a mirror.
//! Wavelengths are vacuum wavelengths in nanometres, angles are in radians unless a name says degrees, indices are
//! relative to air, whose index is 1. Everything is `f64`, but for rays that are asked to be traced in `f32`.
//!
//! # From file to ray
//!
//! [`formats::lens`] reads a [`prescription::Prescription`], checked, its [`glass`] found by name. A
//! [`system::System`] is that lens scaled to a focal length and closed to an f-number. [`paraxial`] and [`focus`] say
//! where its planes lie and where the film must stand; a [`trace::Tracer`] carries rays through it at one wavelength,
//! either way; a [`pupil_map::PupilMap`] chooses where to aim from the film, an [`entrance_map::EntranceMap`] from the scene.
//!
//! A module uses only those that stand before it here: [`least_squares`] → [`lensfun`] → [`calibration`] → [`first_order`] → [`glass`] → [`coating`] → [`lane`] → [`vector`] → [`surface`] → [`interface`] → [`single_surface`] → [`diaphragm`] →
//! [`prescription`] → [`deviation`] → [`formats`] → [`system`] → [`trace`] → [`transmission`] → [`paraxial`] → [`axial_beam`] → [`published`] → [`focus`] → [`seidel`] → [`field`] → [`vignetting`] → [`chief_rays`] → [`lens_fit`] → [`drawing`] → [`gaussian`] → [`ghosts`] → [`scatter`] →
//! [`pupil_map`] → [`entrance_map`] → [`autofocus`] → [`analysis`] → [`diffraction`] → [`ray_table`] → [`sensitivity`] → [`reality`].
//!
//! A ray that is lost is a result: the surface and one of seven reasons. No value is ever NaN, and no input panics.
//!
//! # One lens, worked through
//!
//! A biconvex singlet, its focal length by the lensmaker's formula, and a ray that crosses the axis there:
//!
//! ```
//! use glam::DVec3;
//! use petzval_optics::formats::lens;
//! use petzval_optics::glass::{Catalogue, line_nm};
//! use petzval_optics::paraxial::Paraxial;
//! use petzval_optics::system::{System, LensSettings};
//! use petzval_optics::trace::{Failure, Ray};
//!
//! let text = "#radius thickness glass diameter conic isstop
//!              60.0 6.0 N-BK7 30.0 0.0 1
//!             -60.0 55.0 air  30.0 0.0 0";
//! let prescription = lens::parse(text, "singlet.lens", Catalogue::shipped())?;
//! let system = System::new(&prescription, &LensSettings::default())?;
//!
//! // 1 / f = (n - 1) (2 / R - (n - 1) t / (n R^2))
//! let n = Catalogue::shipped().medium("N-BK7")?.index(line_nm::D);
//! let f = 1.0 / ((n - 1.0) * (2.0 / 60.0 - (n - 1.0) * 6.0 / (n * 3600.0)));
//! let info = Paraxial::new(&system, line_nm::D);
//! assert!((info.efl_mm.unwrap() - f).abs() < 1e-12);
//!
//! // A ray close to the axis crosses it in the focal plane; farther out it falls short: spherical aberration.
//! let tracer = system.at_wavelength(line_nm::D);
//! let crossing = |height: f64| {
//!     let ray = Ray { origin: DVec3::new(0.0, height, -10.0), direction: DVec3::Z };
//!     tracer.from_scene(ray).map(|out| out.origin.z - out.origin.y / out.direction.y * out.direction.z)
//! };
//! let focus = info.image_focal_plane_mm.unwrap();
//! assert!((crossing(1e-3).unwrap() - focus).abs() < 1e-6);
//! assert!(crossing(14.0).unwrap() < focus - 5.0);
//! assert_eq!(crossing(15.1).unwrap_err().reason, Failure::OutsideAperture);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// A comparison that NaN fails, written `!(x >= 0.0)`, is how a number that is none ends as a named reason.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod analysis;
pub mod autofocus;
pub mod axial_beam;
pub mod calibration;
pub mod chief_rays;
pub mod coating;
pub mod deviation;
pub mod diaphragm;
pub mod diffraction;
pub mod drawing;
pub mod entrance_map;
pub mod field;
pub mod first_order;
pub mod focus;
pub mod formats;
pub mod gaussian;
pub mod ghosts;
pub mod glass;
pub mod interface;
pub mod lane;
pub mod least_squares;
pub mod lens_fit;
pub mod lensfun;
pub mod paraxial;
pub mod prescription;
pub mod published;
pub mod pupil_map;
pub mod ray_table;
pub mod reality;
pub mod scatter;
pub mod seidel;
pub mod sensitivity;
pub mod single_surface;
pub mod surface;
pub mod system;
pub mod trace;
pub mod transmission;
pub mod vector;
pub mod vignetting;
