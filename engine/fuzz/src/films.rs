//! Files of films: checkpoints that a render takes up, and shares of a picture that are joined.
//!
//! Checksums keep a fuzzer out of these files as they keep out accidents. They are set right here, so that what lies behind them is read: a file
//! that another program has written with care.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use glam::{DMat4, DVec3, Vec3};
use petzval_render::Rgb;
use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::film::cryptomatte::MatteLayer;
use petzval_render::film::data::DataPass;
use petzval_render::integrator::PreparedScene;
use petzval_render::job::checkpoint::Checkpoints;
use petzval_render::job::share::Share;
use petzval_render::job::{Job, OutputOptions, Settings};
use petzval_render::sampler::warp::Filter;
use petzval_render::scene::SceneBuilder;
use petzval_render::scene::mesh::MeshDescription;
use petzval_render::scene::world::World;

use super::{Scratch, one_line};

/// Width and height of the pictures, pixels: some tiles.
const SIZE: [u32; 2] = [36, 20];
/// The fingerprint of all films here.
const FINGERPRINT: &str = "fuzz";
/// Length of the words that a file begins with.
const MAGIC: usize = 16;
/// The share that a render of [`share`] takes itself, and the one that it is given.
const OWN: Share = Share { first: 0, end: 1, of: 2 };
const OTHER: Share = Share { first: 1, end: 2, of: 2 };

/// A triangle in a white world.
pub fn stage() -> Arc<PreparedScene> {
    static STAGE: OnceLock<Arc<PreparedScene>> = OnceLock::new();
    STAGE
        .get_or_init(|| {
            let mut builder = SceneBuilder::new();
            let triangle = MeshDescription {
                name: "triangle".into(),
                positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
                triangles: vec![[0, 1, 2]],
                ..Default::default()
            };
            let mesh = builder.add_mesh(triangle).unwrap_or_else(|error| panic!("{error}"));
            let place = DMat4::from_translation(DVec3::new(0.0, 0.0, -3.0));
            let placed = builder.add_instance("triangle", mesh, place, &[], true, true);
            assert!(placed.is_ok_and(|placed| placed.is_some()));
            assert!(builder.set_world(World { color: Rgb::ONE, ..Default::default() }).is_ok());
            Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)))
        })
        .clone()
}

/// A render of a small picture: plain, or with as many samples as each pixel needs.
fn start(is_adaptive: bool, share: Share, checkpoints: Option<Checkpoints>) -> Job {
    let settings = Settings {
        width: SIZE[0],
        height: SIZE[1],
        samples: if is_adaptive { 32 } else { 1 },
        noise_threshold: if is_adaptive { 0.2 } else { 0.0 },
        threads: 1,
        max_bounces: 1,
        filter: Filter::Box,
        with_data: !is_adaptive,
        ..Settings::default()
    };
    let beside = OutputOptions {
        mattes: if is_adaptive { Vec::new() } else { vec![MatteLayer::Object] },
        matte_levels: 2,
        light_groups: u16::from(!is_adaptive),
        checkpoints,
        share,
        ..OutputOptions::default()
    };
    let description = CameraDescription { model: Model::Pinhole, ..CameraDescription::default() };
    let camera = Camera::new(&description, SIZE[0], SIZE[1]).unwrap_or_else(|error| panic!("{error}"));
    Job::start_with(stage(), vec![camera], settings, beside).unwrap_or_else(|error| panic!("{error}"))
}

/// The film of a finished share as it is in a file.
///
/// # Panics
/// If it cannot be rendered or written.
pub fn film_file(is_adaptive: bool, share: Share) -> Vec<u8> {
    let scratch = Scratch::new("film-template");
    let job = start(is_adaptive, share, None);
    assert!(job.wait(Duration::from_secs(60)));
    let file = scratch.file("film");
    job.write_film(&file, FINGERPRINT).unwrap_or_else(|error| panic!("{error}"));
    std::fs::read(&file).unwrap_or_else(|error| panic!("{error}"))
}

/// The beginning of a file, up to its first block.
fn head(share: Share) -> Vec<u8> {
    static HEADS: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    let heads = HEADS.get_or_init(|| [Share::default(), OTHER].map(|share| film_file(false, share)));
    let whole = &heads[usize::from(share == OTHER)];
    whole[..head_length(whole)].to_vec()
}

fn number(bytes: &[u8], at: usize) -> Option<usize> {
    let four = bytes.get(at..at + 4)?;
    Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]) as usize)
}

/// Length of what stands before the first block.
pub fn head_length(file: &[u8]) -> usize {
    MAGIC + 4 + number(file, MAGIC).unwrap_or(0) + 4
}

/// A file with all checksums right, as far as its lengths let one find them.
fn checked(mut file: Vec<u8>) -> Vec<u8> {
    let mut place = MAGIC;
    // Of the header the checksum stands behind it, of a block before.
    let mut is_header = true;
    while let Some(length) = number(&file, place) {
        let (from, sum) = if is_header { (place + 4, place + 4 + length) } else { (place + 8, place + 4) };
        let Some(bytes) = file.get(from..from + length) else { break };
        let hash = crc32fast::hash(bytes).to_le_bytes();
        let Some(into) = file.get_mut(sum..sum + 4) else { break };
        into.copy_from_slice(&hash);
        place = if is_header { sum + 4 } else { from + length };
        is_header = false;
    }
    file
}

/// The file that an input stands for: its first byte says whether the film is adaptive, and whether the header is an input, too.
fn file(bytes: &[u8], share: Share) -> (bool, Vec<u8>) {
    let (&kind, rest) = bytes.split_first().unwrap_or((&0, &[]));
    let whole = if kind & 2 == 0 { [&head(share), rest].concat() } else { rest.to_vec() };
    (kind & 1 != 0, checked(whole))
}

/// Looks at all that a film has; true if all numbers of its pictures are finite. Those of a file may be any.
fn is_finite(job: &Job) -> bool {
    let film = job.film();
    let mut pictures = vec![film.picture().into_flattened()];
    pictures.extend(film.groups().iter().map(|group| group.picture().into_flattened()));
    pictures.extend([DataPass::Depth, DataPass::Normal, DataPass::Samples].map(|pass| job.data(pass)));
    pictures.push(film.remainders().into_flattened().into_flattened());
    pictures.push(job.matte(MatteLayer::Object));
    let _ = (film.most_seen(MatteLayer::Object), film.variances(), job.progress(), job.samples_done());
    pictures.iter().flatten().all(|value| value.is_finite())
}

/// A checkpoint is taken up or refused in one line, and the render then ends.
pub fn checkpoint(bytes: &[u8]) {
    takes_up(bytes);
}

/// [`checkpoint`]; true if it was taken up, and the picture is finite.
pub fn takes_up(bytes: &[u8]) -> bool {
    let scratch = Scratch::new("checkpoint");
    let (is_adaptive, whole) = file(bytes, Share::default());
    let path = scratch.file("render.checkpoint");
    assert!(std::fs::write(&path, whole).is_ok());
    let every = Duration::from_secs(3600);
    let checkpoints = Checkpoints { file: path, fingerprint: FINGERPRINT.to_owned(), every };
    let job = start(is_adaptive, Share::default(), Some(checkpoints));
    assert!(job.wait(Duration::from_secs(20)), "the render does not end");
    let statistics = job.statistics();
    for what in statistics.failure.iter().chain(statistics.kept.iter().filter_map(|kept| kept.problem.as_ref())) {
        one_line(what);
        assert!(!what.contains("please report"), "{what}");
    }
    let is_finite = is_finite(&job);
    is_finite && statistics.failure.is_none() && statistics.kept.is_some_and(|kept| kept.resumed_samples > 0.0)
}

/// A share's film is joined or refused in one line.
pub fn share(bytes: &[u8]) {
    joins(bytes);
}

/// [`share`]; true if it was joined, and the picture is finite.
pub fn joins(bytes: &[u8]) -> bool {
    let scratch = Scratch::new("share");
    let (is_adaptive, whole) = file(bytes, OTHER);
    let path = scratch.file("share.film");
    assert!(std::fs::write(&path, whole).is_ok());
    let job = start(is_adaptive, OWN, None);
    let refused = job.join_film(&path, FINGERPRINT, OTHER);
    if let Some(why) = &refused {
        one_line(why);
    }
    assert!(job.wait(Duration::from_secs(20)), "the render does not end");
    assert_eq!(job.statistics().failure, None);
    is_finite(&job) && refused.is_none()
}

/// Inputs that are whole films, to begin with: of [`checkpoint`] and of [`share`].
pub fn seeds() -> [(&'static str, Vec<Vec<u8>>); 2] {
    let of = |share: Share| {
        let input = |is_adaptive: bool, with_head: bool| {
            let file = film_file(is_adaptive, share);
            let kind = u8::from(is_adaptive) | if with_head { 2 } else { 0 };
            let rest = if with_head { &file[..] } else { &file[head_length(&file)..] };
            [&[kind], rest].concat()
        };
        vec![input(false, false), input(true, false), input(false, true)]
    };
    [("checkpoint", of(Share::default())), ("share", of(OTHER))]
}
