//! The process image of a station as a Modbus TCP server.
