use super::*;

use proptest::prelude::*;

fn parse(text: &str) -> Address {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn refused(text: &str) -> String {
    text.parse::<Address>().unwrap_err().to_string()
}

#[test]
fn what_is_left_out_has_its_default() {
    assert_eq!(parse("modbus-tcp://gateway"), Address::tcp("gateway", 502));
    let address = parse("modbus-rtu:/dev/ttyUSB0");
    let way = Way::Rtu {
        device: "/dev/ttyUSB0".to_owned(),
        baud: 19_200,
        parity: Parity::Even,
        stop: StopBits::One,
    };
    assert_eq!(address, Address::new(way));
    assert_eq!(address.timeout, Duration::from_millis(647));
    assert_eq!(address.settle, Duration::from_millis(20));
    assert_eq!(parse("modbus-rtu-tcp://gateway:4001").timeout, Duration::from_millis(500));
    assert_eq!(parse("modbus-rtu:/dev/ttyUSB0?baud=300").timeout, Duration::from_millis(500 + 9_387));
    let every_default = "modbus-tcp://gateway:502?unit=1&out=holding:0&in=input:0&order=high-first\
                         &layout=plain&timeout_ms=500&settle_ms=20";
    assert_eq!(parse(every_default), Address::tcp("gateway", 502));
}

#[test]
fn every_option_says_what_it_does() {
    let address = parse(
        "modbus-tcp://10.0.0.7:1502?settle_ms=5&timeout_ms=250&order=low-first&in=holding:1000&out=holding:200&unit=255",
    );
    assert_eq!(
        address,
        Address {
            unit: 255,
            layout: Layout::Plain { out: 200, input: RegisterPlace { table: Table::Holding, first: 1000 } },
            order_in: WordOrder::LowFirst,
            order_out: WordOrder::LowFirst,
            timeout: Duration::from_millis(250),
            settle: Duration::from_millis(5),
            ..Address::tcp("10.0.0.7", 1502)
        }
    );
    let serial = parse("modbus-rtu:COM3?baud=9600&parity=none&stop=2&data=8&unit=7");
    assert_eq!(
        serial.way,
        Way::Rtu { device: "COM3".to_owned(), baud: 9_600, parity: Parity::None, stop: StopBits::Two }
    );
    assert_eq!(serial.unit, 7);
    let inline = parse("modbus-tcp://coupler?layout=inline");
    assert_eq!(inline.layout, Layout::Inline { data: RegisterPlace { table: Table::Holding, first: 8000 } });
    let inline = parse("modbus-tcp://coupler?in=input:8000&layout=inline");
    assert_eq!(inline.layout, Layout::Inline { data: RegisterPlace { table: Table::Input, first: 8000 } });
}

#[test]
fn an_ipv6_host_stands_in_brackets() {
    assert_eq!(parse("modbus-tcp://[::1]:1502"), Address::tcp("::1", 1502));
    assert_eq!(parse("modbus-tcp://[0:0::1]"), Address::tcp("::1", 502));
    assert_eq!(parse("modbus-tcp://[::1]").to_string(), "modbus-tcp://[::1]:502");
    for text in ["modbus-tcp://::1", "modbus-tcp://[::1", "modbus-tcp://[::1]502", "modbus-tcp://[x]:502"] {
        text.parse::<Address>().unwrap_err();
    }
}

#[test]
fn an_address_is_printed_without_its_defaults() {
    for text in [
        "modbus-tcp://gateway:502",
        "modbus-tcp://[fe80::1]:1502?unit=0&order=low-first",
        "modbus-tcp://gateway:502?unit=3&out=holding:0&in=holding:1000&timeout_ms=50&settle_ms=0",
        "modbus-tcp://gateway:502?layout=inline&in=input:8000",
        "modbus-tcp://gateway:502?layout=inline",
        "modbus-rtu:/dev/ttyS1?baud=19200&parity=even",
        "modbus-rtu:/dev/ttyS1?baud=115200&parity=odd&stop=2&unit=9&layout=inline&order=low-first",
        "modbus-rtu-tcp://[::1]:4001?unit=7",
        "modbus-tcp://gateway:502?order_in=low-first&order_out=high-first&max_registers=16&accept=transaction,unit",
        "modbus-tcp://gateway:502?order_in=high-first&order_out=low-first",
        "modbus-tcp://gateway:502?status=holding:900&parameter=input:901&accept=unit&timeout_ms=50&settle_ms=0",
    ] {
        assert_eq!(parse(text).to_string(), text);
    }
}

#[test]
fn what_is_wrong_is_told_with_its_place_and_what_is_allowed() {
    let told = [
        "",
        "tcp://gateway",
        "modbus-tcp://",
        "modbus-tcp://gate way",
        "modbus-tcp://gateway:",
        "modbus-tcp://gateway:65536",
        "modbus-tcp://gateway:+1",
        "modbus-tcp://gateway?",
        "modbus-tcp://gateway?unit",
        "modbus-tcp://gateway?unit=256",
        "modbus-tcp://gateway?unit=1&unit=1",
        "modbus-tcp://gateway?baud=9600",
        "modbus-tcp://gateway?out=input:0",
        "modbus-tcp://gateway?in=coils:0",
        "modbus-tcp://gateway?in=input",
        "modbus-tcp://gateway?in=input:65535",
        "modbus-tcp://gateway?order=big",
        "modbus-tcp://gateway?layout=inline&out=holding:0",
        "modbus-tcp://gateway?timeout_ms=9",
        "modbus-tcp://gateway?settle_ms=1.5",
        "modbus-tcp://gateway?in=30001",
        "modbus-tcp://gateway?out=40013",
        "modbus-tcp://gateway?status=400901",
        "modbus-tcp://gateway?max_registers=1",
        "modbus-tcp://gateway?accept=function",
        "modbus-tcp://gateway?accept=unit,unit",
        "modbus-rtu-tcp://gateway?baud=9600",
        "modbus-rtu-tcp://gateway?unit=0",
        "modbus-rtu:",
        "modbus-rtu:/dev/ttyS0?unit=0",
        "modbus-rtu:/dev/ttyS0?parity=mark",
        "modbus-rtu:/dev/ttyS0?stop=3",
        "modbus-rtu:/dev/ttyS0?data=7",
        "modbus-rtu:/dev/ttyS0?baud=0",
        "modbus-rtu:/dev/tty\u{e4}\u{f6}?baud=9600&speed=1",
    ]
    .map(|text| format!("{text}\n    {}\n", refused(text)))
    .concat();
    insta::assert_snapshot!(told);
}

#[test]
fn the_documentation_lists_every_option() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/bus.md");
    let page = std::fs::read_to_string(page).unwrap();
    for key in COMMON.into_iter().chain(SERIAL) {
        assert!(page.contains(&format!("| `{key}` |")), "docs/bus.md must list {key}");
    }
}

fn any_place() -> impl Strategy<Value = RegisterPlace> {
    (prop_oneof![Just(Table::Holding), Just(Table::Input)], 0..u16::MAX)
        .prop_map(|(table, first)| RegisterPlace { table, first })
}

fn any_way() -> impl Strategy<Value = Way> {
    let tcp = ("[a-zA-Z0-9._-]{1,20}", 1..=u16::MAX).prop_map(|(host, port)| Way::Tcp { host, port });
    let six = (any::<u128>(), 1..=u16::MAX)
        .prop_map(|(bits, port)| Way::Tcp { host: Ipv6Addr::from_bits(bits).to_string(), port });
    let parity = prop_oneof![Just(Parity::None), Just(Parity::Even), Just(Parity::Odd)];
    let stop = prop_oneof![Just(StopBits::One), Just(StopBits::Two)];
    let rtu = ("[^?\\p{Cc}]{1,20}", BAUD, parity, stop).prop_map(|(device, baud, parity, stop)| Way::Rtu {
        device,
        baud,
        parity,
        stop,
    });
    let through = ("[a-zA-Z0-9._-]{1,20}", 1..=u16::MAX).prop_map(|(host, port)| Way::RtuTcp { host, port });
    prop_oneof![tcp, six, rtu, through]
}

fn any_address() -> impl Strategy<Value = Address> {
    let plain = (0..u16::MAX, any_place()).prop_map(|(out, input)| Layout::Plain { out, input });
    let layout = prop_oneof![plain, any_place().prop_map(|data| Layout::Inline { data })];
    let order = prop_oneof![Just(WordOrder::HighFirst), Just(WordOrder::LowFirst)];
    let accept = any::<(bool, bool)>().prop_map(|(transaction, unit)| Accept { transaction, unit });
    let place = || prop::option::of(any_place());
    let diagnosis = (place(), place()).prop_map(|(status, parameter)| DiagnosisPlaces { status, parameter });
    let orders = (order.clone(), order);
    let times = (TIMEOUT_MS, SETTLE_MS);
    (any_way(), 1..=247_u8, layout, orders, REGISTERS, accept, diagnosis, times).prop_map(
        |(way, unit, layout, (order_in, order_out), registers, accept, diagnosis, (timeout, settle))| {
            Address {
                way,
                unit,
                layout,
                order_in,
                order_out,
                max_registers: registers.try_into().unwrap(),
                accept,
                diagnosis,
                timeout: Duration::from_millis(timeout.into()),
                settle: Duration::from_millis(settle.into()),
            }
        },
    )
}

proptest! {
    #[test]
    fn an_address_that_is_printed_is_read_again(address in any_address()) {
        prop_assert_eq!(address.to_string().parse(), Ok(address));
    }

    #[test]
    fn any_text_is_an_address_or_refused(text in "(modbus-tcp://|modbus-rtu:|modbus-rtu-tcp://|)\\PC{0,40}") {
        if let Ok(address) = text.parse::<Address>() {
            prop_assert_eq!(address.to_string().parse(), Ok(address));
        }
    }

    #[test]
    fn any_options_are_read_or_refused(
        text in "[a-z]{1,3}(\\?|\\?(unit|in|out|order|order_in|status|accept|layout|baud|x)=?(holding|input|inline|1|)?[:=&]?[0-9]{0,6}&?){0,3}",
    ) {
        for way in [TCP, RTU, RTU_TCP] {
            if let Ok(address) = format!("{way}{text}").parse::<Address>() {
                prop_assert_eq!(address.to_string().parse(), Ok(address));
            }
        }
    }
}
