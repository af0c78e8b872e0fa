//! Any text as a backup: what is read of it is written and read again as the same.
#![no_main]

use encoring_workshop::ParameterFile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match ParameterFile::parse("backup.toml", text) {
        Ok(file) => {
            let again = ParameterFile::parse("backup.toml", &file.text());
            assert_eq!(again.map(|file| file.encoders), Ok(file.encoders));
        }
        Err(refused) => assert!(refused.to_string().starts_with("backup.toml"), "{refused}"),
    }
});
