use super::*;

#[test]
fn what_is_written_reads_as_the_same_fault() {
    for (fault, form, _) in Fault::kinds() {
        let values = match form.split_once('=') {
            None => vec![fault],
            Some((_, "N")) => [1, 20, PER_MILLION]
                .map(|chance| format!("{}={chance}", fault.name()).parse().unwrap())
                .into(),
            Some(_) => [0x0303, 0x0A00].map(|word| Fault::Ident(Ident(word))).into(),
        };
        for fault in values {
            assert_eq!(fault.to_string().parse(), Ok(fault));
        }
    }
    assert_eq!("flips=20".parse(), Ok(Fault::Flips(20)));
    for text in ["ident=0303", "ident=0x303", "ident=303h", "ident=W#16#0303"] {
        assert_eq!(text.parse(), Ok(Fault::Ident(Ident(0x0303))), "{text}");
    }
    assert_eq!("ident=03aB".parse(), Ok(Fault::Ident(Ident(0x03AB))));
    assert_eq!(Fault::Ident(Ident(0x33)).to_string(), "ident=0033");
}

#[test]
fn what_is_no_kind_is_told_with_what_is_allowed() {
    let refused = |text: &str| text.parse::<Fault>().unwrap_err();
    let kinds = "bad, silent, low, high, flips=N, bursts=N, jitter=N, lost=N, supply, chip, jumper, ident=HHHH, ssi_lost=N, ssi_added=N, ssi_flips=N, ssi_skew=N, ssi_delay=N, ssi_low, ssi_high";
    assert_eq!(refused("flip"), format!("kind \"flip\"; the kinds are {kinds}"));
    assert_eq!(refused(""), format!("kind \"\"; the kinds are {kinds}"));
    assert_eq!(refused("bad=3"), "value \"3\" for bad, which takes none");
    let chance = |given, name| {
        format!("{given} for {name}; write {name}=N with N from 1 to 1000000, bits of a million")
    };
    assert_eq!(refused("flips=0"), chance("value \"0\"", "flips"));
    assert_eq!(refused("flips=+1"), chance("value \"+1\"", "flips"));
    assert_eq!(refused("lost=1000001"), chance("value \"1000001\"", "lost"));
    assert_eq!(refused("lost"), chance("no value", "lost"));
    assert_eq!(
        refused("ident"),
        "ident takes an identification word of 16 bits, as ident=0303 or ident=0x0303"
    );
    assert!(refused("ident=33").starts_with("ident: 33: "), "{}", refused("ident=33"));
}
