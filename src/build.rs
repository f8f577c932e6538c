//! Says which instructions the engine is compiled for.
//!
//! Each level compiles every walk of every tree once more. In a development build those are left out that this machine
//! cannot run, and no test could reach; a release has them all.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(has_avx512)");
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let is_development = variable("PROFILE") == "debug" && variable("HOST") == variable("TARGET");
    let is_x86 = variable("CARGO_CFG_TARGET_ARCH") == "x86_64";
    if is_x86 && (!is_development || this_machine_has_avx512()) {
        println!("cargo:rustc-cfg=has_avx512");
    }
}

#[cfg(target_arch = "x86_64")]
fn this_machine_has_avx512() -> bool {
    std::arch::is_x86_feature_detected!("avx512f")
}

#[cfg(not(target_arch = "x86_64"))]
fn this_machine_has_avx512() -> bool {
    false
}
