//! The picture of a session as a file shows it: film, boxes over it, legend below it.

use image::RgbaImage;

use super::legend::Legend;
use crate::render::Film;
use crate::render::display::picture;
use crate::render::integrate::render;
use crate::render::overlay::{compose, draw_boxes, first_hit_distances};
use crate::scene::Camera;
use crate::session::Session;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// What a picture has beside its pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// The boxes, if the session shows any.
    pub overlay: bool,
    pub legend: bool,
}

/// The film of the session's size with the session's samples; 1 if it does not say.
///
/// # Errors
/// [`Cancelled`]
pub fn film(session: &Session, world: &World, camera: &Camera, task: &Task) -> Result<Film, Cancelled> {
    let samples = session.render.spp.unwrap_or(1);
    render(session.film_subject(), world, camera, &session.render, samples, task)
}

/// The picture of a film that was made so.
///
/// # Errors
/// [`Cancelled`]
pub fn of_film(
    film: &Film,
    session: &Session,
    world: &World,
    camera: &Camera,
    extras: Extras,
    task: &Task,
) -> Result<RgbaImage, Cancelled> {
    let mut image = picture(film, &session.display);
    if extras.overlay && session.overlay.depths.is_some() {
        let (width, height) = (film.width, film.height);
        let depth = first_hit_distances(world, camera, width, height, &task.step())?;
        let boxes = draw_boxes(world, camera, &session.overlay, &[], &depth, [width, height], &task.step())?;
        compose(&mut image, &boxes);
    }
    Ok(if extras.legend { Legend::of(session, film, world).below(&image) } else { image })
}
