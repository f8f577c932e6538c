//! Pictures in a row: a range of time, a turn of the camera, or both; as PNG files, an animated PNG, or a GIF.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::RgbaImage;
use image::codecs::gif::{GifEncoder, Repeat};

use super::picture::{self, Extras};
use super::{ExportError, atomic, session_file};
use crate::render::display::effective_range;
use crate::scene::{Camera, Scene};
use crate::session::{Session, prepare};
use crate::task::{Cancelled, Task};
use crate::world::{TreeFile, World};

/// How the frames follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    pub count: u32,
    /// Frames a second.
    pub fps: u32,
    /// From the first frame's moment to the last one's, in seconds; `None`: time stands still.
    pub time: Option<[f32; 2]>,
    /// The camera turns around its target by so many degrees until where a frame after the last would be: so a whole turn
    /// goes on without a stop when it is shown again and again.
    pub turn_degrees: f32,
}

impl Frames {
    /// Most frames of one animation, and in a second.
    pub const MOST: u32 = 100_000;
    pub const MOST_FPS: u32 = 100;

    /// The moment of a frame, in seconds; `now` where time stands still.
    pub fn time_of(&self, index: u32, now: f32) -> f32 {
        let Some([from, to]) = self.time else { return now };
        // Both ends are shown.
        from + (to - from) * index as f32 / self.count.saturating_sub(1).max(1) as f32
    }

    /// Where the camera stands in a frame.
    pub fn camera_of(&self, index: u32, start: Camera) -> Camera {
        let mut camera = start;
        let angle = self.turn_degrees.to_radians() * index as f32 / self.count.max(1) as f32;
        if angle != 0.0 {
            camera.orbit(angle, 0.0);
        }
        camera
    }

    /// How long it lasts, in seconds.
    pub fn seconds(&self) -> f32 {
        self.count as f32 / self.fps.max(1) as f32
    }

    /// Frames of a time range that is shown as fast as it passes.
    pub fn in_real_time([from, to]: [f32; 2], fps: u32) -> u32 {
        (((to - from).abs() * fps as f32).round() as u32 + 1).clamp(2, Self::MOST)
    }
}

/// Kinds of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameFormat {
    /// A file a frame: the last run of `#` in the name is its number, from 1 on.
    Sequence,
    Apng,
    Gif,
}

impl FrameFormat {
    /// By the name of the file.
    ///
    /// # Errors
    /// [`ExportError::Write`] that names what is known.
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "png" if name.contains('#') => Ok(Self::Sequence),
            "png" | "apng" => Ok(Self::Apng),
            "gif" => Ok(Self::Gif),
            other => Err(ExportError::Write {
                path: path.to_owned(),
                reason: format!(
                    "the extension '{other}' is unknown; use frame-####.png for a file a frame, or an animated .png or .gif"
                ),
            }),
        }
    }
}

/// Why there is no animation.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError {
    #[error("cancelled; nothing was written")]
    Nothing,
    #[error("cancelled; {finished} of {count} frames are finished and stay, up to {}", last.display())]
    Part { finished: u32, count: u32, last: PathBuf },
    #[error(transparent)]
    Export(#[from] ExportError),
}

/// What an animation is of.
pub struct Stage<'a> {
    /// Size, samples and everything that does not move.
    pub session: &'a Session,
    /// The scene as it was loaded.
    pub still: &'a Arc<Scene>,
    /// The tree of the session's file, if it has one.
    pub tree: Option<&'a Arc<TreeFile>>,
    /// Of the first frame.
    pub camera: Camera,
    pub extras: Extras,
}

/// Renders the frames and writes them, each as soon as it is there. Progress is in frames.
///
/// # Errors
/// [`AnimationError`]. Of a single file nothing is written then; the finished frames of a sequence stay.
pub fn animate(stage: &Stage, frames: &Frames, path: &Path, task: &Task) -> Result<(), AnimationError> {
    let mut film = Filming { stage, frames, task, world: None, range: None, size: None };
    task.start(frames.count.into());
    match FrameFormat::of(path)? {
        FrameFormat::Sequence => film.sequence(path),
        FrameFormat::Apng => film.whole(path, |film, file| film.apng(file)),
        FrameFormat::Gif => film.whole(path, |film, file| film.gif(file)),
    }
}

/// The path of a frame, counted from 0.
fn path_of(path: &Path, index: u32) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let end = name.rfind('#').map_or(0, |at| at + 1);
    let start = name[..end].trim_end_matches('#').len();
    let number = format!("{:0width$}", index + 1, width = end - start);
    path.with_file_name(format!("{}{number}{}", &name[..start], &name[end..]))
}

/// Frames being made.
struct Filming<'a> {
    stage: &'a Stage<'a>,
    frames: &'a Frames,
    task: &'a Task,
    /// The last frame's; serves the next one if time stands still.
    world: Option<(f32, World)>,
    /// What colours mean in the first frame, they mean in all.
    range: Option<[f32; 2]>,
    /// Of the first frame; with a legend the others might need a line more or less.
    size: Option<[u32; 2]>,
}

/// Why a frame is not there.
enum Stop {
    Cancelled,
    Export(ExportError),
}

impl From<Cancelled> for Stop {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<ExportError> for Stop {
    fn from(error: ExportError) -> Self {
        Self::Export(error)
    }
}

impl Filming<'_> {
    /// A frame, and the session that it shows.
    fn frame(&mut self, index: u32) -> Result<(RgbaImage, Session), Cancelled> {
        let Stage { still, tree, camera, extras, .. } = *self.stage;
        let mut session = self.stage.session.clone();
        session.time = self.frames.time_of(index, session.time);
        let camera = self.frames.camera_of(index, camera);
        session.camera = Some(camera);
        // What does not move needs no new tree.
        let time = if still.is_animated() { session.time } else { 0.0 };
        let world = match self.world.take() {
            Some((of, world)) if of == time => world,
            before => {
                let scene = prepare::stage(still, &session);
                let moved =
                    before.map(|(_, before)| before.moved(&scene, &self.task.step())).transpose()?.flatten();
                match moved {
                    Some(world) => world,
                    None => World::of(scene, tree, session.build(), &self.task.step())?,
                }
            }
        };
        let film = picture::film(&session, &world, &camera, &self.task.step())?;
        if session.display.range.is_none() {
            self.range = self.range.or_else(|| effective_range(&film, &session.display));
            session.display.range = self.range;
        }
        let image = picture::of_film(&film, &session, &world, &camera, extras, &self.task.step())?;
        self.world = Some((time, world));
        let size = *self.size.get_or_insert([image.width(), image.height()]);
        let image = if [image.width(), image.height()] == size {
            image
        } else {
            let mut whole = RgbaImage::from_pixel(size[0], size[1], *image.get_pixel(0, image.height() - 1));
            image::imageops::replace(&mut whole, &image, 0, 0);
            whole
        };
        self.task.advance(1);
        Ok((image, session))
    }

    fn sequence(&mut self, path: &Path) -> Result<(), AnimationError> {
        for index in 0..self.frames.count {
            let Ok((image, session)) = self.frame(index) else {
                return Err(match index {
                    0 => AnimationError::Nothing,
                    _ => AnimationError::Part {
                        finished: index,
                        count: self.frames.count,
                        last: path_of(path, index - 1),
                    },
                });
            };
            session_file::save_picture(&image, &session, &path_of(path, index))?;
        }
        Ok(())
    }

    /// A file for all frames, whole or not at all.
    fn whole(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut Self, &mut dyn atomic::WriteSeek) -> Result<(), Stop>,
    ) -> Result<(), AnimationError> {
        let mut cancelled = false;
        let done = atomic::write_with(path, |file| match write(self, file) {
            Ok(()) => Ok(()),
            Err(Stop::Export(error)) => Err(error),
            Err(Stop::Cancelled) => {
                cancelled = true;
                Err(ExportError::Encode { reason: "cancelled".to_owned() })
            }
        });
        if cancelled { Err(AnimationError::Nothing) } else { Ok(done?) }
    }

    fn apng(&mut self, file: &mut dyn atomic::WriteSeek) -> Result<(), Stop> {
        let fail = |error: ::png::EncodingError| ExportError::Encode { reason: error.to_string() };
        let (first, _) = self.frame(0)?;
        let mut encoder = ::png::Encoder::new(file, first.width(), first.height());
        encoder.set_color(::png::ColorType::Rgba);
        encoder.set_depth(::png::BitDepth::Eight);
        encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(self.frames.count, 0).map_err(fail)?;
        encoder.set_frame_delay(1, self.frames.fps as u16).map_err(fail)?;
        let mut writer = encoder.write_header().map_err(fail)?;
        writer.write_image_data(first.as_raw()).map_err(fail)?;
        for index in 1..self.frames.count {
            let (image, _) = self.frame(index)?;
            writer.write_image_data(image.as_raw()).map_err(fail)?;
        }
        writer.finish().map_err(fail)?;
        Ok(())
    }

    /// A palette of 256 colours a frame; delays are in hundredths of a second.
    fn gif(&mut self, file: &mut dyn atomic::WriteSeek) -> Result<(), Stop> {
        /// Of 1 to 30: finer palettes cost more time than the pictures.
        const SPEED: i32 = 10;
        let fail = |error: image::ImageError| ExportError::Encode { reason: error.to_string() };
        let mut encoder = GifEncoder::new_with_speed(file, SPEED);
        encoder.set_repeat(Repeat::Infinite).map_err(fail)?;
        let delay = image::Delay::from_numer_denom_ms(1000, self.frames.fps.max(1));
        for index in 0..self.frames.count {
            let (image, _) = self.frame(index)?;
            encoder.encode_frame(image::Frame::from_parts(image, 0, 0, delay)).map_err(fail)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use image::AnimationDecoder as _;

    use super::*;
    use crate::render::View;
    use crate::scene::builtin;

    fn session() -> Session {
        let mut session = Session { view: View::NodesVisited, ..Session::default() };
        (session.render.width, session.render.height) = (24, 16);
        session
    }

    fn run(scene: &str, frames: Frames, path: &Path, task: &Task) -> Result<(), AnimationError> {
        let session = session();
        let still = Arc::new(builtin::make(scene).expect("a built-in scene"));
        let stage = Stage {
            session: &session,
            still: &still,
            tree: None,
            camera: still.camera,
            extras: Extras::default(),
        };
        animate(&stage, &frames, path, task)
    }

    const TURN: Frames = Frames { count: 4, fps: 10, time: None, turn_degrees: 360.0 };

    fn files(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_turn_comes_back_and_a_range_of_time_shows_both_ends() {
        let start = Camera::default();
        let eye = |index| TURN.camera_of(index, start).eye;
        assert_eq!(eye(0), start.eye);
        assert!(eye(2).distance(-start.eye) < 1e-4, "half way around: {}", eye(2));
        assert!(eye(4).distance(start.eye) < 1e-4, "the frame after the last is the first");
        let time = Frames { count: 5, fps: 25, time: Some([1.0, 3.0]), turn_degrees: 0.0 };
        assert_eq!([0, 2, 4].map(|i| time.time_of(i, 9.0)), [1.0, 2.0, 3.0]);
        assert_eq!(time.camera_of(3, start), start);
        assert_eq!(TURN.time_of(3, 9.0), 9.0);
        assert_eq!(Frames::in_real_time([0.0, 2.0], 25), 51);
    }

    #[test]
    fn frames_are_numbered_where_the_name_says() {
        for (name, expected) in
            [("f-####.png", "f-0008.png"), ("#a##.png", "#a08.png"), ("###x.png", "008x.png")]
        {
            assert_eq!(path_of(Path::new(name), 7), PathBuf::from(expected));
        }
        assert_eq!(path_of(Path::new("#.png"), 122), PathBuf::from("123.png"), "more digits than room");
    }

    #[test]
    fn a_sequence_has_a_file_a_frame_that_carries_its_moment() {
        let folder = tempfile::tempdir().expect("a folder");
        let time = Frames { count: 3, fps: 10, time: Some([0.0, 1.0]), turn_degrees: 0.0 };
        run("room", time, &folder.path().join("f-##.png"), &Task::new()).expect("written");
        assert_eq!(files(folder.path()), ["f-01.png", "f-02.png", "f-03.png"]);
        let open = |name| session_file::open(&folder.path().join(name)).expect("a session");
        let (first, last) = (open("f-01.png"), open("f-03.png"));
        assert_eq!((first.time, last.time), (0.0, 1.0));
        assert!(
            first.display.range.is_some() && first.display.range == last.display.range,
            "one range for all"
        );
        let pixels = |name| image::open(folder.path().join(name)).expect("a picture").into_rgba8();
        assert_ne!(pixels("f-01.png"), pixels("f-03.png"), "the scene moves");
    }

    #[test]
    fn animated_files_hold_all_frames_with_their_delay() {
        let folder = tempfile::tempdir().expect("a folder");
        let (png, gif) = (folder.path().join("a.png"), folder.path().join("a.gif"));
        run("cornell", TURN, &png, &Task::new()).expect("written");
        run("cornell", TURN, &gif, &Task::new()).expect("written");
        let read = |path: &Path| std::io::BufReader::new(std::fs::File::open(path).expect("a file"));
        let decoder =
            image::codecs::png::PngDecoder::new(read(&png)).expect("a PNG").apng().expect("animated");
        let frames = decoder.into_frames().collect_frames().expect("frames");
        assert_eq!(frames.len(), 4);
        assert_eq!(frames[1].delay().numer_denom_ms(), (100, 1));
        assert_ne!(frames[0].buffer(), frames[1].buffer());
        let decoder = image::codecs::gif::GifDecoder::new(read(&gif)).expect("a GIF");
        let frames = decoder.into_frames().collect_frames().expect("frames");
        assert_eq!((frames.len(), frames[0].buffer().dimensions()), (4, (24, 16)));
        assert_eq!(frames[0].delay().numer_denom_ms(), (100, 1));
    }

    #[test]
    fn a_cancel_leaves_nothing_half_written_and_keeps_finished_frames() {
        let folder = tempfile::tempdir().expect("a folder");
        let many = Frames { count: 50_000, ..TURN };
        for name in ["a.png", "a.gif"] {
            let cancelled = cancel_soon(&many, &folder.path().join(name));
            assert!(matches!(cancelled, AnimationError::Nothing), "{cancelled}");
        }
        assert!(files(folder.path()).is_empty());
        let cancelled = cancel_soon(&many, &folder.path().join("f-#.png"));
        let AnimationError::Part { finished, count: 50_000, .. } = cancelled else { panic!("{cancelled}") };
        assert_eq!(files(folder.path()).len(), finished as usize);
        assert!(cancelled.to_string().contains("stay"));
    }

    /// Cancels when some frames are finished.
    fn cancel_soon(frames: &Frames, path: &Path) -> AnimationError {
        let task = Task::new();
        let (other, frames, path) = (task.clone(), *frames, path.to_owned());
        let running = std::thread::spawn(move || run("cornell", frames, &path, &other));
        while task.fraction().is_none_or(|share| share < 3.0 / 50_000.0) {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        task.cancel();
        running.join().expect("no panic").expect_err("cancelled")
    }

    #[test]
    fn an_unknown_extension_is_refused_before_anything_is_rendered() {
        let message =
            run("cornell", TURN, Path::new("a.mp4"), &Task::new()).expect_err("unknown").to_string();
        assert!(message.contains("'mp4'") && message.contains("frame-####.png"), "{message}");
    }
}
