//! Pictures: that what is in front is seen, in its own colour, lit from where the light is; and the way back to the host.

use crate::support;
use glam::{Mat4, Vec2, Vec3, vec2, vec3};
use sinew::error::DeviceError;
use sinew::gpu::{Headless, readback};
use sinew::render::{
    Camera, ColorMesh, Direction, Frame, Light, Look, Picture, Renderer, Run, SkinMesh, Surface, Targets, View,
    vertex_buffer,
};
use sinew::rig::{Image, Material};
use std::sync::Arc;

const SIDE: u32 = 128;
const BOX: (Vec3, Vec3) = (Vec3::splat(-1.0), Vec3::splat(1.0));

/// A ball of that radius about `center`, with outward normals.
fn ball(center: Vec3, radius: f32, color: [f32; 3]) -> ColorMesh {
    const RINGS: u32 = 32;
    const AROUND: u32 = 48;
    let mut mesh = ColorMesh::default();
    for ring in 0..=RINGS {
        let (up, out) = (std::f32::consts::PI * ring as f32 / RINGS as f32).sin_cos();
        for k in 0..AROUND {
            let (sine, cosine) = (std::f32::consts::TAU * k as f32 / AROUND as f32).sin_cos();
            mesh.normals.push(Vec3::new(up * cosine, -out, up * sine));
            let [a, b] = [k, (k + 1) % AROUND].map(|k| ring * AROUND + k);
            if ring < RINGS {
                mesh.triangles.extend([[a, b + AROUND, b], [a, a + AROUND, b + AROUND]]);
            }
        }
    }
    mesh.positions = mesh.normals.iter().map(|n| center + *n * radius).collect();
    mesh.colors = vec![color; mesh.positions.len()];
    mesh
}

/// A square of side 2 in the plane `z`, texture upright, looking along +Z.
fn square(z: f32) -> ColorMesh {
    let positions = vec![vec3(-1.0, -1.0, z), vec3(1.0, -1.0, z), vec3(1.0, 1.0, z), vec3(-1.0, 1.0, z)];
    ColorMesh { positions, normals: vec![Vec3::Z; 4], colors: vec![[1.0; 3]; 4], triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

const SQUARE_UVS: [Vec2; 4] = [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)];

fn plain(color: [f32; 3]) -> Material {
    Material { base_color: [color[0], color[1], color[2], 1.0], ..Default::default() }
}

/// A mesh with its own vertices, ready to be drawn.
struct Thing {
    mesh: SkinMesh,
    vertices: wgpu::Buffer,
    model: Mat4,
}

/// Pipelines and targets of one test.
struct Studio<'a> {
    headless: &'a Headless,
    renderer: Renderer,
    targets: Targets,
}

impl<'a> Studio<'a> {
    fn new(headless: &'a Headless) -> Studio<'a> {
        let targets = Targets::new(headless, SIDE, SIDE).unwrap();
        Studio { headless, renderer: Renderer::new(&headless.device), targets }
    }

    fn thing_with(&self, shape: &ColorMesh, uvs: &[Vec2], material: Material, images: &[Image]) -> Thing {
        let look = Arc::new(Look::upload(self.headless, &self.renderer, &[material], images).unwrap());
        let runs = [Run { triangles: 0..shape.triangles.len() as u32, material: 0 }];
        let mesh = SkinMesh::upload(self.headless, &look, &shape.triangles, uvs, &runs).unwrap();
        let vertices = vertex_buffer(self.headless, &shape.positions, &shape.normals).unwrap();
        Thing { mesh, vertices, model: Mat4::IDENTITY }
    }

    fn thing(&self, shape: &ColorMesh, color: [f32; 3]) -> Thing {
        self.thing_with(shape, &vec![Vec2::ZERO; shape.positions.len()], plain(color), &[])
    }

    fn shot(&self, view: View, light: Light, from: Direction, things: &[&Thing], solids: &[ColorMesh]) -> Picture {
        let camera = Camera::frame(BOX, from, self.targets.aspect());
        let surfaces: Vec<Surface> =
            things.iter().map(|t| Surface { mesh: &t.mesh, vertices: t.vertices.slice(..), model: t.model }).collect();
        let frame = Frame { camera: &camera, view, light, surfaces: &surfaces, solids, marks: &[] };
        self.renderer.draw(self.headless, &self.targets, &frame).unwrap()
    }

    fn skin(&self, light: Light, things: &[&Thing]) -> Picture {
        self.shot(View::Skin, light, Direction::FRONT, things, &[])
    }
}

/// Mean byte of the red, green and blue of a rectangle.
fn brightness(picture: &Picture, (left, top): (u32, u32), (width, height): (u32, u32)) -> f32 {
    let mut sum = 0.0;
    for y in top..top + height {
        for x in left..left + width {
            sum += picture.pixel(x, y)[..3].iter().map(|&b| b as f32).sum::<f32>() / 3.0;
        }
    }
    sum / (width * height) as f32
}

/// Largest difference of a channel between two pixels.
fn distance(a: [u8; 4], b: [u8; 4]) -> u8 {
    a.iter().zip(b).map(|(x, y)| x.abs_diff(y)).max().unwrap()
}

fn center(picture: &Picture) -> [u8; 4] {
    picture.pixel(picture.width / 2, picture.height / 2)
}

#[test]
fn a_ball_covers_the_middle_and_leaves_the_corners() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let empty = studio.skin(Light::Studio, &[]);
    let picture = studio.skin(Light::Studio, &[&studio.thing(&ball(Vec3::ZERO, 1.0, [0.0; 3]), [0.6; 3])]);
    assert!(distance(center(&picture), center(&empty)) > 40);
    for (x, y) in [(0, 0), (SIDE - 1, 0), (0, SIDE - 1), (SIDE - 1, SIDE - 1)] {
        assert_eq!(picture.pixel(x, y), empty.pixel(x, y));
    }
    assert!(picture.rgba.chunks(4).all(|p| p[3] == 255));
    // On paper the same ball stands before white, which the studio's backdrop is not.
    let paper = studio.skin(Light::Paper, &[&studio.thing(&ball(Vec3::ZERO, 1.0, [0.0; 3]), [0.6; 3])]);
    assert_eq!((center(&paper), paper.pixel(0, 0)), (center(&picture), [255; 4]));
    assert_ne!(picture.pixel(0, 0), [255; 4]);
}

#[test]
fn the_key_light_comes_from_the_upper_left_front() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let ball = studio.thing(&ball(Vec3::ZERO, 1.0, [0.0; 3]), [0.6; 3]);
    let quarter = |p: &Picture, x, y| brightness(p, (x, y), (24, 24));
    for direction in [Direction::FRONT, Direction::SIDE, Direction { azimuth: 180.0, elevation: 20.0 }] {
        let lit = studio.shot(View::Skin, Light::Studio, direction, &[&ball], &[]);
        let (key, far) = (quarter(&lit, 36, 36), quarter(&lit, 68, 68));
        assert!(key > far + 40.0, "{key} against {far}");
        assert!(far > 20.0, "the far side is black: {far}");
    }
    // Companion: without lights there is nothing to tell the sides apart.
    let flat = studio.skin(Light::Flat, &[&ball]);
    assert_eq!(quarter(&flat, 36, 36), quarter(&flat, 68, 68));
}

#[test]
fn texture_colours_arrive() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let colors = [[200, 30, 60, 255], [20, 140, 90, 255], [5, 60, 220, 255], [128, 128, 128, 255]];
    let side = 64u32;
    let mut image = Image { width: side, height: side, rgba: Vec::new() };
    for y in 0..side {
        for x in 0..side {
            image.rgba.extend(colors[(2 * (y / 32) + x / 32) as usize]);
        }
    }
    let white = Material { base_color: [1.0; 4], texture: Some(0), ..Default::default() };
    let images = [image];
    let picture = studio.skin(Light::Flat, &[&studio.thing_with(&square(0.0), &SQUARE_UVS, white.clone(), &images)]);
    let (near, far) = (SIDE / 4 + 4, 3 * SIDE / 4 - 4);
    let seen = [(near, near), (far, near), (near, far), (far, far)].map(|(x, y)| picture.pixel(x, y));
    // Two bytes: one for the sampler's filtering of sRGB texels, one for rounding on the way out.
    for (seen, color) in seen.iter().zip(colors) {
        assert!(distance(*seen, color) <= 2, "{seen:?} for {color:?}");
    }
    // Companion: the neighbour's colour is not taken for one's own.
    assert!(seen.iter().zip(colors.iter().cycle().skip(1)).all(|(&s, &c)| distance(s, c) > 2));

    // The factor is linear: half the light of byte 200 is byte 147.
    let half = Material { base_color: [0.5, 0.5, 0.5, 1.0], ..white };
    let picture = studio.skin(Light::Flat, &[&studio.thing_with(&square(0.0), &SQUARE_UVS, half, &images)]);
    assert!(picture.pixel(near, near)[0].abs_diff(147) <= 2, "{:?}", picture.pixel(near, near));
}

#[test]
fn the_nearer_surface_wins_whatever_is_drawn_first() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let red = studio.thing(&square(0.5), [1.0, 0.0, 0.0]);
    let green = studio.thing(&square(-0.5), [0.0, 1.0, 0.0]);
    let from = |direction, things: &[&Thing]| center(&studio.shot(View::Skin, Light::Flat, direction, things, &[]));
    let behind = Direction { azimuth: 180.0, elevation: 0.0 };
    assert_eq!(from(Direction::FRONT, &[&red, &green]), [255, 0, 0, 255]);
    assert_eq!(from(Direction::FRONT, &[&green, &red]), [255, 0, 0, 255]);
    assert_eq!(from(behind, &[&red, &green]), [0, 255, 0, 255]);
}

#[test]
fn directions_see_the_sides_they_name() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let red = studio.thing(&ball(Vec3::Z * 0.6, 0.3, [0.0; 3]), [1.0, 0.0, 0.0]);
    let green = studio.thing(&ball(Vec3::X * 0.6, 0.3, [0.0; 3]), [0.0, 1.0, 0.0]);
    let shot = |direction| studio.shot(View::Skin, Light::Flat, direction, &[&red, &green], &[]);
    let front = shot(Direction::FRONT);
    assert_eq!(center(&front), [255, 0, 0, 255]);
    assert_eq!(front.pixel(SIDE - 40, SIDE / 2), [0, 255, 0, 255]);
    let side = shot(Direction::SIDE);
    assert_eq!(center(&side), [0, 255, 0, 255]);
    assert_eq!(side.pixel(40, SIDE / 2), [255, 0, 0, 255]);
}

#[test]
fn xray_shows_the_muscle_and_skin_hides_it() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let skin = studio.thing(&ball(Vec3::ZERO, 1.0, [0.0; 3]), [0.6; 3]);
    let muscle = [ball(Vec3::ZERO, 0.4, [0.8, 0.05, 0.05])];
    let shot =
        |view, solids: &[ColorMesh]| center(&studio.shot(view, Light::Studio, Direction::FRONT, &[&skin], solids));
    for view in [View::Xray, View::Muscles] {
        let (with, without) = (shot(view, &muscle), shot(view, &[]));
        assert!(distance(with, without) > 40, "{view:?}: {with:?} {without:?}");
        assert!(with[0] > with[1] + 40, "{view:?}: not red: {with:?}");
    }
    // Companion: the same muscle under opaque skin changes nothing.
    assert_eq!(shot(View::Skin, &muscle), shot(View::Skin, &[]));
    // Glass is denser at the edge than in the middle, and fainter where only muscles matter.
    let nothing = studio.skin(Light::Studio, &[]);
    let trace = |view, columns: std::ops::Range<u32>| {
        let picture = studio.shot(view, Light::Studio, Direction::FRONT, &[&skin], &[]);
        columns.map(|x| distance(picture.pixel(x, SIDE / 2), nothing.pixel(x, SIDE / 2))).max().unwrap()
    };
    let (edge, middle) = (0..SIDE / 4, SIDE / 2 - 2..SIDE / 2 + 2);
    assert!(trace(View::Xray, edge) > trace(View::Xray, middle.clone()) + 20);
    assert!(trace(View::Muscles, middle.clone()) + 4 < trace(View::Xray, middle));
}

#[test]
fn glass_is_the_front_most_layer_only() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let near = studio.thing(&square(0.5), [0.6; 3]);
    let far = studio.thing(&square(-0.5), [0.6; 3]);
    let shot = |things: &[&Thing]| center(&studio.shot(View::Xray, Light::Studio, Direction::FRONT, things, &[]));
    assert_eq!(shot(&[&far, &near]), shot(&[&near]));
    assert_ne!(shot(&[&near]), shot(&[]));
}

#[test]
fn marks_are_seen_through_all_else_but_not_on_skin() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let camera = Camera::frame(BOX, Direction::FRONT, 1.0);
    let wall = [ball(Vec3::ZERO, 1.0, [0.6; 3])];
    let red = ball(Vec3::NEG_Z * 0.6, 0.2, [1.0, 0.0, 0.0]);
    let nearer = ball(Vec3::NEG_Z * 0.2, 0.1, [0.0, 0.0, 1.0]);
    let shot = |view, marks: &[ColorMesh]| {
        let frame = Frame { camera: &camera, view, light: Light::Flat, surfaces: &[], solids: &wall, marks };
        studio.renderer.draw(&headless, &studio.targets, &frame).unwrap()
    };
    let without = shot(View::Muscles, &[]);
    assert_eq!(center(&without)[..2], [center(&without)[2]; 2], "a grey ball hides the middle");
    let marked = shot(View::Muscles, std::slice::from_ref(&red));
    assert_eq!(center(&marked), [255, 0, 0, 255]);
    assert_eq!(marked.pixel(SIDE / 2, SIDE / 4), without.pixel(SIDE / 2, SIDE / 4), "beside the mark");
    for marks in [[nearer.clone(), red.clone()], [red.clone(), nearer]] {
        assert_eq!(center(&shot(View::Muscles, &marks)), [0, 0, 255, 255], "marks hide one another");
    }
    assert_eq!(shot(View::Skin, &[red]).rgba, shot(View::Skin, &[]).rgba);
}

#[test]
fn edges_are_smooth() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let picture = studio.skin(Light::Flat, &[&studio.thing(&ball(Vec3::ZERO, 1.0, [0.0; 3]), [1.0; 3])]);
    // The backdrop stays below 110 and the ball is 255: what lies between is a pixel covered in part.
    let between = |p: &[u8]| (120..250).contains(&p[0]);
    let count = picture.rgba.chunks(4).filter(|p| between(p)).count();
    // The circle of radius 60 pixels crosses about 8 x 60 of them, some in full steps.
    assert!((150..600).contains(&count), "{count}");
    let inside = (48..80).flat_map(|y| (48..80).map(move |x| (x, y)));
    assert!(inside.into_iter().all(|(x, y)| picture.pixel(x, y) == [255; 4]));
}

#[test]
fn the_same_frame_gives_the_same_bytes() {
    let Some(headless) = support::gpu() else { return };
    let shot = |azimuth| {
        let studio = Studio::new(&headless);
        let skin = studio.thing(&ball(Vec3::ZERO, 0.9, [0.0; 3]), [0.6, 0.5, 0.4]);
        let muscle = [ball(Vec3::ZERO, 0.4, [0.8, 0.05, 0.05])];
        studio.shot(View::Xray, Light::Studio, Direction { azimuth, elevation: 10.0 }, &[&skin], &muscle)
    };
    let first = shot(30.0);
    assert_eq!(first, shot(30.0));
    assert_ne!(first, shot(31.0));
}

#[test]
fn mirrors_and_back_faces_are_lit_from_the_same_side() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let shape = ball(Vec3::ZERO, 1.0, [0.0; 3]);
    let upright = studio.skin(Light::Studio, &[&studio.thing(&shape, [0.6; 3])]);
    let apart = |other: &Picture| {
        let sum: u64 = upright.rgba.iter().zip(&other.rgba).map(|(a, b)| a.abs_diff(*b) as u64).sum();
        sum as f32 / upright.rgba.len() as f32
    };
    // Half a byte on average: the mirrored ball's facets lie elsewhere.
    let mirror = Mat4::from_scale(vec3(-1.0, 1.0, 1.0));
    let mirrored = Thing { model: mirror, ..studio.thing(&shape, [0.6; 3]) };
    assert!(apart(&studio.skin(Light::Studio, &[&mirrored])) < 0.5);
    // A mesh turned inside out, faces and normals both, is seen from its back.
    let mut inverted = shape.clone();
    inverted.normals.iter_mut().for_each(|n| *n = -*n);
    let wrong = apart(&studio.skin(Light::Studio, &[&studio.thing(&inverted, [0.6; 3])]));
    assert!(wrong > 5.0, "{wrong}");
    inverted.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert!(apart(&studio.skin(Light::Studio, &[&studio.thing(&inverted, [0.6; 3])])) < 0.5);
    // Without normals the faces' own are taken: facets, but the same light.
    let mut bare = shape;
    bare.normals.iter_mut().for_each(|n| *n = Vec3::ZERO);
    let faceted = apart(&studio.skin(Light::Studio, &[&studio.thing(&bare, [0.6; 3])]));
    assert!((0.01..3.0).contains(&faceted), "{faceted}");
}

#[test]
fn non_uniform_scale_turns_normals_rightly() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    // A ball pressed flat by the model matrix, against the same ellipsoid made of vertices.
    let scale = vec3(1.0, 0.8, 0.2);
    let shape = ball(Vec3::ZERO, 1.0, [0.0; 3]);
    let pressed = Thing { model: Mat4::from_scale(scale), ..studio.thing(&shape, [0.6; 3]) };
    let mut made = shape.clone();
    made.positions.iter_mut().for_each(|p| *p *= scale);
    made.normals.iter_mut().for_each(|n| *n = (*n / scale).normalize());
    let mut naive = made.clone();
    naive.normals = shape.normals;
    let shot = |t: &Thing| studio.skin(Light::Studio, &[t]);
    let worst = |a: &Picture, b: &Picture| a.rgba.iter().zip(&b.rgba).map(|(x, y)| x.abs_diff(*y)).max().unwrap();
    let exact = shot(&studio.thing(&made, [0.6; 3]));
    assert!(worst(&shot(&pressed), &exact) <= 3);
    assert!(worst(&shot(&studio.thing(&naive, [0.6; 3])), &exact) > 20);
}

#[test]
fn pictures_over_the_limit_are_refused_before_anything_is_allocated() {
    let Some(headless) = support::gpu() else { return };
    let most = headless.limits.max_texture_dimension_2d;
    for (width, height) in [(most + 1, 4), (4, u32::MAX), (0, 4), (4, 0)] {
        let error = Targets::new(&headless, width, height).err();
        assert_eq!(error, Some(DeviceError::PictureSize { width, height, had: most }));
    }
    headless.check().unwrap();
}

#[test]
fn meshes_that_point_nowhere_are_refused() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let upload =
        |materials: &[Material], images: &[Image]| Look::upload(&headless, &studio.renderer, materials, images);
    let torn = Image { width: 4, height: 4, rgba: vec![0; 60] };
    assert!(matches!(upload(&[], &[torn]), Err(DeviceError::Undrawable { what, .. }) if what == "texture 0"));
    let missing = Material { texture: Some(1), ..Default::default() };
    assert!(upload(&[missing], &[]).is_err_and(|e| e.to_string().contains("names texture 1 of 0")));

    let look = Arc::new(upload(&[plain([1.0; 3])], &[]).unwrap());
    let mesh = |triangles: &[[u32; 3]], run: std::ops::Range<u32>, material| {
        SkinMesh::upload(&headless, &look, triangles, &[Vec2::ZERO; 3], &[Run { triangles: run, material }])
    };
    assert!(mesh(&[[0, 1, 3]], 0..1, 0).is_err_and(|e| e.to_string().contains("[0, 1, 3] of 3 vertices")));
    assert!(mesh(&[[0, 1, 2]], 0..2, 0).is_err());
    assert!(mesh(&[[0, 1, 2]], 0..1, 1).is_err());
    let good = mesh(&[[0, 1, 2]], 0..1, 0).unwrap();

    let camera = Camera::frame(BOX, Direction::FRONT, 1.0);
    let draw = |vertices: &wgpu::Buffer, solids: &[ColorMesh]| {
        let surfaces = [Surface { mesh: &good, vertices: vertices.slice(..), model: Mat4::IDENTITY }];
        let frame =
            Frame { camera: &camera, view: View::Xray, light: Light::Studio, surfaces: &surfaces, solids, marks: &[] };
        studio.renderer.draw(&headless, &studio.targets, &frame)
    };
    let enough = vertex_buffer(&headless, &[Vec3::ZERO; 3], &[Vec3::Z; 3]).unwrap();
    let short = vertex_buffer(&headless, &[Vec3::ZERO; 2], &[Vec3::Z; 2]).unwrap();
    assert!(draw(&enough, &[]).is_ok());
    assert!(draw(&short, &[]).is_err_and(|e| e.to_string().contains("need 72 bytes, the buffer gives 48")));
    let mut torn = square(0.0);
    torn.triangles[0][2] = 4;
    assert!(draw(&enough, &[torn]).is_err());
    let mut colorless = square(0.0);
    colorless.colors.pop();
    assert!(draw(&enough, &[colorless]).is_err());
    assert!(vertex_buffer(&headless, &[Vec3::ZERO; 2], &[Vec3::Z; 3]).is_err());
    headless.check().unwrap();
}

#[test]
fn empty_meshes_draw_nothing() {
    let Some(headless) = support::gpu() else { return };
    let studio = Studio::new(&headless);
    let nothing = studio.thing(&ColorMesh::default(), [1.0; 3]);
    let shot = |things: &[&Thing], solids: &[ColorMesh]| {
        studio.shot(View::Xray, Light::Studio, Direction::FRONT, things, solids)
    };
    assert_eq!(shot(&[&nothing], &[ColorMesh::default()]), shot(&[], &[]));
}

#[test]
fn buffers_come_back_as_they_were() {
    let Some(headless) = support::gpu() else { return };
    let buffer = |words: &[u32], usage| {
        let size = words.len() as u64 * 4;
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let buffer = headless.device.create_buffer(&descriptor);
        headless.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words));
        buffer
    };
    let copied = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let words: Vec<u32> = (0..5000u32).map(|i| i.wrapping_mul(2_654_435_761)).collect();
    let source = buffer(&words, copied);
    assert_eq!(readback::read::<u32>(&headless, &source, ..).unwrap(), words);
    // A shorter read through the same staging memory holds nothing of the longer one.
    assert_eq!(readback::read::<u32>(&headless, &source, 7..=9).unwrap(), words[7..=9]);
    assert_eq!(readback::read::<[u32; 2]>(&headless, &source, 2499..).unwrap(), [[words[4998], words[4999]]]);
    assert_eq!(readback::read::<u32>(&headless, &source, 5000..).unwrap(), [0u32; 0]);
    assert_eq!(readback::read::<u16>(&headless, &source, 0..2).unwrap().len(), 2);

    assert!(matches!(readback::read::<u32>(&headless, &source, ..5001), Err(DeviceError::Readback { .. })));
    assert!(matches!(readback::read::<u16>(&headless, &source, 1..3), Err(DeviceError::Readback { .. })));
    let closed = buffer(&words[..4], wgpu::BufferUsages::COPY_DST);
    assert!(readback::read::<u32>(&headless, &closed, ..).is_err_and(|e| e.to_string().contains("COPY_SRC")));
    headless.check().unwrap();
}

#[test]
fn errors_of_the_device_are_kept_and_returned_once() {
    let Some(headless) = support::gpu() else { return };
    let most = headless.limits.max_buffer_size;
    let refused = headless.check_buffer_size("a test", most + 1);
    assert_eq!(refused, Err(DeviceError::BufferTooLarge { what: "a test".to_string(), needed: most + 1, had: most }));
    headless.check_buffer_size("a test", most).unwrap();
    let _ = headless.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::MAP_WRITE,
        mapped_at_creation: false,
    });
    let error = headless.check().unwrap_err();
    assert!(matches!(error, DeviceError::Invalid { .. }) && !error.to_string().contains('\n'), "{error}");
    headless.check().unwrap();
    headless.wait().unwrap();
}
