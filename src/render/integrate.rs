//! Adds samples to a film: picks the integrator for the view and runs it over tiles.

use super::film::{Film, RenderSettings};
use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Adds one sample to every pixel: sample number `film.samples`. The result depends on world, camera, settings and that
/// number only, not on the number of threads. Runs in the current rayon pool.
///
/// # Errors
/// [`Cancelled`] when the task was; the film is then as before.
pub fn add_sample(
    film: &mut Film,
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<(), Cancelled> {
    let _ = (film, world, camera, settings, task);
    todo!()
}
