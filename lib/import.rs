//! stub
use crate::error::*;
use crate::geometry::Mesh;
use crate::rad::Primitive;
use std::sync::Arc;
/// m
pub struct Model {
    /// m
    pub mesh: Arc<Mesh>,
    /// p
    pub modifiers: Vec<Primitive>,
    /// m
    pub materials: Vec<Option<usize>>,
}
/// m
pub fn model(bytes: &[u8], name: &str) -> Result<Model> {
    let text = String::from_utf8_lossy(bytes);
    let (mut positions, mut triangles) = (vec![], vec![]);
    for l in text.lines() {
        let w: Vec<&str> = l.split_whitespace().collect();
        match w.first() {
            Some(&"v") => positions.push(crate::vector::Vec3::new(w[1].parse().unwrap(), w[2].parse().unwrap(), w[3].parse().unwrap())),
            Some(&"f") => {
                let i: Vec<u32> = w[1..].iter().map(|s| s.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect();
                for k in 1..i.len() - 1 {
                    triangles.push([i[0], i[k], i[k + 1]]);
                }
            }
            _ => {}
        }
    }
    let _ = name;
    Ok(Model {
        mesh: Arc::new(Mesh { positions, normals: vec![], uvs: vec![], triangles, materials: vec![] }),
        modifiers: vec![],
        materials: vec![],
    })
}
