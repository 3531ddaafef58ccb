use super::super::{
    DeformError, DeformInput, DeformMethod, DeformParams, Deformed, LandmarkTarget, deform,
};
use crate::data::{Cloud, Mesh, Topology};
use crate::math::{Vec3, percentile};
use crate::spatial::SurfaceIndex;

fn nicp() -> DeformParams {
    DeformParams { method: DeformMethod::Nicp, ..Default::default() }
}

/// Another head: larger, bent smoothly by some millimetres, and with a bump 12 mm wide that the
/// vertices of the template do not resolve.
fn subject(template: &Mesh) -> Mesh {
    let bent = |p: &Vec3| {
        let q = p * 1.05;
        let wave = Vec3::new((q.y / 40.0).sin(), (q.x / 50.0).cos(), (q.x / 35.0).sin()) * 2.5;
        let bump = 2.0 * (-((q.x - 25.0).powi(2) + (q.y + 20.0).powi(2)) / 72.0).exp();
        q + wave + Vec3::new(0.0, 0.0, if q.z > 0.0 { bump } else { 0.0 })
    };
    template.with_vertices(template.vertices.iter().map(bent).collect())
}

/// Dense points on the front of a head: noise of 0.1 mm, every `wrong`th point 5 to 20 mm off.
fn scan(truth: &Mesh, wrong: usize) -> Cloud {
    let normals = truth.vertex_normals();
    let mut cloud = Cloud::default();
    let mut count = 0;
    for face in &truth.faces {
        let corners = face.map(|v| truth.vertices[v as usize]);
        let n: Vec3 = face.iter().map(|&v| normals[v as usize]).sum::<Vec3>().normalize();
        if n.z < 0.35 || corners[0].z < 0.0 || corners[0].y < -100.0 {
            continue;
        }
        for [a, b] in [[0.2, 0.2], [0.6, 0.2], [0.2, 0.6], [0.33, 0.33]] {
            count += 1;
            let t = f64::from(count);
            let noise = 0.1 * ((t * 12.99).sin() + (t * 78.23).sin());
            let off = if (count as usize).is_multiple_of(wrong) {
                12.0 + 8.0 * (t * 0.7).sin()
            } else {
                0.0
            };
            let p = corners[0] * (1.0 - a - b) + corners[1] * a + corners[2] * b;
            cloud.points.push(p + n * (noise + off));
            cloud.normals.push(n);
            cloud.sigmas.push(0.1);
        }
    }
    cloud
}

fn fit(template: &Mesh, data: &Cloud) -> Deformed {
    let input = DeformInput { template, data, assignments: &[], landmarks: &[], outlines: &[] };
    deform(&input, &nicp(), &()).unwrap()
}

#[test]
fn a_scanned_head_is_fitted_without_spikes_and_the_rest_keeps_its_shape() {
    let template = crate::template::head().mesh;
    let truth = subject(&template);
    let data = scan(&truth, 20); // 5 % wrong points
    let fitted = fit(&template, &data);
    fitted.mesh.validate().unwrap();
    assert!(fitted.rms_after < 0.3 * fitted.rms_before);
    assert!(fitted.mesh.vertices.len() > template.vertices.len());

    // the true surface to the mesh, where it was scanned
    let clean = scan(&truth, usize::MAX);
    let index = SurfaceIndex::new(&fitted.mesh).unwrap();
    let far: Vec<f64> = clean.points.iter().map(|p| index.closest(p).unwrap().distance).collect();
    let (median, p99) = (percentile(&far, 0.5).unwrap(), percentile(&far, 0.99).unwrap());
    assert!(median < 0.1, "median {median}");
    assert!(p99 < 1.0, "p99 {p99}");

    // no spikes: each measured vertex lies near the truth
    let true_index = SurfaceIndex::new(&truth).unwrap();
    let normals = fitted.mesh.vertex_normals();
    let off: Vec<f64> = (0..fitted.mesh.vertices.len())
        .filter(|&v| normals[v].z > 0.6 && fitted.mesh.vertices[v].z > 40.0)
        .filter(|&v| fitted.mesh.vertices[v].y > -80.0)
        .map(|v| true_index.closest(&fitted.mesh.vertices[v]).unwrap().distance)
        .collect();
    assert!(off.len() > 3000);
    assert!(percentile(&off, 0.99).unwrap() < 1.0, "{:?}", percentile(&off, 0.99));

    // the back of the head, without data: of the subject's size within some millimetres, and smooth
    let back: Vec<f64> = (0..template.vertices.len())
        .filter(|&v| template.vertices[v].z < -40.0 && template.vertices[v].y > 0.0)
        .map(|v| (fitted.mesh.vertices[v] - truth.vertices[v]).norm())
        .collect();
    assert!(back.len() > 100);
    assert!(percentile(&back, 1.0).unwrap() < 12.0, "{:?}", percentile(&back, 1.0));
    let edge_growth = |mesh: &Mesh| {
        let topology = Topology::new(&template);
        let mut worst = 0.0f64;
        for (v, near) in topology.neighbours.iter().enumerate() {
            for &n in near.iter().filter(|_| template.vertices[v].z < -40.0) {
                let old = (template.vertices[v] - template.vertices[n as usize]).norm();
                let new = (mesh.vertices[v] - mesh.vertices[n as usize]).norm();
                worst = worst.max((new / old / 1.05).ln().abs());
            }
        }
        worst
    };
    assert!(edge_growth(&fitted.mesh) < 0.25, "{}", edge_growth(&fitted.mesh));
}

/// Largest distance between the template's own vertices in two fits, among those chosen.
fn apart(one: &Mesh, other: &Mesh, chosen: impl Fn(&Vec3) -> bool) -> f64 {
    let template = crate::template::head().mesh;
    let pairs = template.vertices.iter().enumerate().filter(|(_, p)| chosen(p));
    pairs.map(|(v, _)| (one.vertices[v] - other.vertices[v]).norm()).fold(0.0, f64::max)
}

#[test]
fn the_neck_without_data_stays_round() {
    let template = crate::template::head().mesh;
    // the jaw slopes away from the template's by up to 12 mm: a plate alone would continue to 40 mm
    // at the border
    let sloped = |p: &Vec3| {
        let low = (-60.0 - p.y).clamp(0.0, 40.0);
        p + Vec3::new(0.0, 0.0, if p.z > 0.0 { 0.3 * low } else { 0.0 })
    };
    let truth = template.with_vertices(template.vertices.iter().map(sloped).collect());
    let fitted = fit(&template, &scan(&truth, 20)).mesh;
    let topology = Topology::new(&template);
    let border: Vec<usize> = (0..topology.border.len()).filter(|&v| topology.border[v]).collect();
    assert!(border.len() > 20);
    let far = border.iter().map(|&v| (fitted.vertices[v] - template.vertices[v]).norm());
    let far = far.fold(0.0, f64::max);
    // 12 mm of the slope, and 3
    assert!(far < 15.0, "{far}");
    for (v, near) in topology.neighbours.iter().enumerate() {
        for &n in near.iter().filter(|&&n| topology.border[v] && topology.border[n as usize]) {
            let old = (template.vertices[v] - template.vertices[n as usize]).norm();
            let new = (fitted.vertices[v] - fitted.vertices[n as usize]).norm();
            assert!((new / old).ln().abs() < 0.15, "{old} {new}");
        }
    }
}

#[test]
fn a_lower_nose_keeps_its_width() {
    let template = crate::template::head().mesh;
    // the nose's height above the cheeks shrinks by 45 %
    let tip = template.vertices.iter().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
    let (top, cheek) = (tip.y, tip.z - 28.0);
    let lower = |p: &Vec3| {
        let near = (-((p.y - top - 10.0) / 45.0).powi(4) - (p.x / 30.0).powi(4)).exp();
        p - Vec3::new(0.0, 0.0, 0.45 * near * (p.z - cheek).max(0.0))
    };
    let truth = template.with_vertices(template.vertices.iter().map(lower).collect());
    let fitted = fit(&template, &scan(&truth, 20)).mesh;
    let index = SurfaceIndex::new(&truth).unwrap();
    let ridge: Vec<f64> = (0..template.vertices.len())
        .filter(|&v| {
            let p = template.vertices[v];
            p.x.abs() < 12.0 && (top + 5.0..top + 40.0).contains(&p.y) && p.z > cheek + 5.0
        })
        .map(|v| index.closest(&fitted.vertices[v]).unwrap().distance)
        .collect();
    assert!(ridge.len() > 50, "{}", ridge.len());
    let worst = percentile(&ridge, 1.0).unwrap();
    assert!(worst < 0.5, "{worst}");
}

#[test]
fn a_stray_component_of_the_data_does_not_move_the_scalp() {
    let template = crate::template::head().mesh;
    // above the forehead there is only one patch of data, 9 mm off the head
    let whole = scan(&subject(&template), usize::MAX);
    let mut clean = Cloud::default();
    let mut stray = Cloud::default();
    for (p, n) in whole.points.iter().zip(&whole.normals) {
        let patch = (70.0..95.0).contains(&p.y) && p.x.abs() < 18.0;
        let (to, position) = if patch { (&mut stray, p + n * 9.0) } else { (&mut clean, *p) };
        if patch || p.y < 55.0 {
            to.points.push(position);
            to.normals.push(*n);
            to.sigmas.push(0.1);
        }
    }
    assert!(stray.points.len() > 100, "{}", stray.points.len());
    let without = fit(&template, &clean).mesh;
    clean.points.extend(stray.points);
    clean.normals.extend(stray.normals);
    clean.sigmas.extend(stray.sigmas);
    let worst = apart(&fit(&template, &clean).mesh, &without, |p| p.y > 60.0);
    assert!(worst < 1.0, "{worst}");
}

#[test]
fn subdivision_keeps_texture_coordinates_and_threads_do_not_change_the_result() {
    let template = crate::template::head().mesh;
    let data = scan(&subject(&template), 25);
    let fitted = fit(&template, &data);
    assert_eq!(fitted.mesh.face_uvs.len(), fitted.mesh.faces.len());
    assert_eq!(fitted.mesh.uvs[..template.uvs.len()], template.uvs[..]);
    let area = |mesh: &Mesh| -> f64 {
        let cross = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|i| mesh.uvs[i as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        };
        mesh.face_uvs.iter().map(|f| cross(f).abs() / 2.0).sum()
    };
    assert!((area(&fitted.mesh) - area(&template)).abs() < 1e-9);
    let topology = Topology::new(&fitted.mesh);
    assert_eq!(topology.non_manifold_edges, 0);
    // an edge split on one side only would be a new border
    let borders = |t: &Topology| t.border.iter().filter(|b| **b).count();
    assert_eq!(borders(&topology), borders(&Topology::new(&template)));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = one.install(|| fit(&template, &data));
    assert_eq!(again, fitted);
}

#[test]
fn the_template_vertices_come_first_and_alone_without_subdivision() {
    let template = crate::template::head().mesh;
    let truth = subject(&template);
    let data = scan(&truth, 25);
    let mut params = nicp();
    params.nicp.subdivide = false;
    let input = DeformInput {
        template: &template,
        data: &data,
        assignments: &[],
        landmarks: &[],
        outlines: &[],
    };
    let fixed = deform(&input, &params, &()).unwrap().mesh;
    assert_eq!(fixed.faces, template.faces);
    assert_eq!(fixed.vertices.len(), template.vertices.len());
    // the detail step has still moved them onto the surface
    let index = SurfaceIndex::new(&truth).unwrap();
    let off: Vec<f64> = (0..template.vertices.len())
        .filter(|&v| template.vertices[v].z > 60.0 && template.vertices[v].y.abs() < 60.0)
        .map(|v| index.closest(&fixed.vertices[v]).unwrap().distance)
        .collect();
    assert!(percentile(&off, 0.5).unwrap() < 0.15, "{:?}", percentile(&off, 0.5));
    // with subdivision the same vertices have the same numbers
    let finer = fit(&template, &data).mesh;
    assert!(finer.vertices.len() > template.vertices.len());
    assert!(apart(&finer, &fixed, |p| p.z > 60.0 && p.y.abs() < 60.0) < 2.0);
}

#[test]
fn vertices_keep_their_meaning_by_landmarks_and_a_wrong_one_does_not_tear_the_mesh() {
    let head = crate::template::head();
    let template = head.mesh;
    let truth = subject(&template);
    let data = scan(&truth, 20);
    let mut landmarks: Vec<LandmarkTarget> = head
        .landmarks
        .values()
        .map(|&vertex| LandmarkTarget { vertex, position: truth.vertices[vertex], sigma_mm: 1.0 })
        .collect();
    let fit = |landmarks: &[LandmarkTarget]| {
        let input = DeformInput {
            template: &template,
            data: &data,
            assignments: &[],
            landmarks,
            outlines: &[],
        };
        deform(&input, &nicp(), &()).unwrap().mesh
    };
    let inner = |v: usize| template.vertices[v].z > 70.0 && template.vertices[v].y.abs() < 65.0;
    // distance of the template's vertices from where the subject has them: median and greatest
    let error = |mesh: &Mesh| {
        let all = (0..template.vertices.len()).filter(|&v| inner(v));
        let all: Vec<f64> = all.map(|v| (mesh.vertices[v] - truth.vertices[v]).norm()).collect();
        [percentile(&all, 0.5).unwrap(), percentile(&all, 1.0).unwrap()]
    };
    let with = fit(&landmarks);
    for l in &landmarks {
        assert!((with.vertices[l.vertex] - l.position).norm() < 1.0, "{}", l.vertex);
    }
    let (with, without) = (error(&with), error(&fit(&[])));
    assert!(with[0] < 0.5 && with[0] < 0.6 * without[0], "{with:?} {without:?}");
    landmarks[9].position += Vec3::new(12.0, 10.0, 0.0);
    let wrong = error(&fit(&landmarks));
    assert!(wrong[0] < 0.7 && wrong[1] < with[1] + 2.0, "{wrong:?} {with:?}");
}

#[test]
fn data_that_cannot_be_fitted_are_refused() {
    let template = crate::template::head().mesh;
    let far = Cloud::from_points(vec![Vec3::new(900.0, 0.0, 0.0); 200]);
    let input = DeformInput {
        template: &template,
        data: &far,
        assignments: &[],
        landmarks: &[],
        outlines: &[],
    };
    let error = deform(&input, &nicp(), &()).unwrap_err();
    assert!(matches!(error, DeformError::TooFew { got: 0, .. }), "{error}");
    let nan = Cloud::from_points(vec![Vec3::repeat(f64::NAN); 200]);
    let input = DeformInput { data: &nan, ..input };
    assert!(deform(&input, &nicp(), &()).is_err());
    let flat = Mesh { vertices: vec![Vec3::zeros(); 3], faces: vec![[0, 1, 2]], ..Mesh::default() };
    let input = DeformInput { template: &flat, ..input };
    assert!(deform(&input, &nicp(), &()).is_err());
}
