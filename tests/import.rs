//! Meshes and octrees that RADIANCE's own programs made, recorded beside what they were made from.

use inverad::accel::{Accel, Geometry, Surface};
use inverad::expand::expand;
use inverad::geometry::{Mesh, Ray};
use inverad::import::{MeshFile, MeshMaterial, Octree, is_octree, mesh, octree};
use inverad::resolve::Files;
use inverad::scene::{Reading, Scene};
use inverad::vector::{Affine, Vec3};
use proptest::prelude::*;
use std::sync::Arc;

// obj2mesh -a materials.rad sheet.obj > sheet.rtm
const RTM: &[u8] = include_bytes!("import/sheet.rtm");
const OBJ: &[u8] = include_bytes!("import/sheet.obj");
const ANSWERS: &str = include_str!("import/sheet.txt");
// oconv -f scene.rad > frozen.oct; oconv scene.rad '!echo void glow g 0 0 4 1 1 1 0' > plain.oct
const SCENE: &str = include_str!("import/scene.rad");
const FROZEN: &[u8] = include_bytes!("import/frozen.oct");
const PLAIN: &[u8] = include_bytes!("import/plain.oct");

fn read(bytes: &[u8], name: &str) -> MeshFile {
    mesh(bytes.to_vec(), name).unwrap()
}

/// The name of the material of a triangle.
fn material(file: &MeshFile, triangle: u32) -> String {
    match &file.materials[file.mesh.material(triangle) as usize] {
        MeshMaterial::Void => "void".into(),
        MeshMaterial::Named(name) => name.clone(),
        MeshMaterial::Embedded(i) => file.scene.primitives().nth(*i).unwrap().name.clone(),
    }
}

#[test]
fn rays_find_in_both_forms_of_a_mesh_what_rtrace_finds() {
    for (bytes, name) in [(RTM, "sheet.rtm"), (OBJ, "sheet.obj")] {
        let file = read(bytes, name);
        let shared = Arc::new(file.mesh.clone());
        let accel = Accel::build(vec![Surface::from(Geometry::Mesh(shared, Affine::IDENTITY))]).unwrap();
        for line in ANSWERS.lines().filter(|line| !line.starts_with('#')) {
            let words: Vec<&str> = line.split(' ').collect();
            let number = |i: usize| words[i].parse::<f64>().unwrap();
            let vector = |i: usize| Vec3::new(number(i), number(i + 1), number(i + 2));
            let hit = accel.nearest(&Ray::new(vector(0), vector(3).normalize()), 1e-6, 1e10);
            if words[6] == "*" {
                assert!(hit.is_none(), "{name}: {line}");
                continue;
            }
            let hit = hit.expect(line);
            assert_eq!(material(&file, hit.triangle), words[6], "{name}: {line}");
            assert!((hit.t - number(7)).abs() < 2e-6 * number(7), "{name}: {line}");
            assert!((hit.point - vector(8)).length() < 1e-6);
            let n = file.mesh.normal(hit.triangle, hit.barycentric).unwrap_or(hit.normal);
            // The codes of a .rtm have 13 bits.
            assert!((n - vector(11)).length() < 2e-4, "{name}: {line} {n}");
            assert!((hit.normal - vector(14)).length() < 1e-5, "{name}: {line} {}", hit.normal);
            let uv = file.mesh.uv(hit.triangle, hit.barycentric).unwrap_or([0.0; 2]);
            assert!((uv[0] - number(17)).abs() < 2e-6 && (uv[1] - number(18)).abs() < 2e-6, "{name}: {line} {uv:?}");
        }
    }
}

#[test]
fn a_compiled_mesh_has_the_triangles_and_modifiers_it_was_made_from() {
    let (rtm, obj) = (read(RTM, "sheet.rtm"), read(OBJ, "sheet.obj"));
    let describe = |file: &MeshFile| {
        let triangle = |t: u32| {
            let corners = file.mesh.corners(t);
            // Halfway between what six decimals can round to.
            let mut keys = corners.map(|p| (p * 1e5 + Vec3::splat(0.05)).round().to_array().map(|x| x as i64));
            let first = (0..3).min_by_key(|&i| keys[i]).unwrap();
            keys.rotate_left(first);
            (keys, material(file, t))
        };
        let mut all: Vec<_> = (0..file.mesh.triangles.len() as u32).map(triangle).collect();
        all.sort();
        all
    };
    let (a, b) = (describe(&rtm), describe(&obj));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a, b);
    }
    let modifiers: Vec<String> = rtm.scene.primitives().map(|p| format!("{} {} {}", p.modifier, p.kind, p.name)).collect();
    assert_eq!(modifiers, ["void plastic red", "void brightfunc pat", "pat plastic blue"]);
    assert!(obj.scene.statements.is_empty());
}

#[test]
fn a_frozen_octree_holds_its_scene() {
    assert!(is_octree(FROZEN) && is_octree(PLAIN) && !is_octree(RTM) && !is_octree(SCENE.as_bytes()));
    let Octree::Scene(frozen) = octree(FROZEN, "frozen.oct").unwrap() else { panic!("it is frozen") };
    let written = inverad::rad::Document::parse(inverad::error::Source::new("scene.rad", SCENE)).unwrap();
    assert_eq!(frozen.primitives().count(), written.primitives().count());
    for (a, b) in frozen.primitives().zip(written.primitives()) {
        let aliases = a.kind == "alias";
        assert_eq!((&a.kind, &a.name), (&b.kind, &b.name));
        // Plain synonyms are stored as such, whatever they were written as.
        if !aliases {
            assert_eq!((&a.modifier, &a.strings), (&b.modifier, &b.strings));
        }
        assert_eq!(a.reals.len(), b.reals.len());
        // 31 bits of mantissa.
        assert!(a.reals.iter().zip(&b.reals).all(|(a, b)| (a - b).abs() <= 5e-10 * b.abs()), "{a} {b}");
    }
    let aliases: Vec<String> = frozen.primitives().filter(|p| p.kind == "alias").map(|p| p.to_string()).collect();
    assert_eq!(aliases, ["inherit alias a red\n", "inherit alias b red\n", "pat alias c red\n"]);
}

#[test]
fn an_octree_that_is_not_frozen_names_its_files() {
    let Octree::Files(files) = octree(PLAIN, "plain.oct").unwrap() else { panic!("it is not frozen") };
    assert_eq!(files, ["scene.rad", "!echo void glow g 0 0 4 1 1 1 0"]);
    // What its command prints is made inside the process.
    let resolve = Files::of([("scene.rad", &b"void plastic p 0 0 5 1 1 1 0 0"[..])]);
    let flat = expand(Octree::Files(files).documents("plain.oct", &resolve).unwrap(), &resolve).unwrap();
    assert_eq!(flat.primitives.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["p", "g"]);
}

#[test]
fn what_is_unknown_stands_for_its_name_in_octrees_and_meshes_too() {
    let text = "void metal red 0 0 5 .9 .9 .9 .9 .1\nvoid instance i 1 frozen.oct 0 0\nvoid mesh m 1 sheet.rtm 0 0\n";
    let resolve = Files::of([("scene.rad", text.as_bytes()), ("frozen.oct", FROZEN), ("sheet.rtm", RTM)]);
    let flat = expand(Octree::Files(vec!["scene.rad".into()]).documents("", &resolve).unwrap(), &resolve).unwrap();
    for unknown in [None, Some("red".to_string())] {
        let scene = Scene::new(&flat, &resolve, &Reading { unknown: unknown.clone(), ..Reading::default() }).unwrap();
        let kinds = |name: &str| scene.materials.iter().filter(|m| m.name == name).count();
        assert_eq!(scene.material(&flat.primitives[0]).is_some(), unknown.is_some());
        // Each file has a plastic of that name, one of them another behind a pattern.
        assert_eq!((kinds("red"), kinds("blue")), (if unknown.is_some() { 1 } else { 3 }, 1));
    }
}

#[test]
fn faults_are_told_with_their_place() {
    let fault = |text: &str| mesh(text.as_bytes().to_vec(), "a.obj").unwrap_err().to_string().lines().next().unwrap().to_string();
    assert_eq!(fault("v 0 0 0\nv 1 0 x\n"), "a.obj:2:7: error: not a number");
    assert_eq!(fault("v 0 0 nan\n"), "a.obj:1:7: error: not a number");
    assert_eq!(fault("v 0 0\n"), "a.obj:1:1: error: `v` needs 3 numbers");
    assert_eq!(fault("v 0 0 0\nf 1 1\n"), "a.obj:2:1: error: a face needs 3 to 512 corners, not 2");
    assert_eq!(fault("v 0 0 0\nf 1 1 2\n"), "a.obj:2:7: error: there are 1 positions so far");
    assert_eq!(fault("v 0 0 0\nf 1 1 0\n"), "a.obj:2:7: error: there are 1 positions so far");
    assert_eq!(fault("v 0 0 0\nf 1 1 -2\n"), "a.obj:2:7: error: there are 1 positions so far");
    assert_eq!(fault("v 0 0 0\nf 1 \\\n 1 1/7\n"), "a.obj:3:4: error: there are 0 surface coordinates so far");
    let truncated = mesh(RTM[..RTM.len() / 2].to_vec(), "a.rtm").unwrap_err().to_string();
    assert!(truncated.starts_with("error: a.rtm: the file ends too early (byte "), "{truncated}");
    let other = mesh(FROZEN.to_vec(), "a.oct").unwrap_err().to_string();
    assert_eq!(other, "error: a.oct: its format is Radiance_octree, not Radiance_tmesh");
}

#[test]
fn an_obj_without_materials_has_none() {
    let file = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj");
    assert_eq!((file.materials, file.mesh.material(0)), (vec![MeshMaterial::Void], 0));
    let file = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ng first second\nf 3 2 1\nusemtl red\nf 1 2 3\ng third\nf 3 2 1\n", "a.obj");
    let names: Vec<String> = (0..4).map(|t| material(&file, t)).collect();
    assert_eq!(names, ["void", "first", "red", "red"], "obj2mesh -a asks for `first` and `red`");
}

#[test]
fn a_quad_is_divided_where_obj2mesh_divides_it() {
    // rtrace finds the middle of this one at height .5, on the edge from the second corner to the fourth:
    // obj2mesh q.obj q.rtm; echo .5 .5 5 0 0 -1 | rtrace -h -op x.oct
    let file = read(b"v 0 0 0\nv 1 0 1\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "a.obj");
    let middle = |m: &Mesh| m.triangles.iter().all(|t| t.contains(&1) && t.contains(&3));
    assert!(middle(&file.mesh));
}

#[test]
fn a_small_octree_makes_no_large_scene() {
    // One type and one modifier with long names, and thousands of primitives of seven bytes that repeat them.
    let long = "N".repeat(2000);
    let mut bytes = format!("#?RADIANCE\nFORMAT=Radiance_octree\n\n\x01\x1c0\x000\x000\x001\0\0\0\0{long}\0\0").into_bytes();
    bytes.extend([0, 0xff]);
    bytes.extend(format!("{long}\0\0\0\0\0").bytes());
    bytes.extend([0; 7 * 3000]);
    bytes.push(0xff);
    let error = octree(&bytes, "a.oct").err().unwrap().message;
    assert!(error.contains("a.oct: the scene in it repeats names that are too long"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_make_a_reader_panic(which in 0..4usize, changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6), end in any::<prop::sample::Index>(), cut: bool) {
        let mut bytes = [RTM, OBJ, FROZEN, PLAIN][which].to_vec();
        for (place, byte) in changes {
            // Headers are text; what follows them is where numbers decide.
            let skip = if which == 1 { 0 } else { 60 };
            let place = skip + place.index(bytes.len() - skip);
            bytes[place] = byte;
        }
        if cut {
            bytes.truncate(end.index(bytes.len()));
        }
        let _ = octree(&bytes, "a");
        let _ = mesh(bytes, "a");
    }

    #[test]
    fn no_text_makes_the_obj_reader_panic(text in "((v|vt|vn|f|g|usemtl)( (-?[0-9]{1,2}(/[0-9]?){0,2}|[0-9]e9|\\\\\n)){0,6}\n){0,20}") {
        let _ = mesh(text.into_bytes(), "a");
    }
}
