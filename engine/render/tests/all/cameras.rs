//! Cameras that many pictures share: the maps of a lens take longer than a small picture.

use petzval_render::camera::{Camera, CameraDescription};
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// The camera of a description, made at its first use. The lens file counts by its content.
pub(crate) fn camera(d: &CameraDescription, width: u32, height: u32) -> Camera {
    static MADE: Mutex<Option<HashMap<String, Camera>>> = Mutex::new(None);
    let lens = std::fs::read(&d.lens_path).unwrap_or_default();
    let key = format!("{d:?} {width} {height} {lens:?}");
    let made = |all: &mut Option<HashMap<String, Camera>>| all.get_or_insert_default().get(&key).cloned();
    // A test that has failed leaves the table whole.
    if let Some(found) = made(&mut MADE.lock().unwrap_or_else(PoisonError::into_inner)) {
        return found;
    }
    let camera = Camera::new(d, width, height).unwrap();
    MADE.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_default().insert(key, camera.clone());
    camera
}
