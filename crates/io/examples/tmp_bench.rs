#![allow(clippy::print_stdout,clippy::unwrap_used,missing_docs, reason="t")]
use std::time::Instant;
use evpose_core::*; use evpose_io::*;
fn main(){
  let path="/tmp/bench.evc";
  let t=Instant::now();
  let mut w=EvcWriter::create(path,SensorSize::DAVIS240C).unwrap();
  let mut rng=CounterRng::new(1,"b",0);
  let ev:Vec<Vec<(u16,u16,Polarity)>>=(0..500).map(|_|(0..200).map(|_|(rng.below(240) as u16,rng.below(180) as u16,Polarity::from_on(rng.chance(0.5)))).collect()).collect();
  let t2=Instant::now();
  for k in 0..500_000{ w.frame_of(ev[k%500].iter().copied()).unwrap(); }
  println!("write {:?} frames 500k, {:?}",t2.elapsed(),t.elapsed()); w.finish().unwrap();
  let n=std::fs::metadata(path).unwrap().len() as f64;
  for _ in 0..3{ let t=Instant::now(); let r=EvcReader::open(path).unwrap(); let e=t.elapsed().as_secs_f64();
  println!("open {:.0} MB/s frames {} on {}",n/e/1e6,r.frames(),r.on_events());
  let mut win=EvcWindow::new(); let t=Instant::now(); let mut s=0u64;
  for i in 0..2000u64{ let a=rng.below(499_000) as u64; r.read_frames(a..a+100,&mut win).unwrap(); s+=i; }
  println!("read {:?}/window {s}",t.elapsed()/2000);
  let t=Instant::now(); let mut s=0u64; for _ in 0..2000{ for e in win.events(){ s+=e.frame as u64+e.x as u64; } }
  println!("iterate {:?}/window {s} len {}",t.elapsed()/2000,win.len());
  }
}
