use super::albedo::albedo;
use super::model::Model;
use crate::math::Vec3;
use crate::template::Template;

fn vertex_of(t: &Template, name: &str) -> Vec3 {
    t.mesh.vertices[t.landmarks[name]]
}

#[test]
fn persons_differ_from_each_other_and_are_asymmetric() {
    let (one, again, two) = (Model::new(1), Model::new(1), Model::new(2));
    assert_eq!(one.head, again.head);
    assert!((20_000..27_000).contains(&one.head.mesh.vertices.len()));
    assert!(one.head.mesh.validate().is_ok());
    let median = |a: &Template, b: &dyn Fn(usize) -> Vec3| {
        let near = |v: &&usize| a.mesh.vertices[**v].z > 40.0;
        let all: Vec<usize> = (0..a.mesh.vertices.len()).collect();
        let mut d: Vec<f64> =
            all.iter().filter(near).map(|&i| (a.mesh.vertices[i] - b(i)).norm()).collect();
        d.sort_by(f64::total_cmp);
        d[d.len() / 2]
    };
    let other = median(&one.head, &|i| two.head.mesh.vertices[i]);
    assert!((1.0..9.0).contains(&other), "two persons differ by {other:.2} mm");
    // Asymmetry: left and right landmarks are no mirror images.
    let [l, r] = ["mouth_left", "mouth_right"].map(|n| vertex_of(&one.head, n));
    let skew = (l - Vec3::new(-r.x, r.y, r.z)).norm();
    assert!((0.1..6.0).contains(&skew), "{skew}");
}

#[test]
fn skin_is_coloured_where_it_should_be() {
    let person = Model::new(5);
    let size = 512;
    let albedo = albedo(&person, size);
    assert_eq!(albedo.size(), (size, size));
    assert!(albedo.data().iter().flatten().all(|c| (0.0..=1.0).contains(c)));
    // Mean of a few texels around the texture position of a vertex.
    let at = |p: Vec3| {
        let mesh = &person.head.mesh;
        let corner = (0..mesh.faces.len())
            .flat_map(|f| (0..3).map(move |k| (f, k)))
            .min_by(|a, b| {
                let d = |(f, k): (usize, usize)| {
                    (mesh.vertices[mesh.faces[f][k] as usize] - p).norm_squared()
                };
                d(*a).total_cmp(&d(*b))
            })
            .unwrap();
        let [u, v] = mesh.uvs[mesh.face_uvs[corner.0][corner.1] as usize];
        albedo.at((u * size as f64) as usize, ((1.0 - v) * size as f64) as usize)
    };
    let cheek = at(Vec3::new(45.0, -25.0, 75.0));
    let crown = at(Vec3::new(0.0, 133.0, 0.0));
    let lip = at(vertex_of(&person.head, "mouth_down") + Vec3::new(0.0, 4.0, 1.0));
    let dark = |c: [f32; 3]| c.iter().sum::<f32>();
    assert!(dark(crown) < 0.5 * dark(cheek), "hair {crown:?}, skin {cheek:?}");
    assert!(lip[0] / lip[1] > 1.1 * cheek[0] / cheek[1], "lip {lip:?}, skin {cheek:?}");
}

#[test]
fn a_full_beard_covers_the_chin_and_nothing_above_the_mouth() {
    let (shaved, bearded) = (Model::new(4), Model::bearded(4));
    let moved =
        |name: &str| (vertex_of(&bearded.head, name) - vertex_of(&shaved.head, name)).norm();
    assert!((3.0..12.0).contains(&moved("chin")), "{}", moved("chin"));
    for name in ["mouth_left", "mouth_up", "mouth_down", "nose_tip", "ala_left", "forehead"] {
        assert!(moved(name) < 0.5, "{name}: {}", moved(name));
    }
    let brightness = |model: &Model| -> f32 { albedo(model, 256).data().iter().flatten().sum() };
    assert!(brightness(&bearded) < 0.99 * brightness(&shaved));
}
