//! What the mathematics costs.
fn main() {
    divan::main();
}
