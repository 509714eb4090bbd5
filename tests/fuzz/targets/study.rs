//! The target for study files. A study that is accepted must stay the same after it is written and read again, and must
//! give every participant a sound order.

use cyclopean::study::stimulus::Catalogue;
use cyclopean::study::validate;

pub fn run(bytes: &[u8]) {
    let path = super::file("study.json", bytes);
    let study = match validate::load(&path) {
        Ok(study) => study,
        Err(error) => return super::said(&error),
    };
    let text = serde_json::to_string(&study.definition).expect("a definition is plain data");
    let again = validate::parse(&path, text).expect("a definition that was accepted is accepted again");
    assert_eq!(again.definition, study.definition, "the study changed when it was written and read again");
    let catalogue = Catalogue::of(&["pica", "wine"], &["sssr", "path-traced"]).with_paths(&["sway"]);
    validate::resolve(&study.definition, &catalogue).iter().for_each(|problem| super::said(problem));
    for row in [0, 1, u64::MAX] {
        super::order::check(&study.definition, row);
    }
}
