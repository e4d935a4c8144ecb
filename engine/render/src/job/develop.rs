//! Development of a picture once all its samples are there: stray light is computed and added.

use super::{Job, Shared, lock};
use crate::Rgb;
use crate::camera::CameraError;
use crate::stray::{Picture, Straight, StrayLight, StrayPass, Strays, Watch};
use rayon::ThreadPoolBuilder;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Job {
    /// Finds the stray light, by the picture as it is now, for [`Self::picture`] and [`Self::stray_pass`]; to be called after the
    /// end. [`Self::stop_developing`] ends it without a result.
    pub fn develop(&self, strays: &Strays) {
        let shared: &Shared = &self.shared;
        let stopped = || shared.stop_developing.load(Ordering::Relaxed);
        let tell = |part: f64| shared.developed.store(part.to_bits(), Ordering::Relaxed);
        let watch = Watch { stopped: &stopped, tell: &tell };
        if let Some(found) = self.with_picture(|straight| strays.find(straight, &watch)) {
            *lock(&shared.strayed) = Some(Arc::new(found));
        }
    }

    /// [`Strays::expected_times`] of the whole picture, by this small one.
    pub(super) fn expected_times(&self, strays: &Strays, of_this: &Strays) -> Vec<(StrayPass, f64)> {
        self.with_picture(|straight| strays.expected_times(of_this, straight))
    }

    /// Gives the picture as it is now to a function that runs on as many threads as the render had.
    fn with_picture<T: Send>(&self, find: impl FnOnce(&Straight<'_>) -> T + Send) -> T {
        let shared: &Shared = &self.shared;
        let (width, height) = shared.film.size();
        let light = self.straight().into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect();
        let picture = Picture { width, height, light };
        let (exposure, gains) = shared.film.scales();
        let straight = Straight { stage: &shared.stage, camera: self.camera(), picture: &picture, exposure, gains };
        self.on_threads(|| find(&straight))
    }

    /// The result of a function that runs on as many threads as the render had.
    pub fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        // Where there can be no more threads, this one does.
        match ThreadPoolBuilder::new().num_threads(self.threads.len()).build() {
            Ok(pool) => pool.install(work),
            Err(_) => work(),
        }
    }

    /// [`Self::develop`] with the decisions of the plan of [`Self::request`]; nothing where it simulates no stray light.
    ///
    /// # Errors
    /// [`CameraError`] where the lens cannot be traced for it.
    pub fn develop_as_planned(&self) -> Result<(), CameraError> {
        let Some((plan, camera)) = &self.stray_light else { return Ok(()) };
        let settings = self.settings();
        if let Some(stray_light) = plan.strays(camera, [settings.width, settings.height])? {
            self.develop(&stray_light);
        }
        Ok(())
    }

    /// The part of [`Self::develop`] that is done, 0 to 1.
    pub fn developed(&self) -> f64 {
        f64::from_bits(self.shared.developed.load(Ordering::Relaxed))
    }

    /// Ends [`Self::develop`] without a result.
    pub fn stop_developing(&self) {
        self.shared.stop_developing.store(true, Ordering::Relaxed);
    }

    /// The stray light that [`Self::develop`] found.
    pub fn strayed(&self) -> Option<Arc<StrayLight>> {
        lock(&self.shared.strayed).clone()
    }

    /// The whole picture as it is now, denoised if it was, with the stray light once that is found; rows from below.
    pub fn picture(&self) -> Vec<[f32; 4]> {
        self.with_strayed(self.straight())
    }

    /// The stray light laid over a picture, once it is found.
    pub(super) fn with_strayed(&self, mut picture: Vec<[f32; 4]>) -> Vec<[f32; 4]> {
        if let Some(strayed) = self.strayed() {
            strayed.add_to(&mut picture);
        }
        picture
    }

    /// A part of the stray light, rows from below; black where it was not found.
    pub fn stray_pass(&self, pass: StrayPass) -> Vec<Rgb> {
        let (width, height) = self.shared.film.size();
        let found = self.strayed().and_then(|strayed| strayed.part(pass).map(<[Rgb]>::to_vec));
        found.unwrap_or_else(|| vec![Rgb::ZERO; width as usize * height as usize])
    }
}
