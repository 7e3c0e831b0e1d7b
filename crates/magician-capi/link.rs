//! Build script of the shared libraries: gives them the vendor's names for linking.

fn main() {
    println!("cargo::rerun-if-changed=../link.rs");
    let target = |key: &str| std::env::var(key).unwrap_or_default();
    let arguments: &[&str] = match target("CARGO_CFG_TARGET_VENDOR").as_str() {
        "apple" => &["-Wl,-install_name,@rpath/libDobotDll.dylib"],
        // Without `nodelete`, a program that unloads the library while an arm is connected would
        // crash: threads of the driver still run its code.
        _ if target("CARGO_CFG_TARGET_FAMILY") == "unix" => {
            &["-Wl,-soname,libDobotDll.so.1", "-Wl,-z,nodelete"]
        }
        // A DLL is named by its file. The import library carries the vendor's name, and is made
        // when the package is staged.
        _ => &[],
    };
    for argument in arguments {
        println!("cargo::rustc-cdylib-link-arg={argument}");
    }
}
