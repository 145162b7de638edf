//! Commands about the program itself.

use beadwork_tests::{misused, run};
use serde_json::Value;

#[test]
fn doctor_lists_what_is_needed_and_how_to_get_it() {
    let text = run(&["doctor"]);
    assert!(text.contains("Rust"), "{text}");
    let document: Value = serde_json::from_str(&run(&["doctor", "--json"])).unwrap();
    let items = document["items"].as_array().unwrap();
    assert!(items.iter().any(|item| item["name"] == "libtorch 2.13.0"));
    assert!(items.iter().all(|item| !item["install"].as_str().unwrap().is_empty()));
}

#[test]
fn completions_know_the_commands_in_every_shell() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = run(&["completions", shell]);
        assert!(script.contains("gen-data") && script.contains("simulate"), "{shell}");
    }
    assert!(misused(&["completions", "tcsh"]).contains("bash"));
}
