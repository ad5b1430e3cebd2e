//! `solidtrace trace`.

use std::fmt::Write;
use std::fs;

use glam::DVec3;
use solidtrace::io::{RayReader, ReadOptions, read_scene};
use solidtrace::world::World;

use super::{folder_with_scene, run, stderr};

#[test]
fn trace_answers_a_million_rays_as_the_library_does() {
    const RAYS: i32 = 1_000_000;
    let count = RAYS as usize;
    let folder = folder_with_scene();
    let path = folder.path();
    let mut rays = String::from("ox,oy,oz,dx,dy,dz,tmin,tmax\n");
    for i in 0..RAYS {
        let (x, y) = (
            f64::from(i % 1009) / 500.0 - 1.0,
            f64::from(i % 997) / 800.0 - 0.6,
        );
        let tmax = if i % 10 == 0 { "4.5" } else { "inf" };
        let tmin = i % 3;
        writeln!(rays, "0,1,5,{x},{y},-2.5,{tmin},{tmax}").unwrap();
    }
    fs::write(path.join("rays.csv"), rays).unwrap();
    let output = run(path, &["trace", "room.ron", "rays.csv", "-o", "hits.csv"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let output = run(path, &["trace", "room.ron", "rays.csv", "--any"]);
    let any = String::from_utf8(output.stdout).unwrap();

    let scene = read_scene(&path.join("room.ron"), &ReadOptions::default()).unwrap();
    let world = World::build(scene).unwrap();
    let rays = RayReader::open(&path.join("rays.csv"))
        .unwrap()
        .read(count + 1)
        .unwrap();
    let mut lines = csv::Reader::from_path(path.join("hits.csv")).unwrap();
    let header = "hit,t,px,py,pz,nx,ny,nz,u,v,object,primitive,material";
    assert_eq!(
        lines
            .headers()
            .unwrap()
            .iter()
            .collect::<Vec<_>>()
            .join(","),
        header
    );
    let lines: Vec<csv::StringRecord> = lines.records().map(Result::unwrap).collect();
    assert_eq!((lines.len(), any.lines().count()), (count, count + 1));
    let mut hits = 0;
    for ((ray, line), any) in rays.iter().zip(&lines).zip(any.lines().skip(1)) {
        assert_eq!(&line[0], &any[..1]);
        let Some(hit) = world.intersect(ray) else {
            assert_eq!(&line[0], "0");
            continue;
        };
        hits += 1;
        let point = world.surface(ray, &hit);
        let number = |i: usize| line[i].parse::<f64>().unwrap();
        assert_eq!(&line[0], "1");
        assert_eq!(number(1), hit.t);
        assert_eq!(DVec3::new(number(2), number(3), number(4)), point.p);
        let n = DVec3::new(number(5), number(6), number(7));
        let outward = point.ng.as_dvec3();
        let name = world.instance(&hit).name.clone();
        let turned = name.as_deref() == Some("floor") && outward.dot(ray.direction) > 0.0;
        assert_eq!(n, if turned { -outward } else { outward });
        assert_eq!(&line[10], name.unwrap_or_else(|| hit.instance.to_string()));
        assert_eq!(&line[11], hit.primitive.to_string());
        assert_eq!(&line[12], world.material(&point).name);
    }
    assert!(hits > RAYS / 5, "{hits}");
}

#[test]
fn a_bad_ray_is_an_error_with_its_place_and_no_output() {
    let folder = folder_with_scene();
    let path = folder.path();
    for (rays, place) in [
        (
            "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n0,0,0,zero,0,1\n",
            "rays.csv:3:7",
        ),
        ("ox,oy,oz,dx,dy,dz\n0,0,0,0,0,0\n", "rays.csv:2:7"),
        ("ox,oy,oz,dx,dy\n0,0,0,0,0\n", "rays.csv:1"),
        ("ox,oy,oz,dx,dy,dz\n0,0,NaN,0,0,1\n", "rays.csv:2:5"),
        ("ox,oy,oz,dx,dy,dz\n0,0,0,0,1\n", "rays.csv:2"),
        (
            "ox,oy,oz,dx,dy,dz,tmin,tmax\n0,0,0,0,1,0,3,2\n",
            "rays.csv:2:13",
        ),
        ("ox,oy,oz,dx,dy,dz,tmin\n0,0,0,0,1,0,-1\n", "rays.csv:2:13"),
    ] {
        fs::write(path.join("rays.csv"), rays).unwrap();
        let output = run(path, &["trace", "room.ron", "rays.csv", "-o", "hits.csv"]);
        assert_eq!(output.status.code(), Some(1), "{rays}");
        assert!(
            stderr(&output).contains(place),
            "{rays}: {}",
            stderr(&output)
        );
        assert!(!path.join("hits.csv").exists());
    }
}
