//! A render that was broken off, however often, comes to the bits of one that was not.

use super::super::film_file::MAGIC;
use super::super::tests::{camera, settings, stage};
use super::super::{Job, OutputOptions, Settings};
use super::{Checkpoints, Kept, check_file};
use crate::camera::Model;
use crate::film::cryptomatte::MatteLayer;
use crate::film::data::DataPass;
use crate::integrator::Integrator;
use crate::pipeline::Pipeline;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A folder of its own for each test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("petzval-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn file(&self) -> PathBuf {
        self.0.join("render.checkpoint")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn start(settings: &Settings, file: Option<&Path>, fingerprint: &str, every_ms: u64) -> Job {
    let checkpoints = file.map(|file| Checkpoints {
        file: file.to_owned(),
        fingerprint: fingerprint.into(),
        every: Duration::from_millis(every_ms),
    });
    let beside = OutputOptions {
        mattes: vec![MatteLayer::Object],
        matte_levels: 2,
        light_groups: 1,
        checkpoints,
        ..OutputOptions::default()
    };
    Job::start_with(stage(), vec![camera(Model::Lens)], settings.clone(), beside).unwrap()
}

fn finish(job: &Job) -> Kept {
    assert!(job.wait(Duration::from_secs(120)));
    let statistics = job.statistics();
    assert_eq!(statistics.failure, None);
    statistics.kept.unwrap_or_default()
}

/// Everything that a render gives, and its number of rays.
fn bits(job: &Job) -> (Vec<Vec<f32>>, u64) {
    let data = [DataPass::Depth, DataPass::Position, DataPass::Normal, DataPass::Samples].map(|pass| job.data(pass));
    let pictures = [job.film().picture(), job.film().groups()[0].picture()].map(Vec::into_flattened);
    let all = data.into_iter().chain(pictures).chain([job.matte(MatteLayer::Object)]).collect();
    (all, job.statistics().counts.rays)
}

fn kinds() -> [(&'static str, Settings); 4] {
    let plain = settings(64, 2);
    [
        ("film", Settings { pipeline: Pipeline::FilmFirst, ..plain.clone() }),
        ("hero", Settings { pipeline: Pipeline::Hero, ..plain.clone() }),
        ("two-way", Settings { integrator: Integrator::Bidirectional, samples: 24, ..plain.clone() }),
        ("adaptive", Settings { noise_threshold: 0.05, samples: 256, ..plain }),
    ]
}

#[test]
fn a_render_broken_off_again_and_again_comes_to_the_same_bits() {
    for (name, settings) in kinds() {
        let folder = Folder::new(name);
        let whole = start(&settings, None, "", 0);
        finish(&whole);
        let mut times = 0;
        let last = loop {
            // With other threads each time, and copied while it goes on: as if killed then.
            let settings = Settings { threads: 1 + times % 3, ..settings.clone() };
            let job = start(&settings, Some(&folder.file()), "one", 1);
            let before = job.progress();
            let copy = folder.0.join("copy");
            while !job.wait(Duration::from_millis(2))
                && times < 12
                && job.progress() < before.max(0.08 * times as f32) + 0.07
            {}
            let ended = job.wait(Duration::ZERO);
            if ended || times >= 12 {
                finish(&job);
                break job;
            }
            while std::fs::copy(folder.file(), &copy).is_err() {
                std::thread::sleep(Duration::from_millis(1));
            }
            drop(job);
            std::fs::rename(&copy, folder.file()).unwrap();
            times += 1;
        };
        assert!(times >= 2, "{name}: broken off {times} times");
        assert!(last.statistics().kept.unwrap().resumed_samples > 0.0, "{name}");
        assert!(bits(&last) == bits(&whole), "{name}");
        assert!(last.end_checkpoints().unwrap().delete());
        assert!(!folder.file().exists());
    }
}

/// Stopping keeps the samples so far; the next render begins with it, and says so.
#[test]
fn a_stopped_render_is_kept() {
    let folder = Folder::new("stopped");
    let settings = Settings { samples: 4000, ..settings(64, 2) };
    let job = start(&settings, Some(&folder.file()), "one", 20);
    while job.samples_done() < 4 {
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(Duration::from_millis(30));
    job.stop();
    let kept = finish(&job);
    assert_eq!((kept.resumed_samples, kept.problem), (0.0, None));
    let mean = job.statistics().mean_samples;
    let _ = job.end_checkpoints();
    assert!(job.statistics().kept.unwrap().written > 0);

    let next = start(&settings, Some(&folder.file()), "one", 10_000);
    let kept = next.statistics().kept.unwrap();
    assert_eq!(kept.resumed_samples, mean);
    assert!(kept.resumed_seconds > 0.0 && kept.problem.is_none());
}

#[test]
fn what_is_of_another_picture_is_not_taken_up() {
    let folder = Folder::new("another");
    let settings = settings(48, 2);
    let job = start(&settings, Some(&folder.file()), "one", 1);
    finish(&job);
    let picture = bits(&job);
    let _ = job.end_checkpoints();
    for (fingerprint, is_damaged, said) in [("two", false, "another picture"), ("one", true, "damaged")] {
        if is_damaged {
            damage(&folder.file(), |bytes| bytes.truncate(bytes.len() / 2));
        }
        let job = start(&settings, Some(&folder.file()), fingerprint, 10_000);
        let kept = finish(&job);
        assert!(kept.problem.as_ref().unwrap().contains(said), "{kept:?}");
        assert_eq!(kept.resumed_samples, 0.0);
        assert!(bits(&job) == picture);
    }
    // Where nothing can be written it is said, and the picture is whole.
    let job = start(&settings, Some(&folder.0.join("none").join("file")), "one", 1);
    finish(&job);
    let _ = job.end_checkpoints();
    assert!(job.statistics().kept.unwrap().problem.unwrap().contains("cannot be written"));
    assert!(bits(&job) == picture);
}

fn damage(file: &Path, how: impl FnOnce(&mut Vec<u8>)) {
    let mut bytes = std::fs::read(file).unwrap();
    how(&mut bytes);
    std::fs::write(file, bytes).unwrap();
}

/// A checkpoint of a render that is done, and its picture.
fn kept_render(folder: &Folder, settings: &Settings) -> (Vec<Vec<f32>>, u64) {
    let job = start(settings, Some(&folder.file()), "one", 1);
    finish(&job);
    assert!(job.end_checkpoints().is_some());
    bits(&job)
}

/// Single bits are turned all over the file: it is never taken up, and the picture is that of a whole render.
#[test]
fn a_damaged_checkpoint_is_never_taken_up() {
    let folder = Folder::new("damaged");
    let settings = settings(48, 2);
    let picture = kept_render(&folder, &settings);
    let whole = std::fs::read(folder.file()).unwrap();
    // Not the magic: a file without it is none of ours.
    let places = (0..64).map(|i| MAGIC.len() + i * 7919 * (whole.len() - MAGIC.len()) / (64 * 7919));
    for place in places.chain([whole.len() - 1]) {
        let mut bytes = whole.clone();
        bytes[place] ^= 1 << (place % 8);
        std::fs::write(folder.file(), bytes).unwrap();
        let job = start(&settings, Some(&folder.file()), "one", 10_000);
        let kept = job.statistics().kept.unwrap();
        assert_eq!(kept.resumed_samples, 0.0, "byte {place}");
        assert!(kept.problem.is_some(), "byte {place}");
    }
    let job = start(&settings, Some(&folder.file()), "one", 10_000);
    finish(&job);
    assert!(bits(&job) == picture);
}

#[test]
fn a_file_that_is_no_checkpoint_is_left_as_it_is() {
    let folder = Folder::new("foreign");
    std::fs::write(folder.file(), "a text, or a scene").unwrap();
    let job = start(&settings(48, 2), Some(&folder.file()), "one", 1);
    assert!(job.wait(Duration::from_secs(60)));
    assert!(job.statistics().failure.unwrap().contains("it is no checkpoint"));
    assert!(job.end_checkpoints().is_none());
    assert_eq!(std::fs::read_to_string(folder.file()).unwrap(), "a text, or a scene");
    assert!(check_file(&folder.file()).is_err() && check_file(&folder.0).is_err());
    #[cfg(unix)]
    assert!(check_file(Path::new("/dev/zero")).is_err());
    // Nothing yet, as mktemp leaves it.
    std::fs::write(folder.file(), "").unwrap();
    kept_render(&folder, &settings(48, 2));
}

/// Two renders with one file: each removes only the file that it has written itself.
#[test]
fn a_checkpoint_of_another_render_is_not_deleted() {
    let folder = Folder::new("shared");
    let settings = settings(48, 2);
    let first = start(&settings, Some(&folder.file()), "one", 1);
    finish(&first);
    let own = first.end_checkpoints().unwrap();
    let second = start(&settings, Some(&folder.file()), "two", 1);
    finish(&second);
    let others = second.end_checkpoints().unwrap();
    assert!(!own.delete() && folder.file().exists());
    assert!(others.delete() && !folder.file().exists());
}

/// A header that says to be longer than any is refused before it is read.
#[test]
fn headers_are_bounded() {
    let folder = Folder::new("header");
    let mut bytes = MAGIC.to_vec();
    bytes.extend(u32::MAX.to_le_bytes());
    std::fs::write(folder.file(), bytes).unwrap();
    let job = start(&settings(48, 2), Some(&folder.file()), "one", 10_000);
    assert!(finish(&job).problem.unwrap().contains("damaged"));
}
