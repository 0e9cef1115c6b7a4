//! Prints the table of bytes of worlds with slots of 16 bits and room for four pairs an object.

use trisap::{Capacity, Config, layout};

fn main() {
    println!("| objects | pairs | lean | exact | with found and lost pairs |");
    println!("|--------:|------:|-----:|------:|--------------------------:|");
    for objects in [16, 32, 64, 128, 256, 512, 1024] {
        let config = Config::new(Capacity::for_objects(objects).with_pairs(4 * objects));
        let bytes = |config: &Config| layout::<u16>(config).map(|layout| layout.bytes.to_string());
        let told = [bytes(&config.with_lean()), bytes(&config), bytes(&config.with_events())];
        println!("| {objects} | {} | {} |", 4 * objects, told.map(Option::unwrap_or_default).join(" | "));
    }
}
