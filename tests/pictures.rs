//! Pictures against what is known of them: analytic answers, three estimators of the same light, reference pictures.

mod common {
    //! Small worlds, and means over their pictures.

    use std::sync::Arc;

    use bvhscope::accel::BuildConfig;
    use bvhscope::geometry::{Cuboid, Quad, Rigid, Shape, ShapeKind, Sphere, Torus};
    use bvhscope::render::film::FilmSubject;
    use bvhscope::render::pass::Pass;
    use bvhscope::render::path::{self, Estimator};
    use bvhscope::render::whitted::Whitted;
    use bvhscope::render::{CountKind, RenderSettings, View};
    use bvhscope::scene::{
        Camera, Color, Light, Material, MaterialKind, MeshTriangle, Scene, ShadowRule, ShapeSlot, Sky,
    };
    use bvhscope::task::Task;
    use bvhscope::world::World;
    use glam::{Quat, Vec3};
    use rayon::prelude::*;

    #[derive(Default)]
    pub struct Build {
        scene: Scene,
        materials: Vec<Material>,
    }

    impl Build {
        pub fn shape(&mut self, shape: Shape, kind: MaterialKind, color: Vec3) -> &mut Self {
            let scene = &mut self.scene;
            let index = match shape {
                Shape::Triangle(t) => {
                    let first = scene.mesh.positions.len() as u32;
                    scene.mesh.positions.extend(t.v);
                    let none = [MeshTriangle::NO_INDEX; 3];
                    let position = [first, first + 1, first + 2];
                    scene.mesh.triangles.push(MeshTriangle { position, normal: none, uv: none });
                    scene.mesh.triangles.len()
                }
                Shape::Sphere(s) => push(&mut scene.spheres, s),
                Shape::Cuboid(c) => push(&mut scene.cuboids, c),
                Shape::Quad(q) => push(&mut scene.quads, q),
                Shape::Torus(t) => push(&mut scene.tori, t),
            };
            if let MaterialKind::Emissive { .. } = kind {
                scene.lights.push(Light::Shape { shape: scene.shapes.len() as u32 });
            }
            scene.shapes.push(ShapeSlot { kind: shape.kind(), index: index as u32 - 1 });
            scene.shape_materials.push(self.materials.len() as u32);
            self.materials.push(Material { name: String::new(), color: Color::Solid(color), kind });
            self
        }

        pub fn light(&mut self, light: Light) -> &mut Self {
            self.scene.lights.push(light);
            self
        }

        pub fn sky(&mut self, radiance: f32) -> &mut Self {
            self.scene.sky = Sky { radiance: Vec3::splat(radiance) };
            self
        }

        pub fn world(&mut self) -> World {
            let mut scene = std::mem::take(&mut self.scene);
            scene.materials = Arc::new(std::mem::take(&mut self.materials));
            World::build(Arc::new(scene), &BuildConfig::default(), &Task::new()).expect("nobody cancels")
        }
    }

    fn push<T>(shapes: &mut Vec<T>, shape: T) -> usize {
        shapes.push(shape);
        shapes.len()
    }

    pub fn builtin(name: &str) -> World {
        let scene = bvhscope::scene::builtin::make(name).expect("a built-in scene");
        World::build(Arc::new(scene), &BuildConfig::default(), &Task::new()).expect("nobody cancels")
    }

    pub const MATT: MaterialKind = MaterialKind::Diffuse { reflectivity: 0.0 };
    pub const CLEAR: MaterialKind = MaterialKind::Glass { ior: 1.5, absorption: Vec3::ZERO };

    pub fn emissive(radiance: f32) -> MaterialKind {
        MaterialKind::Emissive { radiance: Vec3::splat(radiance) }
    }

    /// A quad about `center`, its outside along `edge_u x edge_v`.
    pub fn quad(center: Vec3, edge_u: Vec3, edge_v: Vec3) -> Quad {
        Quad { corner: center - 0.5 * (edge_u + edge_v), edge_u, edge_v }
    }

    pub fn sphere(center: Vec3, radius: f32) -> Shape {
        Shape::Sphere(Sphere { center, radius })
    }

    pub fn cuboid(center: Vec3, half_extent: Vec3) -> Shape {
        Shape::Cuboid(Cuboid { world_from_object: Rigid::new(Quat::IDENTITY, center), half_extent })
    }

    pub fn torus(center: Vec3) -> Shape {
        let world_from_object = Rigid::new(Quat::IDENTITY, center);
        Shape::Torus(Torus { world_from_object, major_radius: 0.6, minor_radius: 0.3 })
    }

    /// A large floor in y = 0 that looks up.
    pub fn floor() -> Shape {
        Shape::Quad(quad(Vec3::ZERO, Vec3::Z * 40.0, Vec3::X * 40.0))
    }

    /// Looks at `target` so closely that all pixels see as good as the same point.
    pub fn at_point(eye: Vec3, target: Vec3) -> Camera {
        Camera { eye, target, fov_y_degrees: 0.01, ..Camera::default() }
    }

    pub fn settings(size: [u32; 2], max_depth: u32) -> RenderSettings {
        RenderSettings { width: size[0], height: size[1], max_depth, ..RenderSettings::default() }
    }

    pub fn subject(view: View) -> FilmSubject {
        FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::Glass }
    }

    /// A mean with its standard error.
    #[derive(Clone, Copy, Debug)]
    pub struct Estimate {
        pub mean: f64,
        pub error: f64,
    }

    impl Estimate {
        /// Within four standard errors, which must be small enough for that to mean something.
        pub fn assert_is(&self, expected: f64, what: &str) {
            let Self { mean, error } = *self;
            assert!(error <= 0.02 * expected, "{what}: {mean} +- {error} says nothing about {expected}");
            let off = (mean - expected).abs();
            assert!(off <= 4.0 * error + 2e-4 * expected, "{what}: {mean} +- {error}, not {expected}");
        }

        pub fn assert_agrees(&self, other: &Self, what: &str) {
            let error = self.error.hypot(other.error);
            assert!(error <= 0.02 * self.mean, "{what}: {self:?} and {other:?} say nothing");
            assert!((self.mean - other.mean).abs() <= 4.0 * error, "{what}: {self:?} is not {other:?}");
        }
    }

    /// The green channel's mean over all pixels of 16 batches of `samples` samples.
    fn estimate(samples: u32, mean_of_sample: impl Fn(u32) -> f64 + Sync) -> Estimate {
        const BATCHES: u32 = 16;
        let batch =
            |b| (0..samples).map(|s| mean_of_sample(b * samples + s)).sum::<f64>() / f64::from(samples);
        let means: Vec<f64> = (0..BATCHES).into_par_iter().map(batch).collect();
        let n = f64::from(BATCHES);
        let mean = means.iter().sum::<f64>() / n;
        let variance = means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / (n - 1.0);
        Estimate { mean, error: (variance / n).sqrt() }
    }

    fn picture_mean(settings: &RenderSettings, pixel: impl Fn(u32, u32) -> Vec3) -> f64 {
        let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
        let sum: f64 = pixels.map(|(x, y)| f64::from(pixel(x, y).y)).sum();
        sum / f64::from(settings.width * settings.height)
    }

    pub fn path_mean(
        world: &World,
        camera: &Camera,
        settings: &RenderSettings,
        estimator: Estimator,
        samples: u32,
    ) -> Estimate {
        let size = [settings.width, settings.height];
        estimate(samples, |sample| {
            let pass = Pass::new(world, camera, size, settings, ShadowRule::Glass, sample);
            picture_mean(settings, |x, y| {
                path::radiance(&pass, estimator, pass.camera_ray(x, y), &mut pass.sampler(x, y), &mut ())
            })
        })
    }

    pub fn whitted_mean(world: &World, camera: &Camera, settings: &RenderSettings, samples: u32) -> Estimate {
        let size = [settings.width, settings.height];
        estimate(samples, |sample| {
            let pass = Pass::new(world, camera, size, settings, ShadowRule::Glass, sample);
            let rows = 0..settings.height;
            let pixels: Vec<_> = rows.flat_map(|y| (0..settings.width).map(move |x| [x, y])).collect();
            let mut whitted = Whitted::new(world);
            let found = whitted.radiance(&pass, &pixels, &mut (), &Task::new()).expect("nobody cancels");
            found.iter().map(|color| f64::from(color.y)).sum::<f64>() / found.len() as f64
        })
    }

    pub fn kinds_of(world: &World) -> Vec<ShapeKind> {
        world.scene.shapes.iter().map(|s| s.kind).collect()
    }
}

mod furnace {
    //! Where light is the same from everywhere, everything that absorbs nothing is as bright.

    use super::common::*;
    use bvhscope::geometry::Shape;
    use bvhscope::render::path::Estimator;
    use bvhscope::scene::{Camera, MaterialKind};
    use glam::Vec3;

    fn camera() -> Camera {
        Camera { eye: Vec3::new(0.0, 1.2, 2.2), target: Vec3::ZERO, fov_y_degrees: 30.0, ..Camera::default() }
    }

    fn check(shape: Shape, kind: MaterialKind, what: &str) {
        let world = Build::default().shape(shape, kind, Vec3::ONE).sky(1.0).world();
        for estimator in Estimator::ALL {
            let mean = path_mean(&world, &camera(), &settings([12, 12], 400), estimator, 8);
            mean.assert_is(1.0, &format!("{what}, {}", estimator.name()));
        }
    }

    #[test]
    fn under_a_white_dome_a_white_thing_is_white() {
        check(sphere(Vec3::ZERO, 0.8), MATT, "matt sphere");
        check(torus(Vec3::ZERO), MATT, "matt torus, lit by itself, too");
        check(
            cuboid(Vec3::ZERO, Vec3::splat(0.5)),
            MaterialKind::Diffuse { reflectivity: 0.4 },
            "glossy cuboid",
        );
    }

    #[test]
    fn under_a_white_dome_mirrors_and_glass_are_white() {
        check(torus(Vec3::ZERO), MaterialKind::Mirror, "mirror torus");
        check(sphere(Vec3::ZERO, 0.8), CLEAR, "glass sphere");
        check(cuboid(Vec3::ZERO, Vec3::splat(0.5)), CLEAR, "glass cuboid");
        check(torus(Vec3::ZERO), CLEAR, "glass torus");
    }

    #[test]
    fn in_a_glowing_room_everything_glows_as_bright() {
        let mut build = Build::default();
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for side in [-1.0, 1.0] {
                let normal = axis * side;
                let (u, v) = normal.any_orthonormal_pair();
                // Looks inwards.
                let (u, v) = if u.cross(v).dot(normal) < 0.0 { (u, v) } else { (v, u) };
                build.shape(Shape::Quad(quad(normal * 4.0, u * 8.0, v * 8.0)), emissive(1.0), Vec3::ONE);
            }
        }
        build.shape(sphere(Vec3::new(-0.6, 0.0, 0.0), 0.5), MATT, Vec3::ONE);
        build.shape(sphere(Vec3::new(0.6, 0.0, 0.0), 0.5), CLEAR, Vec3::ONE);
        build.shape(sphere(Vec3::new(0.0, 0.6, -0.6), 0.5), MaterialKind::Mirror, Vec3::ONE);
        let world = build.world();
        for estimator in Estimator::ALL {
            let mean = path_mean(&world, &camera(), &settings([12, 12], 400), estimator, 8);
            mean.assert_is(1.0, estimator.name());
        }
    }

    #[test]
    fn whitted_keeps_the_light_of_the_dome_too() {
        for (shape, kind, lost) in [
            (sphere(Vec3::ZERO, 0.8), MATT, 0.0),
            (cuboid(Vec3::ZERO, Vec3::splat(0.5)), MaterialKind::Mirror, 0.0),
            // Rays that weigh less than 1/512 are cut.
            (sphere(Vec3::ZERO, 0.8), CLEAR, 0.02),
        ] {
            let world = Build::default().shape(shape, kind, Vec3::ONE).sky(1.0).world();
            let mean = whitted_mean(&world, &camera(), &settings([16, 16], 30), 1).mean;
            assert!(mean <= 1.0 + 1e-5 && mean >= 1.0 - lost - 1e-5, "{kind:?}: {mean}");
        }
    }

    #[test]
    fn what_absorbs_is_darker_by_what_it_absorbs() {
        // Straight through a slab of index 1 and thickness 2, seen through a pinhole.
        let absorption = Vec3::new(0.1, 0.35, 2.0);
        let kind = MaterialKind::Glass { ior: 1.0, absorption };
        let slab = cuboid(Vec3::ZERO, Vec3::new(5.0, 5.0, 1.0));
        let world = Build::default().shape(slab, kind, Vec3::ONE).sky(3.0).world();
        let camera = at_point(Vec3::Z * 6.0, Vec3::ZERO);
        let expected = 3.0 * (-2.0f64 * 0.35).exp();
        whitted_mean(&world, &camera, &settings([4, 4], 10), 1).assert_is(expected, "whitted");
        for estimator in Estimator::ALL {
            let mean = path_mean(&world, &camera, &settings([4, 4], 10), estimator, 1);
            mean.assert_is(expected, estimator.name());
        }
    }
}

mod analytic {
    //! Lights over a floor, whose irradiance has a closed form.

    use super::common::*;
    use bvhscope::geometry::{Quad, Shape, ShapeKind, Triangle};
    use bvhscope::render::path::Estimator;
    use bvhscope::scene::{Camera, Light, MaterialKind};
    use bvhscope::world::World;
    use glam::Vec3;

    const ALBEDO: f32 = 0.8;

    fn camera() -> Camera {
        at_point(Vec3::new(3.0, 2.0, 1.0), Vec3::ZERO)
    }

    /// The form factor of a rectangle `width` x `height`, parallel to the receiver, its centre `distance` above
    /// (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3, four times).
    fn form_factor(width: f64, height: f64, distance: f64) -> f64 {
        let (a, b) = (0.5 * width / distance, 0.5 * height / distance);
        let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
        4.0 * (part(a, b) + part(b, a)) / std::f64::consts::TAU
    }

    fn over_floor(build: &mut Build) -> World {
        build.shape(floor(), MATT, Vec3::splat(ALBEDO)).world()
    }

    /// What no ray can hit is left to the estimators that sample lights.
    fn check(world: &World, expected: f64, can_be_hit: bool, what: &str) {
        whitted_mean(world, &camera(), &settings([16, 16], 4), 8)
            .assert_is(expected, &format!("{what}, whitted"));
        for estimator in Estimator::ALL {
            let mean = path_mean(world, &camera(), &settings([16, 16], 4), estimator, 32);
            let what = format!("{what}, {}", estimator.name());
            if can_be_hit || estimator != Estimator::Plain {
                mean.assert_is(expected, &what);
            } else {
                assert_eq!(mean.mean, 0.0, "{what}");
            }
        }
    }

    /// 2 x 3, looks down from y = 1.5.
    fn lamp() -> Quad {
        quad(Vec3::Y * 1.5, Vec3::X * 2.0, Vec3::Z * 3.0)
    }

    fn lamp_answer() -> f64 {
        f64::from(ALBEDO) * 5.0 * form_factor(2.0, 3.0, 1.5)
    }

    #[test]
    fn a_quad_light() {
        let world = over_floor(Build::default().shape(Shape::Quad(lamp()), emissive(5.0), Vec3::ONE));
        check(&world, lamp_answer(), true, "quad");
    }

    #[test]
    fn a_panel_lights_like_a_quad_but_is_not_there() {
        let panel = Light::Panel { quad: lamp(), radiance: Vec3::splat(5.0) };
        let world = over_floor(Build::default().light(panel));
        check(&world, lamp_answer(), false, "panel");
    }

    #[test]
    fn a_light_shines_from_its_outside_alone() {
        let mut away = lamp();
        std::mem::swap(&mut away.edge_u, &mut away.edge_v);
        let panel = Light::Panel { quad: away, radiance: Vec3::splat(5.0) };
        let build = &mut Build::default();
        let world = over_floor(build.shape(Shape::Quad(away), emissive(5.0), Vec3::ONE).light(panel));
        assert_eq!(whitted_mean(&world, &camera(), &settings([4, 4], 4), 1).mean, 0.0);
        for estimator in Estimator::ALL {
            assert_eq!(path_mean(&world, &camera(), &settings([4, 4], 4), estimator, 4).mean, 0.0);
        }
    }

    #[test]
    fn a_cuboid_light_directly_above_shows_its_lower_side_alone() {
        let light = cuboid(Vec3::Y * 2.0, Vec3::new(1.0, 0.5, 1.5));
        let world = over_floor(Build::default().shape(light, emissive(5.0), Vec3::ONE));
        check(&world, lamp_answer(), true, "cuboid");
    }

    #[test]
    fn a_sphere_light() {
        let world = over_floor(Build::default().shape(sphere(Vec3::Y * 2.0, 0.8), emissive(5.0), Vec3::ONE));
        check(&world, f64::from(ALBEDO) * 5.0 * (0.8f64 / 2.0).powi(2), true, "sphere");
    }

    #[test]
    fn a_point_light() {
        let light = Light::Point { position: Vec3::new(1.0, 2.0, -2.0), intensity: Vec3::splat(30.0) };
        let world = over_floor(Build::default().light(light));
        let expected = f64::from(ALBEDO) / std::f64::consts::PI * 30.0 / 9.0 * (2.0 / 3.0);
        check(&world, expected, false, "point");
    }

    #[test]
    fn lights_of_every_kind_add_up() {
        let small = sphere(Vec3::new(4.0, 3.0, 0.0), 0.5);
        let dim = Light::Point { position: Vec3::new(0.0, 1.0, 0.0), intensity: Vec3::splat(0.3) };
        let world = over_floor(Build::default().shape(Shape::Quad(lamp()), emissive(5.0), Vec3::ONE).shape(
            small,
            emissive(40.0),
            Vec3::ONE,
        ));
        let sphere_part = f64::from(ALBEDO) * 40.0 * (0.5f64 / 5.0).powi(2) * 0.6;
        // The way from the origin to the sphere passes the lamp's edge at a distance of about 1.
        check(&world, lamp_answer() + sphere_part, true, "quad and sphere");
        let world = over_floor(
            Build::default().light(dim).light(Light::Panel { quad: lamp(), radiance: Vec3::splat(5.0) }),
        );
        let point_part = f64::from(ALBEDO) / std::f64::consts::PI * 0.3;
        check(&world, lamp_answer() + point_part, false, "panel and point");
    }

    #[test]
    fn a_light_of_thousands_of_triangles_is_the_light_of_their_union() {
        let Quad { corner, edge_u, edge_v } = lamp();
        let mut build = Build::default();
        const N: usize = 40;
        for i in 0..N {
            for j in 0..N {
                // Rows of very different size, so that the picks must follow the area.
                let at = |i: usize, j: usize| {
                    let along = (i as f32 / N as f32).powi(2);
                    corner + along * edge_u + j as f32 / N as f32 * edge_v
                };
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                for v in [[a, b, c], [a, c, d]] {
                    build.shape(Shape::Triangle(Triangle { v }), emissive(5.0), Vec3::ONE);
                }
            }
        }
        let world = over_floor(&mut build);
        assert_eq!(kinds_of(&world).iter().filter(|k| **k == ShapeKind::Triangle).count(), 2 * N * N);
        check(&world, lamp_answer(), true, "mesh");
    }

    #[test]
    fn a_share_of_the_floor_mirrors() {
        // The camera sees the lamp in the floor, and the floor itself is black.
        let kind = MaterialKind::Diffuse { reflectivity: 0.3 };
        let world = Build::default()
            .shape(Shape::Quad(quad(Vec3::new(0.0, 2.0, -2.0), Vec3::X, Vec3::Z)), emissive(5.0), Vec3::ONE)
            .shape(floor(), kind, Vec3::ZERO)
            .world();
        let camera = at_point(Vec3::new(0.0, 2.0, 2.0), Vec3::ZERO);
        whitted_mean(&world, &camera, &settings([8, 8], 4), 1).assert_is(1.5, "whitted");
        for estimator in Estimator::ALL {
            let mean = path_mean(&world, &camera, &settings([16, 16], 4), estimator, 16);
            mean.assert_is(1.5, estimator.name());
        }
    }

    #[test]
    fn no_light_shades_itself_at_any_size_or_place() {
        use bvhscope::render::shadow::{ShadowAnswers, ShadowClass, answers_at};
        use bvhscope::scene::ShadowRule;
        for (scale, offset) in
            [(1.0, Vec3::ZERO), (1e-3, Vec3::ZERO), (1e4, Vec3::ZERO), (1.0, Vec3::new(900.0, -70.0, 333.0))]
        {
            let place = |shape: Shape| match shape {
                Shape::Quad(q) => Shape::Quad(Quad {
                    corner: q.corner * scale + offset,
                    edge_u: q.edge_u * scale,
                    edge_v: q.edge_v * scale,
                }),
                Shape::Sphere(s) => sphere(s.center * scale + offset, s.radius * scale),
                other => panic!("{other:?} is not placed here"),
            };
            let lights = [
                Shape::Quad(Quad { edge_u: Vec3::new(2.0, 0.3, 0.1), ..lamp() }),
                sphere(Vec3::new(0.3, 2.0, 0.1), 0.7),
            ];
            for light in lights {
                let world = over_floor_at(
                    Build::default().shape(place(light), emissive(5.0), Vec3::ONE),
                    place(floor()),
                );
                let camera = Camera {
                    eye: Vec3::new(0.0, 1.0, 6.0) * scale + offset,
                    target: Vec3::new(0.0, -2.0, 0.0) * scale + offset,
                    fov_y_degrees: 90.0,
                    ..Camera::default()
                };
                let settings = settings([60, 60], 1);
                let mut asked = 0;
                for pixel in (0..3600).map(|i| [i % 60, i / 60]) {
                    let answers = answers_at(&world, &camera, &settings, ShadowRule::Glass, pixel);
                    let Some(ShadowAnswers { class, .. }) = answers else { continue };
                    assert_eq!(class, ShadowClass::LitInBoth, "{light:?} at scale {scale}, pixel {pixel:?}");
                    asked += 1;
                }
                assert!(asked > 1000, "{asked} shadow rays are too few to tell");
            }
        }
    }

    fn over_floor_at(build: &mut Build, floor: Shape) -> World {
        build.shape(floor, MATT, Vec3::splat(ALBEDO)).world()
    }
}

mod estimators {
    //! Plain, next-event and MIS estimates of the same picture.

    use super::common::*;
    use bvhscope::geometry::Shape;
    use bvhscope::render::path::Estimator;
    use bvhscope::scene::{Camera, MaterialKind};
    use glam::Vec3;

    /// A box open to the viewer, lit through glass.
    fn room(build: &mut Build) {
        let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 4.0, Vec3::Z * 4.0);
        let mut wall = |center: Vec3, u: Vec3, v: Vec3, color: Vec3| {
            build.shape(Shape::Quad(quad(center, u, v)), MATT, color);
        };
        wall(Vec3::Y * -2.0, z, x, Vec3::new(0.7, 0.7, 0.7));
        wall(Vec3::Y * 2.0, x, z, Vec3::new(0.7, 0.7, 0.7));
        wall(Vec3::Z * -2.0, x, y, Vec3::new(0.7, 0.7, 0.7));
        wall(Vec3::X * -2.0, y, z, Vec3::new(0.7, 0.2, 0.2));
        wall(Vec3::X * 2.0, z, y, Vec3::new(0.2, 0.7, 0.2));
    }

    fn camera() -> Camera {
        Camera { eye: Vec3::Z * 6.0, target: Vec3::ZERO, fov_y_degrees: 35.0, ..Camera::default() }
    }

    fn check(build: &mut Build, samples: u32, what: &str) {
        let world = build.world();
        let estimates = Estimator::ALL.map(|estimator| {
            (estimator.name(), path_mean(&world, &camera(), &settings([16, 16], 8), estimator, samples))
        });
        for (name, estimate) in &estimates[1..] {
            estimate.assert_agrees(&estimates[0].1, &format!("{what}: plain and {name}"));
        }
    }

    #[test]
    fn agree_where_glass_is_before_the_light() {
        let mut build = Build::default();
        room(&mut build);
        let lamp = quad(Vec3::Y * 1.9, Vec3::X * 2.0, Vec3::Z * 2.0);
        build.shape(Shape::Quad(lamp), emissive(4.0), Vec3::ONE);
        let glass = MaterialKind::Glass { ior: 1.5, absorption: Vec3::splat(0.2) };
        build.shape(cuboid(Vec3::Y * 1.2, Vec3::new(1.3, 0.2, 1.3)), glass, Vec3::ONE);
        build.shape(sphere(Vec3::new(-0.8, -1.3, 0.0), 0.6), CLEAR, Vec3::ONE);
        check(&mut build, 48, "glass before the light");
    }

    #[test]
    fn agree_where_floors_are_glossy_and_lights_are_round() {
        let mut build = Build::default();
        room(&mut build);
        build.shape(sphere(Vec3::new(0.5, 1.0, 0.3), 0.6), emissive(5.0), Vec3::ONE);
        build.shape(torus(Vec3::new(-0.9, -0.5, 0.0)), emissive(2.0), Vec3::ONE);
        let glossy = MaterialKind::Diffuse { reflectivity: 0.5 };
        build.shape(
            Shape::Quad(quad(Vec3::Y * -1.9, Vec3::Z * 4.0, Vec3::X * 4.0)),
            glossy,
            Vec3::splat(0.6),
        );
        build.shape(sphere(Vec3::new(1.0, -1.2, 0.5), 0.6), MaterialKind::Mirror, Vec3::splat(0.9));
        check(&mut build, 32, "round lights over a glossy floor");
    }

    #[test]
    fn agree_where_the_sky_shines_beside_a_lamp() {
        let mut build = Build::default();
        build.shape(floor(), MATT, Vec3::splat(0.6));
        build.shape(cuboid(Vec3::Y * 0.5, Vec3::splat(0.5)), MATT, Vec3::splat(0.8));
        build.shape(sphere(Vec3::new(1.3, 0.5, 0.0), 0.5), CLEAR, Vec3::ONE);
        build.shape(sphere(Vec3::new(-2.0, 2.0, 0.0), 0.7), emissive(4.0), Vec3::ONE);
        check(build.sky(0.7), 16, "sky and lamp");
    }
}

mod films {
    //! What must hold of films of every view.

    use std::sync::Arc;

    use super::common::*;
    use bvhscope::accel::{BuildConfig, Probe, Width};
    use bvhscope::render::film::{Film, FilmSubject};
    use bvhscope::render::integrate::{add_sample, render};
    use bvhscope::render::measure::{count_rays, time_frame};
    use bvhscope::render::shadow::{ShadowClass, answers_at};
    use bvhscope::render::{CountKind, View};
    use bvhscope::scene::{ShadowRule, builtin};
    use bvhscope::task::{Cancelled, Task};
    use bvhscope::world::World;
    use glam::Vec2;

    #[test]
    fn every_view_is_the_same_at_any_thread_count() {
        let world = builtin("cornell");
        let settings = settings([37, 21], 6);
        for view in View::ALL {
            for count in CountKind::ALL {
                if count != CountKind::Camera && view.counter().is_none() {
                    continue;
                }
                let subject = FilmSubject { view, count, shadow_rule: ShadowRule::Glass };
                let films = [1, 2, 4].map(|threads| {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
                    let render = || render(subject, &world, &world.scene.camera, &settings, 2, &Task::new());
                    bits(&pool.install(render).expect("nobody cancels"))
                });
                assert!(films[0] == films[1] && films[0] == films[2], "{} {}", view.name(), count.name());
            }
        }
    }

    /// Sums bit by bit; NaN compares, too.
    fn bits(film: &Film) -> Vec<u32> {
        use bvhscope::render::film::FilmContent;
        match &film.content {
            FilmContent::Color(c) => c.iter().flat_map(|c| c.to_array()).map(f32::to_bits).collect(),
            FilmContent::Number(n) => n.iter().map(|n| n.to_bits()).collect(),
        }
    }

    #[test]
    fn seeds_make_other_pictures_of_the_same_scene() {
        let world = builtin("cornell");
        let pictures = [0, 1].map(|seed| {
            let settings = bvhscope::render::RenderSettings { seed, ..settings([16, 12], 4) };
            render(subject(View::Path), &world, &world.scene.camera, &settings, 1, &Task::new())
        });
        assert_ne!(pictures[0], pictures[1]);
    }

    #[test]
    fn a_cancelled_sample_leaves_the_film_as_it_was() {
        let world = builtin("cornell");
        let settings = settings([24, 16], 4);
        let mut film = Film::new(24, 16, subject(View::Path));
        add_sample(&mut film, &world, &world.scene.camera, &settings, &Task::new()).expect("nobody cancels");
        let before = film.clone();
        let task = Task::new();
        task.cancel();
        let answer = add_sample(&mut film, &world, &world.scene.camera, &settings, &task);
        assert_eq!((answer, &film), (Err(Cancelled), &before));
    }

    #[test]
    fn progress_ends_at_one() {
        let world = builtin("cornell");
        let task = Task::new();
        render(subject(View::Whitted), &world, &world.scene.camera, &settings([19, 17], 4), 3, &task)
            .expect("nobody cancels");
        assert_eq!(task.fraction(), Some(1.0));
    }

    #[test]
    fn heatmaps_and_figures_count_the_same_rays() {
        let world = builtin("bunny");
        let camera = &world.scene.camera;
        let settings = settings([40, 30], 6);
        let task = Task::new();
        let mut rays = 0;
        let mut nodes = 0.0;
        for count in CountKind::ALL {
            let figures = count_rays(&world, camera, &settings, count, 1, &task).expect("nobody cancels");
            let subject = FilmSubject { view: View::NodesVisited, count, shadow_rule: ShadowRule::Glass };
            let film = render(subject, &world, camera, &settings, 1, &task).expect("nobody cancels");
            let sum: f64 = film.numbers().expect("numbers").into_iter().map(f64::from).sum();
            let mean = figures.nodes_visited_mean.expect("the scene has rays of every kind");
            assert!((sum - mean * figures.ray_count as f64).abs() < 1e-6 * sum, "{}", count.name());
            let parts = figures.inner_visits_mean.unwrap_or(0.0) + figures.leaf_visits_mean.unwrap_or(0.0);
            assert!((parts - mean).abs() < 1e-9);
            if count == CountKind::Camera {
                assert_eq!(figures.ray_count, 1200);
            }
            if count == CountKind::All {
                assert_eq!(figures.ray_count, rays);
                assert!((sum - nodes).abs() < 1e-6 * sum);
            }
            rays += figures.ray_count;
            nodes += sum;
        }
    }

    /// The leaves that a ray visits, written down one by one.
    #[derive(Default)]
    struct Leaves(Vec<u32>);

    impl Probe for Leaves {
        fn inner_visited(&mut self, _: u32, _: u32) {}
        fn shapes_tested(&mut self, _: u32) {}
        fn leaf_visited(&mut self, leaf_idx: u32) {
            self.0.push(leaf_idx);
        }
    }

    #[test]
    fn lcv_is_the_deviation_of_the_leaves_that_single_rays_visit() {
        for (scene, width) in [("bunny", Width::W2), ("soup:300", Width::W8)] {
            let scene = Arc::new(builtin::make(scene).expect("a built-in scene"));
            let config = BuildConfig { width, ..BuildConfig::default() };
            let world = World::build(scene, &config, &Task::new()).expect("nobody cancels");
            let (camera, settings) = (&world.scene.camera, settings([48, 27], 6));
            let figures = count_rays(&world, camera, &settings, CountKind::Camera, 1, &Task::new());
            let frame = camera.frame(48, 27);
            let visits = |i: u32| {
                let mut leaves = Leaves::default();
                let pixel = Vec2::new((i % 48) as f32 + 0.5, (i / 48) as f32 + 0.5);
                world.intersect(&frame.ray(pixel), &mut leaves);
                let count = leaves.0.len();
                leaves.0.sort_unstable();
                leaves.0.dedup();
                assert_eq!(leaves.0.len(), count, "no leaf is visited twice");
                count as f64
            };
            let visits: Vec<f64> = (0..48 * 27).map(visits).collect();
            let mean = visits.iter().sum::<f64>() / visits.len() as f64;
            let variance = visits.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / visits.len() as f64;
            let lcv = figures.expect("nobody cancels").lcv.expect("rays were counted");
            assert!((lcv - variance.sqrt()).abs() < 1e-9 && lcv > 0.1, "{lcv} {}", variance.sqrt());
        }
    }

    #[test]
    fn a_stride_counts_a_part_of_the_rays() {
        let world = builtin("bunny");
        let camera = &world.scene.camera;
        let count = |stride| {
            count_rays(&world, camera, &settings([64, 40], 6), CountKind::Camera, stride, &Task::new())
                .expect("nobody cancels")
        };
        let (all, some) = (count(1), count(4));
        assert_eq!((all.ray_count, some.ray_count), (64 * 40, 16 * 10));
        let (all, some) = (all.nodes_visited_mean.expect("rays"), some.nodes_visited_mean.expect("rays"));
        assert!((some / all - 1.0).abs() < 0.3, "{some} of a part, {all} of all");
    }

    #[test]
    fn a_frame_is_timed_on_the_threads_of_the_pool_and_can_be_cancelled() {
        let world = builtin("cornell");
        let (camera, settings) = (&world.scene.camera, settings([160, 100], 6));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("a pool");
        let times =
            pool.install(|| time_frame(&world, camera, &settings, &Task::new())).expect("nobody cancels");
        assert!(times.traversal_ms > 0.0 && times.frames_per_s > 0.0);
        assert_eq!(times.threads, 3);
        let task = Task::new();
        task.cancel();
        assert_eq!(time_frame(&world, camera, &settings, &task), Err(Cancelled));
        assert_eq!(count_rays(&world, camera, &settings, CountKind::All, 1, &task), Err(Cancelled));
    }

    #[test]
    fn no_built_in_scene_is_dark_only_in_intersect() {
        for (name, _) in builtin::SCENES {
            let world = builtin(if name == "soup" { "soup:20000" } else { name });
            for rule in ShadowRule::ALL {
                let settings = settings([96, 60], 6);
                let mut counts = [0; 5];
                for pixel in (0..96 * 60).map(|i| [i % 96, i / 96]) {
                    let Some(answers) = answers_at(&world, &world.scene.camera, &settings, rule, pixel)
                    else {
                        counts[0] += 1;
                        continue;
                    };
                    counts[answers.class as usize] += 1;
                    let blocked = [answers.intersect.blocker, answers.filtered.blocker].map(|b| b.is_some());
                    assert_eq!(blocked[0], blocked[1], "{name}, {}, pixel {pixel:?}", rule.name());
                }
                assert_eq!(counts[ShadowClass::DarkOnlyInIntersect as usize], 0, "{name}, {}", rule.name());
                assert!(counts[ShadowClass::LitInBoth as usize] > 0, "{name} has no lit pixel: {counts:?}");
                if name == "bunny" {
                    assert!(counts[ShadowClass::DarkOnlyInOccluded as usize] > 20, "{counts:?}");
                }
            }
        }
    }

    #[test]
    fn the_class_view_shows_the_classes_of_the_answers() {
        let world = builtin("bunny");
        let settings = settings([48, 30], 6);
        let camera = &world.scene.camera;
        let film =
            |view| render(subject(view), &world, camera, &settings, 1, &Task::new()).expect("nobody cancels");
        let (classes, saved) = (film(View::ShadowDifference), film(View::ShadowSaving));
        for (x, y) in (0..48 * 30).map(|i| (i % 48, i / 48)) {
            let answers = answers_at(&world, camera, &settings, ShadowRule::Glass, [x, y]);
            let class = classes.number(x, y).and_then(ShadowClass::from_number);
            assert_eq!(class, Some(answers.map_or(ShadowClass::NotAsked, |a| a.class)));
            assert_eq!(saved.number(x, y), answers.map(|a| a.nodes_saved() as f32));
        }
    }
}

mod benchmark {
    //! Sets of rays.

    use super::common::*;
    use bvhscope::render::bench::{Query, RaySetKind, make_rays, trace_rays};
    use bvhscope::task::Task;

    #[test]
    fn answers_do_not_depend_on_the_threads() {
        let world = builtin("bunny");
        for kind in RaySetKind::ALL {
            let make = || make_rays(kind, &world, &world.scene.camera, &settings([60, 40], 6), &Task::new());
            let set = make().expect("nobody cancels");
            assert_eq!(set, make().expect("nobody cancels"));
            let (one, two) = (trace_rays(&world, &set, 1, false), trace_rays(&world, &set, 2, false));
            assert_eq!(one.answers, two.answers, "{}", kind.name());
            let in_packets = trace_rays(&world, &set, 2, true);
            assert_eq!(one.answers, in_packets.answers, "in packets, {}", kind.name());
            assert_eq!((one.hit_count, one.sum_t), (two.hit_count, two.sum_t));
            assert_eq!(one.ray_count, set.rays.len());
            assert!(one.hit_count > 0 && one.mrays_per_s().is_some_and(|r| r > 0.0));
            match set.query {
                // The room is closed.
                Query::Intersect => assert_eq!(one.hit_count, one.ray_count, "{}", kind.name()),
                Query::Occluded => assert!(one.answers.iter().all(|a| *a == 0.0 || *a == 1.0)),
            }
        }
    }

    #[test]
    fn no_rays_have_no_speed() {
        let world = builtin("cornell");
        let set = bvhscope::render::bench::RaySet { rays: Vec::new(), query: Query::Intersect };
        let result = trace_rays(&world, &set, 1, false);
        assert_eq!((result.ray_count, result.hit_count, result.mrays_per_s()), (0, 0, None));
    }
}

mod goldens {
    //! Reference pictures in `tests/goldens`. `UPDATE_GOLDENS=1 cargo test --test pictures goldens` writes them anew.

    use std::path::PathBuf;

    use super::common::*;
    use bvhscope::render::display::picture;
    use bvhscope::render::integrate::render;
    use bvhscope::render::{DisplaySettings, View};
    use bvhscope::task::Task;
    use image::RgbaImage;

    /// How far two pictures may be apart that ought to be the same.
    struct Tolerance {
        /// Pixels of which a channel is off by more than `CLEARLY`, at most.
        clearly_off: usize,
        /// The mean over all channels, in codes, at most.
        mean: f64,
    }

    /// Codes of 255.
    const CLEARLY: u8 = 12;

    /// Sines and roots of other platforms round differently, and a rounding may send a path another way.
    const OTHER_ROUNDING: Tolerance = Tolerance { clearly_off: 12, mean: 0.25 };

    fn check(scene: &str, view: View, samples: u32) {
        let world = builtin(scene);
        let film =
            render(subject(view), &world, &world.scene.camera, &settings([64, 40], 6), samples, &Task::new())
                .expect("nobody cancels");
        let image = picture(&film, &DisplaySettings::default());
        let name = format!("{scene}-{}.png", view.name());
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/goldens").join(&name);
        if std::env::var_os("UPDATE_GOLDENS").is_some() {
            image.save(&path).expect("tests/goldens can be written");
            return;
        }
        let golden = image::open(&path)
            .unwrap_or_else(|e| panic!("{}: {e}; UPDATE_GOLDENS=1 writes it", path.display()))
            .into_rgba8();
        compare(&image, &golden, &OTHER_ROUNDING, &name);
    }

    fn compare(image: &RgbaImage, golden: &RgbaImage, tolerance: &Tolerance, name: &str) {
        assert_eq!(image.dimensions(), golden.dimensions(), "{name}");
        let off = |a: &image::Rgba<u8>, b: &image::Rgba<u8>| (0..3).map(|c| a[c].abs_diff(b[c])).max();
        let clearly = image
            .pixels()
            .zip(golden.pixels())
            .filter(|(a, b)| off(a, b).is_some_and(|d| d > CLEARLY))
            .count();
        let sum: u64 = image.iter().zip(golden.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        let mean = sum as f64 / image.len() as f64;
        assert!(
            clearly <= tolerance.clearly_off && mean <= tolerance.mean,
            "{name}: {clearly} pixels clearly off, {mean:.3} codes in the mean"
        );
    }

    #[test]
    fn cornell_path() {
        check("cornell", View::Path, 32);
    }

    #[test]
    fn cornell_whitted() {
        check("cornell", View::Whitted, 4);
    }

    #[test]
    fn cornell_normal() {
        check("cornell", View::Normal, 1);
    }

    #[test]
    fn cornell_nodes_visited() {
        check("cornell", View::NodesVisited, 1);
    }

    #[test]
    fn room_whitted() {
        check("room", View::Whitted, 4);
    }

    #[test]
    fn bunny_whitted() {
        check("bunny", View::Whitted, 4);
    }

    #[test]
    fn bunny_shadow_difference() {
        check("bunny", View::ShadowDifference, 1);
    }
}
