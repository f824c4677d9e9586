//! A terminal, at whose other end a test types.

use std::fs::File;
use std::io::{Read, Write};
use std::process::Stdio;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// A terminal for the standard input of a program.
pub struct Terminal {
    keyboard: File,
    screen: String,
}

impl Terminal {
    /// A terminal of its own, which controls no process.
    pub fn open() -> Self {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
        let keyboard = openpt(flags).expect("there are terminals to be had");
        grantpt(&keyboard).expect("it is ours");
        unlockpt(&keyboard).expect("it is ours");
        let screen = ptsname(&keyboard, Vec::new()).expect("it has a name");
        let screen = screen.into_string().expect("its name is text");
        Self { keyboard: File::from(keyboard), screen }
    }

    /// The end that the program reads from.
    pub fn input(&self) -> Stdio {
        let mut options = File::options();
        options.read(true).write(true);
        options.open(&self.screen).expect("the terminal is there").into()
    }

    /// Types a line.
    pub fn type_line(&mut self, line: &str) {
        writeln!(self.keyboard, "{line}").expect("somebody reads it");
    }
}

impl Terminal {
    /// Everything that programs have printed on it, once all of them have ended.
    pub fn printed(mut self) -> String {
        let mut printed = Vec::new();
        let mut part = [0; 4096];
        // Linux ends it by an error, once nobody holds the other end.
        while let Ok(n @ 1..) = self.keyboard.read(&mut part) {
            printed.extend_from_slice(&part[..n]);
        }
        String::from_utf8(printed).expect("words are UTF-8")
    }
}
