#[path="scratch.rs"] #[allow(dead_code)] mod scratch; use scratch::*;
use inverad::recover::{fit::*,gram::*,model::*}; use inverad::transport::*; use inverad::geometry::Ray; use rayon::prelude::*;
use inverad::world::World; use inverad::scene::Scene; use inverad::rad::Document; use inverad::rules::*; use inverad::resolve::*;
use std::time::*;
fn geo(lo:f64,hi:f64,n:usize)->Vec<f64>{(0..n).map(|i| lo*(hi/lo).powf(i as f64/(n as f64-1.0))).collect()}
fn main(){
  let a:Vec<String>=std::env::args().collect(); let dir=&a[1]; std::env::set_current_dir(format!("/work/shared/experiments/{dir}")).unwrap();
  let t0=Instant::now(); let n1:u32=a[2].parse().unwrap(); let n2:u32=a[3].parse().unwrap(); let n3:u32=a[4].parse().unwrap(); let seed0:u64=a[5].parse().unwrap();
  let metal=dir=="horse"; let mut rules=Rules::default(); rules.ambient_bounces=if metal {2} else {3};
  let docs=vec![Document::read("true.mat",D.scene("start.rad").unwrap()).unwrap(),Document::read("scene.rad",D.scene("scene.rad").unwrap()).unwrap()];
  let flat=inverad::expand::expand(docs,&D).unwrap(); let scene=Scene::new(&flat,&D,false).unwrap(); let id=scene.material("obj_mat").unwrap();
  let world=World::new(scene,&rules).unwrap(); println!("load {:?}",t0.elapsed());
  let l=lens("view.vf"); let target=inverad::picture::Picture::read(&std::fs::read("target.hdr").unwrap(),"t").unwrap().into_radiance();
  let numbers:Vec<usize>=(0..25600usize).into_par_iter().filter(|&n| (0..16).any(|k| {let (o,d,_)=l(n,[(k%4) as f64/4.0+0.125,(k/4) as f64/4.0+0.125]).unwrap(); world.shows(&Ray{origin:o,direction:d},id)})).collect();
  println!("{} pixels {:?}",numbers.len(),t0.elapsed());
  let tg:Vec<[f32;3]>=numbers.iter().map(|&n| target.pixels[n]).collect();
  let kind=Kind{metal,transmits:false,anisotropic:false};
  let bounds=if metal {vec![(0.,1.),(0.,1.),(0.,1.),(0.4,1.0),(0.0,0.3)]} else {vec![(0.,1.),(0.,1.),(0.,1.),(0.,0.3),(0.,0.3)]};
  let px=Pixels{numbers:&numbers,lens:&l};
  let truth=if metal {[0.8,0.6,0.3,0.9,0.01]} else {[0.7,0.7,0.7,0.12,0.125]};
  // weights from the blurred target
  let blur:Vec<[f32;3]>=numbers.iter().map(|&n|{let (x,y)=((n%160) as i32,(n/160) as i32); let mut s=[0f32;3]; let mut c=0.0; for dy in -2..=2{for dx in -2..=2{ let (u,v)=(x+dx,y+dy); if u>=0&&v>=0&&u<160&&v<160{ for k in 0..3{s[k]+=target.pixels[(v*160+u) as usize][k]} c+=1.0; }}} s.map(|v| v/c)}).collect();
  let mean=blur.iter().map(|b| b[0]+b[1]+b[2]).sum::<f32>()/blur.len() as f32/3.0;
  let rel:Vec<[f32;3]>=blur.iter().map(|b| b.map(|v| 1.0/(v+0.1*mean).powi(2))).collect();
  let mut grid=geo(0.003,0.4,16); let mut prop:Vec<f64>=vec![0.004,0.0126,0.04,0.126,0.4]; let mut best:Vec<f64>=vec![];
  for stage in 0..3 {
    let t1=Instant::now();
    let u=Unknown::Rough(Rough::new(id,metal,false,alphas(kind,&grid),prop.iter().map(|a|[a*a;2]).collect()));
    let b=trace(&world,&rules,&u,&px,2,[n1,n2,n3][stage],seed0*10+stage as u64);
    let t2=t1.elapsed();
    let Unknown::Rough(r)=&u else{panic!()}; let m=Model::new(kind,&r.monomials,&grid);
    let co=|v:&[f64]| m.coefficients(v);
    // weights for later stages: own variance
    let w:Vec<[f32;3]>= if stage==0 {rel.clone()} else {
       let x=co(&best); let nn=b.columns;
       let val=|p:usize,s:usize|->[f64;3]{ let q=b.pixel(p,s); std::array::from_fn(|c| (0..nn).map(|i| q[c*nn+i] as f64*x[c][i]).sum())};
       let var:Vec<[f64;3]>=(0..numbers.len()).map(|p|{let (a,b)=(val(p,0),val(p,1)); std::array::from_fn(|c| (a[c]-b[c]).powi(2)/2.0*[n1,n2,n3][stage] as f64)}).collect();
       let mut map=vec![usize::MAX;25600]; for (i,&n) in numbers.iter().enumerate(){map[n]=i;}
       (0..numbers.len()).map(|p|{ let n=numbers[p]; let (x0,y0)=((n%160) as i32,(n/160) as i32); let mut s=[0f64;3]; let mut c=0.0; for dy in -1..=1{for dx in -1..=1{ let (u,v)=(x0+dx,y0+dy); if u>=0&&v>=0&&u<160&&v<160{ let i=map[(v*160+u) as usize]; if i!=usize::MAX { for k in 0..3{s[k]+=var[i][k]} c+=1.0; }}}}
         let (a,bb)=(val(p,0),val(p,1)); std::array::from_fn(|k| (1.0/(s[k]/c/12.0+(0.02*(a[k]+bb[k])/2.0).powi(2)+(0.01*mean as f64).powi(2))) as f32)}).collect()
    };
    for form in [Form::Whole,Form::Halves] {
      let t3=Instant::now();
      let g=Gram::new(&b,&tg,&w,form); let tg_=t3.elapsed();
      let p=Problem{gram:&g,coefficients:&co,bounds:&bounds};
      let mut res:Option<Point>=None;
      for r in &grid { if *r>0.3 {continue;} let st=vec![0.5,0.5,0.5,(bounds[3].0+bounds[3].1)/2.0,*r]; let q=p.polish(&st,&[true,true,true,true,false]); let q=p.polish(&q.values,&[true;5]); if res.as_ref().is_none_or(|b| q.chi2<b.chi2){res=Some(q);} }
      let res=res.unwrap();
      println!("stage {stage} {form:?} trace {t2:?} gram {tg_:?} fit {:?}: {:?} chi {} (truth {})",t3.elapsed(),res.values.iter().map(|v|(v*1e4).round()/1e4).collect::<Vec<_>>(),res.chi2,p.chi2(&truth));
      if form==Form::Whole {best=res.values.clone();}
    }
    let a=best[4].max(0.0035); let ratio:f64=if stage==0 {1.3} else {1.15};
    grid=(0..8).map(|i| a*ratio.powf(i as f64-3.5)).collect(); prop=if stage==0 {vec![a*0.5,a,a*2.0]} else {vec![a*0.8,a*1.3]};
  }
  println!("total {:?}",t0.elapsed());
}
