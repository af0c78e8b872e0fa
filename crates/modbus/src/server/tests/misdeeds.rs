//! Each fault of a gateway, seen from both sides: what a master gets and when, and what then stands in the image.

use super::*;

const READ_IN: &[u8] = &[4, 0, 0, 0, 2];
const IN: &[u8] = &[4, 4, 0x80, 0x00, 0x80, 0x01];
/// A service, and the word that ends it.
const SERVICE: &[u8] = &[16, 0, 0, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F];
const REST: &[u8] = &[16, 0, 0, 0, 2, 4, 0x42, 0x00, 0x27, 0x0F];
const WRITTEN: &[u8] = &[16, 0, 0, 0, 2];

/// What a master sees of one request.
#[derive(Debug, PartialEq, Eq)]
enum Sees {
    /// Transaction number, unit and PDU, so many milliseconds after the request.
    Answer(u16, u8, Vec<u8>, u128),
    /// Nothing within a minute.
    Nothing,
    /// The end of the connection, behind an answer too.
    End,
}

/// A request, and what a master sees of it.
type Exchange<'a> = (&'a [u8], Sees);

fn answer(pdu: &[u8]) -> Sees {
    Sees::Answer(0x1234, 1, pdu.to_vec(), 0)
}

/// A gateway with faults, in virtual time.
struct Faulty {
    image: SharedImage,
    faults: GatewayFaults,
    client: DuplexStream,
}

impl Faulty {
    fn new(faults: &[&str]) -> Self {
        let gateway = GatewayFaults::default();
        faults.iter().for_each(|fault| gateway.add(fault.parse().unwrap()).unwrap());
        let mut faulty =
            Self { image: SharedImage::new(image(ENCODERS)), faults: gateway, client: duplex(1).0 };
        faulty.connect();
        faulty
    }

    fn connect(&mut self) {
        let (client, stream) = duplex(1024);
        self.client = client;
        let (image, faults) = (self.image.clone(), self.faults.clone());
        tokio::spawn(async move {
            let options = Options { idle: Duration::from_secs(3_600), ..Options::default() };
            converse(stream, &image, options, &ServerCounts::default(), &faults, 1).await;
        });
    }

    async fn ask(&mut self, pdu: &[u8]) -> Sees {
        let asked = Instant::now();
        self.client.write_all(&framed(0x1234, 1, pdu)).await.unwrap();
        match timeout(Duration::from_secs(60), next_answer(&mut self.client)).await {
            Err(_) => Sees::Nothing,
            Ok(None) => Sees::End,
            Ok(Some(got)) => {
                let transaction = u16::from_be_bytes([got[0], got[1]]);
                Sees::Answer(transaction, got[6], got[7..].to_vec(), asked.elapsed().as_millis())
            }
        }
    }

    fn out(&self) -> u32 {
        self.image.with(|image| image.out()[0].0)
    }
}

#[tokio::test(start_paused = true)]
async fn a_master_gets_what_such_a_gateway_sends() {
    let before = 0x4000_4001;
    let table: &[(&str, &[Exchange<'_>], u32)] = &[
        ("silent", &[(READ_IN, Sees::Nothing), (SERVICE, Sees::Nothing)], before),
        ("late=2500", &[(READ_IN, Sees::Answer(0x1234, 1, IN.to_vec(), 2_500))], before),
        (
            // It is carried out at once.
            "late=2500#2",
            &[
                (READ_IN, answer(IN)),
                (SERVICE, Sees::Answer(0x1234, 1, WRITTEN.to_vec(), 2_500)),
                (READ_IN, answer(IN)),
            ],
            0xC200_270F,
        ),
        ("busy", &[(READ_IN, answer(&[0x84, 6])), (SERVICE, answer(&[0x90, 6]))], before),
        ("exception=0B", &[(READ_IN, answer(&[0x84, 0x0B])), (SERVICE, answer(&[0x90, 0x0B]))], before),
        ("drop", &[(READ_IN, Sees::Nothing), (SERVICE, Sees::Nothing)], 0xC200_270F),
        ("dead", &[(READ_IN, answer(IN)), (REST, answer(WRITTEN)), (SERVICE, Sees::End)], 0xC200_270F),
        ("close", &[(READ_IN, answer(IN))], before),
        ("split", &[(READ_IN, Sees::Answer(0x1234, 1, IN.to_vec(), 5))], before),
        (
            // A register that is left over stays.
            "swapped",
            &[
                (READ_IN, answer(&[4, 4, 0x80, 0x01, 0x80, 0x00])),
                (&[4, 0, 0, 0, 3], answer(&[4, 6, 0x80, 0x01, 0x80, 0x00, 0x80, 0x02])),
                (SERVICE, answer(WRITTEN)),
                (&[3, 0, 0, 0, 2], answer(&[3, 4, 0xC2, 0x00, 0x27, 0x0F])),
            ],
            0x270F_C200,
        ),
        ("unit=0", &[(READ_IN, Sees::Answer(0x1234, 0, IN.to_vec(), 0))], before),
        ("transaction", &[(READ_IN, Sees::Answer(0x1235, 1, IN.to_vec(), 0))], before),
        (
            "max=4",
            &[
                (&[4, 0, 0, 0, 4], answer(&[4, 8, 0x80, 0x00, 0x80, 0x01, 0x80, 0x02, 0x80, 0x03])),
                (&[4, 0, 0, 0, 5], answer(&[0x84, 3])),
                (&[3, 0, 0, 0, 5], answer(&[0x83, 3])),
                (SERVICE, answer(WRITTEN)),
            ],
            0xC200_270F,
        ),
    ];
    for (fault, conversation, out) in table {
        let mut gateway = Faulty::new(&[fault]);
        for (request, sees) in *conversation {
            assert_eq!(gateway.ask(request).await, *sees, "{fault}: {request:02X?}");
        }
        assert_eq!(gateway.out(), *out, "{fault}: {:08X}", gateway.out());
        let closes = matches!(*fault, "close" | "dead");
        let ended = timeout(Duration::from_millis(1), gateway.client.read_u8()).await;
        assert_eq!(matches!(ended, Ok(Err(_))), closes, "{fault}");
    }
}

#[tokio::test(start_paused = true)]
async fn one_byte_of_a_garbled_answer_is_another_and_its_header_is_sound() {
    let mut gateway = Faulty::new(&["garbled"]);
    let mut changed = [false; 6];
    for _ in 0..6 {
        let Sees::Answer(0x1234, 1, got, 0) = gateway.ask(READ_IN).await else { panic!("no answer") };
        let others: Vec<_> = (0..IN.len()).filter(|index| got[*index] != IN[*index]).collect();
        assert_eq!((got.len(), others.len()), (IN.len(), 1), "{got:02X?}");
        changed[others[0]] = true;
    }
    assert_eq!(changed, [true; 6], "each byte in its turn");
}

#[tokio::test(start_paused = true)]
async fn requests_are_counted_over_all_connections_and_faults_have_their_time() {
    let mut gateway = Faulty::new(&["late=100#3", "close", "busy@10s+5s"]);
    for late in [0, 0, 100, 0] {
        assert_eq!(gateway.ask(READ_IN).await, Sees::Answer(0x1234, 1, IN.to_vec(), late));
        gateway.connect();
    }
    for (at, sees) in [(9_000, answer(IN)), (2_000, answer(&[0x84, 6])), (5_000, answer(IN))] {
        sleep(Duration::from_millis(at)).await;
        gateway.connect();
        assert_eq!(gateway.ask(READ_IN).await, sees, "{at}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_gateway_dies_of_a_service_bit_wherever_that_stands() {
    for (request, service) in [
        (SERVICE, true),
        (REST, false),
        // The same bit for the last encoder, behind other words; and by functions 23 and 6.
        (&[16, 0, 0, 0, 6, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0xC2, 0, 0, 0][..], true),
        (&[23, 0, 0, 0, 2, 0, 0, 0, 2, 4, 0xC2, 0, 0, 0], true),
        (&[6, 0, 2, 0xC2, 0], true),
        (&[6, 0, 3, 0xC2, 0], false),
        // Refused, so nothing is set.
        (&[16, 0, 4, 0, 4, 8, 0xC2, 0, 0, 0, 0xC2, 0, 0, 0], false),
    ] {
        let mut gateway = Faulty::new(&["dead+2s"]);
        let seen = gateway.ask(request).await;
        assert_eq!(seen == Sees::End, service, "{request:02X?}: {seen:?}");
        assert_eq!(gateway.faults.is_dead(), service, "{request:02X?}");
        sleep(Duration::from_secs(2)).await;
        gateway.connect();
        assert_eq!(gateway.ask(READ_IN).await, answer(IN), "alive again");
    }
}
