//! Shares of a picture, joined, are the whole to its bits; a file that is no share of it is refused and changes nothing.

use super::super::share::Share;
use super::super::tests::{camera, settings, stage};
use super::super::{Job, OutputOptions, Settings};
use crate::camera::Model;
use crate::film::cryptomatte::MatteLayer;
use crate::film::data::DataPass;
use crate::integrator::Integrator;
use crate::pipeline::Pipeline;
use std::path::PathBuf;
use std::time::Duration;

/// A folder of its own for each test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("petzval-share-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn start(settings: &Settings, share: Share) -> Job {
    let output = OutputOptions {
        mattes: vec![MatteLayer::Object],
        matte_levels: 2,
        light_groups: 1,
        share,
        ..Default::default()
    };
    let job = Job::start_with(stage(), vec![camera(Model::Lens)], settings.clone(), output).unwrap();
    job.wait(Duration::MAX);
    job
}

/// All that is in the film.
fn bits(job: &Job) -> Vec<Vec<u32>> {
    let data = [DataPass::Depth, DataPass::Position, DataPass::Normal, DataPass::Samples].map(|pass| job.data(pass));
    let pictures = [job.film().picture(), job.film().groups()[0].picture()].map(Vec::into_flattened);
    let all = data.into_iter().chain(pictures).chain([job.matte(MatteLayer::Object), job.film().variances()]);
    all.map(|numbers| numbers.into_iter().map(f32::to_bits).collect()).collect()
}

const NOTHING: Share = Share { first: 0, end: 0, of: 1 };

fn kinds() -> [(&'static str, Settings); 5] {
    let plain = Settings { width: 80, height: 72, ..settings(10, 2) };
    [
        ("film", Settings { pipeline: Pipeline::FilmFirst, ..plain.clone() }),
        ("scene", Settings { pipeline: Pipeline::SceneFirst, ..plain.clone() }),
        ("hero", Settings { pipeline: Pipeline::Hero, ..plain.clone() }),
        ("two-way", Settings { integrator: Integrator::Bidirectional, samples: 5, ..plain.clone() }),
        ("adaptive", Settings { noise_threshold: 0.05, samples: 64, ..plain }),
    ]
}

#[test]
fn shares_make_the_whole() {
    for (name, settings) in kinds() {
        let (folder, whole) = (Folder::new(name), start(&settings, Share::default()));
        // Of very different sizes, and one without a tile, joined in another order.
        let shares = [[0, 4], [4, 5], [5, 5], [5, 7]].map(|[first, end]| Share { first, end, of: 7 });
        for (i, &share) in shares.iter().enumerate() {
            let part = start(&Settings { threads: 1 + i % 3, ..settings.clone() }, share);
            part.write_film(&folder.0.join(i.to_string()), "one").unwrap();
            assert!(share == shares[2] || bits(&part) != bits(&whole), "{name}");
        }
        let joined = start(&settings, NOTHING);
        assert_eq!(joined.statistics().mean_samples, 0.0);
        for i in [3, 0, 2, 1] {
            let file = folder.0.join(i.to_string());
            assert_eq!(joined.join_film(&file, "one", shares[i]), None, "{name}");
        }
        assert!(bits(&joined) == bits(&whole), "{name}");
        let counts = [&joined, &whole].map(|job| job.statistics().counts.rays);
        assert_eq!(counts[0], counts[1], "{name}");
        // Twice is not taken.
        assert!(joined.join_film(&folder.0.join("0"), "one", shares[0]).is_some());
        assert!(bits(&joined) == bits(&whole), "{name}");
    }
}

#[test]
fn what_is_no_share_of_it_is_refused() {
    let (folder, settings) = (Folder::new("refused"), Settings { width: 80, height: 72, ..settings(4, 2) });
    let share = Share { first: 0, end: 1, of: 2 };
    let file = folder.0.join("part");
    start(&settings, share).write_film(&file, "one").unwrap();
    let joined = start(&settings, NOTHING);
    let empty = bits(&joined);
    let other = Share { first: 1, end: 2, of: 2 };
    for (fingerprint, share, said) in [("two", share, "another picture"), ("one", other, "another part")] {
        assert!(joined.join_film(&file, fingerprint, share).unwrap().contains(said));
    }
    assert!(joined.join_film(&folder.0.join("none"), "one", share).is_some());
    let whole = std::fs::read(&file).unwrap();
    for place in (0..whole.len()).step_by(whole.len() / 40).chain([whole.len() - 1]) {
        let mut bytes = whole.clone();
        bytes[place] ^= 1 << (place % 8);
        std::fs::write(&file, &bytes).unwrap();
        assert!(joined.join_film(&file, "one", share).is_some(), "byte {place}");
        std::fs::write(&file, &whole[..place]).unwrap();
        assert!(joined.join_film(&file, "one", share).is_some(), "cut at byte {place}");
    }
    assert!(bits(&joined) == empty);
    // A render that was stopped is no share.
    let long = Settings { samples: 100_000, ..settings.clone() };
    let output = OutputOptions { light_groups: 1, share, ..Default::default() };
    let job = Job::start_with(stage(), vec![camera(Model::Lens)], long, output).unwrap();
    job.stop();
    job.wait(Duration::MAX);
    assert!(job.write_film(&folder.0.join("stopped"), "one").is_err() && !folder.0.join("stopped").exists());
}
