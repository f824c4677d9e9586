//! A fleet on a terminal: what is seen of it, drawn at any size.

mod arena;
mod bottom;
mod help;
mod keys;
mod look;
mod order;
mod player;
mod screen;
mod table;
mod terminal;
mod top;
mod view;
mod viewer;
mod writing;

#[cfg(test)]
mod tests;

pub use look::Look;
pub use player::play;
pub use terminal::check;
pub use viewer::{Fleet, view};
