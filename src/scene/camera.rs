//! The pinhole camera.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::geometry::{Aabb, Ray};

/// The world axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UpAxis {
    #[default]
    Y,
    Z,
}

impl UpAxis {
    pub const ALL: [Self; 2] = [Self::Y, Self::Z];

    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    pub fn vector(self) -> Vec3 {
        match self {
            Self::Y => Vec3::Y,
            Self::Z => Vec3::Z,
        }
    }

    /// Where somebody looks who stands upright in front of a model: along -Z where Y is up, along +Y where Z is.
    pub fn front(self) -> DVec3 {
        match self {
            Self::Y => DVec3::NEG_Z,
            Self::Z => DVec3::Y,
        }
    }

    /// To the right of somebody who looks to the front.
    fn side(self) -> DVec3 {
        self.front().cross(self.vector().as_dvec3())
    }
}

/// Position, target and vertical field of view in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    pub eye: Vec3,
    pub target: Vec3,
    pub fov_y_degrees: f32,
    pub up: UpAxis,
}

impl Default for Camera {
    fn default() -> Self {
        Self { eye: Vec3::new(0.0, 0.0, 5.0), target: Vec3::ZERO, fov_y_degrees: 45.0, up: UpAxis::Y }
    }
}

/// A camera prepared for a picture of a given size: unit vectors to the right, up and forward, and half the picture's
/// width and height at distance 1, where a pixel is `pixel_size` wide and high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFrame {
    pub eye: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    pub forward: Vec3,
    pub half_size: Vec2,
    pub pixel_size: Vec2,
    pub size: Vec2,
}

/// The least angle between the line of sight and the up axis that orbiting leaves, in radians.
const POLE_MARGIN: f64 = 1e-3;

/// How much nearer one step of [`Camera::dolly`] brings the eye.
const DOLLY_FACTOR: f64 = 0.9;

/// No part of a camera's position goes beyond this, so that distances within a scene never overflow.
const FARTHEST: f64 = 1e18;

impl Camera {
    /// The field of view that [`Camera::framing`] gives.
    const FRAMING_FOV_DEGREES: f32 = 40.0;

    /// Prepares for a picture of `width` x `height` pixels. Looking along the up axis picks any horizon; eye and target
    /// at the same place look ahead as [`UpAxis::front`] says. The answer is finite for every camera.
    pub fn frame(&self, width: u32, height: u32) -> CameraFrame {
        let (right, up, forward) = self.axes();
        let size = Vec2::new(width.max(1) as f32, height.max(1) as f32);
        let half_height = self.half_fov().tan() as f32;
        let half_size = Vec2::new(half_height * size.x / size.y, half_height);
        CameraFrame {
            eye: finite_or_zero(self.eye.as_dvec3()).as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            half_size,
            pixel_size: 2.0 * half_size / size,
            size,
        }
    }

    /// A camera that sees all of `bounds` in any picture at least as wide as high, from its front, slightly above and
    /// from the side. Bounds that are empty or a point are seen as a box of size 1 around it (or around the origin).
    pub fn framing(bounds: &Aabb, up: UpAxis) -> Self {
        let usable = bounds.is_finite() && !bounds.is_empty();
        let center = if usable { bounds.center().as_dvec3() } else { DVec3::ZERO };
        let mut half = if usable { bounds.max.as_dvec3() - center } else { DVec3::ZERO };
        if half.max_element() <= center.abs().max_element() * 1e-6 {
            half = DVec3::splat((center.abs().max_element() * 1e-4).max(0.5));
        }
        let towards_eye = (up.side() * 0.42 + up.vector().as_dvec3() * 0.36 - up.front()).normalize();
        let mut camera = Self {
            eye: (center + towards_eye * half.length()).as_vec3(),
            target: center.as_vec3(),
            fov_y_degrees: Self::FRAMING_FOV_DEGREES,
            up,
        };
        let (right, above) = axes_along(-towards_eye, up);
        let slope = camera.half_fov().tan() / 1.06;
        let corners = (0..8).map(|i| {
            let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            half * DVec3::new(sign(0), sign(1), sign(2))
        });
        let distance = corners.fold(0.0_f64, |distance, corner| {
            let aside = corner.dot(right).abs().max(corner.dot(above).abs());
            distance.max(aside / slope + corner.dot(towards_eye))
        });
        camera.eye = (center + towards_eye * distance).as_vec3();
        camera
    }

    /// A camera that sees a segment from the side, slightly from above, with room around it.
    pub fn aside(from: Vec3, to: Vec3, up: UpAxis) -> Self {
        let along = finite_or_zero((to - from).as_dvec3());
        let (right, above) = axes_along(along.try_normalize().unwrap_or(up.front()), up);
        let middle = finite_or_zero((0.5 * (from + to)).as_dvec3());
        let distance = along.length().max(1e-3 * middle.abs().max_element()).max(1e-6) * 1.5;
        let eye = middle + (right * 0.94 + above * 0.34) * distance;
        let fov_y_degrees = Self::FRAMING_FOV_DEGREES;
        Self { eye: eye.as_vec3(), target: middle.as_vec3(), fov_y_degrees, up }
    }

    /// Turns around the target by angles in radians: `yaw > 0` moves the eye to its right, `pitch > 0` upwards. Never
    /// over the pole.
    pub fn orbit(&mut self, yaw: f32, pitch: f32) {
        let (yaw, pitch) = (finite(yaw), finite(pitch));
        let (side, up, front) = (self.up.side(), self.up.vector().as_dvec3(), self.up.front());
        let (_, above, forward) = self.axes();
        let offset = -forward * self.distance();
        let height = offset.normalize().dot(up).clamp(-1.0, 1.0).asin();
        // Straight above or below the target, the heading is where the top of the picture points to.
        let level = if height.abs() < FRAC_PI_2 - POLE_MARGIN { offset } else { -above * height.signum() };
        let heading = level.dot(side).atan2(-level.dot(front)) + yaw;
        let limit = FRAC_PI_2 - POLE_MARGIN;
        let height = (height + pitch).clamp(-limit, limit);
        let direction = height.cos() * (heading.sin() * side - heading.cos() * front) + height.sin() * up;
        self.place_eye(direction * self.distance());
    }

    /// Moves eye and target together, in pixels of a picture `height` pixels high (x to the right, y down), so that the
    /// target follows the mouse.
    pub fn pan(&mut self, delta: Vec2, height: f32) {
        let (right, up, _) = self.axes();
        let unit = 2.0 * self.distance() * self.half_fov().tan() / f64::from(height.max(1.0));
        self.shift(unit * (up * finite(delta.y) - right * finite(delta.x)));
    }

    /// Moves towards the target (`steps > 0`) or away from it, never through it; a step is a tenth of the distance.
    pub fn dolly(&mut self, steps: f32) {
        let (_, _, forward) = self.axes();
        let distance = self.distance() * DOLLY_FACTOR.powf(finite(steps).clamp(-200.0, 200.0));
        self.place_eye(-forward * distance);
    }

    /// Flies: `motion` is along right, up, forward in scene units.
    pub fn fly(&mut self, motion: Vec3) {
        let (right, up, forward) = self.axes();
        let motion = motion.as_dvec3();
        self.shift(finite(motion.x) * right + finite(motion.y) * up + finite(motion.z) * forward);
    }

    /// From eye to target, in scene units; positive even where both are one point.
    fn distance(&self) -> f64 {
        let (eye, target) = (finite_or_zero(self.eye.as_dvec3()), finite_or_zero(self.target.as_dvec3()));
        eye.distance(target).max(Self::least_distance(target))
    }

    /// Nearer than this, single precision could not tell the eye from the target.
    fn least_distance(target: DVec3) -> f64 {
        (target.abs().max_element() * 1e-5).max(1e-20)
    }

    /// Half the vertical field of view in radians, within what a pinhole can show.
    fn half_fov(&self) -> f64 {
        let fov = f64::from(self.fov_y_degrees);
        let fov = if fov.is_finite() { fov.clamp(0.01, 179.0) } else { f64::from(Self::FRAMING_FOV_DEGREES) };
        0.5 * fov.to_radians()
    }

    /// Right, up and forward, of unit length.
    fn axes(&self) -> (DVec3, DVec3, DVec3) {
        let forward =
            (self.target.as_dvec3() - self.eye.as_dvec3()).try_normalize().unwrap_or(self.up.front());
        let (right, up) = axes_along(forward, self.up);
        (right, up, forward)
    }

    /// Puts the eye at `offset` from the target.
    fn place_eye(&mut self, offset: DVec3) {
        let target = finite_or_zero(self.target.as_dvec3());
        let length = offset.length().max(Self::least_distance(target));
        let offset = offset.normalize_or(-self.up.front()) * length;
        self.target = target.as_vec3();
        self.eye = (target + offset).clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST)).as_vec3();
    }

    /// Moves eye and target together.
    fn shift(&mut self, by: DVec3) {
        let offset = self.eye.as_dvec3() - self.target.as_dvec3();
        let target = finite_or_zero(self.target.as_dvec3()) + by;
        self.target = target.clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST)).as_vec3();
        self.place_eye(finite_or_zero(offset));
    }
}

/// Right and up, of unit length and at right angles to `forward`, which is.
fn axes_along(forward: DVec3, up: UpAxis) -> (DVec3, DVec3) {
    let right = forward.cross(up.vector().as_dvec3());
    // At the pole any horizon will do.
    let right = if right.length_squared() > 1e-18 { right.normalize() } else { up.side() };
    (right, right.cross(forward))
}

fn finite_or_zero(v: DVec3) -> DVec3 {
    if v.is_finite() { v } else { DVec3::ZERO }
}

fn finite(x: impl Into<f64>) -> f64 {
    let x = x.into();
    if x.is_finite() { x } else { 0.0 }
}

impl CameraFrame {
    /// The ray through a point of the picture, in pixels from the top left; unit direction.
    #[inline]
    pub fn ray(&self, pixel: Vec2) -> Ray {
        let at = pixel * self.pixel_size - self.half_size;
        Ray::new(self.eye, (self.forward + at.x * self.right - at.y * self.up).normalize())
    }

    /// Where a point lies: pixels from the top left, and the distance along `forward` (negative behind the camera).
    #[inline]
    pub fn project(&self, point: Vec3) -> Vec3 {
        let d = point - self.eye;
        let z = d.dot(self.forward);
        let x = d.dot(self.right) / (z * self.half_size.x);
        let y = d.dot(self.up) / (z * self.half_size.y);
        Vec3::new((x + 1.0) * 0.5 * self.size.x, (1.0 - y) * 0.5 * self.size.y, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_sound(camera: &Camera) {
        let f = camera.frame(640, 480);
        for v in [f.eye, f.right, f.up, f.forward] {
            assert!(v.is_finite(), "{camera:?} gives {f:?}");
        }
        for v in [f.right, f.up, f.forward] {
            assert!((v.length() - 1.0).abs() < 1e-5, "{camera:?} gives {f:?}");
        }
        assert!(f.right.dot(f.up).abs() < 1e-5 && f.right.dot(f.forward).abs() < 1e-5);
        assert!(f.half_size.is_finite() && f.half_size.min_element() > 0.0);
    }

    #[test]
    fn a_segment_is_seen_from_the_side() {
        for up in UpAxis::ALL {
            for (from, to) in
                [(Vec3::ZERO, Vec3::Z), (Vec3::ONE, Vec3::new(-3.0, 1.0, 2.0)), (Vec3::Y, -Vec3::Y)]
            {
                let camera = Camera::aside(from, to, up);
                assert_sound(&camera);
                let frame = camera.frame(600, 400);
                let [a, b] = [from, to].map(|p| frame.project(p));
                for p in [a, b] {
                    assert!((0.0..600.0).contains(&p.x) && (0.0..400.0).contains(&p.y) && p.z > 0.0);
                }
                assert!(a.truncate().distance(b.truncate()) > 100.0);
            }
            assert_sound(&Camera::aside(Vec3::ONE, Vec3::ONE, up));
        }
    }

    #[test]
    fn any_camera_has_a_sound_frame() {
        let points = [
            Vec3::ZERO,
            Vec3::Y,
            -Vec3::Z,
            Vec3::splat(f32::NAN),
            Vec3::splat(1e30),
            Vec3::splat(f32::INFINITY),
        ];
        for up in UpAxis::ALL {
            for eye in points {
                for target in points {
                    for fov in [-1.0, 0.0, 45.0, 180.0, f32::NAN] {
                        assert_sound(&Camera { eye, target, fov_y_degrees: fov, up });
                    }
                }
            }
        }
        let f = Camera::default().frame(0, 0);
        assert_eq!(f.size, Vec2::ONE);
    }

    #[test]
    fn a_ray_goes_where_its_point_projects_to() {
        let camera = Camera::framing(&Aabb::new(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)), UpAxis::Z);
        let frame = camera.frame(320, 200);
        for pixel in [Vec2::new(0.5, 0.5), Vec2::new(160.0, 100.0), Vec2::new(300.0, 20.0)] {
            let ray = frame.ray(pixel);
            let back = frame.project(ray.at(7.0));
            assert!((back.truncate() - pixel).length() < 1e-2, "{pixel} came back as {back}");
        }
    }

    #[test]
    fn framing_sees_every_corner_of_tiny_far_and_huge_boxes() {
        let boxes = [
            Aabb::new(Vec3::ZERO, Vec3::ONE),
            Aabb::new(Vec3::splat(-1e-6), Vec3::new(1e-6, 3e-6, 0.0)),
            Aabb::new(Vec3::new(-1e17, 0.0, -1e15), Vec3::new(1e17, 1e16, 1e17)),
            Aabb::new(Vec3::new(1000.0, 1000.0, 1000.0), Vec3::new(1001.0, 1000.0, 1005.0)),
        ];
        for up in UpAxis::ALL {
            for bounds in boxes {
                let frame = Camera::framing(&bounds, up).frame(100, 100);
                let mut extreme = 0.0_f32;
                for corner in bounds.corners() {
                    let p = frame.project(corner);
                    assert!(p.z > 0.0, "{bounds:?} is behind");
                    assert!(
                        p.x >= 0.0 && p.x <= 100.0 && p.y >= 0.0 && p.y <= 100.0,
                        "{corner} of {bounds:?} at {p}"
                    );
                    extreme = extreme.max((p.x - 50.0).abs()).max((p.y - 50.0).abs());
                }
                assert!(extreme > 35.0, "{bounds:?} is shown too small: {extreme}");
            }
        }
    }

    #[test]
    fn framing_nothing_or_a_point_is_sound() {
        for bounds in [
            Aabb::EMPTY,
            Aabb::new(Vec3::splat(5.0), Vec3::splat(5.0)),
            Aabb::new(Vec3::splat(f32::NAN), Vec3::ONE),
            Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY),
        ] {
            let camera = Camera::framing(&bounds, UpAxis::Y);
            assert_sound(&camera);
            assert!(camera.eye.distance(camera.target) > 0.1);
        }
    }

    #[test]
    fn orbit_keeps_the_distance_and_stops_at_the_pole() {
        for up in UpAxis::ALL {
            let mut camera =
                Camera { eye: Vec3::new(1.0, 2.0, 3.0), target: Vec3::X, fov_y_degrees: 45.0, up };
            let distance = camera.eye.distance(camera.target);
            for i in 0..200 {
                camera.orbit(0.3, if i < 100 { 0.4 } else { -0.4 });
                assert_sound(&camera);
                assert!((camera.eye.distance(camera.target) - distance).abs() < 1e-3);
                let up_share = camera.frame(1, 1).up.dot(up.vector());
                assert!(up_share > 0.0, "upside down");
            }
        }
    }

    #[test]
    fn orbit_turns_to_the_right_and_upwards() {
        let mut camera = Camera::default();
        camera.orbit(0.1, 0.0);
        assert!(camera.eye.x > 0.1 && camera.eye.y.abs() < 1e-6);
        camera.orbit(0.0, 0.1);
        assert!(camera.eye.y > 0.1);
    }

    #[test]
    fn orbit_leaves_the_pole_without_a_jump() {
        let mut camera = Camera { eye: Vec3::Y * 4.0, target: Vec3::ZERO, ..Camera::default() };
        let before = camera.frame(10, 10);
        camera.orbit(0.0, -0.01);
        let after = camera.frame(10, 10);
        assert!(before.right.dot(after.right) > 0.99, "{before:?} became {after:?}");
    }

    #[test]
    fn panning_moves_the_target_with_the_mouse() {
        let mut camera = Camera::default();
        let before = camera.frame(400, 300);
        let point = camera.target;
        camera.pan(Vec2::new(30.0, -20.0), 300.0);
        let after = camera.frame(400, 300);
        let (p, q) = (before.project(point), after.project(point));
        assert!((q.x - p.x - 30.0).abs() < 0.01 && (q.y - p.y + 20.0).abs() < 0.01, "{p} moved to {q}");
    }

    #[test]
    fn dolly_never_goes_through_the_target() {
        let mut camera = Camera { target: Vec3::new(3.0, 0.0, 1.0), ..Camera::default() };
        let forward = camera.frame(1, 1).forward;
        for _ in 0..500 {
            camera.dolly(5.0);
            assert_sound(&camera);
            assert_ne!(camera.eye, camera.target);
        }
        assert!(camera.frame(1, 1).forward.dot(forward) > 0.9);
        for _ in 0..500 {
            camera.dolly(-5.0);
            assert_sound(&camera);
        }
        camera.dolly(f32::NAN);
        assert_sound(&camera);
    }

    #[test]
    fn flying_moves_eye_and_target_alike() {
        let mut camera = Camera::default();
        camera.fly(Vec3::new(1.0, 2.0, 3.0));
        assert!((camera.eye - Vec3::new(1.0, 2.0, 2.0)).length() < 1e-5);
        assert!((camera.target - Vec3::new(1.0, 2.0, -3.0)).length() < 1e-5);
    }
}
