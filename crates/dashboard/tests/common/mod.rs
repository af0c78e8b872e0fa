//! A page that is asked over a real socket.
#![allow(dead_code, unreachable_pub, reason = "each test file uses a part")]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::ops::Deref;
use std::sync::Arc;

use encoring_dashboard::{ServedPage, WebOptions, start};
use encoring_sim::{Scenario, World};
use encoring_station::{Controlled, Options, Permission, RefereeMode, Speed, Station};
use serde_json::Value;

/// What a page of a simulation on this machine may do.
pub fn free() -> WebOptions {
    WebOptions { permission: Permission::Change, ..WebOptions::default() }
}

/// A page of the built-in ring.
pub struct Page {
    pub controlled: Controlled,
    pub asked: Asked,
    pub served: ServedPage,
    _station: Station,
}

/// Where a page is asked.
pub struct Asked {
    pub address: SocketAddr,
}

impl Deref for Page {
    type Target = Asked;

    fn deref(&self) -> &Asked {
        &self.asked
    }
}

/// An answer, taken apart.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: String,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap()
    }
}

impl Page {
    /// It may do everything, and asks nobody for a token.
    pub fn start() -> Self {
        Self::with(&free())
    }

    pub fn with(options: &WebOptions) -> Self {
        let scenario = Scenario::built_in().unwrap();
        let units = scenario.devices.iter().map(|device| device.unit).collect();
        let speed = Options { speed: Speed::Max, referee: RefereeMode::On, ..Options::default() };
        let station = Station::start(World::new(&scenario).unwrap(), speed).unwrap();
        let controlled = Controlled { ring: station.handle().clone(), units, gateway: None };
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let served = start(listener, Arc::new(controlled.clone()), options).unwrap();
        Self { controlled, asked: Asked { address }, served, _station: station }
    }
}

impl Asked {
    /// Sends these bytes and reads until the other side closes.
    pub fn raw(&self, bytes: &[u8]) -> String {
        let mut stream = TcpStream::connect(self.address).unwrap();
        // A server that has said its last word takes no more.
        let _ = stream.write_all(bytes);
        let mut answer = Vec::new();
        // Closed over unread bytes it is reset; what came before counts.
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8(answer).unwrap()
    }

    pub fn send(&self, line: &str, headers: &str, body: &str) -> Answer {
        let text = self.raw(
            format!(
                "{line} HTTP/1.1\r\n{headers}Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
                body.len()
            )
            .as_bytes(),
        );
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no head in {text:?}"));
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Answer { status, head: head.to_ascii_lowercase(), body: body.to_owned() }
    }

    pub fn get(&self, path: &str) -> Answer {
        self.send(&format!("GET {path}"), &format!("Host: {}\r\n", self.address), "")
    }

    pub fn command(&self, verb: &Value) -> Answer {
        let headers = format!(
            "Host: {0}\r\nOrigin: http://{0}\r\nSec-Fetch-Site: same-origin\r\nContent-Type: application/json\r\n",
            self.address
        );
        self.send("POST /api/command", &headers, &verb.to_string())
    }
}

pub fn description() -> Value {
    serde_json::from_str(include_str!("../../assets/openapi.json")).unwrap()
}

/// Fails where a value is not as it is described, or where it lacks something that is.
pub fn described(value: &Value, schema: &Value, whole: &Value, place: &str) {
    if let Some(name) = schema["$ref"].as_str() {
        return described(value, whole.pointer(name.trim_start_matches('#')).unwrap(), whole, place);
    }
    if let Some(options) = schema["oneOf"].as_array() {
        let null = value.is_null();
        let at = |option: &Value| match option["$ref"].as_str() {
            Some(name) => whole.pointer(name.trim_start_matches('#')).unwrap().clone(),
            None => option.clone(),
        };
        let has = |name: &Value| value.get(name.as_str().unwrap()).is_some();
        let fits = |option: &&Value| {
            let option = at(option);
            (option["type"] == "null") == null && option["required"].as_array().into_iter().flatten().all(has)
        };
        return described(value, options.iter().find(fits).unwrap(), whole, place);
    }
    if schema == &Value::Object(serde_json::Map::new()) {
        return;
    }
    match schema["type"].as_str().unwrap() {
        "object" => {
            let object = value.as_object().unwrap_or_else(|| panic!("{place}: {value}"));
            let none = serde_json::Map::new();
            let properties = schema["properties"].as_object().unwrap_or(&none);
            for name in schema["required"].as_array().into_iter().flatten() {
                assert!(object.contains_key(name.as_str().unwrap()), "{place} lacks {name}");
            }
            for (key, value) in object {
                let place = format!("{place}.{key}");
                match (properties.get(key), &schema["additionalProperties"]) {
                    (Some(schema), _) => described(value, schema, whole, &place),
                    (None, Value::Bool(true)) => {}
                    (None, other @ Value::Object(_)) => described(value, other, whole, &place),
                    (None, _) => panic!("{place} is not described"),
                }
            }
        }
        "array" => {
            let list = value.as_array().unwrap_or_else(|| panic!("{place}: {value}"));
            list.iter().for_each(|value| described(value, &schema["items"], whole, place));
        }
        "integer" => assert!(value.is_i64() || value.is_u64(), "{place}: {value}"),
        "string" => assert!(value.is_string(), "{place}: {value}"),
        "boolean" => assert!(value.is_boolean(), "{place}: {value}"),
        "null" => assert!(value.is_null(), "{place}: {value}"),
        other => panic!("{place}: type {other}"),
    }
}
