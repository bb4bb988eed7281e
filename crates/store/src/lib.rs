//! Files of numbers in blocks: mapped into memory, checked, and resumed where a build was cut off.
//!
//! A file is a preamble, records and a footer, all in multiples of 64 bytes, little-endian:
//!
//! | part | bytes | what it holds |
//! |---|---|---|
//! | preamble | 64 | magic, version, kind, fingerprint of what the numbers follow from, checksum |
//! | record 0 | | the settings as JSON, and whatever makes the file stand alone |
//! | record k | | a block: a head of 64 bytes, a table of sections, the sections |
//! | footer | 64 | the number of records, the file's length, a digest of all heads, checksum |
//!
//! A section is an array of one type that starts at a multiple of 64 bytes, so that it can be read where the file is
//! mapped. The head and the table of a record have a checksum of their own, so that the structure of a file can be
//! checked without reading its numbers; another one is of the numbers. Every byte is under one of them.
//!
//! This crate knows bytes and arrays, not what they mean. What does is [`Stored`] by it.
//!
//! # Building onto a file
//!
//! A [`Checkpoint`] is the file while it is built, under the name `F.partial` beside the file `F`: it takes block after
//! block in a fixed order. It becomes `F` when it is whole, so that nobody ever writes to a file that others may have
//! mapped. After a crash the same call opens it again, keeps the records that are whole, and says how many blocks it
//! has. [`in_order`] builds blocks on all threads and hands them over one after the other.
//!
//! # What mapping trusts
//!
//! Numbers are read where they lie in the file. If another program truncates a file that is mapped, reading on ends
//! the process (SIGBUS), as with every mapped file. This crate never does so: it replaces files by renaming, which
//! leaves the old one to those who have it open.

mod checkpoint;
mod error;
pub mod files;
mod format;
mod numbers;
mod ordered;
mod section;
mod store_file;
mod writer;

pub use checkpoint::{Checkpoint, Opened, partial_name};
pub use error::StoreError;
pub use format::{Identity, Settings, VERSION, fingerprint, role};
pub use numbers::{Element, Numbers};
pub use ordered::{Keep, in_order};
pub use section::{Section, Sections, Stored};
pub use store_file::StoreFile;
pub use writer::{Writer, save};
