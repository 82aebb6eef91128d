use inverad::color::*; use inverad::vector::Vec3; use inverad::world::World; use inverad::scene::Scene; use inverad::rad::Document; use inverad::error::*; use inverad::resolve::*; use inverad::render::*; use inverad::rules::*;
use std::time::*;
pub struct D; 
impl Resolve for D { fn scene(&self,p:&str)->Result<Vec<u8>>{std::fs::read(p).map_err(|e|Error::new(format!("{p}: {e}")))} fn library(&self,n:&str)->Result<Vec<u8>>{ if n.ends_with(".rtm") {return self.scene(&format!("/work/shared/data/mesh/{}.obj", n.split('/').last().unwrap().trim_end_matches(".rtm")));} self.scene(n)} fn command(&self,c:&str)->Result<Vec<u8>>{Err(Error::new(c.to_string()))}}
pub fn lens(vf:&str)->impl Fn(usize,[f64;2])->Option<(Vec3,Vec3,f64)>+Sync {
  let t=std::fs::read_to_string(vf).unwrap(); let w:Vec<&str>=t.split_whitespace().collect();
  let f=|k:&str,i:usize|->f64{ let p=w.iter().position(|x|*x==k).unwrap(); w[p+1+i].parse().unwrap()};
  let v=|k:&str| Vec3::new(f(k,0),f(k,1),f(k,2));
  let (vp,vd,vu)=(v("-vp"),v("-vd").normalize(),v("-vu")); let h=vd.cross(vu).normalize(); let u=h.cross(vd); let s=2.0*(f("-vh",0).to_radians()/2.0).tan();
  move |n,j| { let (x,y)=(n%160,n/160); let (a,b)=((x as f64+j[0])/160.0,1.0-(y as f64+j[1])/160.0); Some((vp,(vd+h*((a-0.5)*s)+u*((b-0.5)*s)).normalize(),f64::INFINITY)) }
}
fn main(){
  let a:Vec<String>=std::env::args().collect(); let dir=&a[1]; std::env::set_current_dir(format!("/work/shared/experiments/{dir}")).unwrap();
  let t0=Instant::now();
  let mut rules=Rules::default(); rules.ambient_bounces=a[2].parse().unwrap();
  let docs=vec![Document::read("true.mat",D.scene("true.mat").unwrap()).unwrap(),Document::read("scene.rad",D.scene("scene.rad").unwrap()).unwrap()];
  let flat=inverad::expand::expand(docs,&D).unwrap(); let scene=Scene::new(&flat,&D,false).unwrap(); println!("scene {:?}",t0.elapsed());
  let world=World::new(scene,&rules).unwrap(); println!("world {:?}",t0.elapsed());
  let l=lens("view.vf"); let spp:u32=a[3].parse().unwrap();
  let t1=Instant::now();
  let r=render(&world,&rules,160*160,&l,1.0,Budget::Samples(spp),0,&mut |_|true);
  println!("render {:?} noise {}",t1.elapsed(),r.noise);
  let target=inverad::picture::Picture::read(&std::fs::read("target.hdr").unwrap(),"t").unwrap().into_radiance();
  let (mut s,mut t,mut n,mut d2)=(Rgb::ZERO,Rgb::ZERO,0,0.0);
  for (p,q) in r.pixels.iter().zip(&target.pixels){ if p.surface { let q=Rgb::new(q[0] as f64,q[1] as f64,q[2] as f64); s+=p.mean(); t+=q; n+=1; d2+=(p.mean()-q).length_squared(); } }
  println!("{n} pixels, ratio {:?} rel rms {}", s/t, (d2/n as f64/3.0).sqrt()/(t/n as f64).dot(Rgb::ONE)*3.0);
  let flat:Vec<[f32;3]>=r.pixels.iter().map(|p|{let m=p.mean();[m.x as f32,m.y as f32,m.z as f32]}).collect();
  std::fs::write(format!("/tmp/{dir}.ppm"),{let mut v=b"P6 320 160 255\n".to_vec(); let tm=|x:f32| ((x/(1.0+x)).powf(1.0/2.2)*255.0) as u8; for y in 0..160{ for x in 0..160{ for c in 0..3{v.push(tm(flat[y*160+x][c]*1.5))}} for x in 0..160{for c in 0..3{v.push(tm(target.pixels[y*160+x][c]*1.5))}}} v}).unwrap();
}
