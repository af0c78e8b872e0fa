//! Looks at a ring behind a Modbus gateway: `bus ADDRESS` prints OUT and IN of the encoders from position 0 on,
//! `bus ADDRESS probe` looks for them, `bus ADDRESS write POSITION WORD` writes an OUT word (in hex).
//!
//! `bus ADDRESS try TIMES` writes another OUT word to position 0 each time, without a service bit, and reads it back.
//! It prints how often that worked and how often it was an error, and fails if ever another word came back.

use std::ops::ControlFlow;

use encoring_bus::{Bus, BusError};
use encoring_modbus::{Client, ModbusError, probe};
use encoring_words::{InWord, OutWord};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let address = words.first().ok_or("which bus address?")?;
    let mut client = Client::new(address.parse()?)?;
    match words.get(1..).unwrap_or_default() {
        ["probe"] => {
            let found = probe::probe(&mut client, probe::Reach::default(), |_| ControlFlow::Continue(()))?;
            println!("{} ({} requests)", found.verdict(), found.requests);
            for candidate in found.candidates {
                println!("{}: {} ({} encoders)", candidate.certainty, candidate.address, candidate.encoders);
                for evidence in candidate.evidence {
                    println!("  {evidence}");
                }
            }
        }
        ["write", position, word] => {
            let word = OutWord(u32::from_str_radix(word, 16)?);
            client.cycle(Some((position.parse()?, word)), 0, &mut [])?;
        }
        ["try", times] => {
            let (mut answered, mut errors) = (0, 0);
            // What may stand there: the last word that was acknowledged, and those sent since.
            // Its gateway may lose the first answers too.
            let first = (0..10).find_map(|_| client.out(0).ok());
            let mut sent = vec![first.ok_or("no answer in ten tries")?];
            for number in 1..=times.parse()? {
                sent.push(OutWord(number));
                match client.cycle(Some((0, OutWord(number))), 0, &mut []) {
                    Ok(_) => sent = vec![OutWord(number)],
                    Err(_) => errors += 1,
                }
                match client.out(0) {
                    Ok(word) if sent.contains(&word) => answered += 1,
                    Ok(word) => return Err(format!("{:08X} instead of one of {sent:08X?}", word.0).into()),
                    Err(_) => errors += 1,
                }
            }
            println!("{answered} answered, {errors} errors");
        }
        [] => {
            for position in 0.. {
                let mut input = [InWord(0)];
                let result = client.cycle(None, position, &mut input);
                let [word] = input;
                match result {
                    Ok(_) => println!("{position}: OUT {:08X} IN {:08X}", client.out(position)?.0, word.0),
                    Err(error) if error.is_no_encoder() => break,
                    // Behind the last encoder there are no registers.
                    Err(BusError::Client(client))
                        if matches!(
                            client.error().downcast_ref(),
                            Some(ModbusError::Refused { exception: 2, .. })
                        ) =>
                    {
                        break;
                    }
                    Err(error @ BusError::NotAnEncoder { .. }) => println!("{position}: {error}"),
                    Err(error) => return Err(error.into()),
                }
            }
        }
        _ => return Err("ADDRESS [probe | write POSITION WORD | try TIMES]".into()),
    }
    Ok(())
}
