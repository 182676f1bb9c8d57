//! Drives the real binary, and tests its files, texts and exit codes.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod apply;
mod backs;
mod bad_input;
mod bad_manifest;
mod batch;
mod bundle;
mod check;
mod commands;
mod folder;
mod formats;
mod heights;
mod help;
mod limits;
mod materials;
mod mesh;
mod methods;
mod noise;
mod noise_bench;
mod outputs;
mod page;
mod pages;
mod quality;
mod reference;
mod report;
mod shading;
mod streams;
mod trust;
#[cfg(unix)]
mod unix;
mod unwrap;
