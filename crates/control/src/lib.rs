//! A simulated ring told what to do by JSON lines over TCP.
