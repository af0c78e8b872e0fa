//! Looks at a ring behind a Modbus gateway: `bus ADDRESS` prints OUT and IN of the encoders from position 0 on,
//! `bus ADDRESS probe` looks for them, `bus ADDRESS write POSITION WORD` writes an OUT word (in hex).

use std::ops::ControlFlow;

use encoring_modbus::{Client, probe};
use encoring_station::{Bus, BusError};
use encoring_words::{InWord, OutWord};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let address = words.first().ok_or("which bus address?")?;
    let mut client = Client::new(address.parse()?)?;
    match words.get(1..).unwrap_or_default() {
        ["probe"] => {
            let found = probe::probe(&mut client, probe::Limits::default(), |_| ControlFlow::Continue(()))?;
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
        [] => {
            for position in 0.. {
                let mut input = [InWord(0)];
                match client.cycle(None, position, &mut input) {
                    Ok(_) => {
                        println!("{position}: OUT {:08X} IN {:08X}", client.out(position)?.0, input[0].0)
                    }
                    Err(BusError::Refused { exception: 2, .. } | BusError::NoEncoder { .. }) => break,
                    Err(error @ BusError::NotAnEncoder { .. }) => println!("{position}: {error}"),
                    Err(error) => return Err(error.into()),
                }
            }
        }
        _ => return Err("ADDRESS [probe | write POSITION WORD]".into()),
    }
    Ok(())
}
