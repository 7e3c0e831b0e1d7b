//! The names of the vendor's library for linking.

fn main() {
    println!("cargo::rerun-if-changed=../link.rs");
    let target = |key: &str| std::env::var(key).unwrap_or_default();
    let arguments: &[&str] = match target("CARGO_CFG_TARGET_VENDOR").as_str() {
        "apple" => &["-Wl,-install_name,@rpath/libDobotDll.dylib"],
        // The code must stay while threads of it run: a program that unloads it with an arm connected goes on.
        _ if target("CARGO_CFG_TARGET_FAMILY") == "unix" => {
            &["-Wl,-soname,libDobotDll.so.1", "-Wl,-z,nodelete"]
        }
        // The name of a DLL is its file's; the import library, which has the other one, is made when it is staged.
        _ => &[],
    };
    for argument in arguments {
        println!("cargo::rustc-cdylib-link-arg={argument}");
    }
}
