#[path="scratch.rs"] #[allow(dead_code)] mod scratch; use scratch::*;
use inverad::color::*; use inverad::vector::Vec3; use inverad::world::World; use inverad::scene::Scene; use inverad::rad::Document; use inverad::render::*; use inverad::rules::*; use inverad::resolve::*; use inverad::geometry::Ray;
fn main(){ let rules=Rules::default(); let docs=vec![Document::read("t",D.scene("/tmp/t.rad").unwrap()).unwrap()];
  let flat=inverad::expand::expand(docs,&D).unwrap(); let scene=Scene::new(&flat,&D,false).unwrap(); let world=World::new(scene,&rules).unwrap();
  let ray=Ray{origin:Vec3::new(2.6,-1.6,1.0),direction:Vec3::new(-2.6,1.6,-0.48).normalize()};
  let h=world.nearest(&ray,f64::INFINITY); println!("{h:?}"); let h=h.unwrap();
  for k in 0..5 { let d=(h.normal+Vec3::new(0.3*k as f64,0.1,0.0)).normalize(); let r=Ray{origin:h.point,direction:d}; println!("{:?} {}",world.nearest(&r,f64::INFINITY).map(|h|(h.t,h.triangle)), world.occluded(&r)); }
  let l=|_:usize,_:[f64;2]| Some((ray.origin,ray.direction,f64::INFINITY));
  let r=render(&world,&rules,1,&l,0.0,Budget::Samples(64),0,&mut |_|true); println!("{:?}",r.pixels[0].mean()); let _=Rgb::ONE;
}
