//! Tells the linker where `run.sh` put the Embree driver.

fn main() {
    let folder = std::env::var("EMBREE_DRIVER").expect("run.sh sets EMBREE_DRIVER");
    println!("cargo::rustc-link-search=native={folder}");
    println!("cargo::rustc-link-arg=-Wl,-rpath,{folder}");
    println!("cargo::rerun-if-env-changed=EMBREE_DRIVER");
}
