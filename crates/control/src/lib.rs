//! A simulated ring told what to do by JSON lines over TCP: one object a line in, one answer a line out, in order.
//!
//! What can be asked is [`encoring_station::verbs`]; [`server`] reads and writes the lines. Nothing here is
//! authenticated: whoever reaches the port moves the world. Nothing here opens a file either.
//!
//! ```
//! use encoring_control::{Options, serve};
//! use encoring_sim::{Scenario, World};
//! use encoring_station::{Controlled, Station};
//! use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
//! use tokio::net::{TcpListener, TcpStream};
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scenario = Scenario::built_in()?;
//! let station = Station::start(World::new(&scenario)?, encoring_station::Options::default())?;
//! let units = scenario.devices.iter().map(|device| device.unit).collect();
//! let controlled = Controlled { ring: station.handle().clone(), units, gateway: None };
//! let listener = TcpListener::bind("127.0.0.1:0").await?;
//! let address = listener.local_addr()?;
//! tokio::spawn(serve(listener, controlled, Options::default(), std::future::pending()));
//!
//! let mut peer = BufReader::new(TcpStream::connect(address).await?);
//! peer.write_all(b"{\"verb\":\"set\",\"position\":1,\"set\":{\"raw\":4096}}\n").await?;
//! let mut answer = String::new();
//! peer.read_line(&mut answer).await?;
//! assert_eq!(answer, "{\"ok\":true}\n");
//! # Ok(())
//! # }
//! ```

pub mod server;
pub mod unread;

pub use server::{Options, serve};
