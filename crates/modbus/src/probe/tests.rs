use super::*;

use std::collections::BTreeMap;

/// A gateway whose encoders turn a little at each request.
struct Gateway {
    input: BTreeMap<u16, Cell>,
    holding: BTreeMap<u16, Cell>,
    time: u32,
    silent_from: u32,
    /// Each answer of this number is lost.
    lost: u32,
    /// Exceptions for a register that is not there, and for a table that is not.
    missing: u8,
    no_table: Option<Table>,
}

#[derive(Clone, Copy)]
enum Cell {
    Is(u16),
    /// The upper or lower half of an encoder: where it begins, steps a request, and all bits above.
    Half(u32, u32, u32, bool),
}

impl Source for Gateway {
    fn registers(&mut self, place: RegisterPlace, count: u16) -> Result<Vec<u16>, ModbusError> {
        self.time += 1;
        let refused = |exception| {
            Err(ModbusError::Refused { function: function(place.table), register: place.first, exception })
        };
        if self.time > self.silent_from || self.time.is_multiple_of(self.lost) {
            return Err(BusError::NoAnswer { within: Duration::from_secs(1) }.into());
        }
        if self.no_table == Some(place.table) {
            return refused(1);
        }
        assert!((1..=READ_MAX).contains(&count));
        let cells = self.table(place.table);
        let registers = (u32::from(place.first)..).take(usize::from(count));
        let cells: Option<Vec<Cell>> =
            registers.map(|register| cells.get(&u16::try_from(register).ok()?).copied()).collect();
        let Some(cells) = cells else { return refused(self.missing) };
        Ok(cells.into_iter().map(|cell| self.value(cell)).collect())
    }

    fn pause(&mut self, _: Duration) {
        self.time += 5;
    }
}

impl Gateway {
    fn new() -> Self {
        let (input, holding) = (BTreeMap::new(), BTreeMap::new());
        Self { input, holding, time: 0, silent_from: u32::MAX, lost: u32::MAX, missing: 2, no_table: None }
    }

    fn table(&mut self, table: Table) -> &mut BTreeMap<u16, Cell> {
        match table {
            Table::Holding => &mut self.holding,
            Table::Input => &mut self.input,
        }
    }

    fn value(&self, cell: Cell) -> u16 {
        match cell {
            Cell::Is(value) => value,
            Cell::Half(from, speed, above, upper) => {
                let word = above | (from + speed * self.time) & 0x00FF_FFFF;
                if upper { (word >> 16) as u16 } else { word as u16 }
            }
        }
    }

    fn with(mut self, table: Table, first: u16, cells: impl IntoIterator<Item = Cell>) -> Self {
        let registers = (u32::from(first)..).map(|register| register as u16);
        self.table(table).extend(registers.zip(cells));
        self
    }

    fn search(&mut self) -> Findings {
        let address = Address::tcp("gateway", 502);
        search(self, &address, Reach::default(), |_| ControlFlow::Continue(())).unwrap()
    }
}

/// Three encoders, of which the middle one stands still.
fn encoders(order: WordOrder) -> Vec<Cell> {
    [(0x00_1F00, 3, 0), (0x12_3456, 0, 0x2000_0000), (0xFF_FF00, 9, 0)]
        .into_iter()
        .flat_map(|(from, speed, above)| {
            let half = |upper| Cell::Half(from, speed, above, upper);
            match order {
                WordOrder::HighFirst => [half(true), half(false)],
                WordOrder::LowFirst => [half(false), half(true)],
            }
        })
        .collect()
}

fn zeros(count: usize) -> Vec<Cell> {
    vec![Cell::Is(0); count]
}

/// A report as a person would read it.
fn told(report: &Findings) -> String {
    let mut text = format!("{}; {} requests\n", report.verdict(), report.requests);
    for candidate in &report.candidates {
        text += &format!("{}: {} ({})\n", candidate.certainty, candidate.address, candidate.encoders);
        for evidence in &candidate.evidence {
            text += &format!("  {evidence}\n");
        }
    }
    text
}

fn both(mut check: impl FnMut(WordOrder, &str)) {
    check(WordOrder::HighFirst, "");
    check(WordOrder::LowFirst, "order=low-first");
}

fn best(report: &Findings) -> (Certainty, String, usize) {
    let candidate = &report.candidates[0];
    (candidate.certainty, candidate.address.to_string(), candidate.encoders)
}

#[test]
fn our_own_map_is_found_in_either_order() {
    both(|order, option| {
        let mut gateway = Gateway::new()
            .with(Table::Input, 0, encoders(order))
            .with(Table::Holding, 0, zeros(6))
            .with(Table::Holding, 1000, encoders(order));
        for table in [Table::Input, Table::Holding] {
            // A count that moves as a position does.
            let faults = [Cell::Half(3, 1, 0, false), Cell::Is(0), Cell::Is(7), Cell::Is(0)];
            gateway = gateway.with(table, 900, [Cell::Is(0x40E0), Cell::Is(0)].into_iter().chain(faults));
        }
        let report = gateway.search();
        let text = told(&report);
        let options = if option.is_empty() { String::new() } else { format!("?{option}") };
        assert_eq!(
            best(&report),
            (Certainty::Certain, format!("modbus-tcp://gateway:502{options}"), 3),
            "{text}"
        );
        let mirror = &report.candidates[1];
        assert_eq!(mirror.certainty, Certainty::Certain, "{text}");
        assert!(
            mirror.evidence.contains(&Evidence::SameAs(RegisterPlace { table: Table::Input, first: 0 })),
            "{text}"
        );
        assert!(mirror.evidence.contains(&Evidence::OutGuessed(0)), "{text}");
        assert_eq!(report.candidates.len(), 2, "{text}");
        assert_eq!(report.end, End::Whole);
    });
}

#[test]
fn encoders_where_our_own_server_has_its_diagnosis_are_found() {
    both(|order, option| {
        let report = Gateway::new().with(Table::Input, 900, encoders(order)).search();
        let option = if option.is_empty() { String::new() } else { format!("&{option}") };
        let (certainty, address, encoders) = best(&report);
        assert_eq!((certainty, encoders), (Certainty::Certain, 3));
        assert_eq!(address, format!("modbus-tcp://gateway:502?out=holding:0&in=input:900{option}"));
    });
}

#[test]
fn what_is_told_reads_like_this() {
    let mut gateway = Gateway::new().with(Table::Holding, 0, zeros(6)).with(
        Table::Holding,
        1000,
        encoders(WordOrder::LowFirst),
    );
    gateway.no_table = Some(Table::Input);
    insta::assert_snapshot!(told(&gateway.search()), @r"
    one place stands out; 143 requests
    certain: modbus-tcp://gateway:502?out=holding:0&in=holding:1000&order=low-first (3)
      2 moving as positions do, upper byte 00h or 20h
      no other registers around them
      in the other word order 1F750000h, which no encoder sends so
      OUT words believed to be at holding:0, nothing was written; their word order cannot be read, it is taken to be the same (order_out)
    ");
}

#[test]
fn a_block_that_begins_between_two_steps_is_followed_back() {
    both(|order, _| {
        let mut gateway =
            Gateway::new().with(Table::Input, 937, encoders(order)).with(Table::Input, 943, zeros(100));
        let report = gateway.search();
        let candidate = &report.candidates[0];
        let Layout::Plain { input, .. } = candidate.address.layout else { panic!() };
        assert_eq!((input.first, candidate.encoders), (937, 3), "{}", told(&report));
        assert_eq!(candidate.address.order_in, order);
        assert_eq!(candidate.certainty, Certainty::Likely);
    });
}

#[test]
fn a_gateway_on_which_every_register_exists_is_searched_within_its_limits() {
    both(|order, _| {
        let mut gateway = Gateway::new()
            .with(Table::Input, 0, zeros(0x1_0000))
            .with(Table::Holding, 0, zeros(0x1_0000))
            .with(Table::Holding, 2048, encoders(order));
        let report = gateway.search();
        assert_eq!(report.end, End::Whole);
        assert!(report.requests < 1_500, "{}", report.requests);
        let candidate = &report.candidates[0];
        // The first word's upper half is 0, so that it might begin one register later.
        let Layout::Plain { input, .. } = candidate.address.layout else { panic!() };
        assert_eq!((input.table, candidate.certainty), (Table::Holding, Certainty::Likely));
        assert_eq!((input.first, candidate.address.order_in), (2048, order), "{}", told(&report));
    });
}

#[test]
fn encoders_at_rest_are_possible_at_most() {
    both(|order, _| {
        let cells = [0x0000_1234, 0x0000_0007].map(|word| order.registers(word).map(Cell::Is)).concat();
        let report = Gateway::new().with(Table::Input, 0, cells).search();
        let text = told(&report);
        assert!(report.candidates.iter().all(|c| c.certainty == Certainty::Possible), "{text}");
        assert_eq!(report.candidates[0].address.order_in, order, "{text}");
        assert!(text.starts_with("nothing moved"), "{text}");
    });
}

#[test]
fn zeros_are_nothing() {
    let report = Gateway::new().with(Table::Input, 0, zeros(6)).with(Table::Holding, 0, zeros(6)).search();
    assert_eq!(report.candidates, []);
    assert_eq!(report.blocks.len(), 2);
    assert!(told(&report).starts_with("there are registers, but nothing"), "{}", told(&report));
    let report = Gateway::new().search();
    assert_eq!(report.verdict(), "no registers were found");
}

#[test]
fn a_small_number_that_moves_in_one_register_tells_the_order() {
    both(|order, _| {
        let half = |upper| Cell::Half(5, 1, 0, upper);
        let cells = match order {
            WordOrder::HighFirst => [half(true), half(false)],
            WordOrder::LowFirst => [half(false), half(true)],
        };
        let report = Gateway::new().with(Table::Input, 0, cells).search();
        let candidate = &report.candidates[0];
        assert_eq!(
            (candidate.certainty, candidate.address.order_in),
            (Certainty::Certain, order),
            "{}",
            told(&report)
        );
        assert_eq!(report.candidates.len(), 1);
    });
}

#[test]
fn an_encoder_in_a_service_counts_as_one() {
    let order = WordOrder::HighFirst;
    let mut cells = encoders(order);
    cells.extend(order.registers(0xC200_270F).map(Cell::Is));
    cells.extend(order.registers(0xA700_0000).map(Cell::Is));
    let report = Gateway::new().with(Table::Input, 0, cells).search();
    let candidate = &report.candidates[0];
    assert_eq!((candidate.certainty, candidate.encoders), (Certainty::Certain, 5), "{}", told(&report));
    assert!(candidate.evidence.contains(&Evidence::Replies { words: 2 }));
}

#[test]
fn registers_of_something_else_are_left_alone() {
    let text = b"ACME power meter, firmware 7.3";
    let cells = text.as_chunks().0.iter().map(|two| Cell::Is(u16::from_be_bytes(*two)));
    let report = Gateway::new().with(Table::Input, 0, cells).search();
    assert_eq!(report.candidates, [], "{}", told(&report));
}

#[test]
fn an_inline_coupler_is_known_by_its_directory() {
    both(|order, option| {
        // Digital out, encoder, digital in, encoder, encoder; the IN data of 7 words, then as many OUT data.
        let modules = [5, 0x0101, 0x0233, 0x0102, 0x0233, 0x0233].map(Cell::Is);
        let mut data = encoders(order);
        data.insert(2, Cell::Is(0xFFFF));
        let mut gateway = Gateway::new()
            .with(Table::Holding, 1400, modules)
            .with(Table::Holding, 8000, data)
            .with(Table::Holding, 8007, zeros(7));
        let report = gateway.search();
        let and = if option.is_empty() { String::new() } else { format!("&{option}") };
        let address = format!("modbus-tcp://gateway:502?layout=inline{and}");
        assert_eq!(best(&report), (Certainty::Certain, address, 3), "{}", told(&report));
        assert_eq!(report.candidates.len(), 1, "{}", told(&report));
    });
}

#[test]
fn a_time_out_ends_the_search_and_is_told() {
    let mut gateway = Gateway::new().with(Table::Input, 0, encoders(WordOrder::HighFirst));
    gateway.silent_from = 12;
    let address = Address::tcp("gateway", 502);
    let error = search(&mut gateway, &address, Reach::default(), |_| ControlFlow::Continue(())).unwrap_err();
    assert_eq!(error.error, BusError::NoAnswer { within: Duration::from_secs(1) }.into());
    assert_eq!(
        error.to_string(),
        "no answer within 1 s; that was request 15, for 1 register from input:256 on"
    );
}

#[test]
fn one_lost_answer_does_not_end_the_search() {
    let mut gateway = Gateway::new().with(Table::Input, 0, encoders(WordOrder::HighFirst));
    gateway.lost = 10;
    assert_eq!(best(&gateway.search()).0, Certainty::Certain);
}

#[test]
fn it_ends_when_it_is_told_to_or_has_used_up_its_requests() {
    let address = Address::tcp("gateway", 502);
    let gateway = || {
        Gateway::new().with(Table::Input, 0, encoders(WordOrder::HighFirst)).with(Table::Holding, 0, zeros(6))
    };
    let whole = gateway().search().requests;
    for stop in 0..whole {
        let progress = |progress: Progress| match progress.requests < stop {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        };
        let report = search(&mut gateway(), &address, Reach::default(), progress).unwrap();
        assert_eq!((report.end, report.requests), (End::Stopped, stop));
        let limits = Reach { requests: stop, ..Reach::default() };
        let report = search(&mut gateway(), &address, limits, |_| ControlFlow::Continue(())).unwrap();
        assert_eq!((report.end, report.requests), (End::Limit, stop));
    }
}

#[test]
fn other_exceptions_for_registers_that_are_not_there_are_understood() {
    for missing in [2, 3, 4] {
        let mut gateway = Gateway::new().with(Table::Input, 0, encoders(WordOrder::HighFirst));
        gateway.missing = missing;
        assert_eq!(best(&gateway.search()).0, Certainty::Certain);
    }
    let mut gateway = Gateway::new();
    gateway.missing = 0x0B;
    let address = Address::tcp("gateway", 502);
    let error = search(&mut gateway, &address, Reach::default(), |_| ControlFlow::Continue(())).unwrap_err();
    assert!(matches!(error.error, ModbusError::Refused { exception: 0x0B, .. }));
}
