//! `pldi templates`: sets from meshes, conversion, both arithmetics.

mod common;

use std::fmt::Write as _;

use common::{folder, pldi, recording};
use pldi_core::matching::canberra;
use pldi_core::pipeline::Float;
use pldi_core::templates::{Encoding, Templates};
use pldi_host::templates::{Builder, EMBEDDED, Look, fixed_file, procedural};
use pldi_host::{Numbers, parallel};

/// One object of each class, all its views; `cargo xtask golden --check` makes all eight, which takes minutes.
#[test]
fn the_embedded_set_is_what_the_code_makes() {
    let set = Templates::parse(EMBEDDED).unwrap();
    let look = Look { distances: vec![2.0, 3.0], ..Look::default() };
    let builder = Builder::new(*set.view_params(), look).unwrap();
    let objects = procedural(8);
    assert!(set.objects().map(|(_, name)| name).eq(objects.iter().map(|o| o.name.as_str())));
    let numbers: Vec<usize> = (0..objects.len() / 8).map(|class| 8 * class + class % 8).collect();
    parallel::map_ordered(numbers.len(), 2, Float::workspace, |workspace, i| {
        let number = numbers[i];
        let made = builder.describe::<Float>(&objects[number], number, workspace)?;
        let kept = set.iter().filter(|t| usize::from(t.object()) == number).map(|t| (t.view(), t.descriptor()));
        assert!(kept.eq(made), "{}: `cargo xtask golden` if that is meant", objects[number].name);
        Ok::<_, pldi_host::Error>(())
    })
    .unwrap();
}

/// A shelf-like solid (not the same from any two sides) as corners and triangles, in metres, z up.
fn solid() -> (Vec<[f32; 3]>, Vec<[usize; 3]>) {
    let boxes = [([-0.3, -0.2, 0.0], [0.3, 0.2, 0.35]), ([-0.3, -0.2, 0.35], [-0.1, 0.2, 0.9])];
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for (low, high) in boxes {
        let first = corners.len();
        for i in 0..8 {
            corners.push([0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }));
        }
        for quad in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let [a, b, c, d] = quad.map(|i| first + i);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (corners, triangles)
}

fn off() -> String {
    let (corners, triangles) = solid();
    let mut text = format!("OFF\n{} {} 0\n", corners.len(), triangles.len());
    for [x, y, z] in corners {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    for [a, b, c] in triangles {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text
}

/// With y up, as most OBJ files.
fn obj() -> String {
    let (corners, triangles) = solid();
    let mut text = String::new();
    for [x, y, z] in corners {
        writeln!(text, "v {x} {z} {}", -y).unwrap();
    }
    for [a, b, c] in triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

/// In millimetres, as most STL files.
fn stl() -> String {
    let (corners, triangles) = solid();
    let mut text = "solid shelf\n".to_owned();
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle.map(|i| corners[i].map(|c| 1000.0 * c)) {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid shelf\n"
}

#[test]
fn templates_come_from_meshes_of_any_format() {
    let out = folder();
    let build = |name: &str, text: String, more: &[&str]| {
        let (mesh, set) = (out.path().join(name), out.path().join(format!("{name}.pldt")));
        std::fs::write(&mesh, text).unwrap();
        let mut line = arguments!["templates", "build", mesh, "-o", set, "--class", "shelf"].to_vec();
        line.extend(["--views", "5", "--noise-free"].iter().chain(more).map(Into::into));
        pldi(line).ok();
        let info = pldi(arguments!["templates", "info", set]).ok();
        let info = String::from_utf8(info.stdout).unwrap();
        assert!(info.contains("shelf") && info.contains("5 templates of 1 objects in 1 classes"), "{info}");
        std::fs::read(set).unwrap()
    };
    let sets = [
        build("shelf.off", off(), &[]),
        build("shelf.obj", obj(), &["--up", "y"]),
        build("shelf.stl", stl(), &["--unit", "mm"]),
    ];
    let parsed: Vec<_> = sets.iter().map(|bytes| Templates::parse(bytes).unwrap()).collect();
    for view in 0..5 {
        let descriptor = |set: usize| parsed[set].iter().nth(view).unwrap().descriptor();
        // The same solid, but for rounding; another side of it is far away.
        assert!(canberra(&descriptor(0), &descriptor(1)) < 1.0, "obj, view {view}");
        assert!(canberra(&descriptor(0), &descriptor(2)) < 1.0, "stl, view {view}");
        let other = parsed[0].iter().nth((view + 1) % 5).unwrap().descriptor();
        assert!(canberra(&descriptor(0), &other) > 2.0, "view {view}");
    }
    let file = out.path().join("shelf.off.pldt");
    let lines = pldi(arguments!["run", *recording(), "--templates", file]).ok().lines();
    let results = lines.iter().flat_map(|l| l["detections"].as_array().unwrap()).map(|d| &d["results"]);
    assert!(results.clone().count() > 0);
    for result in results {
        assert_eq!(result.as_array().unwrap().len(), 1);
        assert_eq!((&result[0]["class_id"], &result[0]["object"]), (&"shelf".into(), &"shelf".into()));
    }
    let cut = out.path().join("cut.off");
    std::fs::write(&cut, &off()[..100]).unwrap();
    let outcome = pldi(arguments!["templates", "build", cut, "-o", out.path().join("none.pldt"), "--class", "x"]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("cut.off"), "{}", outcome.stderr);
    assert!(!out.path().join("none.pldt").exists());
}

#[test]
fn templates_are_converted_for_fixed_point() {
    let out = folder();
    let mesh = out.path().join("shelf.off");
    std::fs::write(&mesh, off()).unwrap();
    let [float, fixed, converted] = ["float", "fixed", "converted"].map(|name| out.path().join(name));
    let build =
        arguments!["templates", "build", mesh, "--class", "shelf", "--views", "5", "--noise-free", "-o"].to_vec();
    pldi([&build[..], &arguments![float]].concat()).ok();
    pldi([&build[..], &arguments![fixed, "--fixed"]].concat()).ok();
    let outcome = pldi(arguments!["templates", "convert", float, "-o", converted]).ok();
    assert!(outcome.stderr.contains("5 templates as 16-bit logarithms"), "{}", outcome.stderr);
    let [fixed, converted] = [fixed, converted].map(|file| std::fs::read(file).unwrap());
    assert!(fixed == converted && fixed == fixed_file(&std::fs::read(&float).unwrap()).unwrap());
    for (file, encoding) in [("float", "32-bit floats"), ("converted", "16-bit logarithms")] {
        let info = pldi(arguments!["templates", "info", out.path().join(file)]).ok();
        let info = String::from_utf8(info.stdout).unwrap();
        assert!(info.contains(&format!("5 templates of 1 objects in 1 classes, {encoding}")), "{info}");
        let evaluated = pldi(arguments!["templates", "evaluate", out.path().join(file)]).ok();
        assert!(String::from_utf8(evaluated.stdout).unwrap().contains("macro averages"));
    }
}

/// What integers make of a mesh is nearly what floats make of it, and each arithmetic searches what it can read.
#[test]
fn templates_are_computed_in_integers() {
    let out = folder();
    let mesh = out.path().join("shelf.off");
    std::fs::write(&mesh, off()).unwrap();
    for noise in [false, true] {
        let [float, fixed] = ["float", "fixed"].map(|arithmetic| {
            let file = out.path().join(format!("{arithmetic}{noise}"));
            let mut line =
                arguments!["templates", "build", mesh, "--class", "shelf", "--views", "3", "-o", file].to_vec();
            line.extend(arguments!["--arithmetic", arithmetic]);
            line.extend((!noise).then(|| "--noise-free".into()));
            pldi(line).ok();
            std::fs::read(file).unwrap()
        });
        let [a, b] = [&float, &fixed].map(|bytes| Templates::parse(bytes).unwrap());
        assert_eq!((a.encoding(), b.encoding()), (Encoding::Float, Encoding::Logarithmic));
        assert_eq!((a.len(), a.view_params()), (b.len(), b.view_params()));
        for (a, b) in a.iter().zip(b.iter()) {
            let distance = canberra(&a.descriptor(), &b.descriptor());
            assert!(
                (a.class(), a.object(), a.view()) == (b.class(), b.object(), b.view()) && distance < 3.0,
                "{distance}"
            );
        }
    }
    let coded = out.path().join("fixedfalse");
    let run = |more: &[&str]| {
        pldi(arguments!["run", *recording(), "--templates", coded].iter().cloned().chain(more.iter().map(Into::into)))
    };
    let lines = run(&["--arithmetic", "fixed"]).ok().lines();
    let (detections, classes) = (&lines[1]["detections"], &lines[1]["detections"][0]["results"][0]["class_id"]);
    assert!(!detections.as_array().unwrap().is_empty() && classes == "shelf", "{detections}");
    let info = String::from_utf8(pldi(arguments!["templates", "info", coded]).ok().stdout).unwrap();
    assert!(info.contains(&format!("CRC-32 {}", lines[0]["templates"].as_str().unwrap())), "{info}");
    let outcome = run(&[]);
    assert!(outcome.code == Some(2) && outcome.stdout.is_empty(), "{}", outcome.stderr);
    for part in ["fixedfalse", "16-bit logarithms", "32-bit floats"] {
        assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
    }
    let outcome =
        pldi(arguments!["templates", "build", mesh, "--class", "x", "-o", coded, "--fixed", "--arithmetic", "fixed"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
}
