use super::*;
use crate::plain::image;
use crate::registers::WordOrder;
use crate::{Counters, Options, serve};

use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use encoring_station::SharedImage;
use tokio::net::TcpListener;
use tokio::sync::oneshot;

/// Our own server on a thread of its own.
struct Server {
    address: SocketAddr,
    image: SharedImage,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    fn start(encoders: usize, options: Options) -> Self {
        let image = SharedImage::new(image(encoders));
        let (stop, stopped) = oneshot::channel::<()>();
        let (tell, told) = std::sync::mpsc::channel();
        let served = image.clone();
        let thread = thread::spawn(move || {
            let runtime = Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
                tell.send(listener.local_addr().unwrap()).unwrap();
                let stopped = async {
                    let _ = stopped.await;
                };
                serve(listener, served, options, Arc::new(Counters::default()), stopped).await;
            });
        });
        Self { address: told.recv().unwrap(), image, stop: Some(stop), thread: Some(thread) }
    }

    fn address(&self, options: &str) -> Address {
        format!("modbus-tcp://{}{options}", self.address).parse().unwrap()
    }

    fn client(&self, options: &str) -> Client {
        Client::new(self.address(options)).unwrap()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.take().unwrap().send(()).unwrap();
        self.thread.take().unwrap().join().unwrap();
    }
}

fn read(client: &mut Client, first: usize, count: usize) -> Result<Vec<u32>, BusError> {
    let mut input = vec![InWord(0); count];
    client.cycle(None, first, &mut input)?;
    Ok(input.into_iter().map(|word| word.0).collect())
}

#[test]
fn words_come_and_go_in_either_order_and_from_either_table() {
    for order in [WordOrder::HighFirst, WordOrder::LowFirst] {
        let server = Server::start(3, Options { word_order: order, ..Options::default() });
        for table in ["input:0", "holding:1000"] {
            let mut client = server.client(&format!("?order={order}&in={table}"));
            assert_eq!(read(&mut client, 0, 3).unwrap(), [0x8000_8001, 0x8002_8003, 0x8004_8005]);
            assert_eq!(read(&mut client, 1, 1).unwrap(), [0x8002_8003]);
            assert_eq!(client.out(2).unwrap(), OutWord(0x4004_4005));

            let mut input = [InWord(0)];
            client.cycle(Some((1, OutWord(0xC200_270F))), 2, &mut input).unwrap();
            assert_eq!(input, [InWord(0x8004_8005)]);
            server.image.with(|image| {
                assert_eq!(image.out(), [OutWord(0x4000_4001), OutWord(0xC200_270F), OutWord(0x4004_4005)]);
                image.out_mut()[1] = OutWord(0x4002_4003);
            });
        }
    }
}
